//! The run inside the unit, and what it last reported.

use super::error::counted_from;
use super::{CoupledError, CoupledParameters, Place, Snapshot, variables};
use crate::ground::ground_signal;
use cofferdam_coupling::observer::{Ending, Observer, ObserverError, Start};
use cofferdam_coupling::scheme::{CouplingError, UnitId, WindowReport};
use cofferdam_coupling::signal::Signal;
use cofferdam_coupling::simulation::{Course, Simulation};
use cofferdam_unit::Variable;
use serde::{Deserialize, Serialize};

/// Pressure relative to the atmosphere below which water cavitates, Pa.
const CAVITATION: f64 = -1e5;

/// What the last window reported.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Latest {
    /// Outputs of each unit.
    pub(super) outputs: Vec<Vec<f64>>,
    iterations: u32,
    converged: bool,
    residual: f64,
    interpolation_error: f64,
    lowest: f64,
    /// Work on the dam, and by the waters, since the start, J/m.
    work: [f64; 2],
    /// Cavitation was warned of.
    cavitates: bool,
    /// The importer's time at the start of the run, s, from which the run itself counts.
    pub(super) start_time: f64,
}

impl Observer for Latest {
    fn begin(&mut self, _: &Start<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        for message in &report.messages {
            let text = format!("{}: {}{}", message.unit, message.text, counted_from(self.start_time));
            match message.level {
                cofferdam_unit::Level::Error => tracing::error!("{text}"),
                cofferdam_unit::Level::Warning => tracing::warn!("{text}"),
                cofferdam_unit::Level::Information => tracing::info!("{text}"),
                cofferdam_unit::Level::Debug => tracing::debug!("{text}"),
            }
        }
        for (index, interval) in report.steps.iter().enumerate().filter(|_| report.is_accepted()) {
            for (number, outputs) in self.outputs.iter_mut().enumerate() {
                if let Some(exchange) = report.accepted(UnitId(number), interval.step) {
                    outputs.clone_from(&exchange.outputs);
                }
            }
            let work = report.work(index).unwrap_or_default();
            self.work = [self.work[0] + work.on_first, self.work[1] + work.by_second];
            self.lowest = report.lowest(index).unwrap_or(0.0);
            if self.lowest < CAVITATION && !self.cavitates {
                self.cavitates = true;
                let (time, kilopascal) = (self.start_time + interval.end(), 1e-3 * self.lowest);
                tracing::warn!(
                    "at t = {time:.3} s the pressure falls to {kilopascal:.0} kPa relative to the atmosphere; water cavitates near \
                     -100 kPa, the linear model does not"
                );
            }
            self.iterations = report.iterations();
            self.converged = report.converged;
            self.residual = report.residuals().map_or(0.0, |residuals| residuals.norm);
            self.interpolation_error = report.interpolation_error.unwrap_or(0.0);
        }
        Ok(())
    }

    fn end(&mut self, _: &Ending) -> Result<(), ObserverError> {
        Ok(())
    }
}

/// The run and where it stands.
pub(super) struct Live {
    pub(super) simulation: Simulation,
    pub(super) course: Course,
    pub(super) latest: Latest,
    /// Where an input has last moved the ground, along x and y, m/s².
    pub(super) moved: [f64; 2],
}

impl Live {
    pub(super) fn new(simulation: Simulation) -> Self {
        let outputs = simulation.graph.units().map(|_| Vec::new()).collect();
        let course = simulation.course();
        Self { simulation, course, latest: Latest { outputs, ..Latest::default() }, moved: [0.0; 2] }
    }

    pub(super) fn snapshot(&mut self, at: &Place) -> Result<Snapshot, CoupledError> {
        Ok(Snapshot {
            run: self.simulation.state(&self.course)?,
            units: self.simulation.graph.serialise().map_err(CouplingError::from)?,
            moved: self.moved,
            latest: self.latest.clone(),
            at: at.clone(),
        })
    }
}

/// Sets the signals of the ground for the next steps, if inputs move it.
pub(super) fn move_ground(parameters: &CoupledParameters, live: &mut Live, acceleration: [f64; 2]) {
    if parameters.use_record == 0.0 {
        let axes = if parameters.vertical.is_some() { 2 } else { 1 };
        for (axis, value) in acceleration.into_iter().enumerate().take(axes) {
            let signal = Signal { held: true, ..ground_signal(axis, 1.0, vec![value]) };
            live.simulation.scheme.replace_signal(signal);
        }
        live.moved = acceleration;
    }
}

/// A value that the scheme reports.
pub(super) fn of_scheme(latest: &Latest, variable: &Variable) -> f64 {
    match *variable {
        variables::ITERATIONS => f64::from(latest.iterations),
        variables::CONVERGED => f64::from(u8::from(latest.converged)),
        variables::RESIDUAL => latest.residual,
        variables::INTERPOLATION_ERROR => latest.interpolation_error,
        variables::INTERFACE_WORK => latest.work[0],
        variables::INTERFACE_ENERGY_PRODUCED => latest.work[0] - latest.work[1],
        variables::LOWEST_PRESSURE => latest.lowest,
        // A variable that no unit has: a mistake of the program, which no result hides.
        _ => f64::NAN,
    }
}
