//! Water on both faces of the dam, from the scene to the log.

use cofferdam_assembly::observer::HistoriesWriter;
use cofferdam_assembly::simulation::simulation_of;
use cofferdam_assembly::units::DAM;
use cofferdam_assembly::{Assembly, read_scene};
use cofferdam_coupling::observer::{Ending, Observer, ObserverError, Start};
use cofferdam_coupling::scheme::{SchemeKind, WindowReport};
use cofferdam_log::{Log, compare};
use std::num::NonZeroUsize;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::AtomicBool;
use toml::{Table, Value};
use whole_chain::scenario::{Histories, Scenario, binary};

/// The scene with tailwater, coarse, for this long (s).
fn coarse(duration: f64) -> Scenario {
    let mut scenario = Scenario::shipped("koyna-tailwater");
    scenario.set("dam.element_size", 15.0).set("time.duration", duration);
    scenario.set("reservoir.element_size", 12.0).set("tailwater.element_size", 7.5);
    scenario
}

/// A dam of symmetric section between waters of the same depth and bed.
fn symmetric(polarity: i64) -> Scenario {
    let mut scenario = coarse(2.0);
    let side = |points: [[f64; 2]; 2]| {
        Value::Array(points.iter().map(|p| Value::Array(p.map(Value::Float).to_vec())).collect())
    };
    scenario.set("dam.section.upstream", side([[0.0, 0.0], [0.0, 60.0]]));
    scenario.set("dam.section.downstream", side([[30.0, 0.0], [30.0, 60.0]]));
    scenario.set("dam.cracks", Value::Array(Vec::new()));
    scenario.set("ground_motion.record.polarity", polarity);
    for water in ["reservoir", "tailwater"] {
        let bed = Value::Array(vec![Value::Array(vec![Value::Float(-40.0), Value::Float(10.0)])]);
        scenario.set(&format!("{water}.depth"), 48.0).set(&format!("{water}.bed"), bed);
        scenario.set(&format!("{water}.element_size"), 6.0);
    }
    scenario
}

/// Largest difference over the largest value.
fn apart(a: &[f64], b: impl Iterator<Item = f64>) -> f64 {
    let largest = whole_chain::peak(a);
    assert!(largest > 0.0);
    a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) / largest
}

#[test]
fn both_transports_give_the_same_log_and_all_three_units_replay() {
    let scenario = coarse(0.8);
    let paths = ["shared", "here"].map(|name| scenario.folder().join(name).join("log.mcap"));
    for (name, transport) in [("shared", "shared-memory"), ("here", "in-process")] {
        let done = scenario.command(name).args(["--transport", transport]).output().expect("cofferdam runs");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let said = String::from_utf8_lossy(&done.stdout).into_owned();
        assert_eq!(said.contains("processes  dam "), name == "shared");
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        for line in
            [" tailwater compressible", "peak hydrodynamic base pressure of the tailwater over hydrostatic"]
        {
            assert!(said.contains(line), "{said}");
        }
    }
    let logs = paths.each_ref().map(|path| Log::open(path).expect("a log"));
    let names: Vec<_> = logs[0].head().units.iter().map(|unit| unit.name.as_str()).collect();
    assert_eq!(names, ["dam", "reservoir", "tailwater"]);
    let same = compare([&logs[0], &logs[1]]).expect("two logs");
    assert!(same.identical() && same.identical > 3 * 320);
    let replayed = Command::new(binary()).arg("replay").arg(&paths[0]).arg("-q").output().expect("it runs");
    let said = String::from_utf8_lossy(&replayed.stdout);
    assert!(replayed.status.success(), "{said}");
    assert_eq!(said.matches(": identical: ").count(), 3, "{said}");

    let manifest =
        std::fs::read_to_string(scenario.folder().join("shared/manifest.toml")).expect("a manifest");
    let manifest: Table = manifest.parse().expect("TOML");
    let face = &manifest["further_wet_faces"].as_array().expect("a list")[0];
    assert_eq!(face["water"].as_str(), Some("tailwater"));
    let points = face["points"].as_array().expect("points");
    assert_eq!(points[0], Value::Array(vec![Value::Float(70.0), Value::Float(0.0)]));
    assert!(face.get("own_points").is_none(), "the tailwater has the dam's points");
    let rows = std::fs::read_to_string(scenario.folder().join("shared/tailwater-interface_pressure.csv"));
    assert_eq!(rows.expect("a file").lines().next().expect("a header").split(',').count(), 1 + points.len());
}

/// Work of each interface, J/m.
#[derive(Default)]
struct Works(Vec<f64>);

impl Observer for Works {
    fn begin(&mut self, start: &Start<'_>) -> Result<(), ObserverError> {
        self.0 = vec![0.0; start.units.len() - 1];
        Ok(())
    }

    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        for interfaces in &report.interfaces {
            for (sum, interface) in self.0.iter_mut().zip(interfaces) {
                *sum += interface.work.map_or(0.0, |work| work.on_first);
            }
        }
        Ok(())
    }

    fn end(&mut self, _ending: &Ending) -> Result<(), ObserverError> {
        Ok(())
    }
}

/// A column of values a point, for each row of a file of a wet face.
fn face(folder: &Path, name: &str) -> Vec<Vec<f64>> {
    let mut reader = csv::Reader::from_path(folder.join(name)).expect("a file");
    let row =
        |record: csv::StringRecord| record.iter().skip(1).map(|x| x.parse().expect("a number")).collect();
    reader.records().map(|record| row(record.expect("a row"))).collect()
}

/// The work at each interface is that of its own files, summed by a plain rule, and both together are the work of the
/// histories; the dam's energy is balanced with both.
#[test]
fn the_work_at_each_interface_adds_up_in_the_balance() -> Result<(), Box<dyn std::error::Error>> {
    let mut scenario = coarse(6.0);
    // Deep, so that its work counts.
    scenario.set("tailwater.depth", 80.0).set("dam.cracks", Value::Array(Vec::new()));
    let loaded = read_scene(&scenario.write(), &[])?;
    let graph = Assembly::with(&loaded.scene, NonZeroUsize::MIN).graph()?;
    let mut simulation = simulation_of(&loaded.scene, &loaded.ground_motion, graph)?;
    let folder = tempfile::tempdir()?;
    let (mut histories, mut works) = (HistoriesWriter::new(folder.path()), Works::default());
    let (_, failure) = simulation.run(&mut [&mut histories, &mut works], &AtomicBool::new(false));
    assert!(failure.is_none(), "{failure:?}");
    let column = |name: &str| histories.histories.column(name).unwrap_or_else(|| panic!("no {name}"));

    let (h, ground) = (loaded.scene.time.communication_step, column("ground_acceleration.x"));
    let mut velocity = vec![0.0];
    for pair in ground.windows(2) {
        velocity.push(velocity[velocity.len() - 1] + h * (pair[0] + pair[1]) / 2.0);
    }
    for (number, (prefix, water)) in [("", "reservoir"), ("tailwater_", "tailwater")].into_iter().enumerate()
    {
        let dam = &mut simulation.graph[DAM];
        let normals = dam.read(&format!("{prefix}interface_normal_x"))?;
        let [x, y] = [dam.read(&format!("{prefix}interface_x"))?, dam.read(&format!("{prefix}interface_y"))?];
        let length = |i: usize| (x[i + 1] - x[i]).hypot(y[i + 1] - y[i]);
        let pressure = face(folder.path(), &format!("{water}-interface_pressure.csv"));
        let moved = face(folder.path(), &format!("dam-{prefix}interface_velocity.csv"));
        let mut sum = 0.0;
        for step in 1..pressure.len() {
            let mean = |i: usize| (pressure[step][i] + pressure[step - 1][i]) / 2.0;
            let total = |i: usize, step: usize| moved[step][i] + velocity[step] * normals[i];
            let moves = |i: usize| h * (total(i, step) + total(i, step - 1)) / 2.0;
            for i in 0..normals.len() - 1 {
                // Both are linear along a panel.
                let product = |i: usize, j: usize| mean(i) * moves(j);
                let ends = product(i, i) + product(i + 1, i + 1);
                sum += length(i) * (2.0 * ends + product(i, i + 1) + product(i + 1, i)) / 6.0;
            }
        }
        println!("{water}: work {:.4e} J/m, {sum:.4e} J/m by trapezoids", works.0[number]);
        assert!(sum.abs() > 100.0 && (works.0[number] / sum - 1.0).abs() < 0.02);
    }
    let work = column("interface_work");
    let both: f64 = works.0.iter().sum();
    assert!((work[work.len() - 1] - both).abs() < 1e-9 * both.abs());
    let balance = whole_chain::peak(column("dam.energy_balance_error"));
    println!("energy balance error {balance:.1e} J/m");
    assert!(balance < 0.05 * works.0[1].abs(), "without the tailwater's work it would be as large as that");
    Ok(())
}

/// No thrust at rest, and the mirror image under the mirrored ground, which differs by the tolerance of the coupling.
#[test]
fn a_symmetric_dam_between_equal_waters_answers_the_mirrored_ground_in_the_mirror() {
    let [here, there] = [1, -1].map(|polarity| symmetric(polarity).run());
    let thrust = 1000.0 * 9.81 * 48.0 * 48.0 / 2.0;
    let shear = [&here, &there].map(|histories| histories.column("dam.base_shear")[0]);
    // What is left of the two is not the ground's.
    assert!((shear[0] + shear[1]).abs() < 1e-9 * thrust);
    for (name, image, sign) in [
        ("dam.base_shear", "dam.base_shear", -1.0),
        ("dam.base_normal_force", "dam.base_normal_force", 1.0),
        ("dam.kinetic_energy", "dam.kinetic_energy", 1.0),
        ("interface_work", "interface_work", 1.0),
        ("reservoir.base_pressure", "tailwater.base_pressure", 1.0),
        ("tailwater.base_pressure", "reservoir.base_pressure", 1.0),
        ("reservoir.total_force", "tailwater.total_force", -1.0),
    ] {
        let mirrored = there.column(image).iter().map(|value| sign * value);
        let error = apart(here.column(name), mirrored);
        println!("{name}: {error:.1e}");
        assert!(error < 1e-5, "{name}: {error}");
    }
    // The two waters of one run are no copies of each other.
    assert!(
        apart(here.column("reservoir.base_pressure"), here.column("tailwater.base_pressure").iter().copied())
            > 0.1
    );
}

/// The tailwater holds against the reservoir: the block leans less, and the factor of safety grows.
#[test]
fn the_check_knows_both_waters() {
    let said = |depth: f64| {
        let mut scenario = coarse(1.0);
        scenario.set("tailwater.depth", depth);
        let output = Command::new(binary()).arg("check").arg(scenario.write()).output().expect("it runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let factor = |text: &str| -> f64 {
        let rest =
            text.split("before the ground moves, by limit equilibrium: sliding ").nth(1).expect("a factor");
        rest.split([',', ' ']).next().expect("a number").parse().expect("a number")
    };
    let empty = read_scene(&coarse(1.0).set("reservoir.fidelity", "none").write(), &[]).expect("a scene");
    let thrust_of_tailwater_only = Assembly::of(&empty.scene).limit_equilibria().expect("a dam")[0];
    assert_eq!(thrust_of_tailwater_only.sliding, f64::INFINITY, "it stays below the crack");
    let [low, high] = [30.0, 80.0].map(|depth| factor(&said(depth)));
    println!("factor of safety against sliding {low} with 30 m of tailwater, {high} with 80 m");
    // Above the crack at 66.5 m: γ(25.25² − 13.5²)/2 in place of γ 25.25²/2; the water's weight adds little.
    let expected = 25.25 * 25.25 / (25.25 * 25.25 - 13.5 * 13.5);
    assert!((high / low / expected - 1.0).abs() < 0.02, "{}", high / low);
}

#[test]
fn the_scheme_follows_from_both_waters() {
    let scheme = |reservoir: &str, tailwater: &str| {
        let mut scenario = coarse(1.0);
        scenario.set("reservoir.fidelity", reservoir).set("tailwater.fidelity", tailwater);
        read_scene(&scenario.write(), &[]).expect("a scene").scene.scheme()
    };
    assert_eq!(scheme("westergaard", "incompressible"), SchemeKind::OneWay);
    assert_eq!(scheme("none", "westergaard"), SchemeKind::OneWay);
    for (reservoir, tailwater) in [("compressible", "westergaard"), ("westergaard", "compressible")] {
        assert_eq!(scheme(reservoir, tailwater), SchemeKind::SerialImplicit);
    }
    assert_eq!(scheme("none", "compressible"), SchemeKind::SerialImplicit);
}

/// Water without memory in the mass, or exchanged; behind a full or an empty reservoir, at points of its own.
#[test]
fn added_mass_of_both_waters_gives_what_exchanging_it_gives() {
    for reservoir in ["westergaard", "none"] {
        let mut scenario = coarse(3.0);
        scenario.set("dam.cracks", Value::Array(Vec::new()));
        scenario.set("reservoir.fidelity", reservoir).set("tailwater.fidelity", "incompressible");
        scenario.remove("reservoir.element_size").set("tailwater.depth", 60.0);
        let mass = scenario.run();
        scenario.set("coupling.scheme", "serial-implicit");
        std::fs::remove_dir_all(scenario.folder().join("run")).expect("the first run");
        let exchanged = scenario.run();
        let crest = "dam.crest_displacement.x";
        let error = apart(mass.column(crest), exchanged.column(crest).iter().copied());
        println!("reservoir {reservoir}: crest {error:.1e} apart");
        assert!(error < 0.02);
        let without = |histories: &Histories| histories.column("tailwater.base_pressure").to_vec();
        assert!(whole_chain::peak(&without(&mass)) > 1e3);
    }
}

#[test]
fn a_tailwater_with_panels_of_its_own_and_a_recursion_runs() {
    let mut scenario = coarse(1.0);
    scenario.set("snapshots", toml::toml! { interval = 0.5 });
    scenario.set("tailwater.interface_size", 6.0).set("tailwater.method", "recursive");
    // A recursion does not fit water between a slope and a rigid bed: the message names the unit.
    scenario.set("tailwater.wave_reflection_coefficient", 1.0);
    let refused = scenario.try_run("refused");
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(4), "{said}");
    assert!(said.contains("tailwater: no rational function could be fitted"), "{said}");
    scenario.set("tailwater.wave_reflection_coefficient", 0.9);
    let output = scenario.try_run("run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("error of the tailwater's recursion"), "{said}");
    let manifest = std::fs::read_to_string(scenario.folder().join("run/manifest.toml")).expect("a manifest");
    let manifest: Table = manifest.parse().expect("TOML");
    let face = &manifest["further_wet_faces"].as_array().expect("a list")[0];
    let count = |key: &str| face[key].as_array().map_or(0, Vec::len);
    assert!(count("own_points") > count("points"));
    // Its face is a part of each picture, at the unloaded positions from the toe up.
    for number in 0..3 {
        let path = scenario.folder().join(format!("run/snapshots/tailwater_wet_face-{number:06}.vtu"));
        let text = std::fs::read_to_string(path).expect("a picture");
        assert!(text.contains(&format!("NumberOfPoints=\"{}\"", count("points"))), "{text}");
        assert!(text.contains("hydrodynamic_pressure") && text.contains("70\n0\n0\n"), "{text}");
    }
}
