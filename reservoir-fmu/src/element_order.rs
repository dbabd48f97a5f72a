use serde::{Deserialize, Serialize};

/// Position of the two nodes of a linear element, ±1/√3: the points of Gauss' two-point rule.
const NODE: f64 = 0.577_350_269_189_625_8;

/// Shape functions of the boundary elements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ElementOrder {
    /// One node per element.
    Constant,
    /// Two nodes per element.
    #[default]
    Linear,
}

impl ElementOrder {
    /// Both orders, in the order of the enum.
    pub const ALL: [Self; 2] = [Self::Constant, Self::Linear];

    /// The word in a scene file, and in the serialised form.
    pub fn word(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Linear => "linear",
        }
    }

    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Constant => "constant elements",
            Self::Linear => "linear elements",
        }
    }

    /// Positions ξ of an element's nodes.
    pub(crate) fn nodes(self) -> &'static [f64] {
        match self {
            Self::Constant => &[0.0],
            Self::Linear => &[-NODE, NODE],
        }
    }

    /// Shape functions of an element's nodes at ξ; a constant element has only the first.
    pub(crate) fn shape(self, position: f64) -> [f64; 2] {
        match self {
            Self::Constant => [1.0, 0.0],
            Self::Linear => [0.5 * (1.0 - position / NODE), 0.5 * (1.0 + position / NODE)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_of_the_serialised_form() {
        for order in ElementOrder::ALL {
            assert_eq!(serde_json::to_value(order).unwrap(), order.word());
        }
    }

    /// Every node's two shape functions sum to one, so do the weights: `∫ N₁ + N₂ = length`.
    #[test]
    fn shapes_are_a_partition_of_unity() {
        for position in [-1.0, -NODE, 0.2, 1.0] {
            for order in [ElementOrder::Constant, ElementOrder::Linear] {
                let [first, second] = order.shape(position);
                assert!((first + second - 1.0).abs() < 1e-15);
            }
        }
    }
}
