use super::interpolation::Interpolant;
use nalgebra::DMatrix;
use num_complex::Complex64;
use rayon::prelude::*;
use rustfft::FftPlanner;
use std::f64::consts::PI;

/// Relative accuracy of the symbol along the contour.
const TOLERANCE: f64 = 1e-9;
/// R^N, the factor of aliasing from weight n + N into weight n.
const ALIASING: f64 = 1e-7;

/// Convolution quadrature with the two-stage Radau IIA method (Lubich and Ostermann 1993).
///
/// For a velocity linear over every step, zero before the first, the pressure at the
/// steps' ends is `p_n = Σ_{j=1}^{n} W_{n−j} v_j` with the generating function
///
/// ```text
/// Σ_n W_n ζⁿ = K₂₁(ζ) (1/3 + 2ζ/3) + K₂₂(ζ),   [K_ij](ζ) = K(Δ(ζ)/H)
/// Δ(ζ) = A⁻¹ − ζ A⁻¹ 1 e₂ᵀ = [[3/2, 1/2 − 2ζ], [−9/2, 5/2 + 2ζ]]
/// ```
///
/// because the stages at c = (1/3, 1) see `v = (v_n/3 + 2v_{n−1}/3, v_n)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConvolutionQuadrature {
    /// H, s.
    pub communication_step: f64,
    /// Number of weights.
    pub steps: usize,
}

/// Weights of a convolution: `W_n[i][j]` for lags n < `steps`.
pub(crate) struct Weights {
    /// Number of rows and columns of a weight.
    pub size: usize,
    /// Entry (i, j) at `i * size + j`: its values at all lags.
    pub entries: Vec<Vec<f64>>,
}

/// The two complex frequencies (times H) of a ζ and their factors in the generating function.
fn stage_frequencies(zeta: Complex64) -> [(Complex64, Complex64); 2] {
    let (lower, diagonal) = (Complex64::from(-4.5), 2.5 + 2.0 * zeta);
    let half_trace = 2.0 + zeta;
    let root = (half_trace * half_trace - 6.0 + 6.0 * zeta).sqrt();
    let frequencies = [half_trace - root, half_trace + root];
    let inner = lower * (1.0 + 2.0 * zeta) / 3.0 + diagonal;
    let factor = |own: Complex64, other: Complex64| (inner - other) / (own - other);
    [
        (frequencies[0], factor(frequencies[0], frequencies[1])),
        (frequencies[1], factor(frequencies[1], frequencies[0])),
    ]
}

impl ConvolutionQuadrature {
    /// Number of points on the contour.
    fn length(&self) -> usize {
        (2 * self.steps).next_multiple_of(2).max(64)
    }

    /// Number of frequencies that the symbol would be needed at without interpolation.
    pub fn frequencies(&self) -> usize {
        self.length() + 2
    }

    /// The weights of `symbol` K(s), whose branch points (1/s) may be told to save work.
    ///
    /// Runs on the current rayon pool; the result does not depend on its size.
    pub fn weights<E: Send>(
        &self,
        symbol: impl Fn(Complex64) -> Result<DMatrix<Complex64>, E> + Sync,
        branch_points: &[Complex64],
    ) -> Result<Weights, E> {
        let length = self.length();
        let radius = ALIASING.powf(1.0 / length as f64);
        let spacing = 2.0 * PI / length as f64;
        let generating = |theta: f64| {
            let zeta = Complex64::from_polar(radius, -theta);
            let [(s1, f1), (s2, f2)] = stage_frequencies(zeta);
            let k1 = symbol(s1 / self.communication_step)?;
            let k2 = symbol(s2 / self.communication_step)?;
            Ok(k1.zip_map(&k2, |a, b| a * f1 + b * f2))
        };
        let singularities = self.singularities(branch_points, radius);
        let interpolant = Interpolant::new(generating, [0.0, PI], &singularities, TOLERANCE, 4.0 * spacing)?;
        Ok(self.transform(&interpolant, length, radius))
    }

    /// Where the generating function is singular as a function of θ, ζ = R e^{−iθ}.
    ///
    /// An eigenvalue z of Δ(ζ) obeys `r(z) = 1/ζ` with the method's stability function r.
    fn singularities(&self, branch_points: &[Complex64], radius: f64) -> Vec<Complex64> {
        branch_points
            .iter()
            .map(|s| {
                let z = s * self.communication_step;
                let stability = (1.0 + z / 3.0) / (1.0 - z * 2.0 / 3.0 + z * z / 6.0);
                Complex64::I * (1.0 / (stability * radius)).ln()
            })
            .collect()
    }

    /// `W_n = R⁻ⁿ/N Σ_k G(R e^{−iθ_k}) e^{inθ_k}`, θ_k = 2πk/N, entry by entry.
    fn transform(&self, interpolant: &Interpolant, length: usize, radius: f64) -> Weights {
        let points: Vec<f64> = (0..=length / 2).map(|k| 2.0 * PI * k as f64 / length as f64).collect();
        let basis = interpolant.basis(&points);
        let transform = FftPlanner::new().plan_fft_inverse(length);
        let size = interpolant.size();
        let entries = (0..size * size)
            .into_par_iter()
            .map(|entry| {
                let column_major = entry % size * size + entry / size;
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
        Weights { size, entries }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weights(
        symbol: impl Fn(Complex64) -> Complex64 + Sync,
        branch_points: &[Complex64],
    ) -> Result<Vec<f64>, std::convert::Infallible> {
        let quadrature = ConvolutionQuadrature { communication_step: 0.01, steps: 10_000 };
        let symbol = |s| Ok::<_, std::convert::Infallible>(DMatrix::from_element(1, 1, symbol(s)));
        Ok(quadrature.weights(symbol, branch_points)?.entries.swap_remove(0))
    }

    /// K = s is exact for the third-order method on linear v: ṗ of a ramp is its slope.
    #[test]
    fn differentiates_a_ramp() -> Result<(), std::convert::Infallible> {
        let w = weights(|s| s, &[])?;
        for n in [1, 5, 400, 10_000] {
            let sum: f64 = (1..=n).map(|j| w[n - j] * 0.01 * j as f64).sum();
            assert!((sum - 1.0).abs() < 1e-6, "step {n}: {sum}");
        }
        Ok(())
    }

    /// K = 1/√(1 + s²/ω²): a ramp convolved with J₀ against its fine quadrature.
    #[test]
    fn bessel_kernel() -> Result<(), std::convert::Infallible> {
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
