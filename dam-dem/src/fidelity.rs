use serde::{Deserialize, Serialize};

use crate::error::{DamError, require};

/// Level of detail of the dam model. All levels have the same variables and the same interface points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fidelity {
    /// Full model: every element and every contact, with explicit time integration.
    #[default]
    Dem,
    /// Blocks represented by elastic modes, between nonlinear contacts ([`reduction`](crate::reduction)).
    Reduced {
        /// Number of modes of each block with the nodes on its cracks held; `None` for as many as the error estimate
        /// requires.
        modes: Option<usize>,
    },
    /// Rigid blocks above a base that moves with the ground. **Unsafe**: the dam does not amplify the ground
    /// motion, so that most of the sliding is missing.
    RigidBlocks,
    /// The linear dam without cracks, represented by its natural modes.
    Intact {
        /// Number of natural modes; `None` for as many as the error estimate requires.
        modes: Option<usize>,
    },
}

impl Fidelity {
    /// Whether its cracks can open and slide.
    pub fn is_cracked(&self) -> bool {
        !matches!(self, Self::Intact { .. })
    }

    /// Checks the number of modes, and that there is a crack if the blocks are rigid.
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
