//! The state of a run between two windows, as one value: scheme, clock and counts. The units give theirs
//! themselves ([`Graph::serialise`](crate::scheme::Graph::serialise)).

use crate::observer::{Statistics, WallTime};
use crate::scheme::SchemeState;
use crate::stepping::Clock;
use cofferdam_unit::{Fingerprint, StateError, open, seal};
use serde::{Deserialize, Serialize};

/// All that the rest of a run depends on, besides its units; observers have seen
/// [what is past](crate::observer::Observer::past).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RunState {
    pub(crate) fingerprint: Fingerprint,
    pub(crate) scheme: SchemeState,
    pub(crate) clock: Clock,
    pub(crate) statistics: Statistics,
    pub(crate) wall: WallTime,
    pub(crate) initial_values: Option<Vec<f64>>,
}

/// A state of a run that cannot be given or taken.
#[derive(Debug, thiserror::Error)]
pub enum RunStateError {
    /// Asked for inside a window.
    #[error(
        "at t = {time} s the run is inside a window that is not accepted, where it has no state; ask after a window that is"
    )]
    InsideWindow {
        /// Start of the window, s.
        time: f64,
    },
    /// Steps of another length do not begin there.
    #[error(
        "no communication step of {communication_step} s begins at t = {time:.6} s; branch where one does, or keep \
         `time.communication_step`"
    )]
    OffGrid {
        /// Where the run is, s.
        time: f64,
        /// Length of a step, s.
        communication_step: f64,
    },
    /// Of another run, or damaged.
    #[error("the state of the run: {0}")]
    State(#[from] StateError),
}

impl RunState {
    /// The state as bytes, with version and fingerprint.
    pub fn to_bytes(&self) -> Result<Vec<u8>, StateError> {
        seal(self.fingerprint, self)
    }

    /// Reads what [`to_bytes`](Self::to_bytes) wrote, for a run with this `fingerprint`.
    ///
    /// **Errors**: [`StateError`]: another version or fingerprint, damaged bytes.
    pub fn from_bytes(fingerprint: Fingerprint, bytes: &[u8]) -> Result<Self, StateError> {
        open(fingerprint, bytes)
    }

    /// Time at which it was saved, s.
    pub fn time(&self) -> f64 {
        self.clock.time()
    }
}
