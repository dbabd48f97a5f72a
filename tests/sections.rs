//! Shipped scenes whose sections and cracks are not those of the main one.

use std::process::Command;
use toml::Value;
use whole_chain::peak;
use whole_chain::scenario::{Histories, Scenario, binary, root};

/// Every scene can be run, as `check` says of each.
#[test]
fn every_shipped_scene_is_checked() {
    let folders = std::fs::read_dir(root().join("scenes")).expect("scenes");
    let scenes: Vec<_> = folders
        .map(|entry| entry.expect("an entry").path())
        .filter(|p| p.join("scene.toml").exists())
        .collect();
    assert!(scenes.len() >= 9, "{scenes:?}");
    let table = std::fs::read_to_string(root().join("scenes/README.md")).expect("a file");
    for scene in &scenes {
        let name = scene.file_name().expect("a name").to_string_lossy();
        assert!(scene.join("README.md").exists(), "{name} has no README.md");
        assert!(table.contains(&format!("| `{name}` |")), "{name} is not in scenes/README.md");
    }
    let done = Command::new(binary()).arg("check").args(&scenes).output().expect("cofferdam runs");
    let said = String::from_utf8_lossy(&done.stdout).into_owned();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    assert_eq!(said.matches(" can be run: ").count(), scenes.len(), "{said}");
    for crack in
        ["the crack at 66.5 m", "the crack \"base joint\"", "the crack \"neck\"", "the crack \"third joint\""]
    {
        assert!(
            said.contains(&format!("factor of safety of {crack} before the ground moves")),
            "{crack}: {said}"
        );
    }
}

/// Runs 1.5 s of the strongest shaking of a shipped scene on a coarse mesh; checks energy, crest and the `labels` of its cracks,
/// from the base up, and returns the histories.
fn shaken(case: &str, start: f64, element_size: f64, labels: &[&str]) -> Histories {
    let mut scenario = Scenario::shipped(case);
    scenario.set("ground_motion.record.start", start).set("time.duration", 1.5);
    scenario.set("dam.element_size", element_size);
    if case != "stacked-blocks" {
        scenario.set("reservoir.fidelity", "westergaard");
    }
    let done = scenario.try_run("run");
    let said = String::from_utf8_lossy(&done.stdout).into_owned();
    assert!(done.status.success(), "{case}: {}", String::from_utf8_lossy(&done.stderr));
    let histories = Histories::read(&scenario.folder().join("run/histories.csv"));
    let crest = histories.column("dam.crest_displacement.x");
    assert!(
        crest.iter().all(|u| u.is_finite()) && (1e-3..1.0).contains(&peak(crest)),
        "{case}: {}",
        peak(crest)
    );
    let error =
        peak(histories.column("dam.energy_balance_error")) / peak(histories.column("dam.kinetic_energy"));
    println!("{case}: crest {:.1} mm, energy balance error {:.3} %", 1e3 * peak(crest), 100.0 * error);
    assert!(error < 0.01, "{case}: {error}");
    let lines: Vec<&str> =
        said.lines().map(str::trim).filter(|line| line.starts_with("peak sliding")).collect();
    assert_eq!(lines.len(), labels.len(), "{said}");
    for (index, (line, label)) in lines.iter().zip(labels).enumerate() {
        let value = line
            .strip_prefix(&format!("peak sliding, {label} "))
            .unwrap_or_else(|| panic!("{label}: {line}"));
        let value: f64 = value.split_whitespace().next().expect("a value").parse().expect("a number");
        let column = 1e3 * peak(histories.column(&format!("dam.crack_sliding.{index}")));
        assert!((value.abs() - column).abs() <= 1e-3 * column, "{line} against {column}");
    }
    histories
}

#[test]
fn a_dam_on_a_joint_to_the_ground_slides_on_it() {
    let histories = shaken("koyna-base-joint", 4.5, 10.0, &["base joint"]);
    assert!(peak(histories.column("dam.crack_sliding.0")) > 1e-3);
}

#[test]
fn two_cracks_are_named_from_the_base_up() {
    shaken("koyna-two-cracks", 4.5, 10.0, &["lift joint", "neck"]);
}

/// Down the slope a block slides further than up it: the scene's direction is the adverse one.
#[test]
fn a_sloping_joint_slides_further_downhill() {
    let falling = shaken("lift-joint-sloping", 4.5, 7.5, &["lift joint"]);
    let mut scenario = Scenario::shipped("lift-joint-sloping");
    scenario.set("ground_motion.record.start", 4.5).set("time.duration", 1.5);
    scenario.set("dam.element_size", 7.5).set("reservoir.fidelity", "westergaard");
    let points = [[0.0, 57.0], [30.0, 60.0]].map(|point| Value::Array(point.map(Value::Float).to_vec()));
    scenario.set("dam.cracks.0.polyline", Value::Array(points.to_vec()));
    let rising = scenario.run();
    let [falling, rising] =
        [&falling, &rising].map(|h| *h.column("dam.crack_sliding.0").last().expect("a value"));
    println!("falling {:.1} mm, rising {:.1} mm", 1e3 * falling, 1e3 * rising);
    assert!(falling > rising + 1e-3);
}

#[test]
fn pine_flat_is_intact() {
    shaken("pine-flat-taft", 3.0, 10.0, &[]);
}

#[test]
fn a_stack_of_blocks_rocks_at_every_joint() {
    let labels = ["joint to the ground", "first joint", "second joint", "third joint"];
    let histories = shaken("stacked-blocks", 4.5, 2.0, &labels);
    for joint in 0..4 {
        assert!(peak(histories.column(&format!("dam.crack_opening.{joint}"))) > 1e-5, "{joint} stays closed");
    }
}

#[test]
fn a_crack_that_ends_inside_the_concrete_is_refused() {
    let mut scenario = Scenario::shipped("lift-joint-sloping");
    let points = [[0.0, 60.0], [15.0, 58.5]].map(|point| Value::Array(point.map(Value::Float).to_vec()));
    scenario.set("dam.cracks.0.polyline", Value::Array(points.to_vec()));
    for command in ["check", "run"] {
        let done =
            Command::new(binary()).arg(command).arg(scenario.write()).output().expect("cofferdam runs");
        let said = String::from_utf8_lossy(&done.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(done.status.code(), Some(2), "{said}");
        for part in ["ends inside the concrete at", "(15", "lead it to", "polyline"] {
            assert!(said.contains(part), "`{part}` is missing: {said}");
        }
    }
}
