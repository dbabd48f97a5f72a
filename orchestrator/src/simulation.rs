//! The run itself: step after step, every report to every observer.

use crate::observer::{Ending, Observer, ObserverError, Start, Status, WallTime};
use crate::participant::ParticipantError;
use crate::scene::GroundMotion;
use crate::scheme::{CouplingError, SerialImplicit, StepFailure, StepReport, Units};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Two units, a scheme and a ground motion.
pub struct Simulation {
    /// The units.
    pub units: Units,
    /// How they take a step together.
    pub scheme: SerialImplicit,
    /// What moves the ground.
    pub ground_motion: GroundMotion,
    /// Length of a communication step, s.
    pub communication_step: f64,
    /// Number of communication steps.
    pub steps: u64,
    /// Displacement (x, y) of the crest under weight and hydrostatic pressure, m, once a dam that has it is
    /// initialised.
    pub static_crest_displacement: Option<[f64; 2]>,
}

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// A step failed.
    #[error(transparent)]
    Coupling(#[from] CouplingError),
    /// An observer failed.
    #[error(transparent)]
    Observer(#[from] ObserverError),
}

impl Simulation {
    /// Runs to the end, to the first failure, or until `interrupted` becomes true.
    ///
    /// Observers see the reports of initialisation and of every step, a failed one too, and
    /// at last the ending, however it came. A failure comes beside the ending.
    pub fn run(
        &mut self,
        observers: &mut [&mut dyn Observer],
        interrupted: &AtomicBool,
    ) -> (Ending, Option<SimulationError>) {
        let began = Instant::now();
        let mut wall = WallTime::default();
        let mut time = 0.0;
        let result = self.observed_run(observers, interrupted, &mut wall, &mut time);
        wall.total = began.elapsed();
        let status = match &result {
            Ok(status) => status.clone(),
            Err(error) => Status::Failed(error.to_string()),
        };
        let ending = Ending { status, time, wall };
        let closed = tell_all(observers, |o| o.end(&ending));
        (ending, result.err().or(closed.err().map(Into::into)))
    }

    fn observed_run(
        &mut self,
        observers: &mut [&mut dyn Observer],
        interrupted: &AtomicBool,
        wall: &mut WallTime,
        time: &mut f64,
    ) -> Result<Status, SimulationError> {
        let start = Start {
            dam: self.units.dam.description().clone(),
            reservoir: self.units.reservoir.description().clone(),
            ground_motion: &self.ground_motion,
            communication_step: self.communication_step,
            steps: self.steps,
        };
        tell_all(observers, |o| o.begin(&start))?;
        let report = self.scheme.initialise(&mut self.units, 0.0, self.ground_motion.at(0.0));
        observe(observers, report, wall)?;
        self.static_crest_displacement = match self.units.dam.fixed("crest_static_displacement") {
            Ok(u) => u.first().zip(u.get(1)).map(|(x, y)| [*x, *y]),
            Err(ParticipantError::Missing { .. }) => None,
            Err(error) => return Err(CouplingError::from(error).into()),
        };
        for step in 1..=self.steps {
            if interrupted.load(Ordering::Relaxed) {
                return Ok(Status::Interrupted);
            }
            let length = self.communication_step;
            let end = step as f64 * length;
            let ground = self.ground_motion.at(end);
            let began = Instant::now();
            let report = self.scheme.advance(&mut self.units, step, *time, length, ground);
            wall.coupling += began.elapsed();
            observe(observers, report, wall)?;
            *time = end;
        }
        Ok(Status::Completed)
    }
}

/// Shows a report, or what there is of a failed one, to the observers.
fn observe(
    observers: &mut [&mut dyn Observer],
    result: Result<StepReport, StepFailure>,
    wall: &mut WallTime,
) -> Result<(), SimulationError> {
    let (report, error) = match result {
        Ok(report) => (report, None),
        Err(StepFailure { report, error }) => (*report, Some(error)),
    };
    let counted = |time: Duration| if report.step > 0 { time } else { Duration::ZERO };
    wall.dam += counted(report.solver_time[0]);
    wall.reservoir += counted(report.solver_time[1]);
    wall.initialisation +=
        report.solver_time.iter().sum::<Duration>() - counted(report.solver_time.iter().sum());
    let began = Instant::now();
    let told = tell_all(observers, |o| o.step(&report));
    wall.observers += began.elapsed();
    error.map_or(Ok(()), |e| Err(e.into())).and(told.map_err(Into::into))
}

/// Tells every observer, even after one has failed; returns the first failure.
fn tell_all(
    observers: &mut [&mut dyn Observer],
    mut tell: impl FnMut(&mut dyn Observer) -> Result<(), ObserverError>,
) -> Result<(), ObserverError> {
    observers.iter_mut().map(|o| tell(*o)).fold(Ok(()), Result::and)
}
