/// Growth of the residual over the smallest of the step that counts as divergence.
const DIVERGENCE: f64 = 1e6;
/// Iterations without a residual below this share of the smallest that count as stagnation.
const PATIENCE: u32 = 30;
const PROGRESS: f64 = 0.99;
/// Equal answers to different guesses that count as frozen.
const FROZEN: u32 = 3;

/// Watches the iterations of a communication step that has not converged: will it ever?
///
/// It never declares convergence; it only tells, and names, when going on is in vain.
#[derive(Clone, Debug, Default)]
pub struct Guard {
    smallest: Option<f64>,
    since_progress: u32,
    answered: Vec<f64>,
    given: Vec<f64>,
    equal_answers: u32,
}

/// Why a communication step will not converge.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Hopeless {
    /// The residual grows without bound.
    #[error("diverges: the residual is {residual:.3e} Pa, it has been {smallest:.3e} Pa")]
    Diverging {
        /// Residual of the last iteration, Pa.
        residual: f64,
        /// Smallest residual of the step, Pa.
        smallest: f64,
    },
    /// The residual gets no smaller.
    #[error("stagnates: in {PATIENCE} iterations the residual fell no further than {smallest:.3e} Pa")]
    Stagnating {
        /// Smallest residual of the step, Pa.
        smallest: f64,
    },
    /// A unit answers different requests with the same.
    #[error(
        "is frozen: {FROZEN} times the reservoir's answer was the same to different pressures of the dam"
    )]
    Frozen,
}

impl Guard {
    /// Looks at an iteration that did not converge: residual ‖p̃ − p‖₂ (Pa), pressure given to the dam and answered by
    /// the reservoir (Pa).
    ///
    /// **Errors**: [`Hopeless`].
    pub fn observe(&mut self, residual: f64, given: &[f64], answered: &[f64]) -> Result<(), Hopeless> {
        let smallest = self.smallest.unwrap_or(f64::INFINITY);
        if residual < PROGRESS * smallest {
            self.since_progress = 0;
        } else {
            self.since_progress += 1;
        }
        self.smallest = Some(smallest.min(residual));
        let same = self.answered == answered && self.given != given;
        self.equal_answers = if same { self.equal_answers + 1 } else { 0 };
        self.answered.clear();
        self.answered.extend_from_slice(answered);
        self.given.clear();
        self.given.extend_from_slice(given);
        // A residual of zero says nothing of the size of the next.
        if smallest > 0.0 && residual > DIVERGENCE * smallest {
            Err(Hopeless::Diverging { residual, smallest })
        } else if self.equal_answers >= FROZEN {
            Err(Hopeless::Frozen)
        } else if self.since_progress >= PATIENCE {
            Err(Hopeless::Stagnating { smallest: smallest.min(residual) })
        } else {
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first_complaint(residuals: impl Iterator<Item = f64>) -> Option<(usize, Hopeless)> {
        let mut guard = Guard::default();
        for (count, residual) in residuals.take(200).enumerate() {
            let p = [count as f64];
            if let Err(hopeless) = guard.observe(residual, &p, &[residual + p[0]]) {
                return Some((count, hopeless));
            }
        }
        None
    }

    #[test]
    fn slow_convergence_and_bumps_are_let_be() {
        assert_eq!(first_complaint((0..).map(|k: i32| 0.98f64.powi(k))), None);
        let bumpy = |k: i32| 0.9f64.powi(k) * if k % 10 == 5 { 1e5 } else { 1.0 };
        assert_eq!(first_complaint((0..).map(bumpy)), None);
    }

    #[test]
    fn growth_is_divergence_and_rest_is_stagnation() {
        let (count, hopeless) = first_complaint((0..).map(|k| 26f64.powi(k))).expect("it diverges");
        assert_eq!((count, hopeless), (5, Hopeless::Diverging { residual: 26f64.powi(5), smallest: 1.0 }));
        let (count, hopeless) = first_complaint((0..).map(|k: i32| 1e-9 + 0.1f64.powi(k))).expect("it rests");
        assert!(matches!(hopeless, Hopeless::Stagnating { smallest } if smallest < 1.1e-9), "{hopeless}");
        assert!((30..50).contains(&count), "{count}");
    }

    #[test]
    fn an_answer_that_never_changes_is_frozen_only_if_the_question_does() {
        let mut guard = Guard::default();
        let mut seen = (0..9).map(|k| guard.observe(1.0, &[f64::from(k)], &[5.0]));
        assert_eq!(seen.position(|outcome| outcome == Err(Hopeless::Frozen)), Some(3));
        let mut guard = Guard::default();
        assert!((0..9).all(|_| guard.observe(1.0, &[2.0], &[5.0]).is_ok()));
    }
}
