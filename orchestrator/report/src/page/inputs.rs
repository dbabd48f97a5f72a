//! Inputs of a run, and its provenance.

use super::super::Manifest;
use super::data::{Group, Row};
use super::folder::RunFolder;
use cofferdam_coupling::convergence::Tolerance;
use cofferdam_motion::GroundMotion;
use cofferdam_scene::{
    CrackScene, DamScene, DampingModel, MaterialScene, ReservoirScene, Scene, Shock, Side,
};
use cofferdam_unit::number::plain;
use cofferdam_unit::sha256;

/// The inputs by subject, in the units of the field.
pub fn of(scene: &Scene, manifest: &Manifest, motion: &GroundMotion) -> Vec<Group> {
    let mut groups = vec![ground(scene, motion), time(scene)];
    if let Some(dam) = &scene.dam {
        groups.push(concrete(scene, dam, manifest));
        for zone in &dam.zones {
            groups.push(Group {
                name: format!("Zone {}", zone.name),
                rows: material(&zone.material(&dam.material)),
            });
        }
        groups.extend(dam.cracks.iter().map(crack));
    }
    if let Some(prescribed) = &scene.prescribed {
        let rows = vec![
            Row::text("model", "rigid, moves with the ground"),
            Row::number("batter of the wet face", prescribed.batter, "m"),
            Row::number("panels of the wet face", prescribed.panels as f64, "1"),
        ];
        groups.push(Group { name: "Dam".to_owned(), rows });
    }
    groups.extend(scene.waters().map(|(side, own)| water(scene, side, own, manifest)));
    groups.push(coupling(scene));
    if !scene.stop.is_empty() {
        let limit = |stop: &cofferdam_scene::StopScene| {
            Row::text(stop.quantity.word(), format!("above {}{}", stop.above, stop.quantity.unit()))
                .with(word(&stop.action))
        };
        groups.push(Group { name: "Limits".to_owned(), rows: scene.stop.iter().map(limit).collect() });
    }
    groups
}

/// The word that a scene has for a choice.
fn word(choice: &impl serde::Serialize) -> String {
    match serde_json::to_value(choice) {
        Ok(serde_json::Value::String(word)) => word,
        _ => String::new(),
    }
}

fn ground(scene: &Scene, motion: &GroundMotion) -> Group {
    let mut rows = Vec::new();
    if let Some(record) = &scene.ground_motion.record {
        let name =
            record.file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        rows.push(Row::code("record", name));
        let samples = motion.acceleration().len();
        rows.push(
            Row::number("samples", samples as f64, "1").with(format!("every {} s", plain(motion.interval()))),
        );
        rows.push(Row::number("scale factor of the acceleration", record.scale, "1"));
        let direction = if record.polarity < 0 { "upstream" } else { "downstream" };
        rows.push(Row::text("positive accelerations point", direction));
        rows.push(Row::number("start within the record", record.start, "s"));
        rows.extend(record.end.map(|end| Row::number("end within the record", end, "s")));
    }
    if let (Some(scene), Some(vertical)) = (&scene.ground_motion.vertical, motion.vertical()) {
        let name =
            scene.file.as_ref().and_then(|file| Some(file.file_name()?.to_string_lossy().into_owned()));
        let row = Row::code("vertical record", name.unwrap_or_default());
        let column = scene.column.map(|column| format!("column {column} after the time"));
        rows.push(column.into_iter().fold(row, Row::with));
        let samples = vertical.acceleration().len() as f64;
        let every = format!("every {} s", plain(vertical.interval()));
        rows.push(Row::number("samples of the vertical record", samples, "1").with(every));
        let both = "in addition to the scale factor of the record";
        rows.push(Row::number("scale factor of the vertical acceleration", scene.scale, "1").with(both));
        let direction = if scene.polarity < 0 { "down" } else { "up" };
        rows.push(Row::text("positive vertical accelerations point", direction));
    }
    rows.extend(scene.ground_motion.shocks().iter().zip(motion.begins()).skip(1).flat_map(further));
    if let Some(ramp) = &scene.ground_motion.ramp {
        rows.push(Row::number("ramp up to", ramp.acceleration, "m/s²").with("then held"));
        if ramp.vertical_acceleration != 0.0 {
            let upwards = Row::number("vertical ramp up to", ramp.vertical_acceleration, "m/s²");
            rows.push(upwards.with("positive upwards, then held"));
        }
        rows.push(Row::number("rise time", ramp.rise, "s"));
    }
    Group { name: "Ground motion".to_owned(), rows }
}

/// A shock of the sequence, with its begin.
fn further((shock, begin): (&Shock<'_>, f64)) -> Vec<Row> {
    let Shock { label, record, vertical, rest, .. } = shock;
    let direction = if record.polarity < 0 { "upstream" } else { "downstream" };
    let mut rows = vec![
        Row::code(label.clone(), shock.file_name()).with(format!("positive accelerations point {direction}")),
        Row::number(format!("rest before {label}"), *rest, "s")
            .with(format!("{label} begins at {} s", plain(begin))),
        Row::number(format!("scale factor of {label}"), record.scale, "1"),
    ];
    if record.start > 0.0 || record.end.is_some() {
        rows.push(Row::number(format!("start within the record of {label}"), record.start, "s"));
        rows.extend(record.end.map(|end| Row::number(format!("end within the record of {label}"), end, "s")));
    }
    if let (Some(vertical), Some(name)) = (vertical, shock.vertical_file_name()) {
        let direction = if vertical.polarity < 0 { "down" } else { "up" };
        let row = Row::code(format!("vertical record of {label}"), name);
        rows.push(row.with(format!("positive accelerations point {direction}")));
        let row =
            Row::number(format!("scale factor of the vertical acceleration of {label}"), vertical.scale, "1");
        rows.push(row.with("in addition to the scale factor of its record"));
    }
    rows
}

fn time(scene: &Scene) -> Group {
    let time = &scene.time;
    let mut rows = vec![Row::number("communication step", 1e3 * time.communication_step, "ms")];
    rows.extend(time.adaptive.map(|adaptive| {
        Row::text("adaptive steps", format!("{} to {} s", adaptive.shortest, adaptive.longest))
    }));
    rows.extend(time.duration.map(|duration| Row::number("planned duration", duration, "s")));
    rows.push(Row::number("rest after the record", time.quiet, "s"));
    rows.extend(time.longest_quiet.map(|longest| Row::number("maximum wait for rest", longest, "s")));
    Group { name: "Time".to_owned(), rows }
}

fn concrete(scene: &Scene, dam: &DamScene, manifest: &Manifest) -> Group {
    let last = |side: &[[f64; 2]]| side.last().copied().unwrap_or_default();
    let (crest, toe) =
        (last(&dam.section.upstream), dam.section.downstream.first().copied().unwrap_or_default());
    let mut rows = vec![
        Row::text("model", dam.fidelity.word()),
        Row::number("height", scene.height(), "m"),
        Row::number("width of the base", toe[0], "m"),
        Row::number("width of the crest", last(&dam.section.downstream)[0] - crest[0], "m"),
        Row::number("element size", dam.element_size, "m"),
    ];
    if let Some(unit) = manifest.units.first() {
        rows.push(Row::text("solver", unit.solver.clone()));
    }
    rows.extend(material(&dam.material));
    let damping = &dam.damping;
    let model = match damping.model {
        DampingModel::Rayleigh => "Rayleigh",
        DampingModel::Mass => "mass-proportional",
        DampingModel::Stiffness => "stiffness-proportional",
        DampingModel::Local => "local",
    };
    rows.push(Row::text("damping", model));
    let at = match (damping.multiples_of_first, damping.radians_per_second) {
        (Some([low, high]), _) => format!("at {low} and {high} times ω₁ of the intact empty dam"),
        (None, Some([low, high])) => format!("at {low} and {high} rad/s"),
        (None, None) => String::new(),
    };
    rows.push(Row::number("damping ratio", 100.0 * damping.ratio, "%").with(at));
    if damping.drags_blocks {
        rows.push(Row::text("mass damping of sliding blocks", "yes").with("as in most published runs"));
    }
    rows.push(Row::number("gravity", scene.gravity, "m/s²"));
    Group { name: "Dam".to_owned(), rows }
}

fn material(material: &MaterialScene) -> Vec<Row> {
    let mut rows = vec![
        Row::number("elastic modulus E", 1e-9 * material.young_modulus, "GPa"),
        Row::number("Poisson's ratio ν", material.poisson_ratio, "1"),
        Row::number("density ρ", material.density, "kg/m³"),
        Row::text("plane condition", material.plane.label()),
    ];
    let strength =
        material.tensile_strength.map(|strength| Row::number("tensile strength", 1e-6 * strength, "MPa"));
    rows.extend(strength.map(|row| row.with("compared with stresses")));
    rows
}

fn crack(crack: &CrackScene) -> Group {
    let mut rows = Vec::new();
    match (crack.elevation, &crack.polyline) {
        (Some(elevation), _) => rows.push(Row::number("elevation", elevation, "m")),
        (None, Some(points)) => {
            let points: Vec<String> = points.iter().map(|[x, y]| format!("({x}, {y})")).collect();
            rows.push(Row::text("line", format!("{} m", points.join(" – "))));
        }
        (None, None) => {}
    }
    rows.push(Row::number("friction coefficient", crack.friction_coefficient, "1"));
    rows.extend(
        crack.residual_friction_coefficient.map(|mu| Row::number("residual friction coefficient", mu, "1")),
    );
    rows.push(Row::number("cohesion", 1e-6 * crack.cohesion, "MPa"));
    rows.push(Row::number("tensile strength", 1e-6 * crack.tensile_strength, "MPa"));
    if crack.dilation > 0.0 {
        rows.push(Row::number("tangent of the dilation angle", crack.dilation, "1"));
    }
    rows.push(Row::number("normal stiffness", 1e-9 * crack.normal_stiffness, "GPa/m"));
    rows.push(Row::number("shear stiffness", 1e-9 * crack.shear_stiffness, "GPa/m"));
    rows.push(Row::text("contacts", word(&crack.integration)));
    let phrase = crack.phrase();
    Group { name: format!("C{}", phrase.strip_prefix("the c").unwrap_or(&phrase)), rows }
}

fn water(scene: &Scene, side: Side, water: &ReservoirScene, manifest: &Manifest) -> Group {
    let name = if side == Side::Upstream { "Reservoir" } else { "Tailwater" }.to_owned();
    if water.is_empty() {
        return Group { name, rows: vec![Row::text("model", "empty")] };
    }
    let mut rows = vec![
        Row::text("model", water.fidelity.word()),
        Row::number("depth", scene.depth_of(side), "m"),
        Row::number("density", water.density, "kg/m³"),
        Row::number("hydrostatic pressure at the base", 1e-3 * scene.hydrostatic_base_pressure(side), "kPa"),
    ];
    if let Some(unit) = manifest.units.iter().find(|unit| unit.name == side.table()) {
        rows.push(Row::text("solver", unit.solver.clone()));
    }
    if water.fidelity.is_compressible() {
        rows.push(Row::number("speed of sound", water.sound_speed, "m/s"));
        rows.push(Row::number(
            "wave reflection coefficient of the bed",
            water.wave_reflection_coefficient,
            "1",
        ));
        rows.push(Row::text("time integration", word(&water.method)));
    }
    if water.fidelity.is_solved() {
        rows.push(Row::text("gravity waves", if water.surface_waves { "yes" } else { "no" }));
        rows.extend(water.element_size.map(|size| Row::number("element size", size, "m")));
        rows.extend(water.far_end_distance.map(|far| Row::number("distance to the far end", far, "m")));
    }
    Group { name, rows }
}

fn coupling(scene: &Scene) -> Group {
    let coupling = &scene.coupling;
    let mut rows = vec![Row::text("scheme", word(&scene.scheme()))];
    if scene.scheme().is_implicit() {
        rows.push(Row::text("acceleration", word(&coupling.acceleration)));
        rows.push(match coupling.tolerance {
            Tolerance::Relative(tolerance) => Row::number("tolerance", tolerance, "1"),
            Tolerance::Balanced => {
                Row::text("tolerance", "balanced with the error of the communication step")
            }
        });
    }
    if coupling.window > 1 {
        rows.push(Row::number("steps per window", coupling.window as f64, "1"));
    }
    Group { name: "Coupling".to_owned(), rows }
}

/// Hashes, program, machine and date.
pub fn provenance(run: &RunFolder) -> Group {
    let (manifest, build) = (&run.manifest, &run.manifest.build);
    let mut rows = vec![
        Row::text("start of the run", manifest.started.clone()),
        Row::text("program", format!("cofferdam {}, {}", build.version, build.profile)),
        Row::code("commit", build.commit.clone()),
        Row::text("machine", format!("{}, {} cores", build.processor, build.cores)),
        Row::text("system", build.system.clone()).with(build.features.clone()),
        Row::code("scene", sha256(&run.log.head().scene_text)).with("SHA-256 of the scene with all defaults"),
    ];
    for (number, shock) in run.loaded.scene.ground_motion.shocks().iter().enumerate() {
        let of = if number > 0 { format!(" of {}", shock.label) } else { String::new() };
        let hashes = [
            ("record", &shock.record.sha256),
            ("vertical record", &shock.vertical.and_then(|v| v.sha256.clone())),
        ];
        for (component, hash) in hashes {
            let row = |hash| Row::code(format!("{component}{of}"), hash).with("SHA-256 of the file");
            rows.extend(hash.clone().map(row));
        }
    }
    if let Some(hash) = run.loaded.scene.dam.as_ref().and_then(|dam| dam.mesh.as_ref()?.sha256.as_ref()) {
        rows.push(Row::code("mesh", hash).with("SHA-256 of the file"));
    }
    for unit in &manifest.units {
        rows.push(Row::code(&unit.name, &unit.fingerprint).with("hash of all inputs of the unit"));
    }
    Group { name: "Provenance".to_owned(), rows }
}

/// The scene as TOML, without the text of a mesh.
pub fn scene_text(scene: &Scene) -> String {
    let mut scene = scene.clone();
    if let Some(mesh) = scene.dam.as_mut().and_then(|dam| dam.mesh.as_mut()) {
        mesh.text = None;
    }
    // A scene that was read as TOML can be written as such.
    toml::to_string(&scene).unwrap_or_default()
}
