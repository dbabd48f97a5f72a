use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Subject of a quantity: the headings of the table, in order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Subject {
    /// The dam before time 0, and its modes.
    AtRest,
    /// Its crest.
    Crest,
    /// Its cracks.
    Cracks,
    /// The force on the ground.
    Base,
    /// The stresses in the concrete.
    Stresses,
    /// The waters.
    Water,
    /// Errors and work of the computation.
    Numerics,
    /// All others, and quantities of earlier versions.
    #[default]
    Other,
}

impl Subject {
    /// All, in their order.
    pub const ALL: [Self; 8] = [
        Self::AtRest,
        Self::Crest,
        Self::Cracks,
        Self::Base,
        Self::Stresses,
        Self::Water,
        Self::Numerics,
        Self::Other,
    ];

    /// Its heading.
    pub const fn title(self) -> &'static str {
        match self {
            Self::AtRest => "At rest",
            Self::Crest => "Crest",
            Self::Cracks => "Cracks",
            Self::Base => "Base",
            Self::Stresses => "Stresses",
            Self::Water => "Water",
            Self::Numerics => "Numerics",
            Self::Other => "Other",
        }
    }
}

/// Whether the `values` that runs have of the quantity `name` are to be taken as magnitudes: it is a peak that some have in one direction and
/// some in the other, and between both directions there is no peak.
pub fn has_both_directions(name: &str, values: impl Iterator<Item = f64>) -> bool {
    let [mut negative, mut positive] = [false; 2];
    values.for_each(|value| (negative, positive) = (negative | (value < 0.0), positive | (value > 0.0)));
    name.starts_with("peak") && negative && positive
}

/// One number of a summary.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quantity {
    /// Name.
    pub name: String,
    /// Its subject.
    #[serde(default)]
    pub subject: Subject,
    /// Its value, in `unit`.
    pub value: f64,
    /// Unit.
    pub unit: Cow<'static, str>,
    /// When it occurred, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// Where it occurred, x and y from the heel, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<[f64; 2]>,
    /// 16 %, median and 84 % of perturbed replicates, in `unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band: Option<[f64; 3]>,
}
