//! `cofferdam range`: what the command writes and refuses, and what the report of a run takes from it.

use std::path::Path;
use std::process::{Command, Output};
use whole_chain::scenario::{Scenario, binary, root};

/// A tenth of a second of the coarse main scene, whose crack slips at once.
fn short_scene() -> Scenario {
    let mut scenario = Scenario::quick(0.1);
    scenario.set("ground_motion.record.start", 4.4).set("dam.cracks.0.friction_coefficient", 0.4);
    scenario.write();
    scenario
}

fn range(scene: &Path, output: &Path, options: &[&str]) -> Output {
    let mut command = Command::new(binary());
    command.arg("range").arg(scene).arg("--output").arg(output).args(options);
    command.output().expect("cofferdam runs")
}

fn said(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    text.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

#[test]
fn the_report_of_a_run_has_the_range_of_its_scene() {
    let scenario = short_scene();
    let folder = scenario.folder().join("range");
    let done = range(scenario.folder(), &folder, &["--samples", "8", "--replicates", "2"]);
    assert!(done.status.success(), "{}", said(&done));
    // What is left out is said, and the table is printed.
    assert!(
        said(&done).contains("left out: wave reflection coefficient: there is no compressible water"),
        "{}",
        said(&done)
    );
    for text in ["| peak crest displacement, mm |", "**Factors**", "- record: not covered"] {
        assert!(String::from_utf8_lossy(&done.stdout).contains(text), "{text}: {}", said(&done));
    }
    for file in [
        "range.md",
        "range.csv",
        "range.toml",
        "range-peak-crest-displacement.svg",
        "range-residual-sliding.svg",
    ] {
        assert!(folder.join(file).is_file(), "{file}");
    }
    let run = scenario.command("run").args(["--transport", "in-process"]).output().expect("cofferdam runs");
    assert!(run.status.success(), "{}", said(&run));
    let report = |range: &Path| {
        let mut command = Command::new(binary());
        command.arg("report").arg(scenario.folder().join("run")).arg("--range").arg(range);
        command.output().expect("cofferdam runs")
    };
    let written = report(&folder);
    assert!(written.status.success(), "{}", said(&written));
    let page = std::fs::read_to_string(scenario.folder().join("run/report.html")).expect("a page");
    let record: toml::Table =
        std::fs::read_to_string(folder.join("range.toml")).expect("a record").parse().expect("TOML");
    let crest = record["quantities"].as_array().expect("quantities").iter();
    let crest = crest.map(|quantity| quantity.as_table().expect("a table"));
    let crest =
        crest.into_iter().find(|quantity| quantity["name"].as_str() == Some("peak crest displacement"));
    assert_eq!(crest.expect("the crest")["combined"]["runs"].as_integer(), Some(8));
    assert!(
        page.contains("5 to 95 % of 8 runs")
            && page.contains("ranges of key figures: 8 runs in which all factors vary")
    );
    // The range of another scene is refused, with the keys that differ.
    let other = scenario.folder().join("other");
    let options = ["--one-at-a-time", "--replicates", "2", "--set", "dam.cracks.0.friction_coefficient=0.45"];
    assert!(range(scenario.folder(), &other, &options).status.success());
    let refused = report(&other);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        said(&refused).contains("differs from that of the run in dam.cracks.0.friction_coefficient"),
        "{}",
        said(&refused)
    );
    // No range at all.
    let none = report(scenario.folder());
    assert!(none.status.code() == Some(2) && said(&none).contains("range.toml"), "{}", said(&none));
}

#[test]
fn wrong_requests_are_refused_before_any_run() {
    let scenario = short_scene();
    let refused = |scene: &Path, output: &str, options: &[&str], status: i32, text: &str| {
        let output = scenario.folder().join(output);
        let done = range(scene, &output, options);
        assert_eq!(done.status.code(), Some(status), "{}", said(&done));
        assert!(said(&done).contains(text), "{text}: {}", said(&done));
        assert!(!output.join("range.md").exists());
    };
    let scene = scenario.folder();
    refused(scene, "a", &["--samples", "0"], 2, "0 is not in 8..=10000");
    refused(scene, "b", &["--samples", "8", "--one-at-a-time"], 2, "cannot be used with");
    refused(scene, "c", &["--record", "nowhere.csv"], 2, "--record");
    refused(scene, "d", &["--set", "dam.damping.ratio=2"], 2, "dam.damping.ratio");
    refused(&root().join("scenes/rigid-dam-ramp"), "e", &[], 2, "[prescribed]");
    std::fs::create_dir(scenario.folder().join("taken")).expect("a folder");
    std::fs::write(scenario.folder().join("taken/file"), "").expect("a file");
    refused(scene, "taken", &[], 1, "is not empty");
}
