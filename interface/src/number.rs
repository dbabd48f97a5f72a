//! Numbers as messages show them.

/// A number to six digits, without a row of zeros.
pub fn plain(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    match rounded.abs() {
        0.0 | 1e-4..1e5 => rounded.to_string(),
        _ => format!("{rounded:e}"),
    }
}

/// A number with all its digits, but without a row of zeros.
pub fn exact(value: f64) -> String {
    match value.abs() {
        0.0 | 1e-4..1e16 => value.to_string(),
        _ => format!("{value:e}"),
    }
}
