//! The built-in units of a scene.

use crate::cache::Cache;
use crate::participant::{EmptyReservoir, Prescribed};
use crate::units::{DAM, RESERVOIR, TAILWATER, wet_face_interface};
use cofferdam_coupling::participant::{InProcess, Messages, Participant, ParticipantError};
use cofferdam_coupling::scheme::{CouplingError, Graph, Interface, Port, SchemeKind, UnitId};
use cofferdam_scene::mesh_file::MeshFileError;
use cofferdam_scene::{
    CommandScene, DamScene, LoadedScene, Refusal, ReservoirScene, Scene, SceneError, Side, Source, UnitChecks,
};
use dam_dem::{Dam, DamError, DamParameters, GivenMesh};
pub use dam_dem::{Flutter, LimitEquilibrium, LimitingPart, Mesh, NaturalModes, PartKind, Quality};
use interface::{Fingerprint, Packable, WetFace, WetFaceError};
use nalgebra::{Complex, DMatrix};
pub use reservoir::paper::{FarEndCondition, ShortWindows};
use reservoir::{Fidelity, Method, Reservoir, ReservoirError, ReservoirParameters, added_mass, paper};
use std::num::NonZeroUsize;
use std::path::Path;
use std::time::Instant;

mod cracks;
mod foreign;
mod made_from;
mod water_field;

pub use cracks::{Equilibrium, UpliftEffect, equilibria, flutter, limit_equilibria};
pub use foreign::{adapted, brief, place, role, source};
pub use made_from::made_from;
pub use water_field::water_field;

/// Most time steps of the dam in a communication step: beyond, no run would end.
const MOST_TIME_STEPS: usize = 20_000;

/// A unit that cannot be made from a scene.
#[derive(Debug, thiserror::Error)]
pub enum RegistryError {
    /// The scene has no such unit.
    #[error(
        "the scene has no unit number {number}; the dam is number 0, the reservoir number 1, and the tailwater number 2 where there \
         is a [tailwater]"
    )]
    NoUnit {
        /// Number asked for.
        number: usize,
    },
    /// The dam.
    #[error(transparent)]
    Dam(#[from] DamError),
    /// The reservoir.
    #[error(transparent)]
    Reservoir(#[from] ReservoirError),
    /// The tailwater.
    #[error("tailwater: {0}")]
    Tailwater(#[source] ReservoirError),
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
    /// The prescribed dam, or the empty reservoir.
    #[error(transparent)]
    Face(#[from] interface::StateError),
    /// The units cannot be connected.
    #[error(transparent)]
    Graph(#[from] CouplingError),
    /// There is no water to compute.
    #[error("the reservoir is empty: `reservoir.fidelity` is \"none\"; choose another fidelity")]
    Empty,
    /// The water is another program's.
    #[error(
        "`reservoir.fidelity` is {fidelity:?}: this program does not compute that water; choose another fidelity"
    )]
    Foreign {
        /// The word in the scene.
        fidelity: String,
    },
    /// A unit that is a process, where there is none for it.
    #[error(
        "{unit}: it is a process of its own (`{unit}.command`), which this command does not start; use `cofferdam run`"
    )]
    Process {
        /// Name of the unit.
        unit: &'static str,
    },
    /// A unit of another program.
    #[error(transparent)]
    Participant(#[from] ParticipantError),
    /// The mesh of the dam.
    #[error(transparent)]
    Mesh(#[from] MeshFileError),
    /// The wet face.
    #[error(transparent)]
    WetFace(#[from] WetFaceError),
}

/// Reads the scene at `path` as [`LoadedScene::read`] does; the built-in units are asked whether they can be made.
///
/// **Errors**: every problem of the scene at once.
pub fn read(path: &Path, overrides: &[String]) -> Result<LoadedScene, SceneError> {
    LoadedScene::read(path, overrides, &UnitChecks { dam: refused_by_dam, reservoir: refused_by_reservoir })
}

/// What the dam says against a scene.
fn refused_by_dam(scene: &Scene) -> Vec<Refusal> {
    // A crack that is nowhere is reported elsewhere.
    let placed = |dam: &&DamScene| dam.cracks.iter().all(|crack| crack.line().is_some());
    let Some(Ok(parameters)) = scene.dam.as_ref().filter(placed).map(|dam| dry_dam(dam, scene)) else {
        return Vec::new();
    };
    let radians = scene.dam.as_ref().is_some_and(|dam| dam.damping.radians_per_second.is_some());
    let frequencies = if radians { "radians_per_second" } else { "multiples_of_first" };
    let key = |path: &String| match path.as_str() {
        "water_depth" => "reservoir.depth".to_owned(),
        "tailwater_depth" => "tailwater.depth".to_owned(),
        "gravity" => path.clone(),
        "damping.frequencies" => format!("dam.damping.{frequencies}"),
        _ => format!("dam.{path}"),
    };
    let problems = parameters.problems().into_iter();
    let cracks = scene.dam.iter().flat_map(|dam| &dam.cracks);
    let names: Vec<Option<String>> =
        cracks.map(|crack| crack.name.as_ref().map(|_| crack.phrase())).collect();
    let message = |error: DamError| match error {
        DamError::Geometry(error) => error.with_names(&names),
        error => error.to_string(),
    };
    let mut refusals: Vec<Refusal> = problems
        .map(|problem| Refusal {
            keys: problem.keys.iter().map(key).collect(),
            message: message(problem.error),
        })
        .collect();
    if refusals.is_empty() {
        let falls = limit_equilibria(scene).unwrap_or_default().into_iter().filter_map(|equilibrium| {
            let error = equilibrium.check().err()?;
            let index = parameters.cracks_from_the_base_up()[equilibrium.crack];
            let keys = vec![format!("dam.cracks.{index}.friction_coefficient"), "reservoir.depth".to_owned()];
            Some(Refusal { keys, message: error.to_string() })
        });
        refusals.extend(falls);
    }
    refusals
}

/// The dam that this program computes.
fn own_dam(scene: &Scene) -> Option<&DamScene> {
    scene.dam.as_ref().filter(|dam| !dam.fidelity.is_foreign())
}

/// Whether this program computes the dam: it is neither prescribed nor another program's.
pub fn computes_dam(scene: &Scene) -> bool {
    own_dam(scene).is_some()
}

/// The mesh of the dam, if this program computes it.
///
/// **Errors**: those of the dam.
pub fn dam_mesh(scene: &Scene) -> Result<Option<Mesh>, RegistryError> {
    own_dam(scene).map(|dam| Ok(dry_dam(dam, scene)?.mesh()?)).transpose()
}

/// What limits the time step of the dam (s), and its largest time step; `None` below the full model, and for a dam that this program
/// does not compute.
///
/// **Errors**: those of the dam.
pub fn limiting_part(scene: &Scene) -> Result<Option<(LimitingPart, f64)>, RegistryError> {
    let Some(dam) = own_dam(scene).filter(|dam| dam.fidelity.has_elements()) else {
        return Ok(None);
    };
    let dam = Dam::new(dam_parameters(dam, scene, WaterMass::of(scene))?)?;
    Ok(dam.limiting_part().map(|part| (*part, dam.time_step_limit())))
}

/// The `count` lowest natural modes of the dam on an empty reservoir, if this program computes it.
///
/// **Errors**: those of the dam.
pub fn natural_modes(scene: &Scene, count: usize) -> Result<Option<NaturalModes>, RegistryError> {
    own_dam(scene).map(|dam| Ok(dry_dam(dam, scene)?.natural_modes(count)?)).transpose()
}

/// The same with the mass of the waters of the scene, those with a memory as if they were incompressible; none without water, or
/// beside water that is another program's.
///
/// **Errors**: those of the dam, and of the reservoir that the mass is taken from.
pub fn natural_modes_in_water(scene: &Scene, count: usize) -> Result<Option<NaturalModes>, RegistryError> {
    let dam = own_dam(scene).filter(|_| scene.has_water() && !scene.has_foreign_water());
    dam.map(|dam| Ok(dam_parameters(dam, scene, WaterMass::Still)?.natural_modes(count)?)).transpose()
}

/// ρ g of the water upstream and downstream, N/m³; 0 where there is none.
fn specific_weights(scene: &Scene) -> [f64; 2] {
    Side::BOTH.map(|side| filled(scene, side).map_or(0.0, |water| water.density * scene.gravity))
}

/// Whether this program computes water on a side.
fn computed(scene: &Scene, side: Side) -> bool {
    filled(scene, side).is_some_and(|water| !water.fidelity.is_foreign())
}

/// The water on a side, if there is any.
fn filled(scene: &Scene, side: Side) -> Option<&ReservoirScene> {
    scene.water(side).filter(|water| !water.is_empty())
}

/// What the reservoir and the tailwater say against a scene, before its dam, which has nothing to say.
fn refused_by_reservoir(scene: &Scene) -> Vec<Refusal> {
    Side::BOTH.into_iter().flat_map(|side| refused_by_water(scene, side)).collect()
}

fn refused_by_water(scene: &Scene, side: Side) -> Vec<Refusal> {
    let Some(water) = filled(scene, side).filter(|water| !water.fidelity.is_foreign()) else {
        return Vec::new();
    };
    let parameters = match parameters_of_water(scene, side) {
        Ok(parameters) => parameters,
        Err(error) => {
            return vec![Refusal { keys: vec![side.key("depth")], message: error.to_string() }];
        }
    };
    let refusal = |(parameter, error): (&str, ReservoirError)| {
        let key = match parameter {
            "communication_step" => "time.communication_step".to_owned(),
            "horizon" => "time.duration".to_owned(),
            "gravity" => parameter.to_owned(),
            // Where the scene does not give it, it follows from the panels or from the dam's elements.
            "element_size" if water.element_size.is_none() => match water.interface_size {
                Some(_) => side.key("interface_size"),
                None if scene.dam.is_some() => "dam.element_size".to_owned(),
                None => "prescribed.panels".to_owned(),
            },
            _ => side.key(parameter),
        };
        Refusal { keys: vec![key], message: error.to_string().replace("`horizon`", "`time.duration`") }
    };
    parameters.problem().map(refusal).into_iter().collect()
}

/// Whether unit number `id` of the second scene can go on from a state of that of the first though it is another: it is the dam,
/// and only the strength of its cracks differs.
pub fn keeps_state(id: UnitId, [before, after]: [&Scene; 2]) -> bool {
    let (Some(old), Some(new)) = (&before.dam, &after.dam) else { return false };
    let mut stronger = old.clone();
    for (crack, other) in stronger.cracks.iter_mut().zip(&new.cracks) {
        crack.friction_coefficient = other.friction_coefficient;
        crack.residual_friction_coefficient = other.residual_friction_coefficient;
        (crack.cohesion, crack.tensile_strength) = (other.cohesion, other.tensile_strength);
    }
    let dam_as_before = Scene {
        dam: before.dam.clone(),
        coupling: before.coupling.clone(),
        stop: before.stop.clone(),
        snapshots: before.snapshots,
        log: before.log,
        ..after.clone()
    };
    id == DAM && !new.fidelity.is_foreign() && stronger == *new && dam_as_before == *before
}

/// The units of a scene, each at the place of its number: the dam, the reservoir and, if there is one, the tailwater.
pub fn units(scene: &Scene) -> Vec<UnitId> {
    std::iter::once(DAM).chain(scene.waters().map(|(side, _)| unit_of(side))).collect()
}

/// The interfaces of a scene's dam with its waters.
pub fn interfaces(scene: &Scene) -> Vec<Interface> {
    // The inertia of the water column.
    let inertia = scene.reservoir.density * scene.depth();
    let interface = |(side, _)| {
        let structure = Port { unit: DAM, prefix: prefix(side).to_owned() };
        wet_face_interface(structure, Port::of(unit_of(side)), inertia)
    };
    scene.waters().map(interface).collect()
}

/// What the names of the dam's variables of a face begin with.
fn prefix(side: Side) -> &'static str {
    match side {
        Side::Upstream => "",
        Side::Downstream => "tailwater_",
    }
}

/// The unit of the water on a side.
fn unit_of(side: Side) -> UnitId {
    match side {
        Side::Upstream => RESERVOIR,
        Side::Downstream => TAILWATER,
    }
}

/// The name of a built-in unit, in logs and as argument of `cofferdam unit`.
pub fn name(id: UnitId) -> &'static str {
    match id {
        DAM => "dam",
        TAILWATER => Side::Downstream.table(),
        _ => Side::Upstream.table(),
    }
}

/// The side of the water of a unit; none of the dam.
fn side_of(id: UnitId) -> Option<Side> {
    Side::BOTH.into_iter().find(|&side| unit_of(side) == id)
}

/// Where a unit runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Home<'a> {
    /// In the orchestrator, because it computes nothing.
    Here,
    /// In a process of this program, unless the user wants it here.
    Process,
    /// In a process of another program, always.
    Command(&'a CommandScene),
}

/// Where a unit of a scene runs.
pub fn home(id: UnitId, scene: &Scene) -> Home<'_> {
    match source(id, scene) {
        Source::Command(command) => Home::Command(command),
        Source::Log(_) => Home::Here,
        _ if id == RESERVOIR && is_empty(scene) => Home::Here,
        _ => Home::Process,
    }
}

/// With what units are made; from a number of threads, without a cache.
#[derive(Clone, Copy, Debug)]
pub struct Making<'a> {
    /// Threads for what is prepared, and for large meshes of the dam; results do not depend on their number, bit for bit.
    pub threads: NonZeroUsize,
    /// Where operators of the water are kept for the next time.
    pub cache: Option<&'a Cache>,
}

impl From<NonZeroUsize> for Making<'_> {
    fn from(threads: NonZeroUsize) -> Self {
        Self { threads, cache: None }
    }
}

/// The units of a scene in this process, connected.
///
/// **Errors**: a unit that cannot be made.
pub fn graph<'a>(scene: &Scene, making: impl Into<Making<'a>>) -> Result<Graph, RegistryError> {
    let making = making.into();
    let units = units(scene).into_iter().map(|id| unit(id, scene, making)).collect::<Result<_, _>>()?;
    Ok(Graph::new(units, interfaces(scene))?)
}

/// Makes unit number `id` of a scene that has been loaded, in this process.
///
/// **Errors**: those of the unit; [`RegistryError::Process`] for one that is a process of another program.
pub fn unit<'a>(
    id: UnitId,
    scene: &Scene,
    making: impl Into<Making<'a>>,
) -> Result<Box<dyn Participant>, RegistryError> {
    let making = making.into();
    match source(id, scene) {
        Source::BuiltIn => (),
        Source::Fmu(fmu) => return foreign::fmu(id, scene, fmu),
        Source::Log(log) => return foreign::recorded(id, scene, log),
        Source::Command(_) | Source::Untold(_) => return Err(RegistryError::Process { unit: name(id) }),
    }
    match (id, &scene.dam) {
        (DAM, Some(dam)) => computed_dam(dam, scene, making.threads),
        (DAM, None) => Ok(Box::new(Prescribed::new(wet_face(scene)?)?)),
        (RESERVOIR, _) if is_empty(scene) => Ok(Box::new(EmptyReservoir::new(wet_face(scene)?)?)),
        (RESERVOIR, _) => computed_water(scene, Side::Upstream, making),
        (TAILWATER, _) if scene.tailwater.is_some() => computed_water(scene, Side::Downstream, making),
        (UnitId(number), _) => Err(RegistryError::NoUnit { number }),
    }
}

/// Whether the reservoir is one without water, which needs no process of its own.
pub fn is_empty(scene: &Scene) -> bool {
    scene.reservoir.is_empty()
}

fn computed_dam(
    dam: &DamScene,
    scene: &Scene,
    threads: NonZeroUsize,
) -> Result<Box<dyn Participant>, RegistryError> {
    let messages = Messages::default();
    let (dam, time_steps) =
        messages.listen(|| made_dam(dam_parameters(dam, scene, WaterMass::of(scene))?, scene))?;
    let dam = dam.on_threads(threads)?;
    let (elements, nodes, version) = (dam.element_count(), dam.node_count(), env!("CARGO_PKG_VERSION"));
    let modes = dam.modes().map_or(0, |modes| modes.mode_count());
    let model = match dam.parameters().fidelity {
        dam_dem::Fidelity::Dem => format!("distinct elements {version}"),
        dam_dem::Fidelity::Reduced { .. } => format!("reduced blocks {version}, {modes} modes"),
        dam_dem::Fidelity::RigidBlocks => format!("rigid blocks (unsafe) {version}, {modes} modes"),
        dam_dem::Fidelity::Intact { .. } => format!("intact dam {version}, {modes} modes"),
    };
    let calm =
        dam.calm_time_steps_per(longest_step(scene)).map_or_else(String::new, |calm| format!("{calm} to "));
    let solver = format!(
        "{model}: {elements} elements, {nodes} nodes, {calm}{time_steps} time steps a communication step"
    );
    Ok(Box::new(InProcess::new(dam, &solver, messages)))
}

/// Makes the dam; also returns its time steps a communication step of `scene`.
///
/// **Errors**: those of the dam, and [`RegistryError::TimeSteps`].
pub fn made_dam(parameters: DamParameters, scene: &Scene) -> Result<(Dam, usize), RegistryError> {
    let dam = Dam::new(parameters)?;
    let time_steps = dam.time_steps_per(longest_step(scene));
    if time_steps > MOST_TIME_STEPS {
        return Err(RegistryError::TimeSteps { time_steps, limit: dam.time_step_limit() });
    }
    Ok((dam, time_steps))
}

/// The longest communication step of `scene`, s.
fn longest_step(scene: &Scene) -> f64 {
    scene.time.adaptive.map_or(scene.time.communication_step, |adaptive| adaptive.longest)
}

/// The value of `dam.time_step_safety` with which the scene's dam takes time steps of this `part` of their length: 2 for half.
///
/// **Errors**: those of the dam.
pub fn safety_of_part(dam: &DamScene, scene: &Scene, part: f64) -> Result<f64, RegistryError> {
    let (dam, _) = made_dam(dam_parameters(dam, scene, WaterMass::of(scene))?, scene)?;
    Ok(dam.time_step_limit() / (part * dam.critical_time_step().limit))
}

fn computed_water(
    scene: &Scene,
    side: Side,
    making: Making<'_>,
) -> Result<Box<dyn Participant>, RegistryError> {
    let messages = Messages::default();
    let parameters = parameters_of_water(scene, side)?;
    let points = parameters.wet_face.len();
    let named = |error| match side {
        Side::Upstream => RegistryError::Reservoir(error),
        Side::Downstream => RegistryError::Tailwater(error),
    };
    let reservoir = messages.listen(|| made_reservoir(parameters, making)).map_err(named)?;
    let model = match (reservoir.parameters().fidelity, reservoir.parameters().method) {
        (Fidelity::Compressible, Method::FiniteElements) => "compressible water, finite elements",
        (Fidelity::Compressible, _) if reservoir.is_recursion() => "compressible water, recursion",
        (Fidelity::Compressible, _) => "compressible water, boundary elements",
        (Fidelity::Incompressible, _) => "incompressible water, boundary elements",
        (Fidelity::Westergaard, _) => "Westergaard's added mass",
        (Fidelity::WestergaardExact, _) => "Westergaard's added mass, exact profile",
    };
    let solver = format!("{model} {}: {points} interface points", env!("CARGO_PKG_VERSION"));
    Ok(Box::new(InProcess::new(reservoir, &solver, messages)))
}

/// Makes the reservoir of a scene.
///
/// **Errors**: [`RegistryError::Empty`], and those of the reservoir.
pub fn water<'a>(scene: &Scene, making: impl Into<Making<'a>>) -> Result<Reservoir, RegistryError> {
    Ok(made_reservoir(water_parameters(scene)?, making.into())?)
}

/// The name of an operator in the cache.
fn cache_key(parameters: &ReservoirParameters) -> Result<String, ReservoirError> {
    Ok(Fingerprint::of(Reservoir::NAME, parameters)?.to_string())
}

/// A reservoir whose operator is taken from the cache, or kept there.
fn made_reservoir(
    parameters: ReservoirParameters,
    Making { threads, cache }: Making<'_>,
) -> Result<Reservoir, ReservoirError> {
    let Some(cache) = cache.filter(|_| Reservoir::is_prepared(&parameters)) else {
        return Reservoir::new(parameters, threads);
    };
    let key = cache_key(&parameters)?;
    let read = |bytes: &[u8]| Reservoir::from_prepared(parameters.clone(), bytes, threads);
    let make = || Ok(Reservoir::prepare(&parameters, threads)?.unwrap_or_default());
    cache.prepared(&key, read, make)
}

/// Estimated time of making the convolutions of a scene's waters on this machine, s: that of one frequency, times the number
/// of frequencies that are usually needed; 0 of what is in the cache. None if no water is made that way: then it is a matter of
/// a second.
///
/// **Errors**: those of the reservoir.
pub fn preparation_time(
    scene: &Scene,
    Making { threads, cache }: Making<'_>,
) -> Result<Option<f64>, RegistryError> {
    let mut sum = None;
    for side in Side::BOTH.into_iter().filter(|&side| computed(scene, side)) {
        let parameters = parameters_of_water(scene, side)?;
        let Some(frequencies) = reservoir::usual_frequencies(&parameters) else { continue };
        let sum = sum.get_or_insert(0.0);
        let key = cache_key(&parameters)?;
        if cache.is_some_and(|cache| cache.holds(&key)) {
            continue;
        }
        let system = reservoir::boundary_system(&parameters)?;
        let began = Instant::now();
        system.symbol(Complex::new(1.0, 1.0) / parameters.communication_step)?;
        *sum += began.elapsed().as_secs_f64() * frequencies as f64 / threads.get() as f64;
    }
    Ok(sum)
}

/// Hydrostatic pressure at the points of the dam's wet faces, ρg(h − y), Pa, with the name of the dam's variable: what the
/// waters of a scene give its dam before the ground moves.
///
/// **Errors**: the wet face.
pub fn hydrostatic_pressure(scene: &Scene) -> Result<Vec<(String, Vec<f64>)>, RegistryError> {
    let mut found = Vec::new();
    for ((side, _), specific_weight) in scene.waters().zip(specific_weights(scene)) {
        let face = face_of_dam(scene, side)?;
        let pressure = face.points().iter().map(|[_, y]| specific_weight * (face.depth() - y)).collect();
        found.push((format!("{}hydrostatic_pressure", prefix(side)), pressure));
    }
    Ok(found)
}

/// The inputs of a scene's `dam` at rest, with the same pressure at the points that it has itself.
///
/// **Errors**: the dam does not tell its points.
pub fn inputs_at_rest(scene: &Scene, dam: &mut dyn Participant) -> Result<Vec<f64>, ParticipantError> {
    let mut inputs = vec![0.0; dam.description().inputs.size()];
    for ((side, _), specific_weight) in scene.waters().zip(specific_weights(scene)) {
        let of_side = |name: &str| format!("{}{name}", prefix(side));
        let Some(range) = dam.description().inputs.range(&of_side("hydrostatic_pressure")) else { continue };
        let (depth, elevations) = (scene.depth_of(side), dam.read(&of_side("interface_y"))?);
        for (pressure, y) in inputs[range].iter_mut().zip(elevations) {
            *pressure = specific_weight * (depth - y);
        }
    }
    Ok(inputs)
}

/// The parameters of the reservoir of a scene, at its own points.
///
/// **Errors**: [`RegistryError::Empty`], and the wet face.
pub fn water_parameters(scene: &Scene) -> Result<ReservoirParameters, RegistryError> {
    parameters_of_water(scene, Side::Upstream)
}

/// The parameters of the water on a side, at its own points.
///
/// **Errors**: [`RegistryError::Empty`], and the wet face.
pub fn parameters_of_water(scene: &Scene, side: Side) -> Result<ReservoirParameters, RegistryError> {
    reservoir_parameters(scene, face_of_water(scene, side)?)
}

/// The wet face of the water on a side: the dam's, divided anew if the scene gives the water panels of its own.
pub fn face_of_water(scene: &Scene, side: Side) -> Result<WetFace, RegistryError> {
    let face = face_of_dam(scene, side)?;
    Ok(match scene.water(side).and_then(|water| water.interface_size) {
        Some(size) => face.respaced(size)?,
        None => face,
    })
}

/// The dam's wet face on a side.
///
/// **Errors**: [`RegistryError::Empty`] for a side without water, and the wet face.
pub fn face_of_dam(scene: &Scene, side: Side) -> Result<WetFace, RegistryError> {
    match (side, &scene.dam) {
        (Side::Upstream, _) => wet_face(scene),
        (Side::Downstream, Some(dam)) => dry_dam(dam, scene)?.tailwater_face()?.ok_or(RegistryError::Empty),
        (Side::Downstream, None) => Err(RegistryError::Empty),
    }
}

/// The upstream wet face of the scene's dam: either unit finds the same by itself.
pub fn wet_face(scene: &Scene) -> Result<WetFace, RegistryError> {
    let depth = scene.depth();
    let straight = |batter, panels| WetFace::straight([batter, depth], panels);
    Ok(match (&scene.dam, &scene.prescribed) {
        (Some(dam), _) => dry_dam(dam, scene)?.wet_face()?.map_or_else(|| straight(0.0, 1), Ok)?,
        (None, Some(prescribed)) => straight(prescribed.batter, prescribed.panels)?,
        (None, None) => straight(0.0, 1)?,
    })
}

/// The paper's water of a scene, `steps` communication steps a window, before the dam's own points.
pub fn short_windows(
    scene: &Scene,
    steps: usize,
    threads: NonZeroUsize,
) -> Result<ShortWindows, RegistryError> {
    Ok(ShortWindows::new(&reservoir_parameters(scene, wet_face(scene)?)?, steps, threads)?)
}

/// Pressure (Pa) at the dam's points over the whole record of `acceleration` (m/s², points and ground × instants).
pub fn pressure_of_record(
    scene: &Scene,
    far_end: FarEndCondition,
    acceleration: &DMatrix<f64>,
    threads: NonZeroUsize,
) -> Result<DMatrix<f64>, RegistryError> {
    let parameters = reservoir_parameters(scene, wet_face(scene)?)?;
    Ok(paper::pressure_before(far_end, &parameters, acceleration, threads)?)
}

/// K(s) of a scene's water at the dam's points.
pub fn frequency_response(
    scene: &Scene,
    far_end: FarEndCondition,
    s: &[Complex<f64>],
    threads: NonZeroUsize,
) -> Result<Vec<DMatrix<Complex<f64>>>, RegistryError> {
    let parameters = reservoir_parameters(scene, wet_face(scene)?)?;
    Ok(paper::response_before(far_end, &parameters, s, threads)?)
}

/// The water's inertia in the dam's mass matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WaterMass {
    /// None: the water is another unit.
    None,
    /// That of water without memory; water with a memory is refused.
    Exact,
    /// That of the water as if it were incompressible and without waves.
    Still,
}

impl WaterMass {
    /// What the scheme of the scene wants.
    fn of(scene: &Scene) -> Self {
        if scene.scheme() == SchemeKind::OneWay { Self::Exact } else { Self::None }
    }
}

/// The parameters of the dam of a scene, with the water's added mass.
///
/// **Errors**: the wet face, and those of the reservoir that the mass is taken from.
pub fn dam_parameters(
    dam: &DamScene,
    scene: &Scene,
    mass: WaterMass,
) -> Result<DamParameters, RegistryError> {
    let mut parameters = dry_dam(dam, scene)?;
    if mass != WaterMass::None {
        parameters.added_mass = Some(mass_of_water(scene, mass == WaterMass::Still)?);
    }
    Ok(parameters)
}

/// The added mass of the scene's waters at the dam's own points, whatever the waters' are, a row for each; `still` is
/// for water that has a memory, as if it were incompressible and without waves. Waters know of each other by the dam's motion
/// only: the mass has a block for each.
fn mass_of_water(scene: &Scene, still: bool) -> Result<Vec<Vec<f64>>, RegistryError> {
    let mut blocks = Vec::new();
    for (side, _) in scene.waters() {
        let face = face_of_dam(scene, side)?;
        if filled(scene, side).is_none() {
            blocks.push(DMatrix::zeros(face.len(), face.len()));
            continue;
        }
        let mut water = reservoir_parameters(scene, face)?;
        if still && water.fidelity == Fidelity::Compressible {
            water = ReservoirParameters { fidelity: Fidelity::Incompressible, surface_waves: false, ..water };
        }
        blocks.push(added_mass(&water)?);
    }
    let points: usize = blocks.iter().map(DMatrix::nrows).sum();
    let (mut rows, mut first) = (Vec::with_capacity(points), 0);
    for block in blocks {
        for values in block.row_iter() {
            let mut row = vec![0.0; points];
            row[first..first + values.len()].iter_mut().zip(&values).for_each(|(to, value)| *to = *value);
            rows.push(row);
        }
        first += block.nrows();
    }
    Ok(rows)
}

fn dry_dam(dam: &DamScene, scene: &Scene) -> Result<DamParameters, RegistryError> {
    let DamScene {
        fidelity,
        modes,
        element_size,
        kinematics,
        time_step_safety,
        envelopes,
        section,
        mesh: _,
        material,
        zones,
        damping,
        cracks,
        // Other programs' dams, of which only the wet face is needed here.
        fmu: _,
        command: _,
        log: _,
    } = dam;
    Ok(DamParameters {
        section: section.into(),
        water_depth: scene.depth(),
        tailwater_depth: scene.tailwater.as_ref().and_then(|water| water.depth).unwrap_or(0.0),
        cracks: cracks.iter().map(Into::into).collect(),
        material: material.into(),
        damping: damping.into(),
        fidelity: fidelity.level().unwrap_or_default().with_modes(*modes),
        kinematics: *kinematics,
        element_size: *element_size,
        gravity: scene.gravity,
        time_step_safety: *time_step_safety,
        drags_blocks: damping.drags_blocks,
        zones: zones.iter().map(Into::into).collect(),
        given_mesh: given_mesh(dam)?,
        added_mass: None,
        envelopes: *envelopes,
    })
}

/// The mesh from the dam's file, if it has one.
fn given_mesh(dam: &DamScene) -> Result<Option<GivenMesh>, RegistryError> {
    let Some(mesh) = &dam.mesh else { return Ok(None) };
    let names: Vec<Option<String>> = dam.cracks.iter().map(|crack| crack.name.clone()).collect();
    Ok(Some(mesh.mesh(&names)?.into()))
}

/// The parameters of the water of a scene before `wet_face`: of the tailwater, if that is downstream.
///
/// **Errors**: [`RegistryError::Empty`].
pub fn reservoir_parameters(scene: &Scene, wet_face: WetFace) -> Result<ReservoirParameters, RegistryError> {
    let side = if wet_face.is_downstream() { Side::Downstream } else { Side::Upstream };
    let water = scene.water(side).ok_or(RegistryError::Empty)?;
    let communication_step = scene.time.communication_step;
    let fidelity = match water.solver() {
        Some(fidelity) => fidelity,
        None if water.is_empty() => return Err(RegistryError::Empty),
        None => return Err(RegistryError::Foreign { fidelity: water.fidelity.word() }),
    };
    let ReservoirScene {
        density,
        sound_speed,
        wave_reflection_coefficient,
        bed,
        surface_waves,
        method,
        element_order,
        bed_element_size,
        corner_element_size,
        // The wet face, the model and the sizes, which depend on other tables too.
        depth: _,
        fidelity: _,
        profile: _,
        interface_size: _,
        element_size: _,
        far_end_distance: _,
        // Other programs' water.
        fmu: _,
        command: _,
        log: _,
    } = water;
    // A formula knows neither waves nor a bed.
    let solved = fidelity.is_solved();
    Ok(ReservoirParameters {
        density: *density,
        sound_speed: *sound_speed,
        wave_reflection_coefficient: *wave_reflection_coefficient,
        gravity: scene.gravity,
        fidelity,
        surface_waves: solved && *surface_waves,
        bed: if solved { bed.clone() } else { Vec::new() },
        element_order: *element_order,
        element_size: scene.boundary_element_size(side),
        bed_element_size: *bed_element_size,
        corner_element_size: *corner_element_size,
        far_end_distance: scene.far_end_distance(side),
        communication_step,
        horizon: scene.steps() as f64 * communication_step,
        method: match method {
            Method::Automatic if scene.has_varying_steps() => Method::Recursive,
            method => *method,
        },
        ..ReservoirParameters::before(wet_face)
    })
}
