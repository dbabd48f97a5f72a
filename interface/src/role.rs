use crate::{Variable, variables};
use serde::{Deserialize, Serialize};

/// What a unit is at its interfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// It answers pressure with motion.
    Structure,
    /// It answers motion with pressure.
    Fluid,
}

impl Role {
    /// The built-in unit of this role.
    pub fn name(self) -> &'static str {
        match self {
            Self::Structure => "dam",
            Self::Fluid => "reservoir",
        }
    }

    /// The variables of the contract.
    pub fn variables(self) -> &'static [Variable] {
        match self {
            Self::Structure => variables::dam::ALL,
            Self::Fluid => variables::reservoir::ALL,
        }
    }

    /// Inputs and outputs without which there is no interface.
    pub fn needed(self) -> (&'static [&'static str], &'static [&'static str]) {
        match self {
            Self::Structure => {
                (&["interface_pressure"], &["interface_displacement", "interface_acceleration"])
            }
            Self::Fluid => (&["interface_acceleration"], &["interface_pressure"]),
        }
    }
}
