//! `reservoir.fidelity = "none"`: the dam alone, computed like every other run.

use cofferdam_assembly::ground::ground_signals;
use cofferdam_assembly::observer::HistoriesWriter;
use cofferdam_assembly::participant::EmptyReservoir;
use cofferdam_assembly::read_scene;
use cofferdam_assembly::simulation::{scales, with_work};
use cofferdam_assembly::units::{RESERVOIR, pair};
use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
use cofferdam_coupling::convergence::{ConvergenceMeasure, Measure};
use cofferdam_coupling::participant::{InProcess, Messages, Participant};
use cofferdam_coupling::scheme::{Predictor, Scheme, SchemeKind, Settings};
use cofferdam_coupling::simulation::Simulation;
use cofferdam_coupling::stepping::Stepping;
use cofferdam_dam::Dam;
use cofferdam_log::Log;
use cofferdam_reservoir::{Reservoir, ReservoirParameters};
use cofferdam_unit::export::Contents;
use std::num::NonZeroUsize;
use std::process::{Command, Output};
use std::sync::atomic::AtomicBool;
use whole_chain::fmu::{Fmu, export};
use whole_chain::scenario::{Histories, Scenario, binary, root};
use whole_chain::{koyna, peak, relative_l2};

const H: f64 = 0.0025;
const STEPS: u64 = 400;

/// Crest displacement (m) of the intact dam with the `reservoir` made from the dam's wet face.
fn crest(kind: SchemeKind, reservoir: impl Fn(cofferdam_unit::WetFace) -> Box<dyn Participant>) -> Vec<f64> {
    let parameters = koyna::dam(10.0, false);
    let face = parameters.wet_face().expect("a mesh").expect("a wet face");
    let dam = InProcess::new(Dam::new(parameters).expect("a dam"), "dam", Messages::default());
    let mut graph = pair(Box::new(dam), reservoir(face)).expect("two units");
    let measure = ConvergenceMeasure::new(&[Measure::Relative], 1e-9, scales(koyna::CREST, 1e-6));
    let acceleration = Acceleration::new(AccelerationKind::Constant, 1.0, 1e-9);
    let settings = Settings { kind, ..Settings::default() };
    let motion =
        read_scene(&root().join("scenes/koyna-intact"), &["ground_motion.record.start=4".to_owned()])
            .expect("a shipped scene")
            .ground_motion;
    let signals = ground_signals(&motion);
    let scheme = Scheme::new(&mut graph, settings, acceleration, Predictor::new(2), measure, signals)
        .expect("units that fit");
    let scheme = with_work(scheme, &mut graph).expect("units that tell their points");
    let mut simulation = Simulation::new(graph, scheme, Stepping::equal(H, STEPS));
    let mut histories = HistoriesWriter::in_memory();
    let (_, failure) = simulation.run(&mut [&mut histories], &AtomicBool::new(false));
    assert!(failure.is_none(), "{failure:?}");
    histories.histories.column("dam.crest_displacement.x").expect("a crest").to_vec()
}

/// Water of 1e-9 kg/m³ has 1e-12 of water's inertia and weight, so that the two runs differ by some 1e-12.
#[test]
fn an_empty_reservoir_is_one_of_vanishing_density() {
    let empty = |face| Box::new(EmptyReservoir::new(face).expect("a face")) as Box<dyn Participant>;
    let thin = |face| {
        let parameters = ReservoirParameters { density: 1e-9, ..koyna::reservoir(face, H, H * STEPS as f64) };
        let unit = Reservoir::new(parameters, NonZeroUsize::MIN).expect("a reservoir");
        Box::new(InProcess::new(unit, "thin water", Messages::default())) as Box<dyn Participant>
    };
    let alone = crest(SchemeKind::SerialExplicit, empty);
    let before_thin_water = crest(SchemeKind::SerialImplicit, thin);
    let difference = relative_l2(&alone, &before_thin_water);
    println!("crest {:.2} mm at most; differs by {difference:.1e}", 1e3 * peak(&alone));
    assert!(peak(&alone) > 1e-3 && difference < 1e-10);
    // No scheme needs iterations.
    let iterated = crest(SchemeKind::SerialImplicit, empty);
    assert!(iterated == alone, "the implicit scheme has the same bits");
}

fn short() -> Scenario {
    let mut scenario = Scenario::shipped("koyna-intact");
    scenario.set("reservoir.fidelity", "none").set("dam.element_size", 10.0).set("time.duration", 0.5);
    scenario
}

fn said(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn a_run_is_one_process_one_dam_step_a_step_and_can_be_replayed() {
    let scenario = short();
    let output = said(&scenario.try_run("run"));
    let processes = output.lines().find(|line| line.starts_with("processes")).expect("a line");
    assert!(processes.contains("dam") && !processes.contains("reservoir"), "{processes}");
    assert!(output.contains("reservoir  empty") && output.contains("static crest displacement (weight)"));
    assert!(!output.contains("base pressure") && !output.contains("NaN"), "{output}");

    let run = scenario.folder().join("run");
    let histories = Histories::read(&run.join("histories.csv"));
    assert!(histories.column("iterations")[1..].iter().all(|count| *count == 1.0));
    assert!(histories.column("lowest_pressure").iter().all(|p| *p == 0.0));
    assert!(peak(histories.column("interface_work")) == 0.0);
    assert!(peak(histories.column("dam.crest_displacement.x")) > 0.0);
    let mut pressure = csv::Reader::from_path(run.join("reservoir-interface_pressure.csv")).expect("a file");
    let zero = |row: csv::StringRecord| row.iter().skip(1).all(|p| p.parse() == Ok(0.0));
    assert!(pressure.records().all(|row| zero(row.expect("a row"))));

    let replayed = Command::new(binary()).arg("replay").arg(&run).arg("--quiet").output().expect("a replay");
    let replayed = said(&replayed);
    assert!(replayed.contains("dam: identical: 201 exchanges"), "{replayed}");
    assert!(replayed.contains("reservoir: identical: 201 exchanges"), "{replayed}");
    let log = Log::open(&run).expect("a log");
    assert_eq!(log.head().unit(RESERVOIR).name, "reservoir");

    // The same bits in one process and from the manifest.
    let manifest: toml::Table =
        std::fs::read_to_string(run.join("manifest.toml")).expect("a manifest").parse().expect("TOML");
    let again = scenario.folder().join("again.toml");
    std::fs::write(&again, toml::to_string(&manifest["scene"]).expect("TOML")).expect("written");
    let mut command = Command::new(binary());
    command.arg("run").arg(again).args(["--quiet", "--transport", "in-process", "--output"]);
    said(&command.arg(scenario.folder().join("again")).output().expect("a run"));
    let read = |run: &str| std::fs::read(scenario.folder().join(run).join("histories.csv")).expect("a file");
    assert!(read("run") == read("again"), "the histories differ");
}

/// Without a depth there is no water level in the mesh, and the face extends to the crest.
#[test]
fn no_depth_is_needed_and_no_scheme_iterates() {
    let mut scenario = short();
    scenario.remove("reservoir.depth").set("coupling.scheme", "parallel-implicit");
    let said = said(&scenario.try_run("run"));
    let most =
        said.lines().find_map(|line| line.trim().strip_prefix("dam steps per communication step, most"));
    assert_eq!(most.map(str::trim), Some("1.000"), "{said}");
    let manifest = std::fs::read_to_string(scenario.folder().join("run/manifest.toml")).expect("a manifest");
    let manifest: toml::Table = manifest.parse().expect("TOML");
    let top = manifest["wet_face"].as_array().and_then(|points| points.last()).expect("points");
    assert_eq!(top[1].as_float(), Some(koyna::CREST));
    assert!(manifest["scene"]["reservoir"].get("depth").is_none());
    assert_eq!(manifest["scene"]["coupling"]["scheme"].as_str(), Some("serial-explicit"));
}

#[test]
fn its_dam_can_be_packed_without_load_and_its_water_cannot() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = root().join("scenes/koyna-intact");
    let arguments = ["--set", "reservoir.fidelity=none", "--set", "dam.element_size=10", "-o", "x.fmu"];
    let output = export(folder.path(), &scene, "reservoir", &arguments);
    let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(complaint.contains("reservoir is empty") && complaint.contains("--unit dam"), "{complaint}");
    assert!(!folder.path().join("x.fmu").exists());

    said(&export(folder.path(), &scene, "dam", &arguments));
    let mut fmu = Fmu::open(&folder.path().join("x.fmu"));
    std::fs::write(folder.path().join("unit.toml"), fmu.bytes("resources/unit.toml")).expect("written");
    let contents = Contents::<cofferdam_dam::DamParameters>::read(folder.path()).expect("contents");
    let hydrostatic = &contents.start["hydrostatic_pressure"];
    assert!(hydrostatic.len() > 5 && hydrostatic.iter().all(|p| *p == 0.0), "{hydrostatic:?}");
    assert!(contents.parameters.added_mass.is_none());
}

/// An estimate that is always zero would let steps grow for no reason, so the scene is refused.
#[test]
fn steps_cannot_follow_an_error_that_there_is_not() {
    let settings = ["reservoir.fidelity=none", "time.adaptive={tolerance=1e-3, shortest=1e-3, longest=0.01}"];
    let error =
        cofferdam_assembly::read_scene(&root().join("scenes/koyna-intact"), &settings.map(str::to_owned));
    let error = error.expect_err("nothing to follow");
    assert!(error.problems[0].to_string().starts_with("`time.adaptive`"), "{}", error.problems[0]);
}
