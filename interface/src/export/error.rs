use super::ContentsError;
use crate::{CallError, StateError};

/// Why an FMU refuses a call of its importer.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// A call that breaks the contract of units.
    #[error(transparent)]
    Call(#[from] CallError),
    /// What the unit itself said.
    #[error("{0}")]
    Unit(Box<dyn std::error::Error + Send + Sync>),
    /// The FMU's resources.
    #[error(transparent)]
    Contents(#[from] ContentsError),
    /// A serialised state.
    #[error(transparent)]
    State(#[from] StateError),
    /// A call in the wrong mode of the FMU's life.
    #[error("{call} is not allowed in {mode}; {remedy}")]
    Mode {
        /// The function.
        call: &'static str,
        /// Mode that the instance is in.
        mode: &'static str,
        /// What would be allowed.
        remedy: &'static str,
    },
    /// A pointer is null, or points where no such values can lie.
    #[error("{call}: `{argument}` is null, misaligned or impossibly long; pass a valid pointer and length")]
    Pointer {
        /// The function.
        call: &'static str,
        /// Name of the argument.
        argument: &'static str,
    },
    /// A string is no UTF-8.
    #[error("{call}: `{argument}` is no UTF-8 text; encode it so")]
    Text {
        /// The function.
        call: &'static str,
        /// Name of the argument.
        argument: &'static str,
    },
    /// The values do not fit the variables.
    #[error("{call}: the variables have {expected} values together, {found} were passed; pass as many")]
    Values {
        /// The function.
        call: &'static str,
        /// Number of their values.
        expected: usize,
        /// Number of values passed.
        found: usize,
    },
    /// An interval that no simulation can have.
    #[error("the start time is {start_time} s, the stop time {stop_time} s; both must be finite, and ascend")]
    Interval {
        /// Start passed, s.
        start_time: f64,
        /// Stop passed, s.
        stop_time: f64,
    },
    /// A step beyond the end.
    #[error(
        "a step to {end} s passes the stop time of {stop_time} s; give fmi3EnterInitializationMode a later one, or none"
    )]
    BeyondStop {
        /// End of the step, s.
        end: f64,
        /// Stop time, s.
        stop_time: f64,
    },
    /// A start value among the resources that no input of the unit can take.
    #[error("`{name}` cannot start with {found} values: the unit has an input of that name with {expected}")]
    Start {
        /// Name in the contents.
        name: String,
        /// Number of values of the input of that name; 0 if there is none.
        expected: usize,
        /// Number of values in the contents.
        found: usize,
    },
    /// `time` cannot be set.
    #[error("`time` cannot be set; it is what fmi3EnterInitializationMode and fmi3DoStep make it")]
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
        "the instantiation token is {found}, the resources want {expected}; take modelDescription.xml and resources \
         from the same FMU"
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
    /// A handle that is none.
    #[error("{call}: the state was not saved by this instance, or is freed already")]
    UnknownState {
        /// The function.
        call: &'static str,
    },
    /// Room of the wrong size for a serialised state.
    #[error(
        "the serialised state has {expected} bytes, there is room for {found}; ask fmi3SerializedFMUStateSize"
    )]
    StateSize {
        /// Bytes needed.
        expected: usize,
        /// Bytes of room.
        found: usize,
    },
    /// A category of messages that there is not.
    #[error("there is no log category {found:?}; there are logStatusError, logStatusWarning and logEvents")]
    Category {
        /// Category passed.
        found: String,
    },
    /// A part of FMI that this FMU does not have.
    #[error("{call}: this FMU does not offer it; its modelDescription.xml says what it offers")]
    NotOffered {
        /// The function.
        call: &'static str,
    },
    /// Earlier the instance was left in the middle of something.
    #[error("this instance broke down earlier; free it and instantiate another")]
    Broken,
    /// A defect of the unit.
    #[error("{call} broke down: {cause}; this is a defect of the FMU, please report it")]
    Panicked {
        /// The function.
        call: &'static str,
        /// What the panic said.
        cause: String,
    },
}
