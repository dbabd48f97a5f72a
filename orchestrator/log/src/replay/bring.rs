//! A unit that gives no state as bytes is brought to a step by what the run asked it there.

use super::exchanges::Exchanges;
use super::{ReplayError, window_end};
use crate::alignment::Alignment;
use crate::{Log, LoggedExchange, LoggedUnit};
use cofferdam_coupling::difference::{Difference, Divergence, Half};
use cofferdam_coupling::participant::{Description, Occasion, Participant};
use cofferdam_coupling::scheme::UnitId;
use std::ops::Range;

/// How a unit was brought to a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Brought {
    /// Accepted exchanges that it repeated.
    pub exchanges: u64,
    /// The first answer that is not that of the log.
    pub divergence: Option<Divergence>,
}

/// Puts `unit` where unit number `id` of `log` was at the end of step `until`, 0 for the end of initialisation.
///
/// It is new or, with `stands`, already at the end of that step, as by [`Participant::deserialise`]. It is asked what the run went
/// on with: initialisation and the accepted exchange of each step. Every answer is compared bit for bit; the first that differs
/// does not end it, because another unit than that of the log answers otherwise. In the log of a branch the answers before it left
/// its run are not compared: they are those of that run's units. Variables are found by their names. `progress` is called for
/// every exchange.
///
/// **Errors**: [`ReplayError`]: the log ends before `until`, or is damaged; the unit has an input that the log lacks, or fails.
pub fn bring(
    log: &Log,
    id: UnitId,
    unit: &mut dyn Participant,
    stands: Option<u64>,
    until: u64,
    mut progress: impl FnMut(&Occasion),
) -> Result<Brought, ReplayError> {
    let mut exchanges = Exchanges::of(log, id, stands)?;
    let window = log.head().window;
    along(&mut exchanges, unit, stands, until, window, &mut progress)
}

/// The same along `exchanges`, of which those of the window of `until` are read to its end.
pub(super) fn along(
    exchanges: &mut Exchanges<'_>,
    unit: &mut dyn Participant,
    stands: Option<u64>,
    until: u64,
    window: u64,
    progress: &mut dyn FnMut(&Occasion),
) -> Result<Brought, ReplayError> {
    let mut shared = Shared::of(exchanges.unit, unit.description())?;
    let (mut brought, mut reached) = (Brought::default(), stands);
    loop {
        let identical = brought.exchanges;
        let next = exchanges.next(window_end(until, window));
        let Some(exchange) = next.map_err(|cause| ReplayError::Log { identical, cause })? else { break };
        let LoggedExchange { occasion, accepted, .. } = exchange;
        if !accepted || occasion.step > until {
            continue;
        }
        let what = shared.ask(unit, &exchange)?;
        let own = exchanges.of_others.is_none_or(|last| occasion.step > last);
        if own && brought.divergence.is_none() {
            let (unit, before) = (exchanges.unit.name.clone(), brought.exchanges);
            brought.divergence = what.map(|what| Divergence { unit, occasion, before, what });
        }
        brought.exchanges += 1;
        reached = Some(occasion.step);
        progress(&occasion);
    }
    if reached == Some(until) {
        return Ok(brought);
    }
    Err(ReplayError::Beyond { step: until, last: reached.unwrap_or(0) })
}

/// The variables that a unit of a log and another one share.
struct Shared {
    /// Places in the log's request and in the unit's.
    inputs: Vec<[Range<usize>; 2]>,
    outputs: Alignment,
    request: Vec<f64>,
    answer: Vec<f64>,
}

impl Shared {
    /// **Errors**: [`ReplayError::Input`].
    fn of(logged: &LoggedUnit, now: &Description) -> Result<Self, ReplayError> {
        let mut inputs = Vec::new();
        for (channel, range) in now.inputs.channels() {
            let there = logged.inputs.range(&channel.name).filter(|there| there.len() == range.len());
            let missing = || ReplayError::Input {
                unit: now.name.clone(),
                variable: channel.name.clone(),
                size: range.len(),
            };
            inputs.push([there.ok_or_else(missing)?, range]);
        }
        let outputs = Alignment::of(&logged.outputs, &now.outputs);
        let (request, answer) = (vec![0.0; now.inputs.size()], vec![0.0; now.outputs.size()]);
        Ok(Self { inputs, outputs, request, answer })
    }

    /// Repeats an exchange; the first difference of its answer.
    fn ask(
        &mut self,
        unit: &mut dyn Participant,
        exchange: &LoggedExchange,
    ) -> Result<Option<Difference>, ReplayError> {
        for [there, here] in &self.inputs {
            self.request[here.clone()].copy_from_slice(&exchange.inputs[there.clone()]);
        }
        let occasion = exchange.occasion;
        let asked = match occasion.step {
            0 => unit.initialise(occasion.time, &self.request, &mut self.answer),
            _ => unit.save_state().and_then(|()| unit.step(&occasion, &self.request, &mut self.answer)),
        };
        asked.map_err(|cause| ReplayError::Unit { occasion, cause })?;
        let recorded = exchange.outputs.as_deref().unwrap_or_default();
        Ok(self.outputs.difference(Half::Answer, recorded, &self.answer))
    }
}
