use super::fragility::{Line, Lognormal, Point, penalised, sum};
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// A curve and how sure it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitted {
    line: Line,
    /// Covariance of the line: of a, of both, of b.
    covariance: [f64; 3],
    /// Factor on standard errors.
    factor: f64,
}

impl Fitted {
    /// The penalised line of `clusters`, which all have the same intensities, and its covariance by leaving out one cluster at a time,
    ///
    /// ```text
    /// V = (G − 1)/G Σ_g (c₋g − c)(c₋g − c)ᵀ,   c = (a, b)
    /// ```
    ///
    /// None of fewer than two clusters or intensities.
    ///
    /// **Source**: J.W. Tukey's jackknife with whole clusters as B. Efron, *The Jackknife, the Bootstrap and Other Resampling Plans* (1982), chapter 3,
    /// about the estimate from all clusters; intervals by Student's t with G − 1 degrees of freedom (A.C. Cameron, D.L. Miller, A
    /// practitioner's guide to cluster-robust inference, Journal of Human Resources 50 (2015), section VI).
    pub(super) fn of(clusters: &[Vec<Point>], confidence: f64) -> Option<Self> {
        let count = clusters.len();
        let all = sum(clusters);
        let line = penalised(&all, None)?;
        let freedom = count.checked_sub(1).filter(|freedom| *freedom > 0)? as f64;
        let mut covariance = [0.0; 3];
        for cluster in clusters {
            let mut others = all.clone();
            for (sum, own) in others.iter_mut().zip(cluster) {
                sum.exceeding = (sum.exceeding - own.exceeding).max(0.0);
                sum.others = (sum.others - own.others).max(0.0);
            }
            let left = penalised(&others, Some(line))?;
            let [da, db] = [left.a - line.a, left.b - line.b];
            for (sum, product) in covariance.iter_mut().zip([da * da, da * db, db * db]) {
                *sum += product * freedom / count as f64;
            }
        }
        let student = StudentsT::new(0.0, 1.0, freedom).ok()?;
        Some(Self { line, covariance, factor: student.inverse_cdf((1.0 + confidence) / 2.0) })
    }

    /// The curve, if it rises.
    pub fn curve(&self) -> Option<Lognormal> {
        self.line.curve()
    }

    /// Probability at `intensity`, and its interval: `Φ(z ± t s)` with the standard error s of `z = a + b ln x`.
    pub fn probability(&self, intensity: f64) -> (f64, [f64; 2]) {
        let (x, [va, vab, vb]) = (intensity.ln(), self.covariance);
        let (z, error) = (self.line.a + self.line.b * x, (va + 2.0 * x * vab + x * x * vb).max(0.0).sqrt());
        let normal = Normal::standard();
        (normal.cdf(z), [-1.0, 1.0].map(|sign| normal.cdf(z + sign * self.factor * error)))
    }

    /// Interval of the median: the intensities at which the interval of the probability holds one half (Fieller). None if the curve may be
    /// level.
    ///
    /// **Source**: E.C. Fieller, Some problems in interval estimation, Journal of the Royal Statistical Society B 16 (1954).
    pub fn median(&self) -> Option<[f64; 2]> {
        let (Line { a, b }, [va, vab, vb]) = (self.line, self.covariance);
        let square = self.factor * self.factor;
        // (a + b x)² = t² (va + 2 vab x + vb x²)
        let (p, q, r) = (b * b - square * vb, a * b - square * vab, a * a - square * va);
        let root = (q * q - p * r).sqrt();
        (self.rises() && root.is_finite()).then(|| [(-q - root) / p, (-q + root) / p].map(f64::exp))
    }

    /// Interval of the dispersion, `1/(b ± t s)`. None if the curve may be level.
    pub fn dispersion(&self) -> Option<[f64; 2]> {
        let error = self.factor * self.covariance[2].sqrt();
        self.rises().then(|| [1.0 / (self.line.b + error), 1.0 / (self.line.b - error)])
    }

    /// Whether the interval of b holds rising lines only.
    fn rises(&self) -> bool {
        self.line.b - self.factor * self.covariance[2].sqrt() > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::Outcome;
    use crate::statistics::fragility::clusters;

    fn runs(records: usize) -> Vec<Outcome> {
        let of = |record: usize| {
            let capacity = 0.4 * (0.5 * ((record as f64 + 0.5) / records as f64 - 0.5) * 3.0).exp();
            (0..6).map(move |level| {
                let intensity = 0.15 * (level + 1) as f64;
                Outcome { intensity, level, exceeded: intensity > capacity, cluster: record }
            })
        };
        (0..records).flat_map(of).collect()
    }

    /// At both ends of the interval of the median the band of the probability ends at one half.
    #[test]
    fn the_interval_of_the_median_is_where_the_band_crosses_one_half() {
        let fitted = Fitted::of(&clusters(&runs(20)), 0.95).expect("a fit");
        let [low, high] = fitted.median().expect("a rising curve");
        let curve = fitted.curve().expect("a rising curve");
        assert!(low < curve.median && curve.median < high);
        assert!((fitted.probability(low).1[1] - 0.5).abs() < 1e-9);
        assert!((fitted.probability(high).1[0] - 0.5).abs() < 1e-9);
        assert!((fitted.probability(curve.median).0 - 0.5).abs() < 1e-9);
        let [low, high] = fitted.dispersion().expect("a rising curve");
        assert!(low < curve.dispersion && curve.dispersion < high);
    }

    /// Student's factor of a published table, and a variance that falls with the number of records as that of a mean.
    #[test]
    fn intervals_shrink_with_records_and_not_with_copies() {
        let few = Fitted::of(&clusters(&runs(12)), 0.95).expect("a fit");
        assert!((few.factor - 2.200_985).abs() < 1e-5, "{}", few.factor);
        let fitted = |runs: &[Outcome]| Fitted::of(&clusters(runs), 0.95).expect("a fit");
        let copies: Vec<Outcome> = runs(12).iter().flat_map(|run| [*run; 3]).collect();
        assert_eq!(fitted(&copies), few);
        let apart: Vec<Outcome> = runs(12)
            .iter()
            .flat_map(|run| [0, 100, 200].map(|more| Outcome { cluster: run.cluster + more, ..*run }))
            .collect();
        let ratio = few.covariance[2] / fitted(&apart).covariance[2];
        assert!((2.5..5.5).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_level_curve_has_no_interval() {
        let runs: Vec<Outcome> = (0..40)
            .map(|i| Outcome {
                intensity: [0.2, 0.4][i % 2],
                level: i % 2,
                exceeded: i % 4 < 2,
                cluster: i / 2,
            })
            .collect();
        let fitted = Fitted::of(&clusters(&runs), 0.95).expect("a fit");
        assert_eq!((fitted.median(), fitted.dispersion()), (None, None));
        assert_eq!(Fitted::of(&clusters(&runs[..2]), 0.95), None, "of one cluster nothing is known");
    }
}
