//! The section coloured by the envelope of the largest principal stress, as SVG.

use super::super::envelopes::{MAJOR, RATIO};
use super::number::plain;
use super::profile_picture::tick;
use cofferdam_assembly::vtk::Grid;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Largest width and height of the section, pixels.
const SIZE: [f64; 2] = [520.0, 520.0];
/// Margins left, above, right (with the legend) and below, pixels.
const AROUND: [f64; 4] = [52.0, 12.0, 150.0, 44.0];
/// Maximum number of colour bands.
const BANDS: f64 = 8.0;
/// Where the concrete was never in tension.
const COMPRESSION: &str = "#e4e4e4";
/// Viridis by S. van der Walt and N. Smith, 2015, without its ends, from above: even steps of lightness, which the colour-blind and a
/// grey print show too; more tension is darker.
const COLOURS: [[u8; 3]; 9] = [
    [189, 223, 38],
    [122, 209, 81],
    [68, 191, 112],
    [34, 168, 132],
    [33, 145, 140],
    [42, 120, 142],
    [53, 95, 141],
    [65, 68, 135],
    [72, 36, 117],
];

type Point = [f64; 2];
/// Corners of a polygon on the page, each with its value.
type Valued = Vec<(Point, f64)>;

/// The picture of the dam's `envelope`; none without stresses.
pub fn picture(envelope: &Grid) -> Option<String> {
    let stress: Vec<f64> = envelope.point_field(MAJOR)?.iter().map(|stress| 1e-6 * stress).collect();
    let largest = stress.iter().copied().fold(0.0, f64::max);
    let step = if largest > 0.0 { tick(largest, BANDS) } else { 1.0 };
    let bands = ((largest / step).ceil() as usize).max(1);
    let bound = |pick: fn(f64, f64) -> f64, axis: usize| {
        envelope.points.iter().map(|point| point[axis]).reduce(pick).unwrap_or_default()
    };
    let [[x0, y0], [x1, y1]] = [f64::min, f64::max].map(|pick| [bound(pick, 0), bound(pick, 1)]);
    let scale = (SIZE[0] / (x1 - x0)).min(SIZE[1] / (y1 - y0));
    let [left, top, right, bottom] = AROUND;
    let place = |[x, y]: Point| [left + scale * (x - x0), top + scale * (y1 - y)];
    let [width, height] = [left + scale * (x1 - x0) + right, top + scale * (y1 - y0) + bottom];

    // The first path is where there was no tension.
    let mut paths = vec![String::new(); bands + 1];
    let mut limit = String::new();
    let ratio = envelope.point_field(RATIO);
    for cell in envelope.cells.iter().filter(|cell| cell.len() == 3) {
        let corners = |values: &[f64]| -> Valued {
            cell.iter().map(|&node| (place(envelope.points[node]), values[node])).collect()
        };
        let whole = corners(&stress);
        let most = whole.iter().map(|(_, value)| *value).fold(f64::NEG_INFINITY, f64::max);
        outline(&mut paths[0], &below(&whole, 0.0));
        for band in (0..bands).take_while(|band| *band as f64 * step < most) {
            let part = above(&whole, band as f64 * step);
            let part = if band + 1 < bands { below(&part, (band + 1) as f64 * step) } else { part };
            outline(&mut paths[band + 1], &part);
        }
        if let Some(ratio) = ratio
            && let [[a, b], [c, d]] = crossings(&corners(ratio), 1.0)[..]
        {
            // Writing to a string cannot fail.
            let _ = write!(limit, "M{a:.1} {b:.1}L{c:.1} {d:.1}");
        }
    }
    let mut text = format!(
        "<svg viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" class=\"envelope\">\
         <title>Largest principal stress over the run</title>"
    );
    for (band, path) in paths.iter().enumerate() {
        let colour = colour(band, bands);
        let _ =
            write!(text, "<path fill=\"{colour}\" stroke=\"{colour}\" stroke-width=\"0.5\" d=\"{path}\"/>");
    }
    let _ = write!(text, "<path class=\"rim\" d=\"{}\"/>", rim(envelope, place));
    if !limit.is_empty() {
        let _ = write!(text, "<path class=\"strength\" d=\"{limit}\"/>");
    }
    axes(&mut text, [[x0, y0], [x1, y1]], place);
    legend(&mut text, width - right + 24.0, top, (step, bands), !limit.is_empty());
    Some(text + "</svg>")
}

/// Colour of a band: the first is for no tension.
fn colour(band: usize, bands: usize) -> String {
    let Some(band) = band.checked_sub(1) else { return COMPRESSION.to_owned() };
    let place = if bands > 1 { band * (COLOURS.len() - 1) / (bands - 1) } else { COLOURS.len() / 2 };
    let [r, g, b] = COLOURS[place.min(COLOURS.len() - 1)];
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn outline(path: &mut String, corners: &[(Point, f64)]) {
    if corners.len() > 2 {
        for (number, ([x, y], _)) in corners.iter().enumerate() {
            let _ = write!(path, "{}{x:.1} {y:.1}", if number == 0 { 'M' } else { 'L' });
        }
        path.push('Z');
    }
}

/// The part of a polygon where the value is at least `level`.
fn above(corners: &[(Point, f64)], level: f64) -> Valued {
    cut(corners, |value| value - level)
}

/// The part of a polygon where the value is at most `level`.
fn below(corners: &[(Point, f64)], level: f64) -> Valued {
    cut(corners, |value| level - value)
}

/// The part of a polygon where `of_value` is not negative.
fn cut(corners: &[(Point, f64)], of_value: impl Fn(f64) -> f64) -> Valued {
    let mut kept = Vec::new();
    for (index, &(point, value)) in corners.iter().enumerate() {
        let (next, next_value) = corners[(index + 1) % corners.len()];
        let (here, there) = (of_value(value), of_value(next_value));
        if here >= 0.0 {
            kept.push((point, value));
        }
        if here * there < 0.0 {
            let share = here / (here - there);
            let at = [0, 1].map(|d| point[d] + share * (next[d] - point[d]));
            kept.push((at, value + share * (next_value - value)));
        }
    }
    kept
}

/// Where the value crosses `level` on the sides of a triangle.
fn crossings(corners: &[(Point, f64)], level: f64) -> Vec<Point> {
    let sides = (0..corners.len()).map(|index| (corners[index], corners[(index + 1) % corners.len()]));
    let crossed = sides.filter(|((_, a), (_, b))| (*a > level) != (*b > level));
    crossed
        .map(|((p, a), (q, b))| {
            let share = (level - a) / (b - a);
            [0, 1].map(|d| p[d] + share * (q[d] - p[d]))
        })
        .collect()
}

/// The sides that only one triangle has: outline, galleries and cracks.
fn rim(envelope: &Grid, place: impl Fn(Point) -> Point) -> String {
    let mut edges = BTreeMap::<[usize; 2], usize>::new();
    for cell in envelope.cells.iter().filter(|cell| cell.len() == 3) {
        for k in 0..3 {
            let (a, b) = (cell[k], cell[(k + 1) % 3]);
            *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    let mut path = String::new();
    for (edge, _) in edges.into_iter().filter(|(_, times)| *times == 1) {
        let [[a, b], [c, d]] = edge.map(|node| place(envelope.points[node]));
        let _ = write!(path, "M{a:.1} {b:.1}L{c:.1} {d:.1}");
    }
    path
}

fn axes(text: &mut String, [[x0, y0], [x1, y1]]: [Point; 2], place: impl Fn(Point) -> Point) {
    let step = tick((x1 - x0).max(y1 - y0), 10.0);
    let within = |from: f64, to: f64| {
        let numbers = (from / step).ceil() as i64..=(to / step + 1e-9).floor() as i64;
        numbers.map(move |number| step * number as f64)
    };
    let ([left, foot], [right, top]) = (place([x0, y0]), place([x1, y1]));
    for x in within(x0, x1) {
        let [at, _] = place([x, y0]);
        let _ = write!(
            text,
            "<path class=\"tick\" d=\"M{at:.1} {foot:.1}v5\"/><text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            foot + 17.0,
            plain(x)
        );
    }
    for y in within(y0, y1) {
        let [_, at] = place([x0, y]);
        let _ = write!(
            text,
            "<path class=\"tick\" d=\"M{:.1} {at:.1}h-5\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            left - 3.0,
            left - 11.0,
            at + 4.0,
            plain(y)
        );
    }
    let _ = write!(
        text,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">x downstream of the heel, m</text>\
         <text transform=\"translate(12 {:.1}) rotate(-90)\" text-anchor=\"middle\">y above the heel, m</text>",
        (left + right) / 2.0,
        foot + 36.0,
        (foot + top) / 2.0
    );
}

/// Legend of the colours, largest tension first, and of the line.
fn legend(text: &mut String, x: f64, top: f64, (step, bands): (f64, usize), has_limit: bool) {
    let _ = write!(text, "<text x=\"{x:.1}\" y=\"{:.1}\">MPa</text>", top + 10.0);
    let line = 22.0;
    // Sums of steps round.
    let level = |band: usize| plain((band as f64 * step * 1e9).round() / 1e9);
    for (row, band) in (0..=bands).rev().enumerate() {
        let y = top + 20.0 + line * row as f64;
        let label = match band {
            0 => "no tension".to_owned(),
            band => format!("{} to {}", level(band - 1), level(band)),
        };
        let _ = write!(
            text,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"22\" height=\"{line}\" fill=\"{}\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\">{label}</text>",
            colour(band, bands),
            x + 30.0,
            y + 15.0
        );
    }
    if has_limit {
        let y = top + 36.0 + line * (bands + 1) as f64;
        let _ = write!(
            text,
            "<path class=\"strength\" d=\"M{x:.1} {y:.1}h22\"/><text x=\"{:.1}\" y=\"{:.1}\">tensile strength</text>",
            x + 30.0,
            y + 4.0
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_assembly::vtk::Field;

    #[test]
    fn a_triangle_is_divided_into_its_bands_without_gap_or_overlap() {
        let corners = vec![([0.0, 0.0], -1.0), ([4.0, 0.0], 3.0), ([0.0, 4.0], 1.0)];
        let area = |part: &[(Point, f64)]| {
            let next = part.iter().cycle().skip(1);
            0.5 * part.iter().zip(next).map(|((p, _), (q, _))| p[0] * q[1] - q[0] * p[1]).sum::<f64>()
        };
        let parts = [
            area(&below(&corners, 0.0)),
            area(&below(&above(&corners, 0.0), 2.0)),
            area(&above(&corners, 2.0)),
        ];
        // Of the whole, 8: to 0 a quarter of one side times a half of the other, from 2 up a quarter times a half.
        assert_eq!(parts, [1.0, 6.0, 1.0]);
        assert_eq!(crossings(&corners, 2.0).len(), 2);
        assert!(crossings(&corners, 3.0).is_empty());
    }

    #[test]
    fn the_line_of_the_strength_is_drawn_where_it_is_passed() {
        let points = vec![[0.0, 0.0], [10.0, 0.0], [0.0, 20.0]];
        let grid = |ratio: f64| Grid {
            points: points.clone(),
            cells: vec![vec![0, 1, 2]],
            point_data: vec![
                Field::scalar(MAJOR, vec![-1e6, 0.0, 3e6]),
                Field::scalar(RATIO, vec![0.0, 0.0, ratio]),
            ],
            ..Grid::default()
        };
        let passed = picture(&grid(1.5)).expect("a picture");
        let says = |words: &str| passed.contains(words);
        assert!(says("class=\"strength\"") && says("no tension") && says("2.5 to 3"), "{passed}");
        assert!(!picture(&grid(0.9)).expect("a picture").contains("class=\"strength\""));
        assert_eq!(picture(&Grid::default()), None);
    }
}
