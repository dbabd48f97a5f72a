use super::JacobianState;
use super::secants::{SecantCounts, Secants};
use nalgebra::{DMatrix, DVector, Dyn, LU};
use serde::{Deserialize, Serialize};

/// Interface Newton: the Jacobian of the residual is measured once, then used in every step.
///
/// ```text
/// x ← x − ΔX c − J⁻¹ r⊥,  J = ∂r/∂x,  r = ΔR c + r⊥
/// ```
///
/// J is measured in the first step that needs iterations: one iteration for each unknown, in which only that unknown
/// is moved. It is exact as long as the units respond linearly (an elastic dam with sticking cracks). Later,
/// differences between iterations of this and of past steps ([`Secants`]) correct it. A J that cannot be inverted is
/// not used: the guess is then relaxed by a constant factor beside the secants. Convergence is judged by the true
/// residual.
///
/// The units need no derivatives, only states that can be restored. The measurement is part of the log.
///
/// **Source**: a chord Newton method with the multi-secant update of Eyert (1996).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct InterfaceJacobian {
    /// Change of an unknown in the measurement.
    probe: f64,
    /// Factor for the guess without a Jacobian and without secants.
    relaxation: f64,
    secants: Secants,
    stage: Stage,
}

/// Smallest pivot of an invertible Jacobian, as a share of the largest.
const SMALLEST_PIVOT: f64 = 1e-12;

#[derive(Clone, Debug, Serialize, Deserialize)]
enum Stage {
    /// Not measured yet.
    Unknown,
    /// The Jacobian is being measured from this guess and its residual.
    Measuring { guess: Vec<f64>, residual: Vec<f64>, columns: Vec<f64> },
    /// It is measured and inverted.
    Known(Measured),
    /// It cannot be inverted and is not used.
    Singular,
}

/// A Jacobian with its factors. Saved are its columns, whose factors have the same bits again.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(from = "Vec<f64>", into = "Vec<f64>")]
struct Measured {
    columns: Vec<f64>,
    factors: Box<LU<f64, Dyn, Dyn>>,
}

impl From<Vec<f64>> for Measured {
    fn from(columns: Vec<f64>) -> Self {
        let size = columns.len().isqrt();
        let jacobian = DMatrix::from_column_slice(size, size, &columns[..size * size]);
        Self { columns, factors: Box::new(jacobian.lu()) }
    }
}

impl From<Measured> for Vec<f64> {
    fn from(measured: Measured) -> Self {
        measured.columns
    }
}

impl InterfaceJacobian {
    /// Measures with changes `probe` (Pa, not zero) of the unknowns; relaxes by `relaxation` if the Jacobian cannot
    /// be inverted.
    pub fn new(probe: f64, relaxation: f64, secants: Secants) -> Self {
        Self { probe, relaxation, secants, stage: Stage::Unknown }
    }

    /// Whether the last guess was part of the measurement; its residual does not show convergence.
    pub fn measuring(&self) -> bool {
        matches!(self.stage, Stage::Measuring { .. })
    }

    /// The differences in the last guess.
    pub fn secants(&self) -> SecantCounts {
        self.secants.counts()
    }

    /// The differences that correct the Jacobian.
    pub fn secants_mut(&mut self) -> &mut Secants {
        &mut self.secants
    }

    /// What became of the Jacobian.
    pub fn jacobian(&self) -> JacobianState {
        match self.stage {
            Stage::Unknown => JacobianState::None,
            Stage::Measuring { .. } => JacobianState::Measuring,
            Stage::Known(_) => JacobianState::Kept,
            Stage::Singular => JacobianState::Singular,
        }
    }

    /// The factor without a Jacobian.
    pub fn without_model(&self) -> f64 {
        self.relaxation
    }

    /// Begins a communication step; an unfinished measurement starts again.
    pub fn begin_step(&mut self) {
        self.secants.begin_step();
        if self.measuring() {
            self.stage = Stage::Unknown;
        }
    }

    /// Moves `guess` on by means of `residual` = G(guess) − guess.
    pub fn accelerate(&mut self, guess: &mut [f64], residual: &[f64]) {
        let size = guess.len();
        match &mut self.stage {
            Stage::Unknown => {
                let columns = Vec::with_capacity(size * size);
                self.stage = Stage::Measuring { guess: guess.to_vec(), residual: residual.to_vec(), columns };
                guess[0] += self.probe;
            }
            Stage::Measuring { guess: base, residual: from, columns } => {
                let moved = columns.len() / size;
                columns.extend(residual.iter().zip(from.iter()).map(|(r, base)| (r - base) / self.probe));
                guess.copy_from_slice(base);
                if moved + 1 < size {
                    guess[moved + 1] += self.probe;
                    return;
                }
                let (measured, residual) = (Measured::from(std::mem::take(columns)), from.clone());
                let pivots: Vec<f64> = measured.factors.u().diagonal().iter().map(|x| x.abs()).collect();
                let largest = pivots.iter().copied().fold(0.0, f64::max);
                let sound =
                    largest.is_finite() && pivots.iter().all(|pivot| *pivot > SMALLEST_PIVOT * largest);
                self.stage = if sound { Stage::Known(measured) } else { Stage::Singular };
                self.correct(guess, &residual);
            }
            Stage::Known(_) | Stage::Singular => self.correct(guess, residual),
        }
    }

    fn correct(&mut self, guess: &mut [f64], residual: &[f64]) {
        self.secants.observe(guess, residual);
        let known = self.secants.project(residual);
        let mut newton = DVector::from_column_slice(&known.rest);
        match &self.stage {
            // It was found to be invertible.
            Stage::Known(measured) if measured.factors.solve_mut(&mut newton) => {}
            _ if known.columns > 0 => newton.neg_mut(),
            _ => newton *= -self.relaxation,
        }
        for ((x, change), step) in guess.iter_mut().zip(&known.change).zip(newton.iter()) {
            *x -= change + step;
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::acceleration::linear_problem::{SIZE, iterations};
    use crate::acceleration::{Acceleration, AccelerationKind};

    #[test]
    fn a_linear_problem_is_measured_once_and_takes_two_iterations_then() {
        let mut newton = Acceleration::new(AccelerationKind::InterfaceJacobian, 0.1, 1e-3);
        assert_eq!(iterations(&mut newton, 1.0), SIZE + 2);
        for step in 1..5 {
            assert_eq!(iterations(&mut newton, 1.0 + f64::from(step)), 2);
        }
    }

    #[test]
    fn a_residual_that_nothing_moves_leaves_everything_finite() {
        let mut newton = super::InterfaceJacobian::new(1.0, 0.5, super::Secants::new(3, 1e-3));
        let mut x = [1.0, 2.0];
        newton.begin_step();
        for _ in 0..9 {
            newton.accelerate(&mut x, &[1.0, -1.0]);
            assert!(x.iter().all(|x| x.is_finite()));
        }
    }
}
