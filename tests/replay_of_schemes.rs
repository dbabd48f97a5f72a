//! Logs of runs whose steps are iterated together, repeated, taken at once, or accepted without convergence: they are
//! replayed bit for bit and show the course of the run.

use cofferdam_log::{Entry, Log, LoggedStep};
use std::path::{Path, PathBuf};
use std::process::Command;
use whole_chain::scenario::{Scenario, binary};

fn short_scene() -> Scenario {
    let mut scenario = Scenario::shipped("koyna-coarse");
    scenario.set("dam.element_size", 15.0).set("reservoir.element_size", 12.0);
    scenario.set("ground_motion.record.start", 5.0).set("ground_motion.record.end", 5.4);
    scenario.set("time.quiet", 0.0);
    scenario
}

fn said(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(binary()).args(arguments).output().expect("cofferdam runs");
    (output.status.code(), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
}

/// Runs the scene, replays its log, and returns its path.
fn replayed(scenario: &Scenario) -> PathBuf {
    let run = scenario.try_run("run");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let log = scenario.folder().join("run/log.mcap");
    let (status, text) = said(&["replay", log.to_str().expect("a path")]);
    assert_eq!(status, Some(0), "{text}");
    assert!(text.contains("identical"), "{text}");
    log
}

fn steps(log: &Path) -> Vec<LoggedStep> {
    let entries = Log::open(log).expect("a log").entries().expect("entries");
    let step = |entry| match entry {
        Ok(Entry::Step(step)) => Some(step),
        _ => None,
    };
    entries.filter_map(step).collect()
}

#[test]
fn windows_and_parallel_schemes_are_replayed() {
    for (window, scheme, acceleration) in [
        (5, "serial-implicit", "iqn-ils"),
        (3, "serial-implicit", "interface-jacobian"),
        (3, "parallel-implicit", "iqn-ils"),
        (1, "parallel-implicit", "interface-jacobian"),
        (1, "serial-explicit", "iqn-ils"),
        (1, "parallel-explicit", "iqn-ils"),
    ] {
        let mut scenario = short_scene();
        scenario.set("coupling.window", window).set("coupling.scheme", scheme);
        scenario.set("coupling.acceleration", acceleration).set("coupling.predictor_order", 1);
        let steps = steps(&replayed(&scenario));
        assert_eq!(steps.len(), 165, "initialisation and 164 steps");
        assert!(steps.iter().all(|s| s.accepted && s.converged));
    }
}

#[test]
fn steps_that_vary_are_replayed_and_the_worst_are_listed() {
    for (key, value) in [("reservoir.method", "recursive"), ("reservoir.fidelity", "incompressible")] {
        steps_vary(short_scene().set(key, value));
    }
}

fn steps_vary(scenario: &mut Scenario) {
    let adaptive: toml::Table = "tolerance = 3e-3\nshortest = 1e-4\nlongest = 0.01".parse().expect("TOML");
    scenario.set("coupling.scheme", "serial-implicit").set("time.adaptive", adaptive);
    let log = replayed(scenario);
    let steps = steps(&log);
    let taken = steps.iter().filter(|s| s.accepted).count();
    let lengths: Vec<f64> = steps.iter().skip(1).map(|s| s.occasion.communication_step).collect();
    let [least, most] = [f64::min, f64::max].map(|of| lengths.iter().copied().reduce(of).expect("steps"));
    println!("{taken} steps of {least:.1e} to {most:.1e} s, {} started again", steps.len() - taken);
    assert!(most > 2.0 * least && steps.len() > taken, "{least} {most}");
    let (status, text) = said(&["log", "worst", log.to_str().expect("a path"), "--count", "3"]);
    assert_eq!(status, Some(0), "{text}");
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines.len() == 5 && lines[0].contains("iterations"), "{text}");
    assert!(lines[4].contains("cofferdam log show"), "{text}");
    let iterations = |line: &str| line.split_whitespace().nth(4).and_then(|n| n.parse::<u32>().ok());
    let most = steps.iter().map(|s| s.occasion.iteration).max();
    assert_eq!(iterations(lines[1]), most, "{text}");
    assert!(iterations(lines[1]) >= iterations(lines[2]) && iterations(lines[2]) >= iterations(lines[3]));
}

#[test]
fn steps_gone_on_with_and_steps_halved_are_flagged_everywhere() {
    let mut scenario = short_scene();
    scenario.set("coupling.acceleration", "constant").set("coupling.iteration_limit", 4);
    scenario.set("coupling.on_failure", "continue").set("coupling.tolerance", 1e-6);
    let log = replayed(&scenario);
    let logged = steps(&log);
    let unconverged = logged.iter().filter(|s| !s.converged).count();
    assert!(unconverged > 10 && logged.iter().all(|s| s.accepted), "{unconverged}");
    let manifest = std::fs::read_to_string(scenario.folder().join("run/manifest.toml")).expect("a manifest");
    assert!(
        manifest.contains(&format!("WARNING: {unconverged} communication steps did not converge")),
        "{manifest}"
    );
    let histories = whole_chain::scenario::Histories::read(&scenario.folder().join("run/histories.csv"));
    assert_eq!(histories.column("converged").iter().filter(|c| **c == 0.0).count(), unconverged);
    let (_, text) = said(&["log", "info", log.to_str().expect("a path")]);
    assert!(text.contains(&format!("{unconverged} of them NOT CONVERGED")), "{text}");
    let (_, text) = said(&["log", "worst", log.to_str().expect("a path"), "-c", "1"]);
    assert!(text.contains("NOT CONVERGED, accepted"), "{text}");

    // The Gauss–Seidel iteration diverges in incompressible water; halving does not help, and the message says so.
    scenario.set("reservoir.fidelity", "incompressible").set("coupling.scheme", "serial-implicit");
    scenario.set("coupling.on_failure", "halve");
    let run = scenario.try_run("halved");
    let text = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(3), "{text}");
    let log = scenario.folder().join("halved/log.mcap");
    let attempts: Vec<u32> = steps(&log).iter().skip(1).map(|s| s.occasion.attempt).collect();
    assert_eq!(attempts, (1..=11).collect::<Vec<u32>>());
    let (status, text) = said(&["replay", log.to_str().expect("a path")]);
    assert_eq!(status, Some(0), "{text}");
}
