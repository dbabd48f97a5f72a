//! Requests to the units, one after the other or both at once.

use super::channels::Channels;
use super::{CouplingError, Exchange, Interval, Side, Units};
use crate::mapping::Mapping;
use crate::participant::{Occasion, Participant, ParticipantError, check_finite};
use std::time::Instant;

/// One iteration of a window, with everything that is constant in it.
pub(super) struct Iteration<'a> {
    pub channels: &'a Channels,
    pub mapping: &'a Mapping,
    pub hydrostatic: &'a [f64],
    pub began: Instant,
    pub steps: &'a [Interval],
    pub attempt: u32,
    pub iteration: u32,
    /// Whether it is a probe, which measures the units and does not show convergence.
    pub probe: bool,
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

    /// The dam takes all steps with `pressure`, then the reservoir with the dam's acceleration.
    pub fn one_after_the_other(
        &self,
        units: &mut Units,
        pressure: &[f64],
        exchanges: &mut Vec<Exchange>,
    ) -> Result<(), CouplingError> {
        let first = exchanges.len();
        self.dam(&mut *units.dam, pressure, exchanges)?;
        let points = self.channels.reservoir_acceleration.len();
        let mut acceleration = vec![0.0; points * self.steps.len()];
        for (exchange, mapped) in exchanges[first..].iter().zip(acceleration.chunks_mut(points)) {
            let moved = &exchange.outputs[self.channels.dam_acceleration.clone()];
            self.mapping.motion_to_reservoir(moved, mapped);
        }
        self.reservoir(&mut *units.reservoir, &acceleration, exchanges)
    }

    /// The dam takes all steps with `pressure`, at the same time the reservoir with `acceleration`.
    pub fn at_once(
        &self,
        units: &mut Units,
        [pressure, acceleration]: [&[f64]; 2],
        exchanges: &mut Vec<Exchange>,
    ) -> Result<(), CouplingError> {
        let Units { dam, reservoir } = units;
        let (mut of_dam, mut of_reservoir) = (Vec::new(), Vec::new());
        let [dam, reservoir] = std::thread::scope(|scope| {
            let thread = std::thread::Builder::new();
            let reservoir = thread
                .spawn_scoped(scope, || self.reservoir(&mut **reservoir, acceleration, &mut of_reservoir))
                .map_err(|cause| CouplingError::Thread { cause })?;
            let dam = self.dam(&mut **dam, pressure, &mut of_dam);
            let reservoir = reservoir.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            Ok::<_, CouplingError>([dam, reservoir])
        })?;
        // A request without an answer comes last.
        if of_dam.last().is_some_and(|e| e.outputs.is_empty()) {
            exchanges.append(&mut of_reservoir);
            exchanges.append(&mut of_dam);
        } else {
            exchanges.append(&mut of_dam);
            exchanges.append(&mut of_reservoir);
        }
        dam.and(reservoir)
    }

    fn dam(
        &self,
        dam: &mut dyn Participant,
        pressure: &[f64],
        exchanges: &mut Vec<Exchange>,
    ) -> Result<(), CouplingError> {
        let points = self.channels.dam_pressure.len();
        for (interval, pressure) in self.steps.iter().zip(pressure.chunks(points)) {
            let inputs = self.channels.to_dam(pressure, self.hydrostatic, interval.ground_acceleration);
            self.ask(dam, Side::Dam, interval, inputs, exchanges)?;
        }
        Ok(())
    }

    fn reservoir(
        &self,
        reservoir: &mut dyn Participant,
        acceleration: &[f64],
        exchanges: &mut Vec<Exchange>,
    ) -> Result<(), CouplingError> {
        let points = self.channels.reservoir_acceleration.len();
        for (interval, acceleration) in self.steps.iter().zip(acceleration.chunks(points)) {
            let inputs = self.channels.to_reservoir(acceleration, interval.ground_acceleration);
            self.ask(reservoir, Side::Reservoir, interval, inputs, exchanges)?;
        }
        Ok(())
    }

    fn ask(
        &self,
        unit: &mut dyn Participant,
        side: Side,
        interval: &Interval,
        inputs: Vec<f64>,
        exchanges: &mut Vec<Exchange>,
    ) -> Result<(), CouplingError> {
        let occasion = self.occasion(interval);
        let Occasion { step, time, iteration, .. } = occasion;
        let guessed = iteration > 1 && !self.probe;
        ask(unit, side, occasion, inputs, self.began, exchanges).map_err(|error| match error {
            cause @ ParticipantError::NonFinite { .. } if guessed => {
                CouplingError::BlewUp { step, time, iteration, cause }
            }
            cause @ (ParticipantError::Unit { .. } | ParticipantError::Reported { .. }) if guessed => {
                CouplingError::GuessFailed { step, time, iteration, cause }
            }
            error => error.into(),
        })
    }
}

/// Initialises a unit (step 0) or lets it step, and adds the exchange to `exchanges`.
pub(super) fn ask(
    unit: &mut dyn Participant,
    side: Side,
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
    exchanges.push(Exchange { side, occasion, accepted: false, inputs, outputs, sent, answered });
    result
}
