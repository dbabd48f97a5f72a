//! `cofferdam check`.

use cofferdam_assembly::units::unit_name;
use cofferdam_assembly::{Assembly, AssemblyError, Equilibrium, UpliftEffect, read_scene};
mod describe;
mod foreign;

use crate::context::context;
use crate::modes;
use crate::terminal::{print, show_warnings, warn};
use cofferdam_analysis::context::threads;
use cofferdam_analysis::estimate;
use cofferdam_analysis::flutter::{self, advise};
use cofferdam_analysis::start::StartError;
use cofferdam_analysis::variables::known;
use cofferdam_assembly::ground::ground_signals;
use cofferdam_assembly::observer::{Limits, Rest, Snapshots};
use cofferdam_assembly::units::{DAM, TAILWATER};
use cofferdam_coupling::observer::{self, Observer, ObserverError};
use cofferdam_coupling::participant::{Level, ParticipantError};
use cofferdam_coupling::scheme::{CouplingError, check_points};
use cofferdam_report::section;
use cofferdam_scene::{Scene, SceneError, Side, Source, takes_water};
use cofferdam_unit::Role;
use describe::{SLOW, limit, list, shapes, slow, strengths};
use foreign::{test, told, unit};
use miette::Diagnostic;
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `cofferdam check`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folders with a scene.toml, or .toml files
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,

    /// Change a value of every scene (repeatable)
    ///
    /// As in `cofferdam run`. An error in a changed value is shown in KEY=VALUE.
    #[arg(short, long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Draw the section to scale as SVG: mesh, cracks, water, wet points (one scene only)
    #[arg(short, long, value_name = "FILE")]
    pub picture: Option<PathBuf>,

    /// Write the dam's mode shapes to modes.vtu in this folder, for ParaView (one scene only)
    #[arg(short, long, value_name = "FOLDER")]
    pub modes: Option<PathBuf>,
}

pub const HELP: &str = "\
Reports all errors, each with its line: invalid TOML; unknown, misplaced and
missing keys; wrong types and words; values and geometry that cannot be
computed; records that cannot be read.

Warns, as `cofferdam run` does, if elements or communication steps are too
coarse for the frequencies of the record, if the record drifts, if it is not
followed by a quiet time for the residual sliding, and if values suggest a
wrong unit. scenes/README.md lists the thresholds.

The natural frequencies are those of the intact dam, with the reservoir empty
and full; the water of the full reservoir is treated as incompressible.
modes.vtu has the mode shapes as point data (mode_1_empty, mode_1_full, ...),
each with a modal mass of 1, and the frequencies as field data. Existing files
are replaced.

Examples:
  cofferdam check scenes/koyna-northridge-1994
      Prints the number of steps of a run, or the errors that prevent it.
  cofferdam check scenes/koyna-northridge-1994 --set dam.element_size=25
      Is this mesh fine enough?
  cofferdam check scenes/koyna-northridge-1994 -p koyna.svg -m modes
      Does the section look as intended?
  cofferdam check scenes/*/scene.toml
      All scenes.

Exit status: 0 all scenes can be run, 1 a file cannot be written, 2 a scene or
an option is invalid.";

/// Reason why a scene cannot be run.
#[derive(Debug, thiserror::Error, Diagnostic)]
enum CheckError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Unit(#[from] AssemblyError),
    #[error(transparent)]
    Dam(#[from] ParticipantError),
    #[error(transparent)]
    Estimate(#[from] estimate::EstimateError),
    #[error(transparent)]
    Start(#[from] StartError),
    #[error(transparent)]
    Coupling(#[from] CouplingError),
    #[error(transparent)]
    Demand(#[from] ObserverError),
    #[error("the scene cannot be written: {0}; this is a bug in the program")]
    Text(#[from] toml::ser::Error),
    #[error("{option} {}: there are {scenes} scenes; check one scene with it at a time", path.display())]
    Several { option: &'static str, path: PathBuf, scenes: usize },
    #[error("--picture {}: the picture is an SVG; give it a name that ends in .svg", path.display())]
    NoSvg { path: PathBuf },
    #[error(
        "--modes {}: the dam of the scene is prescribed or simulated by another program and has no modes here; leave the option out", path.display()
    )]
    NoModes { path: PathBuf },
    #[error("{option} {} cannot be written: {cause}; {}", path.display(), remedy(cause))]
    Write { option: &'static str, path: PathBuf, cause: Error },
}

impl CheckError {
    /// The program's exit status.
    fn status(&self) -> u8 {
        if matches!(self, Self::Write { .. }) { 1 } else { 2 }
    }
}

/// Remedy for a file that cannot be written.
fn remedy(cause: &Error) -> &'static str {
    match cause.kind() {
        ErrorKind::NotFound => "create the folder first, or choose another",
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists | ErrorKind::IsADirectory => {
            "the path, or a part of it, exists and is not a folder; choose another name"
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "free some space or choose another place",
        _ => "choose a place where you may write",
    }
}

/// The pressure of a test, as a share of the hydrostatic pressure at the base.
const PROBE: f64 = 1e-4;

/// Says of each scene what is wrong with it, or what a run of it would be.
pub fn check(arguments: &Arguments) -> ExitCode {
    let mut status = 0;
    let mut failed = |error: CheckError| {
        status = error.status().max(status);
        warn(format!("{:?}", miette::Report::new(error)));
    };
    if let Err(error) = fits(arguments) {
        failed(error);
        return ExitCode::from(status);
    }
    for path in &arguments.scenes {
        if let Err(error) = examine(path, arguments) {
            failed(error);
        }
    }
    ExitCode::from(status)
}

/// Checks that the requested files fit the scenes.
fn fits(arguments: &Arguments) -> Result<(), CheckError> {
    let Arguments { scenes, picture, modes, .. } = arguments;
    let asked = [("--picture", picture), ("--modes", modes)];
    let asked = asked.into_iter().find_map(|(option, path)| Some((option, path.clone()?)));
    if let Some((option, path)) = asked.filter(|_| scenes.len() > 1) {
        return Err(CheckError::Several { option, path, scenes: scenes.len() });
    }
    match picture {
        Some(path) if path.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("svg")) => {
            Err(CheckError::NoSvg { path: path.clone() })
        }
        _ => Ok(()),
    }
}

/// Writes the requested files.
fn write_files(scene: &Scene, arguments: &Arguments) -> Result<(), CheckError> {
    if let Some(path) = &arguments.picture {
        write("--picture", path, &section::picture(scene)?)?;
    }
    if let Some(folder) = &arguments.modes {
        let text = modes::vtu(scene)?;
        std::fs::create_dir_all(folder).map_err(|cause| CheckError::Write {
            option: "--modes",
            path: folder.clone(),
            cause,
        })?;
        write("--modes", &folder.join("modes.vtu"), &text)?;
    }
    Ok(())
}

/// Writes a file, completely or not at all, and says so.
fn write(option: &'static str, path: &Path, text: &str) -> Result<(), CheckError> {
    let mut draft = path.as_os_str().to_owned();
    draft.push(".part");
    std::fs::write(&draft, text).and_then(|()| std::fs::rename(&draft, path)).map_err(|cause| {
        // The error of writing is reported, not one of removing.
        let _ = std::fs::remove_file(&draft);
        CheckError::Write { option, path: path.to_owned(), cause }
    })?;
    print(format!("  wrote {}", path.display()));
    Ok(())
}

fn examine(path: &Path, arguments: &Arguments) -> Result<(), CheckError> {
    let loaded = read_scene(path, &arguments.set)?;
    show_warnings(&loaded.warnings);
    if let Some(path) = arguments.modes.as_ref().filter(|_| loaded.scene.computed_dam().is_none()) {
        return Err(CheckError::NoModes { path: path.clone() });
    }
    let time = &loaded.scene.time;
    let (steps, step, duration) = (loaded.steps(), time.communication_step, time.duration.unwrap_or(0.0));
    // The sum of decimal numbers, without what binary ones add to it.
    let duration = (duration * 1e9).round() / 1e9;
    let steps = match time.adaptive {
        Some(adaptive) => format!("communication steps of {} to {} s", adaptive.shortest, adaptive.longest),
        None => format!("{steps} communication steps of {step} s"),
    };
    // The dam is made and brought to rest as a run would; only the water's preparation remains.
    let mut dam = unit(DAM, &loaded.scene)?;
    let start = observer::Start {
        units: vec![dam.description().clone()],
        signals: &ground_signals(&loaded.ground_motion),
        stepping: loaded.scene.stepping(),
    };
    Limits::new(&loaded.scene.stop).begin(&start)?;
    Rest::new(time).begin(&start)?;
    if loaded.scene.snapshots.is_some() {
        Snapshots::check(&start)?;
    }
    let inputs = Assembly::of(&loaded.scene).inputs_at_rest(&mut *dam)?;
    let mut outputs = vec![0.0; dam.description().outputs.size()];
    dam.initialise(0.0, &inputs, &mut outputs)?;
    let scene = &loaded.scene;
    let sources: Vec<Source<'_>> = scene.sources();
    let pressure = PROBE * loaded.scene.hydrostatic_base_pressure(Side::Upstream);
    let mut changes = vec![0.0; sources.len()];
    let mut messages = Vec::new();
    if sources[0].is_foreign() {
        let mut other = unit(DAM, &loaded.scene)?;
        changes[0] = test(&mut *other, Role::Structure, &inputs, pressure, &loaded.scene)?;
        messages.extend(other.messages());
    }
    let mut others = Vec::new();
    for (id, _) in Assembly::of(&loaded.scene)
        .units()
        .into_iter()
        .zip(&sources)
        .skip(1)
        .filter(|(_, s)| **s != Source::BuiltIn)
    {
        let mut other = unit(id, &loaded.scene)?;
        if sources[id.0].is_foreign() {
            let inputs = vec![0.0; other.description().inputs.size()];
            changes[id.0] = test(&mut *other, Role::Fluid, &inputs, pressure, &loaded.scene)?;
        }
        for interface in Assembly::of(&loaded.scene).interfaces().iter().filter(|own| own.second.unit == id) {
            check_points(&mut *dam, &mut *other, interface)?;
        }
        others.push((id, other));
    }
    let made = std::iter::once(&dam).chain(others.iter().map(|(_, other)| other));
    let forgetful = made.map(|unit| unit.description()).find(|unit| !unit.capabilities.saved_state);
    if let Some(unit) = forgetful.filter(|_| loaded.scene.scheme().is_implicit()) {
        return Err(CouplingError::NoState { participant: unit.name.clone() }.into());
    }
    let frequencies = known(dam.read("natural_frequency"))?;
    let (mut lines, mut warnings) = (Vec::new(), loaded.warnings.len());
    let mut doubt = |warning: String| {
        warn(format!("WARNING: {warning}"));
        warnings += 1;
    };
    lines.push(format!("  dam: {}", told(&*dam, sources[0], changes[0], None)));
    let cracks = scene.dam.as_ref().map_or(&[][..], |dam| &dam.cracks);
    if let Some(mesh) = Assembly::of(scene).dam_mesh()? {
        lines.push(format!("  mesh: {}", shapes(&mesh)));
    }
    if let Some((part, longest)) = Assembly::of(scene).limiting_part()? {
        let described = limit(&part, cracks);
        lines.push(format!("  time step of the dam: at most {longest:.3e} s, set by {described}"));
        if part.slowdown() >= SLOW {
            doubt(slow(&part, &described));
        }
    }
    messages.extend(others.iter_mut().flat_map(|(_, other)| other.messages()));
    for message in messages.into_iter().filter(|message| message.level >= Level::Warning) {
        doubt(format!("{}: {}", message.unit, message.text));
    }
    for (id, other) in &mut others {
        let side = if *id == TAILWATER { Side::Downstream } else { Side::Upstream };
        let (depth, density) = (scene.depth_of(side), scene.water(side).map_or(0.0, |water| water.density));
        // ∫ ⅞ ρ √(h (h − y)) dy
        let mass = 7.0 / 12.0 * density * depth * depth;
        lines.push(format!(
            "  {}: {}",
            unit_name(*id),
            told(&**other, sources[id.0], changes[id.0], Some(mass))
        ));
    }
    if loaded.ground_motion.file().is_some() {
        lines.extend(strengths(&loaded));
    }
    if !frequencies.is_empty() {
        lines.push(format!(
            "  natural frequencies of the dam, intact and empty: {} rad/s",
            list(&frequencies)
        ));
        if let Some(full) = Assembly::of(scene).natural_modes_in_water(frequencies.len())? {
            let water = match scene.waters().any(|(_, water)| water.fidelity.is_formula()) {
                true => "with Westergaard's added mass",
                false => "incompressible water",
            };
            lines.push(format!("  full, {water}: {} rad/s", list(&full.frequencies)));
        }
    }
    lines.push(format!("  {}", estimate::of(&loaded, &mut *dam, &inputs, threads(None), &context())?));
    for (crack, Equilibrium { sliding, with_uplift, overturning }) in Assembly::of(scene).equilibria()? {
        let uplift = match with_uplift {
            Some(UpliftEffect { sliding }) => {
                format!(" without uplift ({sliding:.2} with uplift, `dam.uplift` = \"unchanged\")")
            }
            None if takes_water(scene, &cracks[crack]) => " with uplift".to_owned(),
            None => String::new(),
        };
        let overturning_uplift = match with_uplift {
            Some(_) => " without uplift",
            None if takes_water(scene, &cracks[crack]) => " with uplift",
            None => "",
        };
        lines.push(format!(
            "  factor of safety of {} before the ground moves, by limit equilibrium: sliding {sliding:.2}{uplift}, overturning \
             {overturning:.2}{overturning_uplift}",
            cracks[crack].phrase()
        ));
    }
    for (vibration, cures) in Assembly::of(scene).flutter()? {
        let described = flutter::describe(&vibration, &cracks[vibration.crack]);
        lines.push(format!("  {described}"));
        if vibration.growth > 0.0 {
            doubt(format!("{described}{}", advise(&cures)));
        }
    }
    let warnings = if warnings == 1 { "1 warning".to_owned() } else { format!("{warnings} warnings") };
    print(format!("{} can be run: {steps}, {duration} s; {warnings}", loaded.path.display()));
    lines.into_iter().for_each(print);
    write_files(scene, arguments)
}
