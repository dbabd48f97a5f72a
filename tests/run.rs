//! The program on short scenes: files, messages, exit status.

use cofferdam_assembly::{Assembly, Equilibrium, UpliftEffect, read_scene};
use cofferdam_coupling::observer::Status;
use std::process::Stdio;
use std::time::Duration;
use whole_chain::scenario::{Histories, Scenario, binary};

/// The strong part of the main scene on a coarse mesh.
fn short_scene() -> Scenario {
    let mut scenario = Scenario::shipped("koyna-coarse");
    scenario.set("dam.element_size", 10.0).set("ground_motion.record.start", 4.0);
    scenario.set("ground_motion.record.end", 5.0).set("time.quiet", 0.5);
    scenario
}

/// The same, coarser and shorter, for tests that compare several runs.
fn shorter_scene() -> Scenario {
    let mut scenario = short_scene();
    scenario.set("dam.element_size", 15.0).set("reservoir.element_size", 15.0);
    scenario.set("ground_motion.record.start", 4.4).set("time.quiet", 0.0);
    scenario
}

#[test]
fn results_name_the_defaults_that_have_moved_since_the_scene_was_written() {
    let mut scenario = shorter_scene();
    let said = |scenario: &Scenario, folder: &str| {
        let output = scenario.try_run(folder);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    assert!(!said(&scenario, "today").contains("has moved"));
    let old = said(scenario.set("scene_version", 1), "old");
    assert!(
        old.contains("the default of `coupling.acceleration` has moved: \"aitken\" before version 2"),
        "{old}"
    );
    let given = said(scenario.set("coupling.acceleration", "aitken"), "given");
    assert!(
        !given.contains("`coupling.acceleration` has moved")
            && given.contains("`coupling.measures` has moved"),
        "{given}"
    );
}

/// Table and manifest give the error and the loss of a recursion.
#[test]
fn a_run_says_how_good_its_recursion_is() {
    let mut scenario = shorter_scene();
    let output = scenario.set("reservoir.method", "recursive").try_run("run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8_lossy(&output.stdout);
    let manifest = std::fs::read_to_string(scenario.folder().join("run/manifest.toml")).expect("a manifest");
    let manifest: toml::Table = manifest.parse().expect("TOML");
    let quantities = manifest["result"]["quantities"].as_array().expect("quantities");
    for name in ["error of the water's recursion", "loss of the water's recursion over rho c"] {
        assert!(said.contains(name), "`{name}` is missing in:\n{said}");
        let value = quantities.iter().find(|q| q["name"].as_str() == Some(name)).map(|q| &q["value"]);
        assert!(value.and_then(toml::Value::as_float).is_some_and(|v| v > 0.0 && v < 1e-2), "{value:?}");
    }
}

#[test]
fn a_run_leaves_log_histories_and_manifest() {
    let scenario = short_scene();
    let output = scenario.try_run("run");
    let (said, complaint) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{complaint}");
    let wanted = [
        "natural frequency 1 (intact, empty)",
        "natural frequency 4 (intact, empty)",
        "natural frequency 1 (intact, full)",
        "natural frequency 4 (intact, full)",
        "peak crest displacement downstream",
        "peak crest displacement upstream",
        "peak sliding",
        "peak rotation of the block above",
        "peak acceleration below the crack",
        "peak acceleration above the crack",
        "largest share of the shear strength in use",
        "peak base shear",
        "largest tension, heel",
        "largest compression, downstream face, 66.5 m",
        "peak crest acceleration",
        "peak hydrodynamic base pressure over hydrostatic",
        "energy balance error",
        "dam steps per communication step, mean",
        "Rayleigh, 5 %",
        "wall time",
    ];
    for quantity in wanted {
        assert!(said.contains(quantity), "`{quantity}` is missing in:\n{said}");
    }
    // Half a second of rest is not enough for a residual.
    assert!(said.contains("no residual sliding: the ground was not at rest"), "{said}");

    let folder = scenario.folder().join("run");
    let manifest: toml::Table =
        std::fs::read_to_string(folder.join("manifest.toml")).expect("a manifest").parse().expect("TOML");
    assert_eq!(
        manifest["scene"]["coupling"]["predictor_order"].as_integer(),
        Some(2),
        "defaults are written"
    );
    assert_eq!(manifest["scene"]["reservoir"]["far_end_distance"].as_float(), Some(91.75 / 2.0));
    assert_eq!(manifest["result"]["status"].as_str(), Some("completed"));
    assert_eq!(manifest["status"].as_str(), Some("completed"));
    assert!(manifest["build"]["commit"].as_str().is_some_and(|c| !c.is_empty()));

    let histories = Histories::read(&folder.join("histories.csv"));
    let time = histories.column("time");
    // 1 s of record, 0.01 s in which it falls to zero, 0.5 s of rest.
    assert_eq!(time.len(), 605);
    assert_eq!(time[604], 1.51);
    let quantities = manifest["result"]["quantities"].as_array().expect("quantities");
    let value = |name: &str| {
        let quantity = quantities.iter().find(|q| q["name"].as_str() == Some(name));
        quantity.and_then(|q| q["value"].as_float()).expect("a quantity")
    };
    for mode in 1..=4 {
        let [empty, full] =
            ["empty", "full"].map(|water| format!("natural frequency {mode} (intact, {water})"));
        assert!(value(&full) < value(&empty), "water lowers the frequency of mode {mode}");
    }
    let reported = value("peak crest displacement downstream");
    let largest = histories.column("dam.crest_displacement.x").iter().copied().fold(f64::MIN, f64::max);
    assert_eq!(reported, 1e3 * largest);
    assert!(std::fs::metadata(folder.join("log.mcap")).expect("a log").len() > 100_000);

    // A manifest, its folder and its scene by itself can be run again and give the same bits.
    let scene = scenario.folder().join("scene-of-the-manifest.toml");
    std::fs::write(&scene, toml::to_string(&manifest["scene"]).expect("TOML")).expect("written");
    let read =
        |run: &str| std::fs::read(scenario.folder().join(run).join("histories.csv")).expect("histories");
    for (run, again) in
        [("of-scene", scene), ("of-manifest", folder.join("manifest.toml")), ("of-folder", folder)]
    {
        let mut command = std::process::Command::new(whole_chain::scenario::binary());
        command.arg("run").arg(&again).args(["--quiet", "--threads", "1", "--output"]);
        let output = command.arg(scenario.folder().join(run)).output().expect("cofferdam runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(read("run") == read(run), "the histories differ: {run}");
    }
}

#[test]
fn energy_is_balanced_in_a_short_run() {
    let histories = short_scene().run();
    let error = whole_chain::peak(histories.column("dam.energy_balance_error"));
    let kinetic = whole_chain::peak(histories.column("dam.kinetic_energy"));
    println!("energy balance error over peak kinetic energy: {:.2e}", error / kinetic);
    assert!(kinetic > 0.0 && error <= 0.01 * kinetic, "{error} of {kinetic}");
}

#[test]
fn an_interrupted_run_says_so_and_stays_readable() {
    let mut scenario = Scenario::shipped("koyna-coarse");
    scenario.set("dam.element_size", 10.0);
    let mut child =
        scenario.command("run").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("a child");
    let histories = scenario.folder().join("run/histories.csv");
    // One second after the first row the run still continues.
    while std::fs::metadata(&histories).map_or(0, |m| m.len()) < 10_000 {
        assert!(child.try_wait().expect("a child").is_none(), "the run ended by itself");
        std::thread::sleep(Duration::from_millis(20));
    }
    let manifest = scenario.folder().join("run/manifest.toml");
    let meanwhile = std::fs::read_to_string(&manifest).expect("a manifest");
    assert!(meanwhile.contains("\nstatus = \"running\"\n"), "{meanwhile}");
    let signal = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(signal.expect("kill").success());
    let output = child.wait_with_output().expect("an ending");
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(said.contains("PARTIAL RESULT up to t =") && said.contains(", run interrupted"), "{said}");
    let manifest: toml::Table = std::fs::read_to_string(manifest).expect("a manifest").parse().expect("TOML");
    assert_eq!(manifest["status"].as_str(), Some(&*Status::Interrupted.to_string()));
    let rows = Histories::read(&histories).column("time").len();
    assert!(rows > 10 && rows < 9000, "{rows} rows");
}

#[test]
fn a_value_that_cannot_be_set_is_refused() {
    let scenario = short_scene();
    let output =
        scenario.command("run").args(["--set", "dam.cracks.4.elevation=3"]).output().expect("cofferdam runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("dam.cracks.4.elevation=3"), "{said}");
}

#[test]
fn a_step_that_does_not_converge_ends_the_run_with_status_3() {
    let scenario = short_scene();
    let mut command = scenario.command("run");
    for setting in
        ["tolerance=1e-13", "iteration_limit=2", "acceleration=constant", "measures=['displacement']"]
    {
        command.args(["--set", &format!("coupling.{setting}")]);
    }
    let output = command.output().expect("cofferdam runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("step 1 at t = 0 s did not converge in 2 iterations"), "{said}");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("PARTIAL RESULT up to t =") && said.contains(", run failed"), "{said}");
    let manifest = std::fs::read_to_string(scenario.folder().join("run/manifest.toml")).expect("a manifest");
    let manifest: toml::Table = manifest.parse().expect("TOML");
    let status = manifest["result"]["status"].as_str().unwrap_or("");
    assert!(status.starts_with("failed: step 1"), "{status}");
    assert_eq!(manifest["units"].as_array().map(Vec::len), Some(2));
}

/// What `check` says of the disk holds within a factor of two, iterated or not.
#[test]
fn the_disk_that_a_run_needs_is_known_before() {
    let mut scenario = short_scene();
    scenario.set("time.duration", 4.0).set("reservoir.fidelity", "westergaard");
    for scheme in ["added-mass", "serial-implicit"] {
        scenario.set("coupling.scheme", scheme);
        let scene = scenario.write();
        let check = std::process::Command::new(binary()).arg("check").arg(scene).output().expect("it runs");
        let said = String::from_utf8_lossy(&check.stdout).into_owned();
        let estimate = said.split(" MB of disk").next().and_then(|text| text.split(' ').next_back());
        let estimate: f64 = estimate.and_then(|number| number.parse().ok()).expect(&said);
        let output = scenario.try_run(scheme);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let files = std::fs::read_dir(scenario.folder().join(scheme)).expect("results").flatten();
        let used: u64 = files.map(|file| file.metadata().map_or(0, |metadata| metadata.len())).sum();
        let used = used as f64 / 1e6;
        println!("{scheme}: {used:.1} MB used, {estimate} MB estimated");
        assert!(used < 2.0 * estimate && estimate < 2.0 * used, "{used:.1} MB used, {estimate} MB estimated");
    }
}

/// Runs a scene a second time.
fn run_into(scenario: &Scenario, output: &str) -> whole_chain::scenario::Histories {
    let run = scenario.try_run(output);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    whole_chain::scenario::Histories::read(&scenario.folder().join(output).join("histories.csv"))
}

fn iterations(histories: &whole_chain::scenario::Histories) -> f64 {
    let counts = &histories.column("iterations")[1..];
    counts.iter().sum::<f64>() / counts.len() as f64
}

/// Largest difference over the largest value.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let largest = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert_eq!(a.len(), b.len());
    largest / whole_chain::peak(b)
}

#[test]
fn water_without_memory_needs_no_iteration_and_is_nearly_the_same_iterated() {
    for fidelity in ["westergaard", "incompressible"] {
        let mut scenario = shorter_scene();
        scenario.set("reservoir.fidelity", fidelity);
        let in_the_mass = scenario.run();
        scenario.set("coupling.scheme", "serial-implicit");
        let iterated = run_into(&scenario, "iterated");
        let crest = ["dam.crest_displacement.x", "reservoir.total_force"]
            .map(|name| apart(in_the_mass.column(name), iterated.column(name)));
        println!(
            "{fidelity}: {:.2} dam steps per communication step, iterated {:.2}; crest {:.1e} apart, force of the water {:.1e}",
            iterations(&in_the_mass),
            iterations(&iterated),
            crest[0],
            crest[1]
        );
        assert_eq!(iterations(&in_the_mass), 1.0);
        // Besides the linear interpolation of pressure they differ by the symmetrisation of the added mass, on 15 m.
        assert!(crest.iter().all(|apart| *apart < 0.08), "{crest:?}");
    }
}

#[test]
fn all_schemes_give_nearly_the_same_and_the_explicit_ones_say_what_they_leave() {
    let tight = || {
        let mut scenario = shorter_scene();
        scenario.set("coupling.tolerance", 1e-6);
        scenario
    };
    let reference = tight().run();
    let crest = reference.column("dam.crest_displacement.x");
    for (settings, tolerance) in [
        (&[("coupling.scheme", "parallel-implicit")][..], 1e-5),
        (&[("coupling.acceleration", "iqn-ils"), ("coupling.scheme", "parallel-implicit")], 1e-5),
        // One extrapolation of second or first order per step, without correction.
        (&[("coupling.scheme", "serial-explicit")], 0.05),
        (&[("coupling.scheme", "parallel-explicit"), ("coupling.predictor_order", "1")], 0.1),
    ] {
        let mut scenario = tight();
        for (key, value) in settings {
            match value.parse::<i64>() {
                Ok(number) => scenario.set(key, number),
                Err(_) => scenario.set(key, *value),
            };
        }
        let histories = scenario.run();
        let error = apart(histories.column("dam.crest_displacement.x"), crest);
        let residual = whole_chain::peak(histories.column("residual.pressure"));
        println!(
            "{settings:?}: {:.2} iterations, crest {error:.1e}, residual {residual:.1e} Pa",
            iterations(&histories)
        );
        assert!(error < tolerance, "{settings:?}: {error}");
        assert!(residual > 0.0);
    }
}

#[test]
fn a_reservoir_with_panels_of_its_own_gives_nearly_the_same() {
    let reference = shorter_scene().run();
    // The dam's own panels are 15 m long: pressure is as coarse on either side as that.
    for (size, tolerance) in [(7.0, 0.06), (23.0, 0.06)] {
        let mut scenario = shorter_scene();
        scenario.set("reservoir.interface_size", size);
        let histories = scenario.run();
        let error =
            apart(histories.column("dam.crest_displacement.x"), reference.column("dam.crest_displacement.x"));
        println!("panels of {size} m on the reservoir's side: crest {error:.1e} apart");
        assert!(error < tolerance, "{error}");
        let manifest =
            std::fs::read_to_string(scenario.folder().join("run/manifest.toml")).expect("a manifest");
        let manifest: toml::Table = manifest.parse().expect("TOML");
        let points = manifest["reservoir_wet_face"].as_array().map_or(0, Vec::len);
        assert!(points > 2 && Some(points) != manifest["wet_face"].as_array().map(Vec::len));
        let quantities = manifest["result"]["quantities"].as_array().expect("a list");
        let named = |q: &&toml::Value| {
            q["name"].as_str().is_some_and(|name| name.starts_with("work error of the mapping"))
        };
        let work =
            quantities.iter().find(named).and_then(|q| q["value"].as_float()).expect("the mapping's error");
        assert!(work < 1e-12, "{work}");
    }
}

#[test]
fn a_reader_that_goes_away_does_not_end_the_run() {
    let scenario = Scenario::shipped("rigid-dam-ramp");
    let mut child = scenario.command("run").stdout(Stdio::piped()).spawn().expect("a child");
    drop(child.stdout.take());
    assert!(child.wait().expect("an ending").success());
    let manifest = std::fs::read_to_string(scenario.folder().join("run/manifest.toml")).expect("a manifest");
    assert!(manifest.contains("completed"));
}

#[test]
fn a_residual_needs_five_seconds_of_rest() {
    let mut scenario = short_scene();
    scenario.set("ground_motion.record.end", 4.2).set("time.quiet", 5.0).set("dam.element_size", 20.0);
    let said = String::from_utf8_lossy(&scenario.try_run("run").stdout).into_owned();
    assert!(said.contains("\n  residual sliding") && !said.contains("no residual"), "{said}");
    scenario.set("time.quiet", 4.99);
    let said = String::from_utf8_lossy(&scenario.try_run("less").stdout).into_owned();
    assert!(said.contains("peak sliding") && said.contains("no residual sliding"), "{said}");
}

/// A run that waits for rest ends with it, and one in vain says so at the latest moment.
#[test]
fn a_run_waits_for_rest() {
    let mut scenario = short_scene();
    scenario.set("ground_motion.record.end", 4.2).set("time.quiet", 0.0).set("dam.element_size", 20.0);
    scenario.set("time.longest_quiet", 20.0).set("reservoir.fidelity", "westergaard");
    let ended = |scenario: &Scenario, folder: &str| {
        let output = scenario.try_run(folder);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let manifest = std::fs::read_to_string(scenario.folder().join(folder).join("manifest.toml"));
        let manifest: toml::Table = manifest.expect("a manifest").parse().expect("TOML");
        assert_eq!(manifest["result"]["status"].as_str(), Some("completed"));
        let time = manifest["result"]["simulated_time"].as_float().expect("a time");
        let said = String::from_utf8_lossy(&output.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
        (said, time)
    };
    let (said, time) = ended(&scenario, "rest");
    assert!(said.contains("because the dam is at rest"), "{said}");
    assert!(
        said.contains(" residual sliding ") && !said.contains("no residual") && (5.2..6.0).contains(&time),
        "{time}: {said}"
    );
    scenario.set("dam.damping.ratio", 0.0).set("time.longest_quiet", 5.5);
    let (said, time) = ended(&scenario, "no-rest");
    assert!(
        said.contains("not at rest at the end") && said.contains("increase `time.longest_quiet`"),
        "{said}"
    );
    assert!((time - 5.71).abs() < 0.02, "{time}");
}

#[test]
fn several_cracks_are_named_by_their_elevations() {
    let mut scenario = short_scene();
    let crack = |elevation: f64, friction: f64| {
        let mut crack = toml::Table::new();
        crack.insert("elevation".to_owned(), elevation.into());
        crack.insert("friction_coefficient".to_owned(), friction.into());
        crack.insert("normal_stiffness".to_owned(), 1e11.into());
        crack.insert("shear_stiffness".to_owned(), 0.5e11.into());
        toml::Value::Table(crack)
    };
    // Given from above downwards, with a friction at which only the upper one slides.
    scenario.set("dam.cracks", vec![crack(66.5, 0.7), crack(40.0, 5.0)]);
    let output = scenario.try_run("run");
    let warned = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{warned}");
    assert!(warned.contains("`dam.cracks.1.friction_coefficient` is 5"), "the number in the file: {warned}");
    let histories = Histories::read(&scenario.folder().join("run/histories.csv"));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    for (column, elevation) in [("dam.crack_sliding.0", "40"), ("dam.crack_sliding.1", "66.5")] {
        let line = said
            .lines()
            .find(|l| l.trim().starts_with(&format!("peak sliding, {elevation} m")))
            .expect("a line");
        let value: f64 = line.split_whitespace().nth(4).and_then(|v| v.parse().ok()).expect("a number");
        let peak = 1e3 * whole_chain::peak(histories.column(column));
        assert!((value.abs() / peak - 1.0).abs() < 1e-3, "{line} against {peak}");
    }
}

#[test]
fn help_teaches() {
    let help = std::process::Command::new(whole_chain::scenario::binary()).args(["run", "--help"]).output();
    let help = String::from_utf8_lossy(&help.expect("help").stdout).into_owned();
    for word in [
        "log.mcap",
        "histories.csv",
        "manifest.toml",
        "Exit status",
        "scenes/koyna-northridge-1994",
        "Ctrl-C",
    ] {
        assert!(help.contains(word), "`{word}` is missing in:\n{help}");
    }
}

/// Every level of fidelity and kind of damping, through both processes: crest and sliding of the reduced dam are the
/// full one's, and the level and the damping are named.
#[test]
fn levels_of_the_dam_and_kinds_of_damping() {
    let mut scenario = short_scene();
    let full = scenario.run();
    let largest = |values: &[f64]| values.iter().fold(0.0f64, |most, value| most.max(value.abs()));
    let differences = |run: &Histories, name: &str| {
        let pairs = run.column(name).iter().zip(full.column(name));
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest(full.column(name))
    };
    assert!(scenario.set("dam.fidelity", "reduced").try_run("reduced").status.success());
    let reduced = Histories::read(&scenario.folder().join("reduced/histories.csv"));
    let [crest, sliding] =
        ["dam.crest_displacement.x", "dam.crack_sliding.0"].map(|name| differences(&reduced, name));
    println!("reduced, through the whole chain: crest {crest:.1e}, sliding {sliding:.1e} of their largest");
    assert!(crest < 0.02 && sliding < 0.05);
    for (level, named) in [("intact", "intact"), ("rigid-blocks", "rigid blocks: unsafe")] {
        let output = scenario.set("dam.fidelity", level).try_run(level);
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && said.contains(named), "{said}");
    }
    scenario.set("dam.fidelity", "dem");
    for (model, named) in [
        ("mass", "mass-proportional, 5 % at"),
        ("stiffness", "stiffness-proportional, 5 % at"),
        ("local", "local, 5 %"),
    ] {
        let output = scenario.set("dam.damping.model", model).try_run(model);
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && said.contains(named), "{said}");
    }
}

/// A limit ends the run in the step that exceeds it, or marks it; the results show it in both cases.
#[test]
fn limits_end_or_flag_a_run() {
    let limit = |action: &str| {
        let entry = [("quantity", "sliding".into()), ("above", 1e-3.into()), ("action", action.into())];
        let entry = entry.map(|(key, value): (&str, toml::Value)| (key.to_owned(), value));
        toml::Value::Array(vec![toml::Value::Table(entry.into_iter().collect())])
    };
    let mut scenario = short_scene();
    let whole = scenario.run();
    let sliding = whole.column("dam.crack_sliding.0");
    let passed = sliding.iter().position(|sliding| sliding.abs() > 1e-3).expect("it slides by a millimetre");
    for action in ["end", "flag"] {
        let output = scenario.set("stop", limit(action)).try_run(action);
        let folder = scenario.folder().join(action);
        let rows = Histories::read(&folder.join("histories.csv")).column("time").len();
        let manifest = std::fs::read_to_string(folder.join("manifest.toml")).expect("a manifest");
        let manifest: toml::Table = manifest.parse().expect("TOML");
        let status = manifest["result"]["status"].as_str().unwrap_or_default();
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && said.contains("WARNING: sliding"), "{said}");
        match action {
            "end" => {
                assert!(rows == passed + 1 && status.starts_with("stopped: sliding"), "{rows}, {status}")
            }
            _ => assert!(rows == sliding.len() && status == "completed", "{rows}, {status}"),
        }
    }
}

/// The numbers of a field in a VTK file.
fn field(path: &std::path::Path, name: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(path).expect("a picture");
    let (_, after) = text.split_once(&format!("Name=\"{name}\"")).expect("the field");
    let (numbers, _) = after.split_once("</DataArray>").expect("its end");
    let (_, numbers) = numbers.split_once('>').expect("its numbers");
    numbers.split_whitespace().map(|number| number.parse().expect("a number")).collect()
}

/// (c ℓ + μ (N − U))/V of every crack under water, by hand; where the uplift is more than what presses, only cohesion is left.
#[test]
fn factors_of_safety_know_the_uplift_that_no_run_models() {
    let factors = |case: &str, sets: &[(&str, f64)]| {
        let mut scenario = Scenario::shipped(case);
        for (key, value) in sets {
            scenario.set(key, *value);
        }
        let loaded = read_scene(&scenario.write(), &[]).expect("a scene");
        let found = Assembly::of(&loaded.scene).equilibria().expect("factors");
        let effect = |(_, found): &(usize, Equilibrium)| (found.sliding, found.with_uplift.expect("uplift"));
        found.iter().map(effect).collect::<Vec<_>>()
    };
    // The neck: 19.25 m wide at 66.5 m, 36.5 m high.
    let by_hand = |density: f64, depth: f64, cohesion: f64| {
        let below = depth - 66.5;
        let weight = 36.5 * (19.25 + 14.8) / 2.0 * density * 9.81;
        let [thrust, uplift] = [below, 19.25].map(|length| 0.5 * 9810.0 * below * length);
        let factor = |pressing: f64| (cohesion * 19.25 + pressing) / thrust;
        let left = (weight - uplift).max(0.0);
        [factor(weight), factor(left)]
    };
    let neck = |case: &str, crack: usize, sets: &[(&str, f64)], by_hand: [f64; 2]| {
        let (sliding, UpliftEffect { sliding: with_uplift }) = factors(case, sets)[crack];
        println!("{case}: {sliding:.3}, {with_uplift:.3} with uplift");
        for (found, exact) in [sliding, with_uplift].into_iter().zip(by_hand) {
            assert!((found - exact).abs() < 0.01, "{case}: {found}, {exact}");
        }
    };
    neck("koyna-coarse", 0, &[], by_hand(2640.0, 91.75, 0.0));
    // Above another crack under water.
    neck("koyna-two-cracks", 1, &[], by_hand(2640.0, 91.75, 0.0));
    let bond = [("dam.cracks.0.cohesion", 1e6), ("dam.cracks.0.tensile_strength", 1e6)];
    let light = [&bond[..], &[("dam.material.density", 500.0), ("reservoir.depth", 100.0)]].concat();
    neck("koyna-coarse", 0, &light, by_hand(500.0, 100.0, 1e6));
}

#[test]
fn snapshots_show_what_the_histories_say_and_change_nothing() {
    let mut scenario = shorter_scene();
    assert!(scenario.try_run("without").status.success());
    scenario.set("snapshots", toml::toml! { interval = 0.1 from = 0.2 until = 0.4 });
    let output = scenario.try_run("with");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |run: &str, file: &str| {
        std::fs::read_to_string(scenario.folder().join(run).join(file)).expect("the histories")
    };
    for file in ["histories.csv", "reservoir-interface_pressure.csv"] {
        assert!(read("with", file) == read("without", file), "{file} differs");
    }
    let folder = scenario.folder().join("with");
    let histories = Histories::read(&folder.join("histories.csv"));
    let face = Histories::read(&folder.join("reservoir-interface_pressure.csv"));
    let series = read("with", "snapshots.pvd");
    let times: Vec<f64> =
        series.split("timestep=\"").skip(1).filter_map(|rest| rest.split('"').next()?.parse().ok()).collect();
    assert_eq!(times, [[0.2; 4], [0.3; 4], [0.4; 4]].concat(), "four parts each");
    for (picture, number) in (2..5).enumerate() {
        let time = times[4 * picture];
        let row = histories.column("time").partition_point(|t| *t < time - 1e-9);
        let part = |name: &str| folder.join(format!("snapshots/{name}-{number:06}.vtu"));
        let (points, moved) = (field(&part("dam"), "points"), field(&part("dam"), "displacement [m]"));
        let crest = (0..points.len() / 3)
            .max_by(|&a, &b| {
                (points[3 * a + 1] - points[3 * a]).total_cmp(&(points[3 * b + 1] - points[3 * b]))
            })
            .unwrap_or(0);
        assert_eq!(points[3 * crest..][..2], [0.0, 103.0]);
        for (d, axis) in ["x", "y"].into_iter().enumerate() {
            let column = histories.column(&format!("dam.crest_displacement.{axis}"));
            assert_eq!(moved[3 * crest + d], column[row], "crest, {axis}");
        }
        let opening = field(&part("contacts"), "opening [m]").into_iter().fold(0.0, f64::max);
        assert_eq!(opening, histories.column("dam.crack_opening.0")[row]);
        let pressure = field(&part("wet_face"), "hydrodynamic_pressure [Pa]");
        let base = face.column("point 0")[row];
        assert_eq!(pressure[0], base, "what the reservoir answered");
        assert_eq!(field(&part("dam"), "stress_yy [Pa]").len(), field(&part("dam"), "types").len());
    }
}

/// In the files of the envelopes stand the extremes of the histories, whatever the transport.
#[test]
fn envelopes_hold_the_extremes_of_the_histories() {
    let mut scenario = shorter_scene();
    scenario.set("dam.material.tensile_strength", 1e6);
    let run = |scenario: &Scenario, name: &str, transport: &str| {
        let done = scenario.command(name).args(["--transport", transport]).output().expect("cofferdam runs");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        scenario.folder().join(name)
    };
    let [here, there] = [run(&scenario, "here", "in-process"), run(&scenario, "there", "shared-memory")];
    for file in ["envelopes.vtm", "envelopes-dam.vtu", "envelopes-cracks.vtu"] {
        let [one, other] = [&here, &there].map(|folder| std::fs::read(folder.join(file)).expect("envelopes"));
        assert!(one == other, "{file} differs");
    }
    let histories = Histories::read(&here.join("histories.csv"));
    let largest = |name: &str| histories.column(name).iter().copied().fold(f64::MIN, f64::max);
    let (dam, cracks) = (here.join("envelopes-dam.vtu"), here.join("envelopes-cracks.vtu"));
    let most = |file: &std::path::Path, name: &str| field(file, name).into_iter().fold(f64::MIN, f64::max);
    assert_eq!(most(&dam, "major_principal_stress_max [Pa]"), largest("dam.largest_principal_stress"));
    assert_eq!(most(&cracks, "opening_max [m]"), largest("dam.crack_opening.0"));
    let points = field(&dam, "points");
    let crest = points.chunks(3).position(|point| point == [0.0, 103.0, 0.0]).expect("the crest");
    let moved = field(&dam, "displacement_x_max [m]")[crest];
    assert!((moved - largest("dam.crest_displacement.x")).abs() < 1e-12, "{moved}");
    // The summary says what the file does.
    let manifest = std::fs::read_to_string(here.join("manifest.toml")).expect("a manifest");
    let manifest: toml::Table = manifest.parse().expect("TOML");
    let quantities = manifest["result"]["quantities"].as_array().expect("quantities");
    let value = |name: &str| {
        let quantity = quantities.iter().find(|q| q["name"].as_str() == Some(name));
        quantity.and_then(|q| q["value"].as_float()).unwrap_or_else(|| panic!("no {name}"))
    };
    let ratio = value("largest demand-capacity ratio");
    assert_eq!(ratio, most(&dam, "demand_capacity_ratio_max [1]"));
    assert!((ratio - largest("dam.largest_principal_stress") / 1e6).abs() < 1e-12 * ratio);
    assert_eq!(value("longest time above the tensile strength"), most(&dam, "overstress_duration [s]"));
    let share = value("overstressed share of the section");
    assert!(share > 0.0 && share < 100.0 && ratio > 1.0, "{share} %, {ratio}");
    assert!((value("overstressed area of the section") / (0.01 * share) / 3588.975 - 1.0).abs() < 1e-9);

    scenario.set("dam.envelopes", false);
    let none = run(&scenario, "none", "in-process");
    assert!(!none.join("envelopes.vtm").exists());
    assert!(std::fs::read(none.join("histories.csv")).ok() == std::fs::read(here.join("histories.csv")).ok());
}

#[test]
fn response_spectra_begin_at_the_peaks_of_the_motion() {
    let scenario = shorter_scene();
    assert!(scenario.try_run("run").status.success());
    let folder = scenario.folder().join("run");
    let histories = Histories::read(&folder.join("histories.csv"));
    let spectra = Histories::read(&folder.join("response_spectra.csv"));
    assert_eq!(spectra.column("period").len(), 161);
    let peak = |column: &[f64]| column.iter().fold(0.0f64, |most, a| most.max(a.abs()));
    let ground = peak(histories.column("ground_acceleration.x"));
    let shortest = spectra.column("ground")[0];
    assert!((shortest / ground - 1.0).abs() < 0.2, "{shortest} m/s², ground {ground} m/s²");
    assert!(peak(spectra.column("crest")) > peak(histories.column("dam.crest_acceleration.x")));
    assert!(
        std::fs::read_to_string(folder.join("response_spectra.svg")).expect("a picture").contains("crest")
    );
}

/// Heel and toe are two places, not two directions.
#[test]
fn a_section_without_bends_has_stresses_at_heel_and_toe() {
    let mut scenario = shorter_scene();
    let downstream: toml::Value = vec![vec![70.0, 0.0], vec![14.8, 103.0]].into();
    scenario.set("dam.section.downstream", downstream);
    let output = scenario.try_run("run");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for place in ["tension, heel", "compression, toe", "tension in the dam", "compression in the dam"] {
        assert!(said.contains(&format!("largest {place}")), "{place} is missing in:\n{said}");
    }
    assert!(!said.contains("downstream face"), "{said}");
    // The largest is no less than those at the points, and it says where it is.
    let histories = Histories::read(&scenario.folder().join("run/histories.csv"));
    let column = |name: &str| histories.column(&format!("dam.{name}"));
    let rows = column("largest_principal_stress").iter().zip(column("major_principal_stress.0"));
    assert!(rows.clone().all(|(largest, heel)| largest >= heel) && rows.len() > 1);
    let mut from = said.lines().skip_while(|line| !line.contains("largest compression in the dam"));
    assert!(from.nth(1).is_some_and(|below| below.contains(" m, y = ")), "{said}");
}
