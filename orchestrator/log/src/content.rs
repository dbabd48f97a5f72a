//! What a log holds of a run.

use serde::{Deserialize, Serialize};

/// What the log holds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Content {
    /// Largest share of the log that checkpoints take, from which a run can be resumed or tried otherwise; 0 for none, so that a
    /// run can only start again.
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
    /// Those that the run went on with, and all of steps that it did not accept: half of the size, and all that replays, branches
    /// and resumed runs need.
    Accepted,
    /// None, nor the steps and iterations: the log says what was run and how it ended. For series of runs, whose results are in the
    /// histories and the manifest; such a run can only be run again.
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
