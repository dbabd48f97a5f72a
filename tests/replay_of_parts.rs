//! Parts of a run are replayed from where its units stood, and units that give no state as bytes are brought there.

use cofferdam_assembly::simulation::simulation_of;
use cofferdam_assembly::units::{DAM, RESERVOIR};
use cofferdam_assembly::{Assembly, read_scene};
use cofferdam_coupling::difference::Difference;
use cofferdam_coupling::observer::{Ending, Observer, Status};
use cofferdam_coupling::participant::Participant;
use cofferdam_coupling::scheme::UnitId;
use cofferdam_log::replay::{Part, ReplayError, ReplayedPart, bring, replay_part};
use cofferdam_log::{Log, LogWriter, Preamble};
use cofferdam_scene::LoadedScene;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::Command;
use toml::{Table, Value};
use whole_chain::python::interpreter;
use whole_chain::scenario::{Scenario, binary, root};

type Failure = Box<dyn std::error::Error>;

/// A step, and the states of all units at its end.
type Stop = (u64, Vec<Vec<u8>>);

/// A short, coarse scene in which cracks slide.
fn coarse(settings: &[(&str, Value)]) -> Scenario {
    let mut scenario = Scenario::shipped("koyna-coarse");
    scenario.set("dam.element_size", 20.0).set("reservoir.element_size", 20.0);
    scenario.set("ground_motion.record.start", 5.0).set("ground_motion.record.end", 5.1);
    scenario.set("time.quiet", 0.0);
    for (key, value) in settings {
        scenario.set(key, value.clone());
    }
    scenario
}

/// Runs a scene in this process; its log, and the states of its units after initialisation and every accepted window, with the last
/// step of it.
fn run(scenario: &Scenario) -> Result<(LoadedScene, Log, Vec<Stop>), Failure> {
    let loaded = read_scene(&scenario.write(), &[])?;
    let graph = Assembly::with(&loaded.scene, NonZeroUsize::MIN).graph()?;
    let mut simulation = simulation_of(&loaded.scene, &loaded.ground_motion, graph)?;
    let path = scenario.folder().join("log.mcap");
    let scene = toml::to_string(&loaded.scene)?;
    let preamble = Preamble { scene, window: loaded.scene.coupling.window, ..Preamble::default() };
    let mut log = LogWriter::create(&path, &preamble)?;
    let mut course = simulation.course();
    let mut states = Vec::new();
    simulation.begin(&mut course, &mut [&mut log])?;
    let (h, window) = (loaded.scene.time.communication_step, loaded.scene.coupling.window as u64);
    let steps = loaded.scene.steps();
    loop {
        let step = (course.time() / h).round() as u64;
        if step.is_multiple_of(window) || step == steps {
            states.push((step, simulation.graph.serialise()?));
        }
        if simulation.advance(&mut course, &mut [&mut log])?.is_some() {
            break;
        }
    }
    log.end(&Ending {
        status: Status::Completed,
        time: course.time(),
        wall: Default::default(),
        statistics: course.statistics().clone(),
    })?;
    drop(log);
    states.dedup_by_key(|(step, _)| *step);
    Ok((loaded, Log::open(&path)?, states))
}

fn made(loaded: &LoadedScene, id: UnitId) -> Result<Box<dyn Participant>, Failure> {
    Ok(Assembly::with(&loaded.scene, NonZeroUsize::MIN).unit(id)?)
}

#[test]
fn units_are_brought_to_where_the_run_had_them() -> Result<(), Failure> {
    for (scheme, window) in [("serial-implicit", 1), ("parallel-implicit", 3)] {
        let scenario = coarse(&[("coupling.scheme", scheme.into()), ("coupling.window", window.into())]);
        let (loaded, log, states) = run(&scenario)?;
        let last = states.last().ok_or("states")?.0;
        assert!(states.len() > 10 && last > 30, "{} states, {last} steps", states.len());
        for id in [DAM, RESERVOIR] {
            let mut stands: Option<&Stop> = None;
            for state in
                states.iter().filter(|(step, _)| *step < 4 || step.is_multiple_of(9) || *step == last)
            {
                let (step, bytes) = state;
                let mut unit = made(&loaded, id)?;
                let brought = bring(&log, id, &mut *unit, None, *step, |_| ())?;
                assert_eq!((brought.exchanges, brought.divergence), (step + 1, None), "step {step}");
                assert!(unit.serialise()?.as_ref() == Some(&bytes[id.0]), "{id:?}, step {step}");
                // From an earlier state.
                if let Some((before, earlier)) = stands {
                    let mut unit = made(&loaded, id)?;
                    unit.deserialise(&earlier[id.0])?;
                    let brought = bring(&log, id, &mut *unit, Some(*before), *step, |_| ())?;
                    assert_eq!((brought.exchanges, brought.divergence), (step - before, None), "step {step}");
                    assert!(unit.serialise()?.as_ref() == Some(&bytes[id.0]), "{id:?}, step {step}");
                }
                stands = Some(state);
            }
        }
        // Inside a window too: the accepted exchanges are the last ones of each step.
        let mut unit = made(&loaded, DAM)?;
        let brought = bring(&log, DAM, &mut *unit, None, 10, |_| ())?;
        assert_eq!((brought.exchanges, brought.divergence), (11, None));
        let beyond = bring(&log, DAM, &mut *made(&loaded, DAM)?, None, last + 1, |_| ());
        assert!(
            matches!(beyond, Err(ReplayError::Beyond { step, last: found }) if (step, found) == (last + 1, last))
        );
    }
    Ok(())
}

#[test]
fn another_unit_is_brought_there_too_and_the_first_difference_is_named() -> Result<(), Failure> {
    let scenario = coarse(&[]);
    let (loaded, log, states) = run(&scenario)?;
    let last = states.last().ok_or("states")?.0;
    let set = ["dam.cracks.0.dilation=1e-6".to_owned()];
    let other = read_scene(&scenario.write(), &set)?;
    let mut dam = made(&other, DAM)?;
    let brought = bring(&log, DAM, &mut *dam, None, last, |_| ())?;
    let divergence = brought.divergence.ok_or("it slides otherwise")?;
    assert_eq!(brought.exchanges, last + 1, "it went on");
    assert!((1..last).contains(&divergence.occasion.step) && divergence.before == divergence.occasion.step);
    assert!(matches!(divergence.what, Difference::Value { values: [a, b], .. } if a != b));
    // It stands where it would have stood: a second one, brought there in two parts.
    let state = dam.serialise()?.ok_or("its bytes")?;
    let mut again = made(&other, DAM)?;
    bring(&log, DAM, &mut *again, None, last / 2, |_| ())?;
    bring(&log, DAM, &mut *again, Some(last / 2), last, |_| ())?;
    assert!(again.serialise()? == Some(state));
    // One with other inputs is not.
    let refused = bring(&log, DAM, &mut *made(&loaded, RESERVOIR)?, None, 3, |_| ());
    let refused = refused.expect_err("it is no dam").to_string();
    assert!(refused.starts_with("reservoir: its input `interface_acceleration`"), "{refused}");
    Ok(())
}

#[test]
fn every_part_of_a_run_is_replayed() -> Result<(), Failure> {
    let scenario = coarse(&[("coupling.window", 3.into())]);
    let (loaded, log, states) = run(&scenario)?;
    let last = states.last().ok_or("states")?.0;
    let entries = log.entries()?.collect::<Result<Vec<_>, _>>()?;
    for id in [DAM, RESERVOIR] {
        let steps: Vec<u64> = entries
            .iter()
            .filter_map(|entry| match entry {
                cofferdam_log::Entry::Exchange(exchange) if exchange.unit == id => {
                    Some(exchange.occasion.step)
                }
                _ => None,
            })
            .collect();
        for (from, until) in [(0, 0), (0, 5), (1, 1), (2, 2), (7, 12), (11, 11), (20, u64::MAX), (last, last)]
        {
            // Whole windows of three steps.
            let first = if from == 0 { 0 } else { from - (from - 1) % 3 };
            let end = if until == 0 { 0 } else { (until.saturating_sub(1) / 3 * 3 + 3).min(last) };
            let wanted = steps.iter().filter(|step| (first..=end).contains(*step)).count() as u64;
            let part = Part { from, until, stands: None };
            let found = replay_part(&log, id, &mut *made(&loaded, id)?, &part, |_| ())?;
            assert_eq!((found.identical, &found.divergence), (wanted, &None), "{part:?}");
            let replayed = ReplayedPart { from: first, until: end, brought: first };
            assert_eq!(found.part, Some(replayed), "{part:?}");
            // From the state that the run had.
            let Some((stands, bytes)) = states.iter().rev().find(|(step, _)| *step < first) else { continue };
            let mut unit = made(&loaded, id)?;
            unit.deserialise(&bytes[id.0])?;
            let part = Part { stands: Some(*stands), ..part };
            let found = replay_part(&log, id, &mut *unit, &part, |_| ())?;
            let replayed = ReplayedPart { brought: first - 1 - stands, ..replayed };
            assert_eq!(
                (found.identical, found.divergence, found.part),
                (wanted, None, Some(replayed)),
                "{part:?}"
            );
        }
        let part = Part { from: last + 5, until: u64::MAX, stands: None };
        let beyond =
            replay_part(&log, id, &mut *made(&loaded, id)?, &part, |_| ()).expect_err("no such step");
        let said = format!("the log ends with step {last}, and step {} is asked for", last + 5);
        assert!(beyond.to_string().starts_with(&said), "{beyond}");
        // A unit that is not where it is said to be is found out.
        let mut unit = made(&loaded, id)?;
        unit.deserialise(&states[2].1[id.0])?;
        let part = Part { from: 20, until: 22, stands: Some(states[3].0) };
        let found = replay_part(&log, id, &mut *unit, &part, |_| ());
        assert!(found.is_err() || found.is_ok_and(|replay| replay.divergence.is_some()));
    }
    Ok(())
}

fn cofferdam(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(binary()).args(arguments).output().expect("cofferdam runs");
    // Messages are wrapped at the width of a terminal.
    let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    let words = said.lines().map(|line| line.trim_start_matches([' ', '│', '×'])).collect::<Vec<_>>();
    (output.status.code(), words.join(" "))
}

fn logged(scenario: &Scenario, name: &str) -> PathBuf {
    let run = scenario.try_run(name);
    assert!(run.status.success(), "{name}: {}", String::from_utf8_lossy(&run.stderr));
    scenario.folder().join(name)
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a path")
}

#[test]
fn steps_and_keys_that_cannot_be_are_refused() {
    let scenario = coarse(&[]);
    let run = logged(&scenario, "run");
    let run = text(&run);
    for (arguments, status, words) in [
        (&["--from", "9", "--until", "8"][..], 2, "--from 9 is after --until 8; exchange them"),
        (&["--step", "400"], 2, "and step 400 is asked for; ask for steps up to 44"),
        (&["--step", "4", "--until", "5"], 2, "cannot be used with"),
        (&["--step", "-1"], 2, "unexpected argument"),
        (&["--step", "1.5"], 2, "invalid value '1.5'"),
        (&["--unit", "tailwater"], 2, "the log has no unit called tailwater; choose one of dam, reservoir"),
        (&["--set", "coupling.tolerance=1e-9"], 2, "(dam, reservoir) depends on `coupling.tolerance`"),
        (&["--set", "coupling.tolerance=1e-9"], 2, "use `cofferdam branch`"),
        (
            &["--set", "ground_motion.record.scale=2"],
            2,
            "(dam, reservoir) depends on `ground_motion.record.scale`",
        ),
        (
            &["--unit", "dam", "--set", "reservoir.sound_speed=1400"],
            2,
            "it is for reservoir: replay that with --unit",
        ),
        (
            &[
                "--unit",
                "dam",
                "--set",
                "dam.cracks.0.dilation=1e-6",
                "--set",
                "coupling.acceleration=aitken",
            ],
            2,
            "`coupling.acceleration`",
        ),
        // What it is already.
        (
            &["--unit", "dam", "--step", "3", "--set", "dam.element_size=20.0"],
            0,
            "dam: identical: 2 exchanges of step 3 (made in",
        ),
        (
            &["--unit", "reservoir", "--step", "1", "--set", "reservoir.sound_speed=1400"],
            5,
            "different in step 1",
        ),
        (&["--unit", "dam", "--from", "38", "--until", "90"], 0, "of steps 38 to 44"),
        (&["--unit", "dam", "--from", "38", "--until", "90"], 0, "put at the end of step 37 by "),
        (
            &["--unit", "dam", "--step", "30", "--set", "dam.cracks.0.friction_coefficient=0.9"],
            5,
            "on the way to step 30, where the replay was to begin",
        ),
    ] {
        let (found, said) = cofferdam(&[&["replay", "--quiet", run], arguments].concat());
        assert!(found == Some(status) && said.contains(words), "{arguments:?}: {found:?} {said}");
    }
    // A log that is cut short.
    let log = std::fs::read(format!("{run}/log.mcap")).expect("a log");
    let cut = format!("{run}/cut.mcap");
    std::fs::write(&cut, &log[..log.len() - 100]).expect("written");
    let (found, said) = cofferdam(&["replay", "--quiet", &cut, "--unit", "dam", "--step", "7000"]);
    assert!(found == Some(2) && said.contains("the log ends with step"), "{said}");
}

fn table(pairs: &[(&str, Value)]) -> Value {
    Value::Table(pairs.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect::<Table>())
}

/// Units of other programs are made for a replay as they were for the run, in this process or in others.
#[test]
fn units_of_other_programs_are_replayed() {
    let python: Vec<Value> = vec![
        text(interpreter()).into(),
        "-B".into(),
        text(&root().join("tests/python/units.py")).into(),
        "Sampled".into(),
    ];
    let executable: Vec<Value> = vec![env!("CARGO_BIN_EXE_built_in_unit").into()];
    let dam = coarse(&[]);
    let file = dam.folder().join("dam.fmu");
    let mut export = Command::new(binary());
    export.args(["export-fmu", "--unit", "dam", "--output", text(&file)]).arg(dam.write());
    assert!(export.output().expect("cofferdam runs").status.success());
    let fmu = [("dam.fidelity", "fmu".into()), ("dam.fmu", table(&[("file", text(&file).into())]))];
    let command = |argv: &[Value]| {
        [
            ("reservoir.fidelity", Value::from("command")),
            ("reservoir.command", table(&[("argv", argv.to_vec().into()), ("acceleration", "end".into())])),
        ]
    };
    let cases = [
        ("fmu", fmu.to_vec()),
        ("python", command(&python).to_vec()),
        ("executable", command(&executable).to_vec()),
    ];
    for (what, settings) in cases {
        let scenario = coarse(&settings);
        let run = logged(&scenario, "run");
        for more in [&[][..], &["--transport", "shared-memory"], &["--from", "17", "--until", "25"]] {
            let (status, said) = cofferdam(&[&["replay", "--quiet", text(&run)], more].concat());
            let both = ["dam: identical: ", "reservoir: identical: "];
            assert!(
                status == Some(0) && both.iter().all(|unit| said.contains(unit)),
                "{what} {more:?}: {said}"
            );
            assert!(!said.contains("warning"), "{what} {more:?}: {said}");
        }
        // A command may read the whole scene, but not how it is coupled.
        for (set, status) in [("reservoir.density=900.0", 5), ("coupling.tolerance=1e-9", 2)] {
            if what != "fmu" {
                let (found, said) = cofferdam(&["replay", "-q", text(&run), "-u", "reservoir", "--set", set]);
                assert_eq!(found, Some(status), "{what} {set}: {said}");
            }
        }
    }
}
