//! Branches are their runs up to where they leave them, go their own way from there, and can be resumed, replayed and branched.

use crate::log::{cofferdam, entries, exchanges, text};
use cofferdam_log::{Entry, Log, LogReadError, compare};
use std::path::{Path, PathBuf};
use std::process::Command;
use toml::{Table, Value};
use whole_chain::scenario::{Scenario, binary};

/// A short, coarse scene with many checkpoints.
fn coarse(settings: &[(&str, Value)]) -> Scenario {
    let mut scenario = Scenario::shipped("koyna-coarse");
    scenario.set("dam.element_size", 20.0).set("reservoir.element_size", 20.0);
    scenario.set("ground_motion.record.start", 5.0).set("ground_motion.record.end", 5.2);
    scenario.set("time.quiet", 0.0).set("log", table(&[("checkpoint_share", 0.3.into())]));
    for (key, value) in settings {
        scenario.set(key, value.clone());
    }
    scenario
}

fn table(pairs: &[(&str, Value)]) -> Value {
    Value::Table(pairs.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect::<Table>())
}

/// Water without memory.
fn without_memory() -> Vec<(&'static str, Value)> {
    vec![("reservoir.fidelity", "westergaard".into()), ("coupling.scheme", "serial-implicit".into())]
}

const HERE: &[&str] = &["--transport", "in-process"];

/// Runs the scene; the folder, and the exit status.
fn run(scenario: &Scenario, more: &[&str]) -> (PathBuf, Option<i32>) {
    let folder = scenario.folder().join("run");
    let scene = scenario.write();
    let (status, said) =
        cofferdam(&[&["run", text(&scene), "--quiet", "--output", text(&folder)], more].concat());
    assert!(matches!(status, Some(0 | 3)), "{said}");
    (folder, status)
}

/// Branches `run` into a folder beside it; the folder, the exit status and what was said, without line breaks.
fn branch(run: &Path, step: u64, name: &str, more: &[&str]) -> (PathBuf, Option<i32>, String) {
    let folder = run.with_file_name(name);
    let (step, output) = (step.to_string(), text(&folder));
    let arguments = [&["branch", text(run), "--quiet", "--step", &step, "--output", output], more].concat();
    let (status, said) = cofferdam(&arguments);
    let said = said.replace('│', " ").split_whitespace().collect::<Vec<_>>().join(" ");
    (folder, status, said)
}

fn histories(run: &Path) -> Vec<u8> {
    std::fs::read(run.join("histories.csv")).expect("histories")
}

/// That two runs are one, bit for bit.
fn equal(what: &str, a: &Path, b: &Path) -> Result<(), LogReadError> {
    let (log_a, log_b) = (Log::open(a)?, Log::open(b)?);
    assert!(compare([&log_a, &log_b])?.identical(), "{what}");
    assert!(histories(a) == histories(b), "{what}: histories");
    Ok(())
}

/// The last step, those with checkpoints, and how many attempts were given up.
fn steps(run: &Path) -> Result<(u64, Vec<u64>, usize), LogReadError> {
    let (mut last, mut checkpoints, mut rejected) = (0, Vec::new(), 0);
    for entry in entries(&run.join("log.mcap"))? {
        match entry {
            Entry::Step(step) => {
                (last, rejected) = (step.occasion.step, rejected + usize::from(!step.accepted))
            }
            Entry::Checkpoint(checkpoint) => checkpoints.push(checkpoint.step),
            _ => {}
        }
    }
    Ok((last, checkpoints, rejected))
}

/// That `branch` is `run` before `step`, and another from there on.
fn leaves(what: &str, run: &Path, branch: &Path, step: u64) -> Result<(), LogReadError> {
    let [old, new] = [run, branch].map(|folder| exchanges(&folder.join("log.mcap")));
    let (old, new) = (old?, new?);
    let before = old.iter().take_while(|exchange| exchange.occasion.step < step).count();
    let differs = old.iter().zip(&new).position(|(a, b)| (&a.inputs, &a.outputs) != (&b.inputs, &b.outputs));
    assert!(differs.is_some_and(|place| place >= before), "{what}: {differs:?}, {before}");
    Ok(())
}

#[test]
fn a_branch_with_nothing_changed_is_its_run() -> Result<(), LogReadError> {
    let mut adaptive = without_memory();
    adaptive.push((
        "time.adaptive",
        table(&[("tolerance", 1e-3.into()), ("shortest", 1e-3.into()), ("longest", 0.01.into())]),
    ));
    let mut halved = without_memory();
    halved.extend([
        ("coupling.on_failure", "halve".into()),
        ("coupling.iteration_limit", 12.into()),
        ("coupling.tolerance", 1e-6.into()),
        ("coupling.acceleration", "aitken".into()),
        ("time.communication_step", 0.005.into()),
    ]);
    let windows = vec![("coupling.window", 3.into()), ("coupling.scheme", "parallel-implicit".into())];
    let other: &[&str] = &["--transport", "shared-memory"];
    for (what, settings, transports) in [
        ("equal steps", vec![], [HERE, other].as_slice()),
        ("windows", windows, &[HERE]),
        ("adaptive steps", adaptive, &[HERE]),
        ("halved steps", halved, &[HERE]),
    ] {
        let scenario = coarse(&settings);
        let (parent, status) = run(&scenario, HERE);
        assert_eq!(status, Some(0), "{what}");
        let (last, checkpoints, rejected) = steps(&parent)?;
        assert!(what != "halved steps" || rejected > 0, "{what}");
        let middle = checkpoints[checkpoints.len() / 2];
        let between =
            checkpoints.windows(2).find(|pair| pair[1] > pair[0] + 3).map_or(middle + 2, |pair| pair[0] + 2);
        let mut from = vec![1, 2, between, middle + 1, last];
        for transport in transports {
            for step in &from {
                let (folder, status, said) =
                    branch(&parent, *step, &format!("{step}-{}", transport[1]), transport);
                assert!(status == Some(0) && said.contains("against the run: identical"), "{what}: {said}");
                equal(&format!("{what} from step {step}, {transport:?}"), &parent, &folder)?;
                let head = Log::open(&folder)?.head().clone();
                let window = head.window;
                let first = step - (step - 1) % window;
                assert_eq!(head.parent.map(|parent| parent.step), Some(first - 1), "{what}");
            }
            from = vec![between];
        }
    }
    Ok(())
}

#[test]
fn runs_that_failed_or_were_cut_are_branched() -> Result<(), LogReadError> {
    let scenario = coarse(&without_memory());
    let (whole, _) = run(&scenario, HERE);
    let set = ["--set", "coupling.acceleration=constant", "--set", "coupling.iteration_limit=12"];
    let (failed, status, said) = branch(&whole, 41, "failed", &[HERE, &set].concat());
    assert_eq!(status, Some(3), "{said}");
    let (last, ..) = steps(&failed)?;
    assert!(last >= 41, "{last}");
    for step in std::collections::BTreeSet::from([last, 41]) {
        let (again, status, said) = branch(&failed, step, &format!("again-{step}"), HERE);
        assert_eq!(status, Some(3), "{said}");
        equal("a run that failed", &failed, &again)?;
    }
    assert!(last > 10, "{last}");
    let set = ["--set", "coupling.iteration_limit=50", "--set", "coupling.acceleration=iqn-ils"];
    let (mended, status, said) = branch(&failed, last, "mended", &[HERE, &set].concat());
    assert_eq!(status, Some(0), "{said}");
    assert!(steps(&mended)?.0 > last);

    let bytes = std::fs::read(whole.join("log.mcap")).expect("a log");
    let cut = scenario.folder().join("cut.mcap");
    std::fs::write(&cut, &bytes[..bytes.len() * 6 / 10]).expect("written");
    let (first, status, said) = branch(&cut, 9, "of-cut", HERE);
    assert_eq!(status, Some(0), "{said}");
    equal("a log that was cut", &whole, &first)?;
    Ok(())
}

#[test]
fn what_is_set_otherwise_counts_from_the_step_on() -> Result<(), LogReadError> {
    let scenario = coarse(&[("coupling.tolerance", 1e-6.into())]);
    let (parent, _) = run(&scenario, HERE);
    let fmu = scenario.folder().join("water.fmu");
    let mut export = Command::new(binary());
    export.args(["export-fmu", "--unit", "reservoir", "--output", text(&fmu)]).arg(scenario.write());
    assert!(export.output().expect("cofferdam runs").status.success());
    let fmu = format!("reservoir.fmu={{ file = {fmu:?} }}");
    let step = 41;
    let cases: &[(&str, &[&str], &str)] = &[
        ("acceleration", &["coupling.acceleration=aitken"], ""),
        ("tolerance", &["coupling.tolerance=1e-9"], ""),
        ("scheme", &["coupling.scheme=parallel-implicit"], ""),
        ("predictor", &["coupling.predictor_order=0"], ""),
        ("failures", &["coupling.iteration_limit=2", "coupling.on_failure=continue"], ""),
        (
            "friction",
            &["dam.cracks.0.friction_coefficient=0.3"],
            "dam continues from its state with other cracks",
        ),
        ("damping", &["dam.damping.ratio=0.03"], "dam is a new unit: the requests of 40 steps are repeated"),
        ("water", &["reservoir.fidelity=westergaard"], "reservoir is a new unit"),
        ("an FMU", &["reservoir.fidelity=fmu", &fmu], "reservoir is a new unit"),
        ("shorter steps", &["reservoir.fidelity=westergaard", "time.communication_step=0.00125"], ""),
    ];
    for (what, sets, word) in cases {
        let sets: Vec<&str> =
            sets.iter().flat_map(|set| ["--set", set]).chain(HERE.iter().copied()).collect();
        let (folder, status, said) = branch(&parent, step, what, &sets);
        assert!(status == Some(0) && said.contains(word), "{what}: {said}");
        // The same water as an FMU is the same water.
        match *what {
            "an FMU" => assert!(said.contains("against the run: identical"), "{said}"),
            _ => leaves(what, &parent, &folder, step)?,
        }
        let (_, info) = cofferdam(&["log", "info", text(&folder)]);
        assert!(info.contains("branch of") && info.contains("after step 40"), "{what}: {info}");

        // Stopped and resumed, it is the same.
        let until = [&sets[..], &["--until", "0.15"]].concat();
        let (parts, status, said) = branch(&parent, step, &format!("{what} in parts"), &until);
        assert_eq!(status, Some(0), "{what}: {said}");
        let (status, said) = cofferdam(&[&["resume", text(&parts), "--quiet"], HERE].concat());
        assert_eq!(status, Some(0), "{what}: {said}");
        equal(what, &folder, &parts)?;

        let (status, said) = cofferdam(&["replay", text(&folder), "--quiet"]);
        assert_eq!(status, Some(0), "{what}: {said}");
        for wanted in ["a branch of ", "exchanges of steps 41 to ", "put at the end of step 40 by "] {
            assert!(said.contains(wanted), "{what}: {said}");
        }
        let (status, said) = cofferdam(&["replay", text(&folder), "--quiet", "--step", "55"]);
        assert!(status == Some(0) && said.contains("of step 55"), "{what}: {said}");

        // Nothing changed in it.
        let (again, status, said) = branch(&folder, 60, &format!("{what} again"), HERE);
        assert_eq!(status, Some(0), "{what}: {said}");
        equal(what, &folder, &again)?;
    }
    // Back, and from there to the run's own scheme.
    let back = [HERE, &["--set", "coupling.scheme=serial-implicit"]].concat();
    let (folder, status, said) = branch(&parent.with_file_name("scheme"), 60, "back", &back);
    assert_eq!(status, Some(0), "{said}");
    leaves("back", &parent.with_file_name("scheme"), &folder, 60)?;
    let (_, status, said) = branch(&folder, 50, "before", HERE);
    assert!(status == Some(2) && said.contains("up to step 59 this is the run"), "{said}");
    assert!(said.contains("from step 60 on"), "{said}");
    // What is before in its log are the answers of another dam.
    let friction = parent.with_file_name("friction");
    let (status, said) = cofferdam(&["replay", text(&friction), "--quiet", "-u", "dam", "--from", "0"]);
    assert_eq!(status, Some(5), "{said}");
    Ok(())
}

/// Where nothing slips, the limit of friction enters no bit of the dam's answers; its state must be taken whole for that.
#[test]
fn friction_counts_where_something_slips_alone() -> Result<(), LogReadError> {
    let scenario = coarse(&[("ground_motion.record.scale", 0.05.into())]);
    let (parent, _) = run(&scenario, HERE);
    let friction = |mu: &str| format!("dam.cracks.0.friction_coefficient={mu}");
    for (name, mu, other) in [("as it was", "1.00", false), ("more", "3.0", true)] {
        let (folder, status, said) = branch(&parent, 41, name, &[HERE, &["--set", &friction(mu)]].concat());
        assert!(status == Some(0) && said.contains("with other cracks") == other, "{said}");
        let [a, b] = [&parent, &folder].map(|run| exchanges(&run.join("log.mcap")));
        // The share of the strength in use is that of another strength.
        let layout = Log::open(&parent)?.head().units[0].outputs.clone();
        let share = layout.range("crack_shear_utilisation").expect("a variable").start;
        let values = |run: Result<Vec<cofferdam_log::LoggedExchange>, _>| {
            let run = run?;
            Ok::<Vec<_>, LogReadError>(
                run.into_iter().map(|e| (e.unit.0, e.occasion.step, e.inputs, e.outputs)).collect(),
            )
        };
        let (a, mut b) = (values(a)?, values(b)?);
        assert!(a.len() > 200 && a.len() == b.len(), "{name}");
        let factor = mu.parse::<f64>().expect("a number");
        for ((unit, step, _, old), (_, _, _, new)) in a.iter().zip(&mut b) {
            if let (0, 41.., Some(old), Some(new)) = (unit, step, old, new) {
                assert!(
                    (new[share] * factor - old[share]).abs() <= 1e-12 * old[share],
                    "{name}, step {step}"
                );
                new[share] = old[share];
            }
        }
        assert!(a == b, "{name}");
    }
    let (folder, status, said) = branch(&parent, 41, "less", &[HERE, &["--set", &friction("0.05")]].concat());
    assert_eq!(status, Some(0), "{said}");
    leaves("less", &parent, &folder, 41)
}

#[test]
fn there_is_no_branch_where_it_cannot_begin() {
    let mut settings = without_memory();
    settings.push(("coupling.window", 1.into()));
    let scenario = coarse(&settings);
    let (parent, _) = run(&scenario, HERE);
    let cases: &[(u64, &str, &str)] = &[
        (0, "", "0 is not in 1.."),
        (85, "", "the run ends after step 84; branch from an earlier step"),
        (900, "", "the run ends after step 84"),
        (41, "ground_motion.record.scale=2.0", "the ground motion of a branch is that of the run"),
        (41, "coupling.window=3", "a branch keeps the windows of its run"),
        (41, "coupling.nonsense=1", "`nonsense` is no key of `[coupling]`"),
        (41, "dam.element_size=5.0", "exchanges other variables or at other points"),
        (41, "tailwater.depth=20.0", "a branch has the 2 units of its run"),
        (42, "time.communication_step=0.005", "no communication step of 0.005 s begins at t = 0.1025"),
    ];
    for (number, (step, set, words)) in cases.iter().enumerate() {
        let set: &[&str] = if set.is_empty() { &[] } else { &["--set", set] };
        let (_, status, said) = branch(&parent, *step, &format!("bad-{number}"), &[HERE, set].concat());
        assert!(status == Some(2) && said.contains(words), "{set:?}: {said}");
    }
    let (_, status, said) = branch(&scenario.folder().join("none"), 3, "bad", HERE);
    assert!(status == Some(1) && said.contains("No such file"), "{said}");
}

#[test]
fn the_contacts_of_a_step_are_those_that_the_run_counted() -> Result<(), LogReadError> {
    let scenario = coarse(&[]);
    let (parent, _) = run(&scenario, HERE);
    let log = Log::open(&parent)?;
    let layout = log.head().units[0].outputs.clone();
    let all = exchanges(&parent.join("log.mcap"))?;
    let mut seen = [0.0; 3];
    for step in [0, 1, 30, 41, 57, 70, 84] {
        let number = step.to_string();
        let (status, said) = cofferdam(&["log", "show", text(&parent), "--step", &number, "--contacts"]);
        assert_eq!(status, Some(0), "{said}");
        let dam = all.iter().rfind(|e| e.unit.0 == 0 && e.occasion.step == step && e.accepted);
        let outputs = dam.and_then(|e| e.outputs.as_ref()).expect("an answer");
        let of = |name: &str| outputs[layout.range(name).expect("a variable")][0];
        let counts = ["crack_sticking", "crack_slipping", "crack_open"].map(of);
        let [sticking, slipping, open] = counts;
        assert!(
            said.contains(&format!("crack 0: {sticking} sticking, {slipping} slipping, {open} open")),
            "{said}"
        );
        let ends = |word: &str| said.lines().filter(|line| line.ends_with(word)).count();
        let found = (ends(" closed"), ends("  open"));
        assert_eq!(found, ((sticking + slipping) as usize, open as usize), "step {step}: {said}");
        // The largest opening is in the table.
        let opening = of("crack_opening");
        assert!(opening <= 0.0 || said.contains(&format!("{opening:.4e}")), "{opening:e}: {said}");
        seen.iter_mut().zip(counts).for_each(|(seen, count)| *seen += count);
    }
    assert!(seen.iter().all(|count| *count > 0.0), "{seen:?}");

    let (folder, _, _) =
        branch(&parent, 41, "other", &[HERE, &["--set", "dam.cracks.0.friction_coefficient=0.3"]].concat());
    let intact = coarse(&[("dam.fidelity", "intact".into())]);
    let prescribed = Scenario::shipped("rigid-dam-ramp");
    let [intact_run, rigid] = [&intact, &prescribed].map(|scenario| run(scenario, HERE).0);
    for (run, step, status, words) in [
        (&folder, "41", 0, "crack 0: "),
        (&folder, "40", 0, "crack 0: "),
        (&folder, "39", 2, "steps up to 40 are those of the run"),
        (&parent, "900", 2, "there is no step 900"),
        (&intact_run, "3", 2, "its dam has no cracks"),
        (&rigid, "3", 2, "its dam is prescribed"),
    ] {
        let (found, said) = cofferdam(&["log", "show", text(run), "--step", step, "--contacts"]);
        let said = said.replace('│', " ").split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(found == Some(status) && said.contains(words), "{words}: {said}");
    }
    Ok(())
}

/// Branches of a run that was stopped end where it did: with the ground unmoved, like it.
#[test]
fn branches_of_a_stopped_run_end_at_its_time() {
    let scenario = coarse(&without_memory());
    let (folder, _) = run(&scenario, &[HERE, &["--until", "0.1"]].concat());
    let asked = |when: &str| {
        let (status, said) = cofferdam(&[
            "log",
            "bisect",
            text(&folder),
            "--when",
            when,
            "--amount",
            "0",
            "--branches",
            "2",
            "--checkpoints",
            "3",
        ]);
        assert_eq!(status, Some(0), "{said}");
        said
    };
    let crest = |said: &str| -> f64 {
        let (_, rest) = said.split_once("crest displacement ").expect("the outcome");
        rest.split(':').next().and_then(|number| number.parse().ok()).expect("a number")
    };
    let said = asked("crest-displacement > 0");
    assert!(said.contains("the run ends at t = 0.1000 s"), "{said}");
    // just above and just below
    for factor in [0.999, 1.001] {
        let said = asked(&format!("crest-displacement > {}", factor * crest(&said)));
        assert!(said.matches("2 of 2").count() == 3 && !said.contains("failed"), "{said}");
    }
}
