use std::path::PathBuf;

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
    /// A unit that does not return to its saved state.
    #[error(
        "{participant}: the same step from its saved state gives `{variable}`[{index}] = {first:e} at first and {second:e} then; \
         save all that its steps change, or say that it has no state and choose an explicit [coupling] scheme"
    )]
    NotRepeated {
        /// Name of the participant.
        participant: String,
        /// Name of the variable.
        variable: String,
        /// Index of the value, from 0.
        index: usize,
        /// The answer of the first time.
        first: f64,
        /// The answer of the second.
        second: f64,
    },
    /// The unit's process reported an error.
    #[error("{text}")]
    Reported {
        /// Its message, which names the unit.
        text: String,
    },
    /// The unit's process cannot be started.
    #[error("{participant}: its process, `{program}`, cannot be started: {cause}; {remedy}")]
    NotStarted {
        /// Name of the participant.
        participant: String,
        /// The program.
        program: String,
        /// The error of the system.
        cause: std::io::Error,
        /// What to do.
        remedy: &'static str,
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
    /// A state is asked for that the unit cannot save.
    #[error(
        "{participant}: it cannot return to a saved state, as its description says; let it save and restore states, or use \
         an explicit scheme"
    )]
    NoSavedState {
        /// Name of the participant.
        participant: String,
    },
    /// The state is asked for as bytes, which the unit does not give.
    #[error(
        "{participant}: it neither gives nor takes its state as bytes; use a unit that does, such as a built-in one, or put it \
         there by its steps"
    )]
    NotSerialised {
        /// Name of the participant.
        participant: String,
    },
    /// A state does not reach the other process, or does not come from it.
    #[error(
        "{participant}: its state cannot be {doing} in {}: {cause}; it goes through memory, see `df /dev/shm`", path.display()
    )]
    StateFile {
        /// Name of the participant.
        participant: String,
        /// What failed.
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// The error of the system.
        cause: std::io::Error,
    },
    /// The user interrupted the start.
    #[error("interrupted while the units were made")]
    Interrupted,
    /// The unit does not answer.
    #[error(
        "{participant}: no answer for {seconds} s {when}, so its process was killed; if it needs longer, raise \
         --deadline of `run` (preparation and initialisation may take sixty times as long)"
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
    /// The communication with the unit failed.
    #[error(transparent)]
    Communication(Box<dyn std::error::Error + Send + Sync>),
    /// An answer holds a value that is not finite.
    #[error(
        "{participant}: `{variable}`[{index}] became {value} in the step to t = {time} s; \
         look at the last exchanges in the log; of a unit with explicit steps of its own also at their safety factor \
         and the mesh"
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
