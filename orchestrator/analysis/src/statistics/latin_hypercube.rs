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

#[cfg(test)]
mod tests {
    use super::*;

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
