//! `cofferdam check`.

use super::start::{Start, StartError, deadlines};
use super::{Check, Transport, complain, estimate, known, modes, say, section, threads};
use cofferdam_assembly::observer::{Limits, Rest, Snapshots};
use cofferdam_assembly::participant::{check_sign, held_answer, self_test};
use cofferdam_assembly::simulation::ground_signal;
use cofferdam_assembly::units::{DAM, TAILWATER, unit_name};
use cofferdam_assembly::{
    Assembly, AssemblyError, Equilibrium, Flutter, LimitingPart, Mesh, PartKind, UpliftEffect, read_scene,
};
use cofferdam_coupling::observer::{self, Observer, ObserverError};
use cofferdam_coupling::participant::{
    AccelerationMeaning, Description, Level, Occasion, Participant, ParticipantError,
};
use cofferdam_coupling::scheme::{CouplingError, UnitId, check_points};
use cofferdam_motion::{GroundMotion, STANDARD_GRAVITY};
use cofferdam_scene::{CrackScene, Scene, SceneError, SceneWarning, Side, Source};
use interface::Capabilities;
use interface::Role;
use interface::number::plain;
use miette::Diagnostic;
use std::f64::consts::TAU;
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

/// Why a scene cannot be run.
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
    #[error("the scene cannot be written: {0}; this is a mistake of the program")]
    Text(#[from] toml::ser::Error),
    #[error("{option} {}: there are {scenes} scenes; check one scene with it at a time", path.display())]
    Several { option: &'static str, path: PathBuf, scenes: usize },
    #[error("--picture {}: the picture is an SVG; give it a name that ends in .svg", path.display())]
    NoSvg { path: PathBuf },
    #[error(
        "--modes {}: the scene's dam is prescribed or another program's and has no modes here; leave the option out", path.display()
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

/// What to do about a file that cannot be written.
fn remedy(cause: &Error) -> &'static str {
    match cause.kind() {
        ErrorKind::NotFound => "make the folder first, or choose another",
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists | ErrorKind::IsADirectory => {
            "it, or a part of its path, is there and of another kind; choose another name"
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "free some space or choose another place",
        _ => "choose a place where you may write",
    }
}

/// The pressure of a test, as a share of the hydrostatic pressure at the base.
const PROBE: f64 = 1e-4;
/// Steps after which a unit has a past.
const PAST: u64 = 3;
/// Time that a unit of another program may take for a step, s.
const DEADLINE: f64 = 60.0;

/// Says of each scene what is wrong with it, or what a run of it would be.
pub fn check(arguments: &Check) -> ExitCode {
    let mut status = 0;
    let mut failed = |error: CheckError| {
        status = error.status().max(status);
        complain(format!("{:?}", miette::Report::new(error)));
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

/// Whether the files that are asked for fit the scenes.
fn fits(arguments: &Check) -> Result<(), CheckError> {
    let Check { scenes, picture, modes, .. } = arguments;
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

/// Writes the files that are asked for.
fn write_files(scene: &Scene, arguments: &Check) -> Result<(), CheckError> {
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
    say(format!("  wrote {}", path.display()));
    Ok(())
}

fn examine(path: &Path, arguments: &Check) -> Result<(), CheckError> {
    let loaded = read_scene(path, &arguments.set)?;
    warn(&loaded.warnings);
    if let Some(path) = arguments.modes.as_ref().filter(|_| !loaded.scene.computed_dam().is_some()) {
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
        signals: &[ground_signal(&loaded.ground_motion)],
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
    if sources[0].is_foreign() {
        let mut other = unit(DAM, &loaded.scene)?;
        changes[0] = test(&mut *other, Role::Structure, &inputs, pressure, &loaded.scene)?;
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
        complain(format!("WARNING: {warning}"));
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
    for (id, other) in &mut others {
        for message in other.messages() {
            if message.level >= Level::Warning {
                doubt(format!("{}: {}", unit_name(*id), message.text));
            }
        }
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
        lines.push(format!("  {}", strength(&loaded.ground_motion)));
    }
    if !frequencies.is_empty() {
        lines.push(format!(
            "  natural frequencies of the dam, intact and empty: {} rad/s",
            list(&frequencies)
        ));
        if let Some(full) = Assembly::of(scene).natural_modes_in_water(frequencies.len())? {
            let water = match scene.waters().any(|(_, water)| water.fidelity.is_formula()) {
                true => "with Westergaard's added mass",
                false => "water incompressible",
            };
            lines.push(format!("  full, {water}: {} rad/s", list(&full.frequencies)));
        }
    }
    lines.push(format!("  {}", estimate::of(&loaded, &mut *dam, &inputs, threads(None))?));
    for (crack, Equilibrium { sliding, with_uplift, overturning }) in Assembly::of(scene).equilibria()? {
        let uplift = with_uplift.map_or_else(String::new, |UpliftEffect { sliding, friction_coefficient }| {
            format!(
                " ({sliding:.2} with its uplift, for which `friction_coefficient` = {friction_coefficient:.2} stands)"
            )
        });
        lines.push(format!(
            "  factor of safety of {} before the ground moves: sliding {sliding:.2}{uplift}, overturning {overturning:.2}",
            cracks[crack].phrase()
        ));
    }
    for (vibration, cures) in Assembly::of(scene).flutter()? {
        let described = describe(&vibration, &cracks[vibration.crack]);
        lines.push(format!("  {described}"));
        if vibration.growth > 0.0 {
            doubt(format!("{described}{}", advise(&cures)));
        }
    }
    let warnings = if warnings == 1 { "1 warning".to_owned() } else { format!("{warnings} warnings") };
    say(format!("{} can be run: {steps}, {duration} s; {warnings}", loaded.path.display()));
    lines.into_iter().for_each(say);
    write_files(scene, arguments)
}

/// Ratio of the time step that the median element would allow to the one taken, from which a warning is given.
const SLOW: f64 = 3.0;

/// Numbers and shapes of the dam's elements.
fn shapes(mesh: &Mesh) -> String {
    let quality = mesh.quality();
    let at = |(value, [x, y]): (f64, [f64; 2])| format!("{value:.2} at ({x:.2}, {y:.2})");
    let with = |unit: &str, (value, [x, y]): (f64, [f64; 2])| format!("{value:.2}{unit} at ({x:.2}, {y:.2})");
    format!(
        "{} cells, {} elements, {} nodes, {}; smallest angle {}, largest ratio of side to altitude {}, smallest altitude {}",
        mesh.cells.len(),
        4 * mesh.cells.len(),
        mesh.nodes.len(),
        match mesh.blocks.len() {
            1 => "1 block".to_owned(),
            blocks => format!("{blocks} blocks"),
        },
        with("°", quality.smallest_angle),
        at(quality.largest_ratio),
        with(" m", quality.smallest_altitude),
    )
}

/// What sets the time step, and where.
fn limit(part: &LimitingPart, cracks: &[CrackScene]) -> String {
    let what = match part.kind {
        PartKind::Element { block } => format!("an element of block {block}"),
        PartKind::Contact { crack } => {
            format!("a contact of {}", cracks.get(crack).map_or_else(String::new, CrackScene::phrase))
        }
    };
    let [x, y] = part.place;
    format!(
        "{what} at ({}, {}) m; {:.2} times as long if all were as the median element",
        plain(x),
        plain(y),
        part.slowdown()
    )
}

/// What a short time step costs, and how it becomes longer.
fn slow(part: &LimitingPart, described: &str) -> String {
    let remedy = match part.kind {
        PartKind::Element { .. } => {
            "move what is close together there (cracks, corners, water level) apart, give cracks there no smaller `element_size`, or \
             improve the mesh"
        }
        PartKind::Contact { .. } => {
            "lower its `normal_stiffness` and `shear_stiffness`, take larger elements along it, or move what is close to it away"
        }
    };
    format!("one small or stiff part slows the dam down: the time step is set by {described}; {remedy}")
}

/// Frequencies in a line.
fn list(frequencies: &[f64]) -> String {
    let frequencies: Vec<String> = frequencies.iter().map(|f| format!("{f:.2}")).collect();
    frequencies.join(", ")
}

/// A unit of a scene; that of another program in a process of its own, where it does no harm.
fn unit(id: UnitId, scene: &Scene) -> Result<Box<dyn Participant>, CheckError> {
    let foreign = Assembly::of(scene).source(id).is_foreign();
    let start = Start {
        scene,
        resolved: &toml::to_string(scene)?,
        transport: if foreign { Transport::SharedMemory } else { Transport::InProcess },
        threads: threads(None),
        deadlines: deadlines(DEADLINE),
        interrupted: &AtomicBool::new(false),
        announce: false,
    };
    Ok(start.units(&[id])?.remove(0))
}

/// Tests a unit of another program at rest and, if it can save its state, after some steps, and whether it fits the scene;
/// returns its answer to the first test.
fn test(
    unit: &mut dyn Participant,
    role: Role,
    request: &[f64],
    pressure: f64,
    scene: &Scene,
) -> Result<f64, CheckError> {
    let Capabilities { saved_state, variable_communication_step, .. } = unit.description().capabilities;
    let participant = || unit.description().name.clone();
    if !variable_communication_step && scene.stepping().varies() {
        return Err(CouplingError::FixedStep { participant: participant() }.into());
    }
    let communication_step = scene.time.communication_step;
    let occasion = |step: u64| Occasion {
        step,
        iteration: 1,
        attempt: 1,
        time: (step - 1) as f64 * communication_step,
        communication_step,
    };
    let mut outputs = vec![0.0; unit.description().outputs.size()];
    unit.initialise(0.0, request, &mut outputs)?;
    let change = self_test(unit, role, request, pressure, &occasion(1))?;
    check_sign(unit, role, change)?;
    // One that cannot go back has taken the first step already.
    let steps = if saved_state { vec![occasion(1), occasion(2)] } else { vec![occasion(2)] };
    if saved_state {
        unit.save_state()?;
    }
    let held = held_answer(unit, role, request, pressure, &steps)?;
    if saved_state {
        unit.restore_state()?;
        let name = if role == Role::Fluid { "interface_acceleration" } else { "interface_pressure" };
        let driven = unit.description().inputs.range(name).unwrap_or_default();
        let mut moved = request.to_vec();
        for step in 1..=PAST {
            unit.save_state()?;
            moved[driven.clone()].fill(if role == Role::Fluid {
                step as f64
            } else {
                pressure * step as f64
            });
            unit.step(&occasion(step), &moved, &mut outputs)?;
        }
        self_test(unit, role, &moved, pressure, &occasion(PAST + 1))?;
    }
    // What answers only after the step that it is asked for has a sign of 0.
    Ok(if change == 0.0 { change } else { held })
}

/// What a unit is, and of one of another program what it can and lacks; `change` is its answer to a test, beside the `added_mass`
/// (kg/m) of Westergaard's water.
fn told(unit: &dyn Participant, source: Source<'_>, change: f64, added_mass: Option<f64>) -> String {
    let Description { solver, outputs, capabilities, .. } = unit.description();
    if !source.is_foreign() {
        return solver.clone();
    }
    let points = outputs.range("interface_pressure").or(outputs.range("interface_acceleration"));
    let points = points.map_or(0, |range| range.len());
    let answer = match added_mass {
        Some(mass) => format!(
            "1 m/s² into the water, held for two steps, gives {:.3} MN/m (Westergaard's added mass {:.3}; water with a memory takes longer)",
            change / 1e6,
            mass / 1e6
        ),
        None => "a pressure pushes it into the dam".to_owned(),
    };
    let tested = match (change == 0.0, capabilities.saved_state) {
        (true, _) => "it does not answer in the step that it is asked for".to_owned(),
        (false, true) => format!("repeated steps are right, and so is the sign: {answer}"),
        (false, false) => format!("its sign is right: {answer}"),
    };
    let steps = if capabilities.variable_communication_step { "of any length" } else { "of equal length" };
    let schemes = if capabilities.saved_state { "any scheme" } else { "explicit schemes alone" };
    let meaning = match source.acceleration() {
        AccelerationMeaning::Mean => "the mean over the step",
        AccelerationMeaning::End => "that at the step's end",
    };
    format!(
        "{solver}; {points} points, {tested}; it takes steps {steps} and fits {schemes}; its acceleration is \
         taken to be {meaning}"
    )
}

/// How strong a record is.
fn strength(motion: &GroundMotion) -> String {
    let peak = motion.acceleration().iter().fold(0.0, |peak: f64, a| peak.max(a.abs()));
    let [velocity, displacement] = motion.drift().map(|drift| drift.peak);
    let (intensity, duration) = motion.arias_intensity();
    format!(
        "ground: {}, {:.2} s: at most {:.3} g, {velocity:.3} m/s, {displacement:.3} m; Arias intensity {intensity:.3} m/s, 5 to 95 % \
         of it within {duration:.2} s",
        motion.source(),
        motion.duration(),
        peak / STANDARD_GRAVITY,
    )
}

/// What is to be said of vibrations that grow while blocks of the scene slide.
///
/// **Errors**: those of the dam.
pub fn flutter_warnings(scene: &Scene) -> Result<Vec<String>, AssemblyError> {
    let cracks = scene.dam.as_ref().map_or(&[][..], |dam| &dam.cracks);
    let growing = Assembly::of(scene).flutter()?.into_iter().filter(|(vibration, _)| vibration.growth > 0.0);
    Ok(growing
        .map(|(vibration, cures)| describe(&vibration, &cracks[vibration.crack]) + &advise(&cures))
        .collect())
}

fn describe(vibration: &Flutter, crack: &CrackScene) -> String {
    let Flutter { downstream, frequency, growth, .. } = *vibration;
    let above = if crack.name.is_some() { crack.phrase() } else { crack.label() };
    format!(
        "while the block above {above} slides {}: vibration at {:.1} Hz {} by {:.3} 1/s",
        if downstream { "downstream" } else { "upstream" },
        frequency / TAU,
        if growth > 0.0 { "grows" } else { "decays" },
        growth.abs(),
    )
}

/// What a growing vibration means, and what cures it.
fn advise(cures: &[String]) -> String {
    let remedy = match cures {
        [] => {
            "no other damping that was tried makes it decay: it comes from the shape of the block and its friction; rock that takes \
             up waves, not modelled here, would damp it (docs/decisions/flutter.md)"
                .to_owned()
        }
        cures => format!("it would decay with {}", cures.join(", or with ")),
    };
    format!(
        ": once it slides, the block shakes itself, and a thrust below its frictional strength may keep it sliding; {remedy}"
    )
}

/// Shows what is doubtful about a scene.
pub fn warn(warnings: &[SceneWarning]) {
    for warning in warnings {
        complain(format!("{:?}", miette::Report::new(warning.clone())));
    }
}
