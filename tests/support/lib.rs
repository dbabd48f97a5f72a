//! Support for the tests that need more than one crate: scenes that vary a shipped one,
//! the binary that runs them, the FMUs that it packs, and independent solutions to compare with.

pub mod document;
pub mod fmu;
pub mod frequency_domain;
pub mod generated;
pub mod koyna;
pub mod process;
pub mod python;
pub mod quadratic_elements;
pub mod scenario;
pub mod scene_text;
pub mod small_unit;

/// `‖a − b‖₂ / ‖b‖₂`.
pub fn relative_l2(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let difference: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (difference / b.iter().map(|b| b * b).sum::<f64>()).sqrt()
}

/// Largest absolute value.
pub fn peak(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |a, b| a.max(b.abs()))
}

/// Observed order of convergence from two errors, the step of the first `ratio` times that of the second.
pub fn order(coarse: f64, fine: f64, ratio: f64) -> f64 {
    (coarse / fine).ln() / ratio.ln()
}
