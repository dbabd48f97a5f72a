use crate::rational::{DOUBTFUL, Quality};
use crate::time_domain::{Memory, TimeDomain};
use crate::{Method, ReservoirError, ReservoirParameters};
use cofferdam_unit::variables::reservoir as variables;
use cofferdam_unit::{
    CallError, Capabilities, Causality, CoSimulation, EndAcceleration, Fingerprint, Packable, Stage,
    StateError, Variable, WetFace, open, seal,
};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::num::NonZeroUsize;

mod input;
mod look_ahead;
mod packing;
mod preparation;

use input::Input;
use look_ahead::LookAhead;
use preparation::{Prepared, made};

/// Name of the unit in messages and logs.
const UNIT: &str = "reservoir";
/// Its name downstream of the dam.
const TAILWATER: &str = "tailwater";

/// Fraction of a communication step by which times of the caller and the unit may differ.
const TIME_TOLERANCE: f64 = 1e-6;
/// The same for what rounding adds up to in the caller's sum of steps.
const LARGEST_ROUNDING: f64 = 0.25;

/// The water before a dam, as a co-simulation unit.
///
/// Before a downstream face it is a tailwater: it computes the mirrored problem, in which the ground moves along x with the
/// opposite sign, and answers in the coordinates of the dam.
///
/// Input: mean total acceleration of the wet face along n over the step, and acceleration of the ground at its end.
/// Output: pressure at the step's end. Compressible water is stepped by a [`Method`]. A convolution costs a direct sum
/// over the open block of the history and, once per block, a Fourier transform of all other blocks. A recursion and finite
/// elements cost the same at any time of a run. Water without memory and a recursion take steps of any length, the other
/// methods whole multiples of the one they were made for: they take several steps of their own.
///
/// With [`explicit_coupling`](ReservoirParameters::explicit_coupling), `interface_pressure` is what a dam needs in the next step
/// whose mass contains the [`instantaneous_added_mass`](Self::instantaneous_added_mass); other outputs are those of a step before.
pub struct Reservoir {
    parameters: ReservoirParameters,
    fingerprint: Fingerprint,
    model: Model,
    /// The wet face in the dam's coordinates.
    face_of_dam: WetFace,
    /// Force along x (N/m) and moment about the heel (N·m/m) of 1 Pa at a point.
    resultants: Vec<[f64; 2]>,
    state: ReservoirState,
    /// Of a recursion.
    quality: Option<Quality>,
    /// A₀ of water with a memory, for explicit coupling.
    mass_of_step: Option<DMatrix<f64>>,
}

/// The model of the water: pressure from acceleration.
enum Model {
    /// `p = −A a` at the step's end: one column per interface point, then the ground along x and y.
    AddedMass(DMatrix<f64>),
    /// Compressible water.
    Memory(Box<dyn TimeDomain>),
}

/// Saved state of a [`Reservoir`]; the long parts of its memory are shared, not copied.
#[derive(Clone)]
pub struct ReservoirState {
    fingerprint: Fingerprint,
    motion: Motion,
    memory: Memory,
    /// For explicit coupling; the water then is a step behind the time of the motion.
    ahead: Option<LookAhead>,
}

/// The part of a state with constant size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Motion {
    initialised: bool,
    start_time: f64,
    time: f64,
    steps: usize,
    ground_acceleration: [f64; 2],
    /// The ground acceleration at the end of the last step.
    last_ground_acceleration: [f64; 2],
    /// Input of the last or of the next step, m/s².
    acceleration: Vec<f64>,
    /// Velocity of the face, then of the ground, since the start, m/s; zeros without memory.
    velocity: Vec<f64>,
    /// The last communication step; of water with memory, only its length is used.
    last_step: EndAcceleration,
    /// Pressure, Pa.
    pressure: Vec<f64>,
}

/// The serialised form of a state.
#[derive(Serialize, Deserialize)]
struct SerialisedState {
    motion: Motion,
    /// All of the water's memory.
    memory: Vec<f64>,
}

impl Reservoir {
    /// Makes the unit. For compressible water this prepares the method, on `threads`; for incompressible water one system is
    /// solved.
    ///
    /// Results do not depend on the number of threads, bit for bit.
    ///
    /// **Errors**: parameters out of range, [`ReservoirError::Kernel`], [`ReservoirError::FarEnd`],
    /// [`ReservoirError::NotFitted`], [`ReservoirError::Recursion`], [`ReservoirError::Mesh`],
    /// [`ReservoirError::FiniteElementSystem`], [`ReservoirError::GravityWaves`], [`ReservoirError::Threads`].
    pub fn new(parameters: ReservoirParameters, threads: NonZeroUsize) -> Result<Self, ReservoirError> {
        Self::with_prepared(parameters, None, threads)
    }

    fn with_prepared(
        parameters: ReservoirParameters,
        prepared: Option<Prepared>,
        threads: NonZeroUsize,
    ) -> Result<Self, ReservoirError> {
        parameters.validate()?;
        let fingerprint = Fingerprint::of(UNIT, &parameters)?;
        let face = &parameters.wet_face;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build()?;
        let (points, depth) = (face.len(), face.depth());
        // Messages are caught on this thread only, so nothing is logged on the threads of the pool.
        let (model, said, quality) = pool.install(|| made(&parameters, prepared))?;
        tracing::info!("{points} interface points, {depth} m of {said}");
        if let Some(Quality { error, loss, .. }) = quality.filter(Quality::is_doubtful) {
            tracing::warn!(
                "the recursion is {error:.1e} off the water's frequency response, with a loss of {loss:.1e} ρc, more than \
                 {DOUBTFUL:.0e}; choose another method, or a coarser wet face"
            );
        }
        let zeros = vec![0.0; face.len()];
        let motion = Motion {
            initialised: false,
            start_time: 0.0,
            time: 0.0,
            steps: 0,
            ground_acceleration: [0.0; 2],
            last_ground_acceleration: [0.0; 2],
            acceleration: zeros.clone(),
            velocity: vec![0.0; face.len() + 2],
            last_step: EndAcceleration::at_rest(face.len()),
            pressure: zeros,
        };
        let memory = match &model {
            Model::AddedMass(_) => Memory::default(),
            Model::Memory(water) => water.at_rest(),
        };
        let explicit = parameters.explicit_coupling;
        let ahead = explicit.then(|| LookAhead::at_rest(points));
        let state = ReservoirState { fingerprint, motion, memory, ahead };
        let face_of_dam = parameters.face_of_dam();
        let resultants = resultants(&face_of_dam);
        let mass_of_step = None;
        let mut new =
            Self { resultants, face_of_dam, parameters, fingerprint, model, state, quality, mass_of_step };
        if explicit && matches!(new.model, Model::Memory(_)) {
            new.mass_of_step = Some(new.instantaneous_added_mass());
        }
        Ok(new)
    }

    /// Whether making a unit of these parameters takes long, and [`Packable::prepare`] gives something.
    pub fn is_prepared(parameters: &ReservoirParameters) -> bool {
        parameters.fidelity.has_memory() && parameters.method.needs_preparation()
    }

    /// The parameters from which the unit was made.
    pub fn parameters(&self) -> &ReservoirParameters {
        &self.parameters
    }

    /// Whether the water is stepped by a recursion, asked for or chosen.
    pub fn is_recursion(&self) -> bool {
        self.quality.is_some()
    }

    /// A short name of model and solver for people, such as "compressible water, recursion".
    pub fn label(&self) -> String {
        let ReservoirParameters { fidelity, method, .. } = self.parameters;
        let solver = match (fidelity.has_memory(), method) {
            _ if !fidelity.is_solved() => return fidelity.label().to_owned(),
            (true, method) if !method.has_boundary_elements() => method.label(),
            _ if self.is_recursion() => Method::Recursive.label(),
            _ => "boundary elements",
        };
        format!("{}, {solver}", fidelity.label())
    }

    /// Whether a step may have any length.
    fn takes_any_step(&self) -> bool {
        let any = self.parameters.fidelity.supports_variable_steps() || self.is_recursion();
        any && !self.parameters.explicit_coupling
    }

    /// How many steps of its own the unit takes for a communication step.
    fn own_steps(&self, time: f64, communication_step: f64) -> Result<usize, ReservoirError> {
        let ReservoirParameters { communication_step: own, horizon, .. } = self.parameters;
        if !self.state.motion.initialised {
            return Err(
                CallError::Order { unit: self.name(), call: "step", stage: Stage::Instantiated }.into()
            );
        }
        let any = self.takes_any_step();
        if any && !(communication_step > 0.0 && communication_step.is_finite()) {
            let (parameter, value) = ("communication_step", communication_step);
            return Err(ReservoirError::NotPositive { parameter, value, unit: "s" });
        }
        let tolerance = TIME_TOLERANCE * if any { communication_step } else { own };
        let Motion { time: now, steps, .. } = self.state.motion;
        // Importers add steps up: each sum is rounded.
        let rounding = f64::EPSILON * now.abs() * (steps + 1) as f64;
        if (time - now).abs() > tolerance + rounding.min(LARGEST_ROUNDING * own) || !time.is_finite() {
            return Err(CallError::Time { unit: self.name(), asked: time, time: now }.into());
        }
        if any {
            return Ok(1);
        }
        let steps = (communication_step / own).round();
        // A NaN is refused too.
        if !(steps >= 1.0 && (communication_step - steps * own).abs() <= tolerance) {
            let asked = communication_step;
            return Err(CallError::CommunicationStep { unit: self.name(), asked, own }.into());
        }
        let explicit = self.parameters.explicit_coupling;
        if explicit && steps > 1.0 {
            return Err(ReservoirError::ExplicitStep { asked: communication_step, own });
        }
        let start = self.state.motion.start_time;
        let elapsed = now + communication_step - start;
        // The look ahead is a step further.
        let reached = (self.state.motion.steps + usize::from(explicit)) as f64 + steps;
        if self.parameters.method.has_horizon() && reached > self.parameters.steps() as f64 {
            return Err(ReservoirError::BeyondHorizon { end: start + elapsed, elapsed, horizon });
        }
        Ok(steps as usize)
    }

    /// Takes `own_steps` of `length` (s) with the acceleration in `motion` and that of the `ground` at begin and end (m/s²);
    /// sets the pressure.
    fn advance(
        &self,
        motion: &mut Motion,
        memory: &mut Memory,
        ground: [[f64; 2]; 2],
        own_steps: usize,
        length: f64,
    ) -> Result<(), ReservoirError> {
        motion.last_step.step(&motion.acceleration, own_steps as f64 * length);
        let seen = ground.map(|ground| self.parameters.seen(ground));
        motion.pressure = match &self.model {
            Model::AddedMass(mass) => {
                let at_end = DVector::from_column_slice(&motion.last_step.at_end);
                let points = at_end.len();
                minus(
                    mass * at_end.resize_vertically(points + 2, 0.0)
                        + mass.columns(points, 2) * DVector::from(seen[1].to_vec()),
                )
            }
            Model::Memory(water) => {
                let input = Input { face: &motion.acceleration, ground: seen, own_steps, length };
                let answer = input.drive(&**water, &mut motion.velocity, memory);
                answer.ok_or(ReservoirError::ForeignMemory)?
            }
        };
        Ok(())
    }

    fn check_state(&self, found: Fingerprint) -> Result<(), ReservoirError> {
        let expected = self.fingerprint;
        if found == expected { Ok(()) } else { Err(StateError::Fingerprint { found, expected }.into()) }
    }

    /// Force along x (`axis` 0, N/m) or moment about the heel (1, N·m/m) of a pressure (Pa).
    fn resultant(&self, axis: usize, pressure: &[f64]) -> f64 {
        self.resultants.iter().zip(pressure).map(|(unit, p)| unit[axis] * p).sum()
    }

    /// Values of any variable of the unit.
    fn values(&self, variable: &'static Variable) -> Result<Vec<f64>, ReservoirError> {
        let ReservoirParameters { density, gravity, .. } = &self.parameters;
        let wet_face = &self.face_of_dam;
        let motion = &self.state.motion;
        let points = wet_face.points();
        Ok(match *variable {
            variables::INTERFACE_ACCELERATION => motion.acceleration.clone(),
            variables::GROUND_ACCELERATION => motion.ground_acceleration.to_vec(),
            variables::INTERFACE_PRESSURE => match &self.state.ahead {
                Some(ahead) => ahead.pressure.clone(),
                None => motion.pressure.clone(),
            },
            variables::HYDROSTATIC_PRESSURE => {
                points.iter().map(|p| density * gravity * (wet_face.depth() - p[1])).collect()
            }
            variables::TOTAL_FORCE => vec![self.resultant(0, &motion.pressure)],
            variables::OVERTURNING_MOMENT => vec![self.resultant(1, &motion.pressure)],
            variables::BASE_PRESSURE => vec![motion.pressure[0]],
            variables::INTERFACE_X => points.iter().map(|p| p[0]).collect(),
            variables::INTERFACE_Y => points.iter().map(|p| p[1]).collect(),
            variables::INTERFACE_NORMAL_X => wet_face.normals().iter().map(|n| n[0]).collect(),
            variables::INTERFACE_NORMAL_Y => wet_face.normals().iter().map(|n| n[1]).collect(),
            variables::INTERFACE_LENGTH => wet_face.tributary_lengths(),
            variables::WATER_DEPTH => vec![wet_face.depth()],
            variables::WATER_DENSITY => vec![*density],
            variables::SOUND_SPEED => vec![self.parameters.sound_speed],
            variables::WAVE_REFLECTION_COEFFICIENT => vec![self.parameters.wave_reflection_coefficient],
            variables::GRAVITY => vec![*gravity],
            variables::FIDELITY => vec![self.parameters.fidelity.code()],
            variables::ELEMENT_SIZE => vec![self.parameters.element_size],
            variables::FAR_END_DISTANCE => vec![self.parameters.far_end_distance],
            variables::COMMUNICATION_STEP => vec![self.parameters.communication_step],
            variables::HORIZON => vec![self.parameters.horizon],
            variables::INPUTS_HELD => vec![self.parameters.inputs_held],
            variables::RECURSION_ERROR => vec![self.quality.map_or(0.0, |quality| quality.error)],
            variables::RECURSION_LOSS => vec![self.quality.map_or(0.0, |quality| quality.loss)],
            Variable { value_reference, .. } => {
                return Err(CallError::UnknownVariable { unit: self.name(), value_reference }.into());
            }
        })
    }
}

impl CoSimulation for Reservoir {
    type State = ReservoirState;
    type Error = ReservoirError;

    fn name(&self) -> &'static str {
        if self.parameters.toe.is_some() { TAILWATER } else { UNIT }
    }

    fn variables(&self) -> &'static [Variable] {
        variables::ALL
    }

    fn size(&self, variable: &Variable) -> usize {
        Self::size_for(&self.parameters, variable)
    }

    fn fingerprint(&self) -> Fingerprint {
        self.fingerprint
    }

    fn capabilities(&self) -> Capabilities {
        Self::capabilities_for(&self.parameters)
    }

    /// The water is at rest at `start_time`: the pressure is zero for any acceleration. The first step begins with the ground
    /// acceleration set before.
    fn initialise(&mut self, start_time: f64) -> Result<(), ReservoirError> {
        if self.state.motion.initialised {
            return Err(
                CallError::Order { unit: self.name(), call: "initialise", stage: Stage::Stepping }.into()
            );
        }
        if !start_time.is_finite() {
            return Err(CallError::Time {
                unit: self.name(),
                asked: start_time,
                time: self.state.motion.time,
            }
            .into());
        }
        let motion = &mut self.state.motion;
        (motion.initialised, motion.start_time, motion.time) = (true, start_time, start_time);
        motion.last_ground_acceleration = motion.ground_acceleration;
        if let Some(mut ahead) = self.state.ahead.clone() {
            self.look_from_rest(&self.state.motion, &self.state.memory, &mut ahead)?;
            self.state.ahead = Some(ahead);
        }
        Ok(())
    }

    fn set(&mut self, value_reference: u32, values: &[f64]) -> Result<(), ReservoirError> {
        let variable = self.variable(value_reference)?;
        if variable.causality != Causality::Input {
            return Err(CallError::NotSettable { unit: self.name(), variable: variable.name }.into());
        }
        self.check_length(variable, values.len())?;
        self.check_finite(variable, values, self.state.motion.time)?;
        if *variable == variables::INTERFACE_ACCELERATION {
            self.state.motion.acceleration.copy_from_slice(values);
        } else {
            self.state.motion.ground_acceleration = [values[0], values[1]];
        }
        Ok(())
    }

    fn step(&mut self, time: f64, communication_step: f64) -> Result<(), ReservoirError> {
        let own_steps = self.own_steps(time, communication_step)?;
        let ReservoirState { mut motion, mut memory, mut ahead, .. } = self.state.clone();
        motion.steps += own_steps;
        // The time of equal steps follows from their number, because a sum would accumulate rounding errors.
        let length = if self.takes_any_step() {
            motion.time = time + communication_step;
            communication_step
        } else {
            motion.time = motion.start_time + motion.steps as f64 * self.parameters.communication_step;
            self.parameters.communication_step
        };
        let ground = motion.ground_acceleration;
        let held = self.parameters.inputs_held != 0.0;
        let before = if held { ground } else { motion.last_ground_acceleration };
        match &mut ahead {
            Some(ahead) => self.step_and_look_ahead(&mut motion, &mut memory, ahead)?,
            None => {
                self.advance(&mut motion, &mut memory, [before, ground], own_steps, length)?;
            }
        }
        motion.last_ground_acceleration = ground;
        let pressures = motion.pressure.iter().chain(ahead.iter().flat_map(|ahead| &ahead.pressure));
        if let Some((index, value)) = pressures.enumerate().find(|(_, p)| !p.is_finite()) {
            let (index, value) = (index % motion.pressure.len(), *value);
            return Err(ReservoirError::NonFinitePressure { index, value, time: motion.time });
        }
        (self.state.motion, self.state.memory, self.state.ahead) = (motion, memory, ahead);
        Ok(())
    }

    fn get(&self, value_reference: u32, values: &mut [f64]) -> Result<(), ReservoirError> {
        let variable = self.variable(value_reference)?;
        self.check_length(variable, values.len())?;
        values.copy_from_slice(&self.values(variable)?);
        Ok(())
    }

    fn save_state(&self) -> ReservoirState {
        self.state.clone()
    }

    fn restore_state(&mut self, state: &ReservoirState) -> Result<(), ReservoirError> {
        self.check_state(state.fingerprint)?;
        self.state = state.clone();
        Ok(())
    }

    fn serialise_state(&self, state: &ReservoirState) -> Result<Vec<u8>, ReservoirError> {
        self.check_state(state.fingerprint)?;
        let memory = match &self.model {
            Model::AddedMass(_) => Vec::new(),
            Model::Memory(water) => water.values(&state.memory).ok_or(ReservoirError::ForeignMemory)?,
        };
        let serialised = SerialisedState { motion: state.motion.clone(), memory };
        Ok(match &state.ahead {
            Some(ahead) => seal(self.fingerprint, &(serialised, ahead))?,
            None => seal(self.fingerprint, &serialised)?,
        })
    }

    fn deserialise_state(&self, bytes: &[u8]) -> Result<ReservoirState, ReservoirError> {
        let explicit = self.parameters.explicit_coupling;
        let (SerialisedState { motion, memory }, ahead): (_, Option<LookAhead>) = match explicit {
            true => open(self.fingerprint, bytes).map(|(state, ahead)| (state, Some(ahead)))?,
            false => (open(self.fingerprint, bytes)?, None),
        };
        let points = self.parameters.wet_face.len();
        let Motion { acceleration, velocity, last_step, pressure, .. } = &motion;
        let per_point = [acceleration, pressure].iter().all(|v| v.len() == points);
        let whole = per_point
            && last_step.is_of(points)
            && velocity.len() == points + 2
            && ahead.as_ref().is_none_or(|ahead| ahead.is_of(points));
        let taken = motion.steps.saturating_sub(usize::from(explicit));
        let memory = match &self.model {
            Model::AddedMass(_) => memory.is_empty().then(Memory::default),
            Model::Memory(water) => water.resume(&memory, taken),
        };
        match memory.filter(|_| whole) {
            Some(memory) => Ok(ReservoirState { fingerprint: self.fingerprint, motion, memory, ahead }),
            None => Err(StateError::NotAState { length: bytes.len() }.into()),
        }
    }

    /// Derivatives of the pressure at the end of the last step, and of the outputs that follow from it. Before the first
    /// step, they are those of a step with the communication step of the parameters. With respect to the step's mean
    /// acceleration: `H W₀`, without memory `−(1 + H_n/(H_n + H_{n−1})) A`. With respect to the ground acceleration at its
    /// end: `½ H W₀`, `H W₀` where it is held, without memory −A. For a step of several steps of its own: the answer of water at rest.
    fn directional_derivative(
        &self,
        unknown: u32,
        known: u32,
        seed: &[f64],
        sensitivity: &mut [f64],
    ) -> Result<(), ReservoirError> {
        let none = || CallError::Derivative { unit: self.name(), unknown, known };
        if self.parameters.explicit_coupling {
            return Err(none().into());
        }
        let [of, by] = [self.variable(unknown)?, self.variable(known)?];
        self.check_length(by, seed.len())?;
        self.check_length(of, sensitivity.len())?;
        let points = self.parameters.wet_face.len();
        let EndAcceleration { length, share, .. } = self.state.motion.last_step;
        let own = self.parameters.communication_step;
        let length = if length > 0.0 { length } else { own };
        let own_steps = if self.takes_any_step() { 1 } else { (length / own).round() as usize };
        let mut seed = seed.to_vec();
        let held = self.parameters.inputs_held != 0.0;
        let (first, of_memory, of_mass) = match *by {
            variables::INTERFACE_ACCELERATION => (0, length, 1.0 + share),
            variables::GROUND_ACCELERATION => {
                seed = self.parameters.seen([seed[0], seed[1]]).to_vec();
                (points, if held { length } else { 0.5 * length }, 1.0)
            }
            _ => return Err(none().into()),
        };
        let pressure: Vec<f64> = match &self.model {
            Model::AddedMass(mass) => {
                minus(mass.columns(first, seed.len()) * DVector::from_column_slice(&seed) * of_mass)
            }
            Model::Memory(water) if own_steps == 1 => {
                let seed = DVector::from_column_slice(&seed);
                let product = water.instantaneous(length).columns(first, seed.len()) * seed * of_memory;
                product.data.into()
            }
            Model::Memory(water) => {
                let mut all = vec![0.0; points + 2];
                all[first..first + seed.len()].copy_from_slice(&seed);
                let end = [all[points], all[points + 1]];
                let ground = [if held { end } else { [0.0; 2] }, end];
                let input = Input { face: &all[..points], ground, own_steps, length: own };
                let answer = input.drive(&**water, &mut vec![0.0; points + 2], &mut water.at_rest());
                answer.ok_or(ReservoirError::ForeignMemory)?
            }
        };
        match *of {
            variables::INTERFACE_PRESSURE => sensitivity.copy_from_slice(&pressure),
            variables::TOTAL_FORCE => sensitivity[0] = self.resultant(0, &pressure),
            variables::OVERTURNING_MOMENT => sensitivity[0] = self.resultant(1, &pressure),
            variables::BASE_PRESSURE => sensitivity[0] = pressure[0],
            _ => return Err(none().into()),
        }
        Ok(())
    }
}

/// The negated values; zero stays +0.
fn minus(values: DVector<f64>) -> Vec<f64> {
    values.iter().map(|value| 0.0 - value).collect()
}

/// Force along x and moment about the heel (positive when it turns the dam downstream) of 1 Pa at each
/// point, exact for a pressure that is linear along panels.
fn resultants(face: &WetFace) -> Vec<[f64; 2]> {
    let mut unit = vec![0.0; face.len()];
    (0..face.len())
        .map(|point| {
            unit[point] = 1.0;
            let forces = face.nodal_forces(&unit);
            unit[point] = 0.0;
            forces
                .iter()
                .zip(face.points())
                .fold([0.0; 2], |[force, moment], (f, p)| [force + f[0], moment + f[0] * p[1] - f[1] * p[0]])
        })
        .collect()
}
