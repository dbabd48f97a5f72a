//! Published solutions over a flat bed; they call no solver code.
//!
//! Solutions for horizontal motion give the pressure per unit density for a motion *towards* the water (upstream), so
//! that it is positive at first; depth h in m, sound speed c in m/s, elevation y in m above
//! the bed, time t in s, complex frequency s in 1/s.

pub mod bustamante_1963;
pub mod chakrabarti_chopra_1973;
pub mod chopra_1967;
pub mod chwang_1978;
pub mod fenves_chopra_1984;
mod nodal_forces;
pub mod westergaard_1933;

pub use nodal_forces::nodal_forces;
