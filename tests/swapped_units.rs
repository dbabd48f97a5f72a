//! Other programs' units in a scene: each must give what the built-in one gives that it stands for.

use cofferdam_assembly::participant::{Foreign, Place};
use cofferdam_coupling::participant::{AccelerationMeaning, Occasion, Participant, ParticipantError};
use cofferdam_log::{Log, compare};
use cofferdam_unit::Role;
use cofferdam_unit::WetFace;
use std::path::{Path, PathBuf};
use std::process::Command;
use toml::{Table, Value};
use whole_chain::scenario::{Histories, Scenario, binary, root};
use whole_chain::small_unit::SmallUnit;
use whole_chain::{peak, python};

/// A table with one unit's file, command or log.
fn table(pairs: &[(&str, Value)]) -> Value {
    Value::Table(pairs.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect::<Table>())
}

fn text(path: &Path) -> Value {
    path.to_string_lossy().into_owned().into()
}

/// The main scene, coarse, over its strongest second, with a tight tolerance: what is compared differs by no more.
fn tight() -> Scenario {
    let mut scenario = Scenario::quick(1.0);
    scenario.set("ground_motion.record.start", 4.0).set("coupling.tolerance", 1e-11);
    scenario
}

fn run(scenario: &Scenario, output: &str, options: &[&str]) -> PathBuf {
    let done = scenario.command(output).args(options).output().expect("cofferdam runs");
    let [said, complained] =
        [&done.stdout, &done.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert!(done.status.success(), "{output}: {said}\n{complained}");
    scenario.folder().join(output)
}

fn crest(run: &Path) -> Vec<f64> {
    Histories::read(&run.join("histories.csv")).column("dam.crest_displacement.x").to_vec()
}

/// Largest difference over the largest value.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) / peak(a)
}

/// Number of identical exchanges of two runs, which must be all.
fn identical(first: &Path, second: &Path) -> u64 {
    let log = |run: &Path| Log::open(&run.join("log.mcap")).expect("a log");
    let same = compare([&log(first), &log(second)]).expect("logs that can be compared");
    assert!(same.identical(), "{same:?}");
    same.identical
}

#[test]
fn units_packed_as_fmus_take_their_own_place_bit_for_bit() {
    let mut scenario = Scenario::quick(0.4);
    scenario.set("ground_motion.record.start", 4.0).set("reservoir.fidelity", "compressible");
    let own = run(&scenario, "own", &[]);
    for unit in ["dam", "reservoir"] {
        let file = scenario.folder().join(format!("{unit}.fmu"));
        let mut export = Command::new(binary());
        export.args(["export-fmu", "--unit", unit]).arg("--output").arg(&file).arg(scenario.folder());
        assert!(export.output().expect("cofferdam runs").status.success());
    }
    for unit in ["dam", "reservoir"] {
        // A path from the scene's folder.
        let file = Value::from(format!("{unit}.fmu"));
        scenario
            .set(&format!("{unit}.fidelity"), "fmu")
            .set(&format!("{unit}.fmu"), table(&[("file", file)]));
        for transport in ["shared-memory", "in-process"] {
            let swapped = run(&scenario, &format!("{unit}-{transport}"), &["--transport", transport]);
            println!("{unit} as FMU, {transport}: {} identical exchanges", identical(&own, &swapped));
        }
    }
    // Both now; results that no coupling needs come from the FMUs too.
    let both = Histories::read(&scenario.folder().join("reservoir-shared-memory/histories.csv"));
    let built_in = Histories::read(&own.join("histories.csv"));
    for column in ["dam.crack_sliding.0", "dam.energy_balance_error", "reservoir.base_pressure"] {
        assert_eq!(both.column(column), built_in.column(column), "{column}");
    }
    // A dam that is tested at the last step is read there, not where the test has left it.
    scenario.set("time.duration", 0.025);
    let short = run(&scenario, "short", &[]);
    assert!(short.join("envelopes-dam.vtu").exists(), "ten steps");
    // A scene's mesh says nothing of a packed dam.
    scenario.set("dam.element_size", 20.0);
    let done = Command::new(binary()).arg("check").arg(scenario.write()).output().expect("cofferdam runs");
    let said = String::from_utf8_lossy(&done.stdout).into_owned();
    assert!(done.status.success() && said.contains("dam: FMU dam of FMI 3.0"), "{said}");
    // A log of a run with FMUs is replayed by them.
    let replay =
        Command::new(binary()).arg("replay").arg(scenario.folder().join("reservoir-in-process")).output();
    let replay = replay.expect("cofferdam runs");
    let said = String::from_utf8_lossy(&replay.stdout).into_owned();
    assert!(replay.status.success() && said.contains("identical"), "{said}");
}

#[test]
fn units_in_another_executable_take_their_own_place_bit_for_bit() {
    let mut scenario = Scenario::quick(0.2);
    scenario.set("ground_motion.record.start", 4.0).set("reservoir.fidelity", "compressible");
    let own = run(&scenario, "own", &[]);
    let argv = Value::Array(vec![text(Path::new(env!("CARGO_BIN_EXE_built_in_unit")))]);
    for unit in ["reservoir", "dam"] {
        scenario.set(&format!("{unit}.fidelity"), "command");
        scenario.set(&format!("{unit}.command"), table(&[("argv", argv.clone())]));
        let swapped = run(&scenario, unit, &[]);
        println!("{unit} in another executable: {} identical exchanges", identical(&own, &swapped));
    }
}

#[test]
fn a_run_of_the_past_in_the_place_of_a_unit_moves_the_other_as_it_did_then() {
    for (fidelity, scheme) in [("compressible", "serial-implicit"), ("westergaard", "parallel-implicit")] {
        let mut scenario = Scenario::quick(0.3);
        scenario.set("ground_motion.record.start", 4.0).set("reservoir.fidelity", fidelity);
        scenario.set("coupling.scheme", scheme).set("reservoir.interface_size", 8.0);
        let own = run(&scenario, "own", &[]);
        let before = Histories::read(&own.join("histories.csv"));
        let recorded = table(&[("file", "own".into())]);
        let mut water = Scenario::quick(0.3);
        water.set("ground_motion.record.start", 4.0).set("reservoir.fidelity", "log");
        water.set("reservoir.log", table(&[("file", text(&own))]));
        let again = run(&water, "again", &[]);
        let after = Histories::read(&again.join("histories.csv"));
        for column in
            ["dam.crest_displacement.x", "dam.crack_sliding.0", "dam.strain_energy", "dam.base_shear"]
        {
            assert_eq!(before.column(column), after.column(column), "{fidelity}: {column}");
        }
        assert!(after.column("iterations").iter().all(|iterations| *iterations <= 1.0));

        scenario.set("dam.fidelity", "log").set("dam.log", recorded);
        if scheme == "serial-implicit" {
            let again = run(&scenario, "dam-again", &[]);
            let after = Histories::read(&again.join("histories.csv"));
            for column in ["dam.crest_displacement.x", "reservoir.base_pressure", "reservoir.total_force"] {
                assert_eq!(before.column(column), after.column(column), "{fidelity}: {column}");
            }
        }
    }
}

#[test]
fn water_in_python_is_the_built_in_water_whatever_its_input_means() {
    let mut scenario = tight();
    let built_in = crest(&run(&scenario, "built-in", &[]));
    let water = root().join("examples/python/westergaard.py");
    let argv = Value::Array(vec![text(python::interpreter()), text(&water)]);
    scenario.set("reservoir.fidelity", "command");
    for meaning in ["mean", "end"] {
        scenario.set("reservoir.command", table(&[("argv", argv.clone()), ("acceleration", meaning.into())]));
        let error = apart(&built_in, &crest(&run(&scenario, meaning, &[])));
        println!("water in Python, acceleration {meaning:?}: crest apart by {error:.1e}");
        assert!(error < 1e-8);
    }
}

#[test]
fn water_in_c_and_in_python_from_templates_agree() {
    let mut scenario = tight();
    let mut crests = Vec::new();
    for (language, fidelity) in [("c", "fmu"), ("python", "command")] {
        let folder = scenario.folder().join(language);
        let mut template = Command::new(binary());
        template.args(["template", language]).arg(&folder).arg("--scene").arg(scenario.write());
        python::succeed(&mut template);
        let given = match language {
            "c" => {
                python::succeed(Command::new("sh").arg("build.sh").current_dir(&folder));
                table(&[("file", text(&folder.join("water.fmu"))), ("acceleration", "end".into())])
            }
            _ => {
                let argv = Value::Array(vec![text(python::interpreter()), "water.py".into()]);
                table(&[("argv", argv), ("folder", text(&folder)), ("acceleration", "end".into())])
            }
        };
        let mut swapped = tight();
        swapped.set("reservoir.fidelity", fidelity).set(&format!("reservoir.{fidelity}"), given);
        crests.push(crest(&run(&swapped, "run", &[])));
    }
    let error = apart(&crests[0], &crests[1]);
    println!("water in C and in Python: crests apart by {error:.1e}");
    assert!(error < 1e-8 && peak(&crests[0]) > 1e-3);
    // Sampled at the points in place of integrated, the formula is another one than the built-in water's.
    scenario.set("reservoir.fidelity", "westergaard");
    let built_in = crest(&run(&scenario, "built-in", &[]));
    assert!((1e-6..0.2).contains(&apart(&built_in, &crests[0])));
}

#[test]
fn check_says_what_another_programs_unit_is_and_can() {
    let mut scenario = Scenario::quick(0.1);
    let folder = scenario.folder().join("c");
    let mut template = Command::new(binary());
    template.args(["template", "c"]).arg(&folder).arg("--scene").arg(scenario.write());
    python::succeed(&mut template);
    python::succeed(Command::new("sh").arg("build.sh").current_dir(&folder));
    let file = text(&folder.join("water.fmu"));
    scenario.set("reservoir.fidelity", "fmu");
    scenario.set("reservoir.fmu", table(&[("file", file), ("acceleration", "end".into())]));
    let done = Command::new(binary()).arg("check").arg(scenario.write()).output().expect("cofferdam runs");
    let said = String::from_utf8_lossy(&done.stdout).into_owned();
    assert!(done.status.success(), "{said}{}", String::from_utf8_lossy(&done.stderr));
    for part in [
        "reservoir: FMU water of FMI 3.0",
        "repeated steps and sign are correct: 1 m/s² into the water, held for two steps, gives ",
        "of any length",
        "at the step's end",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    // The template's water is Westergaard's, sampled at its points; extrapolated from rest it would be 1.5 times as heavy.
    let number = |after: &str| -> f64 {
        let (_, rest) = said.split_once(after).expect("its name");
        rest.split([' ', ';']).next().and_then(|number| number.parse().ok()).expect("a number")
    };
    let [found, exact] = ["held for two steps, gives ", "Westergaard's added mass "].map(number);
    assert!((found / exact - 1.0).abs() < 0.02, "{said}");
}

/// Of a(t) = 2 + 3 t over steps of unequal length, each taken twice: a dam's values at the ends give exact means, and water that is
/// given means gets exact values at the ends once it has a step before.
#[test]
fn accelerations_at_the_end_of_steps_are_converted_both_ways() -> Result<(), ParticipantError> {
    let face = WetFace::straight([0.0, 10.0], 1).expect("a face");
    let place = |role| Place {
        role,
        face: face.clone(),
        specific_weight: 9810.0,
        acceleration: AccelerationMeaning::End,
    };
    let dam = SmallUnit::structure("dam", &[("", 2)], (), vec![0.0, 0.0, 2.0, 2.0], |(), at, _, answer| {
        answer.copy_from_slice(&[0.0, 0.0, 2.0 + 3.0 * at.end(), 2.0 + 3.0 * at.end()]);
    });
    let water = SmallUnit::reservoir(2, (), vec![0.0; 2], |(), _, given, answer| {
        answer.iter_mut().zip(given).for_each(|(pressure, a)| *pressure = -a);
    });
    let mut dam = Foreign::new(Box::new(dam), &place(Role::Structure))?;
    let mut water = Foreign::new(Box::new(water), &place(Role::Fluid))?;
    assert_eq!(water.read("hydrostatic_pressure")?, [98_100.0, 0.0]);
    assert_eq!(water.read("interface_y")?, [0.0, 10.0]);
    let (mut moved, mut pressure) = (vec![0.0; 4], vec![0.0; 2]);
    dam.initialise(0.0, &[0.0; 6], &mut moved)?;
    water.initialise(0.0, &[0.0; 4], &mut pressure)?;
    let mut time = 0.0;
    for (step, communication_step) in [(1, 0.5), (2, 0.25), (3, 1.0)] {
        let occasion = Occasion { step, iteration: 1, attempt: 1, time, communication_step };
        dam.save_state()?;
        water.save_state()?;
        for again in [false, true] {
            if again {
                dam.restore_state()?;
                water.restore_state()?;
            }
            dam.step(&occasion, &[0.0; 6], &mut moved)?;
            let mean = 2.0 + 3.0 * (time + communication_step / 2.0);
            assert!((moved[2] - mean).abs() < 1e-14, "step {step}: {moved:?}");
            water.step(&occasion, &[moved[2], moved[3], 0.0, 0.0], &mut pressure)?;
            let exact = (pressure[0] + 2.0 + 3.0 * occasion.end()).abs() < 1e-14;
            assert_eq!(exact, step > 1, "step {step}: {pressure:?}");
        }
        time = occasion.end();
    }
    Ok(())
}
