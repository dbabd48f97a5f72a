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

/// How much of the dam is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum FidelityLevel {
    /// Every element and every contact.
    #[default]
    Dem,
    /// Blocks of elastic modes between the same contacts, at a quarter of the cost at 5 m and a tenth at 2.5 m.
    Reduced,
    /// Blocks that do not deform: **unsafe**, the dam's own amplification is missing.
    RigidBlocks,
    /// The dam without its cracks, linear, by modes.
    Intact,
}

impl FidelityLevel {
    /// All levels, in the order of the enum.
    pub const ALL: [Self; 4] = [Self::Dem, Self::Reduced, Self::RigidBlocks, Self::Intact];

    /// The word in a scene file, and in the serialised form.
    pub fn word(self) -> &'static str {
        match self {
            Self::Dem => "dem",
            Self::Reduced => "reduced",
            Self::RigidBlocks => "rigid-blocks",
            Self::Intact => "intact",
        }
    }

    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Dem => "distinct elements",
            Self::Reduced => "reduced blocks",
            Self::RigidBlocks => "rigid blocks (unsafe)",
            Self::Intact => "intact dam",
        }
    }

    /// Whether every element is evaluated in every time step; otherwise blocks, or the dam, move in given shapes.
    pub fn has_elements(self) -> bool {
        self == Self::Dem
    }

    /// Whether a number of elastic modes can be chosen.
    pub fn has_modes(self) -> bool {
        matches!(self, Self::Reduced | Self::Intact)
    }

    /// Whether cracks can open and slide.
    pub fn is_cracked(self) -> bool {
        self != Self::Intact
    }

    /// Whether blocks deform, so that the dam amplifies the motion of the ground.
    pub fn is_deformable(self) -> bool {
        self != Self::RigidBlocks
    }

    /// This level with a number of `modes`, which levels without a choice of modes ignore; `None` for as many as the error
    /// estimate requires.
    pub fn with_modes(self, modes: Option<usize>) -> Fidelity {
        match self {
            Self::Dem => Fidelity::Dem,
            Self::Reduced => Fidelity::Reduced { modes },
            Self::RigidBlocks => Fidelity::RigidBlocks,
            Self::Intact => Fidelity::Intact { modes },
        }
    }
}

impl Fidelity {
    /// The level without its number of modes.
    pub fn level(&self) -> FidelityLevel {
        match self {
            Self::Dem => FidelityLevel::Dem,
            Self::Reduced { .. } => FidelityLevel::Reduced,
            Self::RigidBlocks => FidelityLevel::RigidBlocks,
            Self::Intact { .. } => FidelityLevel::Intact,
        }
    }

    /// The chosen number of modes, if there is one.
    pub fn modes(&self) -> Option<usize> {
        match *self {
            Self::Reduced { modes } | Self::Intact { modes } => modes,
            Self::Dem | Self::RigidBlocks => None,
        }
    }

    /// Whether its cracks can open and slide.
    pub fn is_cracked(&self) -> bool {
        self.level().is_cracked()
    }

    /// Checks the number of modes, and that there is a crack if the blocks are rigid.
    ///
    /// **Errors**: [`DamError::OutOfRange`], [`DamError::RigidWithoutCrack`].
    pub fn check(&self, cracks: usize) -> Result<(), DamError> {
        if cracks == 0 && !self.level().is_deformable() {
            return Err(DamError::RigidWithoutCrack);
        }
        match self.modes() {
            Some(modes) => require(modes > 0, "modes", modes as f64, "at least 1"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_of_the_serialised_form() {
        for level in FidelityLevel::ALL {
            assert_eq!(serde_json::to_value(level).unwrap(), level.word());
            let (fidelity, modes) = (level.with_modes(Some(3)), level.has_modes().then_some(3));
            assert_eq!((fidelity.level(), fidelity.modes()), (level, modes));
            let serialised = serde_json::to_value(fidelity).unwrap();
            assert!(serialised == level.word() || serialised[level.word()]["modes"] == 3);
        }
    }
}
