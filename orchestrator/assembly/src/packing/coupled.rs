//! Dam and waters of a scene as one unit, which takes the acceleration of the ground: the coupling scheme runs inside.

use crate::ground::{component_of, ground_signal, ground_signals};
use crate::simulation::simulation_of;
use crate::{Assembly, AssemblyError};
use cofferdam_coupling::convergence::Tolerance;
use cofferdam_coupling::observer::{Ending, Observer, ObserverError, Start};
use cofferdam_coupling::participant::{InProcess, Messages, Participant};
use cofferdam_coupling::run_state::{RunState, RunStateError};
use cofferdam_coupling::scheme::{CouplingError, Graph, SchemeKind, UnitId, WindowReport};
use cofferdam_coupling::signal::Signal;
use cofferdam_coupling::simulation::{Course, Simulation, SimulationError};
use cofferdam_coupling::stepping::Stepping;
use cofferdam_dam::{Dam, DamError, DamParameters};
use cofferdam_motion::{Component, GroundMotion};
use cofferdam_reservoir::{Reservoir, ReservoirError, ReservoirParameters};
use cofferdam_scene::{OnFailure, Scene};
use cofferdam_unit::variables::coupled as variables;
use cofferdam_unit::{
    CallError, Capabilities, Causality, CoSimulation, Fingerprint, Packable, Shape, Stage, StateError,
    Variable, open, seal,
};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::sync::Arc;

/// Tolerances that a scene may have.
const TOLERANCES: std::ops::RangeInclusive<f64> = 1e-14..=0.1;
/// Pressure relative to the atmosphere below which water cavitates, Pa.
const CAVITATION: f64 = -1e5;
/// Communication steps that one call may take.
const MOST_STEPS: f64 = 1e6;
/// More steps than any simulation takes: the importer decides when it ends.
const ENDLESS: u64 = 1 << 40;
/// Relative difference of lengths that is rounding.
const ROUNDING: f64 = 1e-6;

/// Everything from which the coupled unit is made.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoupledParameters {
    /// 1 if the ground moves as in the scene, 0 if an input moves it.
    pub use_record: f64,
    /// Factor of the ground motion of the scene.
    pub record_scale: f64,
    /// Tolerance of the iteration; 0 for the balanced one.
    pub coupling_tolerance: f64,
    /// Parameters of the dam.
    pub dam: DamParameters,
    /// Parameters of the reservoir and, if there is one, the tailwater.
    pub waters: Vec<ReservoirParameters>,
    /// The scene, for scheme and steps.
    pub scene: Scene,
    /// Ground motion of the scene.
    pub record: Signal,
    /// Its vertical component.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertical: Option<Signal>,
}

/// A coupled unit that cannot be made, or a step that failed.
#[derive(Debug, thiserror::Error)]
pub enum CoupledError {
    /// A call that breaks the contract.
    #[error(transparent)]
    Call(#[from] CallError),
    /// The dam.
    #[error(transparent)]
    Dam(#[from] DamError),
    /// A water.
    #[error("the water: {0}")]
    Reservoir(#[from] ReservoirError),
    /// The units.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The coupling.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A state.
    #[error(transparent)]
    State(#[from] RunStateError),
    /// A scene whose units or steps cannot be those of one unit.
    #[error("the scene cannot be one coupled unit: {0}")]
    Unfit(&'static str),
    /// A value of a parameter.
    #[error("`{name}` is {value}; {remedy}")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        remedy: &'static str,
    },
    /// The state could not be saved.
    #[error("the state could not be saved: {0}")]
    NotSaved(String),
}

impl From<StateError> for CoupledError {
    fn from(error: StateError) -> Self {
        CallError::from(error).into()
    }
}

impl From<CouplingError> for CoupledError {
    fn from(error: CouplingError) -> Self {
        SimulationError::from(error).into()
    }
}

impl CoupledParameters {
    /// The parameters of the units of `scene`, moved by `motion`.
    ///
    /// **Errors**: units that this program does not compute, steps of varying length or in windows, and those of the units.
    pub fn of(scene: &Scene, motion: &GroundMotion) -> Result<Self, CoupledError> {
        if scene.computed_dam().is_none() {
            return Err(CoupledError::Unfit(
                "its dam is prescribed or another program's; give it a [dam] of this program",
            ));
        }
        if scene.waters().any(|(_, water)| water.solver().is_none()) {
            return Err(CoupledError::Unfit(
                "a water is missing or another program's; choose a `reservoir.fidelity` of this program",
            ));
        }
        if scene.time.adaptive.is_some()
            || scene.coupling.window > 1
            || scene.coupling.on_failure == OnFailure::Halve
        {
            return Err(CoupledError::Unfit(
                "its steps vary or are iterated in windows; leave out [time.adaptive], `coupling.window` and \
                 `coupling.on_failure = \"halve\"`",
            ));
        }
        let assembly = Assembly::of(scene);
        let waters = scene.waters().map(|(side, _)| assembly.water_parameters(side));
        let mut signals = ground_signals(motion).into_iter();
        let (Some(record), vertical) = (signals.next(), signals.next()) else {
            return Err(CoupledError::Unfit("its ground has no motion"));
        };
        let coupling_tolerance = match scene.coupling.tolerance {
            Tolerance::Relative(tolerance) => tolerance,
            Tolerance::Balanced => 0.0,
        };
        Ok(Self {
            use_record: 0.0,
            record_scale: 1.0,
            coupling_tolerance,
            dam: assembly.dam_parameters(assembly.scheme_mass())?,
            waters: waters.collect::<Result<_, _>>()?,
            scene: super::without_paths(scene),
            record,
            vertical,
        })
    }

    /// The ground motion of the scene, times `record_scale` if it is used.
    fn motion(&self) -> GroundMotion {
        let scale = if self.use_record == 1.0 { self.record_scale } else { 1.0 };
        let scaled = |signal: &Signal| {
            let samples = signal.samples.iter().map(|sample| sample * scale).collect();
            component_of(&Signal { samples, ..signal.clone() })
        };
        GroundMotion::from(scaled(&self.record)).with_vertical(self.vertical.as_ref().map(scaled))
    }

    /// The units, made on these threads, the waters from what was prepared for them where there is something.
    fn graph(
        &self,
        scene: &Scene,
        prepared: &[Option<Vec<u8>>],
        threads: NonZeroUsize,
    ) -> Result<Graph, CoupledError> {
        let assembly = Assembly::with(scene, threads);
        let messages = Messages::default();
        let (dam, _) = messages.listen(|| assembly.make_dam(self.dam.clone()))?;
        let mut units: Vec<Box<dyn Participant>> =
            vec![Box::new(InProcess::new(dam.on_threads(threads)?, "dam", messages))];
        for (number, parameters) in self.waters.iter().enumerate() {
            let messages = Messages::default();
            let parameters = parameters.clone();
            let water = messages.listen(|| match prepared.get(number).and_then(Option::as_deref) {
                Some(bytes) => Reservoir::from_prepared(parameters, bytes, threads),
                None => Reservoir::new(parameters, threads),
            })?;
            units.push(Box::new(InProcess::new(water, "water", messages)));
        }
        Ok(Graph::new(units, assembly.interfaces())?)
    }

    /// The run with these units, which does not end by itself.
    fn simulation(
        &self,
        prepared: &[Option<Vec<u8>>],
        threads: NonZeroUsize,
    ) -> Result<Simulation, CoupledError> {
        let refused = |name, value, remedy| Err(CoupledError::Parameter { name, value, remedy });
        if ![0.0, 1.0].contains(&self.use_record) {
            return refused("use_record", self.use_record, "set it to 0 or 1");
        }
        if self.coupling_tolerance != 0.0 && !TOLERANCES.contains(&self.coupling_tolerance) {
            let remedy = "set it to a number between 1e-14 and 0.1, or to 0 for the balanced tolerance";
            return refused("coupling_tolerance", self.coupling_tolerance, remedy);
        }
        let finite = |component: &Component| component.acceleration().iter().all(|a| a.is_finite());
        if !self.motion().components().all(finite) {
            return refused(
                "record_scale",
                self.record_scale,
                "set it so that no acceleration becomes infinite",
            );
        }
        let mut scene = self.scene.clone();
        scene.coupling.tolerance = match self.coupling_tolerance {
            0.0 => Tolerance::Balanced,
            tolerance => Tolerance::Relative(tolerance),
        };
        // Scales of the coupling depend on it.
        if let Some(ReservoirParameters { density, .. }) = self.waters.first() {
            if !(density.is_finite() && *density > 0.0) {
                return refused("water_density", *density, "set it to a positive number, kg/m³");
            }
            scene.reservoir.density = *density;
        }
        let graph = self.graph(&scene, prepared, threads)?;
        let mut simulation = simulation_of(&scene, &self.motion(), graph)?;
        simulation.stepping = Stepping { steps: ENDLESS, ..simulation.stepping };
        Ok(simulation)
    }
}

/// What the last window reported.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Latest {
    /// Outputs of each unit.
    outputs: Vec<Vec<f64>>,
    iterations: u32,
    converged: bool,
    residual: f64,
    interpolation_error: f64,
    lowest: f64,
    /// Work on the dam, and by the waters, since the start, J/m.
    work: [f64; 2],
    /// Cavitation was warned of.
    cavitates: bool,
}

impl Observer for Latest {
    fn begin(&mut self, _: &Start<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        for message in &report.messages {
            let text = format!("{}: {}", message.unit, message.text);
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
                let (time, kilopascal) = (interval.end(), 1e-3 * self.lowest);
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
struct Live {
    simulation: Simulation,
    course: Course,
    latest: Latest,
    /// Where an input has last moved the ground, along x and y, m/s².
    moved: [f64; 2],
}

impl Live {
    fn new(simulation: Simulation) -> Self {
        let outputs = simulation.graph.units().map(|_| Vec::new()).collect();
        let course = simulation.course();
        Self { simulation, course, latest: Latest { outputs, ..Latest::default() }, moved: [0.0; 2] }
    }

    fn snapshot(&mut self, at: &Place) -> Result<Snapshot, CoupledError> {
        Ok(Snapshot {
            run: self.simulation.state(&self.course)?,
            units: self.simulation.graph.serialise().map_err(CouplingError::from)?,
            moved: self.moved,
            latest: self.latest.clone(),
            at: at.clone(),
        })
    }
}

/// Times and inputs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Place {
    /// Time reached, s.
    time: f64,
    /// The inputs along x and y: accepted at the start of the step, and for its end, m/s².
    ground: [[f64; 2]; 2],
}

#[derive(Clone, Serialize, Deserialize)]
struct Snapshot {
    run: RunState,
    units: Vec<Vec<u8>>,
    moved: [f64; 2],
    latest: Latest,
    at: Place,
}

/// A state of the coupled unit.
#[derive(Clone, Serialize, Deserialize)]
enum Saved {
    /// Before initialisation.
    New(Place),
    Running(Box<Snapshot>),
    /// It could not be saved, for this reason.
    Failed(String),
}

/// A saved state of a [`Coupled`] unit.
#[derive(Clone)]
pub struct CoupledState(Arc<Saved>);

/// Where a variable's values are.
#[derive(Clone)]
enum Source {
    Output(usize, Range<usize>),
    Readable(UnitId),
    Scheme,
}

/// Dam and waters of a scene, coupled by its scheme.
///
/// The state is that of the whole run: of the units, of the acceleration with all that it has learnt, and of the clock.
pub struct Coupled {
    parameters: CoupledParameters,
    prepared: Arc<Vec<Option<Vec<u8>>>>,
    threads: NonZeroUsize,
    fingerprint: Fingerprint,
    live: RefCell<Live>,
    /// Where each output and calculated parameter is, in the order of the variables.
    sources: Vec<Source>,
    /// Numbers of values, in the same order: some need the mesh.
    sizes: Vec<usize>,
    stage: Stage,
    /// Initialisation was begun, so that the units are no longer new.
    begun: bool,
    at: Place,
}

impl Coupled {
    fn new(
        parameters: CoupledParameters,
        prepared: Arc<Vec<Option<Vec<u8>>>>,
        threads: NonZeroUsize,
    ) -> Result<Self, CoupledError> {
        let simulation = parameters.simulation(&prepared, threads)?;
        let sources = variables::ALL.iter().map(|variable| source(&simulation.graph, variable)).collect();
        Ok(Self {
            fingerprint: Fingerprint::of(Self::NAME, &parameters)?,
            live: RefCell::new(Live::new(simulation)),
            sources,
            sizes: variables::ALL.iter().map(|variable| Self::size_for(&parameters, variable)).collect(),
            stage: Stage::Instantiated,
            begun: false,
            at: Place::default(),
            parameters,
            prepared,
            threads,
        })
    }

    /// Makes the units again.
    fn renew(&mut self) -> Result<(), CoupledError> {
        let simulation = self.parameters.simulation(&self.prepared, self.threads)?;
        (self.live, self.begun) = (RefCell::new(Live::new(simulation)), false);
        Ok(())
    }

    /// Takes `count` communication steps, in which the ground's acceleration changes linearly.
    fn advance(&self, count: u64) -> Result<(), CoupledError> {
        let live = &mut *self.live.borrow_mut();
        let [before, after] = self.at.ground;
        for number in 1..=count {
            let share = number as f64 / count as f64;
            let between = |axis: usize| before[axis] + share * (after[axis] - before[axis]);
            let ground = if number == count { after } else { [between(0), between(1)] };
            move_ground(&self.parameters, live, ground);
            live.simulation.advance(&mut live.course, &mut [&mut live.latest])?;
        }
        Ok(())
    }
}

/// Sets the signals of the ground for the next steps, if inputs move it.
fn move_ground(parameters: &CoupledParameters, live: &mut Live, acceleration: [f64; 2]) {
    if parameters.use_record == 0.0 {
        let axes = if parameters.vertical.is_some() { 2 } else { 1 };
        for (axis, value) in acceleration.into_iter().enumerate().take(axes) {
            let signal = Signal { held: true, ..ground_signal(axis, 1.0, vec![value]) };
            live.simulation.scheme.replace_signal(signal);
        }
        live.moved = acceleration;
    }
}

/// The axis along which an input moves the ground.
fn axis(variable: &Variable) -> usize {
    usize::from(*variable == variables::GROUND_ACCELERATION_VERTICAL)
}

/// Where the values of a variable are.
fn source(graph: &Graph, variable: &Variable) -> Source {
    // The first unit that has a variable of this name: the dam, then the reservoir. The dam's points may be others.
    let first = usize::from(variable.shape == Shape::InterfacePoints);
    for (number, unit) in graph.units().enumerate().skip(first) {
        let description = unit.description();
        if let Some((_, range)) =
            description.outputs.channels().find(|(channel, _)| channel.name == variable.name)
        {
            return Source::Output(number, range);
        }
        if description.find_readable(variable.name).is_ok() {
            return Source::Readable(UnitId(number));
        }
    }
    Source::Scheme
}

impl CoSimulation for Coupled {
    type State = CoupledState;
    type Error = CoupledError;

    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn variables(&self) -> &'static [Variable] {
        variables::ALL
    }

    fn size(&self, variable: &Variable) -> usize {
        let place = variables::ALL.iter().position(|known| known == variable);
        place.and_then(|place| self.sizes.get(place)).copied().unwrap_or(0)
    }

    fn fingerprint(&self) -> Fingerprint {
        self.fingerprint
    }

    fn capabilities(&self) -> Capabilities {
        Self::capabilities_for(&self.parameters)
    }

    fn initialise(&mut self, start_time: f64) -> Result<(), CoupledError> {
        if self.stage != Stage::Instantiated {
            return Err(CallError::Order { unit: Self::NAME, call: "initialise", stage: self.stage }.into());
        }
        if self.begun {
            self.renew()?;
        }
        self.begun = true;
        let live = &mut *self.live.borrow_mut();
        move_ground(&self.parameters, live, self.at.ground[1]);
        live.simulation.begin(&mut live.course, &mut [&mut live.latest])?;
        (self.at.time, self.at.ground[0]) = (start_time, self.at.ground[1]);
        self.stage = Stage::Stepping;
        Ok(())
    }

    fn set(&mut self, value_reference: u32, values: &[f64]) -> Result<(), CoupledError> {
        let variable = self.variable(value_reference)?;
        if variable.causality != Causality::Input {
            return Err(CallError::NotSettable { unit: Self::NAME, variable: variable.name }.into());
        }
        self.check_length(variable, values.len())?;
        let Some(&acceleration) = values.first() else { return Ok(()) };
        if !acceleration.is_finite() {
            let (unit, variable, value, time) = (Self::NAME, variable.name, acceleration, self.at.time);
            return Err(CallError::NonFinite { unit, variable, index: 0, value, time }.into());
        }
        let set = &mut self.at.ground[1][axis(variable)];
        if self.parameters.use_record == 1.0 && acceleration != 0.0 && *set == 0.0 {
            tracing::warn!(
                "{} is not used: use_record is 1, so that the ground moves as in the scene",
                variable.name
            );
        }
        *set = acceleration;
        Ok(())
    }

    fn step(&mut self, time: f64, communication_step: f64) -> Result<(), CoupledError> {
        if self.stage != Stage::Stepping {
            return Err(CallError::Order { unit: Self::NAME, call: "step", stage: self.stage }.into());
        }
        let own = self.parameters.scene.time.communication_step;
        let apart = (time - self.at.time).abs();
        if apart > 1e-3 * own || apart.is_nan() {
            return Err(CallError::Time { unit: Self::NAME, asked: time, time: self.at.time }.into());
        }
        let count = (communication_step / own).round();
        if !((1.0..=MOST_STEPS).contains(&count)
            && (communication_step - count * own).abs() <= ROUNDING * count * own)
        {
            let (unit, asked) = (Self::NAME, communication_step);
            return Err(CallError::CommunicationStep { unit, asked, own }.into());
        }
        // A single step that fails is taken back by the scheme.
        let start = (count > 1.0).then(|| self.save_state());
        if let Some(Saved::Failed(why)) = start.as_ref().map(|start| &*start.0) {
            return Err(CoupledError::NotSaved(why.clone()));
        }
        if let Err(error) = self.advance(count as u64) {
            if let Some(start) = start {
                self.restore_state(&start)?;
            }
            return Err(error);
        }
        self.at.time = time + communication_step;
        self.at.ground[0] = self.at.ground[1];
        Ok(())
    }

    fn get(&self, value_reference: u32, values: &mut [f64]) -> Result<(), CoupledError> {
        let variable = self.variable(value_reference)?;
        self.check_length(variable, values.len())?;
        let place = variables::ALL.iter().position(|known| known.value_reference == value_reference);
        let source = place.and_then(|place| self.sources.get(place)).cloned().unwrap_or(Source::Scheme);
        let live = &mut *self.live.borrow_mut();
        match (variable.causality, source) {
            (Causality::Input, _) => values.fill(self.at.ground[1][axis(variable)]),
            (Causality::Parameter, _) => {
                let mut parameters = self.parameters.clone();
                let numbers = Self::numbers(&mut parameters, variable);
                values.iter_mut().zip(numbers).for_each(|(value, number)| *value = *number);
            }
            _ if self.stage == Stage::Instantiated => {
                return Err(CallError::Order { unit: Self::NAME, call: "get", stage: self.stage }.into());
            }
            (_, Source::Output(unit, range)) => {
                let no_value = CallError::NoValue { unit: Self::NAME, variable: variable.name };
                values.copy_from_slice(live.latest.outputs[unit].get(range).ok_or(no_value)?);
            }
            (_, Source::Readable(unit)) => {
                let read = live.simulation.graph[unit].read(variable.name).map_err(CouplingError::from)?;
                values.copy_from_slice(&read);
            }
            (_, Source::Scheme) => values[0] = of_scheme(&live.latest, variable),
        }
        Ok(())
    }

    fn save_state(&self) -> CoupledState {
        CoupledState(Arc::new(match self.stage {
            Stage::Instantiated => Saved::New(self.at.clone()),
            Stage::Stepping => match self.live.borrow_mut().snapshot(&self.at) {
                Ok(snapshot) => Saved::Running(Box::new(snapshot)),
                Err(error) => Saved::Failed(error.to_string()),
            },
        }))
    }

    fn restore_state(&mut self, state: &CoupledState) -> Result<(), CoupledError> {
        match &*state.0 {
            Saved::New(at) => {
                if self.begun {
                    self.renew()?;
                }
                (self.stage, self.at) = (Stage::Instantiated, at.clone());
            }
            Saved::Running(snapshot) => {
                let Snapshot { run, units, moved, latest, at } = &**snapshot;
                let live = self.live.get_mut();
                live.simulation.graph.deserialise(units)?;
                move_ground(&self.parameters, live, *moved);
                live.simulation.resume(&mut live.course, run)?;
                live.latest.clone_from(latest);
                (self.stage, self.begun, self.at) = (Stage::Stepping, true, at.clone());
            }
            Saved::Failed(why) => return Err(CoupledError::NotSaved(why.clone())),
        }
        Ok(())
    }

    fn serialise_state(&self, state: &CoupledState) -> Result<Vec<u8>, CoupledError> {
        if let Saved::Failed(why) = &*state.0 {
            return Err(CoupledError::NotSaved(why.clone()));
        }
        Ok(seal(self.fingerprint, &*state.0)?)
    }

    fn deserialise_state(&self, bytes: &[u8]) -> Result<CoupledState, CoupledError> {
        Ok(CoupledState(Arc::new(open(self.fingerprint, bytes)?)))
    }

    fn directional_derivative(
        &self,
        unknown: u32,
        known: u32,
        _seed: &[f64],
        _sensitivity: &mut [f64],
    ) -> Result<(), CoupledError> {
        Err(CallError::Derivative { unit: Self::NAME, unknown, known }.into())
    }
}

/// A value that the scheme reports.
fn of_scheme(latest: &Latest, variable: &Variable) -> f64 {
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

impl Packable for Coupled {
    type Parameters = CoupledParameters;

    const NAME: &'static str = "coupled";
    const DESCRIPTION: &'static str = "Concrete gravity dam and its reservoir, coupled";
    const VARIABLES: &'static [Variable] = variables::ALL;

    fn from_parameters(parameters: CoupledParameters, threads: NonZeroUsize) -> Result<Self, CoupledError> {
        Self::new(parameters, Arc::default(), threads)
    }

    /// What the waters prepare.
    fn prepare(
        parameters: &CoupledParameters,
        threads: NonZeroUsize,
    ) -> Result<Option<Vec<u8>>, CoupledError> {
        let prepared = parameters.waters.iter().map(|water| Reservoir::prepare(water, threads));
        let prepared: Vec<Option<Vec<u8>>> = prepared.collect::<Result<_, _>>()?;
        if prepared.iter().all(Option::is_none) {
            return Ok(None);
        }
        Ok(Some(seal(Fingerprint::of(Self::NAME, &parameters.waters)?, &prepared)?))
    }

    fn from_prepared(
        parameters: CoupledParameters,
        prepared: &[u8],
        threads: NonZeroUsize,
    ) -> Result<Self, CoupledError> {
        let prepared: Vec<Option<Vec<u8>>> =
            open(Fingerprint::of(Self::NAME, &parameters.waters)?, prepared)?;
        Self::new(parameters, Arc::new(prepared), threads)
    }

    /// What is prepared depends on the waters alone.
    fn serves(packed: &CoupledParameters, parameters: &CoupledParameters) -> bool {
        let hash = |parameters: &CoupledParameters| Fingerprint::of(Self::NAME, &parameters.waters).ok();
        hash(packed) == hash(parameters)
    }

    fn size_for(parameters: &CoupledParameters, variable: &Variable) -> usize {
        match variable.shape {
            _ if *variable == variables::GROUND_ACCELERATION_VERTICAL => {
                usize::from(parameters.vertical.is_some())
            }
            Shape::InterfacePoints => parameters.waters.first().map_or(0, |water| water.wet_face.len()),
            _ => match of_dam(variable) {
                Some(own) => Dam::size_for(&parameters.dam, own),
                None => variable.shape.fixed_size().unwrap_or(0),
            },
        }
    }

    fn capabilities_for(_: &CoupledParameters) -> Capabilities {
        Capabilities { variable_communication_step: false, directional_derivative: false, saved_state: true }
    }

    fn numbers<'a>(parameters: &'a mut CoupledParameters, variable: &Variable) -> Vec<&'a mut f64> {
        match *variable {
            variables::USE_RECORD => return vec![&mut parameters.use_record],
            variables::RECORD_SCALE => return vec![&mut parameters.record_scale],
            variables::COUPLING_TOLERANCE => return vec![&mut parameters.coupling_tolerance],
            _ => {}
        }
        if let Some(own) = of_dam(variable) {
            return Dam::numbers(&mut parameters.dam, own);
        }
        let own = Reservoir::VARIABLES.iter().find(|own| own.name == variable.name);
        // The dam's mass matrix has the water of the scene.
        let is_free = parameters.scene.scheme() != SchemeKind::OneWay;
        match (own, parameters.waters.first_mut()) {
            (Some(own), Some(water)) if is_free => Reservoir::numbers(water, own),
            _ => Vec::new(),
        }
    }
}

/// The dam's variable of the same name and role.
fn of_dam(variable: &Variable) -> Option<&'static Variable> {
    let same = |own: &&Variable| own.name == variable.name && own.causality == variable.causality;
    Dam::VARIABLES.iter().filter(|_| variable.causality != Causality::Input).find(same)
}
