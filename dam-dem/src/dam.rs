use cofferdam_unit::{
    CallError, Capabilities, CoSimulation, EndAcceleration, Fingerprint, Packable, Shape, Stage, StateError,
    Variable, WetFace, get_all_at, open, seal, variables::dam as variable,
};

use std::collections::VecDeque;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use crate::base::BaseBalance;
use crate::contact::{Crack, MohrCoulomb, Trials};
use crate::energy::{EnergyLedger, EnergyWatch};
use crate::integrator::CentralDifference;
use crate::loads::{Acting, Joints};
use crate::model::{Advanced, Model, TimeSteps};
use crate::reduction::Superposition;
use crate::state::{DamMotion, DamState, Inputs};
use crate::stress::{NodalStresses, PrincipalStresses, stress_points};
use crate::structure::{Motion, Structure};
use crate::time_step::CALM;
use crate::wet::Wet;
use crate::{
    CrackParameters, CriticalTimeStep, DamError, DamParameters, DampingCoefficients, LimitingPart,
    StressRecovery, SystemMatrices, modal,
};

mod attempts;
mod compliance;
mod messages;
mod output;
mod packing;
mod rest;
mod sampling;

pub use compliance::InterfaceCompliance;
pub use rest::JointAtRest;

use sampling::Sampling;

/// A cracked concrete gravity dam as a co-simulation unit.
///
/// ```text
/// M ü = F_weight + B (p_hydrostatic + p) + F_uplift + F_static − M a_g − F_int(u, u̇)
/// ```
///
/// p stands for the pressures on both wet faces, upstream and, if there is a tailwater, downstream.
/// If the parameters give an added mass, `M + X` replaces M ([`AddedMass`](crate::AddedMass)).
/// u is relative to the ground. Over a communication step p and a_g vary linearly, unless the parameters hold them; the dam takes the number of equal
/// time steps that stability requires. Before time 0 it is brought to rest under weight and hydrostatic pressure;
/// displacements, sliding, rotations and energies are relative to this state of rest.
#[derive(Clone, Debug)]
pub struct Dam {
    parameters: DamParameters,
    /// Parameters of the cracks from the base up.
    cracks: Vec<CrackParameters>,
    model: Model,
    /// The node at the upstream crest corner.
    crest: usize,
    base: BaseBalance,
    /// Nodes.
    stress_points: Vec<usize>,
    nodal_stresses: NodalStresses,
    /// Where envelopes are kept, if they are.
    sampling: Option<Sampling>,
    derived: Derived,
    damping_frequencies: [f64; 2],
    fingerprint: Fingerprint,
    state: DamState,
    energy_watch: EnergyWatch,
    /// Whether it was told that a block has left its crack. It is not part of the state.
    told_of_departure: bool,
    /// Attempts at the current steps in which bonds broke or contacts did not stick. They are not part of the state.
    trials: VecDeque<Trials>,
    /// The ground acceleration is constant within a step, whatever holds for the pressure.
    ground_held: bool,
}

/// What follows from the current state, once it was asked for.
#[derive(Clone, Debug, Default)]
struct Derived {
    stresses: OnceLock<PrincipalStresses>,
    /// Displacement since time 0, in the coordinates of the model.
    since_rest: OnceLock<Vec<f64>>,
    /// The same of all nodes, m: both components at once, as the shapes of modes are more than caches hold.
    displacements: OnceLock<Vec<[f64; 2]>>,
}

/// Largest number of time steps in one communication step; more would take too long to compute.
const MOST_TIME_STEPS: f64 = 1e7;

impl Dam {
    /// Checks the parameters, meshes the section, and computes damping and time step.
    ///
    /// **Errors**: the [`DamError`] that names the parameter; [`DamError::AddedMassShape`],
    /// [`DamError::AddedMassNegative`], and [`DamError::OutOfRange`] for an added mass that is not finite;
    /// [`DamError::Singular`] and [`DamError::FrequenciesNotConverged`] from the first natural frequency.
    pub fn new(parameters: DamParameters) -> Result<Self, DamError> {
        parameters.check()?;
        let mut cracks = parameters.cracks.clone();
        cracks.sort_by(CrackParameters::from_the_base_up);
        let (model, damping_frequencies) = Model::new(&parameters, &cracks)?;
        let mesh = &model.body().structure.mesh;
        let crest = mesh.upstream.last().copied().unwrap_or(0);
        let points = model.body().wet.as_ref().map_or(0, Wet::len);
        let inputs = Inputs { pressure: vec![0.0; points], ground_acceleration: [0.0; 2] };
        let motion = model.at_rest();
        let joints = model.body().joints.as_deref();
        let recovery = StressRecovery::new(mesh);
        let sampling =
            parameters.envelopes.then(|| Sampling::new(&parameters.materials(), &model, &recovery));
        let fingerprint = Fingerprint::of(Self::NAME, &parameters)?;
        let state = DamState {
            fingerprint,
            initialised: false,
            time: 0.0,
            rest: motion.displacement().to_vec(),
            mean_acceleration: motion.velocity().to_vec(),
            mean_ground_acceleration: [0.0; 2],
            mean_base_force: [0.0; 2],
            interface_acceleration: EndAcceleration::at_rest(points),
            motion,
            energy: EnergyLedger::default(),
            hydrostatic_pressure: vec![0.0; points],
            uplift: joints.map_or_else(Vec::new, |joints| joints.closed(0.0)),
            opened_at_rest: vec![[0.0; 2]; joints.map_or(0, |joints| joints.cracks().len())],
            accepted: inputs.clone(),
            next: inputs,
            energy_watch: EnergyWatch::default(),
            envelope: sampling.as_ref().map(|sampling| sampling.nothing(&model)),
        };
        let dam = Self {
            base: BaseBalance::new(&model, parameters.gravity),
            stress_points: stress_points(&parameters.section, mesh),
            nodal_stresses: NodalStresses::new(&model, &recovery),
            sampling,
            derived: Derived::default(),
            fingerprint,
            parameters,
            cracks,
            model,
            crest,
            damping_frequencies,
            state,
            energy_watch: EnergyWatch::default(),
            told_of_departure: false,
            trials: VecDeque::new(),
            ground_held: false,
        };
        tracing::info!(
            "{} elements, {} nodes, {} cracks; highest frequency {:.4e} rad/s, largest time step {:.4e} s{}",
            dam.element_count(),
            dam.node_count(),
            dam.cracks.len(),
            dam.critical_time_step().highest_frequency,
            dam.time_step_limit(),
            dam.limiting_part().map_or_else(String::new, |part| dam.phrase_of(part))
        );
        if let Some(modes) = dam.modes() {
            tracing::info!(
                "{} modes; the omitted modes would change the response by at most a share of {:.1e}",
                modes.mode_count(),
                modes.truncation()
            );
        }
        if !dam.parameters.fidelity.level().is_deformable() {
            tracing::warn!(
                "rigid blocks are unsafe: they do not amplify the ground motion, so that the computed sliding is too small"
            );
        }
        if let Some(water) = &dam.structure().added_mass {
            let mass: f64 = water.ground_inertia(0).map(|(_, inertia)| inertia[0]).sum();
            tracing::info!("the mass matrix includes {mass:.4e} kg/m of water (horizontal motion)");
        }
        Ok(dam)
    }

    /// The same dam, whose elements are evaluated on `threads` threads if it has enough elements for this to
    /// be faster.
    ///
    /// **Errors**: [`DamError::Threads`].
    pub fn on_threads(self, threads: NonZeroUsize) -> Result<Self, DamError> {
        Ok(Self { model: self.model.on_threads(threads)?, ..self })
    }

    /// The same dam, for which the ground acceleration has the value that is set over the whole step, while the pressure changes
    /// linearly.
    pub fn holding_the_ground(self) -> Self {
        Self { ground_held: true, ..self }
    }

    /// Parameters from which the dam was made.
    pub fn parameters(&self) -> &DamParameters {
        &self.parameters
    }

    /// Cracks from the base up; all results with one value for each crack have this order.
    pub fn cracks(&self) -> &[CrackParameters] {
        &self.cracks
    }

    /// The upstream wet face, or `None` with an empty reservoir.
    pub fn wet_face(&self) -> Option<&WetFace> {
        self.wet()?.faces[0].as_ref()
    }

    /// The wet face of the tailwater, or `None` without it.
    pub fn tailwater_face(&self) -> Option<&WetFace> {
        self.wet()?.faces[1].as_ref()
    }

    /// Number of triangles.
    pub fn element_count(&self) -> usize {
        self.structure().cells.triangle_count()
    }

    /// Number of nodes; nodes on cracks are doubled and count twice.
    pub fn node_count(&self) -> usize {
        self.structure().mesh.nodes.len()
    }

    /// The `count` lowest natural frequencies of the intact dam with an empty reservoir (no added mass), rad/s.
    ///
    /// **Errors**: as [`modal::natural_frequencies`].
    pub fn natural_frequencies(&self, count: usize) -> Result<Vec<f64>, DamError> {
        modal::natural_frequencies(self.structure(), count)
    }

    /// Highest frequency and longest stable time step, without the safety factor.
    pub fn critical_time_step(&self) -> CriticalTimeStep {
        self.model.critical_time_step()
    }

    /// Where the highest frequency lies; `None` below the full model.
    pub fn limiting_part(&self) -> Option<&LimitingPart> {
        self.model.limiting_part()
    }

    /// Longest time step that the dam uses, with the safety factor, s.
    pub fn time_step_limit(&self) -> f64 {
        self.critical_time_step().with_safety(self.parameters.time_step_safety, self.model.largest_share())
    }

    /// Number of time steps in a communication step of length `communication_step` (s).
    pub fn time_steps_per(&self, communication_step: f64) -> usize {
        self.time_steps(communication_step).steps
    }

    /// The same of a calm communication step, in which every contact sticks; `None` if that makes no difference: it does for
    /// modes with contacts.
    pub fn calm_time_steps_per(&self, communication_step: f64) -> Option<usize> {
        self.calm_time_steps(communication_step).map(|steps| steps.steps)
    }

    /// Matrices of the intact, linear dam.
    pub fn system_matrices(&self) -> SystemMatrices {
        SystemMatrices::of(&self.model, self.crest)
    }

    /// Blocks, masses and cracks.
    pub fn structure(&self) -> &Structure<MohrCoulomb> {
        &self.model.body().structure
    }

    /// Coefficients of the damping, including the memory of stiffness damping.
    pub fn damping_coefficients(&self) -> DampingCoefficients {
        self.model.damping()
    }

    /// The two frequencies at which the damping ratio holds, rad/s. If there is only one, it is given twice;
    /// without a damping ratio both are 0.
    pub fn damping_frequencies(&self) -> [f64; 2] {
        self.damping_frequencies
    }

    /// The current state.
    pub fn state(&self) -> &DamState {
        &self.state
    }

    /// The modes, at all levels except [`Fidelity::Dem`](crate::Fidelity::Dem).
    pub fn modes(&self) -> Option<&Superposition> {
        self.model.superposition()
    }

    fn wet(&self) -> Option<&Wet> {
        self.model.body().wet.as_ref()
    }

    /// The points of a variable's wet face among those of both faces.
    fn points(&self, variable: &Variable) -> Range<usize> {
        let [upstream, downstream] = self.wet().map_or([0..0, 0..0], Wet::ranges);
        if variable.shape == Shape::TailwaterPoints { downstream } else { upstream }
    }

    fn time_steps(&self, communication_step: f64) -> CentralDifference {
        CentralDifference::covering(communication_step, self.time_step_limit())
    }

    fn calm_time_steps(&self, communication_step: f64) -> Option<CentralDifference> {
        let has = self.modes().is_some_and(|modes| modes.has_calm_steps());
        has.then(|| CentralDifference::covering(communication_step, CALM * self.time_step_limit()))
    }

    /// What acts with these `inputs` and this `uplift` (Pa at each contact).
    fn acting(&self, inputs: &Inputs, uplift: Vec<f64>) -> Acting {
        let both = inputs.pressure.iter().zip(&self.state.hydrostatic_pressure);
        let pressure = both.map(|(p, hydrostatic)| p + hydrostatic).collect();
        Acting { pressure, ground_acceleration: inputs.ground_acceleration, uplift }
    }

    /// Pressure of the water in joints at a `time` (s) by their rules, with the contacts as they are now, Pa.
    fn uplift_at(&self, time: f64) -> Vec<f64> {
        let state = &self.state;
        let pressure = |joints: &Arc<Joints>| {
            let opened = joints.opened(state.motion.joints());
            joints.during_shaking(time, &state.opened_at_rest, &opened)
        };
        self.model.body().joints.iter().flat_map(pressure).collect()
    }

    /// Returns an error if the motion is not finite.
    fn check_motion(&self, motion: &DamMotion, time: f64) -> Result<(), DamError> {
        let finite = motion.displacement().iter().zip(motion.velocity()).map(|(u, v)| (u + v).is_finite());
        let Some(index) = finite.into_iter().position(|finite| !finite) else { return Ok(()) };
        let part = match motion {
            DamMotion::Nodes(_) => {
                let node = index / 2;
                format!("node {node} in block {}", self.structure().mesh.block_of(node))
            }
            DamMotion::Modes(_) => format!("mode {index}"),
        };
        Err(DamError::NonFinite { part, time })
    }

    /// The inputs at the start of the next step: those accepted last, or where they are held those for its end.
    fn inputs_at_start(&self) -> Inputs {
        let DamState { accepted, next, .. } = &self.state;
        let all = self.parameters.inputs_held != 0.0;
        Inputs {
            pressure: if all { next } else { accepted }.pressure.clone(),
            ground_acceleration: if all || self.ground_held { next } else { accepted }.ground_acceleration,
        }
    }

    fn check_state(&self, state: &DamState) -> Result<(), StateError> {
        let (found, expected) = (state.fingerprint, self.fingerprint);
        if found == expected { Ok(()) } else { Err(StateError::Fingerprint { found, expected }) }
    }

    fn stage(&self) -> Stage {
        if self.state.initialised { Stage::Stepping } else { Stage::Instantiated }
    }

    fn order(&self, call: &'static str) -> CallError {
        CallError::Order { unit: self.name(), call, stage: self.stage() }
    }
}

impl CoSimulation for Dam {
    type State = DamState;
    type Error = DamError;

    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn variables(&self) -> &'static [Variable] {
        variable::ALL
    }

    fn size(&self, variable: &Variable) -> usize {
        if !self.parameters.has(variable) {
            return 0;
        }
        match variable.shape {
            Shape::InterfacePoints | Shape::TailwaterPoints => self.points(variable).len(),
            Shape::StressPoints => self.stress_points.len(),
            Shape::Nodes => self.node_count(),
            Shape::Triangles => self.element_count(),
            Shape::Contacts => self.structure().cracks.iter().map(Crack::contact_count).sum(),
            _ => Self::size_for(&self.parameters, variable),
        }
    }

    fn fingerprint(&self) -> Fingerprint {
        self.fingerprint
    }

    fn capabilities(&self) -> Capabilities {
        Self::capabilities_for(&self.parameters)
    }

    /// Computes the state of rest under weight and hydrostatic pressure, which is the state at `start_time`.
    ///
    /// **Errors**: [`DamError::CannotStand`], [`DamError::StaticNotConverged`]; [`CallError::Order`] when called twice.
    fn initialise(&mut self, start_time: f64) -> Result<(), DamError> {
        if self.state.initialised {
            return Err(self.order("initialise").into());
        }
        crate::error::require(start_time.is_finite(), "start_time", start_time, "finite")?;
        let rest = self.find_rest(start_time)?;
        let mut motion = rest.motion;
        self.state.opened_at_rest = rest.opened;
        self.state.motion.clone_from(&motion);
        self.state.uplift = self.uplift_at(start_time);
        let start = self.acting(&self.state.next, self.state.uplift.clone());
        // what leaves open joints leaves them from the first instant on
        if let Some(joints) = &self.model.body().joints {
            joints.relieve(motion.joints_mut(), [&self.state.uplift; 2]);
        }
        let mut moving = self.model.with(&mut motion)?;
        moving.begin(&start);
        let at_rest = moving.stored_energy();
        let (acceleration, ground) = moving.initial_acceleration(start.ground_acceleration);
        let state = &mut self.state;
        state.mean_base_force = self.base.force(
            &acceleration,
            [motion.velocity(); 2],
            [0.0; 2],
            ground,
            start.pressure.into_iter(),
        );
        state.mean_acceleration = acceleration;
        state.mean_ground_acceleration = state.next.ground_acceleration;
        state.initialised = true;
        state.time = start_time;
        state.accepted = state.next.clone();
        state.rest = motion.displacement().to_vec();
        state.energy = EnergyLedger::starting(at_rest);
        motion.joints_mut().iter_mut().flatten().for_each(|joint| joint.relief = 0.0);
        state.motion = motion;
        self.derived = Derived::default();
        self.tell_of_uplift();
        self.sample(0.0);
        Ok(())
    }

    fn set(&mut self, value_reference: u32, values: &[f64]) -> Result<(), DamError> {
        let variable = self.variable(value_reference)?;
        self.check_length(variable, values.len())?;
        self.check_finite(variable, values, self.state.time)?;
        let points = self.points(variable);
        match *variable {
            variable::INTERFACE_PRESSURE | variable::TAILWATER_INTERFACE_PRESSURE => {
                self.state.next.pressure[points].copy_from_slice(values);
            }
            variable::GROUND_ACCELERATION => self.state.next.ground_acceleration.copy_from_slice(values),
            variable::HYDROSTATIC_PRESSURE | variable::TAILWATER_HYDROSTATIC_PRESSURE => {
                if self.state.initialised && self.state.hydrostatic_pressure[points.clone()] != *values {
                    return Err(self.order("set hydrostatic_pressure").into());
                }
                self.state.hydrostatic_pressure[points].copy_from_slice(values);
            }
            _ => return Err(CallError::NotSettable { unit: self.name(), variable: variable.name }.into()),
        }
        Ok(())
    }

    /// **Errors**: [`CallError::Order`], [`CallError::Time`], [`DamError::OutOfRange`] for a step that is not
    /// positive, [`DamError::NonFinite`]. After an error the state of the dam is unchanged.
    fn step(&mut self, time: f64, communication_step: f64) -> Result<(), DamError> {
        if !self.state.initialised {
            return Err(self.order("step").into());
        }
        let step = communication_step;
        crate::error::require(step > 0.0, "communication_step", step, "positive")?;
        let (longest, requirement) =
            (MOST_TIME_STEPS * self.time_step_limit(), "no longer than 1e7 time steps");
        crate::error::require(step <= longest, "communication_step", step, requirement)?;
        if (time - self.state.time).abs() > TIME_TOLERANCE * step || !time.is_finite() {
            return Err(CallError::Time { unit: self.name(), asked: time, time: self.state.time }.into());
        }
        if let Some(error) = self.energy_watch.look(&self.state.energy) {
            tracing::warn!(
                "at t = {time} s the error of the energy balance is {:.2} % of the peak kinetic energy; reduce the time \
                 step's safety factor or refine the mesh",
                100.0 * error
            );
        }
        self.state.energy_watch = self.energy_watch;
        self.tell_of_departure();
        let mut motion = self.state.motion.clone();
        let mut trials = self.take_trials(time, step);
        trials.set_fuses(motion.joints_mut());
        let uplift = self.uplift_at(time + step);
        if let Some(joints) = &self.model.body().joints {
            joints.relieve(motion.joints_mut(), [&self.state.uplift, &uplift]);
        }
        let mut energy = self.state.energy;
        let end = time + step;
        let inputs = self.inputs_at_start();
        let start = self.acting(&inputs, self.state.uplift.clone());
        let target = self.acting(&self.state.next, uplift);
        let mut moving = self.model.with(&mut motion)?;
        let calm = self.calm_time_steps(step).filter(|_| trials.may_be_calm());
        let steps = TimeSteps { calm, others: self.time_steps(step) };
        let Advanced { calm, spared } = moving.advance(steps, [&start, &target], &mut energy.work);
        energy.now = moving.stored_energy();
        trials.observe(self.state.motion.joints(), motion.joints_mut(), calm);
        self.keep_trials(trials);
        self.check_motion(&motion, end)?;
        motion.joints_mut().iter_mut().flatten().for_each(|joint| joint.relief = 0.0);
        let state = &mut self.state;
        let velocities = motion.velocity().iter().zip(state.motion.velocity());
        for (mean, (after, before)) in state.mean_acceleration.iter_mut().zip(velocities) {
            *mean = (after - before) / step;
        }
        let (ground, ground_end) = (inputs.ground_acceleration, state.next.ground_acceleration);
        state.mean_ground_acceleration = [0, 1].map(|d| (ground[d] + ground_end[d]) / 2.0);
        let pressures = inputs.pressure.iter().zip(&state.next.pressure);
        let pressures =
            pressures.zip(&state.hydrostatic_pressure).map(|((p, end), rest)| (p + end) / 2.0 + rest);
        state.mean_base_force = self.base.force(
            &state.mean_acceleration,
            [state.motion.velocity(), motion.velocity()],
            spared.map(|impulse| impulse / step),
            state.mean_ground_acceleration,
            pressures,
        );
        state.energy = energy;
        state.motion = motion;
        state.accepted.clone_from(&state.next);
        state.uplift = target.uplift;
        state.time = end;
        let mean = self.mean_interface_acceleration();
        self.state.interface_acceleration.step(&mean, step);
        self.derived = Derived::default();
        self.sample(step);
        Ok(())
    }

    fn get(&self, value_reference: u32, values: &mut [f64]) -> Result<(), DamError> {
        let variable = self.variable(value_reference)?;
        self.check_length(variable, values.len())?;
        self.output(variable, values)
    }

    fn get_at(&self, value_reference: u32, places: &[usize], values: &mut [f64]) -> Result<(), DamError> {
        let variable = self.variable(value_reference)?;
        let axis = [variable::NODE_DISPLACEMENT_X, variable::NODE_DISPLACEMENT_Y]
            .iter()
            .position(|of| of == variable);
        if let Some(axis) = axis.filter(|_| self.state.initialised) {
            self.displacements_at(axis, places, values);
            return Ok(());
        }
        get_all_at(self, value_reference, places, values)
    }

    fn save_state(&self) -> DamState {
        self.state.clone()
    }

    /// **Errors**: [`StateError::Fingerprint`] for the state of another dam.
    fn restore_state(&mut self, state: &DamState) -> Result<(), DamError> {
        self.check_state(state)?;
        self.state.clone_from(state);
        self.trials.retain(|trials| trials.time() >= state.time);
        self.derived = Derived::default();
        if state.initialised {
            self.energy_watch.restore(state.energy_watch);
        } else {
            // Another run begins, which owes nothing to the attempts of the last.
            self.trials.clear();
            self.energy_watch = EnergyWatch::default();
        }
        Ok(())
    }

    fn serialise_state(&self, state: &DamState) -> Result<Vec<u8>, DamError> {
        self.check_state(state)?;
        Ok(seal(self.fingerprint, state)?)
    }

    fn deserialise_state(&self, bytes: &[u8]) -> Result<DamState, DamError> {
        let state: DamState = open(self.fingerprint, bytes)?;
        self.check_state(&state)?;
        let known = |motion: &Motion| self.structure().knows(&motion.meetings);
        if !state.has_shape_of(&self.state) || !state.motion.of_nodes().is_none_or(known) {
            return Err(StateError::NotAState { length: bytes.len() }.into());
        }
        Ok(state)
    }

    fn directional_derivative(
        &self,
        unknown: u32,
        known: u32,
        _seed: &[f64],
        _sensitivity: &mut [f64],
    ) -> Result<(), DamError> {
        Err(CallError::Derivative { unit: self.name(), unknown, known }.into())
    }
}

/// Largest difference between the start of a step and the time of the unit, as a share of the step. It allows for
/// rounding in sums of steps.
const TIME_TOLERANCE: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Meeting;
    use crate::{Damping, Material, Section};

    /// A state of another mesh, or a damaged one.
    #[test]
    fn a_state_with_a_meeting_that_cannot_be_is_refused() -> Result<(), DamError> {
        let parameters = DamParameters {
            section: Section::rectangle(2.0, 4.0),
            water_depth: 0.0,
            cracks: vec![CrackParameters::sliding(3.0, 0.1, 1e9, 0.5e9)],
            material: Material { young_modulus: 1e9, density: 2400.0, ..Default::default() },
            damping: Damping::None,
            element_size: 1.0,
            ..Default::default()
        };
        let dam = Dam::new(parameters)?;
        for (meeting, fits) in [
            (Meeting::open(0, Some(1)), true),
            (Meeting::open(u32::MAX, None), false),
            (Meeting::open(0, Some(u32::MAX)), false),
        ] {
            let mut state = dam.save_state();
            if let DamMotion::Nodes(motion) = &mut state.motion {
                motion.meetings.push(meeting);
            }
            let read = dam.deserialise_state(&dam.serialise_state(&state)?);
            assert_eq!(read.is_ok(), fits, "{read:?}");
        }
        Ok(())
    }
}
