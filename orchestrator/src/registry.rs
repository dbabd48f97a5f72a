//! The built-in units: the only place that knows the solvers.

use dam_dem::{
    CrackParameters, Dam, DamError, DamParameters, Damping, DampingFrequencies, Kinematics, Material, Plane,
    Section,
};
use interface::{WetFace, WetFaceError};
use orchestrator::participant::{InProcess, Participant, Prescribed};
use orchestrator::scene::{DamScene, FidelityScene, KinematicsScene, LoadedScene, PlaneScene, Scene};
use orchestrator::scheme::Units;
use reservoir::{Fidelity, Reservoir, ReservoirError, ReservoirParameters};
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

/// Makes the two units of a scene.
pub fn units(loaded: &LoadedScene, threads: NonZeroUsize) -> Result<Units, RegistryError> {
    let scene = &loaded.scene;
    let depth = scene.reservoir.depth;
    let (dam, wet_face): (Box<dyn Participant>, WetFace) = match (&scene.dam, &scene.prescribed) {
        (Some(dam), _) => {
            let dam = Dam::new(dam_parameters(dam, scene))?;
            let wet_face = dam.wet_face().cloned().map_or_else(|| WetFace::straight([0.0, depth], 1), Ok)?;
            let time_steps = dam.time_steps_per(scene.time.communication_step);
            if time_steps > MOST_TIME_STEPS {
                return Err(RegistryError::TimeSteps { time_steps, limit: dam.time_step_limit() });
            }
            let solver = format!(
                "distinct elements {}: {} elements, {} nodes, {time_steps} time steps a communication step",
                env!("CARGO_PKG_VERSION"),
                dam.element_count(),
                dam.node_count(),
            );
            (Box::new(InProcess::new(dam, &solver)), wet_face)
        }
        (None, prescribed) => {
            let (batter, panels) = prescribed.as_ref().map_or((0.0, 1), |p| (p.batter, p.panels));
            let wet_face = WetFace::straight([batter, depth], panels)?;
            (Box::new(Prescribed::new(wet_face.clone())?), wet_face)
        }
    };
    let points = wet_face.len();
    let reservoir = Reservoir::new(reservoir_parameters(loaded, wet_face), threads)?;
    let model = match scene.reservoir.fidelity {
        FidelityScene::Compressible => "compressible water, boundary elements",
        FidelityScene::Westergaard => "Westergaard's added mass",
    };
    let solver = format!("{model} {}: {points} interface points", env!("CARGO_PKG_VERSION"));
    Ok(Units { dam, reservoir: Box::new(InProcess::new(reservoir, &solver)) })
}

fn dam_parameters(dam: &DamScene, scene: &Scene) -> DamParameters {
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
    }
}

fn reservoir_parameters(loaded: &LoadedScene, wet_face: WetFace) -> ReservoirParameters {
    let water = &loaded.scene.reservoir;
    let communication_step = loaded.scene.time.communication_step;
    ReservoirParameters {
        wet_face,
        density: water.density,
        sound_speed: water.sound_speed,
        wave_reflection_coefficient: water.wave_reflection_coefficient,
        gravity: loaded.scene.gravity,
        fidelity: match water.fidelity {
            FidelityScene::Westergaard => Fidelity::Westergaard,
            FidelityScene::Compressible => Fidelity::Compressible,
        },
        element_size: water.element_size.unwrap_or(water.depth / 16.0),
        far_end_distance: water.far_end_distance.unwrap_or(water.depth / 2.0),
        communication_step,
        horizon: loaded.steps() as f64 * communication_step,
    }
}
