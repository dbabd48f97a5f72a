use std::collections::BTreeMap;

/// Main effect of a factor on values: the variance of the means of its groups over the whole variance,
///
/// ```text
/// η² = Σ_g n_g (ȳ_g − ȳ)² / Σ (y − ȳ)²,
/// ```
///
/// less what chance alone would give with as many groups, `(g − 1)/(n − g)` of the rest, and not below 0. Each value comes
/// with the number of its group. 0 where the values do not vary; none where groups hold a value each.
///
/// **Source**: W.L. Hays, *Statistics*, 5th edition (1994), ω² without the mean square in the denominator (Kelley's ε²).
pub fn main_effect(values: &[(usize, f64)]) -> Option<f64> {
    let n = values.len() as f64;
    let mean = values.iter().map(|(_, y)| y).sum::<f64>() / n;
    let mut groups: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
    for (group, y) in values {
        let (count, sum) = groups.entry(*group).or_default();
        *count += 1.0;
        *sum += y - mean;
    }
    let count = groups.len() as f64;
    if count >= n {
        return None;
    }
    let whole: f64 = values.iter().map(|(_, y)| (y - mean).powi(2)).sum();
    if whole == 0.0 {
        return Some(0.0);
    }
    let between: f64 = groups.values().map(|(count, sum)| sum * sum / count).sum();
    let chance = (count - 1.0) / (n - count) * (whole - between);
    Some(((between - chance) / whole).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_of_an_additive_model_have_their_shares() {
        // y = 3 a + 4 b with a, b = ±1: 9/25 and 16/25 of the variance; a factor without influence has none.
        let mut random = fastrand::Rng::with_seed(3);
        let runs: Vec<[usize; 3]> = (0..4000).map(|_| [0, 1, 2].map(|_| random.usize(0..2))).collect();
        let value = |run: &[usize; 3]| 3.0 * (2.0 * run[0] as f64 - 1.0) + 4.0 * (2.0 * run[1] as f64 - 1.0);
        for (factor, share) in [(0, 9.0 / 25.0), (1, 16.0 / 25.0), (2, 0.0)] {
            let values: Vec<(usize, f64)> = runs.iter().map(|run| (run[factor], value(run))).collect();
            let found = main_effect(&values).expect("groups with many values");
            assert!((found - share).abs() < 0.03, "{factor}: {found} for {share}");
        }
        assert_eq!(main_effect(&[(0, 1.0), (1, 2.0)]), None);
        assert_eq!(main_effect(&[(0, 1.0), (0, 1.0), (1, 1.0)]), Some(0.0));
    }

    #[test]
    fn many_groups_of_noise_explain_nothing_on_the_mean() {
        let mut random = fastrand::Rng::with_seed(5);
        let trial = |_| {
            let values: Vec<(usize, f64)> = (0..60).map(|i| (i / 2, random.f64())).collect();
            main_effect(&values).expect("groups of two")
        };
        let mean = (0..400).map(trial).sum::<f64>() / 400.0;
        // Uncorrected it would be 29/59.
        assert!(mean < 0.1, "{mean}");
    }
}
