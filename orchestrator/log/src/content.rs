//! What a log holds of a run.

use serde::{Deserialize, Serialize};

/// What the log holds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Content {
    /// Largest share of the log for checkpoints, from which a run can be resumed or branched. With 0 there are none, and the run can
    /// only be repeated from the start.
    #[cfg_attr(feature = "schema", schemars(range(min = 0, max = 1)))]
    pub checkpoint_share: f64,
    /// Which exchanges are logged.
    pub exchanges: LoggedExchanges,
}

impl Default for Content {
    fn default() -> Self {
        Self { checkpoint_share: 0.05, exchanges: LoggedExchanges::Every }
    }
}

/// Which exchanges are logged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum LoggedExchanges {
    /// Those of every iteration.
    #[default]
    Every,
    /// Exchanges of accepted iterations, and all exchanges of rejected steps: half the size, and enough for replay, branch and
    /// resume.
    Accepted,
    /// No exchanges, steps or iterations, only what was run and how it ended. For series of runs, whose results are in the histories
    /// and the manifest; such a run can only be repeated from the start.
    None,
}

impl LoggedExchanges {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Every, Self::Accepted, Self::None];

    /// The word for it in scenes and logs.
    pub fn word(self) -> &'static str {
        match self {
            Self::Every => "every",
            Self::Accepted => "accepted",
            Self::None => "none",
        }
    }

    /// The choice of this `word`.
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|choice| choice.word() == word)
    }
}
