//! Number formats of the page.

/// Largest whole number that is written with all its digits.
const WHOLE: f64 = 1e7;

/// Four significant digits; whole numbers with all of theirs; very large and small ones with a power of ten.
pub fn shown(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let size = value.abs();
    let text = if size == 0.0 {
        "0".to_owned()
    } else if value.fract() == 0.0 && size < WHOLE {
        grouped(size)
    } else {
        let four = format!("{size:.3e}");
        let (digits, exponent) = four.split_once('e').unwrap_or((&four, "0"));
        match exponent.parse::<i32>().unwrap_or(0) {
            exponent @ -4..4 => format!("{size:.*}", (3 - exponent) as usize),
            exponent @ 4..6 => grouped((size / 10f64.powi(exponent - 3)).round() * 10f64.powi(exponent - 3)),
            exponent => format!("{digits}·10{}", superscript(exponent)),
        }
    };
    if value < 0.0 { format!("−{text}") } else { text }
}

/// A whole number, thousands apart from ten thousand on.
fn grouped(value: f64) -> String {
    let digits = format!("{value:.0}");
    if digits.len() < 5 {
        return digits;
    }
    let (first, rest) = digits.split_at(digits.len() % 3);
    let groups = rest.as_bytes().chunks(3).map(|group| String::from_utf8_lossy(group).into_owned());
    let groups: Vec<String> =
        Some(first.to_owned()).filter(|first| !first.is_empty()).into_iter().chain(groups).collect();
    groups.join("\u{202f}")
}

fn superscript(exponent: i32) -> String {
    let digit = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    };
    exponent.to_string().chars().map(digit).collect()
}

/// An input value with all its digits.
pub fn plain(value: f64) -> String {
    cofferdam_unit::number::plain(value).to_string().replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits_or_all_of_theirs() {
        for (value, text) in [
            (0.0, "0"),
            (277.429_229, "277.4"),
            (-0.677_275, "−0.6773"),
            (1.000_000_000_000_000_2, "1.000"),
            (9.999_96, "10.00"),
            (9_999.96, "10\u{202f}000"),
            (24.0, "24"),
            (13_649.0, "13\u{202f}649"),
            (123_456.7, "123\u{202f}500"),
            (1.831e-9, "1.831·10⁻⁹"),
            (5.798_66e-4, "0.0005799"),
            (-2.5e12, "−2.500·10¹²"),
            (f64::NAN, "–"),
        ] {
            assert_eq!(shown(value), text, "{value}");
        }
    }
}
