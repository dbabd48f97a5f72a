use crate::added_mass::LastStep;
use crate::convolution::{Convolution, History};
use crate::frequency_response::{convolution_weights, quadrature};
use crate::{Fidelity, ReservoirError, ReservoirParameters, added_mass};
use interface::variables::reservoir as variables;
use interface::{
    CallError, Capabilities, Causality, CoSimulation, Fingerprint, Packable, Shape, Stage, StateError,
    Variable, open, seal,
};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::num::NonZeroUsize;

/// Name of the unit in messages and logs.
const UNIT: &str = "reservoir";

/// Share of a communication step by which times of the caller and the unit may differ.
const TIME_TOLERANCE: f64 = 1e-6;

/// The water before a dam, as a co-simulation unit.
///
/// Input: mean total acceleration of the wet face along n over the step. Output: pressure
/// at the step's end. A step of compressible water costs one direct convolution with the open block of
/// the history; once a block, the frozen ones are convolved by Fourier transform. A step of water without
/// memory may have any length and costs one product with the added mass.
pub struct Reservoir {
    parameters: ReservoirParameters,
    fingerprint: Fingerprint,
    model: Model,
    /// Force along x (N/m) and moment about the heel (N·m/m) of 1 Pa at a point.
    resultants: Vec<[f64; 2]>,
    state: ReservoirState,
}

/// What turns acceleration into pressure.
enum Model {
    /// `p = −A a` at the step's end.
    AddedMass(DMatrix<f64>),
    /// Compressible water.
    Convolution(Convolution),
}

/// Saved state of a [`Reservoir`]; its convolution history is shared, not copied.
#[derive(Clone)]
pub struct ReservoirState {
    fingerprint: Fingerprint,
    motion: Motion,
    /// Of compressible water; without memory there is none.
    history: History,
}

/// The part of a state that does not grow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Motion {
    initialised: bool,
    start_time: f64,
    time: f64,
    steps: usize,
    ground_acceleration: [f64; 2],
    /// Input of the last or of the next step, m/s².
    acceleration: Vec<f64>,
    /// Velocity of the face since the start, m/s; zeros without memory.
    velocity: Vec<f64>,
    /// Of water without memory; with it as at the start.
    last_step: LastStep,
    /// Pressure, Pa.
    pressure: Vec<f64>,
}

/// What is written of a state.
#[derive(Serialize, Deserialize)]
struct SerialisedState {
    motion: Motion,
    /// Velocities at the ends of all steps, m/s; none without memory.
    velocities: Vec<f64>,
}

impl Reservoir {
    /// Makes the unit; for compressible water this computes the convolution weights on `threads`, for
    /// incompressible water it solves one system.
    ///
    /// The number of threads changes no bit of the result.
    ///
    /// **Errors**: parameters out of range, [`ReservoirError::Kernel`], [`ReservoirError::FarEnd`],
    /// [`ReservoirError::Threads`].
    pub fn new(parameters: ReservoirParameters, threads: NonZeroUsize) -> Result<Self, ReservoirError> {
        parameters.validate()?;
        let fingerprint = Fingerprint::of(UNIT, &parameters)?;
        let face = &parameters.wet_face;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build()?;
        let (points, depth) = (face.len(), face.depth());
        // What is said on the pool's threads, nobody hears.
        let (model, history, solved) = pool.install(|| {
            if !parameters.fidelity.has_memory() {
                return Ok((Model::AddedMass(added_mass(&parameters)?), History::default(), 0));
            }
            let (weights, solved) = convolution_weights(&parameters)?;
            let convolution = Convolution::new(weights);
            let history = convolution.start();
            Ok::<_, ReservoirError>((Model::Convolution(convolution), history, solved))
        })?;
        match parameters.fidelity {
            Fidelity::Compressible => tracing::info!(
                "{points} interface points, {depth} m of compressible water; solved at {solved} frequencies in the \
                 place of {}",
                quadrature(&parameters).frequencies()
            ),
            Fidelity::Incompressible => {
                tracing::info!("{points} interface points, {depth} m of incompressible water");
            }
            Fidelity::Westergaard => tracing::info!("{points} interface points, {depth} m of added mass"),
        }
        let zeros = vec![0.0; face.len()];
        let motion = Motion {
            initialised: false,
            start_time: 0.0,
            time: 0.0,
            steps: 0,
            ground_acceleration: [0.0; 2],
            acceleration: zeros.clone(),
            velocity: zeros.clone(),
            last_step: LastStep::at_rest(face.len()),
            pressure: zeros,
        };
        let state = ReservoirState { fingerprint, motion, history };
        Ok(Self { resultants: resultants(face), parameters, fingerprint, model, state })
    }

    /// What the unit was made from.
    pub fn parameters(&self) -> &ReservoirParameters {
        &self.parameters
    }

    fn check_step(&self, time: f64, communication_step: f64) -> Result<(), ReservoirError> {
        let ReservoirParameters { communication_step: allowed, horizon, .. } = self.parameters;
        if !self.state.motion.initialised {
            return Err(CallError::Order { unit: UNIT, call: "step", stage: Stage::Instantiated }.into());
        }
        let memoryless = !self.parameters.fidelity.has_memory();
        if memoryless && !(communication_step > 0.0 && communication_step.is_finite()) {
            let (parameter, value) = ("communication_step", communication_step);
            return Err(ReservoirError::NotPositive { parameter, value, unit: "s" });
        }
        let tolerance = TIME_TOLERANCE * if memoryless { communication_step } else { allowed };
        let now = self.state.motion.time;
        if (time - now).abs() > tolerance || !time.is_finite() {
            return Err(CallError::Time { unit: UNIT, asked: time, time: now }.into());
        }
        if memoryless {
            return Ok(());
        }
        if (communication_step - allowed).abs() > tolerance || !communication_step.is_finite() {
            let asked = communication_step;
            return Err(CallError::CommunicationStep { unit: UNIT, asked, allowed }.into());
        }
        if self.state.motion.steps >= self.parameters.steps() {
            let end = now + allowed;
            let elapsed = end - self.state.motion.start_time;
            return Err(ReservoirError::BeyondHorizon { end, elapsed, horizon });
        }
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
        let ReservoirParameters { wet_face, density, gravity, .. } = &self.parameters;
        let motion = &self.state.motion;
        let points = wet_face.points();
        Ok(match *variable {
            variables::INTERFACE_ACCELERATION => motion.acceleration.clone(),
            variables::GROUND_ACCELERATION => motion.ground_acceleration.to_vec(),
            variables::INTERFACE_PRESSURE => motion.pressure.clone(),
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
            Variable { value_reference, .. } => {
                return Err(CallError::UnknownVariable { unit: UNIT, value_reference }.into());
            }
        })
    }
}

impl CoSimulation for Reservoir {
    type State = ReservoirState;
    type Error = ReservoirError;

    fn name(&self) -> &'static str {
        UNIT
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

    /// The water is at rest at `start_time`: the pressure is zero whatever the acceleration.
    fn initialise(&mut self, start_time: f64) -> Result<(), ReservoirError> {
        if self.state.motion.initialised {
            return Err(CallError::Order { unit: UNIT, call: "initialise", stage: Stage::Stepping }.into());
        }
        if !start_time.is_finite() {
            return Err(
                CallError::Time { unit: UNIT, asked: start_time, time: self.state.motion.time }.into()
            );
        }
        self.state.motion.initialised = true;
        self.state.motion.start_time = start_time;
        self.state.motion.time = start_time;
        Ok(())
    }

    fn set(&mut self, value_reference: u32, values: &[f64]) -> Result<(), ReservoirError> {
        let variable = self.variable(value_reference)?;
        if variable.causality != Causality::Input {
            return Err(CallError::NotSettable { unit: UNIT, variable: variable.name }.into());
        }
        self.check_length(variable, values.len())?;
        self.check_finite(variable, values, self.state.motion.time)?;
        if *variable == variables::INTERFACE_ACCELERATION {
            self.state.motion.acceleration.copy_from_slice(values);
        } else {
            let [horizontal, vertical] = [values[0], values[1]];
            if vertical != 0.0 {
                return Err(ReservoirError::VerticalGroundMotion { acceleration: vertical });
            }
            self.state.motion.ground_acceleration = [horizontal, vertical];
        }
        Ok(())
    }

    fn step(&mut self, time: f64, communication_step: f64) -> Result<(), ReservoirError> {
        self.check_step(time, communication_step)?;
        let mut motion = self.state.motion.clone();
        motion.steps += 1;
        motion.pressure = match &self.model {
            Model::AddedMass(mass) => {
                // From the caller's time: a sum of the unit's own would drift.
                motion.time = time + communication_step;
                let (last_step, at_end) =
                    motion.last_step.followed_by(&motion.acceleration, communication_step);
                motion.last_step = last_step;
                minus(mass * at_end)
            }
            Model::Convolution(convolution) => {
                // The step that the weights were made for.
                let h = self.parameters.communication_step;
                motion.time = motion.start_time + motion.steps as f64 * h;
                motion.velocity.iter_mut().zip(&motion.acceleration).for_each(|(v, a)| *v += h * a);
                convolution.pressure(&self.state.history, &motion.velocity)
            }
        };
        if let Some(index) = motion.pressure.iter().position(|p| !p.is_finite()) {
            let (value, time) = (motion.pressure[index], motion.time);
            return Err(ReservoirError::NonFinitePressure { index, value, time });
        }
        if let Model::Convolution(convolution) = &self.model {
            self.state.history = convolution.push(&self.state.history, &motion.velocity);
        }
        self.state.motion = motion;
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
        let velocities = state.history.velocities();
        Ok(seal(self.fingerprint, &SerialisedState { motion: state.motion.clone(), velocities })?)
    }

    fn deserialise_state(&self, bytes: &[u8]) -> Result<ReservoirState, ReservoirError> {
        let SerialisedState { motion, velocities } = open(self.fingerprint, bytes)?;
        let points = self.parameters.wet_face.len();
        let Motion { acceleration, velocity, last_step, pressure, .. } = &motion;
        let per_point = [acceleration, velocity, &last_step.acceleration, pressure];
        let steps = if self.parameters.fidelity.has_memory() { motion.steps } else { 0 };
        if per_point.iter().any(|v| v.len() != points) || velocities.len() != steps * points {
            return Err(StateError::NotAState { length: bytes.len() }.into());
        }
        let history = match &self.model {
            Model::AddedMass(_) => History::default(),
            Model::Convolution(convolution) => convolution.resume(&velocities),
        };
        Ok(ReservoirState { fingerprint: self.fingerprint, motion, history })
    }

    /// `∂p/∂a = H W₀`, without memory `−(1 + H_n/(H_n + H_{n−1})) A` of the last step (before the first: of equal
    /// ones): pressure at the step's end for the step's mean acceleration, and what follows from the pressure. The ground moves along its bed and pushes no water: a derivative of zero.
    fn directional_derivative(
        &self,
        unknown: u32,
        known: u32,
        seed: &[f64],
        sensitivity: &mut [f64],
    ) -> Result<(), ReservoirError> {
        let none = || CallError::Derivative { unit: UNIT, unknown, known };
        let [of, by] = [self.variable(unknown)?, self.variable(known)?];
        self.check_length(by, seed.len())?;
        self.check_length(of, sensitivity.len())?;
        let step = self.parameters.communication_step;
        let product = |row: &[f64]| step * row.iter().zip(seed).map(|(w, a)| w * a).sum::<f64>();
        let pressure: Vec<f64> = match *by {
            variables::INTERFACE_ACCELERATION => match &self.model {
                Model::AddedMass(mass) => {
                    let factor = 1.0 + self.state.motion.last_step.share;
                    minus(mass * (factor * DVector::from_column_slice(seed)))
                }
                Model::Convolution(convolution) => {
                    convolution.instantaneous().chunks(seed.len()).map(product).collect()
                }
            },
            variables::GROUND_ACCELERATION => vec![0.0; self.parameters.wet_face.len()],
            _ => return Err(none().into()),
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

impl Packable for Reservoir {
    type Parameters = ReservoirParameters;

    const NAME: &'static str = UNIT;
    const DESCRIPTION: &'static str = "Water of infinite extent upstream of a dam";
    const VARIABLES: &'static [Variable] = variables::ALL;

    fn from_parameters(
        parameters: ReservoirParameters,
        threads: NonZeroUsize,
    ) -> Result<Self, ReservoirError> {
        Self::new(parameters, threads)
    }

    fn size_for(parameters: &ReservoirParameters, variable: &Variable) -> usize {
        match variable.shape {
            Shape::Scalar => 1,
            Shape::Plane => 2,
            Shape::InterfacePoints => parameters.wet_face.len(),
            Shape::Cracks => 0,
        }
    }

    fn capabilities_for(parameters: &ReservoirParameters) -> Capabilities {
        let variable_communication_step = !parameters.fidelity.has_memory();
        Capabilities { variable_communication_step, directional_derivative: true }
    }

    fn numbers<'a>(parameters: &'a mut ReservoirParameters, variable: &Variable) -> Vec<&'a mut f64> {
        parameters.numbers(variable)
    }
}

/// The negated values; zero stays without a sign.
fn minus(values: DVector<f64>) -> Vec<f64> {
    values.iter().map(|value| 0.0 - value).collect()
}

/// Force along x and moment about the heel (positive turning the dam downstream) of 1 Pa at a
/// point, exact for a pressure linear along panels.
fn resultants(face: &interface::WetFace) -> Vec<[f64; 2]> {
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
