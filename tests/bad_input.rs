//! Every mistake in a scene gets an error that names place, value and remedy, before any work.

use orchestrator::scene::LoadedScene;
use std::path::Path;
use whole_chain::scenario::Scenario;

const CRACKED: &str = "koyna-northridge-1994";

/// All problems of a scene: the message, and the text that its place shows.
fn problems(path: &Path) -> Vec<(String, String)> {
    let source = std::fs::read_to_string(path).expect("the scene");
    let error = LoadedScene::read(path, &[]).expect_err("the scene is wrong");
    let place = |p: &orchestrator::scene::SceneProblem| {
        p.span.map_or(String::new(), |s| source[s.offset()..s.offset() + s.len()].to_owned())
    };
    error.problems.iter().map(|p| (p.to_string(), place(p))).collect()
}

/// The scene with one value changed has this one problem at this place.
fn one(case: &str, key: &str, value: impl Into<toml::Value>, message: &str, place: &str) {
    let mut scenario = Scenario::shipped(case);
    scenario.set(key, value);
    let found = problems(&scenario.write());
    assert_eq!(found, [(message.to_owned(), place.to_owned())], "{key}");
}

#[test]
fn values_out_of_range() {
    let alpha = "`reservoir.wave_reflection_coefficient` is 1.5; it must lie from 0 to 1";
    one(CRACKED, "reservoir.wave_reflection_coefficient", 1.5, alpha, "1.5");
    let alpha = "`reservoir.wave_reflection_coefficient` is -0.1; it must lie from 0 to 1";
    one(CRACKED, "reservoir.wave_reflection_coefficient", -0.1, alpha, "-0.1");
    let depth = "`reservoir.depth` is -3; it must be greater than 0 and finite";
    one(CRACKED, "reservoir.depth", -3.0, depth, "-3.0");
    let size = "`dam.element_size` is 0; it must be greater than 0 and finite";
    one(CRACKED, "dam.element_size", 0.0, size, "0.0");
    let size = "`dam.element_size` is -5; it must be greater than 0 and finite";
    one(CRACKED, "dam.element_size", -5.0, size, "-5.0");
    let size = "`reservoir.element_size` is NaN; it must be greater than 0 and finite";
    one(CRACKED, "reservoir.element_size", f64::NAN, size, "nan");
    let friction = "`dam.cracks.0.friction_coefficient` is -0.5; it must lie from 0 to 5";
    one(CRACKED, "dam.cracks.0.friction_coefficient", -0.5, friction, "-0.5");
    let degrees = "`dam.cracks.0.friction_coefficient` is 45; it must lie from 0 to 5";
    one(CRACKED, "dam.cracks.0.friction_coefficient", 45.0, degrees, "45.0");
    let gigapascals = "`dam.material.young_modulus` is 31; it must lie from 1000000 to 10000000000000";
    one(CRACKED, "dam.material.young_modulus", 31.0, gigapascals, "31.0");
    let poisson = "`dam.material.poisson_ratio` is 0.5; it must lie from 0 to 0.499";
    one(CRACKED, "dam.material.poisson_ratio", 0.5, poisson, "0.5");
    let polarity = "`ground_motion.record.polarity` is 2; it must be 1 or -1";
    one(CRACKED, "ground_motion.record.polarity", 2, polarity, "2");
    let tolerance = "`coupling.tolerance` is 0; it must lie from 0.00000000000001 to 0.1";
    one(CRACKED, "coupling.tolerance", 0.0, tolerance, "0.0");
    let limit = "`coupling.iteration_limit` is 1; it must be a whole number from 2 to 100000";
    one(CRACKED, "coupling.iteration_limit", 1, limit, "1");
}

#[test]
fn geometry_that_makes_no_dam() {
    let water = "`reservoir.depth` is 110 m, but the crest is at 103 m; water cannot stand above the crest";
    one(CRACKED, "reservoir.depth", 110.0, water, "110.0");
    let crack =
        "`dam.cracks.0.elevation` is 120 m; a crack must lie inside the section, above 0 and below 103 m";
    one(CRACKED, "dam.cracks.0.elevation", 120.0, crack, "120.0");
    let point = |x: f64, y: f64| toml::Value::from(vec![x, y]);
    let sides = "the sides of `dam.section` are -5 m apart at elevation 103 m; the downstream side must lie to the \
                 right of the upstream side, and both must end at the same elevation";
    let crossing = vec![point(70.0, 0.0), point(-5.0, 103.0)];
    one(CRACKED, "dam.section.downstream", crossing, sides, "[dam.section]");
    let heel = "`dam.section.upstream` begins at (1, 0); it must begin at the heel, the origin (0, 0)";
    let shifted = vec![point(1.0, 0.0), point(1.0, 103.0)];
    let mut scenario = Scenario::shipped(CRACKED);
    scenario.set("dam.section.upstream", shifted);
    assert_eq!(problems(&scenario.write())[0].0, heel);
}

#[test]
fn levels_that_lie_too_close_together() {
    let thin = |upper: f64| {
        format!(
            "vertices, cracks and the water level at 66.5 m and {upper} m are less than 0.5 m apart, a tenth of \
             `dam.element_size`; make them equal, move one, or use smaller elements"
        )
    };
    one(CRACKED, "reservoir.depth", 66.52, &thin(66.52), "66.52");
    one(CRACKED, "dam.cracks.0.elevation", 66.6, &thin(66.6), "66.6");
    let mut scenario = Scenario::shipped(CRACKED);
    scenario.set("reservoir.depth", 66.5);
    assert!(LoadedScene::read(&scenario.write(), &[]).is_ok());
}

#[test]
fn more_than_can_be_computed() {
    let elements =
        "`dam.element_size` leads to 1.436e12 elements of the dam; 1e6 are the most, so change it by as much";
    one(CRACKED, "dam.element_size", 1e-4, elements, "0.0001");
    let boundary = "`reservoir.element_size` leads to 2.294e8 boundary elements of the reservoir; 2e3 are the most, \
                    so change it by as much";
    one(CRACKED, "reservoir.element_size", 1e-6, boundary, "0.000001");
    let steps = "`time.communication_step` leads to 2.499e10 communication steps; 1e6 are the most, so change it by \
                 as much";
    one(CRACKED, "time.communication_step", 1e-9, steps, "0.000000001");
    let stiff = Scenario::shipped(CRACKED);
    let output = stiff.command("run").args(["--set", "dam.cracks.0.normal_stiffness=1e16"]).output();
    let output = output.expect("cofferdam runs");
    assert_eq!(output.status.code(), Some(4));
    let said = flat(&output.stderr);
    assert!(said.contains("time steps") && said.contains("lower the joint stiffness"), "{said}");
}

#[test]
fn a_ground_motion_that_would_be_undersampled() {
    let step = "`time.communication_step` is 0.02 s, longer than the ground motion's interval of 0.01 s, whose peaks \
                it would miss; make it no longer, best a whole fraction of it";
    one(CRACKED, "time.communication_step", 0.02, step, "0.02");
}

#[test]
fn keys_that_are_missing_or_unknown() {
    let mut scenario = Scenario::shipped(CRACKED);
    scenario.set("reservoir.dept", 3.0);
    let found = problems(&scenario.write());
    assert!(found[0].0.starts_with("unknown field `dept`, expected one of `depth`"), "{found:?}");
    assert_eq!(found[0].1, "dept");

    let mut scenario = Scenario::shipped(CRACKED);
    scenario.remove("reservoir.depth");
    let found = problems(&scenario.write());
    assert_eq!(found[0].0, "missing field `depth`");
    assert!(found[0].1.starts_with("[reservoir]"), "{found:?}");

    let mut scenario = Scenario::shipped(CRACKED);
    scenario.remove("dam");
    let both = "exactly one of `[dam]` and `[prescribed]` must be given, 0 are";
    assert_eq!(problems(&scenario.write())[0].0, both);

    let mut scenario = Scenario::shipped(CRACKED);
    scenario.remove("dam.damping.multiples_of_first");
    let frequencies = "exactly one of `multiples_of_first` and `radians_per_second` must be given, 0 are";
    assert_eq!(problems(&scenario.write()), [(frequencies.to_owned(), "[dam.damping]".to_owned())]);

    let mut scenario = Scenario::shipped("rigid-dam-ramp");
    scenario.remove("time.duration");
    assert!(problems(&scenario.write())[0].0.starts_with("`time.duration` is missing"));
}

#[test]
fn several_mistakes_are_reported_together() {
    let mut scenario = Scenario::shipped(CRACKED);
    scenario.set("reservoir.depth", -1.0).set("dam.element_size", 0.0).set("ground_motion.record.scale", 0.0);
    let places: Vec<String> = problems(&scenario.write()).into_iter().map(|p| p.1).collect();
    assert_eq!(places, ["-1.0", "0.0", "0.0"]);
}

#[test]
fn records_that_cannot_be_used() {
    let with = |name: &str, content: Option<&str>| {
        let mut scenario = Scenario::shipped(CRACKED);
        scenario.set("ground_motion.record.file", name);
        if let Some(content) = content {
            std::fs::write(scenario.folder().join(name), content).expect("the record is written");
        }
        let found = problems(&scenario.write());
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].1, format!("\"{name}\""), "the place is the record's key");
        found[0].0.clone().replace(&*scenario.folder().to_string_lossy(), "")
    };
    let found = with("a.csv", Some("time,acc\n0,0.1\n0.01,NaN\n"));
    assert_eq!(found, "/a.csv:3: the value NaN is not finite; repair the record or crop it before this line");
    let found = with("a.csv", Some("0,0.1\n0.01,0\n0.03,0\n"));
    assert!(found.starts_with("/a.csv:3: the sample at 0.03 s comes 0.01"), "{found}");
    assert!(found.ends_with("resample the record to equal intervals"), "{found}");
    let found = with("a.csv", Some("0,0.1\n0,0\n"));
    assert!(found.starts_with("/a.csv:2: the sample at 0 s comes 0 s after the one before"), "{found}");
    let found = with("a.csv", Some("# nothing\ntime,acc\n"));
    assert_eq!(found, "/a.csv: the record has 0 samples, two are the least");
    let found = with("a.csv", Some("0,0.1\n0.01,0\n0.02 0\n"));
    assert_eq!(found, "/a.csv:3: `0.02 0` is not `time,acceleration`, two numbers");
    let found = with("a.csv", Some("0,O.5\n0.01,0\n0.02,0\n"));
    assert_eq!(found, "/a.csv:1: `0,O.5` is not `time,acceleration`, two numbers");
    let found = with("a.at2", Some("1\n2\n3\nNPTS= 3, DT= .01 SEC\n0.1 0.2\n"));
    assert!(found.starts_with("/a.at2: the header promises 3 samples, the file holds 2"), "{found}");
    let found = with("a.at2", Some("1\n2\n3\n4\n0.1 0.2\n"));
    assert!(found.starts_with("/a.at2:4: `4` is not a PEER header"), "{found}");
    assert!(with("a.txt", Some("0,1\n")).starts_with("/a.txt: records are two-column .csv"));
    assert!(with("absent.csv", None).starts_with("/absent.csv: No such file"));

    let mut scenario = Scenario::shipped(CRACKED);
    scenario.set("ground_motion.record.start", 30.0);
    assert!(problems(&scenario.write())[0].0.ends_with("samples from 0 to 19.98 s; two of them must remain"));
    scenario.set("ground_motion.record.start", 3.0).set("ground_motion.record.end", 60.0);
    assert!(problems(&scenario.write())[0].0.contains("3–60 s is asked for"));
}

/// What the program said, without the line breaks and bars of its layout.
fn flat(said: &[u8]) -> String {
    String::from_utf8_lossy(said).replace('│', " ").split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn the_program_points_at_the_line_and_ends_with_status_2() {
    let mut scenario = Scenario::shipped(CRACKED);
    scenario.set("reservoir.depth", -1.0);
    let output = scenario.try_run("run");
    let said = flat(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    let source = std::fs::read_to_string(scenario.folder().join("scene.toml")).expect("the scene");
    let line = source.lines().position(|l| l.starts_with("depth")).expect("a line") + 1;
    assert!(said.contains(&format!("scene.toml:{line}:")), "{said}");
    assert!(said.contains("depth = -1.0"), "{said}");
    assert!(!scenario.folder().join("run").exists(), "a wrong scene leaves nothing behind");
}

#[test]
fn an_output_folder_that_cannot_be_made_or_is_taken() {
    let scenario = Scenario::shipped("rigid-dam-ramp");
    std::fs::write(scenario.folder().join("file"), "").expect("a file");
    let output = scenario.try_run("file/run");
    let said = flat(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("file/run") && said.contains("choose another --output"), "{said}");

    std::fs::create_dir(scenario.folder().join("taken")).expect("a folder");
    std::fs::write(scenario.folder().join("taken/histories.csv"), "precious").expect("a file");
    let output = scenario.try_run("taken");
    let said = flat(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("is not empty"), "{said}");
}
