//! Requests to the units, one after the other or all at once.

use super::link::{Link, RequestTemplate};
use super::{CouplingError, Exchange, Graph, Interval, UnitId};
use crate::participant::{Occasion, Participant, ParticipantError, check_finite};
use crate::signal::Signal;
use std::time::Instant;

/// One iteration of a window, with everything that is constant in it.
pub(super) struct Iteration<'a> {
    pub links: &'a [Link],
    pub templates: &'a [RequestTemplate],
    pub signals: &'a [Signal],
    pub order: &'a [UnitId],
    pub began: Instant,
    pub steps: &'a [Interval],
    pub attempt: u32,
    pub iteration: u32,
    /// Whether it is a probe, which measures the units and does not show convergence.
    pub probe: bool,
}

/// What the units are given at the ends of the steps: for each interface, step after step.
pub(super) struct Given {
    /// What the first unit receives.
    pub backward: Vec<Vec<f64>>,
    /// What the second unit receives.
    pub forward: Vec<Vec<f64>>,
}

impl Iteration<'_> {
    fn occasion(&self, interval: &Interval) -> Occasion {
        Occasion {
            step: interval.step,
            iteration: self.iteration,
            attempt: self.attempt,
            time: interval.time,
            communication_step: interval.communication_step,
        }
    }

    /// The first units take all steps with what goes `backward`, then the second ones with the answers of the first. Units whose
    /// outputs are known in advance come first of all, and their answers replace what is given.
    pub fn one_after_the_other(
        &self,
        graph: &mut Graph,
        backward: Vec<Vec<f64>>,
        exchanges: &mut Vec<Exchange>,
    ) -> Result<(), CouplingError> {
        let first = exchanges.len();
        let at_rest = |link: &Link| vec![0.0; link.received()[1] * self.steps.len()];
        let mut given = Given { backward, forward: self.links.iter().map(at_rest).collect() };
        for &id in self.order {
            for (number, link) in self.links.iter().enumerate() {
                let answers = |unit| exchanges[first..].iter().filter(move |e| e.unit == unit);
                if link.second() == id && answers(link.first()).next().is_some() {
                    let forward = answers(link.first()).flat_map(|exchange| link.forward(exchange));
                    given.forward[number] = forward.collect();
                } else if link.first() == id && answers(link.second()).next().is_some() {
                    let backward = answers(link.second()).flat_map(|exchange| link.backward(exchange));
                    given.backward[number] = backward.collect();
                }
            }
            self.steps_of(id, &mut graph[id], &given, exchanges)?;
        }
        Ok(())
    }

    /// All units take all steps at the same time.
    pub fn at_once(
        &self,
        graph: &mut Graph,
        given: &Given,
        exchanges: &mut Vec<Exchange>,
    ) -> Result<(), CouplingError> {
        let take = |(number, unit): (usize, &mut Box<dyn Participant>)| {
            let mut exchanges = Vec::new();
            let result = self.steps_of(UnitId(number), &mut **unit, given, &mut exchanges);
            (exchanges, result)
        };
        let mut taken = std::thread::scope(|scope| {
            let mut units = graph.units_mut().enumerate();
            let first = units.next();
            let threads =
                units.map(|unit| std::thread::Builder::new().spawn_scoped(scope, move || take(unit)));
            let threads = threads.collect::<Result<Vec<_>, _>>();
            let threads = threads.map_err(|cause| CouplingError::Thread { cause })?;
            let first: Vec<_> = first.map(take).into_iter().collect();
            let others = threads
                .into_iter()
                .map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
            Ok::<_, CouplingError>(first.into_iter().chain(others).map(Some).collect::<Vec<_>>())
        })?;
        let in_order = self.order.iter().filter_map(|id| taken[id.0].take());
        let (of_units, results): (Vec<Vec<Exchange>>, Vec<_>) = in_order.unzip();
        // Requests without an answer come last.
        let (answered, silent): (Vec<_>, Vec<_>) =
            of_units.into_iter().flatten().partition(|exchange| !exchange.outputs.is_empty());
        exchanges.extend(answered.into_iter().chain(silent));
        results.into_iter().collect()
    }

    fn steps_of(
        &self,
        id: UnitId,
        unit: &mut dyn Participant,
        given: &Given,
        exchanges: &mut Vec<Exchange>,
    ) -> Result<(), CouplingError> {
        for (index, interval) in self.steps.iter().enumerate() {
            let mut inputs = self.templates[id.0].request(self.signals, interval.signal_time);
            for (number, link) in self.links.iter().enumerate() {
                let [first, second] = link.received();
                if link.first() == id {
                    link.give_first(&given.backward[number][index * first..][..first], &mut inputs);
                } else if link.second() == id {
                    link.give_second(&given.forward[number][index * second..][..second], &mut inputs);
                }
            }
            self.call(unit, id, interval, inputs, exchanges)?;
        }
        Ok(())
    }

    fn call(
        &self,
        unit: &mut dyn Participant,
        id: UnitId,
        interval: &Interval,
        inputs: Vec<f64>,
        exchanges: &mut Vec<Exchange>,
    ) -> Result<(), CouplingError> {
        let occasion = self.occasion(interval);
        let Occasion { step, time, iteration, .. } = occasion;
        let guessed = iteration > 1 && !self.probe;
        call(unit, id, occasion, inputs, self.began, exchanges).map_err(|error| match error {
            cause @ ParticipantError::NonFinite { .. } if guessed => {
                CouplingError::Diverged { step, time, iteration, cause }
            }
            cause @ (ParticipantError::Unit { .. } | ParticipantError::Reported { .. }) if guessed => {
                CouplingError::GuessFailed { step, time, iteration, cause }
            }
            error => error.into(),
        })
    }
}

/// Initialises a unit (step 0) or lets it step, and adds the exchange to `exchanges`.
pub(super) fn call(
    unit: &mut dyn Participant,
    id: UnitId,
    occasion: Occasion,
    inputs: Vec<f64>,
    began: Instant,
    exchanges: &mut Vec<Exchange>,
) -> Result<(), ParticipantError> {
    let mut outputs = vec![0.0; unit.description().outputs.size()];
    let sent = began.elapsed();
    let result = match occasion.step {
        0 => unit.initialise(occasion.time, &inputs, &mut outputs),
        _ => unit.step(&occasion, &inputs, &mut outputs),
    };
    let answered = began.elapsed();
    let result = result.and_then(|()| check_finite(unit.description(), &outputs, occasion.end()));
    // The buffer of a failed unit is no answer; an answer that is not finite counts as one.
    if result.as_ref().is_err_and(|e| !matches!(e, ParticipantError::NonFinite { .. })) {
        outputs.clear();
    }
    exchanges.push(Exchange { unit: id, occasion, accepted: false, inputs, outputs, sent, answered });
    result
}
