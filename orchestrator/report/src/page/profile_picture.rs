//! Pictures of the pressure over height, as SVG.

use super::data::Profile;
use super::number::plain;
use std::fmt::Write;

/// Width and height of a picture and of what lies around its axes, pixels: left, top, right, bottom.
const SIZE: [f64; 2] = [320.0, 340.0];
const AROUND: [f64; 4] = [44.0, 10.0, 12.0, 42.0];

/// Heights (m) and pressures (Pa).
pub type Line = [[f64; 2]];

/// The lines of a profile by their classes.
pub fn lines(profile: &Profile) -> [(&'static str, &Line); 2] {
    [("westergaard", &profile.westergaard), ("computed", &profile.computed)]
}

/// The picture of lines by their classes, from 0 to `height` (m), and to `largest` (kPa) in both directions.
pub fn picture(lines: &[(&str, &Line)], height: f64, largest: f64) -> String {
    let [width, tall] = SIZE;
    let [left, top, right, bottom] = AROUND;
    let x = |pressure: f64| left + (width - left - right) * (pressure + largest) / (2.0 * largest);
    let y = |above: f64| tall - bottom - (tall - top - bottom) * above / height;
    let mut text =
        format!("<svg viewBox=\"0 0 {width} {tall}\" role=\"img\" class=\"profile\"><g class=\"grid\">");
    // Writing to a string cannot fail.
    let step = tick(2.0 * largest, 6.0);
    let last = (largest / step + 1e-9).floor() as i64;
    for pressure in (-last..=last).map(|i| i as f64 * step) {
        let at = x(pressure);
        let _ = write!(
            text,
            "<path d=\"M{at:.1} {top}V{:.1}\"/><text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            tall - bottom,
            tall - bottom + 16.0,
            plain(pressure)
        );
    }
    let step = tick(height, 8.0);
    for above in (0..=(height / step + 1e-9).floor() as i64).map(|i| i as f64 * step) {
        let at = y(above);
        let _ = write!(
            text,
            "<path d=\"M{left} {at:.1}H{:.1}\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            width - right,
            left - 6.0,
            at + 4.0,
            plain(above)
        );
    }
    let line = |class: &str, points: &Line| {
        let points: Vec<String> =
            points.iter().map(|[above, p]| format!("{:.1},{:.1}", x(1e-3 * p), y(*above))).collect();
        format!("<polyline class=\"{class}\" points=\"{}\"/>", points.join(" "))
    };
    let _ = write!(
        text,
        "<path class=\"zero\" d=\"M{zero:.1} {top}V{:.1}\"/></g>{}\
         <text x=\"{zero:.1}\" y=\"{:.1}\" text-anchor=\"middle\">pressure, kPa</text>\
         <text transform=\"translate(12 {:.1}) rotate(-90)\" text-anchor=\"middle\">height above the foot, m</text></svg>",
        tall - bottom,
        lines.iter().map(|(class, points)| line(class, points)).collect::<String>(),
        tall - 6.0,
        (top + tall - bottom) / 2.0,
        zero = x(0.0)
    );
    text
}

/// The largest pressure of lines in either direction, rounded up, kPa, and the largest height, m.
pub fn bounds<'a>(lines: impl Iterator<Item = &'a Line> + Clone) -> [f64; 2] {
    let points = || lines.clone().flatten();
    let largest = points().fold(0.0f64, |most, [_, p]| most.max(1e-3 * p.abs())).max(1e-9);
    let step = tick(2.0 * largest, 6.0) / 2.0;
    [(largest / step).ceil() * step, points().fold(1e-9f64, |most, [above, _]| most.max(*above))]
}

/// 1, 2 or 5 times a power of ten, of which at most `most` make the `length`.
pub fn tick(length: f64, most: f64) -> f64 {
    let power = 10f64.powf((length / most).log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    steps.into_iter().find(|step| length / step <= most).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_holds_every_point() {
        let profile = Profile {
            instant: String::new(),
            water: String::new(),
            time: 1.0,
            ground_acceleration: 1.0,
            computed: vec![[0.0, -6.1e5], [50.0, 2.0e5], [91.75, 0.0]],
            parabola_acceleration: 1.0,
            westergaard: vec![[0.0, -1.0e5], [91.75, 0.0]],
        };
        let [largest, height] = bounds(lines(&profile).iter().map(|(_, line)| *line));
        assert!((610.0..=750.0).contains(&largest) && height == 91.75, "{largest}, {height}");
        let text = picture(&lines(&profile), height, largest);
        let points =
            text.split("class=\"computed\" points=\"").nth(1).and_then(|rest| rest.split('"').next());
        let points: Vec<[f64; 2]> = points
            .expect("a line")
            .split(' ')
            .map(|point| {
                let (x, y) = point.split_once(',').expect("a point");
                [x, y].map(|number| number.parse().expect("a number"))
            })
            .collect();
        assert_eq!(points.len(), 3);
        assert!(
            points.iter().all(|[x, y]| (44.0..=308.0).contains(x) && (10.0..=298.0).contains(y)),
            "{points:?}"
        );
        // Pressure to the right, height upwards.
        assert!(points[0][0] < points[1][0] && points[0][1] > points[1][1]);
    }
}
