//! Accelerations of the fixed-point iteration, a file each.
//!
//! With the fixed point p = G(p) and the residual r = G(p) − p, an acceleration turns the
//! residual into the next guess. It never logs; [`Acceleration::relaxation`] tells what it did.

mod aitken;

pub use aitken::Aitken;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which acceleration a scene picks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AccelerationKind {
    /// p ← p + ω r with a constant ω.
    Constant,
    /// p ← p + ω r with Aitken's ω from the last two residuals.
    Aitken,
}

/// A scheme for the next guess.
#[derive(Clone, Debug)]
pub enum Acceleration {
    /// Constant relaxation ω.
    Constant(f64),
    /// Aitken's dynamic relaxation.
    Aitken(Aitken),
}

impl Acceleration {
    /// The acceleration of `kind` with first (or constant) relaxation factor `relaxation`.
    pub fn new(kind: AccelerationKind, relaxation: f64) -> Self {
        match kind {
            AccelerationKind::Constant => Self::Constant(relaxation),
            AccelerationKind::Aitken => Self::Aitken(Aitken::new(relaxation)),
        }
    }

    /// Begins the iteration of a new communication step.
    pub fn begin_step(&mut self) {
        if let Self::Aitken(aitken) = self {
            aitken.begin_step();
        }
    }

    /// Moves `guess` on by means of `residual` = G(guess) − guess.
    pub fn accelerate(&mut self, guess: &mut [f64], residual: &[f64]) {
        if let Self::Aitken(aitken) = self {
            aitken.observe(residual);
        }
        let relaxation = self.relaxation();
        for (p, r) in guess.iter_mut().zip(residual) {
            *p += relaxation * r;
        }
    }

    /// The relaxation factor used last.
    pub fn relaxation(&self) -> f64 {
        match self {
            Self::Constant(relaxation) => *relaxation,
            Self::Aitken(aitken) => aitken.relaxation(),
        }
    }
}
