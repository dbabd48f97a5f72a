//! When a communication step counts as converged, and when further iterations are useless.

mod guard;
mod tolerance;

pub use guard::{Guard, Hopeless};
pub use tolerance::Tolerance;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Measures of convergence. A communication step has converged when all measures that the scene lists are small.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// The residual of the fixed point: `‖p̃ − p‖₂ ≤ ε ‖p̃‖₂ + p_ref`, with p what the dam was given and p̃ what the
    /// reservoir answered.
    Pressure,
    /// The same against the residual of the step's first iteration: `‖r‖₂ ≤ ε ‖r₁‖₂ + p_ref`.
    Residual,
    /// The change of displacement from iteration j − 1 to j: `max_i |u_i^{j} − u_i^{j−1}| / (|u_i^{j−1}| + u_ref) ≤
    /// ε` over the points of the wet face, the paper's eq. 15 with an absolute scale, which avoids 0/0 at rest. It
    /// shows how far iteration j − 1 was from the solution, so that a fast scheme needs one more iteration with it.
    Displacement,
}

/// The measures of convergence and their tolerance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConvergenceMeasure {
    /// The measures.
    pub measures: Vec<Measure>,
    /// The tolerance.
    pub tolerance: Tolerance,
    /// Hydrodynamic pressure of a point that a balanced tolerance expects at least, before it was seen, Pa.
    pub pressure_scale: f64,
    /// u_ref, m.
    pub displacement_scale: f64,
    /// p_ref, Pa.
    pub pressure_floor: f64,
    /// Largest possible pressure, Pa.
    pub pressure_bound: f64,
}

/// What is known of a step before an iteration is judged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known {
    /// Norm of the step's first residual, Pa; none in its first iteration.
    pub first: Option<f64>,
    /// Error of the pressure that is linear within the step, 2-norm, Pa; none without a past.
    pub step_error: Option<f64>,
    /// Largest norm of an accepted pressure, Pa.
    pub largest: f64,
}

/// How far an iteration is from convergence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residuals {
    /// Largest relative change of displacement; infinite in a step's first iteration.
    pub displacement: f64,
    /// ‖p̃ − p‖₂, Pa.
    pub pressure: f64,
    /// ‖p̃ − p‖₂ over its limit by the pressure; converged at ≤ 1.
    pub pressure_ratio: f64,
    /// ‖p̃ − p‖₂ over its limit by the step's first residual; converged at ≤ 1.
    pub residual_ratio: f64,
}

impl Residuals {
    /// The larger value of each measure.
    pub fn or_larger(&self, other: &Self) -> Self {
        Self {
            displacement: largest(self.displacement, other.displacement),
            pressure: largest(self.pressure, other.pressure),
            pressure_ratio: largest(self.pressure_ratio, other.pressure_ratio),
            residual_ratio: largest(self.residual_ratio, other.residual_ratio),
        }
    }
}

impl ConvergenceMeasure {
    /// `measures` and the tolerance with the scales for a dam of `height` (m) in water of hydrostatic base pressure `ρgh` (Pa):
    /// u_ref = 1e-9 × height, p_ref = ε ρgh/100, so that ε is relative as long as pressures exceed a hundredth of the
    /// hydrostatic (10⁻⁸ ρgh for a balanced one); no pressure may exceed 10⁴ ρgh. Nothing is known of the motion.
    pub fn new(
        measures: &[Measure],
        tolerance: impl Into<Tolerance>,
        height: f64,
        hydrostatic_base_pressure: f64,
    ) -> Self {
        let tolerance = tolerance.into();
        Self {
            measures: measures.to_vec(),
            tolerance,
            pressure_scale: 0.0,
            displacement_scale: 1e-9 * height,
            pressure_floor: tolerance.floor() * hydrostatic_base_pressure,
            pressure_bound: 1e4 * hydrostatic_base_pressure,
        }
    }

    /// The residuals of an iteration.
    ///
    /// **Arguments**: displacement of this iteration and of the one before (m; `None` in a step's first), pressure
    /// given to the dam and answered by the reservoir (Pa), and what is `known` of the step.
    pub fn residuals(
        &self,
        displacement: &[f64],
        previous_displacement: Option<&[f64]>,
        [given, answered]: [&[f64]; 2],
        known: Known,
    ) -> Residuals {
        let displacement = previous_displacement.map_or(f64::INFINITY, |previous| {
            let change = |(u, v): (&f64, &f64)| (u - v).abs() / (v.abs() + self.displacement_scale);
            displacement.iter().zip(previous).map(change).fold(0.0, largest)
        });
        let pressure = norm(given.iter().zip(answered).map(|(p, q)| q - p));
        let expected = self.pressure_scale * (answered.len() as f64).sqrt();
        let known = Known { largest: known.largest.max(expected), ..known };
        let allowed = self.tolerance.allowed(norm(answered.iter().copied()), known) + self.pressure_floor;
        let allowed_of_first =
            self.tolerance.relative() * known.first.unwrap_or(pressure) + self.pressure_floor;
        // At rest with p_ref = 0, both residual and limit are zero.
        let over = |allowed: f64| if pressure == 0.0 { 0.0 } else { pressure / allowed };
        let (pressure_ratio, residual_ratio) = (over(allowed), over(allowed_of_first));
        Residuals { displacement, pressure, pressure_ratio, residual_ratio }
    }

    /// The first pressure (Pa) that exceeds the largest possible one.
    pub fn unbounded(&self, answered: &[f64]) -> Option<Hopeless> {
        let bound = self.pressure_bound;
        let beyond = answered.iter().copied().find(|p| p.is_nan() || p.abs() > bound);
        beyond.map(|pressure| Hopeless::Unbounded { pressure, bound })
    }

    /// Whether all measures hold; a residual that is not finite never does.
    pub fn converged(&self, residuals: &Residuals) -> bool {
        let holds = |measure: &Measure| match measure {
            Measure::Pressure => residuals.pressure_ratio <= 1.0,
            Measure::Residual => residuals.residual_ratio <= 1.0,
            Measure::Displacement => residuals.displacement <= self.tolerance.relative(),
        };
        residuals.pressure.is_finite() && !self.measures.is_empty() && self.measures.iter().all(holds)
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

    fn after(residual: f64) -> Known {
        Known { first: Some(residual), ..Known::default() }
    }

    const BOTH: [Measure; 2] = [Measure::Displacement, Measure::Pressure];

    #[test]
    fn rest_converges_at_once_unless_a_change_is_asked_for() {
        let zero: [&[f64]; 2] = [&[0.0, 0.0]; 2];
        for (measures, first) in [(&BOTH[..], false), (&BOTH[1..], true), (&[Measure::Residual], true)] {
            let measure = ConvergenceMeasure::new(measures, 1e-6, 100.0, 1e6);
            assert_eq!(measure.converged(&measure.residuals(zero[0], None, zero, Known::default())), first);
            assert!(measure.converged(&measure.residuals(zero[0], Some(zero[0]), zero, after(0.0))));
        }
    }

    #[test]
    fn each_measure_can_refuse_alone() {
        let measure = ConvergenceMeasure::new(&BOTH, 1e-3, 100.0, 1e6);
        let (p, near, far) = ([1e4, 2e4], [1e4, 2e4 + 1.0], [1e4, 2.1e4]);
        let converged = |u: f64, q: &[f64]| {
            measure.converged(&measure.residuals(&[u], Some(&[0.01]), [&p, q], after(1e9)))
        };
        assert!(converged(0.010001, &near));
        assert!(!converged(0.0101, &near));
        assert!(!converged(0.010001, &far));
        assert!(!converged(f64::NAN, &near));
        assert!(!converged(0.010001, &[1e4, f64::NAN]));
    }

    #[test]
    fn the_first_residual_is_a_scale_of_its_own_and_nothing_asked_is_never_converged() {
        let p = [1e4, 2e4];
        let converged = |measures: &[Measure], residual: f64, first: f64| {
            let measure = ConvergenceMeasure::new(measures, 1e-3, 100.0, 0.0);
            measure.converged(&measure.residuals(&[0.0], None, [&p, &[1e4 + residual, 2e4]], after(first)))
        };
        assert!(converged(&[Measure::Pressure], 10.0, 1e3) && !converged(&[Measure::Residual], 10.0, 1e3));
        assert!(converged(&[Measure::Residual], 0.9, 1e3));
        assert!(!converged(&[], 0.0, 1.0));
    }

    #[test]
    fn a_balanced_tolerance_is_a_share_of_the_steps_error_between_its_bounds() {
        let mut measure = ConvergenceMeasure::new(&[Measure::Pressure], Tolerance::Balanced, 100.0, 0.0);
        // Limits of pressures of norm 1 kPa at four points: of an unknown error, a small, a middle and a large one.
        let limit = |measure: &ConvergenceMeasure, step_error: Option<f64>, largest: f64| {
            let known = Known { step_error, largest, ..Known::default() };
            let residuals = measure.residuals(&[0.0], None, [&[499.0; 4], &[500.0; 4]], known);
            residuals.pressure / residuals.pressure_ratio
        };
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12 * b;
        for (step_error, expected) in [(None, 0.3), (Some(1.0), 0.3), (Some(50.0), 5.0), (Some(1e6), 10.0)] {
            assert!(near(limit(&measure, step_error, 0.0), expected), "{step_error:?}");
            // A larger pressure of the past, or one that is expected, is the scale.
            assert!(near(limit(&measure, step_error.map(|e| 4.0 * e), 4000.0), 4.0 * expected));
        }
        measure.pressure_scale = 2000.0;
        assert!(near(limit(&measure, None, 0.0), 1.2) && near(limit(&measure, None, 5000.0), 1.5));
    }
}
