//! Dam and waters of a scene as one unit, which takes the acceleration of the ground: the coupling scheme runs inside.

mod error;
mod live;
mod packing;
mod parameters;

pub use error::CoupledError;
pub use parameters::CoupledParameters;

use cofferdam_coupling::run_state::RunState;
use cofferdam_coupling::scheme::{CouplingError, Graph, UnitId};
use cofferdam_coupling::simulation::Waypoint;
use cofferdam_unit::variables::coupled as variables;
use cofferdam_unit::{
    CallError, Capabilities, Causality, CoSimulation, Fingerprint, Packable, Shape, Stage, Variable, open,
    seal,
};
use live::{Latest, Live, move_ground, of_scheme};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::sync::Arc;

/// Communication steps that one call may take.
const MOST_STEPS: f64 = 1e6;
/// Relative difference of lengths that is rounding.
const ROUNDING: f64 = 1e-6;

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

/// Where a unit stands before a call that may fail.
enum Before {
    /// Before a single communication step: its units keep their states themselves.
    Step(Box<Waypoint>, [f64; 2]),
    /// Before several, of which the first may succeed.
    Steps(CoupledState),
}

impl Before {
    fn of(unit: &mut Coupled, count: u64) -> Result<Self, CoupledError> {
        if count > 1 {
            let state = unit.save_state();
            return match &*state.0 {
                Saved::Failed(why) => Err(CoupledError::NotSaved(why.clone())),
                _ => Ok(Self::Steps(state)),
            };
        }
        let live = unit.live.get_mut();
        let lost = || CoupledError::NotSaved("a step failed and was not undone".to_owned());
        let waypoint = live.simulation.waypoint(&live.course).ok_or_else(lost)?;
        Ok(Self::Step(Box::new(waypoint), live.moved))
    }

    /// Undoes everything since: what follows is as if the call had never been made.
    fn return_to(self, unit: &mut Coupled) -> Result<(), CoupledError> {
        match self {
            Self::Step(waypoint, moved) => {
                let live = unit.live.get_mut();
                move_ground(&unit.parameters, live, moved);
                live.simulation.abandon(&mut live.course, *waypoint)?;
            }
            Self::Steps(state) => unit.restore_state(&state)?,
        }
        Ok(())
    }
}

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

    /// Takes `count` communication steps, in which the ground's acceleration changes linearly, unless it is held.
    fn advance(&self, count: u64) -> Result<(), CoupledError> {
        let live = &mut *self.live.borrow_mut();
        let [before, after] = self.at.ground;
        for number in 1..=count {
            let share = number as f64 / count as f64;
            let between = |axis: usize| before[axis] + share * (after[axis] - before[axis]);
            let at_end = number == count || self.parameters.holds_inputs();
            let ground = if at_end { after } else { [between(0), between(1)] };
            move_ground(&self.parameters, live, ground);
            let start_time = live.latest.start_time;
            let advanced = live.simulation.advance(&mut live.course, &mut [&mut live.latest]);
            advanced.map_err(|cause| match start_time {
                0.0 => cause.into(),
                start_time => CoupledError::Later { cause, start_time },
            })?;
        }
        Ok(())
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
        live.latest.start_time = start_time;
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
                "{} is not used: use_record is true, so that the ground moves as in the scene",
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
        let count = count as u64;
        let before = Before::of(self, count)?;
        if let Err(error) = self.advance(count) {
            before.return_to(self)?;
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
