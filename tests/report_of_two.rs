//! The report of two runs: numbers of both are those of their files, differences are B − A, each history has its own instants.

use crate::report::{Page, loads_nothing, manifest, read, report, run, said, shared, short_scene};
use cofferdam_log::{Agreement, Log};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use whole_chain::scenario::{Histories, Scenario};

/// The shared run with another friction, steps twice as long, and an earlier end.
fn other() -> &'static Path {
    static RUN: OnceLock<(Scenario, PathBuf)> = OnceLock::new();
    let (_, folder) = RUN.get_or_init(|| {
        let mut scenario = short_scene();
        scenario.set("dam.cracks.0.friction_coefficient", 0.4).set("time.communication_step", 5e-3);
        scenario.set("ground_motion.record.end", 4.9).set("dam.cracks.0.name", "other & neck");
        scenario.set("reservoir.fidelity", "westergaard");
        let folder = run(&scenario, "other", &[]);
        (scenario, folder)
    });
    folder
}

/// The page of both, with A as the reference.
fn page(a: &Path, b: &Path) -> Page {
    let output = report(&[a, b]);
    assert!(output.status.success(), "{}", said(&output));
    let name = b.file_name().expect("a name").to_string_lossy();
    Page::read(&a.join(format!("report-{name}.html")))
}

/// Values by name and unit.
fn values(folder: &Path) -> BTreeMap<(String, String), f64> {
    let manifest = manifest(folder);
    let quantities = manifest["result"]["quantities"].as_array().expect("quantities").iter();
    let of = |quantity: &toml::Value| {
        let [name, unit] = ["name", "unit"].map(|key| quantity[key].as_str().expect("a word").to_owned());
        (
            (name, if unit == "1" { String::new() } else { unit }),
            quantity["value"].as_float().expect("a value"),
        )
    };
    quantities.map(of).collect()
}

fn floats(value: &serde_json::Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().unwrap_or(f64::NAN)).collect()
}

#[test]
fn both_have_their_numbers_and_the_differences_between() {
    let page = page(shared(), other());
    let [a, b] = [shared(), other()].map(values);
    let rows = &page.rows["quantities pair"];
    let mut seen = 0;
    for row in rows.iter().filter(|row| row.cells[0] != "quantity") {
        let name = row.cells[0].replace(" in A only", "").replace(" in B only", "");
        let key = (name, row.cells[3].clone());
        let of = [&a, &b].map(|run| run.get(&key).copied());
        let expected = match of {
            [Some(a), Some(b)] => {
                let share = (a != 0.0).then(|| 100.0 * ((b - a) / a.abs()));
                [a, b, b - a].into_iter().chain(share).collect::<Vec<_>>()
            }
            [only, other] => vec![only.or(other).unwrap_or_else(|| panic!("{key:?} is of no run"))],
        };
        assert_eq!(row.numbers[..expected.len()], expected, "{row:?}");
        assert_eq!(row.cells[0].ends_with(" in A only"), of[1].is_none(), "{row:?}");
        assert_eq!(row.cells[0].ends_with(" in B only"), of[0].is_none(), "{row:?}");
        if let [Some(a), Some(b)] = of {
            assert!(
                (read(row.cells[4].trim_start_matches('+')) - (b - a)).abs() <= 6e-4 * (b - a).abs(),
                "{row:?}"
            );
        }
        seen += 1;
    }
    let union: std::collections::BTreeSet<_> = a.keys().chain(b.keys()).collect();
    assert_eq!(seen, union.len());
    assert!(a.len() + b.len() > union.len() && rows.iter().any(|row| row.cells[0].ends_with(" in B only")));

    // The crest's number is that of the logs.
    let logs = [shared(), other()].map(|folder| Log::open(&folder.join("log.mcap")).expect("a log"));
    let agreement = Agreement::of([&logs[0], &logs[1]]).expect("an agreement");
    let crest =
        agreement.variables.iter().find(|m| m.variable.name == "dam.crest_displacement").expect("a crest");
    let worst = crest.worst();
    let card = &page.figures[0];
    assert_eq!(card.numbers[..2], [100.0 * crest.relative(worst), 1e3 * crest.differences[worst].0]);
    assert!((card.numbers[2] - agreement.ends[worst].time).abs() < 1e-9, "{card:?}");
    assert_eq!(card.numbers[3], agreement.ends.len() as f64);
    assert!(card.numbers[0] > 1.0, "{card:?}");

    // What was set otherwise, and what was not.
    let setting = |key: &str| page.row("settings", key).cells[1..].to_vec();
    assert_eq!(setting("dam.cracks.0.friction_coefficient"), ["0.5", "0.4"]);
    assert_eq!(setting("time.communication_step"), ["0.0025", "0.005"]);
    assert_eq!(setting("ground_motion.record.end"), ["5.0", "4.9"]);
    let keys: Vec<_> = page.rows["settings"].iter().map(|row| &*row.cells[0]).collect();
    assert!(!keys.contains(&"dam.element_size") && !keys.contains(&"commit"), "{keys:?}");
    let hash =
        manifest(shared())["scene"]["ground_motion"]["record"]["sha256"].as_str().expect("a hash").to_owned();
    assert!(page.words.contains("Equal in both:") && page.words.contains(&format!("(SHA-256 {hash})")));
    assert!(!page.words.contains("different dams"));
    // Their water differs: a sentence of one only.
    assert!(page.words.contains("Both runs") && page.words.contains("Run B only"));
    assert!(page.words.contains("result of A") && page.words.contains("result of B"));
    assert!(loads_nothing(&page).is_empty());
}

#[test]
fn each_history_keeps_its_instants_and_extremes() {
    let page = page(shared(), other());
    let histories = [shared(), other()].map(|folder| Histories::read(&folder.join("histories.csv")));
    let data = page.data();
    assert_eq!(
        ["time", "beside"].map(|key| floats(&data[key])),
        histories.each_ref().map(|h| h.column("time").to_vec())
    );
    let charts = data["charts"].as_array().expect("charts");
    for (title, column, factor) in [
        ("horizontal, positive downstream", "dam.crest_displacement.x", 1e3),
        ("Sliding of each crack, mm", "dam.crack_sliding.0", 1e3),
        ("Base pressure, kPa", "reservoir.base_pressure", 1e-3),
        ("kinetic energy", "dam.kinetic_energy", 1e-6),
    ] {
        let chart =
            charts.iter().find(|chart| chart["title"] == title).unwrap_or_else(|| panic!("no {title}"));
        for (of, histories) in [(chart, &histories[0]), (&chart["beside"], &histories[1])] {
            let mut row = 0;
            let steps = floats(&of["abscissa"]["Rows"]).into_iter();
            let rows: Vec<usize> = steps
                .map(|step| {
                    row += step as usize;
                    row
                })
                .collect();
            let values = floats(&of["series"][0]["values"]);
            let all: Vec<f64> = histories.column(column).iter().map(|value| factor * value).collect();
            let digit = 0.5 * 10f64.powf(whole_chain::peak(&all).log10().floor() - 4.0) * (1.0 + 1e-6);
            assert_eq!(
                (rows.len(), rows[0], rows.last()),
                (values.len(), 0, Some(&(all.len() - 1))),
                "{title}"
            );
            for (row, value) in rows.iter().zip(&values) {
                assert!((value - all[*row]).abs() <= digit, "{title}: {value}, {}", all[*row]);
            }
            for extreme in [f64::min, f64::max] {
                let [kept, whole] =
                    [&values, &all].map(|of| of.iter().copied().reduce(extreme).expect("values"));
                assert!((kept - whole).abs() <= digit, "{title}: {kept}, {whole}");
            }
        }
    }
    // A crack that is called otherwise is still laid beside.
    let sliding = charts.iter().find(|chart| chart["title"] == "Sliding of each crack, mm").expect("sliding");
    assert_eq!(sliding["beside"]["series"][0]["name"], "B, other & neck");
}

#[test]
fn different_dams_are_said_and_what_is_no_pair_is_refused() {
    let prescribed = Scenario::shipped("rigid-dam-ramp");
    let ramp = run(&prescribed, "ramp", &[]);
    let place = tempfile::tempdir().expect("a folder");
    let target = place.path().join("pair.html");
    let output = report(&[shared(), &ramp, Path::new("--output"), &target]);
    assert!(output.status.success(), "{}", said(&output));
    let page = Page::read(&target);
    assert!(
        page.words
            .contains("The runs have different dams: the dam of A is computed, the dam of B is prescribed")
    );
    assert!(page.words.contains("not measured: no dam or no common instant"));
    assert!(loads_nothing(&page).is_empty());

    let twice = shared().join(".");
    for (folders, wanted) in [
        (vec![shared(), &twice], "is given twice; give the folders of two runs"),
        (vec![shared(), place.path()], "manifest.toml is missing: give the folder of a run"),
        (vec![shared(), other(), place.path()], "unexpected argument"),
    ] {
        let output = report(&folders);
        assert!(output.status.code() == Some(2) && said(&output).contains(wanted), "{}", said(&output));
    }
}
