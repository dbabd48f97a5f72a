//! The page of two runs.

use super::super::data::{Check, Row, Value};
use super::super::document::{Page, Part, page, scripts};
use super::super::number::shown;
use super::super::profile_picture::{Line, bounds, picture};
use super::super::tables;
use super::data::{Compared, Head, PairChart, PairData, PairGroup, PairProfile, Shared, Within};
use cofferdam_log::KeyDifference;
use quick_xml::escape::escape;
use serde::Serialize;
use std::fmt::Write;

const STYLE: &str = include_str!("pair.css");

/// Data of the script.
#[derive(Serialize)]
struct Drawn<'a> {
    time: &'a [f64],
    beside: &'a [f64],
    charts: Vec<&'a PairChart>,
}

/// Line samples of the runs.
const KEYS: [&str; 2] = [
    "<svg class=\"key\" viewBox=\"0 0 28 8\"><path class=\"first\" d=\"M0 4H28\"/></svg>",
    "<svg class=\"key\" viewBox=\"0 0 28 8\"><path class=\"second\" d=\"M0 4H28\"/></svg>",
];

/// The report of two runs as an HTML page, which is well-formed XML but for its scripts and styles, and loads nothing.
pub fn html(data: &PairData) -> String {
    let mut charts = Vec::new();
    let parts = parts(data, &mut charts);
    let [time, beside] = &data.times;
    let scripts = scripts(&Drawn { time, beside, charts });
    let title = titles(data).join(" – ");
    let source = "the files of the two runs. Charts: uPlot";
    page(&Page { title: &title, style: STYLE, head: head(data), parts, source, scripts })
}

/// The titles of both, or the one that both have.
fn titles(data: &PairData) -> Vec<&str> {
    let [a, b] = &data.runs;
    if a.title == b.title { vec![&a.title] } else { vec![&a.title, &b.title] }
}

fn head(data: &PairData) -> String {
    let mut text = String::from(
        "<header>\n<p class=\"kind\">Comparison of two earthquake analyses of a gravity dam</p>\n",
    );
    let titles: Vec<_> = titles(data).into_iter().map(escape).collect();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "<h1>{}</h1>\n<div class=\"runs\">", titles.join("<br/>"));
    for (index, run) in data.runs.iter().enumerate() {
        text += &of_run(index, run);
    }
    text += "</div>\n";
    for (name, run) in ["A", "B"].iter().zip(&data.runs).filter(|(_, run)| !run.complete) {
        let _ = writeln!(
            text,
            "<p class=\"alarm\">Partial result: run {name} did not reach its planned end ({}).</p>",
            escape(&run.status)
        );
    }
    if let Some(dams) = &data.dams {
        let _ = writeln!(
            text,
            "<p class=\"alarm\">The runs have different dams: {}. Differences between their results are not effects of a setting.</p>",
            escape(dams)
        );
    }
    text += "<div class=\"figures\">\n";
    text += &crest(data);
    data.key_figures.iter().for_each(|figure| text += &card(figure));
    text += "</div>\n";
    for (class, title, sentences) in [
        ("warnings", "Warnings", &data.warnings),
        ("limits", "What is not modelled", &data.not_modelled),
        ("notes", "Notes", &data.notes),
    ] {
        text += &shared(class, title, sentences);
    }
    text += "<noscript><p class=\"alarm\">The charts on this page need JavaScript; all tables and numbers are shown without it.</p></noscript>\n";
    text + "</header>\n"
}

fn of_run(index: usize, run: &Head) -> String {
    let state = if run.complete { "complete" } else { "partial" };
    let status = if run.complete { escape(&run.status) } else { "not complete".into() };
    let (name, role) = [("A", "reference"), ("B", "compared with A")][index];
    format!(
        "<div class=\"run\"><p class=\"name\">{}<b>{name}</b> {role}</p><p class=\"folder\"><code>{}</code></p><p>{}</p>\
         <p class=\"state\"><span class=\"{state}\">{status}</span> <span>{} s simulated</span> <span>run of {} UTC</span></p></div>\n",
        KEYS[index],
        escape(&run.folder),
        escape(&run.title),
        tables::number(run.simulated_time),
        escape(run.started.split('.').next().unwrap_or(&run.started).replace('T', " ").as_str()),
    )
}

/// Card with the difference of the crest histories.
fn crest(data: &PairData) -> String {
    let Some(crest) = &data.crest else {
        let reason = "no dam or no common instant";
        return format!(
            "<div class=\"figure crest\"><p class=\"name\">largest difference between the crest histories</p><p class=\"when\">not measured: {reason}</p></div>\n"
        );
    };
    let percent = 100.0 * crest.relative();
    format!(
        "<div class=\"figure crest\"><p class=\"name\">largest difference between the crest histories at common instants, over the largest displacement in either run</p>\
         <p class=\"value\"><data value=\"{percent}\">{}</data> <span>%</span></p>\
         <p class=\"when\">{} mm at {} s, of {} common instants</p></div>\n",
        shown(percent),
        tables::number(1e3 * crest.difference),
        tables::number(crest.time),
        tables::number(crest.instants as f64)
    )
}

/// A key figure.
fn card(figure: &Compared) -> String {
    let unit = tables::unit(&figure.unit);
    let mut text = format!("<div class=\"figure\"><p class=\"name\">{}</p>", escape(&figure.name));
    for (name, value) in ["A", "B"].iter().zip(figure.values) {
        let value = value
            .map_or_else(|| "–".to_owned(), |value| format!("{} <span>{unit}</span>", tables::number(value)));
        let _ = write!(text, "<p class=\"value\"><b>{name}</b> {value}</p>");
    }
    let difference = figure.difference().map(|difference| format!("B − A: {} {unit}", signed(difference)));
    let relative = figure.relative().map(|share| format!("{} %", signed(100.0 * share)));
    let band = figure.band.map(|band| within(&band));
    let said: Vec<String> = difference.into_iter().chain(relative).chain(band).collect();
    let _ = writeln!(text, "<p class=\"when\">{}</p></div>", said.join(", "));
    text
}

/// A difference with its sign.
fn signed(value: f64) -> String {
    let sign = if value > 0.0 { "+" } else { "" };
    format!("<data value=\"{value}\">{sign}{}</data>", shown(value))
}

/// Describes whether one run is within the band of the other.
fn within(Within { of, band: [low, _, high], kept }: &Within) -> String {
    let [own, other] = if *of == 0 { ["A", "B"] } else { ["B", "A"] };
    let lies = if *kept { "within" } else { "outside" };
    format!("{other} {lies} the band of {own} ({} to {})", tables::number(*low), tables::number(*high))
}

/// Sentences of both and of one, in a box.
fn shared(class: &str, title: &str, Shared { both, only: [a, b] }: &Shared) -> String {
    if both.is_empty() && a.is_empty() && b.is_empty() {
        return String::new();
    }
    let mut text = format!("<div class=\"box {class}\"><h2>{title}</h2>\n");
    for (whose, sentences) in [("Both runs", both), ("Run A only", a), ("Run B only", b)] {
        if !sentences.is_empty() {
            let _ = write!(text, "<h3>{whose}</h3>\n{}", tables::list(sentences));
        }
    }
    text + "</div>\n"
}

/// The sections that have content; their charts are added to `charts`.
fn parts<'a>(data: &'a PairData, charts: &mut Vec<&'a PairChart>) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut add = |id: &'static str, title: &'static str, body: String| {
        if !body.is_empty() {
            parts.push(Part { id, title, body });
        }
    };
    add("inputs", "Differences in the inputs", inputs(data));
    let histories = figures(&data.histories, charts);
    let hint = format!(
        "<p class=\"hint\">A {}, B {}. Drag across a chart to zoom; all charts over time follow. Double-click to show both runs. Each run is \
         drawn at its own instants.</p>\n",
        KEYS[0], KEYS[1]
    );
    add("histories", "Time histories", if histories.is_empty() { histories } else { hint + &histories });
    add("spectra", "Response spectra", figures(&data.spectra, charts));
    add("pressure", "Pressure over height", profiles(&data.profiles));
    add("table", "All results", quantities(&data.quantities));
    add("ground", "Ground motion", strengths(&data.ground) + &figures(&data.ground_charts, charts));
    add("checks", "Checks", checks(&data.checks));
    parts
}

fn inputs(data: &PairData) -> String {
    let mut text = String::new();
    for (name, settings) in [("Scene", &data.scene), ("Units, program and machine", &data.origin)] {
        if !settings.is_empty() {
            let _ = write!(text, "<h3>{name}</h3>\n{}", settings_table(settings));
        }
    }
    if data.scene.is_empty() && data.origin.is_empty() {
        text += "<p class=\"about\">No differences.</p>\n";
    }
    let equal: Vec<_> = data.equal.iter().map(escape).collect();
    text + &format!("<p class=\"about equal\"><b>Equal in both:</b> {}.</p>\n", equal.join("; "))
}

fn settings_table(settings: &[KeyDifference]) -> String {
    let mut text = String::from(
        "<table class=\"settings\"><thead><tr><th scope=\"col\">key</th><th scope=\"col\">A</th><th scope=\"col\">B</th></tr></thead><tbody>\n",
    );
    for KeyDifference { key, values } in settings {
        let value = |value: &Option<String>| match value {
            Some(value) => format!("<code>{}</code>", escape(value)),
            None => "<span class=\"remark\">not set</span>".to_owned(),
        };
        let [a, b] = values.each_ref().map(value);
        let _ = writeln!(
            text,
            "<tr><th scope=\"row\"><code>{}</code></th><td>{a}</td><td>{b}</td></tr>",
            escape(key)
        );
    }
    text + "</tbody></table>\n"
}

/// The strength of both ground motions.
fn strengths([a, b]: &[Vec<Row>; 2]) -> String {
    let only = b.iter().filter(|row| !a.iter().any(|other| other.name == row.name));
    let rows: Vec<Compared> = a
        .iter()
        .map(|row| [Some(row), b.iter().find(|other| other.name == row.name)])
        .chain(only.map(|row| [None, Some(row)]))
        .filter_map(|pair| {
            let number = |row: Option<&Row>| match row?.value {
                Value::Number(value, unit) => Some((value, unit)),
                Value::Text(_) | Value::Code(_) => None,
            };
            let numbers = pair.map(number);
            let unit = numbers[0].or(numbers[1])?.1.to_owned();
            let values = numbers.map(|number| number.map(|(value, _)| value));
            Some(Compared {
                name: pair[0].or(pair[1])?.name.clone(),
                unit,
                values,
                times: [None; 2],
                band: None,
            })
        })
        .collect();
    quantities(&rows).replace("class=\"quantities", "class=\"strengths")
}

/// Placeholders of charts, which the script fills.
fn figures<'a>(groups: &'a [PairGroup], charts: &mut Vec<&'a PairChart>) -> String {
    let mut text = String::new();
    for group in groups {
        let several = group.charts.len() > 1;
        let about = |about: &str| {
            if about.is_empty() { String::new() } else { format!(" <span>{}</span>", escape(about)) }
        };
        if several {
            let _ = writeln!(
                text,
                "<p class=\"group-title\"><b>{}</b>{}</p>\n<div class=\"pairs\">",
                escape(&group.title),
                about(&group.about)
            );
        }
        for chart in &group.charts {
            let of_group = if several { "" } else { &group.about };
            let _ = writeln!(
                text,
                "<figure class=\"chart\"><figcaption><b>{}</b>{}{}</figcaption><div data-chart=\"{}\"></div></figure>",
                escape(&chart.first.title),
                about(&chart.first.about),
                about(of_group),
                charts.len()
            );
            charts.push(chart);
        }
        if several {
            text += "</div>\n";
        }
    }
    text
}

fn profiles(profiles: &[PairProfile]) -> String {
    if profiles.is_empty() {
        return String::new();
    }
    let [largest, height] =
        bounds(profiles.iter().flat_map(|profile| profile.lines.iter().map(Vec::as_slice)));
    let mut text = format!(
        "<p class=\"about\">Hydrodynamic pressure from the logs at instants of run A (A {}, B {}).</p>\n<div class=\"profiles\">\n",
        KEYS[0], KEYS[1]
    );
    let several = profiles.iter().any(|profile| profile.water != profiles[0].water);
    for profile in profiles {
        let whose = if several { format!("{}: ", profile.water) } else { String::new() };
        let [a, b] = profile.times.map(|time| match time {
            Some(time) => format!("t = <data value=\"{time}\">{time:.4}</data> s"),
            None => "no pressure at this time".to_owned(),
        });
        let lines: [(&str, &Line); 2] = [("first", &profile.lines[0]), ("second", &profile.lines[1])];
        let lines: Vec<_> = lines.into_iter().filter(|(_, line)| !line.is_empty()).collect();
        let _ = writeln!(
            text,
            "<figure><figcaption><b>{whose}{}, run A</b> A: {a}; B: {b}</figcaption>{}</figure>",
            escape(&profile.instant),
            picture(&lines, height, largest)
        );
    }
    text + "</div>\n"
}

fn checks(checks: &[[Option<Check>; 2]]) -> String {
    if checks.is_empty() {
        return String::new();
    }
    let mut text = String::from(
        "<table class=\"checks\"><thead><tr><th scope=\"col\">check</th><th scope=\"col\" class=\"number\">A</th><th scope=\"col\">result of A</th>\
         <th scope=\"col\" class=\"number\">B</th><th scope=\"col\">result of B</th><th scope=\"col\">unit</th><th scope=\"col\">limit</th></tr></thead><tbody>\n",
    );
    for pair in checks {
        let Some(named) = pair[0].as_ref().or(pair[1].as_ref()) else { continue };
        let cells: String = pair.iter().map(verdict).collect();
        let limits: Vec<&str> = pair.iter().flatten().map(|check| &*check.limit).collect();
        let limit = match limits[..] {
            [a, b] if a != b => format!("A: {}; B: {}", escape(a), escape(b)),
            _ => escape(&named.limit).into_owned(),
        };
        let _ = writeln!(
            text,
            "<tr><th scope=\"row\">{}</th>{cells}<td class=\"unit\">{}</td><td>{limit}</td></tr>",
            escape(&named.name),
            tables::unit(named.unit)
        );
    }
    text + "</tbody></table>\n"
}

/// Value and verdict of a check.
fn verdict(check: &Option<Check>) -> String {
    let Some(check) = check else {
        return "<td class=\"number\">–</td><td class=\"remark\">not available</td>".to_owned();
    };
    let (class, verdict) = match check.kept {
        Some(true) => ("kept", "✓ passed"),
        Some(false) => ("broken", "✗ failed"),
        None => ("unjudged", "not judged"),
    };
    format!(
        "<td class=\"number\">{}</td><td class=\"{class}\"><span class=\"verdict\">{verdict}</span></td>",
        tables::number(check.found)
    )
}

/// Numbers of both runs with their differences.
fn quantities(rows: &[Compared]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let banded = rows.iter().any(|row| row.band.is_some());
    let timed = rows.iter().any(|row| row.times.iter().any(Option::is_some));
    let heading = |wanted: bool, text: &str| {
        if wanted { format!("<th scope=\"col\">{text}</th>") } else { String::new() }
    };
    let mut text = format!(
        "<div class=\"scroll\"><table class=\"quantities pair\"><thead><tr><th scope=\"col\">quantity</th><th scope=\"col\" class=\"number\">A</th>\
         <th scope=\"col\" class=\"number\">B</th><th scope=\"col\">unit</th><th scope=\"col\" class=\"number\">B − A</th>\
         <th scope=\"col\" class=\"number\">relative to |A|</th>{}{}</tr></thead><tbody>\n",
        heading(timed, "time"),
        heading(banded, "band of the replicates")
    );
    for row in rows {
        let value = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), tables::number);
        let [a, b] = row.values.map(value);
        let difference = row.difference().map_or_else(String::new, signed);
        let relative =
            row.relative().map_or_else(String::new, |share| format!("{} %", signed(100.0 * share)));
        let missing = match row.values {
            [Some(_), None] => " <small>in A only</small>",
            [None, Some(_)] => " <small>in B only</small>",
            _ => "",
        };
        let time = |time: Option<f64>| Some(format!("<data value=\"{0}\">{0:.3}</data>", time?));
        let times: Vec<String> = match row.times.map(time) {
            [Some(a), Some(b)] => vec![format!("{a}, {b} s")],
            [a, b] => a.or(b).map(|time| format!("{time} s")).into_iter().collect(),
        };
        let when =
            if timed { format!("<td class=\"remark\">{}</td>", times.concat()) } else { String::new() };
        let band = match &row.band {
            _ if !banded => String::new(),
            None => "<td></td>".to_owned(),
            Some(band) => format!("<td class=\"remark\">{}</td>", within(band)),
        };
        let _ = writeln!(
            text,
            "<tr><th scope=\"row\">{}{missing}</th><td class=\"number\">{a}</td><td class=\"number\">{b}</td><td class=\"unit\">{}</td>\
             <td class=\"number\">{difference}</td><td class=\"number\">{relative}</td>{when}{band}</tr>",
            escape(&row.name),
            tables::unit(&row.unit)
        );
    }
    text + "</tbody></table></div>\n"
}
