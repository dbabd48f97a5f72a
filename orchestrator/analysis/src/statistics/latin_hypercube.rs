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
const TRIALS: u64 = 1000;

/// The Latin hypercube with the smallest largest correlation between two factors, of 1000 random ones. `choices` has an entry for each
/// dimension: the number of equally likely choices into which the coordinate is divided by [`choice`], or none for a number. In a small
/// sample chance correlates the factors of a single hypercube, so that one is taken for another. The same `seed` gives the same points.
pub fn uncorrelated_latin_hypercube(count: usize, choices: &[Option<usize>], seed: u64) -> Vec<Vec<f64>> {
    let mut seeds = fastrand::Rng::with_seed(seed);
    let trial = |_| {
        let points = latin_hypercube(count, choices.len(), seeds.u64(..));
        (largest_correlation(&points, choices), points)
    };
    let best = (0..TRIALS).map(trial).min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or_else(Vec::new, |(_, points)| points)
}

/// The choice, of so many, at a coordinate from 0 to 1.
pub fn choice(coordinate: f64, of: usize) -> usize {
    ((coordinate * of as f64) as usize).min(of.saturating_sub(1))
}

/// Largest absolute correlation between the numbers, or the indicators of the choices, of two factors.
fn largest_correlation(points: &[Vec<f64>], choices: &[Option<usize>]) -> f64 {
    let columns = |(factor, choices): (usize, &Option<usize>)| -> Vec<Vec<f64>> {
        let coordinates = points.iter().map(|point| point[factor]);
        match *choices {
            None => vec![normalised(coordinates.collect())],
            Some(of) => {
                let indicator = |which: usize| -> Vec<f64> {
                    coordinates.clone().map(|share| f64::from(u8::from(choice(share, of) == which))).collect()
                };
                (0..of).map(|which| normalised(indicator(which))).collect()
            }
        }
    };
    let columns: Vec<Vec<Vec<f64>>> = choices.iter().enumerate().map(columns).collect();
    let mut largest = 0.0f64;
    for (factor, own) in columns.iter().enumerate() {
        for other in columns[..factor].iter().flatten() {
            for column in own {
                let product: f64 = column.iter().zip(other).map(|(a, b)| a * b).sum();
                largest = largest.max(product.abs());
            }
        }
    }
    largest
}

/// Values less their mean, over the root of the sum of their squares; zeros of values that do not vary.
fn normalised(mut values: Vec<f64>) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter_mut().for_each(|value| *value -= mean);
    let norm = values.iter().map(|value| value * value).sum::<f64>().sqrt();
    values.iter_mut().for_each(|value| *value = if norm > 0.0 { *value / norm } else { 0.0 });
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_of_a_chosen_hypercube_are_less_correlated_than_by_chance() {
        let (count, choices) = (24, [None, None, None, None, Some(2), Some(3), Some(4), Some(2)]);
        let chosen = uncorrelated_latin_hypercube(count, &choices, 1);
        assert_eq!(chosen, uncorrelated_latin_hypercube(count, &choices, 1));
        assert_ne!(chosen, uncorrelated_latin_hypercube(count, &choices, 2));
        let by_chance = |seed| largest_correlation(&latin_hypercube(count, choices.len(), seed), &choices);
        let mean = (0..50).map(by_chance).sum::<f64>() / 50.0;
        let found = largest_correlation(&chosen, &choices);
        assert!(found < 0.75 * mean, "{found} of {mean}");
        // By a formula: u and 1 − u, and the halves of u.
        let line: Vec<Vec<f64>> =
            (0..8).map(|i| vec![f64::from(i) / 7.0, 1.0 - f64::from(i) / 7.0]).collect();
        assert!((largest_correlation(&line, &[None, None]) - 1.0).abs() < 1e-12);
        assert!((largest_correlation(&line, &[Some(2), Some(2)]) - 1.0).abs() < 1e-12);
        // Ranks 1 to 8 and an indicator of the upper four: 2 · 4 / √(42 · 2).
        assert!((largest_correlation(&line, &[None, Some(2)]) - 8.0 / 84f64.sqrt()).abs() < 1e-12);
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
