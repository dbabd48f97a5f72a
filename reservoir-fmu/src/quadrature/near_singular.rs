use super::{QuadraturePoint, gauss_legendre, log_singular::log_singular};

/// Bisections of an element towards a source close to it.
const DEPTH: usize = 40;

/// Rule on the straight element from `start` to `end` for kernels singular at `source` (all m).
///
/// For a source on the element: the logarithmic rule. Otherwise: bisection until every part is no longer
/// than its distance from the source, then Gauss' rule with enough points for a relative
/// error of about 1e-9 at that distance. The previous content of `rule` is replaced.
pub(crate) fn element_rule(
    start: [f64; 2],
    end: [f64; 2],
    source: [f64; 2],
    rule: &mut Vec<QuadraturePoint>,
) {
    rule.clear();
    let along = [end[0] - start[0], end[1] - start[1]];
    let length = along[0].hypot(along[1]);
    let offset = [source[0] - start[0], source[1] - start[1]];
    // local frame of the element: foot of the source in [−1, 1] when beside it, height above it
    let foot = 2.0 * (offset[0] * along[0] + offset[1] * along[1]) / (length * length) - 1.0;
    let height = 2.0 * (offset[0] * along[1] - offset[1] * along[0]).abs() / (length * length);
    if height < 1e-10 && foot.abs() < 1.0 + 1e-10 {
        log_singular(foot.clamp(-1.0, 1.0), rule);
        return;
    }
    subdivide([-1.0, 1.0], foot, height, DEPTH, rule);
}

fn subdivide([start, end]: [f64; 2], foot: f64, height: f64, depth: usize, rule: &mut Vec<QuadraturePoint>) {
    let distance = (foot - foot.clamp(start, end)).hypot(height);
    let length = end - start;
    if distance < length && depth > 0 {
        let middle = 0.5 * (start + end);
        subdivide([start, middle], foot, height, depth - 1, rule);
        subdivide([middle, end], foot, height, depth - 1, rule);
        return;
    }
    let points = match distance / length {
        ratio if ratio > 8.0 => 4,
        ratio if ratio > 4.0 => 5,
        ratio if ratio > 2.0 => 6,
        _ => 9,
    };
    rule.extend(gauss_legendre(points).iter().map(|q| QuadraturePoint {
        position: 0.5 * (start + end) + 0.5 * length * q.position,
        weight: 0.5 * length * q.weight,
    }));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `∫ dx/(x² + d²) = (atan(b/d) − atan(a/d))`: the double layer beside an element.
    #[test]
    fn near_singular_rows_equal_the_closed_form() {
        let mut worst: f64 = 0.0;
        for d in [1e-4, 1e-2, 0.1, 0.5, 3.0, 30.0f64] {
            for foot in [-1.5, -0.2, 0.0, 0.3, 1.0, 2.2f64] {
                let mut rule = Vec::new();
                element_rule([0.0, 0.0], [1.0, 0.0], [foot, d], &mut rule);
                let sum: f64 = rule
                    .iter()
                    .map(|q| {
                        let x = 0.5 * (1.0 + q.position) - foot;
                        0.5 * q.weight * d / (x * x + d * d)
                    })
                    .sum();
                let exact = ((1.0 - foot) / d).atan() + (foot / d).atan();
                worst = worst.max((sum - exact).abs());
            }
        }
        println!("near-singular double layer: largest error {worst:.1e} rad of an angle");
        assert!(worst < 1e-8);
    }
}
