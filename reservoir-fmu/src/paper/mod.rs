//! The paper's method for the water, only to measure its error: **do not use it for results**.
//!
//! The paper on which this project is based divides time into short windows, each with its own Fourier transform
//! ([`ShortWindows`]), and states no condition at the far end ([`response_before`], [`pressure_before`]). Both lose most of
//! the response; `cofferdam-lab windows` shows how much.

mod far_end;
mod short_windows;

pub use crate::condition::FarEndCondition;
pub use far_end::{pressure_before, response_before};
pub use short_windows::ShortWindows;
