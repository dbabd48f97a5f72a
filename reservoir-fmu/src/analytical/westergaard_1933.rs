//! Water pressures on dams during earthquakes: the parabola.
//!
//! **Source**: Westergaard, H. M. (1933), Transactions of the ASCE 98, 418–433. Checked by
//! `tests/westergaard_1933.rs`.

/// Base pressure over ρah.
pub const BASE_PRESSURE: f64 = 7.0 / 8.0;

/// Force over ρah².
pub const FORCE: f64 = 7.0 / 12.0;

/// `p/(ρa) = ⅞ √(h(h − y))`, m.
pub fn pressure(depth: f64, elevation: f64) -> f64 {
    BASE_PRESSURE * (depth * (depth - elevation)).sqrt()
}
