//! Numbers that the paper states, compared with ours.

use super::response::Quantity;
use super::runs::{FINITE_ELEMENTS, Run, Series};
use super::statements::Earthquake;
use cofferdam_analysis::table::Table;
use cofferdam_unit::number::plain;

/// A number of the text, and ours.
pub struct Number {
    pub figure: u8,
    /// The earthquake.
    pub name: &'static str,
    pub what: &'static str,
    pub unit: &'static str,
    pub paper: f64,
    pub ours: f64,
    /// Least and most over the open choices; none of a number that is not swept.
    pub range: Option<[f64; 2]>,
}

impl Number {
    /// Ours over the paper's − 1.
    pub fn difference(&self) -> f64 {
        self.ours / self.paper - 1.0
    }

    /// Whether an open choice reaches the paper's number.
    pub fn verdict(&self) -> &'static str {
        match self.range {
            None => "not swept",
            Some([least, _]) if self.paper < least => "below all of ours",
            Some([_, most]) if self.paper > most => "above all of ours",
            Some(_) => "within ours",
        }
    }

    /// Figure, earthquake and quantity.
    pub fn label(&self) -> String {
        let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
        format!("{} {}, {}, {}{unit}", self.figure, self.name, self.what, plain(self.paper))
    }
}

/// Takes a number from a run under a ground with a peak (g).
type Measure = fn(&Run, f64) -> f64;

/// All numbers that the paper states of an earthquake; `series` has run.
pub fn of(earthquake: &Earthquake, series: &Series) -> Vec<Number> {
    let Earthquake { name, of_accelerations, of_crest, .. } = *earthquake;
    let [below, above] = earthquake.accelerations;
    let [swing, time] = earthquake.first_swing;
    let [boundary, finite] = earthquake.sliding;
    let swept: [(u8, &'static str, &'static str, f64, Measure); 7] = [
        (of_accelerations, "largest acceleration below the crack", "g", below, |run, _| {
            run.response.peak(Quantity::Below)
        }),
        (of_accelerations, "largest acceleration above the crack", "g", above, |run, _| {
            run.response.peak(Quantity::Above)
        }),
        (
            of_accelerations,
            "below the crack over the ground's",
            "1",
            earthquake.amplification,
            |run, ground| run.response.peak(Quantity::Below) / ground,
        ),
        (of_crest, "first large crest displacement", "mm", swing, |run, _| run.response.first_swing()[0]),
        (of_crest, "its time", "s", time, |run, _| run.response.first_swing()[1]),
        (12, "residual sliding", "mm", boundary, |run, _| run.response.residual),
        (13, "largest rotation", "mrad", earthquake.rotation, |run, _| run.response.peak(Quantity::Rotation)),
    ];
    let ground = series.ground();
    let mut numbers: Vec<Number> = swept
        .into_iter()
        .map(|(figure, what, unit, paper, measure)| {
            let values = series.choices().map(|run| measure(run, ground));
            let range = values.fold([f64::MAX, f64::MIN], |[a, b], value| [a.min(value), b.max(value)]);
            let ours = measure(series.base(), ground);
            Number { figure, name, what, unit, paper, ours, range: Some(range) }
        })
        .collect();
    numbers.push(Number {
        figure: 12,
        name,
        what: "residual sliding, water of finite elements",
        unit: "mm",
        paper: finite,
        ours: series.run(FINITE_ELEMENTS).response.residual,
        range: None,
    });
    numbers.sort_by_key(|number| number.figure);
    numbers
}

pub fn table(numbers: &[Number]) -> Table {
    let mut table = Table::new([
        "figure",
        "earthquake",
        "quantity",
        "unit",
        "paper",
        "ours",
        "difference",
        "ours, least",
        "ours, most",
        "the paper's is",
    ]);
    for number in numbers {
        let [least, most] = number.range.map_or(["–".into(), "–".into()], |range| range.map(shown));
        table.row([
            number.figure.to_string(),
            number.name.to_owned(),
            number.what.to_owned(),
            number.unit.to_owned(),
            plain(number.paper),
            shown(number.ours),
            format!("{:+.0} %", 100.0 * number.difference()),
            least,
            most,
            number.verdict().to_owned(),
        ]);
    }
    table
}

/// A number with three digits behind the point.
pub fn shown(value: f64) -> String {
    format!("{value:.3}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_verdict_follows_from_the_range() {
        let of = |paper, range| {
            Number { figure: 12, name: "", what: "", unit: "", paper, ours: 2.0, range }.verdict()
        };
        assert_eq!(of(0.9, Some([1.0, 3.0])), "below all of ours");
        assert_eq!(of(1.0, Some([1.0, 3.0])), "within ours");
        assert_eq!(of(3.1, Some([1.0, 3.0])), "above all of ours");
        assert_eq!(of(2.0, None), "not swept");
    }
}
