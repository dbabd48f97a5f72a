use serde::{Deserialize, Serialize};

/// Aitken's dynamic relaxation: ω ← −ω (r⁻·(r − r⁻)) / ‖r − r⁻‖².
///
/// A communication step begins with the factor that the step before ended with.
///
/// **Source**: Irons and Tuck (1969); Küttler and Wall (2008), eq. 44.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Aitken {
    relaxation: f64,
    previous: Vec<f64>,
}

/// Bounds of the factor; beyond them two residuals were nearly equal or dominated by rounding.
const SMALLEST: f64 = 0.01;
const LARGEST: f64 = 1.5;

impl Aitken {
    /// Starts with the factor `relaxation`.
    pub fn new(relaxation: f64) -> Self {
        Self { relaxation, previous: Vec::new() }
    }

    /// The current relaxation factor.
    pub fn relaxation(&self) -> f64 {
        self.relaxation
    }

    /// Forgets the residuals of the step before.
    pub fn begin_step(&mut self) {
        self.previous.clear();
    }

    /// Takes the newest residual and, from the second residual on, updates the factor.
    pub fn observe(&mut self, residual: &[f64]) {
        if !self.previous.is_empty() {
            let (mut along, mut square) = (0.0, 0.0);
            for (r, old) in residual.iter().zip(&self.previous) {
                along += old * (r - old);
                square += (r - old) * (r - old);
            }
            let factor = -self.relaxation * along / square;
            if factor.is_finite() && factor > 0.0 {
                self.relaxation = factor.clamp(SMALLEST, LARGEST);
            }
        }
        self.previous.clear();
        self.previous.extend_from_slice(residual);
    }
}

#[cfg(test)]
mod tests {
    use crate::acceleration::{Acceleration, AccelerationKind};

    /// Solves p = G p + 1 and counts the iterations to 1e-12.
    fn iterations(kind: AccelerationKind, gain: f64) -> usize {
        let mut acceleration = Acceleration::new(kind, 0.5, 1.0);
        let mut p = [0.0, 0.0];
        acceleration.begin_step();
        for count in 1..200 {
            let residual = p.map(|p| gain * p + 1.0 - p);
            if residual[0].abs() < 1e-12 {
                return count;
            }
            acceleration.accelerate(&mut p, &residual);
        }
        usize::MAX
    }

    #[test]
    fn a_linear_problem_with_one_eigenvalue_takes_three_iterations() {
        for gain in [-0.9, -0.12, 0.3] {
            assert_eq!(iterations(AccelerationKind::Aitken, gain), 3, "gain {gain}");
        }
        // Even where the plain iteration diverges.
        assert_eq!(iterations(AccelerationKind::Aitken, -5.0), 3);
        assert!(iterations(AccelerationKind::Constant, -0.12) > 10);
    }

    #[test]
    fn equal_residuals_leave_the_factor_alone() {
        let mut aitken = super::Aitken::new(0.7);
        aitken.observe(&[1.0, 2.0]);
        aitken.observe(&[1.0, 2.0]);
        assert_eq!(aitken.relaxation(), 0.7);
        aitken.observe(&[0.0, 0.0]);
        assert_eq!(aitken.relaxation(), 0.7);
    }
}
