//! Reduces rows and digits of histories and keeps their extremes.

use super::data::Rounded;

/// Number of parts of a history; minimum and maximum of each part are kept.
pub const PARTS: usize = 2000;
/// Digits of the largest value of a line; a line on a logarithmic scale has three of each value.
const DIGITS: i32 = 5;

/// The rows to keep of lines over the same `rows`: the first and the last, and of each of `parts` (at least 1) parts those with the least and
/// the largest finite value of any line.
pub fn kept(rows: usize, lines: &[&[f64]], parts: usize) -> Vec<usize> {
    let length = rows.div_ceil(parts.max(1)).max(1);
    if length <= 2 {
        return (0..rows).collect();
    }
    let mut keep = vec![false; rows];
    for part in (0..rows).step_by(length) {
        let range = part..(part + length).min(rows);
        for line in lines {
            let finite = || range.clone().filter(|row| line.get(*row).is_some_and(|value| value.is_finite()));
            let least = finite().reduce(|a, b| if line[b] < line[a] { b } else { a });
            let largest = finite().reduce(|a, b| if line[b] > line[a] { b } else { a });
            least.into_iter().chain(largest).for_each(|row| keep[row] = true);
        }
    }
    for end in [0, rows - 1] {
        keep[end] = true;
    }
    (0..rows).filter(|row| keep[*row]).collect()
}

/// The first row, then the differences from one to the next.
pub fn differences(rows: &[usize]) -> Vec<usize> {
    let first = rows.first().copied();
    first.into_iter().chain(rows.windows(2).map(|pair| pair[1] - pair[0])).collect()
}

/// Values with [`DIGITS`] digits of the largest.
pub fn rounded(values: &[f64]) -> Vec<Rounded> {
    let largest =
        values.iter().filter(|value| value.is_finite()).fold(0.0f64, |most, value| most.max(value.abs()));
    if largest == 0.0 {
        return values.iter().map(|value| Rounded(*value)).collect();
    }
    let places = DIGITS - 1 - largest.log10().floor() as i32;
    values.iter().map(|value| Rounded(to_places(*value, places))).collect()
}

/// Values with three digits each; none for what a logarithmic scale cannot show.
pub fn rounded_each(values: &[f64]) -> Vec<Rounded> {
    let of = |value: &f64| match *value > 0.0 {
        true => Rounded(to_places(*value, 2 - value.log10().floor() as i32)),
        false => Rounded(f64::NAN),
    };
    values.iter().map(of).collect()
}

/// `value` with so many decimal places. Division gives the double that is nearest to the decimal number, which is written shortest.
fn to_places(value: f64, places: i32) -> f64 {
    let power = 10f64.powi(places.abs());
    // No -0.
    0.0 + if places >= 0 { (value * power).round() / power } else { (value / power).round() * power }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kept_rows_hold_the_extremes_of_every_part_and_both_ends() {
        let rows = 100_003;
        let [a, b]: [Vec<f64>; 2] =
            [7919, 104_729].map(|prime| (0..rows).map(|i| ((i * prime) % 10_007) as f64).collect());
        let kept = kept(rows, &[&a, &b], PARTS);
        let length = rows.div_ceil(PARTS);
        assert!(kept.len() <= 4 * PARTS + 2 && kept.is_sorted_by(|a, b| a < b), "{} rows", kept.len());
        assert_eq!((kept[0], kept[kept.len() - 1]), (0, rows - 1));
        for line in [&a, &b] {
            for part in (0..rows).step_by(length) {
                let range = part..(part + length).min(rows);
                let extremes = |rows: &mut dyn Iterator<Item = usize>| {
                    rows.fold((f64::MAX, f64::MIN), |(a, b), row| (a.min(line[row]), b.max(line[row])))
                };
                let all = extremes(&mut range.clone());
                assert_eq!(extremes(&mut kept.iter().copied().filter(|row| range.contains(row))), all);
            }
        }
    }

    #[test]
    fn short_histories_stay_whole_and_gaps_are_no_extremes() {
        assert_eq!(kept(4000, &[&[0.0; 4000]], PARTS), (0..4000).collect::<Vec<_>>());
        assert!(kept(0, &[], PARTS).is_empty());
        let gaps: Vec<f64> = (0..9000).map(|i| if i % 5 == 3 { 1.0 } else { f64::NAN }).collect();
        let kept = kept(9000, &[&gaps], PARTS);
        assert!(kept[1..kept.len() - 1].iter().all(|row| row % 5 == 3), "{:?}", &kept[..5]);
    }

    #[test]
    fn numbers_are_written_short() -> Result<(), serde_json::Error> {
        let written = |values: &[Rounded]| serde_json::to_string(values);
        let values = [277.429_229_824, -0.000_01, 13.0, f64::NAN, 0.1 + 0.2];
        assert_eq!(written(&rounded(&values))?, "[277.43,0,13,null,0.3]");
        assert_eq!(written(&rounded(&[1.0e-9, 2.345_67e-9]))?, "[1e-9,2.3457e-9]");
        assert_eq!(written(&rounded(&[97_443_378.2, 4.9e3]))?, "[97443000,5000]");
        assert_eq!(
            written(&rounded_each(&[123_456.0, 0.001_234_5, 0.0, -1.0]))?,
            "[123000,0.00123,null,null]"
        );
        Ok(())
    }

    #[test]
    fn differences_add_up_to_the_rows() {
        assert_eq!(differences(&[3, 4, 9]), [3, 1, 5]);
        assert!(differences(&[]).is_empty());
    }
}
