//! Earlier attempts at the current communication steps, from which a repetition learns.

use super::Dam;
use crate::contact::Trials;

/// Most communication steps whose attempts are remembered, of the longest window. Without repetitions the oldest are forgotten.
const MOST_TRIALS: usize = 10_000;

impl Dam {
    /// The earlier attempts at the communication step of this `length` (s) from `time` (s) on.
    pub(super) fn take_trials(&mut self, time: f64, length: f64) -> Trials {
        let found = self.trials.iter().position(|trials| trials.are_of(time, length));
        let found = found.and_then(|index| self.trials.swap_remove_back(index));
        found.unwrap_or_else(|| Trials::new(time, length))
    }

    /// Keeps the attempts, if anything happened in them.
    pub(super) fn keep_trials(&mut self, trials: Trials) {
        if trials.are_uneventful() {
            return;
        }
        if self.trials.len() == MOST_TRIALS {
            self.trials.pop_front();
        }
        self.trials.push_back(trials);
    }
}
