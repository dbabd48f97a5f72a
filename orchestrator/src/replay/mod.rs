//! Replay: the requests of a log are repeated with a newly made unit, whose answers must be equal bit for bit.

mod recorded;

pub use recorded::{Recorded, RecordedError, Recording};

use crate::difference::{Difference, Divergence, Half};
use crate::log::{Entry, Log, LogReadError, LoggedExchange};
use crate::participant::{Occasion, Participant, ParticipantError};
use crate::scheme::UnitId;

/// Result of the replay of one unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// Exchanges whose answers are identical, up to the first difference.
    pub identical: u64,
    /// The first difference.
    pub divergence: Option<Divergence>,
    /// The request that the recorded unit did not answer, which ended the run.
    pub unanswered: Option<Unanswered>,
    /// How the log ends: the run's status, or the byte at which it is cut short; `None` after a difference.
    pub ending: Option<Result<String, u64>>,
}

/// A request without an answer in the log.
#[derive(Clone, Debug, PartialEq)]
pub struct Unanswered {
    /// When it was made.
    pub occasion: Occasion,
    /// The error if the replayed unit failed too; `None` if it gave an answer.
    pub failure: Option<String>,
}

/// Why a replay cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The log.
    #[error("{cause}")]
    Log {
        /// Number of identical answers before.
        identical: u64,
        /// The error.
        cause: LogReadError,
    },
    /// The log has no such unit.
    #[error("the log has {units} units, and none with the number {}; ask for one of them", .id.0)]
    NoUnit {
        /// Number asked for.
        id: UnitId,
        /// Number of units.
        units: usize,
    },
    /// The unit failed where the recorded one did not.
    #[error("{occasion}, where the recorded unit gave an answer: {cause}")]
    Unit {
        /// The request.
        occasion: Occasion,
        /// The error of the unit.
        cause: ParticipantError,
    },
}

/// Repeats the requests in `log` to unit number `id` with `unit`, and compares every answer bit for bit.
///
/// States are saved and restored as a run does: saved before the first request of a window of communication steps,
/// restored before every other iteration and attempt of it. `progress` is called for every occasion. The replay ends
/// at the first difference.
///
/// **Errors**: [`ReplayError::Log`]; [`ReplayError::Unit`], if `unit` fails where the recorded one did not.
pub fn replay(
    log: &Log,
    id: UnitId,
    unit: &mut dyn Participant,
    mut progress: impl FnMut(&Occasion),
) -> Result<Replay, ReplayError> {
    let Some(logged) = log.head().units.get(id.0) else {
        return Err(ReplayError::NoUnit { id, units: log.head().units.len() });
    };
    let mut replay = Replay { identical: 0, divergence: None, unanswered: None, ending: None };
    let description = unit.description().clone();
    let halves = [
        (Half::Request, &logged.inputs, &description.inputs),
        (Half::Answer, &logged.outputs, &description.outputs),
    ];
    let other =
        halves.into_iter().find(|(_, recorded, now)| !recorded.agrees_with(now)).map(|(half, ..)| half);
    let mut outputs = vec![0.0; description.outputs.size()];
    let mut place = Place { window: log.head().scene.coupling.window as u64, ..Place::default() };
    for entry in log.entries().map_err(|cause| ReplayError::Log { identical: 0, cause })? {
        let exchange = match entry.map_err(|cause| ReplayError::Log { identical: replay.identical, cause })? {
            Entry::Exchange(exchange) if exchange.unit == id => exchange,
            Entry::Damage(damage) => {
                let cause = LogReadError::Missing { path: log.path().to_owned(), damage };
                return Err(ReplayError::Log { identical: replay.identical, cause });
            }
            Entry::End(end) => {
                replay.ending = Some(Ok(end.status));
                break;
            }
            Entry::Cut(position) => {
                replay.ending = Some(Err(position));
                break;
            }
            _ => continue,
        };
        let LoggedExchange { occasion, .. } = exchange;
        let parted = |what| {
            let (unit, before) = (logged.name.clone(), replay.identical);
            Some(Divergence { unit, occasion, before, what })
        };
        if let Some(half) = other {
            replay.divergence = parted(Difference::Layout { half });
            break;
        }
        let result = put(unit, &exchange, &mut place, &mut outputs);
        // An answer that is not finite counts as an answer.
        let failure = result.err().filter(|e| !matches!(e, ParticipantError::NonFinite { .. }));
        let Some(recorded) = &exchange.outputs else {
            let failure = failure.map(|cause| cause.to_string());
            replay.unanswered = Some(Unanswered { occasion, failure });
            continue;
        };
        if let Some(cause) = failure {
            return Err(ReplayError::Unit { occasion, cause });
        }
        let difference = Difference::of_values(Half::Answer, &logged.outputs, recorded, &outputs);
        if let Some(what) = difference {
            replay.divergence = parted(what);
            break;
        }
        replay.identical += 1;
        progress(&occasion);
    }
    Ok(replay)
}

/// Position of a replay.
#[derive(Default)]
struct Place {
    /// Communication steps in a window.
    window: u64,
    /// First step of the window whose start is the saved state.
    saved: u64,
    /// Current attempt and iteration.
    inside: (u32, u32),
}

/// Makes one request as the run did.
fn put(
    unit: &mut dyn Participant,
    exchange: &LoggedExchange,
    place: &mut Place,
    outputs: &mut [f64],
) -> Result<(), ParticipantError> {
    let LoggedExchange { occasion, inputs, .. } = exchange;
    let Occasion { step, attempt, iteration, .. } = *occasion;
    if step == 0 {
        return unit.initialise(occasion.time, inputs, outputs);
    }
    let first = step - (step - 1) % place.window.max(1);
    if place.saved != first {
        unit.save_state()?;
    } else if place.inside != (attempt, iteration) {
        unit.restore_state()?;
    }
    (place.saved, place.inside) = (first, (attempt, iteration));
    unit.step(occasion, inputs, outputs)
}
