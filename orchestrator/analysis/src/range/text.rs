//! `range.md` and `range.csv`.

use super::plan::Part;
use super::results::Finished;
use super::setting::Factor;
use crate::table::Table;
use cofferdam_report::{FactorKind, RangeQuantity, RangeRecord, Setting, Swing};

/// Name of the figure of a quantity.
pub fn figure_name(quantity: &str) -> String {
    let kept: String = quantity.chars().map(|c| if c.is_alphanumeric() { c } else { ' ' }).collect();
    format!("range-{}.svg", kept.to_lowercase().split_whitespace().collect::<Vec<_>>().join("-"))
}

/// The text of a range of a `scene`.
pub fn markdown(range: &RangeRecord, scene: &str) -> String {
    let joint = match range.samples {
        0 => "one factor at a time".to_owned(),
        samples => format!(
            "one factor at a time, and {samples} runs of a Latin hypercube over all of them (seed {})",
            range.seed
        ),
    };
    let mut text = format!("**Range of {scene}**: {} runs, {joint}. {}.\n\n", range.runs, range.model);
    text += &summary(range).markdown();
    text += "\n";
    text += &meaning(range);
    for quantity in &range.quantities {
        let title = title(quantity);
        let value = with_unit(quantity, quantity.as_it_is);
        if quantity.varies() {
            text += &format!("\n**{title}**, as it is {value}\n\n{}", of_quantity(quantity).markdown());
        } else {
            text += &format!("\n**{title}**: {value} in all runs\n");
        }
    }
    text += "\n**Factors**\n\n";
    text += &factors(range).markdown();
    if !range.left_out.is_empty() {
        text += "\nLeft out:\n\n";
        for left_out in &range.left_out {
            text += &format!("- {}: {}\n", left_out.what, left_out.reason);
        }
    }
    if !range.failed.is_empty() {
        text +=
            &format!("\n**{} of {} runs failed** and are in no number:\n\n", range.failed.len(), range.runs);
        for failed in &range.failed {
            text += &format!("- {}: {}\n", failed.run, failed.cause);
        }
    }
    if !range.notes.is_empty() {
        text += "\nDoubtful:\n\n";
        range.notes.iter().for_each(|note| text += &format!("- {note}\n"));
    }
    text
}

fn title(quantity: &RangeQuantity) -> String {
    match quantity.unit.as_str() {
        "1" => quantity.name.clone(),
        unit => format!("{}, {unit}", quantity.name),
    }
}

fn with_unit(quantity: &RangeQuantity, value: f64) -> String {
    let shown = quantity.shown(value);
    if quantity.unit == "1" { shown } else { format!("{shown} {}", quantity.unit) }
}

/// All quantities, with an interval for each kind of spread and the combined one.
fn summary(range: &RangeRecord) -> Table {
    let has = |kind: &FactorKind| range.factors.iter().any(|factor| factor.kind == *kind);
    let kinds: Vec<FactorKind> = FactorKind::ALL.into_iter().filter(has).collect();
    let joint = range.samples > 0;
    let mut headings = vec!["quantity".to_owned(), "as it is".to_owned()];
    headings.extend(kinds.iter().map(|kind| kind.label().to_owned()));
    if joint {
        headings.extend(["all together, 5 to 95 %", "smallest to largest", "runs"].map(str::to_owned));
    }
    headings.push("dominated by".to_owned());
    let mut table = Table::new(headings);
    for quantity in &range.quantities {
        let mut cells = vec![title(quantity), quantity.shown(quantity.as_it_is)];
        let shown = |interval| quantity.shown_interval(interval);
        cells.extend(kinds.iter().map(|kind| quantity.interval_of(*kind).map_or_else(String::new, shown)));
        if joint {
            cells.extend(match &quantity.combined {
                Some(all) => [shown(all.interval), shown(all.extremes), all.runs.to_string()],
                None => ["", "", "0"].map(str::to_owned),
            });
        }
        let dominant = quantity.dominant();
        cells.push(match dominant.is_empty() {
            true if !quantity.varies() => "does not vary".to_owned(),
            true => "no factor stands out".to_owned(),
            false => dominant.join(", "),
        });
        table.row(cells);
    }
    table
}

/// What the columns of the summary mean.
fn meaning(range: &RangeRecord) -> String {
    let mut text = "Numerical error, perturbed motion, range of models and range of records: from the lowest to the highest value with one \
                    factor changed at a time. "
        .to_owned();
    if range.samples > 0 {
        let apart = range.factors.iter().filter(|factor| !factor.joint).map(|factor| &*factor.name);
        let apart: Vec<&str> = apart.collect();
        text += "All together: 5 and 95 % quantiles, smallest and largest value of the runs in which all factors vary at once, each equally \
                 likely over its range, with noise of its own on each motion";
        text += &match &apart[..] {
            [] => ". ".to_owned(),
            apart => format!(
                "; without {}, which multiply the cost and whose effect is in the column of the numerical error. ",
                apart.join(", ")
            ),
        };
        text += "Dominated by: factors that stand out from chance, with their shares of the variance of the ranks (adjusted R² of the \
                 rank regression on each factor); in the tables below, shares in parentheses do not stand out. What is left of 100 % \
                 are perturbed motion, interactions and chance. ";
    } else {
        text += "Dominated by: the factors with the largest swings. ";
    }
    text + "Numbers have the digits that their spread leaves.\n"
}

/// A quantity with one factor at a time, and the shares of the joint sample.
fn of_quantity(quantity: &RangeQuantity) -> Table {
    let shares = quantity.combined.as_ref().map(|all| &all.shares).filter(|shares| !shares.is_empty());
    let headings = ["factor", "what it is", "lowest", "with", "highest", "with", "change"];
    let mut table = Table::new(headings.into_iter().chain(shares.map(|_| "share of the variance")));
    for swing in &quantity.swings {
        let Swing { factor, kind, low, high } = swing;
        let mut cells = vec![factor.clone(), kind.label().to_owned()];
        let shown = |of: &Setting| [quantity.shown(of.value), of.setting.clone()];
        cells.extend(shown(low));
        cells.extend(if low == high { [String::new(), String::new()] } else { shown(high) });
        cells.push(change(quantity, swing));
        if let Some(shares) = shares {
            let share = shares.iter().find(|share| share.factor == *factor);
            cells.push(share.map_or_else(String::new, |share| {
                let percent = format!("{:.0} %", 100.0 * share.share);
                if share.significant { percent } else { format!("({percent})") }
            }));
        }
        table.row(cells);
    }
    table
}

/// How far a factor moves a quantity in both directions.
fn change(quantity: &RangeQuantity, swing: &Swing) -> String {
    let [low, high] = swing.interval(quantity.as_it_is);
    let base = quantity.as_it_is;
    match base.abs() > 1e-3 * low.abs().max(high.abs()) && low.is_finite() && high.is_finite() {
        true => {
            // No negative zero.
            let percent = |value: f64| (100.0 * (value - base) / base.abs()).round() + 0.0;
            format!("{:+.0} % to {:+.0} %", percent(low), percent(high))
        }
        // Per cent of next to nothing, or to where it slides away, say nothing.
        false => String::new(),
    }
}

/// The factors with their ranges and reasons.
fn factors(range: &RangeRecord) -> Table {
    let mut table = Table::new(["factor", "what it is", "range", "reason", "in the joint sample"]);
    for factor in &range.factors {
        let joint = if factor.joint && range.samples > 0 { "yes" } else { "no" };
        table.row([&factor.name, factor.kind.label(), &factor.range, &factor.reason, joint]);
    }
    table
}

/// A row for each run: its settings and its quantities, with all digits.
pub fn runs(factors: &[Factor], finished: &[Finished], range: &RangeRecord) -> Table {
    let named = |quantity: &RangeQuantity| match quantity.unit.as_str() {
        "1" => quantity.name.clone(),
        unit => format!("{} [{unit}]", quantity.name),
    };
    let headings = ["run", "part", "status"].map(str::to_owned).into_iter();
    let headings = headings.chain(factors.iter().map(|factor| factor.about.name.clone()));
    let mut table = Table::new(headings.chain(range.quantities.iter().map(named)));
    for (run, results) in finished {
        let part = match run.part {
            Part::AsItIs => "as it is",
            Part::Alone(_) => "one at a time",
            Part::Joint => "joint",
        };
        let status = if results.is_some() { "completed" } else { "failed" };
        let mut cells = vec![run.name.clone(), part.to_owned(), status.to_owned()];
        cells.extend(
            factors.iter().zip(&run.coordinates).map(|(factor, coordinate)| factor.shown(coordinate)),
        );
        cells.extend(range.quantities.iter().map(|quantity| {
            let value = results.as_ref().map_or(f64::NAN, |results| results.value(&quantity.name));
            if value.is_nan() { String::new() } else { value.to_string() }
        }));
        table.row(cells);
    }
    table
}
