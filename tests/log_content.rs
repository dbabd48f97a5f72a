//! Logs that leave something out.

use std::process::{Command, Output};
use whole_chain::scenario::{Scenario, binary};

fn cofferdam(arguments: &[&str]) -> Output {
    Command::new(binary()).args(arguments).output().expect("cofferdam runs")
}

fn said(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    text.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

/// The results do not depend on what is logged. What is left out is said, and asked for in vain.
#[test]
fn what_is_left_out_is_said_and_missed_nowhere_else() {
    let scenario = Scenario::quick(0.5);
    let at = |name: &str| scenario.folder().join(name).to_string_lossy().into_owned();
    for which in ["every", "accepted", "none"] {
        let mut command = scenario.command(which);
        let output = command.args(["--transport", "in-process", "--log", which]).output().expect("it runs");
        assert!(output.status.success(), "{}", said(&output));
        let manifest = std::fs::read_to_string(scenario.folder().join(which).join("manifest.toml"));
        assert!(manifest.expect("a manifest").contains(&format!("exchanges = \"{which}\"")));
    }
    let read =
        |name: &str, file: &str| std::fs::read(scenario.folder().join(name).join(file)).expect("a file");
    let [every, accepted, none] = ["every", "accepted", "none"].map(|name| {
        assert!(read(name, "histories.csv") == read("every", "histories.csv"), "{name}");
        read(name, "log.mcap").len()
    });
    println!("{every}, {accepted}, {none} bytes");
    assert!(accepted < every * 2 / 3 && none < accepted / 3);
    let info = |name: &str| said(&cofferdam(&["log", "info", &at(name)]));
    assert!(!info("every").contains("left out"));
    assert!(
        info("accepted").contains("left out unaccepted exchanges of accepted steps"),
        "{}",
        info("accepted")
    );
    let left_out = info("none");
    assert!(left_out.contains("left out all exchanges, steps and iterations"), "{left_out}");
    assert!(left_out.contains("ended completed"), "{left_out}");

    // Accepted exchanges are enough for a replay, and for the tables of the run.
    let replayed = cofferdam(&["replay", &at("accepted"), "--quiet"]);
    assert!(replayed.status.success(), "{}", said(&replayed));
    let exported = cofferdam(&["log", "export", &at("accepted"), "--output", &at("tables")]);
    assert!(exported.status.success(), "{}", said(&exported));
    let rows = |bytes: &[u8]| bytes.iter().filter(|byte| **byte == b'\n').count();
    assert_eq!(rows(&read("tables", "histories.csv")), rows(&read("every", "histories.csv")));

    let asked = [
        vec!["replay"],
        vec!["log", "diff", "BOTH"],
        vec!["log", "show", "--step", "3"],
        vec!["log", "worst"],
        vec!["log", "plot", "dam.crest_displacement"],
        vec!["log", "export", "--output", "tables-of-none"],
        vec!["branch", "--step", "3"],
    ];
    for mut arguments in asked {
        let run = at("none");
        let twice = arguments.last() == Some(&"BOTH");
        arguments.retain(|argument| *argument != "BOTH");
        let place = if arguments[0] == "log" { 2 } else { 1 };
        arguments.insert(place, &run);
        if twice {
            arguments.push(&run);
        }
        let output = cofferdam(&arguments);
        let words = said(&output);
        assert!(!output.status.success(), "{arguments:?}: {words}");
        assert!(
            words.contains("holds no exchanges") && words.contains("log.exchanges = \"none\""),
            "{arguments:?}: {words}"
        );
    }
}

/// A run of which only accepted exchanges, or none, are logged continues where it was, or starts again, and ends with the same bits.
#[test]
fn runs_with_less_in_their_logs_are_resumed() {
    let mut scenario = Scenario::quick(0.5);
    for which in ["accepted", "none"] {
        let log: toml::Table =
            format!("exchanges = '{which}'\ncheckpoint_share = 0.5").parse().expect("TOML");
        scenario.set("log", log);
        let run = |name: &str, more: &[&str]| {
            let mut command = scenario.command(&format!("{name}-{which}"));
            let output = command.args(["--transport", "in-process"]).args(more).output().expect("it runs");
            assert!(output.status.success(), "{}", said(&output));
        };
        run("whole", &[]);
        run("part", &["--until", "0.3"]);
        let part = scenario.folder().join(format!("part-{which}"));
        let resumed = cofferdam(&["resume", "--transport", "in-process", part.to_str().expect("a path")]);
        assert!(resumed.status.success(), "{}", said(&resumed));
        let goes_on = said(&resumed).contains("continues after step");
        assert_eq!(goes_on, which == "accepted", "{}", said(&resumed));
        let whole = scenario.folder().join(format!("whole-{which}"));
        let of = |folder: &std::path::Path| std::fs::read(folder.join("histories.csv")).expect("histories");
        assert!(of(&part) == of(&whole), "{which}");
    }
}

/// A step that ends a run is there whole, to be looked into; of those before, what the run went on with.
#[test]
fn a_step_that_fails_is_logged_whole() {
    let mut scenario = Scenario::shipped("koyna-coarse");
    scenario.set("dam.element_size", 10.0).set("reservoir.method", "recursive");
    scenario.set("coupling.acceleration", "constant").set("coupling.relaxation", 1.0);
    scenario.set("coupling.iteration_limit", 4).set("coupling.tolerance", 1e-6);
    let at = |name: &str| scenario.folder().join(name).to_string_lossy().into_owned();
    let [every, accepted] = ["every", "accepted"].map(|which| {
        let output = scenario.command(which).args(["--log", which]).output().expect("it runs");
        assert_eq!(output.status.code(), Some(3), "{}", said(&output));
        let tables = format!("tables-{which}");
        let done = cofferdam(&["log", "export", &at(which), "--iterations", "--output", &at(&tables)]);
        assert!(done.status.success(), "{}", said(&done));
        let rows = std::fs::read_to_string(scenario.folder().join(tables).join("dam-exchanges.csv"));
        let rows = rows.expect("a table");
        rows.lines()
            .skip(1)
            .map(|row| row.split(',').take(2).map(str::to_owned).collect())
            .collect::<Vec<Vec<_>>>()
    });
    let last = every.last().expect("exchanges")[0].clone();
    let of = |rows: &[Vec<String>], step: &str| {
        rows.iter().filter(|row| row[0] == step).cloned().collect::<Vec<_>>()
    };
    assert!(of(&every, &last).len() >= 4 && of(&every, &last) == of(&accepted, &last), "step {last}");
    assert!(of(&every, "100").len() > 1 && of(&accepted, "100").len() == 1);
    let shown = said(&cofferdam(&["log", "show", &at("accepted"), "--step", &last]));
    assert!(shown.contains("not accepted, iteration 4") && shown.contains("iteration 4 guess"), "{shown}");
    let replayed = cofferdam(&["replay", &at("accepted"), "--quiet"]);
    assert!(replayed.status.success(), "{}", said(&replayed));
}
