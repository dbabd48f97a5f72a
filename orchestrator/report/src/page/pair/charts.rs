//! Charts of two runs: a line of each.

use super::super::data::{Abscissa, Chart, Mark, Rounded, Series};
use super::super::thinning::{PARTS, differences, kept};
use super::data::{Beside, PairChart, PairGroup};

/// Names of the lines.
const NAMES: [&str; 2] = ["A", "B"];

/// The charts of A, each paired with that of B with the same title; then the charts only in B.
pub fn of([a, b]: [&[Chart]; 2]) -> Vec<PairGroup> {
    let find = |charts: &'_ [Chart], title: &str| charts.iter().position(|chart| chart.title == title);
    let only = b.iter().filter(|chart| find(a, &chart.title).is_none());
    let pairs = a.iter().map(|chart| [Some(chart), find(b, &chart.title).map(|index| &b[index])]);
    pairs.chain(only.map(|chart| [None, Some(chart)])).filter_map(group).collect()
}

fn group(pair: [Option<&Chart>; 2]) -> Option<PairGroup> {
    let whole = pair[0].or(pair[1])?;
    let lines = |index: usize| pair[index].map_or(&[][..], |chart| &chart.series);
    let mut pairs: Vec<[Option<&Series>; 2]> = match [lines(0), lines(1)] {
        // A different name, for example of a crack, does not make a different quantity.
        [[a], [b]] => vec![[Some(a), Some(b)]],
        [a, b] => {
            let of = |lines: &'_ [Series], name: &str| lines.iter().position(|line| line.name == name);
            let only = b.iter().filter(|line| of(a, &line.name).is_none()).map(|line| [None, Some(line)]);
            let both = a.iter().map(|line| [Some(line), of(b, &line.name).map(|index| &b[index])]);
            both.chain(only).collect()
        }
    };
    pairs.retain(|pair| pair.iter().flatten().next().is_some());
    let alone = pairs.len() == 1;
    let charts = pairs.into_iter().map(|lines| {
        let name = lines[0].or(lines[1]).map_or("", |line| &line.name);
        let renamed = matches!(lines, [Some(a), Some(b)] if a.name != b.name);
        let line = |index: usize| {
            let (chart, line) = (pair[index]?, lines[index]?);
            let (abscissa, values) = thinned(&chart.abscissa, &line.values);
            let name =
                if renamed { format!("{}, {}", NAMES[index], line.name) } else { NAMES[index].to_owned() };
            Some((abscissa, vec![Series { name, values }]))
        };
        let none = || (Abscissa::Rows(Vec::new()), Vec::new());
        let [(abscissa, series), (other, beside)] = [0, 1].map(|index| line(index).unwrap_or_else(none));
        PairChart {
            first: Chart {
                title: if alone { whole.title.clone() } else { name.to_owned() },
                about: only(&lines).to_owned(),
                abscissa,
                logarithmic: whole.logarithmic,
                range: range(pair),
                series,
                marks: marks(pair),
            },
            beside: Beside { abscissa: other, series: beside },
        }
    });
    Some(PairGroup { title: whole.title.clone(), about: whole.about.clone(), charts: charts.collect() })
}

/// Note on a line that only one run has.
fn only(lines: &[Option<&Series>; 2]) -> &'static str {
    match lines {
        [Some(_), None] => "In A only.",
        [None, Some(_)] => "In B only.",
        _ => "",
    }
}

/// The range of both.
fn range(pair: [Option<&Chart>; 2]) -> Option<[f64; 2]> {
    let of = |chart: &Chart| chart.range;
    match pair.map(|chart| chart.and_then(of)) {
        [Some(a), Some(b)] => Some([a[0].min(b[0]), a[1].max(b[1])]),
        [a, b] => a.or(b),
    }
}

/// The marks of both; common marks appear once.
fn marks(pair: [Option<&Chart>; 2]) -> Vec<Mark> {
    let [a, b] = pair.map(|chart| chart.map_or(&[][..], |chart| &chart.marks));
    let single = pair.iter().flatten().count() == 1;
    let both = a.iter().filter(|mark| single || b.contains(mark)).cloned();
    let own = |index: usize, own: &[Mark], other: &[Mark]| -> Vec<Mark> {
        let own = own.iter().filter(|mark| !single && !other.contains(mark));
        own.map(|mark| Mark { name: format!("{}: {}", NAMES[index], mark.name), ..mark.clone() }).collect()
    };
    let of_b = b.iter().filter(|_| single).cloned();
    both.chain(of_b).chain(own(0, a, b)).chain(own(1, b, a)).collect()
}

/// A line without the rows that were kept for other lines of its chart; its extremes are kept.
fn thinned(abscissa: &Abscissa, values: &[Rounded]) -> (Abscissa, Vec<Rounded>) {
    let plain: Vec<f64> = values.iter().map(|value| value.0).collect();
    let keep = kept(values.len(), &[&plain], PARTS);
    let at = |of: &[Rounded]| keep.iter().filter_map(|row| of.get(*row).copied()).collect();
    let abscissa = match abscissa {
        Abscissa::Rows(steps) => {
            let rows: Vec<usize> = steps
                .iter()
                .scan(0, |row, step| {
                    *row += step;
                    Some(*row)
                })
                .collect();
            let rows: Vec<usize> = keep.iter().filter_map(|row| rows.get(*row).copied()).collect();
            Abscissa::Rows(differences(&rows))
        }
        Abscissa::Times(times) => Abscissa::Times(at(times)),
        Abscissa::Periods(_) | Abscissa::Numbers { .. } => return (abscissa.clone(), values.to_vec()),
    };
    (abscissa, at(values))
}

#[cfg(test)]
mod tests {
    use super::*;

    type Named<'a> = (&'a str, fn(usize) -> f64);

    fn chart(title: &str, rows: usize, lines: &[Named<'_>]) -> Chart {
        let series = lines.iter().map(|(name, of)| Series {
            name: (*name).to_owned(),
            values: (0..rows).map(|row| Rounded(of(row))).collect(),
        });
        let abscissa = Abscissa::Rows(differences(&(0..rows).map(|row| 2 * row).collect::<Vec<_>>()));
        let series = series.collect();
        let (title, about) = (title.to_owned(), String::new());
        Chart { title, about, abscissa, logarithmic: false, range: None, series, marks: Vec::new() }
    }

    #[test]
    fn each_line_has_a_chart_and_its_extremes() {
        let wave: fn(usize) -> f64 = |row| ((row * 7919) % 10_007) as f64;
        let a = [chart("x", 50_000, &[("p", wave), ("q", |_| 1.0)]), chart("crack", 3, &[("low", |_| 2.0)])];
        let b = [chart("crack", 3, &[("high", |_| 3.0)]), chart("x", 5, &[("p", |_| 4.0), ("r", |_| 5.0)])];
        let groups = of([&a, &b]);
        assert_eq!(groups.iter().map(|group| group.charts.len()).collect::<Vec<_>>(), [3, 1]);
        let first = &groups[0].charts[0];
        let values: Vec<f64> = first.first.series[0].values.iter().map(|value| value.0).collect();
        let extreme = |of: fn(f64, f64) -> f64| values.iter().copied().reduce(of);
        assert_eq!((extreme(f64::min), extreme(f64::max)), (Some(0.0), Some(10_006.0)));
        let Abscissa::Rows(steps) = &first.first.abscissa else { panic!("rows") };
        assert!(steps.len() == values.len() && values.len() <= 4002, "{}", values.len());
        assert_eq!(steps.iter().sum::<usize>(), 2 * 49_999);
        assert_eq!((first.first.series[0].name.as_str(), first.beside.series[0].name.as_str()), ("A", "B"));
        let [_, q, r] = &groups[0].charts[..] else { panic!("three charts") };
        assert_eq!((&*q.first.about, q.beside.series.len()), ("In A only.", 0));
        assert_eq!((&*r.first.about, r.first.series.len()), ("In B only.", 0));
        let crack = &groups[1].charts[0];
        assert_eq!((&*crack.first.series[0].name, &*crack.beside.series[0].name), ("A, low", "B, high"));
    }
}
