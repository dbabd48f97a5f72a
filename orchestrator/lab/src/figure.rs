//! Common parts of the pictures of the studies.

pub use cofferdam_analysis::study::svg;
use plotters::prelude::RGBColor;

/// Label, colour, points.
pub type Line<'a> = (&'a str, RGBColor, Vec<(f64, f64)>);

/// The range between powers of ten that contains all positive values.
pub fn decades(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let logarithms = values.filter(|value| *value > 0.0 && value.is_finite()).map(f64::log10);
    let (least, most) = logarithms.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
    if least > most { 0.1..1.0 } else { 10f64.powf(least.floor())..10f64.powf(most.floor() + 1.0) }
}
