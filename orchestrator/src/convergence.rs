//! When a communication step counts as converged.

use serde::{Deserialize, Serialize};

/// The measures of convergence and their tolerance.
///
/// Both must hold, for the same iteration j:
/// - displacement: `max_i |u_i^{j} − u_i^{j−1}| / (|u_i^{j−1}| + u_ref) ≤ ε` over the
///   points of the wet face, the paper's eq. 15 with an absolute scale, so that rest is no 0/0;
/// - pressure: `‖p̃ − p‖₂ ≤ ε ‖p̃‖₂ + p_ref`, with p what the dam was given and p̃ what the
///   reservoir answered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConvergenceMeasure {
    /// ε, dimensionless.
    pub tolerance: f64,
    /// u_ref, m.
    pub displacement_scale: f64,
    /// p_ref, Pa.
    pub pressure_floor: f64,
}

/// How far an iteration is from convergence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residuals {
    /// Largest relative change of displacement; infinite in a step's first iteration.
    pub displacement: f64,
    /// ‖p̃ − p‖₂, Pa.
    pub pressure: f64,
    /// ‖p̃ − p‖₂ over what is allowed; converged at ≤ 1.
    pub pressure_ratio: f64,
}

impl ConvergenceMeasure {
    /// ε with the scales for a dam of `height` (m) in water of hydrostatic base pressure `ρgh` (Pa):
    /// u_ref = 1e-9 × height, p_ref = 1e-6 ρgh.
    pub fn new(tolerance: f64, height: f64, hydrostatic_base_pressure: f64) -> Self {
        Self {
            tolerance,
            displacement_scale: 1e-9 * height,
            pressure_floor: 1e-6 * hydrostatic_base_pressure,
        }
    }

    /// The residuals of an iteration.
    ///
    /// **Arguments**: displacement of this iteration and of the one before (m; `None` in a
    /// step's first), pressure given to the dam and answered by the reservoir (Pa).
    pub fn residuals(
        &self,
        displacement: &[f64],
        previous_displacement: Option<&[f64]>,
        given: &[f64],
        answered: &[f64],
    ) -> Residuals {
        let displacement = previous_displacement.map_or(f64::INFINITY, |previous| {
            let change = |(u, v): (&f64, &f64)| (u - v).abs() / (v.abs() + self.displacement_scale);
            displacement.iter().zip(previous).map(change).fold(0.0, largest)
        });
        let pressure = norm(given.iter().zip(answered).map(|(p, q)| q - p));
        let allowed = self.tolerance * norm(answered.iter().copied()) + self.pressure_floor;
        Residuals { displacement, pressure, pressure_ratio: pressure / allowed }
    }

    /// Both measures hold.
    pub fn converged(&self, residuals: &Residuals) -> bool {
        residuals.displacement <= self.tolerance && residuals.pressure_ratio <= 1.0
    }
}

/// The larger of two numbers, NaN if either is.
fn largest(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// Euclidean norm.
pub fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|v| v * v).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rest_converges_and_the_first_iteration_does_not() {
        let measure = ConvergenceMeasure::new(1e-6, 100.0, 1e6);
        let zero = [0.0, 0.0];
        assert!(!measure.converged(&measure.residuals(&zero, None, &zero, &zero)));
        assert!(measure.converged(&measure.residuals(&zero, Some(&zero), &zero, &zero)));
    }

    #[test]
    fn each_measure_can_refuse_alone() {
        let measure = ConvergenceMeasure::new(1e-3, 100.0, 1e6);
        let (p, near, far) = ([1e4, 2e4], [1e4, 2e4 + 1.0], [1e4, 2.1e4]);
        let converged = |u: f64, q: &[f64]| measure.converged(&measure.residuals(&[u], Some(&[0.01]), &p, q));
        assert!(converged(0.010001, &near));
        assert!(!converged(0.0101, &near));
        assert!(!converged(0.010001, &far));
        assert!(!converged(f64::NAN, &near));
        assert!(!converged(0.010001, &[1e4, f64::NAN]));
    }
}
