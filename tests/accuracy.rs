//! `cofferdam plan` and `run --accuracy`: what is said before a run, what is chosen, and how the promise ends.

use std::os::unix::process::ExitStatusExt;
use std::process::{Command, Output, Stdio};
use std::time::Duration;
use whole_chain::scenario::{Scenario, binary, lab, root};

/// A second of strong motion of a shipped scene.
fn strong(case: &str) -> Scenario {
    let mut scenario = Scenario::shipped(case);
    scenario.set("ground_motion.record.start", 4.5).set("ground_motion.record.end", 5.3);
    scenario.set("time.quiet", 0.0);
    scenario
}

fn run(scenario: &Scenario, accuracy: &str) -> (Output, String) {
    let mut command = scenario.command("run");
    command.args(["--accuracy", accuracy, "--log", "none", "--transport", "in-process", "--no-report"]);
    let output = command.output().expect("cofferdam runs");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    (output, said)
}

fn manifest(scenario: &Scenario) -> toml::Table {
    let text = std::fs::read_to_string(scenario.folder().join("run/manifest.toml")).expect("a manifest");
    text.parse().expect("TOML")
}

#[test]
fn a_plan_has_each_criterion_with_its_number_on_narrow_lines() {
    let mut command = Command::new(binary());
    let output =
        command.arg("plan").arg(root().join("scenes/koyna-coarse")).output().expect("cofferdam runs");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // πc/2h = 3.1416 · 1440 / 183.5 = 24.65; an echo takes 2h/c = 0.1274 s, and 0.9ⁿ = 1 % after 43.7 of them.
    let numbers = [
        "24.7 rad/s",
        "0.127 s per reflection",
        "1 % in 5.6 s",
        "sliding 5.15",
        "2.38 MN/m",
        "numerical error of sliding",
    ];
    let unfolded = said.split_whitespace().collect::<Vec<_>>().join(" ");
    for number in numbers {
        assert!(unfolded.contains(number), "`{number}` is missing in:\n{said}");
    }
    assert!(said.lines().all(|line| line.chars().count() <= 80), "{said}");
}

#[test]
fn an_intact_dam_keeps_what_is_asked_with_coarser_elements_the_less_is_asked() {
    let scenario = strong("koyna-intact");
    let (output, said) = run(&scenario, "10%");
    assert_eq!(output.status.code(), Some(0), "{said}{}", String::from_utf8_lossy(&output.stderr));
    let manifest = manifest(&scenario);
    let accuracy = manifest["accuracy"].as_table().expect("a table");
    assert_eq!(accuracy["verdict"].as_str(), Some("kept"), "{accuracy:?}");
    let share = |table: &str, quantity: &str| accuracy[table][quantity].as_float().expect("a share");
    for quantity in ["crest", "history"] {
        assert_eq!(share("asked", quantity), 0.1);
        assert!(share("expected", quantity) > 1e-4 && share("expected", quantity) <= 0.1);
    }
    assert!(manifest["plan"].as_array().is_some_and(|rows| rows.len() > 6), "{manifest:?}");
    // What was chosen is what ran, and nothing physical was changed.
    let dam = &manifest["scene"]["dam"];
    let size = dam["element_size"].as_float().expect("a length");
    assert!((2.0..=5.0).contains(&size) && dam["fidelity"].as_str() == Some("intact"), "{dam:?}");
    assert_eq!(dam["damping"]["ratio"].as_float(), Some(0.05));
}

#[test]
fn a_sliding_block_has_no_answer_to_a_thousandth_and_gets_a_band() {
    let scenario = strong("koyna-coarse");
    let (output, said) = run(&scenario, "sliding=0.1%");
    assert_eq!(output.status.code(), Some(7), "{said}{}", String::from_utf8_lossy(&output.stderr));
    let manifest = manifest(&scenario);
    let accuracy = &manifest["accuracy"];
    assert_eq!(accuracy["verdict"].as_str(), Some("cannot be kept"), "{accuracy:?}");
    assert!(
        accuracy["sensitivity"]["sliding"].as_float().is_some_and(|change| change > 1e-3),
        "{accuracy:?}"
    );
    let band = accuracy["band"]["sliding"].as_array().expect("a band");
    let band: Vec<f64> = band.iter().filter_map(toml::Value::as_float).collect();
    assert!(band.len() == 3 && band[0] < band[1] && band[1] < band[2], "{band:?}");
    assert!(said.contains("quote this band"), "{said}");
    // The two coarsest elements; the finest as they are, by other modes, with 1 % more and less of shaking, and half of that.
    assert_eq!(accuracy["pilot_runs"].as_integer(), Some(2 + 4 + 2), "{accuracy:?}");
}

#[test]
fn an_accuracy_that_cannot_be_meant_is_refused_before_anything_is_computed() {
    for (case, accuracy, wanted) in [
        ("koyna-intact", "5", "write 5%"),
        ("koyna-intact", "drift=5%", "no quantity `drift`"),
        ("rigid-dam-ramp", "5%", "the dam is prescribed"),
        ("koyna-gmsh", "5%", "the mesh is that of a file"),
    ] {
        let scenario = Scenario::shipped(case);
        if case == "koyna-gmsh" {
            let mesh = root().join("scenes").join(case).join("koyna.msh");
            std::fs::copy(mesh, scenario.folder().join("koyna.msh")).expect("a copy");
        }
        let (output, _) = run(&scenario, accuracy);
        let complaint =
            String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(2), "{complaint}");
        assert!(complaint.contains(wanted), "{complaint}");
    }
}

/// The tables that `cofferdam-lab accuracy --coarse` writes for a part of the record of a shipped scene, with further settings: the knob's rows,
/// the levels in all cases, and the table of levels.
fn study(
    case: &str,
    [start, end]: [f64; 2],
    settings: &[&str],
) -> ([Vec<csv::StringRecord>; 2], toml::value::Array) {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("study");
    let mut command = Command::new(lab());
    command.args(["accuracy", "--coarse", "--output"]).arg(&output);
    command.arg(root().join("scenes").join(case));
    command.args(["--set", "time.quiet=0", "--set", &format!("ground_motion.record.start={start}")]);
    for setting in settings {
        command.args(["--set", setting]);
    }
    let done =
        command.args(["--set", &format!("ground_motion.record.end={end}")]).output().expect("cofferdam runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let tables = ["accuracy.csv", "levels.csv"].map(|name| {
        let mut table = csv::Reader::from_path(output.join(name)).expect("a table");
        table.records().map(|row| row.expect("a row")).collect()
    });
    let measured = std::fs::read_to_string(output.join("table.toml")).expect("a table");
    let mut measured: toml::Table = measured.parse().expect("TOML");
    let Some(toml::Value::Array(levels)) = measured.remove("level") else { panic!("no levels") };
    (tables, levels)
}

/// The study runs and finds the knob's error within what was promised.
#[test]
fn the_study_of_accuracy_measures_levels_and_the_knob() {
    let ([rows, _], levels) = study("koyna-intact", [4.5, 5.3], &[]);
    assert_eq!(rows.len(), 2);
    assert!(rows.iter().all(|row| &row[2] == "kept" && &row[6] == "yes" && &row[11] == "0"), "{rows:?}");
    // Both polarities of a linear dam have the same errors: one row a quantity, of two cases without spread.
    assert_eq!(levels.len(), 2, "{levels:?}");
    for level in levels {
        assert_eq!(level["cases"].as_integer(), Some(2));
        assert!(
            level["bias"].as_float().is_some_and(|bias| bias.abs() > 1e-4 && bias.abs() < 0.3),
            "{level:?}"
        );
    }
}

/// With steps that have not converged the study reaches its end, and counts those of the reference.
#[test]
fn the_study_counts_steps_of_the_reference_above_its_tolerance() {
    let settings =
        ["coupling.on_failure=continue", "coupling.acceleration=constant", "coupling.iteration_limit=2"];
    let ([rows, _], _) = study("koyna-intact", [4.5, 4.7], &settings);
    assert_eq!(rows.len(), 2);
    for row in &rows {
        let above: u64 = row[11].parse().expect("a number");
        assert!((1..=80).contains(&above), "{above} of 80");
    }
}

/// A cracked dam has levels of both models; a sliding that 1 % of shaking changes by twice what was asked is not promised, and says
/// nothing of the bias of a level.
#[test]
fn the_study_of_a_cracked_dam_measures_both_models_and_what_shaking_changes() {
    let ([rows, cases], levels) = study("koyna-coarse", [4.5, 5.3], &[]);
    assert_eq!(rows.len(), 2);
    for row in &rows {
        let changed = row[7].rsplit(", ").next().expect("a share").trim_end_matches(" %");
        let changed: f64 = changed.parse().expect("a share");
        assert!(changed > 10.0 && row[1].starts_with('5') && &row[2] == "cannot be kept", "{row:?}");
    }
    for fidelity in ["dem", "reduced"] {
        for quantity in ["crest", "history", "sliding"] {
            let of_it = cases.iter().filter(|case| &case[2] == fidelity && &case[4] == quantity);
            let number = |text: &str| text.parse::<f64>().expect("a number");
            let of_it: Vec<_> = of_it.map(|case| [number(&case[6]), number(&case[7])]).collect();
            let [[one, changed], [other, changed_too]] = of_it[..] else { panic!("two cases: {cases:?}") };
            let of = |level: &&toml::Value| {
                level["fidelity"].as_str() == Some(fidelity) && level["quantity"].as_str() == Some(quantity)
            };
            let level = levels.iter().find(of);
            if quantity == "sliding" {
                assert!(changed > 0.1 && changed_too > 0.1 && level.is_none(), "{of_it:?}, {level:?}");
                continue;
            }
            let level = level.unwrap_or_else(|| panic!("{fidelity} {quantity}: {levels:?}"));
            assert!(changed <= 0.1 && changed_too <= 0.1, "{of_it:?}");
            assert_eq!((level["cases"].as_integer(), level["cracked"].as_bool()), (Some(2), Some(true)));
            // The directions differ, so that no number is that of one of them alone.
            assert!(one != other && one.abs() < 1.0, "{of_it:?}");
            let expected = [(one + other) / 2.0, (one - other).abs() / 2f64.sqrt()];
            for (name, expected) in ["bias", "spread"].into_iter().zip(expected) {
                let found = level[name].as_float().expect("a share");
                assert!((found - expected).abs() < 2e-5, "{name}: {found}, {expected}");
            }
        }
    }
}

/// Its runs take a while: nothing is left of a command that is ended meanwhile.
#[test]
fn a_pilot_that_is_ended_leaves_no_folder() {
    let place = tempfile::tempdir().expect("a folder");
    let output = place.path().join("run");
    let mut command = Command::new(binary());
    command
        .arg("run")
        .arg(root().join("scenes/koyna-coarse"))
        .args(["--accuracy", "5%", "--output"])
        .arg(&output);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut run = command.spawn().expect("it starts");
    std::thread::sleep(Duration::from_millis(400));
    let done = Command::new("kill").args(["-TERM", &run.id().to_string()]).status().expect("a signal");
    assert!(done.success());
    let ended = run.wait().expect("it ends");
    // Ctrl-C's own signal may be ignored, where tests run in the background.
    assert_eq!(ended.signal(), Some(15), "{ended:?}");
    assert!(!output.exists());
}
