//! Comparison of numbers, checks and crests of two runs.

use super::super::super::{Quantity, has_both_directions};
use super::super::data::Check;
use super::data::{Compared, CrestAgreement, Within};
use cofferdam_assembly::observer::Histories;
use cofferdam_log::ROUNDING;

/// Quantities by name and unit: first those of A in order, then those only in B.
pub fn of([a, b]: [&[Quantity]; 2]) -> Vec<Compared> {
    let same = |one: &Quantity, other: &Quantity| one.name == other.name && one.unit == other.unit;
    let only = b.iter().filter(|quantity| !a.iter().any(|other| same(quantity, other)));
    let pairs = a.iter().map(|quantity| [Some(quantity), b.iter().find(|other| same(quantity, other))]);
    pairs.chain(only.map(|quantity| [None, Some(quantity)])).filter_map(compared).collect()
}

fn compared(pair: [Option<&Quantity>; 2]) -> Option<Compared> {
    let named = pair[0].or(pair[1])?;
    let band = |of: usize| {
        let (own, other) = (pair[of]?, pair[1 - of]?.value);
        let band = own.band?;
        // as its band: in the direction of the run's value
        let both = has_both_directions(&own.name, [own.value, other].into_iter());
        let other = if both { other.abs().copysign(own.value) } else { other };
        Some(Within { of, band, kept: (band[0]..=band[2]).contains(&other) })
    };
    Some(Compared {
        name: named.name.clone(),
        unit: named.unit.to_string(),
        values: pair.map(|quantity| quantity.map(|quantity| quantity.value)),
        times: pair.map(|quantity| quantity?.time),
        band: band(0).or_else(|| band(1)),
    })
}

/// Checks by their names, as quantities.
pub fn checks([a, b]: [&[Check]; 2]) -> Vec<[Option<Check>; 2]> {
    let of = |checks: &[Check], name: &str| checks.iter().find(|check| check.name == name).cloned();
    let only = b.iter().filter(|check| of(a, &check.name).is_none());
    let pairs = a.iter().map(|check| [Some(check.clone()), of(b, &check.name)]);
    pairs.chain(only.map(|check| [None, Some(check.clone())])).collect()
}

/// Difference of the crests, measured as in [`Agreement`](cofferdam_log::Agreement) at the ends of steps that both
/// runs have.
pub fn crest(runs: [&Histories; 2]) -> Option<CrestAgreement> {
    let mut found: Option<CrestAgreement> = None;
    let instants = common(runs.map(|run| run.column("time").unwrap_or(&[])));
    for component in ["x", "y"] {
        let [a, b] = runs.map(|run| run.column(&format!("dam.crest_displacement.{component}")));
        let (Some(a), Some(b), Some(time)) = (a, b, runs[0].column("time")) else { continue };
        for [i, j] in &instants {
            let (a, b) = (a[*i], b[*j]);
            let difference = if (a - b).is_nan() { f64::INFINITY } else { (a - b).abs() };
            let so_far = found.get_or_insert(CrestAgreement {
                difference: 0.0,
                scale: 0.0,
                time: time[*i],
                instants: instants.len(),
            });
            so_far.scale = so_far.scale.max(a.abs()).max(b.abs());
            if difference > so_far.difference {
                (so_far.difference, so_far.time) = (difference, time[*i]);
            }
        }
    }
    found
}

/// Rows of common instants, except for rounding.
fn common([a, b]: [&[f64]; 2]) -> Vec<[usize; 2]> {
    let length = |times: &[f64], row: usize| match row {
        0 => times.get(1).map_or(f64::INFINITY, |second| second - times[0]),
        _ => times[row] - times[row - 1],
    };
    let (mut i, mut j, mut rows) = (0, 0, Vec::new());
    while i < a.len() && j < b.len() {
        if (a[i] - b[j]).abs() <= ROUNDING * length(a, i).min(length(b, j)) {
            rows.push([i, j]);
            (i, j) = (i + 1, j + 1);
        } else if a[i] < b[j] {
            i += 1;
        } else {
            j += 1;
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quantity(name: &str, value: f64, band: Option<[f64; 3]>) -> Quantity {
        Quantity { name: name.into(), value, unit: "mm".into(), band, ..Quantity::default() }
    }

    #[test]
    fn differences_are_of_b_less_a_and_rows_of_one_run_stay() {
        let a = [quantity("x", -2.0, Some([1.0, 2.0, 3.0])), quantity("y", 0.0, None)];
        let b =
            [quantity("z", 7.0, None), quantity("y", 1.0, Some([-1.0, 0.5, 2.0])), quantity("x", 1.0, None)];
        let rows = of([&a, &b]);
        assert_eq!(rows.iter().map(|row| &*row.name).collect::<Vec<_>>(), ["x", "y", "z"]);
        assert_eq!((rows[0].difference(), rows[0].relative()), (Some(3.0), Some(1.5)));
        assert_eq!(rows[0].band, Some(Within { of: 0, band: [1.0, 2.0, 3.0], kept: true }));
        assert_eq!((rows[1].difference(), rows[1].relative()), (Some(1.0), None));
        assert_eq!(rows[1].band, Some(Within { of: 1, band: [-1.0, 0.5, 2.0], kept: true }));
        assert_eq!((rows[2].values, rows[2].difference()), ([None, Some(7.0)], None));
    }

    #[test]
    fn a_peak_of_the_other_direction_is_compared_by_its_magnitude() {
        let a = [quantity("peak crest acceleration", -0.95, Some([-1.1, -0.95, -0.85]))];
        for (other, kept) in [(0.95, true), (-0.95, true), (0.7, false), (-1.2, false)] {
            let rows = of([&a, &[quantity("peak crest acceleration", other, None)]]);
            assert_eq!(rows[0].band, Some(Within { of: 0, band: [-1.1, -0.95, -0.85], kept }), "{other}");
        }
    }

    #[test]
    fn instants_of_other_steps_are_found_but_for_rounding() {
        let a = [0.0, 0.1, 0.2, 0.3, 0.4];
        let b = [0.0, 0.2 + 1e-12, 0.35, 0.4, 0.6];
        assert_eq!(common([&a, &b]), [[0, 0], [2, 1], [4, 3]]);
        assert!(common([&a, &[0.05, 0.15]]).is_empty() && common([&a, &[]]).is_empty());
    }
}
