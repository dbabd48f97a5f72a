/// Growth of the residual over its smallest value in the step that counts as divergence.
const DIVERGENCE: f64 = 1e6;
/// Stagnation: in so many iterations the residual does not decrease to this share of its value.
const PATIENCE: usize = 30;
const PROGRESS: f64 = 0.99;
/// A residual that stagnates below this multiple of the rounding floor stagnates because of rounding.
const FLOORS: f64 = 30.0;

/// Watches the iterations of a communication step and recognises those that cannot converge.
///
/// It never declares convergence; it only reports why further iterations are useless.
#[derive(Clone, Debug, Default)]
pub struct Guard {
    smallest: Option<f64>,
    /// Residual from which the decrease is measured.
    mark: f64,
    since_progress: usize,
}

/// Why further iterations of a communication step are useless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IterationFailure {
    /// The residual grows without bound.
    Diverging {
        /// Residual of the last iteration.
        residual: f64,
        /// Smallest residual of the step.
        smallest: f64,
    },
    /// The residual no longer decreases.
    Stagnating {
        /// Iterations without progress.
        iterations: usize,
        /// Smallest residual of the step.
        smallest: f64,
    },
    /// The residual no longer decreases because of the rounding of the units.
    RoundingFloor {
        /// Smallest residual of the step.
        smallest: f64,
        /// The rounding floor.
        floor: f64,
    },
    /// A value above the largest possible one.
    Unbounded {
        /// The value.
        value: f64,
        /// Largest possible magnitude.
        bound: f64,
    },
}

impl IterationFailure {
    /// The failure in words, with its numbers in this `unit`.
    pub fn in_unit(&self, unit: &str) -> String {
        match self {
            Self::Diverging { residual, smallest } => {
                format!(
                    "diverges: the residual is {residual:.3e} {unit}, after {smallest:.3e} {unit} at best"
                )
            }
            Self::Stagnating { iterations, smallest } => format!(
                "stagnates: the residual did not fall by 1 % below {smallest:.3e} {unit} in {iterations} iterations"
            ),
            Self::RoundingFloor { smallest, floor } => format!(
                "stagnates at {smallest:.3e} {unit}, the rounding floor of the units: rounding errors of their inputs change the \
                 residual by {floor:.3e} {unit}; the tolerance is below what double precision allows"
            ),
            Self::Unbounded { value, bound } => {
                format!("left all bounds: a unit returned {value:.3e} {unit} (limit {bound:.3e} {unit})")
            }
        }
    }

    /// The remedy.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::Diverging { .. } | Self::Stagnating { .. } => {
                "choose another [coupling] acceleration, or change communication_step"
            }
            Self::RoundingFloor { .. } => "raise [coupling] tolerance",
            Self::Unbounded { .. } => {
                "choose an implicit [coupling] scheme, another acceleration, or change communication_step"
            }
        }
    }
}

impl Guard {
    /// Checks an iteration that did not converge: its residual ‖p̃ − p‖₂ of `unknowns` values; `floor` is
    /// the change of the residual by rounding, where it was measured.
    ///
    /// **Errors**: [`IterationFailure::Diverging`], [`IterationFailure::Stagnating`], [`IterationFailure::RoundingFloor`].
    pub fn observe(
        &mut self,
        residual: f64,
        unknowns: usize,
        floor: Option<f64>,
    ) -> Result<(), IterationFailure> {
        let smallest = self.smallest.unwrap_or(f64::INFINITY);
        if self.smallest.is_none() || residual < PROGRESS * self.mark {
            (self.mark, self.since_progress) = (residual, 0);
        } else {
            self.since_progress += 1;
        }
        self.smallest = Some(smallest.min(residual));
        // A residual of zero is no scale for the next.
        let grown = smallest > 0.0 && residual > DIVERGENCE * smallest;
        if grown || !residual.is_finite() {
            Err(IterationFailure::Diverging { residual, smallest })
        } else if self.since_progress >= PATIENCE.max(2 * unknowns) {
            // Quasi-Newton schemes may stagnate until they have differences in as many directions as there are
            // unknowns.
            let (iterations, smallest) = (self.since_progress, smallest.min(residual));
            Err(match floor.filter(|floor| smallest <= FLOORS * floor) {
                Some(floor) => IterationFailure::RoundingFloor { smallest, floor },
                None => IterationFailure::Stagnating { iterations, smallest },
            })
        } else {
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first_complaint(
        residuals: impl Iterator<Item = f64>,
        floor: Option<f64>,
    ) -> Option<(usize, IterationFailure)> {
        let mut guard = Guard::default();
        let mut complaints = residuals.take(400).enumerate();
        complaints.find_map(|(count, residual)| Some((count, guard.observe(residual, 6, floor).err()?)))
    }

    #[test]
    fn slow_convergence_and_bumps_are_let_be() {
        for rate in [0.98f64, 0.995, 0.9995] {
            assert_eq!(first_complaint((0..).map(|k: i32| rate.powi(k)), Some(1.0)), None, "{rate}");
        }
        let bumpy = |k: i32| 0.9f64.powi(k) * if k % 10 == 5 { 1e5 } else { 1.0 };
        assert_eq!(first_complaint((0..).map(bumpy), None), None);
    }

    #[test]
    fn growth_is_divergence_and_rest_is_stagnation() {
        let (count, failure) = first_complaint((0..).map(|k| 26f64.powi(k)), None).expect("it diverges");
        assert_eq!(
            (count, failure),
            (5, IterationFailure::Diverging { residual: 26f64.powi(5), smallest: 1.0 })
        );
        for first in [f64::INFINITY, f64::NAN] {
            let complaint = first_complaint(std::iter::once(first), None);
            assert!(matches!(complaint, Some((0, IterationFailure::Diverging { .. }))), "{complaint:?}");
        }
        let resting = || (0..).map(|k: i32| 1e-9 + 0.1f64.powi(k));
        let (count, failure) = first_complaint(resting(), Some(1e-12)).expect("it rests");
        assert!(
            matches!(failure, IterationFailure::Stagnating { smallest, .. } if smallest < 1.1e-9),
            "{failure:?}"
        );
        assert!((30..50).contains(&count), "{count}");
        let (_, failure) = first_complaint(resting(), Some(1e-10)).expect("it rests");
        assert!(matches!(failure, IterationFailure::RoundingFloor { floor: 1e-10, .. }), "{failure:?}");
    }
}
