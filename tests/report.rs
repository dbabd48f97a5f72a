//! The report of a run: what it shows is what the run's files say, in markup that every reader takes.

use cofferdam_report::page::{ReportData, RunFolder};
use quick_xml::events::Event;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use whole_chain::scenario::{Histories, Scenario, binary, root};

/// A title that would be a program if it were not escaped.
const TITLE: &str = "<script>alert(1)</script> & \"dam\"";
const CRACK: &str = "</script><b>neck & co";

/// The strong part of the main scene, coarse and short.
pub fn short_scene() -> Scenario {
    let mut scenario = Scenario::shipped("koyna-coarse");
    scenario.set("title", TITLE).set("dam.cracks.0.name", CRACK);
    scenario.set("dam.element_size", 15.0).set("reservoir.element_size", 15.0);
    scenario.set("dam.material.tensile_strength", 2.5e5);
    scenario
        .set("dam.cracks.0.friction_coefficient", 0.5)
        .set("ground_motion.record.start", 4.4)
        .set("ground_motion.record.end", 5.0)
        .set("time.quiet", 0.0);
    scenario
}

pub fn run(scenario: &Scenario, name: &str, options: &[&str]) -> PathBuf {
    let mut command = scenario.command(name);
    let output = command.args(["--transport", "in-process"]).args(options).output().expect("cofferdam runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    scenario.folder().join(name)
}

/// A run that several tests look at.
pub fn shared() -> &'static Path {
    static RUN: OnceLock<(Scenario, PathBuf)> = OnceLock::new();
    let (_, folder) = RUN.get_or_init(|| {
        let scenario = short_scene();
        let folder = run(&scenario, "run", &[]);
        (scenario, folder)
    });
    folder
}

pub fn report(arguments: &[&Path]) -> Output {
    Command::new(binary()).arg("report").args(arguments).output().expect("cofferdam runs")
}

/// What was said, without the line breaks of the terminal.
pub fn said(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    text.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

/// A row of a table: its cells as text, and the exact numbers in it.
#[derive(Clone, Debug, Default)]
pub struct Row {
    pub cells: Vec<String>,
    pub numbers: Vec<f64>,
}

/// A page, read strictly as XML without its scripts and styles.
#[derive(Default)]
pub struct Page {
    pub text: String,
    pub markup: String,
    pub words: String,
    pub rows: BTreeMap<String, Vec<Row>>,
    pub figures: Vec<Row>,
    pub ids: Vec<String>,
    pub links: Vec<String>,
}

/// The page without what stands between these tags.
fn without(text: &str, begin: &str, end: &str) -> String {
    let mut parts = text.split(begin);
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |kept, part| {
        let (_, rest) = part.split_once(end).unwrap_or_else(|| panic!("{begin} has no {end}"));
        kept + rest
    })
}

impl Page {
    fn of(folder: &Path) -> Self {
        Self::read(&folder.join("report.html"))
    }

    pub fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).expect("a page");
        let markup = without(&without(&text, "<script", "</script>"), "<style", "</style>");
        let mut page = Self { text, markup: markup.clone(), ..Self::default() };
        let mut reader = quick_xml::Reader::from_str(&markup);
        reader.config_mut().check_end_names = true;
        let (mut open, mut table, mut row) = (Vec::<String>::new(), String::new(), Row::default());
        let mut card = false;
        loop {
            match reader.read_event().unwrap_or_else(|e| panic!("at {}: {e}", reader.error_position())) {
                Event::Eof => break,
                Event::DocType(_) | Event::Comment(_) => {}
                Event::Empty(tag) => drop(page.see(&tag)),
                Event::Start(tag) => {
                    let name = tag.name().as_ref().to_owned();
                    let class = page.see(&tag);
                    match name.as_str() {
                        "table" => table = class,
                        "tr" => row = Row::default(),
                        "th" | "td" => row.cells.push(String::new()),
                        "div" if class.split(' ').next() == Some("figure") => {
                            (card, row) = (true, Row { cells: vec![String::new()], ..Row::default() })
                        }
                        "data" => {
                            let value = tag.try_get_attribute("value").expect("attributes").expect("a value");
                            let value = value.value.parse();
                            row.numbers.push(value.expect("a number"));
                        }
                        _ => {}
                    }
                    open.push(name);
                }
                Event::End(_) => match open.pop().as_deref() {
                    Some("tr") => page.rows.entry(table.clone()).or_default().push(std::mem::take(&mut row)),
                    Some("div") if card => {
                        card = false;
                        page.figures.push(std::mem::take(&mut row));
                    }
                    _ => {}
                },
                Event::Text(text) => page.say(&text, &mut row),
                Event::GeneralRef(entity) => {
                    let text = quick_xml::escape::unescape(&format!("&{};", &*entity))
                        .expect("an entity")
                        .into_owned();
                    page.say(&text, &mut row);
                }
                other => panic!("{other:?}"),
            }
        }
        assert!(open.is_empty(), "{open:?} are not closed");
        page
    }

    fn say(&mut self, text: &str, row: &mut Row) {
        self.words += text;
        if let Some(cell) = row.cells.last_mut() {
            *cell += text;
        }
    }

    /// Remembers names and links; returns the class.
    fn see(&mut self, tag: &quick_xml::events::BytesStart<'_>) -> String {
        let of = |name: &str| {
            let attribute = tag.try_get_attribute(name).expect("attributes")?;
            Some(attribute.value.into_owned())
        };
        self.ids.extend(of("id"));
        self.links.extend(of("href"));
        of("class").unwrap_or_default()
    }

    pub fn data(&self) -> serde_json::Value {
        let (_, rest) = self.text.split_once("<script type=\"application/json\" id=\"data\">").expect("data");
        let (json, _) = rest.split_once("</script>").expect("its end");
        assert!(!json.contains(['<', '>', '&']), "data hold no markup");
        serde_json::from_str(json).expect("JSON")
    }

    /// The row of a table that begins with `name`.
    pub fn row(&self, table: &str, name: &str) -> &Row {
        let rows = self.rows.get(table).unwrap_or_else(|| panic!("no table {table}"));
        rows.iter()
            .find(|row| row.cells[0].starts_with(name))
            .unwrap_or_else(|| panic!("no row {name} in {rows:?}"))
    }
}

pub fn manifest(folder: &Path) -> toml::Table {
    std::fs::read_to_string(folder.join("manifest.toml")).expect("a manifest").parse().expect("TOML")
}

/// A number as it is shown.
pub fn read(shown: &str) -> f64 {
    let plain = shown.replace('−', "-").replace(['\u{202f}', ' '], "");
    let (digits, power) = plain.split_once("·10").unwrap_or((&plain, ""));
    let power: String = power
        .chars()
        .filter_map(|c| "⁻⁰¹²³⁴⁵⁶⁷⁸⁹".chars().position(|s| s == c))
        .map(|i| b"-0123456789"[i] as char)
        .collect();
    let digits: f64 = digits.parse().unwrap_or_else(|e| panic!("{shown}: {e}"));
    digits * 10f64.powi(power.parse().unwrap_or(0))
}

#[test]
fn every_number_is_that_of_the_run() {
    let (folder, page) = (shared(), Page::of(shared()));
    let (manifest, histories) = (manifest(folder), Histories::read(&folder.join("histories.csv")));
    let quantities = manifest["result"]["quantities"].as_array().expect("quantities");
    // Below the heading a row each, in order, with all digits.
    let rows = &page.rows["quantities"][1..];
    assert_eq!(rows.len(), quantities.len());
    for (row, quantity) in rows.iter().zip(quantities) {
        let of = |key: &str| quantity.get(key).and_then(toml::Value::as_float);
        let value = of("value").expect("a value");
        assert_eq!(Some(&*row.cells[0]), quantity["name"].as_str());
        let numbers: Vec<f64> = [Some(value), of("time")].into_iter().flatten().collect();
        assert_eq!(row.numbers[..numbers.len()], numbers, "{row:?}");
        assert!((read(&row.cells[1]) - value).abs() <= 6e-4 * value.abs(), "{row:?}");
        let unit = quantity["unit"].as_str().filter(|unit| *unit != "1").unwrap_or_default();
        assert_eq!(row.cells[2], unit);
    }
    let value = |name: &str| {
        let quantity = quantities.iter().find(|q| q["name"].as_str() == Some(name));
        quantity.and_then(|q| q["value"].as_float()).unwrap_or_else(|| panic!("no {name}"))
    };
    for name in [
        "overstressed area of the section",
        "overstressed share of the section",
        "largest demand-capacity ratio",
        "longest time above the tensile strength",
    ] {
        assert_eq!(page.row("short", name).numbers, [value(name)], "{name}");
    }
    for name in [
        "overstressed share of the section",
        "largest demand-capacity ratio",
        "longest time above the tensile strength",
    ] {
        assert_eq!(page.row("checks", name).numbers, [value(name)], "{name}");
    }
    assert!(page.words.contains("Verdict: "), "no verdict on the overstress");
    assert_eq!(page.row("short", "tensile strength").numbers, [0.25]);
    assert!(page.markup.contains("class=\"envelope\"") && page.markup.contains("class=\"strength\""));
    // No residual after so short a run: the peaks take its place.
    let sliding = format!("peak sliding, {CRACK}");
    let crest = ["downstream", "upstream"].map(|to| format!("peak crest displacement {to}"));
    let larger = crest.iter().max_by(|a, b| value(a).abs().total_cmp(&value(b).abs())).expect("two");
    let first = [
        larger.as_str(),
        &sliding,
        "peak base shear",
        "largest tension in the dam",
        "lowest pressure on a wet face, hydrostatic included",
    ];
    assert_eq!(page.figures.iter().map(|figure| figure.numbers[0]).collect::<Vec<_>>(), first.map(value));

    let found = |name: &str| page.row("checks", name).numbers.clone();
    let column = |name: &str| histories.column(name);
    assert_eq!(found("static thrust")[0], 1e-6 * column("dam.base_shear")[0]);
    assert!((found("static thrust")[1] - 1e-6 * 1000.0 * 9.81 * 91.75f64.powi(2) / 2.0).abs() < 1e-9);
    assert_eq!(found("weight")[0], 1e-6 * column("dam.base_normal_force")[0]);
    let frequencies = ["full", "empty"].map(|water| value(&format!("natural frequency 1 (intact, {water})")));
    assert_eq!(found("ω₁"), frequencies);
    assert_eq!(found("energy balance"), [value("energy balance error over peak kinetic energy")]);
    assert_eq!(
        found("steps without convergence"),
        [column("converged").iter().filter(|c| **c == 0.0).count() as f64]
    );
    let verdict = |name: &str| page.row("checks", name).cells[5].clone();
    assert!(["weight", "ω₁", "energy"].iter().all(|name| verdict(name) == "✓ passed"));
    // The ground of this crop already accelerates at time 0.
    assert_eq!(verdict("static thrust"), "not judged");
    assert_eq!(verdict("rest at the end"), "not judged");
    let cavitates = value("lowest pressure on a wet face, hydrostatic included") < -99.0;
    assert_eq!(verdict("lowest pressure") == "✗ failed", cavitates);

    // Samples of the record lie at communication points.
    let largest = whole_chain::peak(column("ground_acceleration.x")) / 9.80665;
    assert!((page.row("short", "peak ground acceleration").numbers[0] / largest - 1.0).abs() < 1e-12);
    let (time, shares) = (column("time"), column("dam.crack_shear_utilisation.0"));
    let slid = time.windows(2).zip(&shares[1..]).filter(|(_, share)| **share >= 1.0 - 1e-9);
    let slid: f64 = slid.map(|(pair, _)| pair[1] - pair[0]).sum();
    assert!(slid > 0.0 && page.row("short", CRACK).numbers[0] == slid, "{slid}");
    // Inputs in the units of the field.
    assert_eq!(page.row("inputs", "elastic modulus").numbers, [1e-9 * 3.1e10]);
    assert!(page.row("inputs", "communication step").cells[1].starts_with("2.5 ms"));
    let hash = manifest["scene"]["ground_motion"]["record"]["sha256"].as_str().expect("a hash");
    assert!(page.rows["inputs"].iter().any(|row| row.cells[0] == "record" && row.cells[1].starts_with(hash)));
}

/// Title of a chart, name of a line, column, factor.
const LINES: [(&str, &str, &str, f64); 6] = [
    ("Ground acceleration, g", "ground, positive downstream", "ground_acceleration.x", 1.0 / 9.80665),
    ("Crest displacement, mm", "horizontal, positive downstream", "dam.crest_displacement.x", 1e3),
    ("Base pressure, kPa", "reservoir", "reservoir.base_pressure", 1e-3),
    ("Force on the base, MN/m", "shear, positive downstream", "dam.base_shear", 1e-6),
    ("Energy balance, MJ/m", "kinetic energy", "dam.kinetic_energy", 1e-6),
    ("Major principal stress, MPa", "heel", "dam.major_principal_stress.0", 1e-6),
];

#[test]
fn thinned_histories_keep_their_extremes_and_their_times() {
    let mut scenario = short_scene();
    scenario.set("dam.element_size", 25.0).set("reservoir.fidelity", "westergaard");
    scenario.set("time.communication_step", 6e-5);
    let folder = run(&scenario, "fine", &["--log", "none"]);
    let histories = Histories::read(&folder.join("histories.csv"));
    let (data, time) = (Page::of(&folder).data(), histories.column("time"));
    let floats = |value: &serde_json::Value| -> Vec<f64> {
        value.as_array().expect("a list").iter().map(|v| v.as_f64().unwrap_or(f64::NAN)).collect()
    };
    assert_eq!(floats(&data["time"]), time);
    let charts = data["charts"].as_array().expect("charts");
    for (title, line, column, factor) in LINES {
        let chart =
            charts.iter().find(|chart| chart["title"] == title).unwrap_or_else(|| panic!("no {title}"));
        let mut row = 0;
        let rows = floats(&chart["abscissa"]["Rows"]).into_iter().map(|step| {
            row += step as usize;
            row
        });
        let rows: Vec<usize> = rows.collect();
        let series = chart["series"].as_array().expect("lines").iter().find(|series| series["name"] == line);
        let values = floats(&series.unwrap_or_else(|| panic!("no {line}"))["values"]);
        let all: Vec<f64> = histories.column(column).iter().map(|value| factor * value).collect();
        assert!(
            rows.len() == values.len() && rows.len() < time.len() && rows[0] == 0,
            "{title}: {}",
            rows.len()
        );
        assert_eq!(rows.last(), Some(&(time.len() - 1)));
        // Half of the fifth digit of the largest.
        let digit = 0.5 * 10f64.powf(whole_chain::peak(&all).log10().floor() - 4.0) * (1.0 + 1e-6);
        for (row, value) in rows.iter().zip(&values) {
            assert!((value - all[*row]).abs() <= digit, "{title} at {}: {value}, {}", time[*row], all[*row]);
        }
        for extreme in [f64::min, f64::max] {
            let [kept, whole] = [&values, &all].map(|of| of.iter().copied().reduce(extreme).expect("values"));
            assert!((kept - whole).abs() <= digit, "{title}: {kept}, {whole}");
        }
    }
}

#[test]
fn pressure_over_height_is_that_of_the_log_beside_the_parabola() {
    let folder = shared();
    let data = ReportData::of(&RunFolder::read(folder).expect("a run"), None).expect("data");
    let face = Histories::read(&folder.join("reservoir-interface_pressure.csv"));
    let histories = Histories::read(&folder.join("histories.csv"));
    let base = histories.column("reservoir.base_pressure");
    let row = (0..base.len()).max_by(|&a, &b| base[a].abs().total_cmp(&base[b].abs())).expect("rows");
    assert_eq!(
        data.profiles.iter().map(|profile| &*profile.instant).collect::<Vec<_>>(),
        ["peak base pressure", "peak crest displacement", "end of the run"]
    );
    let ground = histories.column("ground_acceleration.x");
    let scene = &RunFolder::read(folder).expect("a run").loaded;
    let peak = scene.ground_motion.acceleration().iter().fold(0.0, |peak: f64, a| peak.max(a.abs()));
    for (profile, row) in [(&data.profiles[0], row), (&data.profiles[2], base.len() - 1)] {
        assert!((profile.time - histories.column("time")[row]).abs() < 1e-9);
        for (point, [_, pressure]) in profile.computed.iter().enumerate() {
            assert_eq!(*pressure, face.column(&format!("point {point}"))[row]);
        }
        assert_eq!(profile.ground_acceleration, ground[row]);
    }
    // The parabola of the peak acceleration, with the sign of the pressure at the base; none at the end.
    let parabola = &data.profiles[0].westergaard;
    let expected = 0.875 * 1000.0 * peak * 91.75 * base[row].signum();
    assert!((parabola[0][1] / expected - 1.0).abs() < 1e-12 && parabola[0][0] == 0.0, "{:?}", parabola[0]);
    assert!(parabola.last().is_some_and(|[y, pressure]| *y == 91.75 && *pressure == 0.0));
    assert!(data.profiles[2].westergaard.is_empty());
    assert_eq!(data.profiles[0].computed.last().map(|point| point[0]), Some(91.75));
}

/// Rows of whole numbers, each but the first as its differences from the row before, as values.
fn summed(counted: &serde_json::Value) -> (f64, Vec<Vec<f64>>) {
    let unit = counted["unit"].as_f64().expect("a unit");
    let mut counts = Vec::<i64>::new();
    let rows = counted["rows"].as_array().expect("rows").iter().map(|row| {
        let steps: Vec<i64> = serde_json::from_value(row.clone()).expect("whole numbers");
        counts.resize(steps.len(), 0);
        counts.iter_mut().zip(&steps).for_each(|(count, step)| *count += step);
        counts.iter().map(|count| unit * *count as f64).collect()
    });
    (unit, rows.collect())
}

#[test]
fn the_dam_in_motion_is_that_of_the_run() {
    let (folder, data) = (shared(), Page::of(shared()).data());
    let animation = &data["animation"];
    let [motion, histories, pressure] = ["outline.csv", "histories.csv", "reservoir-interface_pressure.csv"]
        .map(|name| Histories::read(&folder.join(name)));
    let (times, all) = (motion.column("time"), histories.column("time"));
    assert_eq!(animation["times"], serde_json::json!(times));
    // 0.6 s in steps of 25 ms, both ends.
    assert_eq!(times.len(), 25);
    let outline: Vec<Vec<[f64; 2]>> = serde_json::from_value(animation["outline"].clone()).expect("points");
    let area = |of: &Vec<[f64; 2]>| {
        let next = of.iter().cycle().skip(1);
        0.5 * of.iter().zip(next).map(|(p, q)| p[0] * q[1] - q[0] * p[1]).sum::<f64>()
    };
    // The section of Koyna above and below the crack, counter-clockwise.
    let mut areas: Vec<f64> = outline.iter().map(area).collect();
    areas.sort_by(f64::total_cmp);
    let exact = [(14.8 + 19.25) / 2.0 * 36.5, (19.25 + 70.0) / 2.0 * 66.5];
    assert!(areas.len() == 2 && areas.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-6), "{areas:?}");

    let points: Vec<[f64; 2]> = outline.concat();
    let (unit, moved) = summed(&animation["motion"]);
    assert!(moved.len() == times.len() && moved[0].iter().all(|u| u.abs() <= 0.5 * unit));
    for (row, moved) in moved.iter().enumerate() {
        for (number, moved) in moved.iter().enumerate() {
            let axis = ["x", "y"][number % 2];
            let written = motion.column(&format!("{}.{axis}", number / 2))[row];
            assert!((moved - written).abs() <= 0.501 * unit, "point {} at {}", number / 2, times[row]);
        }
    }
    // The histories have the crest; 0.1 µm is the last digit of the file.
    let crest = points.iter().position(|point| *point == [0.0, 103.0]).expect("the upstream crest");
    let at: Vec<usize> =
        times.iter().map(|time| all.iter().position(|of| of == time).expect("a step")).collect();
    for axis in ["x", "y"] {
        let written = motion.column(&format!("{crest}.{axis}"));
        let exact = histories.column(&format!("dam.crest_displacement.{axis}"));
        assert!(written.iter().zip(&at).all(|(u, row)| (u - exact[*row]).abs() <= 0.5001e-7));
    }
    let exact = histories.column("dam.crest_displacement.x");
    let first = animation["first"].as_u64().expect("a number") as usize;
    assert!(at.iter().all(|row| exact[*row].abs() <= exact[at[first]].abs()) && exact[at[first]] != 0.0);

    let water = &animation["waters"][0];
    let (unit, drawn) = summed(&water["pressure"]);
    assert!(water["name"] == "reservoir" && water["level"] == 91.75 && water["downstream"] == false);
    let wet: Vec<[f64; 2]> = serde_json::from_value(water["points"].clone()).expect("points");
    for (row, drawn) in at.iter().zip(&drawn) {
        let exact = (0..wet.len()).map(|point| pressure.column(&format!("point {point}"))[*row]);
        assert!(drawn.iter().zip(exact).all(|(p, exact)| (p - exact).abs() <= 0.501 * unit));
    }
    let face: Vec<usize> = serde_json::from_value(water["face"].clone()).expect("numbers");
    let face: Vec<[f64; 2]> = face.iter().map(|number| points[*number]).collect();
    assert!(face.iter().all(|[x, _]| *x == 0.0) && face.is_sorted_by(|a, b| a[1] <= b[1]));
    // Both sides of the crack are on the face.
    assert!(face[0][1] == 0.0 && face.iter().filter(|[_, y]| *y == 66.5).count() == 2, "{face:?}");

    let readings = animation["readings"].as_array().expect("readings");
    for (name, column, factor) in [
        ("ground, g", "ground_acceleration.x", 1.0 / 9.80665),
        ("crest, mm", "dam.crest_displacement.x", 1e3),
        (&format!("{CRACK}: sliding, mm"), "dam.crack_sliding.0", 1e3),
        (&format!("{CRACK}: opening, mm"), "dam.crack_opening.0", 1e3),
        ("reservoir: base pressure, kPa", "reservoir.base_pressure", 1e-3),
    ] {
        let of = readings.iter().find(|of| of["name"] == name).unwrap_or_else(|| panic!("no {name}"));
        let exact: Vec<f64> = at.iter().map(|row| factor * histories.column(column)[*row]).collect();
        let digit = 0.501 * 10f64.powf(whole_chain::peak(&exact).log10().floor() - 4.0);
        for (shown, exact) in of["values"].as_array().expect("values").iter().zip(exact) {
            assert!((shown.as_f64().expect("a number") - exact).abs() <= digit, "{name}");
        }
    }
}

#[test]
fn names_are_text_and_never_markup() {
    let page = Page::of(shared());
    assert!(!page.text.contains("<script>alert") && !page.text.contains("<b>neck"));
    assert!(page.words.contains(TITLE) && page.words.contains(CRACK));
    let data = page.data();
    let named = |series: &serde_json::Value| series["name"] == CRACK;
    let charts = data["charts"].as_array().expect("charts");
    assert!(charts.iter().any(|chart| chart["series"].as_array().expect("lines").iter().any(named)));
}

/// The markup is well-formed (reading it is the test), names are given once, and links lead to them; returns other links.
pub fn loads_nothing(page: &Page) -> Vec<String> {
    let mut ids = page.ids.clone();
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), page.ids.len(), "{:?}", page.ids);
    let (inside, outside): (Vec<_>, Vec<_>) = page.links.iter().partition(|link| link.starts_with('#'));
    assert!(inside.len() > 5 && inside.iter().all(|link| page.ids.iter().any(|id| link[1..] == *id)));

    let library = root().join("orchestrator/report/src/page/uplot/uPlot.iife.min.js");
    let library = std::fs::read_to_string(library).expect("the library");
    // Its banner names its home.
    assert_eq!(library.matches("://").count(), 1);
    // Clips of the section are in the page.
    let own = page.text.replacen(&library, "", 1).replace("url(#", "");
    for word in ["://", "src=", "url(", "@import", "<link", "<img", "<iframe", "<object", "<form"] {
        assert!(!own.contains(word), "{word}");
    }
    for word in
        ["fetch(", "XMLHttpRequest", "WebSocket", "importScripts", "import(", "sendBeacon", "new Image"]
    {
        assert!(!page.text.contains(word), "{word}");
    }
    assert!(
        page.markup.contains(
            "content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'\""
        )
    );
    outside.into_iter().cloned().collect()
}

#[test]
fn links_lead_somewhere_and_nothing_is_loaded() {
    let page = Page::of(shared());
    assert!(loads_nothing(&page).is_empty());
    let vendored = root().join("orchestrator/report/src/page/uplot");
    assert!(page.markup.contains("<noscript>"));
    assert!(
        page.text.contains("Permission is hereby granted, free of charge"),
        "the licence goes with the library"
    );

    let notes = std::fs::read_to_string(vendored.join("README.md")).expect("notes");
    for file in ["uPlot.iife.min.js", "uPlot.min.css"] {
        let output = Command::new("sha256sum").arg(vendored.join(file)).output().expect("sha256sum");
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        let hash = said.split(' ').next().expect("a hash");
        assert!(hash.len() == 64 && notes.contains(&format!("`{file}` | {hash} |")), "{file}: {said}");
    }
}

#[test]
fn a_missing_file_is_named_with_the_remedy() {
    let (folder, place) = (shared(), tempfile::tempdir().expect("a folder"));
    let files = ["manifest.toml", "histories.csv", "log.mcap"];
    for missing in files {
        let copy = place.path().join(missing);
        std::fs::create_dir(&copy).expect("a folder");
        for file in files.into_iter().filter(|file| *file != missing) {
            std::fs::copy(folder.join(file), copy.join(file)).expect("a copy");
        }
        let output = report(&[&copy]);
        let said = said(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(
            said.contains(missing) && said.contains("is missing") && said.contains("run the scene again"),
            "{said}"
        );
        assert!(!copy.join("report.html").exists());
    }
    let output = report(&[&place.path().join("nowhere")]);
    assert!(
        output.status.code() == Some(2) && said(&output).contains("give the folder of a run"),
        "{}",
        said(&output)
    );
    let output = report(&[folder, Path::new("--output"), &place.path().join("no/such/folder.html")]);
    assert!(
        output.status.code() == Some(1) && said(&output).contains("create the folder first"),
        "{}",
        said(&output)
    );
    // As a run that has only begun.
    std::fs::write(place.path().join("histories.csv/manifest.toml"), "").expect("written");
    std::fs::copy(folder.join("histories.csv"), place.path().join("histories.csv/histories.csv"))
        .expect("a copy");
    let output = report(&[&place.path().join("histories.csv")]);
    assert!(
        output.status.code() == Some(2) && said(&output).contains("run its scene again"),
        "{}",
        said(&output)
    );
}

#[test]
fn a_run_writes_its_report_unless_told_not_to_and_the_command_writes_the_same() {
    let scenario = short_scene();
    let folder = run(&scenario, "without", &["--no-report"]);
    assert!(folder.join("histories.csv").exists() && !folder.join("report.html").exists());
    let written = std::fs::read(shared().join("report.html")).expect("a page");
    let page = scenario.folder().join("again.html");
    let output = report(&[shared(), Path::new("--output"), &page]);
    assert!(output.status.success(), "{}", said(&output));
    assert!(std::fs::read(page).expect("a page") == written, "the page differs");
}

#[test]
fn a_run_that_fails_or_is_killed_shows_what_there_is() {
    let scenario = short_scene();
    let mut command = scenario.command("failed");
    for setting in
        ["tolerance=1e-13", "iteration_limit=2", "acceleration=constant", "measures=['displacement']"]
    {
        command.args(["--set", &format!("coupling.{setting}")]);
    }
    assert_eq!(command.args(["--transport", "in-process"]).output().expect("it runs").status.code(), Some(3));
    let page = Page::of(&scenario.folder().join("failed"));
    assert!(page.words.contains("Partial result") && page.words.contains("failed: step 1"), "{}", page.words);

    // As it is left by one that was killed: no result, a row and a log that are cut.
    let (whole, killed) = (shared(), scenario.folder().join("killed"));
    std::fs::create_dir(&killed).expect("a folder");
    let mut left = manifest(whole);
    left.remove("result");
    left.insert("status".to_owned(), "running".into());
    std::fs::write(killed.join("manifest.toml"), toml::to_string(&left).expect("TOML")).expect("written");
    for (file, share) in [("histories.csv", 0.7), ("log.mcap", 0.6)] {
        let bytes = std::fs::read(whole.join(file)).expect("a file");
        let end = (share * bytes.len() as f64) as usize;
        std::fs::write(killed.join(file), &bytes[..end]).expect("written");
    }
    std::fs::copy(whole.join("outline.csv"), killed.join("outline.csv")).expect("a copy");
    let output = report(&[&killed]);
    assert!(output.status.success(), "{}", said(&output));
    let page = Page::of(&killed);
    assert!(page.words.contains("Partial result") && page.words.contains("without an end"), "{}", page.words);
    let histories = Histories::read(&whole.join("histories.csv"));
    // The dam moves as long as there are histories; pressures are not there.
    let animation = &page.data()["animation"];
    let instants = animation["times"].as_array().expect("times").len();
    assert!(instants > 25 / 2 && instants < 25 * 8 / 10, "{instants}");
    assert_eq!(animation["waters"], serde_json::json!([]));
    let rows = page.data()["time"].as_array().expect("times").len();
    let whole = histories.column("time").len();
    assert!(rows > whole / 2 && rows < whole * 8 / 10, "{rows} of {whole}");
    let peak = histories.column("dam.crest_displacement.x")[..rows].iter().copied().fold(f64::MIN, f64::max);
    assert_eq!(page.figures[0].numbers[0], 1e3 * peak);
}

/// Dams and waters of other kinds: each page shows what its run has, and nothing else.
#[test]
fn other_scenes_have_the_sections_that_concern_them() {
    let mut tailwater = Scenario::shipped("koyna-tailwater");
    tailwater
        .set("dam.element_size", 15.0)
        .set("time.duration", 0.2)
        .set("reservoir.fidelity", "westergaard");
    tailwater.set("tailwater.fidelity", "westergaard");
    let page = Page::of(&run(&tailwater, "tailwater", &[]));
    assert!(
        page.words.contains("tailwater: peak base pressure") && page.ids.iter().any(|id| id == "pressure")
    );
    let waters = page.data()["animation"]["waters"].clone();
    assert!(waters[0]["downstream"] == false && waters[1]["downstream"] == true && waters[2].is_null());
    let kept = |page: &Page, name: &str| page.row("checks", name).cells[5] == "✓ passed";
    assert!(kept(&page, "static thrust") && kept(&page, "weight"), "{:?}", page.rows["checks"]);

    let mut empty = Scenario::quick(0.2);
    empty.set("reservoir.fidelity", "none").remove("coupling.scheme");
    let page = Page::of(&run(&empty, "empty", &[]));
    assert!(
        !page.ids.iter().any(|id| id == "pressure") && !page.words.contains("cavitate"),
        "{:?}",
        page.ids
    );
    assert!(kept(&page, "weight") && page.rows["checks"].iter().all(|row| !row.cells[0].contains("thrust")));
    assert_eq!(page.data()["animation"]["waters"], serde_json::json!([]));

    let page = Page::of(&run(&Scenario::shipped("rigid-dam-ramp"), "ramp", &[]));
    assert!(
        page.words.contains("prescribed") && page.ids.iter().any(|id| id == "pressure"),
        "{:?}",
        page.ids
    );
    // A motion that is prescribed has no dam to show.
    assert!(page.data()["animation"].is_null() && !page.ids.iter().any(|id| id == "motion"));
    assert!(!page.ids.iter().any(|id| id == "spectra") && !page.words.contains("Sliding of each crack"));
}
