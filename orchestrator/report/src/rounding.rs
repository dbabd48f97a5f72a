//! Numbers with the digits that are known.

/// A value and the ends of its interval, all with the last digit that half the width of the interval leaves certain: 0.3127 between 0.2412 and
/// 0.4159 is 0.31 between 0.24 and 0.42.
pub fn known_digits(value: f64, [low, high]: [f64; 2]) -> [String; 3] {
    let half = (high - low).abs() / 2.0;
    let all = [value, low, high];
    if !(half > 0.0 && half.is_finite()) {
        return all.map(|value| significant(value, 3));
    }
    let place = half.log10().floor() as i32;
    all.map(|value| at_place(value, place))
}

/// A share in per cent: two significant digits below 10 % and above 99 %, whole otherwise.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        _ if !percent.is_finite() => String::new(),
        0.0 | 100.0 => format!("{percent:.0}"),
        _ if percent < 9.95 => significant(percent, 2),
        _ if percent > 99.0 => format!("{percent:.1}"),
        _ => format!("{percent:.0}"),
    }
}

/// So many significant digits.
fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    at_place(value, value.abs().log10().floor() as i32 + 1 - digits)
}

/// Rounded to a multiple of 10 to the power of `place`.
fn at_place(value: f64, place: i32) -> String {
    if place >= 0 {
        let unit = 10f64.powi(place);
        format!("{:.0}", (value / unit).round() * unit)
    } else {
        format!("{value:.*}", (-place) as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_end_where_the_interval_leaves_them_open() {
        for (value, interval, wanted) in [
            (0.3127, [0.2412, 0.4159], ["0.31", "0.24", "0.42"]),
            (0.158, [0.0016, 0.158], ["0.16", "0.00", "0.16"]),
            (1234.5, [1100.0, 1399.0], ["1200", "1100", "1400"]),
            (12.0, [3.0, 57.0], ["10", "0", "60"]),
            (0.1, [0.1, 0.1], ["0.100", "0.100", "0.100"]),
        ] {
            assert_eq!(known_digits(value, interval), wanted, "{value} {interval:?}");
        }
    }

    #[test]
    fn shares_are_rounded() {
        let found = [0.0, 0.003_16, 0.0312, 0.124, 0.5265, 0.996_8, 1.0, f64::NAN].map(percent);
        assert_eq!(found, ["0", "0.32", "3.1", "12", "53", "99.7", "100", ""]);
    }
}
