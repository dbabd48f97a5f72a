use serde::{Deserialize, Serialize};

/// Kinematics of the elements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Kinematics {
    /// Small strain and rotation.
    Small,
    /// Small strain, rotation of any size.
    #[default]
    Corotational,
}

impl Kinematics {
    /// Both kinematics, in the order of the enum.
    pub const ALL: [Self; 2] = [Self::Small, Self::Corotational];

    /// The word in a scene file, and in the serialised form.
    pub fn word(self) -> &'static str {
        match self {
            Self::Small => "small",
            Self::Corotational => "corotational",
        }
    }

    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Small => "small rotations",
            Self::Corotational => "finite rotations",
        }
    }

    /// Whether rotations may be finite: the strain is then the Biot strain `U − I` behind the exact rotation of every element
    /// ([`CrossedCells`](crate::element::CrossedCells)), otherwise `sym ∇u`.
    pub fn has_finite_rotations(self) -> bool {
        self == Self::Corotational
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_of_the_serialised_form() {
        for kinematics in Kinematics::ALL {
            assert_eq!(serde_json::to_value(kinematics).unwrap(), kinematics.word());
        }
    }
}
