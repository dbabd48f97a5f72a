//! The built-in units: the only place that knows the solvers.

use dam_dem::{
    CrackParameters, Dam, DamError, DamParameters, Damping, DampingFrequencies, Kinematics, Material, Plane,
    Section,
};
use interface::{WetFace, WetFaceError};
use orchestrator::participant::{InProcess, Messages, Participant, Prescribed};
use orchestrator::scene::{DamScene, FidelityScene, KinematicsScene, PlaneScene, Scene};
use orchestrator::scheme::{SchemeKind, Side};
use reservoir::{Fidelity, Reservoir, ReservoirError, ReservoirParameters, added_mass};
use std::num::NonZeroUsize;

/// Most time steps of the dam in a communication step: beyond, no run would end.
const MOST_TIME_STEPS: usize = 20_000;

/// A unit that cannot be made from a scene.
#[derive(Debug, thiserror::Error)]
pub enum RegistryError {
    /// The dam.
    #[error(transparent)]
    Dam(#[from] DamError),
    /// The reservoir.
    #[error(transparent)]
    Reservoir(#[from] ReservoirError),
    /// The dam's time step is next to nothing.
    #[error(
        "the dam needs {time_steps} time steps of {limit:e} s in a communication step, {MOST_TIME_STEPS} are the most; \
         lower the joint stiffness or the damping, or use larger elements"
    )]
    TimeSteps {
        /// Time steps a communication step.
        time_steps: usize,
        /// Longest stable time step, s.
        limit: f64,
    },
    /// The prescribed dam.
    #[error(transparent)]
    Prescribed(#[from] interface::StateError),
    /// The wet face.
    #[error(transparent)]
    WetFace(#[from] WetFaceError),
}

/// Makes the unit of `side` of a scene that has been loaded.
pub fn unit(side: Side, scene: &Scene, threads: NonZeroUsize) -> Result<Box<dyn Participant>, RegistryError> {
    match (side, &scene.dam) {
        (Side::Dam, Some(dam)) => computed_dam(dam, scene),
        (Side::Dam, None) => Ok(Box::new(Prescribed::new(wet_face(scene)?)?)),
        (Side::Reservoir, _) => reservoir(scene, threads),
    }
}

fn computed_dam(dam: &DamScene, scene: &Scene) -> Result<Box<dyn Participant>, RegistryError> {
    let messages = Messages::default();
    let (dam, time_steps) = messages.listen(|| made_dam(dam_parameters(dam, scene)?, scene))?;
    let solver = format!(
        "distinct elements {}: {} elements, {} nodes, {time_steps} time steps a communication step",
        env!("CARGO_PKG_VERSION"),
        dam.element_count(),
        dam.node_count(),
    );
    Ok(Box::new(InProcess::new(dam, &solver, messages)))
}

/// Makes the dam; also returns its time steps a communication step of `scene`.
///
/// **Errors**: those of the dam, and [`RegistryError::TimeSteps`].
pub fn made_dam(parameters: DamParameters, scene: &Scene) -> Result<(Dam, usize), RegistryError> {
    let dam = Dam::new(parameters)?;
    let longest = scene.time.adaptive.map_or(scene.time.communication_step, |adaptive| adaptive.longest);
    let time_steps = dam.time_steps_per(longest);
    if time_steps > MOST_TIME_STEPS {
        return Err(RegistryError::TimeSteps { time_steps, limit: dam.time_step_limit() });
    }
    Ok((dam, time_steps))
}

fn reservoir(scene: &Scene, threads: NonZeroUsize) -> Result<Box<dyn Participant>, RegistryError> {
    let wet_face = reservoir_face(scene)?;
    let points = wet_face.len();
    let messages = Messages::default();
    let reservoir = messages.listen(|| Reservoir::new(reservoir_parameters(scene, wet_face), threads))?;
    let model = match scene.reservoir.fidelity {
        FidelityScene::Compressible => "compressible water, boundary elements",
        FidelityScene::Incompressible => "incompressible water, boundary elements",
        FidelityScene::Westergaard => "Westergaard's added mass",
    };
    let solver = format!("{model} {}: {points} interface points", env!("CARGO_PKG_VERSION"));
    Ok(Box::new(InProcess::new(reservoir, &solver, messages)))
}

/// The reservoir's wet face: the dam's, divided anew if the scene gives the reservoir panels of its own.
pub fn reservoir_face(scene: &Scene) -> Result<WetFace, RegistryError> {
    let face = wet_face(scene)?;
    Ok(match scene.reservoir.interface_size {
        Some(size) => face.respaced(size)?,
        None => face,
    })
}

/// The wet face of the scene's dam: either unit finds the same by itself.
pub fn wet_face(scene: &Scene) -> Result<WetFace, RegistryError> {
    let depth = scene.reservoir.depth;
    let straight = |batter, panels| WetFace::straight([batter, depth], panels);
    Ok(match (&scene.dam, &scene.prescribed) {
        (Some(dam), _) => dry_dam(dam, scene).wet_face()?.map_or_else(|| straight(0.0, 1), Ok)?,
        (None, Some(prescribed)) => straight(prescribed.batter, prescribed.panels)?,
        (None, None) => straight(0.0, 1)?,
    })
}

/// The parameters of the dam of a scene, with the water's added mass if the scheme wants it there.
///
/// **Errors**: the wet face, and those of the reservoir that the mass is taken from.
pub fn dam_parameters(dam: &DamScene, scene: &Scene) -> Result<DamParameters, RegistryError> {
    let mut parameters = dry_dam(dam, scene);
    if scene.scheme() == SchemeKind::AddedMass {
        // At the dam's own points, whatever the reservoir's are.
        let mass = added_mass(&reservoir_parameters(scene, wet_face(scene)?))?;
        parameters.added_mass = Some(mass.row_iter().map(|row| row.iter().copied().collect()).collect());
    }
    Ok(parameters)
}

fn dry_dam(dam: &DamScene, scene: &Scene) -> DamParameters {
    let DamScene { section, material, damping, .. } = dam;
    let frequencies = match (damping.multiples_of_first, damping.radians_per_second) {
        (Some(multiples), _) => Some(DampingFrequencies::MultiplesOfFirst(multiples)),
        (None, radians) => radians.map(DampingFrequencies::RadiansPerSecond),
    };
    DamParameters {
        section: Section { upstream: section.upstream.clone(), downstream: section.downstream.clone() },
        water_depth: scene.reservoir.depth,
        cracks: dam
            .cracks
            .iter()
            .map(|crack| CrackParameters {
                elevation: crack.elevation,
                friction_coefficient: crack.friction_coefficient,
                normal_stiffness: crack.normal_stiffness,
                shear_stiffness: crack.shear_stiffness,
            })
            .collect(),
        material: Material {
            young_modulus: material.young_modulus,
            poisson_ratio: material.poisson_ratio,
            density: material.density,
            plane: match material.plane {
                PlaneScene::Stress => Plane::Stress,
                PlaneScene::Strain => Plane::Strain,
            },
        },
        damping: match frequencies {
            Some(frequencies) if damping.ratio > 0.0 => {
                Damping::Rayleigh { ratio: damping.ratio, frequencies }
            }
            _ => Damping::None,
        },
        kinematics: match dam.kinematics {
            KinematicsScene::Small => Kinematics::Small,
            KinematicsScene::Corotational => Kinematics::Corotational,
        },
        element_size: dam.element_size,
        gravity: scene.gravity,
        time_step_safety: dam.time_step_safety,
        added_mass: None,
    }
}

/// The parameters of the reservoir of a scene.
pub fn reservoir_parameters(scene: &Scene, wet_face: WetFace) -> ReservoirParameters {
    let water = &scene.reservoir;
    let communication_step = scene.time.communication_step;
    ReservoirParameters {
        wet_face,
        density: water.density,
        sound_speed: water.sound_speed,
        wave_reflection_coefficient: water.wave_reflection_coefficient,
        gravity: scene.gravity,
        fidelity: match water.fidelity {
            FidelityScene::Westergaard => Fidelity::Westergaard,
            FidelityScene::Incompressible => Fidelity::Incompressible,
            FidelityScene::Compressible => Fidelity::Compressible,
        },
        element_size: water.element_size.unwrap_or(water.depth / 16.0),
        far_end_distance: water.far_end_distance.unwrap_or(water.depth / 2.0),
        communication_step,
        horizon: scene.steps() as f64 * communication_step,
    }
}
