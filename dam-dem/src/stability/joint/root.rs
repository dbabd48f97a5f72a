/// Samples per piece. The function is close to a cubic in each of them.
const SAMPLES: usize = 16;

/// The smallest x at which `f` is not negative, between the first and the last of `breakpoints`; `f` must be
/// continuous from each of them to the next and may jump there. `None` if it is negative everywhere.
///
/// Pairs of roots between two samples are found, too, by the maximum between them.
pub(super) fn smallest(f: impl Fn(f64) -> f64, breakpoints: &[f64]) -> Option<f64> {
    for piece in breakpoints.windows(2) {
        let [start, end] = [piece[0], piece[1]];
        // just before the end, where f may jump
        let span = (end - start) * (1.0 - 1e-12);
        let mut samples = [[start, f(start)]; 3];
        if samples[0][1] >= 0.0 {
            return Some(start);
        }
        // the last sample twice, for a maximum just before it
        for k in 1..=SAMPLES + 1 {
            let x = start + span * k.min(SAMPLES) as f64 / SAMPLES as f64;
            samples = [samples[1], samples[2], [x, f(x)]];
            let [left, middle, right] = samples;
            if left[1] <= middle[1] && right[1] <= middle[1] {
                let top = maximum(&f, left[0], right[0]);
                if f(top) >= 0.0 {
                    return Some(crossing(&f, left[0], top));
                }
            }
            if right[1] >= 0.0 {
                return Some(crossing(&f, middle[0], right[0]));
            }
        }
    }
    None
}

/// The end of the bisected interval at which `f` is not negative, given `f(low) < 0 <= f(high)`.
fn crossing(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    loop {
        let middle = low + (high - low) / 2.0;
        if middle <= low || middle >= high {
            return high;
        }
        *(if f(middle) >= 0.0 { &mut high } else { &mut low }) = middle;
    }
}

/// Place of the maximum of `f` with a single one in between.
fn maximum(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..80 {
        let third = (high - low) / 3.0;
        let [left, right] = [low + third, high - third];
        if f(left) < f(right) { low = left } else { high = right }
    }
    low + (high - low) / 2.0
}

#[cfg(test)]
mod tests {
    use super::smallest;

    #[test]
    fn finds_the_first_of_several_roots() {
        let cubic = |x: f64| (x - 1.0) * (x - 2.0) * (x - 3.0);
        let found = smallest(cubic, &[0.0, 4.0]);
        assert!((found.unwrap() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn finds_a_pair_of_roots_between_two_samples() {
        let narrow = |x: f64| 1e-6 - (x - 0.53).powi(2);
        let found = smallest(narrow, &[0.0, 1.0]).unwrap();
        assert!((found - 0.529).abs() < 1e-12 && narrow(found) >= 0.0);
    }

    #[test]
    fn finds_a_maximum_in_the_first_and_in_the_last_interval() {
        for top in [0.001, 0.03, 0.97, 0.999] {
            let narrow = |x: f64| 1e-10 - (x - top).powi(2);
            assert!((smallest(narrow, &[0.0, 1.0]).unwrap() - (top - 1e-5)).abs() < 1e-10);
        }
    }

    #[test]
    fn takes_a_breakpoint_at_which_the_function_jumps_upwards() {
        let jump = |x: f64| if x < 0.3 { -1.0 } else { 1.0 };
        assert_eq!(smallest(jump, &[0.0, 0.3, 1.0]), Some(0.3));
    }

    #[test]
    fn finds_a_root_just_before_the_function_jumps_downwards() {
        // falls, and rises from the last sample before the jump at 1
        let spike = |x: f64| if x < 1.0 { -0.4 - 0.1 * x + 20.0 * (x - 0.95).max(0.0) } else { -10.0 };
        assert!((smallest(spike, &[0.0, 1.0, 2.0]).unwrap() - 19.4 / 19.9).abs() < 1e-14);
    }

    #[test]
    fn has_none_where_the_function_is_negative_or_not_a_number() {
        assert_eq!(smallest(|x| -1.0 - x, &[0.0, 0.3, 1.0]), None);
        assert_eq!(smallest(|_| f64::NAN, &[0.0, 1.0]), None);
    }
}
