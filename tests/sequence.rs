//! A main shock and an aftershock in one run: motion, state, stability after each shock, and what is written about them.

use crate::log::{cofferdam, text};
use cofferdam_assembly::log::ground_motion_of;
use cofferdam_assembly::packing::CoupledParameters;
use cofferdam_assembly::read_scene;
use cofferdam_log::Log;
use std::path::{Path, PathBuf};
use toml::{Table, Value};
use whole_chain::scenario::{Histories, Scenario, root};

/// The interval of the record, and the length of each shock, s.
const INTERVAL: f64 = 0.01;
const SHOCK: f64 = 1.0;
const REST: f64 = 5.5;

fn table(pairs: &[(&str, Value)]) -> Value {
    Value::Table(pairs.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect())
}

fn record() -> String {
    root().join("scenes/records/northridge-1994-canyon-country-270.csv").to_string_lossy().into_owned()
}

/// Koyna, coarse, under a second of the record, and nothing else.
fn alone() -> Scenario {
    let mut scenario = Scenario::quick(15.0);
    scenario.set("dam.element_size", 16.0).set("dam.uplift", "unchanged");
    scenario.set("ground_motion.record.start", 4.4).set("ground_motion.record.end", 4.4 + SHOCK);
    scenario
}

/// The same, and then the weaker opposite.
fn sequence() -> Scenario {
    let mut scenario = alone();
    let aftershock = [
        ("name", Value::from("aftershock")),
        ("rest", REST.into()),
        ("file", record().into()),
        ("scale", 0.8.into()),
        ("polarity", (-1).into()),
        ("start", 4.4.into()),
        ("end", (4.4 + SHOCK).into()),
    ];
    scenario.set("ground_motion.sequence", Value::Array(vec![table(&aftershock)]));
    scenario
}

/// When the aftershock begins, s.
const BEGIN: f64 = SHOCK + INTERVAL + REST;

fn run(scenario: &Scenario) -> PathBuf {
    let output =
        scenario.command("run").args(["--transport", "in-process"]).output().expect("cofferdam runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    scenario.folder().join("run")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Header and rows of a CSV file.
fn rows(path: &Path) -> (csv::StringRecord, Vec<csv::StringRecord>) {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    (reader.headers().expect("a header").clone(), reader.records().map(|row| row.expect("a row")).collect())
}

#[test]
fn the_first_shock_is_its_record_alone_and_the_second_meets_what_it_left() {
    let (before, both) = (alone(), sequence());
    let [before, both] = [&before, &both].map(|scenario| (run(scenario).join("histories.csv"), scenario));
    let [first, whole] = [&before, &both].map(|(path, _)| rows(path));
    assert_eq!(first.0, whole.0);
    let time = |row: &csv::StringRecord| row[0].parse::<f64>().expect("a time");
    let (mut same, mut others) = (0, 0);
    for (a, b) in first.1.iter().zip(&whole.1) {
        if time(a) <= BEGIN + 1e-9 {
            assert_eq!(a, b, "until the aftershock begins");
            same += 1;
        } else {
            others += usize::from(a != b);
        }
    }
    assert!(same as f64 > BEGIN / 0.0025 && others > 2000, "{same} and {others} rows");
    // the second shock is the samples of the first one, opposite and weaker
    let histories = Histories::read(&both.0);
    let (time, ground) = (histories.column("time"), histories.column("ground_acceleration.x"));
    let row = |at: f64| time.partition_point(|time| *time < at - 1e-9);
    let mut moved = 0.0_f64;
    for n in 0..=400 {
        let at = 0.0025 * f64::from(n);
        let (first, second) = (ground[row(at)], ground[row(BEGIN + INTERVAL + at)]);
        assert!((second + 0.8 * first).abs() < 1e-9, "{first} and {second} at {at}");
        moved = moved.max(first.abs());
    }
    assert!(moved > 3.0, "{moved} m/s²");
    let rest = row(SHOCK + INTERVAL)..=row(BEGIN);
    assert!(rest.clone().count() > 2000 && ground[rest].iter().all(|a| *a == 0.0));
}

/// Log, manifest, replay, tables and pages of one run.
#[test]
fn a_run_of_two_shocks_says_what_each_did() -> Result<(), Box<dyn std::error::Error>> {
    let scenario = sequence();
    let scene = scenario.write();
    let loaded = read_scene(&scene, &[])?;
    let begins = loaded.ground_motion.begins();
    assert!(begins.len() == 2 && (begins[1] - BEGIN).abs() < 1e-9, "{begins:?}");
    let folder = run(&scenario);
    let log = Log::open(&folder)?;
    let motion = ground_motion_of(&log);
    assert_eq!(
        (motion.acceleration(), motion.begins()),
        (loaded.ground_motion.acceleration(), begins.clone())
    );
    // a manifest is a scene
    let manifest: Table = read(&folder.join("manifest.toml")).parse()?;
    let ground = &manifest["scene"]["ground_motion"];
    assert_eq!(ground["sequence"][0]["sha256"], ground["record"]["sha256"]);
    assert_eq!(read_scene(&folder.join("manifest.toml"), &[])?.ground_motion, loaded.ground_motion);
    let (status, said) = cofferdam(&["replay", text(&folder), "--quiet"]);
    assert!(status == Some(0) && said.matches("identical").count() == 2, "{said}");

    let csv = scenario.folder().join("stability.csv");
    let (status, said) = cofferdam(&["stability", text(&folder), "--csv", text(&csv)]);
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("after 1") && said.contains("after 2"), "{said}");
    let of_shock = "In shock 1, from 0.00 to 6.51 s: least factor against sliding";
    assert!(said.contains(of_shock) && said.contains("In aftershock, from 6.51 to 15.00 s"), "{said}");
    assert!(said.lines().all(|line| line.chars().count() <= 80), "{said}");
    let (header, rows) = rows(&csv);
    let column = |name: &str| header.iter().position(|head| head == name).expect("a column");
    let names: Vec<&str> = rows.iter().map(|row| &row[column("name")]).collect();
    let [.., first, second] = names[..] else { panic!("{names:?}") };
    assert!(names.len() == 4 && first.ends_with(", after shock 1") && second.ends_with(", after aftershock"));
    let open = |row: &csv::StringRecord| row[column("unbonded_m")].parse::<f64>();
    let opened = [open(&rows[2])?, open(&rows[3])?];
    // of the histories
    let histories = Histories::read(&folder.join("histories.csv"));
    let (time, share) = (histories.column("time"), histories.column("dam.crack_open_share.0"));
    let length: f64 = rows[0][column("length_m")].parse()?;
    for (end, opened) in [BEGIN, f64::INFINITY].into_iter().zip(opened) {
        let until = time.iter().zip(share).filter(|(time, _)| **time <= end + 1e-9);
        let largest = length * until.fold(0.0, |most: f64, (_, share)| most.max(*share));
        assert!((opened - largest).abs() < 1e-9 && largest > 0.0, "{opened} for {largest} m until {end}");
    }
    assert!(opened[0] <= opened[1] && opened[1] <= length, "{opened:?}");
    let sliding = histories.column("dam.crack_sliding.0");
    let at_begin = 1e3 * sliding[time.partition_point(|time| *time <= BEGIN + 1e-9) - 1];
    let at_end = 1e3 * sliding[sliding.len() - 1];
    let words = said.split_whitespace().collect::<Vec<_>>().join(" ");
    for slid in [
        format!("sliding {at_begin:.1} mm more, {at_begin:.1} mm in total"),
        format!("sliding {:.1} mm more, {at_end:.1} mm in total", at_end - at_begin),
    ] {
        assert!(words.contains(&slid), "{slid}: {words}");
    }
    assert!((at_end - at_begin).abs() > 0.1, "the aftershock moves the block: {at_begin} and {at_end} mm");

    let quantities = manifest["result"]["quantities"].as_array().ok_or("quantities")?;
    let value =
        |name: &str| quantities.iter().find(|q| q["name"].as_str() == Some(name))?["value"].as_float();
    let residual = value("residual sliding after shock 1").ok_or("residual sliding after the first shock")?;
    assert!((residual - at_begin).abs() < 0.1, "{residual} and {at_begin} mm");
    assert!(value("residual sliding").is_some_and(|residual| (residual - at_end).abs() < 0.1));
    let page = read(&folder.join("report.html"));
    for wanted in [
        "residual sliding after shock 1",
        "aftershock begins at 6.51 s",
        "scale factor of aftershock",
        "record of aftershock",
        "Arias intensity, aftershock",
        "In aftershock, from",
    ] {
        assert!(page.contains(wanted), "no `{wanted}` on the page");
    }
    Ok(())
}

#[test]
fn commands_know_the_sequence() -> Result<(), Box<dyn std::error::Error>> {
    let mut scenario = sequence();
    scenario.set("time.duration", 8.0);
    let scene = scenario.write();
    let loaded = read_scene(&scene, &[])?;
    let (status, said) = cofferdam(&["check", text(&scene)]);
    assert!(status == Some(0) && said.contains("ground: aftershock from 6.51 s, northridge"), "{said}");
    let (status, said) = cofferdam(&["fmu-input", text(&scene)]);
    assert_eq!(status, Some(0), "{said}");
    // importers take the value of a row for the step before: two rows of the start, then row n + 2 has the end of step n
    for (row, line) in said.lines().skip(1).enumerate() {
        let value: f64 = line.split(',').nth(1).ok_or("a column")?.parse()?;
        let wanted = loaded.ground_motion.at(row.saturating_sub(1) as f64 * 0.0025)[0];
        assert!((value - wanted).abs() < 1e-9, "{value} for {wanted} in row {row}");
    }
    assert_eq!(said.lines().count(), 1 + 2 + 3201);
    // the unit for importers has the whole motion, and no path of this machine
    let parameters = CoupledParameters::of(&loaded.scene, &loaded.ground_motion)?;
    assert_eq!(parameters.record.samples, loaded.ground_motion.acceleration());
    let own = parameters.scene.ground_motion.sequence.first().ok_or("a sequence")?;
    assert_eq!(own.record.file, Path::new("northridge-1994-canyon-country-270.csv"));
    let plan = scenario.folder().join("plan.toml");
    let records = format!("records = [{{ file = {:?} }}]", record());
    std::fs::write(
        &plan,
        format!("title = \"t\"\nscene = \"scene.toml\"\n{records}\n[intensity]\nscales = [1.0]\n"),
    )?;
    let output = scenario.folder().join("ensemble");
    let (status, said) = cofferdam(&["ensemble", text(&plan), "--output", text(&output)]);
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(status == Some(2) && said.contains("[[ground_motion.sequence]]"), "{status:?}: {said}");
    Ok(())
}
