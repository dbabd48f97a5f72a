//! Piecewise linear functions of the distance along a joint, as points in order. Two points at the same
//! distance are a jump.

/// Value at `x`, constant outside the points; at a jump, the value beyond it. 0 without points.
pub fn interpolate(line: &[[f64; 2]], x: f64) -> f64 {
    let (before, after) = line.split_at(line.partition_point(|point| point[0] <= x));
    match (before, after) {
        ([.., a], [b, ..]) => between(*a, *b, x),
        ([.., point], []) | ([], [point, ..]) => point[1],
        ([], []) => 0.0,
    }
}

/// Integral ∫p dx, N/m for pressures in Pa.
pub fn force(line: &[[f64; 2]]) -> f64 {
    segments(line).map(|[a, b]| (b[0] - a[0]) * (a[1] + b[1]) / 2.0).sum()
}

/// Moment ∫p (about − x) dx, N for pressures in Pa; with the length of the joint as `about`, the moment about
/// its downstream end, positive if it lifts the upstream end.
pub fn moment(line: &[[f64; 2]], about: f64) -> f64 {
    segments(line)
        .map(|[a, b]| {
            let [arm_a, arm_b] = [about - a[0], about - b[0]];
            let products = a[1] * (2.0 * arm_a + arm_b) + b[1] * (arm_a + 2.0 * arm_b);
            (b[0] - a[0]) * products / 6.0
        })
        .sum()
}

/// The line with its negative values replaced by 0, and points where it crosses 0.
pub(crate) fn clipped(line: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut result: Vec<[f64; 2]> = Vec::with_capacity(line.len() + 2);
    for (index, &[x, value]) in line.iter().enumerate() {
        if index > 0 {
            let [x0, value0] = line[index - 1];
            if value0 * value < 0.0 && x > x0 {
                result.push([x0 + (x - x0) * value0 / (value0 - value), 0.0]);
            }
        }
        result.push([x, value.max(0.0)]);
    }
    result
}

/// The line of a joint of this `length`, with 0 over the lengths `open` from its two ends.
pub(crate) fn relieved(line: &[[f64; 2]], length: f64, open: [f64; 2]) -> Vec<[f64; 2]> {
    let [start, end] = [open[0], length - open[1]];
    let mut result = Vec::with_capacity(line.len() + 4);
    if start > 0.0 {
        result.extend([[0.0, 0.0], [start.min(length), 0.0]]);
    }
    for [a, b] in segments(line) {
        let [from, to] = [a[0].max(start), b[0].min(end)];
        if from < to {
            result.extend([[from, between(a, b, from)], [to, between(a, b, to)]]);
        }
    }
    if end < length {
        result.extend([[end.max(0.0), 0.0], [length, 0.0]]);
    }
    result.dedup();
    result
}

fn segments(line: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 2]> {
    line.windows(2).map(|pair| [pair[0], pair[1]])
}

fn between(a: [f64; 2], b: [f64; 2], x: f64) -> f64 {
    a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0])
}
