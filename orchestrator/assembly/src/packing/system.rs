//! Dam and waters of a scene as a system of FMUs for masters that repeat no step.
//!
//! Each water gives what its response adds beyond the mass of one step, which is in the dam: see
//! [`Reservoir::instantaneous_added_mass`].

use super::{PackingError, Target, mesh, package};
use crate::assembly::block_diagonal;
use crate::ground::ground_signals;
use crate::units::variable_prefix;
use crate::{Assembly, AssemblyError, WaterMass};
use cofferdam_coupling::signal::Signal;
use cofferdam_dam::{Dam, DamParameters};
use cofferdam_fmi::export::ssp::{Component, System};
use cofferdam_fmi::export::{Page, Times, check_target};
use cofferdam_motion::GroundMotion;
use cofferdam_reservoir::{Reservoir, ReservoirParameters};
use cofferdam_scene::{Scene, Side};
use cofferdam_unit::Packable;
use cofferdam_unit::export::{Contents, Record};
use nalgebra::DMatrix;
use quick_xml::escape::escape;
use std::collections::BTreeMap;
use std::num::NonZeroUsize;

/// Name of the dam's component.
const DAM: &str = "dam";
/// Steps of the water beyond the end of the scene: it looks one step ahead, and sums of steps are rounded.
const BEYOND_END: f64 = 3.0;

/// What was packed.
pub struct PackedSystem {
    /// Size of the archive, bytes.
    pub size: u64,
    /// Names of the components.
    pub components: Vec<&'static str>,
    /// Whether a water has a memory, so that something is extrapolated.
    pub memory: bool,
    /// Waters whose own points gave way to those of the dam.
    pub moved: Vec<Side>,
}

/// Packs dam and waters of a loaded scene for a master that repeats no step, as an SSP archive.
///
/// The points of the waters are those of the dam, also if the scene gives them their own.
///
/// **Errors**: those of [`check_target`] and [`System::write`]; a scene without a dam or water of this program, or with varying
/// steps; a unit that cannot be made. Then nothing is written.
pub fn pack_system(
    name: &str,
    scene: &Scene,
    motion: &GroundMotion,
    target: &Target<'_>,
) -> Result<PackedSystem, PackingError> {
    check_target(target.path, target.overwrite)?;
    let sides = sides(scene)?;
    let records: Vec<Record> = ground_signals(motion).into_iter().map(record).collect();
    let (mut components, mut connections, mut exchanged) = (Vec::new(), Vec::new(), Vec::new());
    let mut masses = BTreeMap::new();
    for &side in &sides {
        let Water { parameters, prepared, mass } = Water::of(scene, side)?;
        let mesh = mesh::reservoir(&parameters).map_err(AssemblyError::from)?;
        let contents = Contents { start: BTreeMap::new(), parameters, records: records.clone() };
        let page = page(include_str!("reservoir.html"));
        let package = package::<Reservoir>(scene, contents, prepared, mesh, page, target)?;
        let fields = ["interface_pressure", "interface_acceleration"];
        let (of_water, of_dam) =
            (fields.map(str::to_owned), fields.map(|field| format!("{}{field}", variable_prefix(side))));
        components.push(Component::new(side.table(), &package, &of_water)?);
        exchanged.extend(of_dam.clone());
        let ([pressure, acceleration], [to_dam, from_dam]) = (of_water, of_dam);
        connections.push([(side.table(), pressure), (DAM, to_dam)]);
        connections.push([(DAM, from_dam), (side.table(), acceleration)]);
        masses.insert(side.table(), mass);
    }
    let contents = dam(scene, masses, records)?;
    let mesh = mesh::dam(&contents.parameters).map_err(AssemblyError::from)?;
    let package = package::<Dam>(scene, contents, None, mesh, page(include_str!("dam.html")), target)?;
    components.insert(0, Component::new(DAM, &package, &exchanged)?);

    let communication_step = scene.time.communication_step;
    let water = |side: &Side| scene.water(*side);
    let system = System {
        name: name.to_owned(),
        title: scene.title.clone(),
        components,
        connections,
        times: Times { communication_step, end: package.end() },
        documentation: documentation(&scene.title, communication_step),
    };
    Ok(PackedSystem {
        size: system.write(target.path)?,
        components: [DAM].into_iter().chain(sides.iter().map(|side| side.table())).collect(),
        memory: sides.iter().filter_map(water).any(|water| water.fidelity.has_memory()),
        moved: sides
            .into_iter()
            .filter(|side| water(side).is_some_and(|water| water.interface_size.is_some()))
            .collect(),
    })
}

/// The sides with water of a scene that can be packed for explicit coupling.
fn sides(scene: &Scene) -> Result<Vec<Side>, PackingError> {
    super::check_dam(scene)?;
    let filled = || scene.waters().filter(|(_, water)| !water.is_empty());
    if let Some((side, water)) = filled().find(|(_, water)| water.solver().is_none()) {
        return Err(PackingError::ForeignWater { table: side.table(), fidelity: water.fidelity.word() });
    }
    if scene.time.adaptive.is_some() {
        return Err(PackingError::VaryingSteps);
    }
    let sides: Vec<Side> = filled().map(|(side, _)| side).collect();
    if sides.is_empty() { Err(PackingError::NoWater) } else { Ok(sides) }
}

/// A water for explicit coupling.
struct Water {
    /// Its parameters, at the dam's points.
    parameters: ReservoirParameters,
    /// What is prepared for them.
    prepared: Option<Vec<u8>>,
    /// Its mass of one step.
    mass: DMatrix<f64>,
}

impl Water {
    fn of(scene: &Scene, side: Side) -> Result<Self, PackingError> {
        let mut parameters = Assembly::of(scene).water_parameters_at_dam(side)?;
        parameters.explicit_coupling = true;
        parameters.horizon += BEYOND_END * parameters.communication_step;
        parameters.validate().map_err(AssemblyError::from)?;
        let threads = std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
        let prepared = Reservoir::prepare(&parameters, threads).map_err(AssemblyError::from)?;
        let made = match &prepared {
            Some(bytes) => Reservoir::from_prepared(parameters.clone(), bytes, threads),
            None => Reservoir::new(parameters.clone(), threads),
        };
        let mass = made.map_err(AssemblyError::from)?.instantaneous_added_mass();
        Ok(Self { parameters, prepared, mass })
    }
}

/// The dam, with the `masses` of the waters by their tables.
fn dam(
    scene: &Scene,
    mut masses: BTreeMap<&'static str, DMatrix<f64>>,
    records: Vec<Record>,
) -> Result<Contents<DamParameters>, PackingError> {
    let assembly = Assembly::of(scene);
    let mut parameters = assembly.dam_parameters(WaterMass::None)?;
    let mut blocks = Vec::new();
    for (side, _) in scene.waters() {
        let points = assembly.dam_face(side)?.len();
        blocks.push(masses.remove(side.table()).unwrap_or_else(|| DMatrix::zeros(points, points)));
    }
    parameters.added_mass = Some(block_diagonal(&blocks));
    // Some mistakes are found only when the dam is made; that takes no longer than a few steps.
    assembly.make_dam(parameters.clone())?;
    let start = assembly.hydrostatic_pressure()?.into_iter().collect();
    Ok(Contents { start, parameters, records })
}

/// The page of a unit in a system, which computes what `about` says.
fn page(about: &'static str) -> Page {
    let (usage, example) = (include_str!("explicit_usage.html"), include_str!("explicit_example.html"));
    Page { about, usage, example, notes: "" }
}

/// The text of documentation/index.html.
fn documentation(title: &str, communication_step: f64) -> String {
    let text = include_str!("system.html");
    let text = text.replace("{version}", env!("CARGO_PKG_VERSION"));
    text.replace("{step}", &communication_step.to_string()).replace("{title}", &escape(title))
}

/// A signal of the ground as the record of an FMU.
fn record(signal: Signal) -> Record {
    let Signal { input, component, interval, samples, held, .. } = signal;
    Record { input, component, interval, samples, held }
}
