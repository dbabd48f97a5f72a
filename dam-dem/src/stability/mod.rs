//! Stability of the dam by the gravity method: rigid parts above joints without tension.

use serde::{Deserialize, Serialize};

mod authority;
mod gravity_method;
pub mod joint;
mod sliding_block;

pub use authority::{Authority, DCR, DcrCriterion, Requirement, Status, Zone, required};
pub use gravity_method::{DamJoint, GravityMethod, LoadCase, LoadedJoint};
pub use joint::{End, Joint, JointLoad, JointState, Mode, ResultantZone, Strength, resultant_zone};
pub use sliding_block::SlidingBlock;

/// Combination of loads, by which authorities set the required factors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum LoadCombination {
    /// Loads of normal operation.
    #[default]
    Usual,
    /// Rare static loads, such as a flood or drains out of service.
    Unusual,
    /// The largest static loads, such as the probable maximum flood.
    Extreme,
    /// Normal operation and the earthquake.
    Seismic,
    /// Static loads on the joint as the earthquake leaves it.
    PostEarthquake,
}

impl LoadCombination {
    /// All combinations, in the order of the enum.
    pub const ALL: [Self; 5] =
        [Self::Usual, Self::Unusual, Self::Extreme, Self::Seismic, Self::PostEarthquake];

    /// The word in a scene file, and in the serialised form.
    pub fn word(self) -> &'static str {
        match self {
            Self::Usual => "usual",
            Self::Unusual => "unusual",
            Self::Extreme => "extreme",
            Self::Seismic => "seismic",
            Self::PostEarthquake => "post-earthquake",
        }
    }

    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Usual => "usual loads",
            Self::Unusual => "unusual loads",
            Self::Extreme => "extreme loads",
            Self::Seismic => "earthquake",
            Self::PostEarthquake => "after the earthquake",
        }
    }
}

#[cfg(test)]
mod tests {
    use serde::de::IntoDeserializer;
    use serde::de::value::{Error, StrDeserializer};

    use super::*;

    #[test]
    fn words_are_those_of_the_serialised_form() {
        for combination in LoadCombination::ALL {
            let word: StrDeserializer<'_, Error> = combination.word().into_deserializer();
            assert_eq!(LoadCombination::deserialize(word), Ok(combination));
            assert!(!combination.label().is_empty());
        }
    }
}
