use serde::{Deserialize, Serialize};

/// Model of the water.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fidelity {
    /// Added mass `p = −⅞ ρ √(h(h − y)) a_n` at every point (Westergaard 1933): no waves, no memory.
    Westergaard,
    /// Incompressible water by boundary elements, `∇²p = 0`: added mass of the real section, no waves, no
    /// memory. Sound speed and bed have no effect.
    Incompressible,
    /// Compressible water by boundary elements, with radiation upstream and an absorbing bed.
    Compressible,
}

impl Fidelity {
    /// The value of the variable `fidelity`.
    pub fn code(self) -> f64 {
        match self {
            Self::Westergaard => 1.0,
            Self::Incompressible => 2.0,
            Self::Compressible => 3.0,
        }
    }

    /// Whether pressure depends on earlier motion; without memory it is `−A a`, A by
    /// [`added_mass`](crate::added_mass()).
    pub fn has_memory(self) -> bool {
        self == Self::Compressible
    }
}
