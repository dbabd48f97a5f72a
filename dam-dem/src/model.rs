//! The dam's equations of motion at its level of fidelity.

use cofferdam_unit::StateError;
use nalgebra::DVector;
use std::num::NonZeroUsize;
use std::sync::Arc;

use crate::contact::{Coulomb, MohrCoulomb};
use crate::damping::DAMPED_SHARE;
use crate::energy::{StoredEnergy, Work};
use crate::integrator::{CentralDifference, DynamicRelaxation, Relaxed, SparseNewton};
use crate::loads::{Acting, Constant, Inertia, Joints, Load, LoadPath, Loads, Water, Weight};
use crate::reduction::{ModalLoadPath, ModalMotion, Superposition};
use crate::state::DamMotion;
use crate::structure::{Motion, Structure};
use crate::time_step::{SHARE_WITH_DASHPOTS, SHARE_WITHOUT_DASHPOTS, highest_mode};
use crate::wet::Wet;
use crate::{
    CrackParameters, CriticalTimeStep, DamError, DamParameters, DampingCoefficients, Fidelity, LimitingPart,
    modal,
};

/// The structure, and what acts on it.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub structure: Structure<MohrCoulomb>,
    pub wet: Option<Wet>,
    pub loads: Loads,
    /// Sum of the static loads, N/m.
    pub applied: [f64; 2],
    /// Those of the loads that come from the water in joints, if there are any.
    pub joints: Option<Arc<Joints>>,
}

/// The coordinates in which the dam moves, and its equations of motion in them.
#[derive(Clone, Debug)]
pub(crate) enum Model {
    /// Displacements of all nodes ([`Fidelity::Dem`]).
    Elements(Elements),
    /// Coordinates of modes (all other levels).
    Modes(Modes),
}

/// Every element and every contact.
#[derive(Clone, Debug)]
pub(crate) struct Elements {
    body: Body,
    damping: DampingCoefficients,
    critical_time_step: CriticalTimeStep,
    limiting_part: LimitingPart,
}

/// Modes of the structure, and contacts between its blocks.
#[derive(Clone, Debug)]
pub(crate) struct Modes {
    body: Body,
    damping: DampingCoefficients,
    superposition: Box<Superposition>,
}

/// The time steps of a communication step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimeSteps {
    /// If every contact sticks; none if that is not tried.
    pub calm: Option<CentralDifference>,
    /// Otherwise.
    pub others: CentralDifference,
}

/// What became of a communication step.
pub(crate) struct Advanced {
    /// Whether every contact stuck, where this decides on the time steps; otherwise true.
    pub calm: bool,
    /// Impulse that mass damping did not take from blocks because they slid or rocked, N s/m.
    pub spared: [f64; 2],
}

/// A model with a motion in its own coordinates.
pub(crate) enum Moving<'a> {
    Elements(&'a Elements, &'a mut Motion),
    Modes(&'a Modes, &'a mut ModalMotion),
}

impl From<&CrackParameters> for MohrCoulomb {
    fn from(crack: &CrackParameters) -> Self {
        let peak = crack.friction_coefficient;
        Self {
            residual: Coulomb {
                friction: crack.residual_friction_coefficient.unwrap_or(peak),
                normal_stiffness: crack.normal_stiffness,
                shear_stiffness: crack.shear_stiffness,
            },
            friction: peak,
            cohesion: crack.cohesion,
            tensile_strength: crack.tensile_strength,
            dilation: crack.dilation,
            dilation_slip: crack.dilation_slip.unwrap_or(f64::INFINITY),
        }
    }
}

impl Body {
    /// The body of checked `parameters` with `cracks` from the base up, and the frequencies at which its
    /// damping ratio holds (rad/s).
    fn new(parameters: &DamParameters, cracks: &[CrackParameters]) -> Result<(Self, [f64; 2]), DamError> {
        let (dry, wet) = Self::structure(parameters, cracks)?;
        let damping_frequencies =
            parameters.damping.frequencies(|| Ok(modal::natural_frequencies(&dry, 1)?[0]))?;
        let structure = match &parameters.added_mass {
            Some(rows) => dry.in_water(wet.as_ref(), rows)?,
            None => dry,
        };
        Ok((Self::loaded(structure, wet, parameters, cracks)?, damping_frequencies))
    }

    /// The body of checked `parameters` with `cracks` from the base up, without added mass.
    ///
    /// **Errors**: [`DamError::WetFace`], [`DamError::PointOutside`].
    pub fn dry(parameters: &DamParameters, cracks: &[CrackParameters]) -> Result<Self, DamError> {
        let (structure, wet) = Self::structure(parameters, cracks)?;
        Self::loaded(structure, wet, parameters, cracks)
    }

    fn structure(
        parameters: &DamParameters,
        cracks: &[CrackParameters],
    ) -> Result<(Structure<MohrCoulomb>, Option<Wet>), DamError> {
        let mesh = parameters.mesh()?;
        let wet = Wet::below(&mesh, parameters.water_levels())?;
        let base = mesh.base.clone();
        let laws = cracks.iter().map(|crack| (MohrCoulomb::from(crack), crack.integration));
        Ok((Structure::new(mesh, parameters.materials(), parameters.kinematics, laws, &base), wet))
    }

    /// A `structure` with the loads of `parameters`.
    fn loaded(
        structure: Structure<MohrCoulomb>,
        wet: Option<Wet>,
        parameters: &DamParameters,
        cracks: &[CrackParameters],
    ) -> Result<Self, DamError> {
        let DamParameters { gravity, static_loads, .. } = parameters;
        let is_cracked = parameters.fidelity.is_cracked();
        let uplifts: Vec<_> = cracks.iter().map(|crack| crack.uplift.clone()).collect();
        let joints = Joints::new(&structure, &uplifts, parameters.water_at_joints())
            .filter(|_| is_cracked)
            .map(Arc::new);
        let mut loads: Vec<Arc<dyn Load>> = vec![Arc::new(Weight::new(&structure.mass, *gravity))];
        if let Some(wet) = &wet {
            loads.push(Arc::new(Water(wet.clone())));
        }
        loads.push(Arc::new(Inertia::new(&structure.mass, structure.added_mass.as_ref())));
        let mut applied = [0.0; 2];
        for load in static_loads {
            let load = Constant::new(load, &structure.mesh, *gravity)?;
            for force in load.basis().resultants() {
                (0..2).for_each(|d| applied[d] += force[d]);
            }
            loads.push(Arc::new(load));
        }
        loads.extend(joints.iter().cloned().map(|joints| joints as Arc<dyn Load>));
        Ok(Self { structure, wet, loads: Loads(loads), applied, joints })
    }

    /// What acts at rest at a `time` (s), with this hydrostatic `pressure` (Pa), while the joints are closed.
    pub fn at_rest(&self, time: f64, pressure: Vec<f64>) -> Acting {
        let uplift = self.joints.as_ref().map_or_else(Vec::new, |joints| joints.closed(time));
        Acting { pressure, ground_acceleration: [0.0; 2], uplift }
    }

    /// Nodal forces of all loads, N/m.
    pub fn forces(&self, acting: &Acting) -> Vec<[f64; 2]> {
        self.loads.forces(self.structure.mesh.nodes.len(), acting)
    }
}

impl Model {
    /// The model of checked `parameters` with `cracks` from the base up, and the frequencies at which its
    /// damping ratio holds (rad/s).
    ///
    /// **Errors**: [`DamError::WetFace`], [`DamError::Singular`], [`DamError::FrequenciesNotConverged`],
    /// [`DamError::TooManyFrequencies`]; those of [`AddedMass::new`](crate::AddedMass::new).
    pub fn new(parameters: &DamParameters, cracks: &[CrackParameters]) -> Result<(Self, [f64; 2]), DamError> {
        let (body, damping_frequencies) = Body::new(parameters, cracks)?;
        let rayleigh = parameters.damping.coefficients(damping_frequencies);
        let (structure, drags_blocks) = (&body.structure, parameters.drags_blocks);
        let model = match parameters.fidelity {
            Fidelity::Dem => {
                let mode = highest_mode(structure)?;
                let (frequency, limiting_part) = (mode.frequency, LimitingPart::of(structure, &mode));
                let damping = DampingCoefficients {
                    rayleigh,
                    memory: 0.0,
                    local: parameters.damping.local(),
                    drags_blocks,
                };
                let bound = CriticalTimeStep::of_frequency(structure, damping, frequency).highest_frequency;
                let memory = rayleigh.memory_reaching(DAMPED_SHARE, bound);
                let damping = DampingCoefficients { memory, ..damping };
                let critical_time_step = CriticalTimeStep::of_frequency(structure, damping, frequency);
                Self::Elements(Elements { body, damping, critical_time_step, limiting_part })
            }
            fidelity => {
                let kinematics = parameters.kinematics;
                let damping = DampingCoefficients { rayleigh, drags_blocks, ..DampingCoefficients::NONE };
                let superposition =
                    Superposition::new(structure, damping, fidelity, kinematics, &body.loads)?;
                let damping = DampingCoefficients { memory: superposition.dashpots().memory, ..damping };
                let superposition = Box::new(superposition);
                Self::Modes(Modes { body, damping, superposition })
            }
        };
        Ok((model, damping_frequencies))
    }

    /// The same model, whose elements are evaluated by `threads`. Modes need no elements.
    ///
    /// **Errors**: [`DamError::Threads`].
    pub fn on_threads(self, threads: NonZeroUsize) -> Result<Self, DamError> {
        match self {
            Self::Elements(Elements {
                body: Body { structure, wet, loads, applied, joints },
                damping,
                critical_time_step,
                limiting_part,
            }) => {
                let body = Body { structure: structure.on_threads(threads)?, wet, loads, applied, joints };
                Ok(Self::Elements(Elements { body, damping, critical_time_step, limiting_part }))
            }
            modes @ Self::Modes(_) => Ok(modes),
        }
    }

    pub fn body(&self) -> &Body {
        match self {
            Self::Elements(elements) => &elements.body,
            Self::Modes(modes) => &modes.body,
        }
    }

    /// The modes, if it has any.
    pub fn superposition(&self) -> Option<&Superposition> {
        match self {
            Self::Elements(_) => None,
            Self::Modes(modes) => Some(&modes.superposition),
        }
    }

    /// Coefficients of its damping. Modes use the memory for the dashpots of contacts only.
    pub fn damping(&self) -> DampingCoefficients {
        match self {
            Self::Elements(elements) => elements.damping,
            Self::Modes(modes) => modes.damping,
        }
    }

    pub fn critical_time_step(&self) -> CriticalTimeStep {
        match self {
            Self::Elements(elements) => elements.critical_time_step,
            Self::Modes(modes) => modes.superposition.critical_time_step(),
        }
    }

    /// What limits the time step of all elements; modes are nowhere.
    pub fn limiting_part(&self) -> Option<&LimitingPart> {
        match self {
            Self::Elements(elements) => Some(&elements.limiting_part),
            Self::Modes(_) => None,
        }
    }

    /// Largest time step as a share of 2/ω, which contacts that open and close require.
    pub fn largest_share(&self) -> f64 {
        match self.damping().rayleigh.stiffness {
            _ if self.body().structure.cracks.is_empty() => 1.0,
            0.0 => SHARE_WITHOUT_DASHPOTS,
            _ => SHARE_WITH_DASHPOTS,
        }
    }

    /// No displacement, no velocity, all contacts just closed.
    pub fn at_rest(&self) -> DamMotion {
        match self {
            Self::Elements(elements) => DamMotion::Nodes(elements.body.structure.at_rest()),
            Self::Modes(modes) => DamMotion::Modes(modes.superposition.at_rest()),
        }
    }

    /// Value at `node` of a `field` in the coordinates of this model.
    pub fn at_node(&self, node: usize, field: &[f64]) -> [f64; 2] {
        match self {
            Self::Elements(_) => [field[2 * node], field[2 * node + 1]],
            Self::Modes(modes) => modes.superposition.at_node(node, field),
        }
    }

    /// Nodal forces (x, then y of each node) as forces on the coordinates of this model.
    pub fn on_coordinates(&self, nodal: DVector<f64>) -> Vec<f64> {
        match self {
            Self::Elements(_) => nodal.data.into(),
            Self::Modes(modes) => modes.superposition.force_of(&nodal),
        }
    }

    /// This model with `motion`.
    ///
    /// **Errors**: [`StateError::NotAState`] for a motion in the coordinates of another model.
    pub fn with<'a>(&'a self, motion: &'a mut DamMotion) -> Result<Moving<'a>, StateError> {
        match (self, motion) {
            (Self::Elements(elements), DamMotion::Nodes(motion)) => Ok(Moving::Elements(elements, motion)),
            (Self::Modes(modes), DamMotion::Modes(motion)) => Ok(Moving::Modes(modes, motion)),
            (_, motion) => Err(StateError::NotAState { length: motion.displacement().len() }),
        }
    }
}

impl Moving<'_> {
    /// Brings the motion to rest under what acts `at_rest`. Returns the name of the method that converged.
    ///
    /// **Errors**: [`DamError::StaticNotConverged`], [`DamError::Singular`].
    pub fn relax(&mut self, at_rest: &Acting) -> Result<(&'static str, Relaxed), DamError> {
        match self {
            Self::Elements(Elements { body, .. }, motion) => {
                let (structure, forces) = (&body.structure, body.forces(at_rest));
                let mut by_newton = motion.clone();
                let found = match SparseNewton::default().relax(structure, &mut by_newton, &forces) {
                    Ok(rest) => {
                        **motion = by_newton;
                        ("Newton's iteration", rest)
                    }
                    Err(DamError::StaticNotConverged { .. }) => {
                        let rest = DynamicRelaxation::default().relax(structure, motion, &forces)?;
                        ("dynamic relaxation", rest)
                    }
                    Err(error) => return Err(error),
                };
                Ok(found)
            }
            Self::Modes(Modes { superposition, body, .. }, motion) => {
                let rest = superposition.relax(motion, &superposition.forces(&body.loads, at_rest))?;
                Ok(("Newton's iteration", rest))
            }
        }
    }

    /// Brings the accelerations of a motion at rest to those under what acts at the `start`.
    pub fn begin(&mut self, start: &Acting) {
        match self {
            Self::Elements(Elements { body, damping, .. }, motion) => {
                body.structure.accelerate(*damping, motion, &body.forces(start));
            }
            Self::Modes(Modes { superposition, .. }, motion) => superposition.press_contacts(motion),
        }
    }

    /// Takes time steps under loads that vary linearly from `start` to `end`; adds what was done to `work`.
    pub fn advance(
        &mut self,
        TimeSteps { calm, others }: TimeSteps,
        [start, end]: [&Acting; 2],
        work: &mut Work,
    ) -> Advanced {
        match self {
            Self::Elements(Elements { body, damping, .. }, motion) => {
                let [start, mut change] = [start, end].map(|acting| body.forces(acting));
                let flat = change.as_flattened_mut().iter_mut().zip(start.as_flattened());
                flat.for_each(|(end, start)| *end -= start);
                let loads = LoadPath { start, change };
                Advanced {
                    calm: true,
                    spared: others.advance(&body.structure, *damping, motion, &loads, work),
                }
            }
            Self::Modes(Modes { superposition, body, .. }, motion) => {
                let [start, end] = [start, end].map(|acting| superposition.forces(&body.loads, acting));
                let loads = ModalLoadPath { start, end };
                let calm = calm.and_then(|steps| superposition.advance_calmly(steps, motion, &loads, work));
                match calm {
                    Some(spared) => Advanced { calm: true, spared },
                    None => Advanced {
                        calm: !superposition.has_calm_steps(),
                        spared: superposition.advance(others, motion, &loads, work),
                    },
                }
            }
        }
    }

    pub fn stored_energy(&self) -> StoredEnergy {
        match self {
            Self::Elements(elements, motion) => elements.body.structure.stored_energy(motion),
            Self::Modes(modes, motion) => modes.superposition.stored_energy(motion),
        }
    }

    /// Accelerations at the start, relative to a ground that moves with `ground` (m/s²), and that of the
    /// ground, from which the force on the base follows. Modes start at rest on a ground at rest.
    pub fn initial_acceleration(&self, ground: [f64; 2]) -> (Vec<f64>, [f64; 2]) {
        match self {
            Self::Elements(_, motion) => (motion.acceleration.as_flattened().to_vec(), ground),
            Self::Modes(_, motion) => (vec![0.0; motion.coordinates.len()], [0.0; 2]),
        }
    }
}
