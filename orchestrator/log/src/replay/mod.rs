//! Replay: the requests of a log are repeated with a newly made unit, whose answers must be equal bit for bit.

mod bring;
mod exchanges;

pub use bring::{Brought, bring};

use crate::alignment::Alignment;
use crate::{Log, LogReadError, LoggedExchange};
use cofferdam_coupling::difference::{Difference, Divergence, Half};
use cofferdam_coupling::participant::{Occasion, Participant, ParticipantError};
use cofferdam_coupling::scheme::UnitId;
use exchanges::Exchanges;

/// Which steps of a run are replayed, and where the unit stands before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// The first; 0 is initialisation.
    pub from: u64,
    /// The last.
    pub until: u64,
    /// The unit is at the end of this step already, as by [`Participant::deserialise`]; otherwise it is new.
    pub stands: Option<u64>,
}

impl Part {
    /// All of the run.
    pub const WHOLE: Self = Self { from: 0, until: u64::MAX, stands: None };

    /// The same, whole windows of communication steps: a run returns to the start of a window, not into it.
    fn in_windows(self, window: u64) -> Self {
        let from = if self.from == 0 { 0 } else { window_start(self.from, window) };
        Self { from, until: window_end(self.until, window), ..self }
    }
}

/// First step of the window of `step`, which is from 1.
fn window_start(step: u64, window: u64) -> u64 {
    step - (step - 1) % window.max(1)
}

/// Last step of the window of `step`; 0 is initialisation.
fn window_end(step: u64, window: u64) -> u64 {
    if step == 0 { 0 } else { window_start(step, window).saturating_add(window.max(1) - 1) }
}

/// Result of the replay of one unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Replay {
    /// Accepted exchanges that put the unit where the part begins, and the steps of that part; `None` for the whole run.
    pub part: Option<ReplayedPart>,
    /// Exchanges whose answers are identical, up to the first difference.
    pub identical: u64,
    /// The first difference.
    pub divergence: Option<Divergence>,
    /// Outputs that are not compared, because only the log has them, or only the unit: one of another version may have more.
    pub uncompared: [Vec<String>; 2],
    /// The request that the recorded unit did not answer, which ended the run; of those after which the run went on in shorter
    /// steps, the last that was answered now.
    pub unanswered: Option<Unanswered>,
    /// How the log ends: the run's status, or the byte at which it is cut short; `None` after a difference.
    pub ending: Option<Result<String, u64>>,
}

/// The part of a run that was replayed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReplayedPart {
    /// First step, with which a window begins.
    pub from: u64,
    /// Last step, with which a window ends.
    pub until: u64,
    /// Accepted exchanges by which the unit came to the start.
    pub brought: u64,
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
    /// No thread can be made.
    #[error("no thread can be made to read the log: {cause}; allow more (`ulimit -u`)")]
    Thread {
        /// The error of the system.
        cause: std::io::Error,
    },
    /// The log ends before a step.
    #[error("the log ends with step {last}, and step {step} is asked for; ask for steps up to {last}")]
    Beyond {
        /// Step that is asked for.
        step: u64,
        /// Last step of the log.
        last: u64,
    },
    /// The unit needs what the log does not have.
    #[error(
        "{unit}: its input `{variable}` of {size} values is not among the requests in the log; only a unit with the inputs of the \
         recorded one can be put where that was"
    )]
    Input {
        /// Name of the unit.
        unit: String,
        /// The input.
        variable: String,
        /// Its number of values.
        size: usize,
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

impl ReplayError {
    /// The same, where `step` is what was asked for.
    fn about(self, step: u64) -> Self {
        match self {
            Self::Beyond { last, .. } => Self::Beyond { step, last },
            other => other,
        }
    }
}

/// Repeats the requests in `log` to unit number `id` with `unit`, and compares every answer bit for bit: [`replay_part`] of all.
///
/// **Errors**: [`ReplayError::Log`]; [`ReplayError::Unit`], if `unit` fails where the recorded one did not.
pub fn replay(
    log: &Log,
    id: UnitId,
    unit: &mut dyn Participant,
    progress: impl FnMut(&Occasion),
) -> Result<Replay, ReplayError> {
    replay_part(log, id, unit, &Part::WHOLE, progress)
}

/// Repeats the requests of a part of `log` to unit number `id` with `unit`, and compares every answer bit for bit.
///
/// The unit is [brought](bring) to the start of the part. Then states are saved and restored as a run does: saved before the
/// first request of a window of communication steps, restored before every other iteration and attempt of it. `progress` is
/// called for every occasion. The replay ends at the first difference, which may be one on the way to the part.
///
/// **Errors**: [`ReplayError`], among them [`ReplayError::Unit`], if `unit` fails where the recorded one did not.
pub fn replay_part(
    log: &Log,
    id: UnitId,
    unit: &mut dyn Participant,
    part: &Part,
    mut progress: impl FnMut(&Occasion),
) -> Result<Replay, ReplayError> {
    let window = log.head().window;
    let Part { from, until, stands } = part.in_windows(window);
    let mut exchanges = Exchanges::of(log, id, stands)?;
    let mut replay = Replay::default();
    let description = unit.description().clone();
    let outputs_in_common = Alignment::of(&exchanges.unit.outputs, &description.outputs);
    let other = match exchanges.unit.inputs.agrees_with(&description.inputs) {
        false => Some(Half::Request),
        true => (!outputs_in_common.fits()).then_some(Half::Answer),
    };
    replay.uncompared.clone_from(&outputs_in_common.lonely);
    if part.from > 0 || part.until < u64::MAX {
        let brought = match (from.checked_sub(1), other) {
            (Some(before), None) => {
                let there = bring::along(&mut exchanges, unit, stands, before, window, &mut progress);
                there.map_err(|error| error.about(part.from))?
            }
            _ => Brought::default(),
        };
        replay.part = Some(ReplayedPart { from, until, brought: brought.exchanges });
        replay.divergence = brought.divergence;
        if replay.divergence.is_some() {
            return Ok(replay);
        }
    }
    let mut outputs = vec![0.0; description.outputs.size()];
    let mut place = Place { window, ..Place::default() };
    // the last request without an answer, and the last of those before others with one that was answered now
    let (mut silent, mut answered): (Option<Unanswered>, Option<Unanswered>) = (None, None);
    loop {
        let identical = replay.identical;
        let next = exchanges.next(until).map_err(|cause| ReplayError::Log { identical, cause })?;
        let Some(exchange) = next else { break };
        let LoggedExchange { occasion, .. } = exchange;
        let parted = |what| {
            let (unit, before) = (exchanges.unit.name.clone(), replay.identical);
            Some(Divergence { unit, occasion, before, what })
        };
        if let Some(half) = other {
            replay.divergence = parted(Difference::Layout { half });
            return Ok(replay);
        }
        let result = put(unit, &exchange, &mut place, &mut outputs);
        // An answer that is not finite counts as an answer.
        let failure = result.err().filter(|e| !matches!(e, ParticipantError::NonFinite { .. }));
        let Some(recorded) = &exchange.outputs else {
            let failure = failure.map(|cause| cause.to_string());
            silent = Some(Unanswered { occasion, failure });
            continue;
        };
        if let Some(cause) = failure {
            return Err(ReplayError::Unit { occasion, cause });
        }
        if let Some(what) = outputs_in_common.difference(Half::Answer, recorded, &outputs) {
            replay.divergence = parted(what);
            return Ok(replay);
        }
        answered = silent.take().filter(|silent| silent.failure.is_none()).or(answered);
        replay.identical += 1;
        progress(&occasion);
    }
    replay.unanswered = silent.or(answered);
    replay.ending = exchanges.ending;
    if let (Some(part), Some(last)) = (&mut replay.part, exchanges.last) {
        part.until = part.until.min(last);
    }
    match exchanges.last {
        Some(last) if last < from => Err(ReplayError::Beyond { step: part.from, last }),
        None if from > 0 => Err(ReplayError::Beyond { step: part.from, last: stands.unwrap_or(0) }),
        _ => Ok(replay),
    }
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
    let first = window_start(step, place.window);
    if place.saved != first {
        unit.save_state()?;
    } else if place.inside != (attempt, iteration) {
        unit.restore_state()?;
    }
    (place.saved, place.inside) = (first, (attempt, iteration));
    unit.step(occasion, inputs, outputs)
}
