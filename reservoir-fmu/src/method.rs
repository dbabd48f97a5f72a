use crate::convolution::Rule;
use serde::{Deserialize, Serialize};

/// How compressible water is stepped in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// `"recursive"` where its fit has an error and a loss below 1e-3, or where steps vary; else `"radau2"`.
    #[default]
    Automatic,
    /// Convolution quadrature by BDF2.
    Bdf2,
    /// Convolution quadrature by the trapezoidal rule.
    Trapezoid,
    /// Convolution quadrature by Radau IIA of two stages.
    Radau2,
    /// Convolution quadrature by Radau IIA of three stages.
    Radau3,
    /// A recursion fitted to the frequency response, of constant cost per step and for steps of any length; not with gravity
    /// waves, nor over an almost rigid bed (reflection coefficient of about 0.995 or more, except a level bed with exactly 1).
    Recursive,
    /// Finite elements with a Sommerfeld end.
    FiniteElements,
}

impl Method {
    /// All methods, in the order of the enum.
    pub const ALL: [Self; 7] = [
        Self::Automatic,
        Self::Bdf2,
        Self::Trapezoid,
        Self::Radau2,
        Self::Radau3,
        Self::Recursive,
        Self::FiniteElements,
    ];

    /// The word in a scene file, and in the serialised form.
    pub fn word(self) -> &'static str {
        match self {
            Self::Automatic => "automatic",
            Self::Bdf2 => "bdf2",
            Self::Trapezoid => "trapezoid",
            Self::Radau2 => "radau2",
            Self::Radau3 => "radau3",
            Self::Recursive => "recursive",
            Self::FiniteElements => "finite-elements",
        }
    }

    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Automatic => "recursion or convolution",
            Self::Bdf2 => "convolution by BDF2",
            Self::Trapezoid => "convolution by the trapezoidal rule",
            Self::Radau2 => "convolution by two-stage Radau IIA",
            Self::Radau3 => "convolution by three-stage Radau IIA",
            Self::Recursive => "recursion",
            Self::FiniteElements => "finite elements",
        }
    }

    /// Whether it is prepared for a limited simulated time, or may be: a convolution.
    pub fn has_horizon(self) -> bool {
        !matches!(self, Self::Recursive | Self::FiniteElements)
    }

    /// Whether communication steps may have any length. An automatic choice supports them where it turns out to be a recursion
    /// ([`Reservoir::is_recursion`](crate::Reservoir::is_recursion)).
    pub fn supports_variable_steps(self) -> bool {
        self == Self::Recursive
    }

    /// Whether the surface may have gravity waves.
    pub fn supports_surface_waves(self) -> bool {
        self != Self::Recursive
    }

    /// Whether the water is divided into boundary elements, of a chosen [`ElementOrder`](crate::ElementOrder).
    pub fn has_boundary_elements(self) -> bool {
        self != Self::FiniteElements
    }

    /// Whether it needs a long preparation, whose result can be kept
    /// ([`Packable::prepare`](cofferdam_unit::Packable::prepare)).
    pub fn needs_preparation(self) -> bool {
        self != Self::FiniteElements
    }

    /// What an automatic choice comes to where no recursion fits.
    pub(crate) fn of_convolution(self) -> Self {
        if self == Self::Automatic { Self::Radau2 } else { self }
    }

    /// The rule of a convolution; that of [`Radau2`](Self::Radau2) for all methods that are none.
    pub(crate) fn rule(self) -> Rule {
        match self {
            Self::Bdf2 => Rule::Bdf2,
            Self::Trapezoid => Rule::Trapezoid,
            Self::Radau3 => Rule::Radau3,
            _ => Rule::Radau2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_of_the_serialised_form() {
        for method in Method::ALL {
            assert_eq!(serde_json::to_value(method).unwrap(), method.word());
        }
    }
}
