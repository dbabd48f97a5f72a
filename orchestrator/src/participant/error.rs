use crate::transport::TransportError;

/// What went wrong in a participant.
#[derive(Debug, thiserror::Error)]
pub enum ParticipantError {
    /// The unit refused or failed.
    #[error("{participant}: {cause}")]
    Unit {
        /// Name of the participant.
        participant: String,
        /// The error of the unit.
        cause: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The participant has no such variable.
    #[error("{participant} has no variable `{variable}`; it cannot take part in this coupling")]
    Missing {
        /// Name of the participant.
        participant: String,
        /// Name of the variable.
        variable: String,
    },
    /// A coupled variable has another number of values than its counterpart.
    #[error(
        "{participant}: `{variable}` has {found} values, {expected} are needed; both units need the same points"
    )]
    Size {
        /// Name of the participant.
        participant: String,
        /// Name of the variable.
        variable: String,
        /// Number of values needed.
        expected: usize,
        /// Number of values found.
        found: usize,
    },
    /// The unit's process reported an error.
    #[error("{text}")]
    Reported {
        /// Its message, which names the unit.
        text: String,
    },
    /// The unit's process cannot be started.
    #[error("{participant}: its process cannot be started: {cause}; use --transport in-process")]
    NotStarted {
        /// Name of the participant.
        participant: String,
        /// The error of the system.
        cause: std::io::Error,
    },
    /// The unit's process ended.
    #[error("{participant}: its process {how} {when}")]
    Ended {
        /// Name of the participant.
        participant: String,
        /// Exit status or signal.
        how: String,
        /// Step and iteration, or the activity.
        when: String,
    },
    /// The user interrupted the start.
    #[error("interrupted while the units were made")]
    Interrupted,
    /// The unit does not answer.
    #[error(
        "{participant}: no answer for {seconds} s {when}, so its process was killed; if it needs longer, raise \
         --deadline (preparation and initialisation may take sixty times as long)"
    )]
    Hung {
        /// Name of the participant.
        participant: String,
        /// Waiting time, s.
        seconds: f64,
        /// Step and iteration, or the activity.
        when: String,
    },
    /// The unit's description cannot be read.
    #[error("{participant}: its description cannot be read: {cause}; run it from the same build")]
    Unintelligible {
        /// Name of the participant.
        participant: String,
        /// The error in it.
        cause: String,
    },
    /// A request holds another number of values than it should.
    #[error(
        "{participant}: a request has {found} values, {expected} are the inputs; run both from the same build"
    )]
    Length {
        /// Name of the participant.
        participant: String,
        /// Number of values of the inputs.
        expected: usize,
        /// Number of values that came.
        found: usize,
    },
    /// A request has an unknown command.
    #[error("{participant}: {command} is no command; run both from the same build")]
    Command {
        /// Name of the participant.
        participant: String,
        /// Number of the command.
        command: u32,
    },
    /// The communication between two processes failed.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// An answer holds a value that is not finite.
    #[error(
        "{participant}: `{variable}`[{index}] became {value} in the step to t = {time} s; \
         look at the last exchanges in the log, and at the time step's safety factor and the mesh"
    )]
    NonFinite {
        /// Name of the participant.
        participant: String,
        /// Name of the variable.
        variable: String,
        /// Index of the value, from 0.
        index: usize,
        /// The value.
        value: f64,
        /// End of the step, s.
        time: f64,
    },
}
