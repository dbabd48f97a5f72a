use super::ContentsError;
use crate::{CallError, StateError};

/// Why an FMU refuses a call of its importer.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// A call that breaks the contract of units.
    #[error(transparent)]
    Call(#[from] CallError),
    /// An error of the unit itself.
    #[error("{0}")]
    Unit(Box<dyn std::error::Error + Send + Sync>),
    /// The FMU's resources.
    #[error(transparent)]
    Contents(#[from] ContentsError),
    /// A serialised state.
    #[error(transparent)]
    State(#[from] StateError),
    /// A variable of another type than that of the function.
    #[error("{call}: `{variable}` is of type {data_type}; use {remedy}")]
    Type {
        /// The function.
        call: &'static str,
        /// Variable named.
        variable: &'static str,
        /// Type of the variable in this version of FMI.
        data_type: &'static str,
        /// Name of the function for it.
        remedy: String,
    },
    /// A call that FMI does not allow in the present mode.
    #[error("{call} is not allowed in {mode}; {remedy}")]
    Mode {
        /// The function.
        call: &'static str,
        /// Mode that the instance is in.
        mode: &'static str,
        /// What to do instead.
        remedy: &'static str,
    },
    /// A pointer that is null or misaligned, or a length that is impossible.
    #[error("{call}: `{argument}` is null, misaligned or impossibly long; pass a valid pointer and length")]
    Pointer {
        /// The function.
        call: &'static str,
        /// Name of the argument.
        argument: &'static str,
    },
    /// A string is not UTF-8.
    #[error("{call}: `{argument}` is not UTF-8 text; encode it in UTF-8")]
    Text {
        /// The function.
        call: &'static str,
        /// Name of the argument.
        argument: &'static str,
    },
    /// The number of values is not that of the variables.
    #[error("{call}: the variables have {expected} values together, {found} were passed; pass {expected}")]
    Values {
        /// The function.
        call: &'static str,
        /// Number of their values.
        expected: usize,
        /// Number of values passed.
        found: usize,
    },
    /// A start or stop time that a simulation cannot have.
    #[error(
        "the start time is {start_time} s, the stop time {stop_time} s; both must be finite, and the stop time not before the start time"
    )]
    Interval {
        /// Start passed, s.
        start_time: f64,
        /// Stop passed, s.
        stop_time: f64,
    },
    /// A step beyond the end.
    #[error(
        "a step to {end} s passes the stop time of {stop_time} s; pass a later stop time, or none, before initialisation"
    )]
    BeyondStop {
        /// End of the step, s.
        end: f64,
        /// Stop time, s.
        stop_time: f64,
    },
    /// Start values in the resources that fit no input of the unit.
    #[error(
        "`{name}` cannot start with {found} values: the unit's input of that name has {expected} (0: there is none)"
    )]
    Start {
        /// Name in the contents.
        name: String,
        /// Number of values of the input of that name; 0 if there is none.
        expected: usize,
        /// Number of values in the contents.
        found: usize,
    },
    /// A derivative of an input that is not used.
    #[error(
        "{unit}: derivative {order} of `{variable}` cannot be set; set derivatives of order 1 of inputs, which are linear within a step"
    )]
    InputDerivative {
        /// Unit that was called.
        unit: &'static str,
        /// Variable named.
        variable: &'static str,
        /// Order of the derivative.
        order: i32,
    },
    /// A derivative of an input that is constant within a step.
    #[error(
        "{call}: `inputs_held` is true, so that inputs are constant within a step; set it to false before initialisation \
         to set derivatives"
    )]
    HeldInputs {
        /// The function.
        call: &'static str,
    },
    /// A location of the resources that is not a local folder.
    #[error(
        "the resource location {found:?} is no local folder; pass a URI such as file:///tmp/fmu/resources"
    )]
    Location {
        /// URI passed.
        found: String,
    },
    /// `time` cannot be set.
    #[error("`time` cannot be set; initialisation and steps set it")]
    Time,
    /// A parameter is NaN or infinite.
    #[error("{unit}: `{variable}`[{index}] cannot be {value}; set it to a finite number")]
    NonFiniteParameter {
        /// Unit that was called.
        unit: &'static str,
        /// Variable named.
        variable: &'static str,
        /// Index of the value, from 0.
        index: usize,
        /// The value.
        value: f64,
    },
    /// The token is not that of the resources.
    #[error(
        "the instantiation token is {found}, but the resources need {expected}; take modelDescription.xml and the \
         resources from the same FMU"
    )]
    Token {
        /// Token passed.
        found: String,
        /// Token of the resources.
        expected: String,
    },
    /// The importer wants to handle events.
    #[error("this FMU has no event mode; instantiate it with eventModeUsed = false")]
    EventMode,
    /// A handle that belongs to no saved state.
    #[error("{call}: the state was not saved by this instance, or has been freed")]
    UnknownState {
        /// The function.
        call: &'static str,
    },
    /// A buffer of the wrong size for a serialised state.
    #[error(
        "the serialised state has {expected} bytes, the buffer has {found}; take its size from the FMU (SerializedFMUStateSize)"
    )]
    StateSize {
        /// Bytes needed.
        expected: usize,
        /// Size of the buffer in bytes.
        found: usize,
    },
    /// An unknown log category.
    #[error("there is no log category {found:?}; choose logStatusError, logStatusWarning or logEvents")]
    Category {
        /// Category passed.
        found: String,
    },
    /// A function of FMI that this FMU does not offer.
    #[error(
        "{call}: this FMU does not offer this function; see the capabilities in its modelDescription.xml"
    )]
    NotOffered {
        /// The function.
        call: &'static str,
    },
    /// An earlier call ended in a panic.
    #[error("this instance failed in an earlier call; free it and instantiate another")]
    Broken,
    /// The call ended in a panic.
    #[error("{call} failed: {cause}; this is a defect of the FMU, please report it")]
    Panicked {
        /// The function.
        call: &'static str,
        /// Message of the panic.
        cause: String,
    },
}
