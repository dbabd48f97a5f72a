use super::secants::{SecantCounts, Secants};
use serde::{Deserialize, Serialize};

/// Interface quasi-Newton with the inverse Jacobian from a least-squares model, of this and of past steps.
///
/// ```text
/// x ← x − ΔX c + r⊥,  r = ΔR c + r⊥
/// ```
///
/// with the residual r = G(x) − x and differences between the iterations of a step ([`Secants`]). Without any, the
/// guess is relaxed by a constant factor.
///
/// **Source**: Degroote, Bathe and Vierendeels (2009); Degroote et al. (2010) for the reuse of past steps.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct IqnIls {
    /// Relaxation factor without a model.
    without_model: f64,
    /// The factor applied last: 1 with a model.
    relaxation: f64,
    secants: Secants,
}

impl IqnIls {
    /// Starts without a model; relaxes by `relaxation` until it has one.
    pub fn new(relaxation: f64, secants: Secants) -> Self {
        Self { without_model: relaxation, relaxation, secants }
    }

    /// The factor applied last: 1 with a model.
    pub fn relaxation(&self) -> f64 {
        self.relaxation
    }

    /// The differences in the last guess.
    pub fn secants(&self) -> SecantCounts {
        self.secants.counts()
    }

    /// The model.
    pub fn secants_mut(&mut self) -> &mut Secants {
        &mut self.secants
    }

    /// The factor without a model.
    pub fn without_model(&self) -> f64 {
        self.without_model
    }

    /// Begins a communication step.
    pub fn begin_step(&mut self) {
        self.secants.begin_step();
    }

    /// Moves `guess` on by means of `residual` = G(guess) − guess.
    pub fn accelerate(&mut self, guess: &mut [f64], residual: &[f64]) {
        self.secants.observe(guess, residual);
        let known = self.secants.project(residual);
        self.relaxation = if known.columns > 0 { 1.0 } else { self.without_model };
        for ((x, change), rest) in guess.iter_mut().zip(&known.change).zip(&known.rest) {
            *x += self.relaxation * rest - change;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Secants;
    use crate::acceleration::linear_problem::{SIZE, iterations};
    use crate::acceleration::{Acceleration, AccelerationKind};

    #[test]
    fn a_linear_problem_takes_as_many_iterations_as_it_has_unknowns_and_two_with_reuse() {
        let mut iqn = Acceleration::new(AccelerationKind::IqnIls, 0.1, 1.0);
        let first = iterations(&mut iqn, 1.0);
        assert!((SIZE..=SIZE + 2).contains(&first), "{first}");
        for step in 1..5 {
            // The model holds for another load too.
            let again = iterations(&mut iqn, 1.0 + f64::from(step));
            assert!(again <= 2, "{again}");
        }
        assert_eq!(iterations(&mut Acceleration::new(AccelerationKind::Constant, 0.1, 1.0), 1.0), usize::MAX);
    }

    #[test]
    fn without_reused_steps_every_step_takes_as_many_iterations_as_the_first() {
        let mut iqn = Acceleration::new(AccelerationKind::IqnIls, 0.1, 1.0).reusing(0);
        for _ in 0..3 {
            let count = iterations(&mut iqn, 1.0);
            assert!((SIZE..=SIZE + 2).contains(&count), "{count}");
        }
    }

    #[test]
    fn equal_and_zero_residuals_relax_and_leave_everything_finite() {
        let mut iqn = super::IqnIls::new(0.5, Secants::new(4, 1e-2));
        let mut x = [1.0, 2.0];
        iqn.begin_step();
        iqn.accelerate(&mut x, &[1.0, 0.0]);
        assert_eq!(x, [1.5, 2.0]);
        iqn.accelerate(&mut x, &[1.0, 0.0]);
        assert_eq!(x, [2.0, 2.0], "the residual did not change: no model");
        iqn.accelerate(&mut x, &[0.0, 0.0]);
        assert_eq!(x, [2.0, 2.0]);
        iqn.accelerate(&mut x, &[1e-300, 0.0]);
        assert!(x.iter().all(|x| x.is_finite()));
    }
}
