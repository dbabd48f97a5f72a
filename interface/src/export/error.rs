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
    /// A pointer is null, or points where no such value can lie.
    #[error("{call}: `{argument}` is null or misaligned; pass a valid pointer")]
    Pointer {
        /// The function.
        call: &'static str,
        /// Name of the argument.
        argument: &'static str,
    },
    /// A string is no UTF-8.
    #[error("{call}: `{argument}` is no UTF-8 text")]
    Text {
        /// The function.
        call: &'static str,
        /// Name of the argument.
        argument: &'static str,
    },
    /// The values do not fit the variables.
    #[error("{call}: the {references} variables have {expected} values together, {found} were passed")]
    Values {
        /// The function.
        call: &'static str,
        /// Number of variables.
        references: usize,
        /// Number of their values.
        expected: usize,
        /// Number of values passed.
        found: usize,
    },
    /// A start time that is not finite.
    #[error("the start time is {value} s; it must be finite")]
    StartTime {
        /// Value passed, s.
        value: f64,
    },
    /// `time` cannot be set.
    #[error("`time` cannot be set; it is what fmi3EnterInitializationMode and fmi3DoStep make it")]
    Time,
    /// A parameter that these contents do not let change.
    #[error("{unit}: `{variable}` cannot be changed in this FMU; change the scene and pack it again")]
    Unchangeable {
        /// Unit that was called.
        unit: &'static str,
        /// Variable named.
        variable: &'static str,
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
