use serde::{Deserialize, Serialize};

/// Model of the water.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fidelity {
    /// Added mass `p = −⅞ ρ √(h(h − y)) a_n` (Westergaard 1933): no waves, no memory.
    Westergaard,
    /// The same with the exact profile of incompressible water before a vertical face, which the parabola
    /// approximates ([`series_pressure`](crate::analytical::westergaard_1933::series_pressure)).
    WestergaardExact,
    /// Incompressible water by boundary elements, `∇²p = 0`: added mass of the real section, no waves, no
    /// memory. Sound speed and bed absorption have no effect.
    Incompressible,
    /// Compressible water, with radiation upstream and an absorbing bed.
    Compressible,
}

impl Fidelity {
    /// The value of the variable `fidelity`.
    pub fn code(self) -> f64 {
        match self {
            Self::Westergaard => 1.0,
            Self::Incompressible => 2.0,
            Self::Compressible => 3.0,
            Self::WestergaardExact => 4.0,
        }
    }

    /// Whether pressure depends on earlier motion; without memory it is `−A a`, with A from
    /// [`added_mass`](crate::added_mass()).
    pub fn has_memory(self) -> bool {
        self == Self::Compressible
    }

    /// Whether the pressure follows from a solved system; otherwise it is given by a formula.
    pub fn is_solved(self) -> bool {
        matches!(self, Self::Incompressible | Self::Compressible)
    }
}
