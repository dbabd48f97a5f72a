use serde::{Deserialize, Serialize};

use crate::error::{DamError, require};

/// How much of the dam's physics is computed. All levels have the same variables and the same interface points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fidelity {
    /// Every element and every contact, explicit in time.
    #[default]
    Dem,
    /// Blocks of elastic modes between nonlinear contacts ([`reduction`](crate::reduction)).
    Reduced {
        /// Modes of each block with its cracks held; `None` for as many as the error estimate asks for.
        modes: Option<usize>,
    },
    /// Blocks that do not deform on a base that moves with the ground. **Unsafe**: the dam's amplification of the ground
    /// motion is missing, and with it most of the sliding.
    RigidBlocks,
    /// The dam without its cracks, linear, by its natural modes.
    Intact {
        /// Natural modes; `None` for as many as the error estimate asks for.
        modes: Option<usize>,
    },
}

impl Fidelity {
    /// Checks the number of modes, and that rigid blocks have a crack to move on.
    ///
    /// **Errors**: [`DamError::OutOfRange`], [`DamError::RigidWithoutCrack`].
    pub fn check(&self, cracks: usize) -> Result<(), DamError> {
        match *self {
            Self::RigidBlocks if cracks == 0 => Err(DamError::RigidWithoutCrack),
            Self::Reduced { modes: Some(modes) } | Self::Intact { modes: Some(modes) } => {
                require(modes > 0, "modes", modes as f64, "at least 1")
            }
            _ => Ok(()),
        }
    }
}
