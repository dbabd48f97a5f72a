//! The page.

use super::super::{Quantity, Subject};
use super::data::{Animation, Chart, Envelope, Profile, ReportData};
use super::number::shown;
use super::profile_picture::{bounds, lines, picture};
use super::tables;
use quick_xml::escape::escape;
use serde::Serialize;
use std::fmt::Write;

const CHARTS: &str = include_str!("uplot/uPlot.iife.min.js");
const CHARTS_STYLE: &str = include_str!("uplot/uPlot.min.css");
const CHARTS_LICENCE: &str = include_str!("uplot/LICENSE");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
const ANIMATION: &str = include_str!("animation.js");

/// Charts are pixels: they are drawn with twice those of the screen, so that they are sharp on paper.
const SHARP: &str = "if (devicePixelRatio < 2) Object.defineProperty(window, \"devicePixelRatio\", { value: 2, configurable: true });";

/// Nothing but what is in the page is ever loaded.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// What the script draws.
#[derive(Serialize)]
struct Drawn<'a> {
    time: &'a [f64],
    charts: Vec<&'a Chart>,
    #[serde(skip_serializing_if = "Option::is_none")]
    animation: Option<&'a Animation>,
}

/// A section of the page.
pub(super) struct Part {
    pub id: &'static str,
    pub title: &'static str,
    pub body: String,
}

/// A page around its sections.
pub(super) struct Page<'a> {
    /// What the browser's tab says.
    pub title: &'a str,
    /// Rules beside those of all pages.
    pub style: &'static str,
    /// What stands above the sections.
    pub head: String,
    /// The sections.
    pub parts: Vec<Part>,
    /// From what it is made.
    pub source: &'static str,
    /// The scripts, with their tags.
    pub scripts: String,
}

/// The report as an HTML page, which is well-formed XML but for its scripts and styles, and loads nothing.
pub fn html(data: &ReportData) -> String {
    let mut charts = Vec::new();
    let parts = parts(data, &mut charts);
    let animation = data.animation.as_ref();
    let mut scripts = scripts(&Drawn { time: &data.time, charts, animation });
    if animation.is_some() {
        // Writing to a string cannot fail.
        let _ = writeln!(scripts, "<script>{ANIMATION}</script>");
    }
    let (title, head) = (&*data.title, head(data));
    page(&Page { title, style: "", head, parts, source: "the files of the run. Charts: uPlot", scripts })
}

/// The page as HTML.
pub(super) fn page(page: &Page<'_>) -> String {
    let Page { title, style, head, parts, source, scripts } = page;
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{}</title>\n\
         <style>{CHARTS_STYLE}\n{STYLE}{style}</style>\n</head>\n<body>\n<main>\n",
        escape(*title)
    );
    text += head;
    text += "<nav>";
    for (number, part) in parts.iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = write!(text, "<a href=\"#{}\">{} {}</a>", part.id, number + 1, part.title);
    }
    text += "</nav>\n";
    for (number, part) in parts.iter().enumerate() {
        let _ = writeln!(
            text,
            "<section id=\"{}\" class=\"part\">\n<h2><span>{}</span> {}</h2>\n{}</section>",
            part.id,
            number + 1,
            part.title,
            part.body
        );
    }
    let _ = write!(
        text,
        "<footer>Made by cofferdam {} from {source}.</footer>\n</main>\n{scripts}</body>\n</html>\n",
        env!("CARGO_PKG_VERSION")
    );
    text
}

/// The scripts that draw charts, with their data.
pub(super) fn scripts(drawn: &impl Serialize) -> String {
    // Plain values in plain structures can be written.
    let json = serde_json::to_string(drawn).unwrap_or_default();
    let json = json.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026");
    format!(
        "<script type=\"application/json\" id=\"data\">{json}</script>\n\
         <script>{SHARP}\n{CHARTS}\n/*\n{CHARTS_LICENCE}\n*/</script>\n<script>{SCRIPT}</script>\n"
    )
}

/// Title, status and what matters first.
fn head(data: &ReportData) -> String {
    let state = if data.complete { "complete" } else { "partial" };
    let mut text = format!(
        "<header>\n<p class=\"kind\">Earthquake analysis of a gravity dam</p>\n<h1>{}</h1>\n\
         <p class=\"state\"><span class=\"{state}\">{}</span> <span>{} s simulated</span> <span>{}</span> <span>run of {} UTC</span></p>\n",
        escape(&data.title),
        escape(&data.status),
        tables::number(data.simulated_time),
        escape(&data.name),
        escape(data.started.split('.').next().unwrap_or(&data.started).replace('T', " ").as_str()),
    );
    if !data.complete {
        text += "<p class=\"alarm\">Partial result: the run did not come to its planned end.</p>\n";
    }
    text += "<div class=\"figures\">\n";
    data.key_figures.iter().for_each(|quantity| text += &figure(quantity));
    text += "</div>\n";
    for (class, title, sentences) in [
        ("warnings", "Warnings", &data.warnings),
        ("limits", "What is not modelled", &data.not_modelled),
        ("notes", "Notes", &data.notes),
    ] {
        if !sentences.is_empty() {
            let _ = write!(
                text,
                "<div class=\"box {class}\"><h2>{title}</h2>\n{}</div>\n",
                tables::list(sentences)
            );
        }
    }
    text += "<noscript><p class=\"alarm\">The charts of this page need JavaScript. All tables and numbers are shown without it.</p></noscript>\n";
    text + "</header>\n"
}

/// A number that matters first.
fn figure(quantity: &Quantity) -> String {
    format!(
        "<div class=\"figure\"><p class=\"name\">{}</p><p class=\"value\"><data value=\"{}\">{}</data> <span>{}</span></p>\
         {}</div>\n",
        escape(&quantity.name),
        quantity.value,
        shown(quantity.value),
        tables::unit(&quantity.unit),
        [tables::occasion(quantity), range(quantity)]
            .iter()
            .filter(|said| !said.is_empty())
            .map(|said| format!("<p class=\"when\">{said}</p>"))
            .collect::<String>()
    )
}

/// How far a number that matters first can be trusted: its band, or that it is one realisation.
fn range(quantity: &Quantity) -> String {
    match quantity.band {
        Some([low, median, high]) => format!(
            "replicates: 16 % <data value=\"{low}\">{}</data>, median <data value=\"{median}\">{}</data>, 84 % <data value=\"{high}\">{}</data>",
            shown(low),
            shown(median),
            shown(high)
        ),
        None if quantity.subject == Subject::Cracks => {
            "one realisation: quote a range, with the damping".to_owned()
        }
        None if quantity.name.starts_with("largest tension") => {
            "in corners it grows with a finer mesh".to_owned()
        }
        None => String::new(),
    }
}

/// The sections that have content; their charts are added to `charts`.
fn parts<'a>(data: &'a ReportData, charts: &mut Vec<&'a Chart>) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut add = |id: &'static str, title: &'static str, body: String| {
        if !body.is_empty() {
            parts.push(Part { id, title, body });
        }
    };
    let section = data.section.as_ref().map(|svg| {
        // Inside a page a picture needs no namespace.
        let svg = svg.replacen(" xmlns=\"http://www.w3.org/2000/svg\"", "", 1);
        format!("<figure class=\"section\">{svg}</figure>\n")
    });
    add("picture", "Section of the dam", section.unwrap_or_default());
    add("motion", "The dam in motion", data.animation.as_ref().map_or_else(String::new, motion));
    add("inputs", "Inputs", inputs(data));
    add("ground", "Ground motion", tables::results(&data.ground) + &figures(&data.ground_charts, charts));
    add("histories", "Histories", histories(data, charts));
    add("envelope", "Largest principal stress", data.envelope.as_ref().map_or_else(String::new, envelope));
    add("spectra", "Response spectra", figures(&data.spectra, charts));
    add("pressure", "Pressure over height", profiles(&data.profiles));
    add(
        "checks",
        "Checks",
        if data.checks.is_empty() { String::new() } else { tables::checks(&data.checks) },
    );
    add("table", "All results", tables::quantities(&data.quantities));
    parts
}

/// The place of the dam in motion, which the script fills.
fn motion(animation: &Animation) -> String {
    let between = animation.times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    let pressure = if animation.waters.is_empty() {
        ""
    } else {
        " Beside it the hydrodynamic pressure: blue presses on the dam, orange relieves it."
    };
    format!(
        "<p class=\"about\">Displacement since the state of rest, magnified; dashed: unloaded.{pressure} Recorded every {} ms or less, in \
         between interpolated; numbers are those of the nearest record. A click in a chart over time leads here.</p>\n\
         <figure id=\"dam-in-motion\"><canvas role=\"img\" aria-label=\"The dam in motion\"></canvas>\
         <figcaption class=\"controls\"><button type=\"button\" class=\"play\">Play</button>\
         <input class=\"instant\" type=\"range\" aria-label=\"instant\"/>\
         <label>speed <select class=\"speed\"><option value=\"1\">as it was</option><option value=\"0.5\">half</option>\
         <option value=\"0.1\">a tenth</option></select></label>\
         <label>motion <select class=\"magnification\"></select></label></figcaption>\
         <p><time></time> <span class=\"readings\"></span></p></figure>\n",
        tables::number((1e4 * between).round() / 10.0)
    )
}

/// The section coloured by the largest principal stress, and by how much it is too much.
fn envelope(envelope: &Envelope) -> String {
    let compared = if envelope.rows.is_empty() {
        "With <code>dam.material.tensile_strength</code> it is compared with a strength."
    } else {
        "The concrete does not crack here: where it is overstressed, real concrete may. Demand-capacity ratio, area and time are those by \
         which linear analyses are judged (USACE EM 1110-2-6051, 6053)."
    };
    format!(
        "<p class=\"about\">At each point the largest over time, tension positive, static stress included, from 0 to {} s, at the end of \
         every communication step. {compared} In corners of an elastic body it grows without limit as the mesh is refined.</p>\n{}\
         <figure class=\"section\">{}</figure>\n",
        tables::number(envelope.end),
        tables::results(&envelope.rows),
        envelope.picture
    )
}

fn inputs(data: &ReportData) -> String {
    let mut text = String::from("<div class=\"groups\">\n");
    data.inputs.iter().for_each(|group| text += &tables::group(group));
    text += "</div>\n";
    text += &tables::group(&data.provenance).replace("class=\"group\"", "class=\"group wide\"");
    let _ = writeln!(
        text,
        "<details><summary>The scene with all defaults, as it was run</summary><pre>{}</pre></details>",
        escape(&data.scene)
    );
    text
}

fn histories<'a>(data: &'a ReportData, charts: &mut Vec<&'a Chart>) -> String {
    if data.histories.is_empty() {
        return String::new();
    }
    let mut text = String::from(
        "<p class=\"hint\">Drag across a chart to zoom in; all charts follow. A double click shows the whole run again.</p>\n",
    );
    text += &figures(&data.histories, charts);
    if !data.sliding_times.is_empty() {
        text += "<h3>Time at a safety of 1 or below: the joint slides</h3>\n";
        text += &tables::results(&data.sliding_times);
    }
    text
}

/// Places for charts, which the script fills.
fn figures<'a>(of: &'a [Chart], charts: &mut Vec<&'a Chart>) -> String {
    let mut text = String::new();
    for chart in of {
        let about = if chart.about.is_empty() {
            String::new()
        } else {
            format!(" <span>{}</span>", escape(&chart.about))
        };
        let _ = writeln!(
            text,
            "<figure class=\"chart\"><figcaption><b>{}</b>{about}</figcaption><div data-chart=\"{}\"></div></figure>",
            escape(&chart.title),
            charts.len()
        );
        charts.push(chart);
    }
    text
}

fn profiles(profiles: &[Profile]) -> String {
    if profiles.is_empty() {
        return String::new();
    }
    let [largest, height] =
        bounds(profiles.iter().flat_map(|profile| [&*profile.computed, &profile.westergaard]));
    let mut text = String::from(
        "<p class=\"about\">Hydrodynamic pressure from the log (<svg class=\"key\" viewBox=\"0 0 28 8\"><path class=\"computed\" d=\"M0 4H28\"/></svg> \
         computed), beside Westergaard's parabola ⅞ ρ a √(h (h − y)) for the acceleration a of the ground at that instant \
         (<svg class=\"key\" viewBox=\"0 0 28 8\"><path class=\"westergaard\" d=\"M0 4H28\"/></svg>). The parabola belongs to a rigid dam in \
         incompressible water: a dam that amplifies the ground motion presses harder, and at another time.</p>\n<div class=\"profiles\">\n",
    );
    let several = profiles.iter().any(|profile| profile.water != profiles[0].water);
    for profile in profiles {
        let whose = if several { format!("{}: ", profile.water) } else { String::new() };
        let _ = writeln!(
            text,
            "<figure><figcaption><b>{whose}{}</b> t = <data value=\"{}\">{:.4}</data> s, ground {} m/s²</figcaption>{}</figure>",
            escape(&profile.instant),
            profile.time,
            profile.time,
            tables::number(profile.ground_acceleration),
            picture(&lines(profile), height, largest)
        );
    }
    text + "</div>\n"
}
