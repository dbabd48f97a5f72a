use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::{Damping, DampingFrequencies};

/// Kind of damping.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum DampingModel {
    /// Of mass and stiffness, with the ratio at two frequencies.
    #[default]
    Rayleigh,
    /// Of mass, with the ratio at the lower frequency.
    Mass,
    /// Of stiffness, with the ratio at the lower frequency.
    Stiffness,
    /// A share, tanh(π × ratio), of every force out of balance: the ratio at all frequencies, and none in steady sliding;
    /// with `dam.fidelity = "dem"` alone.
    Local,
}

impl DampingModel {
    /// All models, in the order of the enum.
    pub const ALL: [Self; 4] = [Self::Rayleigh, Self::Mass, Self::Stiffness, Self::Local];

    /// The word in a scene file, and in the serialised form.
    pub fn word(self) -> &'static str {
        match self {
            Self::Rayleigh => "rayleigh",
            Self::Mass => "mass",
            Self::Stiffness => "stiffness",
            Self::Local => "local",
        }
    }

    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Rayleigh => "Rayleigh damping",
            Self::Mass => "mass-proportional damping",
            Self::Stiffness => "stiffness-proportional damping",
            Self::Local => "local damping",
        }
    }

    /// Whether it needs the frequencies at which its ratio holds.
    pub fn has_frequencies(self) -> bool {
        self != Self::Local
    }

    /// Whether it is linear, and so available with modes.
    pub fn supports_modes(self) -> bool {
        self != Self::Local
    }

    /// Damping of this kind; none for a ratio of 0, and for a model that has frequencies without any. Local damping has the
    /// coefficient `κ = tanh πξ` of the `ratio` ξ and ignores the `frequencies`.
    pub fn with_ratio(self, ratio: f64, frequencies: Option<DampingFrequencies>) -> Damping {
        match (self, frequencies) {
            _ if ratio == 0.0 => Damping::None,
            (Self::Local, _) => Damping::Local { coefficient: (PI * ratio).tanh() },
            (_, None) => Damping::None,
            (Self::Rayleigh, Some(frequencies)) => Damping::Rayleigh { ratio, frequencies },
            (Self::Mass, Some(frequencies)) => Damping::Mass { ratio, frequencies },
            (Self::Stiffness, Some(frequencies)) => Damping::Stiffness { ratio, frequencies },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_of_the_serialised_form() {
        for model in DampingModel::ALL {
            assert_eq!(serde_json::to_value(model).unwrap(), model.word());
            let damping = model.with_ratio(0.05, Some(DampingFrequencies::default()));
            assert_eq!(damping.model(), Some(model));
            assert!(serde_json::to_value(damping).unwrap()[model.word()].is_object());
        }
    }

    #[test]
    fn damping_has_the_ratio_it_was_made_with() {
        for model in DampingModel::ALL {
            let damping = |ratio: f64| model.with_ratio(ratio, Some(DampingFrequencies::default()));
            assert!((damping(0.05).ratio() - 0.05).abs() < 1e-16);
            assert_eq!(damping(0.0), Damping::None);
            assert_eq!(model.with_ratio(0.05, None) == Damping::None, model.has_frequencies());
        }
    }
}
