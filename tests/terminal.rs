//! What the command prints, for people, for programs and for the shell.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use whole_chain::scenario::{Scenario, binary};

fn run(scene: &Path, further: &[&str]) -> Output {
    let mut command = Command::new(binary());
    command.arg("run").arg(scene).args(["--transport", "in-process", "--no-report"]).args(further);
    command.output().expect("cofferdam runs")
}

fn words(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("text")
}

#[test]
fn the_table_and_the_progress_fit_eighty_columns() {
    let scenario = Scenario::quick(0.2);
    let results = scenario.folder().join("results");
    let at = results.to_str().expect("a path").to_owned();
    let done = run(&scenario.write(), &["--output", &at, "--band", "3"]);
    assert!(done.status.success(), "{}", words(&done.stderr));
    let (table, aside) = (words(&done.stdout), words(&done.stderr));
    assert!(
        table.contains("replicates: 16 %")
            && table.contains("\nCrest\n")
            && aside.contains("100 % 0.20/0.20 s")
    );
    for line in table.lines().chain(aside.lines()).filter(|line| !line.contains(&at)) {
        // Pictures of the scene show its lines as they are.
        let drawn = line.contains('│') || line.contains('─') || line.contains("toml");
        assert!(drawn || line.chars().count() <= 80, "{line}");
    }
    let of_plan = Command::new(binary()).arg("plan").arg(scenario.write()).output().expect("cofferdam runs");
    for line in words(&of_plan.stdout).lines() {
        assert!(line.chars().count() <= 80, "{line}");
    }
}

#[test]
fn a_program_gets_one_line_of_json_with_the_numbers_of_the_manifest() {
    let scenario = Scenario::quick(0.2);
    let results = scenario.folder().join("results");
    let at = results.to_str().expect("a path");
    let done = run(&scenario.write(), &["--output", at, "--json"]);
    assert!(done.status.success(), "{}", words(&done.stderr));
    let text = words(&done.stdout);
    assert_eq!(text.lines().count(), 1, "{text}");
    let answer: Value = serde_json::from_str(&text).expect("JSON");
    let manifest: toml::Table =
        std::fs::read_to_string(results.join("manifest.toml")).expect("a manifest").parse().expect("TOML");
    let result = serde_json::to_value(&manifest["result"]).expect("JSON");
    assert_eq!(answer["status"], result["status"]);
    let quantities = result["quantities"].as_array().expect("quantities");
    assert_eq!(answer["quantities"].as_array().map(Vec::len), Some(quantities.len()));
    for quantity in quantities {
        // All digits, as text: a reader may round.
        let stands = format!(
            "{{\"name\":{},\"subject\":{},\"value\":{},",
            quantity["name"], quantity["subject"], quantity["value"]
        );
        assert!(text.contains(&stands), "{stands} in {text}");
    }
    assert_eq!(answer["folder"], at);
    let names: Vec<&str> =
        answer["key_figures"].as_array().expect("figures").iter().flat_map(|f| f["name"].as_str()).collect();
    assert_eq!(names.len(), 5, "{names:?}");
    assert!(answer["wall_time"]["dam"].as_f64() <= answer["wall_time"]["total"].as_f64());
    assert!(
        answer["model"]["damping model of the dam"].as_str().is_some_and(|words| words.contains("Rayleigh"))
    );
    // What people read goes to standard error.
    assert!(words(&done.stderr).contains("peak base shear"), "{}", words(&done.stderr));

    let done =
        Command::new(binary()).arg("resume").arg(&results).arg("--json").output().expect("cofferdam runs");
    let answer: Value = serde_json::from_slice(&done.stdout).expect("JSON");
    assert_eq!(answer["status"], "nothing to do: the run completed");
}

#[test]
fn a_program_is_told_why_there_are_no_numbers() {
    let mut scenario = Scenario::quick(0.2);
    let done = run(&scenario.write(), &["--json", "--set", "dam.element_size=-1"]);
    let answer: Value = serde_json::from_slice(&done.stdout).expect("JSON");
    assert_eq!((answer["exit_status"].as_i64(), done.status.code()), (Some(2), Some(2)));
    assert!(answer["status"].as_str().is_some_and(|status| status.starts_with("failed: ")), "{answer}");
    // A step that does not converge: the numbers up to it, said once.
    scenario.set("coupling.iteration_limit", 2).set("coupling.acceleration", "constant");
    scenario.set("coupling.tolerance", 1e-12);
    let results = scenario.folder().join("results");
    let done = run(&scenario.write(), &["--json", "--output", results.to_str().expect("a path")]);
    assert_eq!((done.status.code(), words(&done.stdout).lines().count()), (Some(3), 1));
    let answer: Value = serde_json::from_slice(&done.stdout).expect("JSON");
    assert!(answer["status"].as_str().is_some_and(|status| status.contains("converge")), "{answer}");
    assert!(answer["quantities"].is_array(), "{answer}");
}

/// Names of the commands that `cofferdam --help` lists.
fn commands() -> Vec<String> {
    let help = words(&Command::new(binary()).arg("--help").output().expect("cofferdam runs").stdout);
    let listed =
        help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let first = |line: &str| line.strip_prefix("  ").filter(|rest| !rest.starts_with(' ')).map(str::to_owned);
    let names = listed.filter_map(first).filter_map(|line| line.split(' ').next().map(str::to_owned));
    names.filter(|name| name != "help").collect()
}

#[test]
fn completions_and_manual_know_every_command() {
    let commands = commands();
    assert!(commands.len() > 15 && commands.iter().any(|command| command == "export-fmu"), "{commands:?}");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let done = Command::new(binary()).args(["completions", shell]).output().expect("cofferdam runs");
        let script = words(&done.stdout);
        for command in &commands {
            assert!(done.status.success() && script.contains(command), "{shell}: {command}");
        }
        if shell == "bash" {
            let mut bash = Command::new("bash").arg("-n").stdin(Stdio::piped()).spawn().expect("bash");
            std::io::Write::write_all(&mut bash.stdin.take().expect("piped"), script.as_bytes())
                .expect("read");
            assert!(bash.wait().expect("it ends").success());
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let done = Command::new(binary()).arg("man").arg(folder.path()).output().expect("cofferdam runs");
    assert!(done.status.success(), "{}", words(&done.stderr));
    for command in &commands {
        let page = folder.path().join(format!("cofferdam-{command}.1"));
        let text =
            std::fs::read_to_string(&page).unwrap_or_else(|error| panic!("{}: {error}", page.display()));
        assert!(text.contains(".TH") && text.contains(".SH DESCRIPTION"), "{command}");
    }
    assert!(!folder.path().join("cofferdam-unit.1").exists(), "what `run` starts by itself is no command");
    let file = folder.path().join("cofferdam.1");
    let done = Command::new(binary()).arg("man").arg(&file).output().expect("cofferdam runs");
    let said = words(&done.stderr);
    assert!(done.status.code() == Some(1) && said.contains("choose another folder"), "{said}");
}
