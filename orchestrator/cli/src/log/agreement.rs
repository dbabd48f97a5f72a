//! The agreement of two runs as text.

use cofferdam_log::{Agreement, End, Event, Events, Measured};
use std::fmt::Write;

/// Variables that are listed, those with the largest differences.
const LISTED: usize = 12;

/// Whether something was compared, and nothing differs by more than `tolerance`.
pub fn within(agreement: &Agreement, tolerance: f64) -> bool {
    let compared = !agreement.ends.is_empty() && !agreement.variables.is_empty();
    compared && agreement.first_beyond(tolerance).is_none()
}

/// Text of the result.
pub fn report(agreement: &Agreement, tolerance: f64) -> String {
    let mut text = String::new();
    for setting in &agreement.settings {
        line(&mut text, "", &setting.to_string());
    }
    line(&mut text, "compared", &compared(agreement));
    for (index, apart) in agreement.apart.iter().enumerate() {
        line(&mut text, if index == 0 { "not compared" } else { "" }, apart);
    }
    for (name, ending) in ["a", "b"].into_iter().zip(&agreement.endings) {
        if let Some(ending) = ending.as_ref().filter(|ending| *ending != "completed") {
            line(&mut text, "", &format!("{name}: {ending}"));
        }
    }
    let largest = (0..agreement.ends.len()).filter_map(|end| agreement.largest(end)).map(|(_, d)| d);
    if largest.fold(0.0, f64::max) > 0.0 {
        beyond(&mut text, agreement, tolerance);
        growth(&mut text, agreement);
        variables(&mut text, agreement);
    }
    parted(&mut text, agreement);
    let verdict = match (within(agreement, tolerance), agreement.ends.len()) {
        (true, _) => format!("within {tolerance:e} at all {} ends", agreement.ends.len()),
        (false, 0) => {
            "nothing in common to compare: no step of one run ends with one of the other".to_owned()
        }
        (false, _) if agreement.variables.is_empty() => {
            "nothing in common to compare: no variable".to_owned()
        }
        (false, _) => format!("beyond {tolerance:e}"),
    };
    line(&mut text, "result", &verdict);
    text.truncate(text.trim_end().len());
    text
}

fn line(text: &mut String, name: &str, content: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{name:<12} {content}");
}

fn compared(agreement: &Agreement) -> String {
    let Agreement { steps: [a, b], ends, variables, .. } = agreement;
    format!("{} ends of steps of {a} in a, {b} in b; {} variables", ends.len(), variables.len())
}

/// The step of a compared end in words.
fn place(end: &End) -> String {
    let End { steps: [a, b], time } = end;
    let step = if a == b { format!("step {a}") } else { format!("step {a} in a, {b} in b") };
    format!("{step}, t = {time:.6} s")
}

fn beyond(text: &mut String, agreement: &Agreement, tolerance: f64) {
    let Some(first) = agreement.first_beyond(tolerance) else { return };
    let mut name = "beyond";
    let at = format!("in {}:", place(&agreement.ends[first]));
    line(text, name, &at);
    name = "";
    let mut over: Vec<_> = agreement.variables.iter().filter(|m| m.relative(first) > tolerance).collect();
    over.sort_by(|a, b| b.relative(first).total_cmp(&a.relative(first)));
    let listed = |measured: &&Measured| {
        format!("  {:<34} {:>9.2e}", element(measured, first), measured.relative(first))
    };
    over.iter().take(LISTED).map(listed).for_each(|content| line(text, name, &content));
    if over.len() > LISTED {
        line(text, name, &format!("  and {} more", over.len() - LISTED));
    }
}

/// A variable, with the index of its largest difference at `end`.
fn element(measured: &Measured, end: usize) -> String {
    let name = &measured.variable.name;
    if measured.variable.array { format!("{name}[{}]", measured.differences[end].1) } else { name.clone() }
}

fn growth(text: &mut String, agreement: &Agreement) {
    line(text, "growth", &format!("{:>8} {:>12} {:>10}  variable", "step", "t, s", "relative"));
    let entered = agreement.decades().into_iter().filter_map(|end| {
        let (measured, relative) = agreement.largest(end)?;
        (relative > 0.0).then_some((end, measured, relative))
    });
    let entered = entered.collect::<Vec<_>>();
    for (end, measured, relative) in &entered {
        let End { steps: [step, _], time } = agreement.ends[*end];
        let variable = element(measured, *end);
        line(text, "", &format!("{step:>8} {time:>12.6} {relative:>10.2e}  {variable}"));
    }
    if let (Some((first, _, least)), Some((last, _, most))) = (entered.first(), entered.last()) {
        let time = agreement.ends[*last].time - agreement.ends[*first].time;
        let decades = (most / least).log10();
        if time > 0.0 && decades > 0.0 {
            line(text, "", &format!("{decades:.1} decades in {time:.4} s: one in {:.4} s", time / decades));
        }
    }
    let mut so_far = 0.0_f64;
    let mut jump = (1.0, 0);
    for end in 0..agreement.ends.len() {
        let Some((_, relative)) = agreement.largest(end) else { return };
        if so_far > 0.0 && relative / so_far > jump.0 {
            jump = (relative / so_far, end);
        }
        so_far = so_far.max(relative);
    }
    if jump.0 > 1.0 {
        let at = place(&agreement.ends[jump.1]);
        line(text, "", &format!("most in one step: {:.3e} times what it was, in {at}", jump.0));
    }
}

fn variables(text: &mut String, agreement: &Agreement) {
    let mut ranked: Vec<_> = agreement.variables.iter().map(|m| (m, m.worst())).collect();
    ranked.retain(|(measured, end)| measured.relative(*end) > 0.0);
    ranked.sort_by(|(a, i), (b, j)| b.relative(*j).total_cmp(&a.relative(*i)));
    let head = format!("{:<34} {:>9} {:>10} {:>10}  where", "", "relative", "absolute", "magnitude");
    line(text, "variables", &head);
    for (measured, end) in &ranked {
        let content = format!(
            "{:<34} {:>9.2e} {:>10.2e} {:>10.2e}  {}; {}",
            element(measured, *end),
            measured.relative(*end),
            measured.differences[*end].0,
            measured.scale,
            measured.variable.unit,
            place(&agreement.ends[*end])
        );
        line(text, "", &content);
    }
    let same = agreement.variables.len() - ranked.len();
    if same > 0 {
        line(text, "", &format!("{same} variables are identical"));
    }
}

fn parted(text: &mut String, agreement: &Agreement) {
    let before = |end: usize| {
        (0..end).filter_map(|end| agreement.largest(end)).map(|(_, relative)| relative).fold(0.0, f64::max)
    };
    let Events { length, iterations, contacts } = &agreement.events;
    let kinds = [("lengths of steps", length), ("iterations", iterations), ("contacts", contacts)];
    for (index, (kind, event)) in kinds.into_iter().enumerate() {
        let content = match event {
            None => format!("{kind}: nowhere"),
            Some(Event { what, values: [a, b], end }) => {
                let (at, before) = (place(&agreement.ends[*end]), before(*end));
                format!("{kind}: in {at}: {what} {a} | {b}; relative difference before {before:.2e}")
            }
        };
        line(text, if index == 0 { "parted" } else { "" }, &content);
    }
}
