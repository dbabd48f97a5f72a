//! Times of runs, in turns with another build.

use std::path::Path;
use std::process::{Command, Output};
use whole_chain::scenario::{Scenario, binary, lab};

fn bench(scenario: &Scenario, further: &[&str]) -> Output {
    let mut command = Command::new(lab());
    command.arg("bench").arg(scenario.write()).args(["-n", "1"]).args(further);
    command.output().expect("cofferdam runs")
}

/// A build beside itself: every time of both runs is there, and the parts are no longer than the whole.
#[test]
fn two_builds_take_turns() {
    let mut scenario = Scenario::shipped("koyna-coarse");
    scenario.set("dam.element_size", 10.0).set("time.duration", 0.2);
    let program = binary();
    let program = program.to_str().expect("a path");
    let done = bench(&scenario, &["--against", program, "--", "--transport", "in-process"]);
    let text = String::from_utf8_lossy(&done.stdout);
    assert!(done.status.success(), "{text}{}", String::from_utf8_lossy(&done.stderr));
    let rows: Vec<Vec<&str>> = text
        .lines()
        .filter(|line| line.starts_with("| ") && line.contains("scene.toml"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    let time = |run: &str, what: &str, column: usize| -> f64 {
        let row = rows.iter().find(|row| row[1] == run && row[2] == what);
        row.unwrap_or_else(|| panic!("no {what} of {run} in {text}"))[column].parse().expect("a number")
    };
    for run in ["first", "again"] {
        for column in [3, 4, 5, 6] {
            let parts = time(run, "preparing", column) + time(run, "dam", column);
            // Each is rounded to a hundredth.
            assert!(parts <= time(run, "whole process", column) + 0.02, "{text}");
        }
        assert!(time(run, "whole process", 7) > 0.0);
    }
}

#[test]
fn what_cannot_be_timed_is_named() {
    let mut scenario = Scenario::quick(0.1);
    let nowhere = Path::new("no/such/program").to_str().expect("a path");
    for (further, status, word) in [
        (&["--against", nowhere][..], 1, nowhere),
        (&["--against", "true", "--its", "a", "--its", "b"], 2, "1 scenes, but 2 for the other build"),
        (&["--", "--set", "dam.element_size=-1"], 1, "dam.element_size"),
    ] {
        let done = bench(&scenario, further);
        let said = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.code() == Some(status) && said.contains(word), "{further:?}: {said}");
    }
    scenario.set("coupling.iteration_limit", 2).set("coupling.acceleration", "constant");
    scenario.set("coupling.tolerance", 1e-12);
    let done = bench(&scenario, &[]);
    assert_eq!(done.status.code(), Some(1), "{}", String::from_utf8_lossy(&done.stderr));
}
