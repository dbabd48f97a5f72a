//! Accelerations of the fixed-point iteration, one file each.
//!
//! With the fixed point p = G(p) and the residual r = G(p) − p, an acceleration turns the residual into the next
//! guess. It never logs; [`Acceleration::correction`] tells how it came about.

mod aitken;
mod filtered_qr;
mod interface_jacobian;
mod iqn_ils;
mod secants;

pub use aitken::Aitken;
pub use interface_jacobian::InterfaceJacobian;
pub use iqn_ils::IqnIls;
pub use secants::{Projection, SecantCounts, Secants};

use serde::{Deserialize, Serialize};

/// The acceleration that a scene chooses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum AccelerationKind {
    /// p ← p + ω r with a constant ω.
    Constant,
    /// p ← p + ω r with Aitken's ω from the last two residuals.
    Aitken,
    /// Quasi-Newton: the inverse Jacobian by least squares from the iterations of this and of past steps.
    IqnIls,
    /// Interface Newton: the Jacobian is measured once and corrected by the iterations of this and of past steps.
    InterfaceJacobian,
}

/// What became of a measured Jacobian.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum JacobianState {
    /// None is used, or none yet.
    #[default]
    None,
    /// It is being measured.
    Measuring,
    /// It was measured, in this window or in an earlier one, and is used.
    Kept,
    /// It cannot be inverted and is not used.
    Singular,
}

/// How a guess came about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    /// The acceleration in charge.
    pub acceleration: AccelerationKind,
    /// Relaxation factor.
    pub relaxation: f64,
    /// Differences of past iterations.
    pub secants: SecantCounts,
    /// The Jacobian.
    pub jacobian: JacobianState,
}

impl AccelerationKind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Constant, Self::Aitken, Self::IqnIls, Self::InterfaceJacobian];

    /// The word for it in scenes and logs.
    pub fn word(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Aitken => "aitken",
            Self::IqnIls => "iqn-ils",
            Self::InterfaceJacobian => "interface-jacobian",
        }
    }
}

impl JacobianState {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::None, Self::Measuring, Self::Kept, Self::Singular];

    /// The word for it in logs.
    pub fn word(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Measuring => "measuring",
            Self::Kept => "kept",
            Self::Singular => "singular",
        }
    }
}

/// A scheme for the next guess.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Acceleration {
    /// Constant relaxation ω.
    Constant(f64),
    /// Aitken's dynamic relaxation.
    Aitken(Aitken),
    /// Interface quasi-Newton.
    IqnIls(IqnIls),
    /// Interface Newton.
    InterfaceJacobian(InterfaceJacobian),
}

/// Default number of past communication steps whose differences are reused ([`Acceleration::reusing`]).
pub const REUSED_STEPS: u64 = 30;
/// Least independent share of a difference that is used.
const FILTER: f64 = 1e-3;

impl Acceleration {
    /// The acceleration of `kind` with first (or constant) relaxation factor `relaxation`; unknowns (Pa) are moved by `probe`
    /// (not zero) where a Jacobian is measured.
    pub fn new(kind: AccelerationKind, relaxation: f64, probe: f64) -> Self {
        let secants = Secants::new(REUSED_STEPS, FILTER);
        match kind {
            AccelerationKind::Constant => Self::Constant(relaxation),
            AccelerationKind::Aitken => Self::Aitken(Aitken::new(relaxation)),
            AccelerationKind::IqnIls => Self::IqnIls(IqnIls::new(relaxation, secants)),
            AccelerationKind::InterfaceJacobian => {
                Self::InterfaceJacobian(InterfaceJacobian::new(probe, relaxation, secants))
            }
        }
    }

    /// The same with this number of past communication steps whose iterations are reused; relaxations have no past.
    pub fn reusing(mut self, steps: u64) -> Self {
        if let Some(secants) = self.secants_mut() {
            secants.reuse(steps);
        }
        self
    }

    /// Begins the iteration of a new communication step.
    pub fn begin_step(&mut self) {
        match self {
            Self::Constant(_) => {}
            Self::Aitken(aitken) => aitken.begin_step(),
            Self::IqnIls(iqn) => iqn.begin_step(),
            Self::InterfaceJacobian(newton) => newton.begin_step(),
        }
    }

    /// Moves `guess` on by means of `residual` = G(guess) − guess.
    pub fn accelerate(&mut self, guess: &mut [f64], residual: &[f64]) {
        match self {
            Self::Constant(_) => {}
            Self::Aitken(aitken) => aitken.observe(residual),
            Self::IqnIls(iqn) => return iqn.accelerate(guess, residual),
            Self::InterfaceJacobian(newton) => return newton.accelerate(guess, residual),
        }
        let relaxation = self.correction().relaxation;
        for (p, r) in guess.iter_mut().zip(residual) {
            *p += relaxation * r;
        }
    }

    /// Takes the change of a residual by rounding.
    pub fn set_floor(&mut self, floor: f64) {
        if let Some(secants) = self.secants_mut() {
            secants.set_floor(floor);
        }
    }

    /// Forgets past iterations; a measured Jacobian is kept.
    pub fn forget(&mut self) {
        if let Some(secants) = self.secants_mut() {
            secants.forget();
        }
    }

    /// What takes over where this acceleration brings no convergence, from `stage` 0 on: the same without its past,
    /// IQN-ILS, Aitken's relaxation. A relaxation has no past that could mislead it, and nothing takes over.
    pub fn fallback(&self, stage: usize) -> Option<Self> {
        let (relaxation, measured) = match self {
            Self::Constant(_) | Self::Aitken(_) => return None,
            Self::IqnIls(iqn) => (iqn.without_model(), false),
            Self::InterfaceJacobian(newton) => (newton.without_model(), true),
        };
        let other = |kind| Some(Self::new(kind, relaxation, 1.0));
        match stage {
            0 => {
                let mut without_past = self.clone();
                without_past.forget();
                Some(without_past)
            }
            1 if measured => other(AccelerationKind::IqnIls),
            1 => other(AccelerationKind::Aitken),
            2 if measured => other(AccelerationKind::Aitken),
            _ => None,
        }
    }

    fn secants_mut(&mut self) -> Option<&mut Secants> {
        match self {
            Self::Constant(_) | Self::Aitken(_) => None,
            Self::IqnIls(iqn) => Some(iqn.secants_mut()),
            Self::InterfaceJacobian(newton) => Some(newton.secants_mut()),
        }
    }

    /// How the last guess came about.
    pub fn correction(&self) -> Correction {
        let none = SecantCounts::default;
        let (acceleration, relaxation, secants, jacobian) = match self {
            Self::Constant(relaxation) => {
                (AccelerationKind::Constant, *relaxation, none(), JacobianState::None)
            }
            Self::Aitken(aitken) => {
                (AccelerationKind::Aitken, aitken.relaxation(), none(), JacobianState::None)
            }
            Self::IqnIls(iqn) => {
                (AccelerationKind::IqnIls, iqn.relaxation(), iqn.secants(), JacobianState::None)
            }
            Self::InterfaceJacobian(newton) => {
                (AccelerationKind::InterfaceJacobian, 1.0, newton.secants(), newton.jacobian())
            }
        };
        Correction { acceleration, relaxation, secants, jacobian }
    }

    /// Whether the last guess served a measurement, not convergence.
    pub fn measuring(&self) -> bool {
        matches!(self, Self::InterfaceJacobian(newton) if newton.measuring())
    }
}

/// A linear problem for tests: G(x) = A x + b, where A is far from a multiple of the unit matrix and the plain
/// iteration diverges.
#[cfg(test)]
mod linear_problem {
    use super::Acceleration;

    pub const SIZE: usize = 8;

    fn answer(x: &[f64], load: f64) -> Vec<f64> {
        (0..SIZE)
            .map(|i| {
                let along = |j: usize| {
                    (0.7 * (i * i + 3 * j * j + i * j) as f64).sin() - if i == j { 1.5 } else { 0.0 }
                };
                load * (i as f64).cos() + (0..SIZE).map(|j| along(j) * x[j]).sum::<f64>()
            })
            .collect()
    }

    /// Iterations of one step to 1e-9.
    pub fn iterations(acceleration: &mut Acceleration, load: f64) -> usize {
        let mut x = vec![0.0; SIZE];
        acceleration.begin_step();
        for count in 1..100 {
            let residual: Vec<f64> = answer(&x, load).iter().zip(&x).map(|(g, x)| g - x).collect();
            if residual.iter().all(|r| r.abs() < 1e-9) {
                return count;
            }
            acceleration.accelerate(&mut x, &residual);
        }
        usize::MAX
    }
}
