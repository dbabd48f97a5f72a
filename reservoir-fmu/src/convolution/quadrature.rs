use super::interpolation::Interpolant;
use crate::ReservoirError;
use nalgebra::{DMatrix, Schur};
use num_complex::Complex64;
use rayon::prelude::*;
use rustfft::FftPlanner;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Relative accuracy of the symbol along the contour.
const TOLERANCE: f64 = 1e-9;
/// Largest number of iterations for the stages' frequencies.
const ITERATIONS: usize = 1000;
/// R^N, the factor with which weight n + N is aliased into weight n.
const ALIASING: f64 = 1e-7;

/// The time-stepping method of a convolution quadrature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    /// `δ(ζ) = 3/2 − 2ζ + ζ²/2`, order 2.
    Bdf2,
    /// `δ(ζ) = 2(1 − ζ)/(1 + ζ)`, order 2.
    Trapezoid,
    /// Radau IIA of two stages, order 3.
    Radau2,
    /// Radau IIA of three stages, order 5.
    Radau3,
}

/// Convolution quadrature (Lubich 1988 for multistep methods, Lubich and Ostermann 1993 for Runge–Kutta ones).
///
/// For a velocity linear over every step, zero before the first, the pressure at the
/// steps' ends is `p_n = Σ_{j=1}^{n} W_{n−j} v_j` with the generating function
///
/// ```text
/// Σ_n W_n ζⁿ = e_mᵀ K(Δ(ζ)/H) g(ζ),   Δ(ζ) = A⁻¹ − ζ A⁻¹ 1 e_mᵀ,   g_i = c_i + (1 − c_i) ζ
/// ```
///
/// because the stages at `t + c_i H` see `v = c_i v_n + (1 − c_i) v_{n−1}`. The multistep methods have one stage,
/// at the step's end, and `Δ = δ(ζ)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConvolutionQuadrature {
    /// The method.
    pub rule: Rule,
    /// H, s.
    pub communication_step: f64,
    /// Number of weights.
    pub steps: usize,
}

/// Weights of a convolution: `W_n[i][j]` for lags n < `steps`.
#[derive(Serialize, Deserialize)]
pub(crate) struct Weights {
    /// Number of rows of a weight.
    pub rows: usize,
    /// Number of columns of a weight.
    pub columns: usize,
    /// Entry (i, j) at `i * columns + j`: its values at all lags.
    pub entries: Vec<Vec<f64>>,
}

impl Weights {
    /// Whether these are the weights of `steps` lags, each of `rows` × `columns`.
    pub fn are_of(&self, rows: usize, columns: usize, steps: usize) -> bool {
        (self.rows, self.columns, self.entries.len()) == (rows, columns, rows * columns)
            && self.entries.iter().all(|entry| entry.len() == steps)
    }
}

impl Rule {
    /// The Butcher matrix and the times of the stages divided by H, row by row; none for methods with one stage.
    fn stages(self) -> Option<(Vec<f64>, Vec<f64>)> {
        match self {
            Self::Bdf2 | Self::Trapezoid => None,
            Self::Radau2 => Some((vec![5.0 / 12.0, -1.0 / 12.0, 3.0 / 4.0, 1.0 / 4.0], vec![1.0 / 3.0, 1.0])),
            Self::Radau3 => {
                let root = 6f64.sqrt();
                let matrix = vec![
                    (88.0 - 7.0 * root) / 360.0,
                    (296.0 - 169.0 * root) / 1800.0,
                    (-2.0 + 3.0 * root) / 225.0,
                    (296.0 + 169.0 * root) / 1800.0,
                    (88.0 + 7.0 * root) / 360.0,
                    (-2.0 - 3.0 * root) / 225.0,
                    (16.0 - root) / 36.0,
                    (16.0 + root) / 36.0,
                    1.0 / 9.0,
                ];
                Some((matrix, vec![(4.0 - root) / 10.0, (4.0 + root) / 10.0, 1.0]))
            }
        }
    }

    /// The stages' complex frequencies (times H) at ζ and their factors in the generating function.
    ///
    /// With the eigenvalues z_i of Δ the factor is `e_mᵀ P_i g`, `P_i = Π_{j≠i} (Δ − z_j)/(z_i − z_j)` (Sylvester). None if the eigenvalues are not found.
    fn frequencies(self, zeta: Complex64) -> Option<Vec<(Complex64, Complex64)>> {
        let one = |z: Complex64| Some(vec![(z, Complex64::ONE)]);
        let Some((matrix, times)) = self.stages() else {
            return one(match self {
                Self::Trapezoid => 2.0 * (1.0 - zeta) / (1.0 + zeta),
                _ => 1.5 - 2.0 * zeta + 0.5 * zeta * zeta,
            });
        };
        let count = times.len();
        let butcher = DMatrix::from_row_slice(count, count, &matrix);
        let inverse = butcher.try_inverse()?;
        let mut delta = inverse.map(Complex64::from);
        let sums = inverse.column_sum();
        for i in 0..count {
            delta[(i, count - 1)] -= zeta * sums[i];
        }
        let values = Schur::try_new(delta.clone(), f64::EPSILON, ITERATIONS)?.eigenvalues()?;
        if !values.iter().all(|z| z.is_finite()) {
            return None;
        }
        let data: Vec<Complex64> = times.iter().map(|&c| c + (1.0 - c) * zeta).collect();
        let factor = |own: usize| {
            let others = (0..count).filter(|&other| other != own);
            let projected = others.fold(data.clone(), |v, other| {
                let image = |i: usize| -> Complex64 {
                    (0..count).map(|j| delta[(i, j)] * v[j]).sum::<Complex64>() - values[other] * v[i]
                };
                (0..count).map(|i| image(i) / (values[own] - values[other])).collect()
            });
            projected[count - 1]
        };
        Some((0..count).map(|own| (values[own], factor(own))).collect())
    }

    /// The relevant solutions ζ of `det(Δ(ζ) − z) = 0`: `1/ζ` is the method's stability function at z.
    fn shift(self, z: Complex64) -> Complex64 {
        match self {
            Self::Bdf2 => 2.0 - (1.0 + 2.0 * z).sqrt(),
            Self::Trapezoid => (2.0 - z) / (2.0 + z),
            Self::Radau2 => (1.0 - z * 2.0 / 3.0 + z * z / 6.0) / (1.0 + z / 3.0),
            Self::Radau3 => {
                (1.0 - z * 0.6 + z * z * 0.15 - z * z * z / 60.0) / (1.0 + z * 0.4 + z * z / 20.0)
            }
        }
    }
}

impl ConvolutionQuadrature {
    /// Number of points on the contour.
    fn length(&self) -> usize {
        (2 * self.steps).next_multiple_of(2).max(64)
    }

    /// Number of frequencies at which the symbol would be needed without interpolation.
    pub fn frequencies(&self) -> usize {
        (self.length() / 2 + 1) * self.rule.stages().map_or(1, |(_, times)| times.len())
    }

    /// The weights of `symbol` K(s). Its branch points (1/s), if given, save work.
    ///
    /// Runs on the current rayon pool; the result does not depend on its size.
    ///
    /// **Errors**: [`ReservoirError::Stages`], [`ReservoirError::NotInterpolated`], and those of the symbol.
    pub fn weights(
        &self,
        symbol: impl Fn(Complex64) -> Result<DMatrix<Complex64>, ReservoirError> + Sync,
        branch_points: &[Complex64],
    ) -> Result<Weights, ReservoirError> {
        let length = self.length();
        let radius = ALIASING.powf(1.0 / length as f64);
        let spacing = 2.0 * PI / length as f64;
        let generating = |theta: f64| {
            let zeta = Complex64::from_polar(radius, -theta);
            let stages = self.rule.frequencies(zeta).ok_or(ReservoirError::Stages { zeta })?;
            let mut stages = stages.into_iter();
            let (first, factor) = stages.next().unwrap_or_default();
            let mut sum = symbol(first / self.communication_step)?;
            sum.iter_mut().for_each(|value| *value *= factor);
            for (frequency, factor) in stages {
                let stage = symbol(frequency / self.communication_step)?;
                sum.zip_apply(&stage, |value, more| *value += more * factor);
            }
            Ok(sum)
        };
        let singularities = self.singularities(branch_points, radius);
        let interpolant = Interpolant::new(generating, [0.0, PI], &singularities, TOLERANCE, 4.0 * spacing)?;
        Ok(self.transform(&interpolant, length, radius))
    }

    /// Singularities of the generating function as a function of θ, with ζ = R e^{−iθ}.
    fn singularities(&self, branch_points: &[Complex64], radius: f64) -> Vec<Complex64> {
        branch_points
            .iter()
            .map(|s| Complex64::I * (self.rule.shift(s * self.communication_step) / radius).ln())
            .collect()
    }

    /// `W_n = R⁻ⁿ/N Σ_k G(R e^{−iθ_k}) e^{inθ_k}`, θ_k = 2πk/N, entry by entry.
    fn transform(&self, interpolant: &Interpolant, length: usize, radius: f64) -> Weights {
        let points: Vec<f64> = (0..=length / 2).map(|k| 2.0 * PI * k as f64 / length as f64).collect();
        let basis = interpolant.basis(&points);
        let transform = FftPlanner::new().plan_fft_inverse(length);
        let (rows, columns) = interpolant.shape();
        let entries = (0..rows * columns)
            .into_par_iter()
            .map(|entry| {
                let column_major = entry % columns * rows + entry / columns;
                let mut values = vec![Complex64::ZERO; length];
                for (k, basis) in basis.iter().enumerate() {
                    values[k] = interpolant.evaluate(column_major, basis);
                    values[(length - k) % length] = values[k].conj();
                }
                transform.process(&mut values);
                let scale = |n: usize| radius.powf(-(n as f64)) / length as f64;
                values[..self.steps].iter().enumerate().map(|(n, w)| w.re * scale(n)).collect()
            })
            .collect();
        Weights { rows, columns, entries }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weights(
        symbol: impl Fn(Complex64) -> Complex64 + Sync,
        branch_points: &[Complex64],
    ) -> Result<Vec<f64>, ReservoirError> {
        let quadrature =
            ConvolutionQuadrature { rule: Rule::Radau2, communication_step: 0.01, steps: 10_000 };
        let symbol = |s| Ok(DMatrix::from_element(1, 1, symbol(s)));
        Ok(quadrature.weights(symbol, branch_points)?.entries.swap_remove(0))
    }

    /// A point on the contour that is no number has none.
    #[test]
    fn stages_that_are_not_found_are_none() {
        for rule in [Rule::Radau2, Rule::Radau3] {
            assert!(rule.frequencies(Complex64::new(f64::NAN, 0.0)).is_none());
            assert!(rule.frequencies(Complex64::new(0.9, 0.1)).is_some());
        }
    }

    /// K = s is exact for the third-order method on linear v: ṗ of a ramp is its slope.
    #[test]
    fn differentiates_a_ramp() -> Result<(), ReservoirError> {
        let w = weights(|s| s, &[])?;
        for n in [1, 5, 400, 10_000] {
            let sum: f64 = (1..=n).map(|j| w[n - j] * 0.01 * j as f64).sum();
            assert!((sum - 1.0).abs() < 1e-6, "step {n}: {sum}");
        }
        Ok(())
    }

    /// K = 1/√(1 + s²/ω²): a ramp convolved with J₀ against its fine quadrature.
    #[test]
    fn bessel_kernel() -> Result<(), ReservoirError> {
        let omega = 3.0;
        let cut_off = Complex64::new(0.0, omega);
        let w = weights(|s| 1.0 / (1.0 + (s / omega).powi(2)).sqrt(), &[Complex64::ZERO, cut_off])?;
        let mut worst: f64 = 0.0;
        for n in [50, 300, 1000, 4000, 10_000] {
            let t = 0.01 * n as f64;
            let sum: f64 = (1..=n).map(|j| w[n - j] * 0.01 * j as f64).sum();
            // J₀(x) = (1/π)∫cos(x sin φ)dφ, ∫₀ᵗ ω J₀(ωτ)(t − τ)dτ = (1/π)∫(1 − cos(ωt sin φ))/(ω sin²φ)dφ
            let points = 2000;
            let exact: f64 = (0..points)
                .map(|i| {
                    let sine = (PI * (i as f64 + 0.5) / points as f64).sin();
                    (1.0 - (omega * t * sine).cos()) / (omega * sine * sine) / points as f64
                })
                .sum();
            worst = worst.max((sum - exact).abs() / exact);
        }
        println!("convolution quadrature, ramp on J₀: largest relative error {worst:.1e}");
        assert!(worst < 2e-6);
        Ok(())
    }
}
