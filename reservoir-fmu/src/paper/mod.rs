//! The paper's way with the water, to be measured: **not for use**.
//!
//! The paper that this project realises goes through time in short windows, each with a Fourier transform of its own
//! ([`ShortWindows`]), and says nothing of the far end ([`response_before`], [`pressure_before`]). Both cost most of the
//! answer; `cofferdam study windows` shows how much.

mod far_end;
mod short_windows;

pub use crate::condition::FarEndCondition;
pub use far_end::{pressure_before, response_before};
pub use short_windows::ShortWindows;
