//! When a communication step counts as converged, and when further iterations are useless.

mod guard;
mod tolerance;

pub use guard::{Guard, IterationFailure};
pub use tolerance::Tolerance;

use serde::{Deserialize, Serialize};

/// Measures of convergence. A communication step has converged when all measures that are listed are small.
///
/// The words are those of the scene files, named after what a reservoir and a dam exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// The residual of the fixed point: `‖p̃ − p‖₂ ≤ ε ‖p̃‖₂ + p_ref`, with p what the dam was given and p̃ what the
    /// reservoir answered.
    #[serde(rename = "pressure")]
    Relative,
    /// The same against the residual of the step's first iteration: `‖r‖₂ ≤ ε ‖r₁‖₂ + p_ref`.
    #[serde(rename = "residual")]
    Reduction,
    /// The change of displacement from iteration j − 1 to j: `max_i |u_i^{j} − u_i^{j−1}| / (|u_i^{j−1}| + u_ref) ≤
    /// ε` over the points of the wet face, the paper's eq. 15 with an absolute scale, which avoids 0/0 at rest. It
    /// shows how far iteration j − 1 was from the solution, so that a fast scheme needs one more iteration with it.
    #[serde(rename = "displacement")]
    Change,
}

/// Absolute scales, by which a measure stays meaningful near zero. All but `change` are in the unit of the backward fields.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scales {
    /// Magnitude that a balanced tolerance assumes before it has seen a larger one.
    pub expected: f64,
    /// u_ref, which is added to the monitored quantity, in its unit.
    pub change: f64,
    /// A typical value, from which the residual that is always allowed is taken: p_ref = 10⁻² ε of it, or 10⁻⁸ of it with a
    /// balanced tolerance.
    pub typical: f64,
    /// Largest possible magnitude of a value; an iteration beyond it fails.
    pub bound: f64,
}

impl Default for Scales {
    /// No scale and no bound: residuals are relative alone.
    fn default() -> Self {
        Self { expected: 0.0, change: 0.0, typical: 0.0, bound: f64::INFINITY }
    }
}

/// The measures of convergence and their tolerance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConvergenceMeasure {
    /// The measures.
    pub measures: Vec<Measure>,
    /// The tolerance.
    pub tolerance: Tolerance,
    /// The scales.
    pub scales: Scales,
}

/// What is known of a step before an iteration is judged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IterationInfo {
    /// Norm of the step's first residual; none in its first iteration.
    pub first: Option<f64>,
    /// Error of values that are linear within the step, 2-norm; none without a past.
    pub step_error: Option<f64>,
    /// Largest norm of accepted values.
    pub largest: f64,
}

/// How far an iteration is from convergence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residuals {
    /// Largest relative change of the monitored quantity; infinite in a step's first iteration.
    pub change: f64,
    /// ‖p̃ − p‖₂, in the unit of p.
    pub norm: f64,
    /// ‖p̃ − p‖₂ over its limit by ‖p̃‖₂; converged at ≤ 1.
    pub relative_ratio: f64,
    /// ‖p̃ − p‖₂ over its limit by the step's first residual; converged at ≤ 1.
    pub reduction_ratio: f64,
}

impl Residuals {
    /// The larger value of each measure.
    pub fn or_larger(&self, other: &Self) -> Self {
        Self {
            change: largest(self.change, other.change),
            norm: largest(self.norm, other.norm),
            relative_ratio: largest(self.relative_ratio, other.relative_ratio),
            reduction_ratio: largest(self.reduction_ratio, other.reduction_ratio),
        }
    }
}

impl ConvergenceMeasure {
    /// `measures` and the tolerance, with these `scales`.
    pub fn new(measures: &[Measure], tolerance: impl Into<Tolerance>, scales: Scales) -> Self {
        Self { measures: measures.to_vec(), tolerance: tolerance.into(), scales }
    }

    /// p_ref, the residual that is always allowed.
    pub fn floor(&self) -> f64 {
        self.tolerance.floor() * self.scales.typical
    }

    /// The residuals of an iteration.
    ///
    /// **Arguments**: the monitored quantity of this iteration and of the one before (`None` in a step's first), the values
    /// that were given and answered, and what is `known` of the step.
    pub fn residuals(
        &self,
        monitored: &[f64],
        previous: Option<&[f64]>,
        [given, answered]: [&[f64]; 2],
        known: IterationInfo,
    ) -> Residuals {
        let change = previous.map_or(f64::INFINITY, |previous| {
            let change = |(u, v): (&f64, &f64)| (u - v).abs() / (v.abs() + self.scales.change);
            monitored.iter().zip(previous).map(change).fold(0.0, largest)
        });
        let residual = norm(given.iter().zip(answered).map(|(p, q)| q - p));
        let expected = self.scales.expected * (answered.len() as f64).sqrt();
        let known = IterationInfo { largest: known.largest.max(expected), ..known };
        let floor = self.floor();
        let allowed = self.tolerance.allowed(norm(answered.iter().copied()), known) + floor;
        let allowed_of_first = self.tolerance.relative() * known.first.unwrap_or(residual) + floor;
        // At rest with p_ref = 0, both residual and limit are zero.
        let over = |allowed: f64| if residual == 0.0 { 0.0 } else { residual / allowed };
        let (relative_ratio, reduction_ratio) = (over(allowed), over(allowed_of_first));
        Residuals { change, norm: residual, relative_ratio, reduction_ratio }
    }

    /// The first value whose magnitude exceeds the largest possible one.
    pub fn unbounded(&self, answered: &[f64]) -> Option<IterationFailure> {
        let bound = self.scales.bound;
        let beyond = answered.iter().copied().find(|p| p.is_nan() || p.abs() > bound);
        beyond.map(|value| IterationFailure::Unbounded { value, bound })
    }

    /// Whether all measures hold; a residual that is not finite never does.
    pub fn converged(&self, residuals: &Residuals) -> bool {
        let holds = |measure: &Measure| match measure {
            Measure::Relative => residuals.relative_ratio <= 1.0,
            Measure::Reduction => residuals.reduction_ratio <= 1.0,
            Measure::Change => residuals.change <= self.tolerance.relative(),
        };
        residuals.norm.is_finite() && !self.measures.is_empty() && self.measures.iter().all(holds)
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

    fn measure(measures: &[Measure], tolerance: impl Into<Tolerance>, typical: f64) -> ConvergenceMeasure {
        let scales = Scales { expected: 0.0, change: 1e-7, typical, bound: 1e4 * typical };
        ConvergenceMeasure::new(measures, tolerance, scales)
    }

    fn after(residual: f64) -> IterationInfo {
        IterationInfo { first: Some(residual), ..IterationInfo::default() }
    }

    const BOTH: [Measure; 2] = [Measure::Change, Measure::Relative];

    #[test]
    fn rest_converges_at_once_unless_a_change_is_asked_for() {
        let zero: [&[f64]; 2] = [&[0.0, 0.0]; 2];
        for (measures, first) in [(&BOTH[..], false), (&BOTH[1..], true), (&[Measure::Reduction], true)] {
            let measure = measure(measures, 1e-6, 1e6);
            assert_eq!(
                measure.converged(&measure.residuals(zero[0], None, zero, IterationInfo::default())),
                first
            );
            assert!(measure.converged(&measure.residuals(zero[0], Some(zero[0]), zero, after(0.0))));
        }
    }

    #[test]
    fn each_measure_can_refuse_alone() {
        let measure = measure(&BOTH, 1e-3, 1e6);
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
            let measure = measure(measures, 1e-3, 0.0);
            measure.converged(&measure.residuals(&[0.0], None, [&p, &[1e4 + residual, 2e4]], after(first)))
        };
        assert!(converged(&[Measure::Relative], 10.0, 1e3) && !converged(&[Measure::Reduction], 10.0, 1e3));
        assert!(converged(&[Measure::Reduction], 0.9, 1e3));
        assert!(!converged(&[], 0.0, 1.0));
    }

    #[test]
    fn a_balanced_tolerance_is_a_share_of_the_steps_error_between_its_bounds() {
        let mut measure = measure(&[Measure::Relative], Tolerance::Balanced, 0.0);
        // Limits of pressures of norm 1 kPa at four points: of an unknown error, a small, a middle and a large one.
        let limit = |measure: &ConvergenceMeasure, step_error: Option<f64>, largest: f64| {
            let known = IterationInfo { step_error, largest, ..IterationInfo::default() };
            let residuals = measure.residuals(&[0.0], None, [&[499.0; 4], &[500.0; 4]], known);
            residuals.norm / residuals.relative_ratio
        };
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12 * b;
        for (step_error, expected) in [(None, 0.3), (Some(1.0), 0.3), (Some(50.0), 5.0), (Some(1e6), 10.0)] {
            assert!(near(limit(&measure, step_error, 0.0), expected), "{step_error:?}");
            // A larger pressure of the past, or one that is expected, is the scale.
            assert!(near(limit(&measure, step_error.map(|e| 4.0 * e), 4000.0), 4.0 * expected));
        }
        measure.scales.expected = 2000.0;
        assert!(near(limit(&measure, None, 0.0), 1.2) && near(limit(&measure, None, 5000.0), 1.5));
    }
}
