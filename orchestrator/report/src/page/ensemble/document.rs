//! The page of an ensemble.

use super::super::document::{Page, Part, page};
use super::super::tables;
use super::data::EnsembleData;
use crate::known_digits;
use quick_xml::escape::escape;
use std::fmt::Write;

const STYLE: &str = include_str!("ensemble.css");
const SORTING: &str = include_str!("sorting.js");

/// The report of an ensemble as an HTML page, which is well-formed XML but for its scripts and styles, and loads nothing.
pub fn html(data: &EnsembleData) -> String {
    let source = "the files of the ensemble";
    let scripts = format!("<script>{SORTING}</script>\n");
    page(&Page { title: &data.title, style: STYLE, head: head(data), parts: parts(data), source, scripts })
}

fn head(data: &EnsembleData) -> String {
    let failed = data.runs - data.completed;
    let (state, status) = match failed {
        0 => ("complete", "all runs completed".to_owned()),
        failed => ("partial", format!("{failed} of {} runs failed", data.runs)),
    };
    let mut text = format!(
        "<header>\n<p class=\"kind\">Ensemble of earthquake analyses of a gravity dam</p>\n<h1>{}</h1>\n\
         <p class=\"state\"><span class=\"{state}\">{status}</span> <span>{}</span> <span>{} records</span></p>\n",
        escape(&data.title),
        escape(&data.scene),
        data.records.rows.len(),
    );
    text += "<div class=\"figures\">\n";
    let share = |count: usize, of: usize| {
        format!("{} <span>of</span> {}", tables::number(count as f64), tables::number(of as f64))
    };
    text += &card("runs completed", &share(data.completed, data.runs), "");
    text += &card("runs failed", &share(failed, data.runs), "excluded from the statistics");
    let still = "of the completed runs; they have no residual sliding";
    text += &card("runs with blocks still moving at the end", &share(data.moving, data.completed), still);
    for [quantity, joint, remark] in &data.governing_joints {
        text += &card(&format!("governing joint, {quantity}"), &escape(joint), &escape(remark));
    }
    for (limit, [median, dispersion]) in &data.curves {
        let name = format!("median {} at which {limit}", data.measure);
        let ([value, interval], [dispersion, of_dispersion]) = (known(median), known(dispersion));
        let remark = format!("95 %: {interval} g; dispersion {dispersion} ({of_dispersion})");
        text += &card(&name, &format!("{value} <span>g</span>"), &remark);
    }
    text += "</div>\n";
    for (class, title, sentences) in
        [("warnings", "Warnings", &data.warnings), ("limits", "What is not modelled", &data.not_modelled)]
    {
        if !sentences.is_empty() {
            let _ = write!(
                text,
                "<div class=\"box {class}\"><h2>{title}</h2>\n{}</div>\n",
                tables::list(sentences)
            );
        }
    }
    text + "</header>\n"
}

/// A number that matters first; `value` and `remark` are markup.
fn card(name: &str, value: &str, remark: &str) -> String {
    format!(
        "<div class=\"figure\"><p class=\"name\">{}</p><p class=\"value\">{value}</p><p class=\"when\">{remark}</p></div>\n",
        escape(name)
    )
}

/// A value and its interval with the digits that are known, and all of theirs in the markup.
fn known([value, low, high]: &[f64; 3]) -> [String; 2] {
    let texts = known_digits(*value, [*low, *high]);
    let [value, low, high] = [value, low, high].map(f64::to_string);
    let data = |exact: &str, shown: &str| format!("<data value=\"{exact}\">{shown}</data>");
    [data(&value, &texts[0]), format!("{} to {}", data(&low, &texts[1]), data(&high, &texts[2]))]
}

/// The sections that have content.
fn parts(data: &EnsembleData) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut add = |id: &'static str, title: &'static str, body: String| {
        if !body.is_empty() {
            parts.push(Part { id, title, body });
        }
    };
    let wide = |group| tables::group(group).replace("class=\"group\"", "class=\"group wide\"");
    let below = |title: &str, table: String| {
        if table.is_empty() { table } else { format!("<h3>{title}</h3>\n{table}") }
    };
    let plan = wide(&data.plan)
        + &below("Records", data.records.html("records"))
        + &below("Varied keys", data.varied.html("varied"));
    add("plan", "Plan", plan);
    add(
        "target",
        "Records and the target spectrum",
        picture(data.spectra.as_deref()) + &data.target.html("target"),
    );
    let about = "<p class=\"about\">Points: share of the runs that exceed the limit, with the exact (Clopper–Pearson) 95 % interval of \
                 independent records or pairs. Curve: penalised probit fit (Jeffreys’ prior) and its 95 % band by leaving out one record \
                 or pair at a time, only where the runs support it. Without a curve, low and high bracket the median by the exact \
                 intervals.</p>\n";
    let limits = data.limits.html("fits");
    let advice = data
        .advice
        .as_ref()
        .map_or_else(String::new, |advice| format!("<p class=\"about\">{}</p>\n", escape(advice)));
    let fragility = if limits.is_empty() { String::new() } else { about.to_owned() + &advice + &limits };
    let exceeding =
        below("Runs exceeding each limit, by level of shaking", data.exceedance.html("exceedance"));
    add(
        "fragility",
        "Probability of exceeding a limit",
        fragility + &picture(data.fragility.as_deref()) + &exceeding,
    );
    let about = "<p class=\"about\">Thin lines: one per ground motion and dam. Thick lines: 16, 50 and 84 % of the runs at each level.</p>\n";
    let analysis = picture(data.analysis.as_deref());
    add(
        "analysis",
        "Incremental dynamic analysis",
        if analysis.is_empty() { analysis } else { about.to_owned() + &analysis },
    );
    add("statistics", "Medians and spread", statistics(data));
    let about = "<p class=\"about\">Number of runs that each joint governs.</p>\n";
    let joints = data.joints.html("joints");
    add("joints", "Governing joint", if joints.is_empty() { joints } else { about.to_owned() + &joints });
    let about = "<p class=\"about\">Magnitude for each polarity (median of several runs); +1: positive accelerations point \
                 downstream.<span class=\"hint\"> Click a heading to sort.</span></p>\n";
    let polarities = data.polarities.html("polarities sortable");
    add(
        "polarities",
        "Governing polarity",
        if polarities.is_empty() { polarities } else { about.to_owned() + &polarities },
    );
    let about = "<p class=\"about\">Main effects at one level of shaking (Kelley’s ε²); the remainder is interaction and unexplained \
                 variance.</p>\n";
    let variance = data.variance.html("variance");
    add(
        "variance",
        "Sources of variance",
        if variance.is_empty() { variance } else { about.to_owned() + &variance },
    );
    let about = "<p class=\"about\">Ratios of medians for the same motions, with 90 % intervals; p values with Holm’s correction over all pairs of a quantity.</p>\n";
    let methods = data.methods.html("methods");
    add(
        "methods",
        "Comparison of methods",
        if methods.is_empty() { methods } else { about.to_owned() + &methods },
    );
    let about = "<p class=\"about\">Each file contains the results of its run.<span class=\"hint\"> Click a heading \
                 to sort.</span></p>\n";
    let results = data.results.html("results sortable");
    add("runs", "All runs", if results.is_empty() { results } else { about.to_owned() + &results });
    let plan = format!(
        "<details><summary>Plan as given</summary><pre>{}</pre></details>\n",
        escape(&data.plan_text)
    );
    add("provenance", "Provenance", wide(&data.provenance) + &plan);
    parts
}

fn statistics(data: &EnsembleData) -> String {
    let short = data.statistics.html("statistics");
    if short.is_empty() {
        return short;
    }
    format!(
        "<p class=\"about\">Completed runs that have the quantity. Low and high, if there are six records or pairs, are 95 % confidence \
         limits of the median (order statistics), with the number of records or pairs as the number of independent values.</p>\n{short}\
         <details><summary>All quantities</summary>\n{}</details>\n",
        data.all_statistics.html("statistics all")
    )
}

/// A picture of the folder.
fn picture(svg: Option<&str>) -> String {
    let Some(svg) = svg else { return String::new() };
    // Inside a page a picture needs no namespace.
    let svg = svg.replacen(" xmlns=\"http://www.w3.org/2000/svg\"", "", 1);
    format!("<figure class=\"curves\">{svg}</figure>\n")
}
