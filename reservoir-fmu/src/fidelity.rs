use serde::{Deserialize, Serialize};

/// Model of the water.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Fidelity {
    /// Westergaard's added mass, without memory.
    Westergaard,
    /// The same with the exact profile of incompressible water before a vertical face, which the parabola approximates.
    WestergaardExact,
    /// Incompressible water by boundary elements: the added mass of the real section, without memory.
    Incompressible,
    /// Compressible water.
    #[default]
    Compressible,
}

/// Profile of Westergaard's added mass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Profile {
    /// ⅞ ρ √(h(h − y)).
    #[default]
    Parabola,
    /// The series of incompressible water before a vertical face, which the parabola approximates.
    Exact,
}

impl Fidelity {
    /// All models, in the order of the enum.
    pub const ALL: [Self; 4] =
        [Self::Westergaard, Self::WestergaardExact, Self::Incompressible, Self::Compressible];

    /// Westergaard's added mass with this profile: `p = −⅞ ρ √(h(h − y)) a_n` (Westergaard 1933), or the
    /// [series](crate::analytical::westergaard_1933::series_pressure) that it approximates.
    pub fn westergaard(profile: Profile) -> Self {
        match profile {
            Profile::Parabola => Self::Westergaard,
            Profile::Exact => Self::WestergaardExact,
        }
    }

    /// The word in the serialised form. In a scene file both of Westergaard's profiles are `"westergaard"`, with the word of
    /// their [`Profile`] at a key of its own.
    pub fn word(self) -> &'static str {
        match self {
            Self::Westergaard => "westergaard",
            Self::WestergaardExact => "westergaard-exact",
            Self::Incompressible => "incompressible",
            Self::Compressible => "compressible",
        }
    }

    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Westergaard => "Westergaard's added mass",
            Self::WestergaardExact => "Westergaard's added mass, exact profile",
            Self::Incompressible => "incompressible water",
            Self::Compressible => "compressible water",
        }
    }

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

    /// Whether the pressure follows from a solved system (`∇²p = 0`, or `∇²p = p̈/c²` with radiation upstream and an absorbing
    /// bed); otherwise it is given by a formula.
    pub fn is_solved(self) -> bool {
        matches!(self, Self::Incompressible | Self::Compressible)
    }

    /// Whether communication steps may have any length, whatever the [`Method`](crate::Method): water without memory.
    pub fn supports_variable_steps(self) -> bool {
        !self.has_memory()
    }

    /// Whether the surface may have gravity waves.
    pub fn supports_surface_waves(self) -> bool {
        self.is_solved()
    }
}

impl Profile {
    /// Both profiles, in the order of the enum.
    pub const ALL: [Self; 2] = [Self::Parabola, Self::Exact];

    /// The word in a scene file, and in the serialised form.
    pub fn word(self) -> &'static str {
        match self {
            Self::Parabola => "parabola",
            Self::Exact => "exact",
        }
    }

    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Parabola => "Westergaard's parabola",
            Self::Exact => "exact profile",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_of_the_serialised_form() {
        for fidelity in Fidelity::ALL {
            assert_eq!(serde_json::to_value(fidelity).unwrap(), fidelity.word());
        }
        for profile in Profile::ALL {
            assert_eq!(serde_json::to_value(profile).unwrap(), profile.word());
        }
    }
}
