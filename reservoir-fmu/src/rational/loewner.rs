use super::partial_fractions::PartialFractions;
use faer::Mat;
use faer::linalg::solvers::Solve;
use nalgebra::DMatrix;
use num_complex::Complex64;

/// A matrix function known at a point.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    /// s, Im > 0.
    pub s: Complex64,
    /// G(s), outputs × inputs.
    pub value: DMatrix<Complex64>,
}

/// Tangential interpolation of a matrix function that vanishes at infinity (Mayo and Antoulas 2007).
///
/// Samples with even indices are matched from the right, `G(λ_j) r_j = w_j`, those with odd ones from the
/// left, `ℓ_iᵀ G(μ_i) = v_iᵀ`, each in several directions, and all at the conjugate points too. With
///
/// ```text
/// 𝕃_ij = (v_iᵀ r_j − ℓ_iᵀ w_j)/(μ_i − λ_j),   𝕃ˢ_ij = (μ_i v_iᵀ r_j − λ_j ℓ_iᵀ w_j)/(μ_i − λ_j)
/// ```
///
/// and 𝕃 = Y Σ Xᵀ, the leading k singular values give `G(s) ≈ W X (…s…) Yᵀ V` of order k: the same matrices
/// hold the approximations of every order.
pub(crate) struct Loewner {
    /// Σ, descending.
    singular_values: Vec<f64>,
    /// Yᵀ 𝕃ˢ X.
    shifted: Mat<f64>,
    /// Yᵀ V.
    input: Mat<f64>,
    /// W X.
    output: Mat<f64>,
}

/// One side of the interpolation, in real arithmetic: columns are Re and Im of a sample in one direction.
struct Side {
    points: Vec<Complex64>,
    directions: Vec<Vec<f64>>,
    /// Products of G with the directions.
    images: Vec<Vec<Complex64>>,
}

impl Side {
    fn new<'a>(
        samples: impl Iterator<Item = &'a Sample>,
        per_sample: usize,
        from_left: bool,
        seed: u64,
    ) -> Self {
        let (mut points, mut directions, mut images) = (Vec::new(), Vec::new(), Vec::new());
        let mut random = seed;
        for Sample { s, value } in samples {
            let length = if from_left { value.nrows() } else { value.ncols() };
            for _ in 0..per_sample {
                let direction: Vec<f64> = (0..length).map(|_| uniform(&mut random)).collect();
                let norm = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
                let direction: Vec<f64> = direction.iter().map(|d| d / norm).collect();
                let image = |matrix: &DMatrix<Complex64>| -> Vec<Complex64> {
                    matrix
                        .row_iter()
                        .map(|row| row.iter().zip(&direction).map(|(g, d)| g * d).sum())
                        .collect()
                };
                images.push(if from_left { image(&value.transpose()) } else { image(value) });
                points.push(*s);
                directions.push(direction);
            }
        }
        Self { points, directions, images }
    }
}

/// The next number of a fixed sequence in [−1, 1) (SplitMix64).
pub(super) fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

impl Loewner {
    /// Prepares approximations of the sampled function; each of the `samples` is used in `directions` directions.
    ///
    /// None if the decomposition does not converge.
    pub fn new(samples: &[Sample], directions: usize) -> Option<Self> {
        let right = Side::new(samples.iter().step_by(2), directions, false, 1);
        let left = Side::new(samples.iter().skip(1).step_by(2), directions, true, 2);
        let (rows, columns) = (left.points.len(), right.points.len());
        let dot = |a: &[Complex64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<Complex64>();
        let (mut plain, mut shifted) = (Mat::zeros(2 * rows, 2 * columns), Mat::zeros(2 * rows, 2 * columns));
        for j in 0..columns {
            for i in 0..rows {
                let from_left = dot(&left.images[i], &right.directions[j]);
                let from_right = dot(&right.images[j], &left.directions[i]);
                // Both points, and the left one with the conjugate of the right one.
                let pair = |mu: Complex64, lambda: Complex64, image: Complex64| {
                    let difference = mu - lambda;
                    [(from_left - image) / difference, (mu * from_left - lambda * image) / difference]
                };
                let same = pair(left.points[i], right.points[j], from_right);
                let mirrored = pair(left.points[i], right.points[j].conj(), from_right.conj());
                for (matrix, a, b) in
                    [(&mut plain, same[0], mirrored[0]), (&mut shifted, same[1], mirrored[1])]
                {
                    matrix[(2 * i, 2 * j)] = (a + b).re;
                    matrix[(2 * i, 2 * j + 1)] = (b - a).im;
                    matrix[(2 * i + 1, 2 * j)] = (a + b).im;
                    matrix[(2 * i + 1, 2 * j + 1)] = (a - b).re;
                }
            }
        }
        let svd = plain.thin_svd().ok()?;
        let scale = 2f64.sqrt();
        let parts = |z: Complex64, part: usize| scale * if part == 0 { z.re } else { z.im };
        let inputs = right.directions.first()?.len();
        let outputs = left.directions.first()?.len();
        let v = Mat::from_fn(2 * rows, inputs, |i, j| parts(left.images[i / 2][j], i % 2));
        let w = Mat::from_fn(outputs, 2 * columns, |i, j| {
            // The right samples are combined with the conjugate of the transformation.
            let z = right.images[j / 2][i];
            parts(if j % 2 == 0 { z } else { Complex64::new(z.re, -z.im) }, j % 2)
        });
        Some(Self {
            singular_values: svd.S().column_vector().iter().copied().collect(),
            shifted: svd.U().transpose() * &shifted * svd.V(),
            input: svd.U().transpose() * v,
            output: w * svd.V(),
        })
    }

    /// Numbers of states whose singular values are above these fractions of the largest, ascending, without repetition.
    pub fn orders(&self, shares: &[f64]) -> Vec<usize> {
        let largest = self.singular_values.first().copied().unwrap_or(0.0);
        let above =
            |share: &f64| self.singular_values.iter().take_while(|&&value| value > share * largest).count();
        let mut orders: Vec<usize> = shares.iter().map(above).collect();
        orders.dedup();
        orders
    }

    /// The approximation with `order` states; none if its eigenvalues do not converge. Unstable poles are left out, so
    /// the residues must then be fitted again.
    pub fn truncated(&self, order: usize) -> Option<PartialFractions> {
        let roots: Vec<f64> = self.singular_values[..order].iter().map(|value| value.sqrt()).collect();
        let system = Mat::from_fn(order, order, |i, j| self.shifted[(i, j)] / (roots[i] * roots[j]));
        let eigen = system.eigen().ok()?;
        let right = Mat::from_fn(order, self.input.ncols(), |i, j| {
            // G = −W X (s Σ − Yᵀ𝕃ˢX)⁻¹ Yᵀ V with the sign of 𝕃 taken into the system
            faer::c64::new(-self.input[(i, j)] / roots[i], 0.0)
        });
        let inputs = eigen.U().partial_piv_lu().solve(&right);
        let output = Mat::from_fn(self.output.nrows(), order, |i, j| {
            faer::c64::new(self.output[(i, j)] / roots[j], 0.0)
        });
        let outputs = output * eigen.U();
        let poles: Vec<Complex64> = (0..order).map(|k| eigen.S()[k]).collect();
        let kept: Vec<usize> = (0..order).filter(|&k| poles[k].re < 0.0 && poles[k].im >= 0.0).collect();
        Some(PartialFractions {
            poles: kept.iter().map(|&k| poles[k]).collect(),
            outputs: DMatrix::from_fn(outputs.nrows(), kept.len(), |i, k| outputs[(i, kept[k])]),
            inputs: DMatrix::from_fn(inputs.ncols(), kept.len(), |j, k| inputs[(kept[k], j)]),
            direct: DMatrix::zeros(outputs.nrows(), inputs.ncols()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A 2 × 3 function with five poles is reproduced with the same number of states.
    #[test]
    fn a_rational_function_is_found_again() {
        let poles = [Complex64::new(-0.3, 0.0), Complex64::new(-0.1, 2.0), Complex64::new(-0.5, 7.0)];
        let entry =
            |i: usize, j: usize| Complex64::new((1 + i * 3 + j) as f64 * 0.3, (i as f64 - j as f64) * 0.2);
        let exact = PartialFractions {
            outputs: DMatrix::from_fn(2, 3, |i, k| if k == 0 { entry(i, k).re.into() } else { entry(i, k) }),
            inputs: DMatrix::from_fn(3, 3, |j, k| if k == 0 { entry(k, j).re.into() } else { entry(k, j) }),
            direct: DMatrix::zeros(2, 3),
            poles: poles.to_vec(),
        };
        let at = |omega: f64| Complex64::new(0.0, omega);
        let samples: Vec<Sample> = [0.1, 0.5, 1.0, 1.8, 2.5, 4.0, 6.5, 7.5, 9.0, 12.0]
            .map(|omega| Sample { s: at(omega), value: exact.evaluate(at(omega)) })
            .to_vec();
        let loewner = Loewner::new(&samples, 2).unwrap();
        assert_eq!(loewner.orders(&[1e-10]), [5]);
        let found = loewner.truncated(5).unwrap();
        for omega in [0.0, 0.3, 2.0, 5.0, 7.0, 30.0] {
            let (a, b) = (found.evaluate(at(omega)), exact.evaluate(at(omega)));
            let error = (&a - &b).norm() / b.norm();
            println!("rational function at ω = {omega}: {error:.1e}");
            assert!(error < 1e-10);
        }
    }
}
