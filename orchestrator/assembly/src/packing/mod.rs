//! The built-in units of a scene as FMUs.

mod coupled;
mod mesh;
mod system;

pub use coupled::{Coupled, CoupledError, CoupledParameters, CoupledState};
pub use system::{PackedSystem, pack_system};

use crate::{Assembly, AssemblyError, WaterMass};
use cofferdam_dam::Dam;
use cofferdam_fmi::export::{FmuError, Library, Package, Page, Version, check_target, crack_names};
use cofferdam_motion::GroundMotion;
use cofferdam_reservoir::Reservoir;
use cofferdam_scene::{Scene, Side};
use cofferdam_unit::Packable;
use cofferdam_unit::export::Contents;
use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::Path;

/// Why a unit of a scene cannot be packed.
#[derive(Debug, thiserror::Error)]
pub enum PackingError {
    /// The dam's motion is prescribed.
    #[error(
        "the scene has no dam to pack: its motion is prescribed; pack the water with --unit reservoir, or give \
         the scene a [dam] instead of [prescribed]"
    )]
    NoDam,
    /// The dam is another program's.
    #[error(
        "the scene's dam is another program's or a run's of the past, and this program cannot pack it; choose a `dam.fidelity` of its own"
    )]
    ForeignDam,
    /// There is no tailwater.
    #[error("the scene has no tailwater to pack; give it a [tailwater]")]
    NoTailwater,
    /// There is no water.
    #[error(
        "the scene's reservoir is empty, so there is no water to pack; pack the dam with --unit dam, or choose a \
         `reservoir.fidelity` other than \"none\""
    )]
    NoWater,
    /// A water is another program's.
    #[error(
        "the scene's {table} is not computed by this program (fidelity \"{fidelity}\"), so that its mass in a step is unknown; \
         choose a `{table}.fidelity` of this program"
    )]
    ForeignWater {
        /// Table of the water in the scene.
        table: &'static str,
        /// Its fidelity.
        fidelity: String,
    },
    /// The steps vary.
    #[error(
        "the scene's steps vary, but the mass of the water in the dam belongs to steps of one length; leave out [time.adaptive]"
    )]
    VaryingSteps,
    /// The unit cannot be made.
    #[error(transparent)]
    Unit(#[from] AssemblyError),
    /// The FMU cannot be made.
    #[error(transparent)]
    Fmu(#[from] FmuError),
    /// The coupled unit cannot be made.
    #[error(transparent)]
    Coupled(#[from] CoupledError),
    /// The scene cannot be written.
    #[error("the scene cannot be written as TOML: {0}")]
    Scene(#[from] toml::ser::Error),
}

/// Where an FMU is written, and with which library.
pub struct Target<'a> {
    /// The FMU's file.
    pub path: &'a Path,
    /// Whether an existing file may be overwritten.
    pub overwrite: bool,
    /// Version of FMI.
    pub version: Version,
    /// The unit's library; by default the one built together with this program.
    pub library: Option<&'a Path>,
}

/// A unit of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// The dam; whether its mass matrix contains the water's inertia.
    Dam {
        /// Whether it does.
        added_mass: bool,
    },
    /// The reservoir or the tailwater.
    Water(Side),
    /// Dam and waters, coupled by the scheme of the scene.
    Coupled,
}

/// What was packed.
pub struct Packed {
    /// Size of the FMU, bytes.
    pub size: u64,
    /// Number of points of the wet face; of a dam, of the upstream one.
    pub interface_points: usize,
    /// Whether the importer may choose the length of communication steps.
    pub variable_step: bool,
}

/// Packs a unit of a loaded scene.
///
/// **Errors**: those of [`check_target`] and [`Package::write`], and a unit that cannot be made from the scene; then
/// nothing is written.
pub fn pack(
    unit: Unit,
    scene: &Scene,
    motion: &GroundMotion,
    target: &Target<'_>,
) -> Result<Packed, PackingError> {
    check_target(target.path, target.overwrite)?;
    match unit {
        Unit::Coupled => whole(scene, motion, target),
        Unit::Dam { added_mass } => dam(scene, added_mass, target),
        Unit::Water(side) => water(scene, side, target),
    }
}

/// Checks that the scene has a dam of this program.
fn check_dam(scene: &Scene) -> Result<(), PackingError> {
    match (&scene.dam, scene.computed_dam()) {
        (None, _) => Err(PackingError::NoDam),
        (_, None) => Err(PackingError::ForeignDam),
        _ => Ok(()),
    }
}

fn dam(scene: &Scene, added_mass: bool, target: &Target<'_>) -> Result<Packed, PackingError> {
    check_dam(scene)?;
    let assembly = Assembly::of(scene);
    let mass = if added_mass { WaterMass::Still } else { WaterMass::None };
    let parameters = assembly.dam_parameters(mass)?;
    // Some mistakes are found only when the dam is made; that takes no longer than a few steps.
    assembly.make_dam(parameters.clone())?;
    // The order of the operations is that of the reservoir, so that the bits are equal.
    let start: BTreeMap<_, _> = assembly.hydrostatic_pressure()?.into_iter().collect();
    let page = page(include_str!("dam.html"), include_str!("dam_example.html"));
    let mesh = mesh::dam(&parameters).map_err(AssemblyError::from)?;
    written(package::<Dam>(scene, contents(start, parameters), None, mesh, page, target)?, target)
}

fn water(scene: &Scene, side: Side, target: &Target<'_>) -> Result<Packed, PackingError> {
    match side {
        Side::Upstream if scene.reservoir.is_empty() => return Err(PackingError::NoWater),
        Side::Downstream if scene.tailwater.is_none() => return Err(PackingError::NoTailwater),
        _ => {}
    }
    let parameters = Assembly::of(scene).water_parameters(side)?;
    parameters.validate().map_err(AssemblyError::from)?;
    let threads = std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
    let prepared = Reservoir::prepare(&parameters, threads).map_err(AssemblyError::from)?;
    let page = page(include_str!("reservoir.html"), include_str!("reservoir_example.html"));
    let mesh = mesh::reservoir(&parameters).map_err(AssemblyError::from)?;
    let contents = contents(BTreeMap::new(), parameters);
    written(package::<Reservoir>(scene, contents, prepared, mesh, page, target)?, target)
}

fn whole(scene: &Scene, motion: &GroundMotion, target: &Target<'_>) -> Result<Packed, PackingError> {
    let parameters = CoupledParameters::of(scene, motion)?;
    // Some mistakes are found only when the dam is made; that takes no longer than a few steps.
    Assembly::of(scene).make_dam(parameters.dam.clone())?;
    let threads = std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
    let prepared = Coupled::prepare(&parameters, threads)?;
    let page = Page {
        about: include_str!("coupled.html"),
        usage: include_str!("coupled_usage.html"),
        example: include_str!("coupled_example.html"),
        notes: include_str!("coupled_notes.html"),
    };
    let mesh = mesh::dam(&parameters.dam).map_err(AssemblyError::from)?;
    let contents = contents(BTreeMap::new(), parameters);
    written(package::<Coupled>(scene, contents, prepared, mesh, page, target)?, target)
}

/// The page of a unit that exchanges fields with another.
fn page(about: &'static str, example: &'static str) -> Page {
    Page { about, usage: include_str!("usage.html"), example, notes: include_str!("notes.html") }
}

/// Contents that leave all inputs to the importer.
fn contents<P>(start: BTreeMap<String, Vec<f64>>, parameters: P) -> Contents<P> {
    Contents { start, parameters, records: Vec::new() }
}

/// Writes an FMU.
fn written<U: Packable>(package: Package<U>, target: &Target<'_>) -> Result<Packed, PackingError> {
    Ok(Packed {
        size: package.write(target.path)?,
        interface_points: package.interface_points(),
        variable_step: U::capabilities_for(&package.contents.parameters).variable_communication_step,
    })
}

/// The FMU of a unit with these contents.
fn package<U: Packable>(
    scene: &Scene,
    contents: Contents<U::Parameters>,
    prepared: Option<Vec<u8>>,
    mesh: Vec<mesh::File>,
    page: Page,
    target: &Target<'_>,
) -> Result<Package<U>, PackingError> {
    let cracks = scene.dam.iter().flat_map(|dam| &dam.cracks);
    Ok(Package::<U> {
        contents,
        prepared,
        title: scene.title.clone(),
        scene: portable(scene)?,
        page,
        communication_step: scene.time.communication_step,
        steps: scene.steps(),
        mesh,
        library: Library::find(U::NAME, target.library)?,
        bounds: cofferdam_scene::bounds,
        version: target.version,
        as_scalars: U::NAME == Coupled::NAME,
        cracks: crack_names(cracks.map(|crack| crack.name.as_deref())),
    })
}

/// The scene as TOML, without paths of this machine.
pub fn portable(scene: &Scene) -> Result<String, toml::ser::Error> {
    toml::to_string(&without_paths(scene))
}

/// The scene with the names of the files of records and mesh but not their paths, which are of no use on another machine.
fn without_paths(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for file in scene.ground_motion.files_mut() {
        if let Some(name) = file.file_name() {
            *file = name.into();
        }
    }
    if let Some(mesh) = scene.dam.as_mut().and_then(|dam| dam.mesh.as_mut())
        && let Some(name) = mesh.file.file_name()
    {
        mesh.file = name.into();
    }
    scene
}
