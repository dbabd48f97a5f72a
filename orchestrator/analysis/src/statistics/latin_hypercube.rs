/// A Latin hypercube: `count` points in the unit cube of this many `dimensions`. Every coordinate falls once into
/// each of `count` equal intervals, at a random position. The same `seed` gives the same points.
///
/// **Source**: M.D. McKay, R.J. Beckman, W.J. Conover, A comparison of three methods for selecting values of input variables
/// in the analysis of output from a computer code, Technometrics 21 (1979).
pub fn latin_hypercube(count: usize, dimensions: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut points = vec![Vec::with_capacity(dimensions); count];
    for _ in 0..dimensions {
        let mut strata: Vec<usize> = (0..count).collect();
        random.shuffle(&mut strata);
        for (point, stratum) in points.iter_mut().zip(strata) {
            point.push((stratum as f64 + random.f64()) / count as f64);
        }
    }
    points
}

/// Hypercubes among which the least correlated one is chosen.
const TRIALS: u64 = 200;

/// The Latin hypercube with the smallest largest correlation between two coordinates, of 200 random ones. In small samples chance
/// correlates the coordinates of a single one, so that one factor is taken for another. The same `seed` gives the same points.
pub fn uncorrelated_latin_hypercube(count: usize, dimensions: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut seeds = fastrand::Rng::with_seed(seed);
    let trial = |_| {
        let points = latin_hypercube(count, dimensions, seeds.u64(..));
        (largest_correlation(&points, dimensions), points)
    };
    let best = (0..TRIALS).map(trial).min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or_else(Vec::new, |(_, points)| points)
}

/// Largest absolute correlation between two coordinates of the points.
fn largest_correlation(points: &[Vec<f64>], dimensions: usize) -> f64 {
    let product = |a: usize, b: usize| points.iter().map(|p| (p[a] - 0.5) * (p[b] - 0.5)).sum::<f64>();
    let pairs = (0..dimensions).flat_map(|a| (0..a).map(move |b| (a, b)));
    pairs.map(|(a, b)| product(a, b).abs() / (product(a, a) * product(b, b)).sqrt()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_of_a_chosen_hypercube_are_less_correlated_than_by_chance() {
        let (count, dimensions) = (24, 9);
        let chosen = uncorrelated_latin_hypercube(count, dimensions, 1);
        assert_eq!(chosen, uncorrelated_latin_hypercube(count, dimensions, 1));
        assert_ne!(chosen, uncorrelated_latin_hypercube(count, dimensions, 2));
        let by_chance: f64 = (0..50)
            .map(|seed| largest_correlation(&latin_hypercube(count, dimensions, seed), dimensions))
            .sum();
        let found = largest_correlation(&chosen, dimensions);
        assert!(found < 0.7 * by_chance / 50.0, "{found} of {}", by_chance / 50.0);
        // Correlated by a formula: (u, u) and (u, 1 − u).
        let line: Vec<Vec<f64>> =
            (0..9).map(|i| vec![f64::from(i) / 8.0, 1.0 - f64::from(i) / 8.0]).collect();
        assert!((largest_correlation(&line, 2) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn every_interval_is_hit_once_in_every_dimension() {
        let points = latin_hypercube(50, 3, 7);
        for dimension in 0..3 {
            let mut strata: Vec<usize> =
                points.iter().map(|point| (50.0 * point[dimension]) as usize).collect();
            strata.sort_unstable();
            assert_eq!(strata, (0..50).collect::<Vec<_>>());
        }
        assert_eq!(points, latin_hypercube(50, 3, 7));
        assert_ne!(points, latin_hypercube(50, 3, 8));
    }
}
