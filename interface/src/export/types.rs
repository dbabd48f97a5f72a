//! Types of the C functions of FMI 2.0 and 3.0.

use std::ffi::{c_char, c_void};

/// `fmi3Instance`, `fmi3FMUState`: a number that is looked up, never dereferenced.
pub type Handle = *mut c_void;
/// `fmi3Boolean`; a `u8`, because any byte that C passes must be valid here.
pub type Boolean = u8;
/// `fmi3String`.
pub type Text = *const c_char;
/// `fmi3LogMessageCallback`.
pub type LogMessage = unsafe extern "C" fn(*mut c_void, Status, Text, Text);
/// `fmi2CallbackLogger`: environment, name of the instance, status, category, format, and what it formats.
pub type Logger = unsafe extern "C" fn(*mut c_void, Text, Status, Text, Text, ...);

/// `fmi2CallbackFunctions`; only the first and the last member are used.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Callbacks {
    /// Takes messages.
    pub logger: Option<Logger>,
    /// Of memory and of steps that end later; not called.
    pub unused: [*const c_void; 3],
    /// Goes back to the logger.
    pub environment: *mut c_void,
}

/// `fmi3Status`, of the same numbers as `fmi2Status`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum Status {
    /// Success.
    Ok,
    /// The results may be doubtful.
    Warning,
    /// The call did nothing; the instance is unchanged.
    Discard,
    /// The call was refused; the instance is unchanged.
    Error,
    /// The instance can no longer be used, or could not be made because of a panic.
    Fatal,
}
