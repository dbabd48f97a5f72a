//! The results of a run as text of at most 80 columns, for terminals and files.

use super::{Quantity, Subject, Summary};
use cofferdam_coupling::observer::{Status, WallTime};
use std::time::Duration;
use textwrap::{Options, WordSeparator, WordSplitter};

/// Columns of all text.
pub const COLUMNS: usize = 80;
/// Columns of a name; then follow the value in 10, the unit in 5 and a remark in 9 columns.
const NAME: usize = 51;

/// A text in lines of at most 80 columns, all but the first behind `indent`. Paths and options stay whole.
pub fn wrapped(text: &str, indent: &str) -> String {
    folded(text, COLUMNS, indent).join("\n")
}

fn folded(text: &str, columns: usize, indent: &str) -> Vec<String> {
    let options = Options::new(columns)
        .subsequent_indent(indent)
        .break_words(false)
        .word_separator(WordSeparator::AsciiSpace)
        .word_splitter(WordSplitter::NoHyphenation);
    textwrap::wrap(text, options).into_iter().map(|line| line.into_owned()).collect()
}

/// The table of a run: warnings and notes, the key figures, then all other quantities by subject.
pub fn table(summary: &Summary) -> String {
    let mut text = String::new();
    if summary.status != Status::Completed.to_string() {
        let partial =
            format!("PARTIAL RESULT up to t = {:.4} s, run {}", summary.simulated_time, summary.status);
        text += &(wrapped(&partial, "  ") + "\n");
    }
    for note in &summary.notes {
        text += &(wrapped(note, "  ") + "\n");
    }
    let first = summary.key_figures();
    if !text.is_empty() && !first.is_empty() {
        text += "\n";
    }
    first.iter().for_each(|quantity| text += &quantity_lines(quantity));
    for subject in Subject::ALL {
        let about = |quantity: &&Quantity| {
            quantity.subject == subject && !first.iter().any(|shown| shown.name == quantity.name)
        };
        let mut rest = summary.quantities.iter().filter(about).peekable();
        if rest.peek().is_some() {
            text += &heading(subject.title());
            rest.for_each(|quantity| text += &quantity_lines(quantity));
        }
    }
    text
}

/// Distribution of the wall time of a run.
pub fn wall_time(wall: &WallTime) -> String {
    let part = |name: &str, time: Duration| {
        let share = 100.0 * time.as_secs_f64() / wall.total.as_secs_f64().max(1e-9);
        line(&format!("  {name}"), &format!("{:.2}", time.as_secs_f64()), "s", &format!("{share:.0} %"))
    };
    let mut text = heading("Time") + &line("wall time", &format!("{:.2}", wall.total.as_secs_f64()), "s", "");
    wall.inside.iter().for_each(|(unit, time)| text += &part(unit, *time));
    for (name, time) in [
        ("exchange", wall.exchange()),
        ("log and histories", wall.observers),
        ("checkpoints", wall.checkpoints),
        ("initialisation", wall.initialisation),
    ] {
        text += &part(name, time);
    }
    text
}

/// A heading, after an empty line.
pub fn heading(title: &str) -> String {
    format!("\n{title}\n")
}

fn quantity_lines(quantity: &Quantity) -> String {
    let Quantity { name, value, unit, time, place, band, .. } = quantity;
    let unit = if unit == "1" { "" } else { unit };
    let time = time.map_or_else(String::new, |time| format!("{time:.3} s"));
    let mut text = line(name, &significant(*value), unit, &time);
    if let Some([x, y]) = place {
        text += &format!("    at x = {x} m, y = {y} m\n");
    }
    if let Some(band) = band {
        let [low, median, high] = band.map(significant);
        text += &format!("    replicates: 16 % {low}, median {median}, 84 % {high} {unit}\n");
    }
    text
}

/// A name, its value, its unit and a remark; a long name takes several lines.
fn line(name: &str, value: &str, unit: &str, beside: &str) -> String {
    let mut lines = folded(name, NAME, "  ");
    let last = lines.pop().unwrap_or_default();
    let mut text: String = lines.iter().map(|line| format!("  {line}\n")).collect();
    text += format!("  {last:<NAME$} {value:>10} {unit:<5} {beside:>9}").trim_end();
    text + "\n"
}

/// Four significant digits; counts have all digits.
fn significant(value: f64) -> String {
    if value.fract() == 0.0 && (10.0..1e7).contains(&value.abs()) {
        return format!("{value:.0}");
    }
    let digits = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    match digits {
        -5..4 => format!("{value:.*}", (3 - digits).max(0) as usize),
        _ => format!("{value:.3e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_all_digits_and_measures_four() {
        let shown = [24.0, 13_680.0, 13_680.5, -0.680_44, 1.0, 0.0].map(significant);
        assert_eq!(shown, ["24", "13680", "1.368e4", "-0.6804", "1.000", "0.000"]);
    }

    #[test]
    fn nothing_is_wider_than_a_terminal_and_every_number_stands_once() {
        let quantity = |name: &str, subject, value| Quantity {
            name: name.to_owned(),
            subject,
            value,
            unit: "rad/s".into(),
            time: Some(234.5678),
            place: Some([-123.456, 1234.567]),
            band: Some([-1.234_5e-10, -1.234_5e-20, 3.0]),
        };
        let long =
            "a quantity whose name is so long that it does not fit into the columns that it has, not nearly";
        let summary = Summary {
            status: "failed: something that is told at length, so that it does not fit into one line either"
                .into(),
            simulated_time: 1.0,
            notes: vec!["WARNING: words ".repeat(20), "a/path/that/stays/whole".into()],
            quantities: vec![
                quantity(long, Subject::Cracks, -1.234_5e-10),
                quantity("natural frequency 1", Subject::AtRest, 18.0),
                quantity("peak base shear", Subject::Base, 4.0),
            ],
        };
        let wall = WallTime { total: Duration::from_secs(123_456), ..WallTime::default() };
        let text = table(&summary) + &wall_time(&wall);
        for line in text.lines() {
            assert!(line.chars().count() <= COLUMNS && line.trim_end() == line, "{line:?}");
        }
        let at = |what: &str| {
            assert_eq!(text.matches(what).count(), 1, "{what} in\n{text}");
            text.find(what).expect("it is there")
        };
        assert!(at("peak base shear") < at("At rest") && at("At rest") < at("natural frequency 1"));
        assert!(at("natural frequency 1") < at("Cracks"), "{text}");
        at("-1.234e-10 rad/s");
        assert!(!text.contains("\nBase"), "its only number stands above: {text}");
        assert!(text.contains("a/path/that/stays/whole\n"));
    }
}
