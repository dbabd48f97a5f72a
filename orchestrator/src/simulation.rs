//! The run: takes step after step and gives every report to every observer.

use crate::acceleration::Acceleration;
use crate::convergence::ConvergenceMeasure;
use crate::ground_motion::GroundMotion;
use crate::observer::{Ending, Observer, ObserverError, Start, Statistics, Status, WallTime};
use crate::participant::{Description, ParticipantError};
use crate::scene::{OnFailure, Scene};
use crate::scheme::{CouplingError, Graph, Predictor, Scheme, Settings, StepFailure, UnitId, WindowReport};
use crate::stepping::{Clock, Stepping};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Coupled units, a scheme and a ground motion.
pub struct Simulation {
    /// The units.
    pub graph: Graph,
    /// The coupling scheme.
    pub scheme: Scheme,
    /// The ground motion.
    pub ground_motion: GroundMotion,
    /// The communication steps.
    pub stepping: Stepping,
    /// Displacement (x, y) of the crest under weight and hydrostatic pressure, m; `None` before initialisation and
    /// for a dam that does not have it.
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

/// Change of a pressure by which the units are measured, as a share of the hydrostatic pressure at the base: far above
/// rounding, and too small to move a crack.
const PROBE: f64 = 1e-4;

impl Simulation {
    /// The simulation of `scene` with the units of `graph`, which fit it: scheme, acceleration, predictor, measures of convergence
    /// and communication steps are those of the scene.
    ///
    /// **Errors**: the units do not fit each other or the scheme.
    pub fn of_scene(
        scene: &Scene,
        ground_motion: &GroundMotion,
        mut graph: Graph,
    ) -> Result<Self, SimulationError> {
        let coupling = &scene.coupling;
        let base_pressure = scene.hydrostatic_base_pressure();
        let settings = Settings {
            kind: scene.scheme(),
            iteration_limit: coupling.iteration_limit,
            accept_unconverged: coupling.on_failure == OnFailure::Continue,
            // The inertia of the water column.
            acceleration_scale: scene.reservoir.density * scene.depth(),
        };
        let acceleration =
            Acceleration::new(coupling.acceleration, coupling.relaxation, PROBE * base_pressure);
        let predictor = Predictor::new(coupling.predictor_order);
        let measure =
            ConvergenceMeasure::new(&coupling.measures, coupling.tolerance, scene.height(), base_pressure);
        let scheme = Scheme::new(&mut graph, settings, acceleration, predictor, measure)?;
        Ok(Self {
            graph,
            scheme,
            ground_motion: ground_motion.clone(),
            stepping: scene.stepping(),
            static_crest_displacement: None,
        })
    }

    /// Runs until the end, the first failure, an observer's request to stop, or until `interrupted` becomes true.
    ///
    /// Observers receive the reports of initialisation and of every step, including a failed one, and at last the
    /// ending. A failure is returned beside the ending.
    pub fn run(
        &mut self,
        observers: &mut [&mut dyn Observer],
        interrupted: &AtomicBool,
    ) -> (Ending, Option<SimulationError>) {
        let began = Instant::now();
        let mut tally = Tally::default();
        let result = self.observed_run(observers, interrupted, &mut tally);
        let Tally { mut wall, statistics, time } = tally;
        wall.total = began.elapsed();
        let status = match &result {
            Ok(status) => status.clone(),
            Err(error) => Status::Failed(error.to_string()),
        };
        let ending = Ending { status, time, wall, statistics };
        let closed = tell_all(observers, |o| o.end(&ending));
        (ending, result.err().or(closed.err().map(Into::into)))
    }

    fn observed_run(
        &mut self,
        observers: &mut [&mut dyn Observer],
        interrupted: &AtomicBool,
        tally: &mut Tally,
    ) -> Result<Status, SimulationError> {
        let start = Start {
            units: self.graph.units().map(|unit| unit.description().clone()).collect(),
            ground_motion: &self.ground_motion,
            stepping: self.stepping,
        };
        self.check_stepping(&start.units)?;
        tally.wall.inside = start.units.iter().map(|unit| (unit.name.clone(), Duration::ZERO)).collect();
        tally.statistics.calls = start.units.iter().map(|unit| (unit.name.clone(), [0; 2])).collect();
        tell_all(observers, |o| o.begin(&start))?;
        match self.scheme.initialise(&mut self.graph, 0.0, self.ground_motion.at(0.0)) {
            Ok(report) => {
                observe(observers, &report, tally)?;
                inspect(observers, &mut self.graph, tally)?;
            }
            Err(failure) => return Err(failed(observers, failure, tally)),
        }
        self.static_crest_displacement = match self.graph[UnitId::DAM].read("crest_static_displacement") {
            Ok(u) => u.first().zip(u.get(1)).map(|(x, y)| [*x, *y]),
            Err(ParticipantError::Missing { .. }) => None,
            Err(error) => return Err(CouplingError::from(error).into()),
        };
        let mut clock = Clock::new(self.stepping);
        loop {
            if interrupted.load(Ordering::Relaxed) {
                return Ok(Status::Interrupted);
            }
            let window = clock.window(&self.ground_motion);
            if window.is_empty() {
                return Ok(Status::Completed);
            }
            let began = Instant::now();
            let result = self.scheme.attempt(&mut self.graph, &window, clock.attempt());
            tally.wall.coupling += began.elapsed();
            match result {
                Ok(mut report) => {
                    tally.statistics.fallbacks += u64::from(report.fallbacks > 0);
                    let taken = clock.takes(&report);
                    if taken {
                        self.scheme.accept(&mut report);
                        clock.accept(&report);
                    }
                    tally.statistics.rejected += u64::from(!taken);
                    observe(observers, &report, tally)?;
                    if taken {
                        inspect(observers, &mut self.graph, tally)?;
                    }
                }
                Err(failure)
                    if failure.error.is_of_coupling()
                        && clock.shorten(failure.report.end() - failure.report.time()) =>
                {
                    tally.statistics.rejected += 1;
                    observe(observers, &failure.report, tally)?;
                }
                Err(failure) => return Err(failed(observers, failure, tally)),
            }
            tally.time = clock.time();
            if let Some(status) = observers.iter().find_map(|observer| observer.ends()) {
                return Ok(status);
            }
        }
    }

    /// Refuses steps of varying length for a unit that needs a fixed one.
    fn check_stepping(&self, units: &[Description]) -> Result<(), CouplingError> {
        let fixed = units.iter().find(|unit| !unit.capabilities.variable_communication_step);
        match fixed {
            Some(unit) if self.stepping.varies() => {
                Err(CouplingError::FixedStep { participant: unit.name.clone() })
            }
            _ => Ok(()),
        }
    }
}

/// What is counted during a run.
#[derive(Default)]
struct Tally {
    wall: WallTime,
    statistics: Statistics,
    time: f64,
}

/// Gives the partial report of a failed window to the observers; returns the error that ends the run.
fn failed(observers: &mut [&mut dyn Observer], failure: StepFailure, tally: &mut Tally) -> SimulationError {
    let StepFailure { report, error } = failure;
    // The failure of the coupling is reported; one of an observer would hide it.
    let _ = observe(observers, &report, tally);
    error.into()
}

/// Gives a report to the observers and adds it to the tally.
fn observe(
    observers: &mut [&mut dyn Observer],
    report: &WindowReport,
    tally: &mut Tally,
) -> Result<(), SimulationError> {
    let Tally { wall, statistics, .. } = tally;
    if report.step() > 0 {
        for ((_, sum), time) in wall.inside.iter_mut().zip(&report.solver_time) {
            *sum += *time;
        }
        wall.units += report.unit_time;
    } else {
        wall.initialisation += report.solver_time.iter().sum::<Duration>();
    }
    for (number, (_, calls)) in statistics.calls.iter_mut().enumerate() {
        let [all, repeated] = report.calls(UnitId(number));
        (calls[0], calls[1]) = (calls[0] + all, calls[1] + repeated);
    }
    if report.step() > 0 {
        let steps = report.steps.len() as u64;
        statistics.unconverged += if report.is_accepted() && !report.converged { steps } else { 0 };
    }
    let errors = report.interfaces.iter().flatten().map(|interface| interface.mapping_error);
    statistics.mapping_error = errors.fold(statistics.mapping_error, f64::max);
    if report.is_accepted() {
        statistics.largest_pressure = statistics.largest_pressure.max(report.largest_pressure);
    }
    statistics.rounding_floor = report.rounding_floor.or(statistics.rounding_floor);
    let began = Instant::now();
    let told = tell_all(observers, |o| o.window(report));
    wall.observers += began.elapsed();
    Ok(told?)
}

/// Lets the observers read the units.
fn inspect(
    observers: &mut [&mut dyn Observer],
    graph: &mut Graph,
    tally: &mut Tally,
) -> Result<(), SimulationError> {
    let began = Instant::now();
    let told = tell_all(observers, |o| o.inspect(graph));
    tally.wall.observers += began.elapsed();
    Ok(told?)
}

/// Calls every observer, even after one has failed; returns the first failure.
fn tell_all(
    observers: &mut [&mut dyn Observer],
    mut tell: impl FnMut(&mut dyn Observer) -> Result<(), ObserverError>,
) -> Result<(), ObserverError> {
    observers.iter_mut().map(|o| tell(*o)).fold(Ok(()), Result::and)
}
