//! Types of the C functions of FMI 3.0.

use std::ffi::{c_char, c_void};

/// `fmi3Instance`, `fmi3FMUState`: a number that is looked up, never dereferenced.
pub type Handle = *mut c_void;
/// `fmi3Boolean`; a `u8`, because any byte that C passes must be valid here.
pub type Boolean = u8;
/// `fmi3String`.
pub type Text = *const c_char;
/// `fmi3LogMessageCallback`.
pub type LogMessage = unsafe extern "C" fn(*mut c_void, Status, Text, Text);

/// `fmi3Status`.
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
