//! Whether a rational impedance can produce energy, and the loss that prevents it.
//!
//! `G(s)` is passive if `Re x*G(iω)x ≥ 0` for all ω and x (its poles lie in the left half plane). Then the
//! recursion for velocities that are linear over steps of H is passive too: its transfer function is
//!
//! ```text
//! Ĝ(θ) = Σ_k G(i(θ + 2πk)/H) sinc²((θ + 2πk)/2)
//! ```
//!
//! by Poisson's summation, as the hat function's transform is sinc² ≥ 0: a sum of passive terms. Hence
//! `Σ_n v_nᵀ p_n H ≥ 0`. For p and v that are both linear within steps, `∫ vᵀp dt ≥ 0` as well, as its symbol is
//! `(2 + cos θ)/3 Ĝ(θ)`.
//!
//! Water does not resist a steady velocity, `G(0) = 0`, and its added mass `G′(0)` is symmetric. So the Hermitian part of
//! `G(iω)` is that of `−ω² R(iω)`, `R = (G − s G′(0))/s²`, and the loss `δ s/(s + ω₀)` compensates it where
//!
//! ```text
//! −(ω² + ω₀²) Herm R(iω) ≥ −δ,
//! ```
//!
//! which has no cancellation at low frequencies, and a limit at ω = 0.

use super::partial_fractions::{Evaluator, PartialFractions};
use faer::{Mat, Side};
use nalgebra::DMatrix;
use num_complex::Complex64;
use rayon::prelude::*;

/// Frequencies above the largest given one: number of decades, and frequencies per decade.
const BEYOND: (i32, i32) = (4, 10);

/// A frequency at which a rational impedance can produce energy.
#[derive(Clone, Debug)]
pub(crate) struct Violation {
    /// ω, rad/s.
    pub omega: f64,
    /// −λ_min of `−(ω² + ω₀²) Herm R(iω)`, leading square block: the loss δ that is needed there.
    pub most: f64,
    /// Its eigenvectors of negative λ.
    pub directions: Vec<Vec<Complex64>>,
}

/// A loss `δ s/(s + ω₀)` on the diagonal of the leading square block, over ρc.
///
/// It is passive, `δ ω²/(ω² + ω₀²)` at real frequencies, and zero at s = 0, where it adds the mass `δ/ω₀`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Loss {
    /// δ.
    pub size: f64,
    /// ω₀, rad/s.
    pub corner: f64,
}

impl Loss {
    /// The impedance with this loss.
    pub fn added_to(&self, fractions: &mut PartialFractions) {
        let (size, order) = (fractions.direct.nrows(), fractions.poles.len());
        // s/(s + ω₀) = 1 − ω₀/(s + ω₀)
        fractions.poles.extend(std::iter::repeat_n(Complex64::from(-self.corner), size));
        fractions.outputs.resize_horizontally_mut(order + size, Complex64::ZERO);
        fractions.inputs.resize_horizontally_mut(order + size, Complex64::ZERO);
        for i in 0..size {
            fractions.direct[(i, i)] += self.size;
            fractions.outputs[(i, order + i)] = Complex64::from(-self.corner * self.size);
            fractions.inputs[(i, order + i)] = Complex64::ONE;
        }
    }
}

/// Frequencies at which a rational impedance with G(0) = 0 and a symmetric G′(0) can produce energy although `loss` is
/// added to it.
///
/// The search covers 0, `frequencies` (rad/s, ascending), points between them, four decades above the largest, and every
/// pole and its flanks.
pub(crate) fn violations(fractions: &PartialFractions, frequencies: &[f64], loss: Loss) -> Vec<Violation> {
    let largest = frequencies.last().copied().unwrap_or(1.0);
    let mut grid = vec![0.0];
    grid.extend(frequencies);
    let between =
        grid.windows(2).flat_map(|pair| [0.25, 0.5, 0.75].map(|t| pair[0] + t * (pair[1] - pair[0])));
    grid = between.chain(grid.iter().copied()).collect();
    grid.extend((1..=BEYOND.0 * BEYOND.1).map(|i| largest * 10f64.powf(f64::from(i) / f64::from(BEYOND.1))));
    grid.extend(
        fractions
            .poles
            .iter()
            .filter(|pole| pole.im > 0.0)
            .flat_map(|pole| [-1.0, 0.0, 1.0].map(|t| (pole.im + t * pole.re).max(0.0))),
    );
    grid.sort_by(f64::total_cmp);
    let beyond = fractions.beyond_slope();
    let beyond = Evaluator::of(&beyond);
    grid.par_iter().filter_map(|&omega| violation(&beyond, omega, loss)).collect()
}

/// `−(ω² + ω₀²) R(iω)` of R given as `beyond`.
pub(crate) fn scaled(beyond: &Evaluator<'_>, omega: f64, corner: f64) -> DMatrix<Complex64> {
    let factor = Complex64::from(-omega * omega - corner * corner);
    beyond.at(Complex64::new(0.0, omega)) * factor
}

/// The violation at iω; without directions if the eigenvalues do not converge.
fn violation(beyond: &Evaluator<'_>, omega: f64, loss: Loss) -> Option<Violation> {
    let value = scaled(beyond, omega, loss.corner);
    let size = value.nrows();
    let hermitian = Mat::from_fn(size, size, |i, j| {
        0.5 * (value[(i, j)] + value[(j, i)].conj())
            + if i == j { Complex64::from(loss.size) } else { Complex64::ZERO }
    });
    // Most matrices are positive definite, which a factorisation finds faster.
    if hermitian.llt(Side::Lower).is_ok() {
        return None;
    }
    let Ok(eigen) = hermitian.self_adjoint_eigen(Side::Lower) else {
        return Some(Violation { omega, most: f64::INFINITY, directions: Vec::new() });
    };
    let negative: Vec<usize> = (0..size).filter(|&k| eigen.S()[k].re < 0.0).collect();
    let directions = negative.iter().map(|&k| (0..size).map(|i| eigen.U()[(i, k)]).collect()).collect();
    let most = loss.size + negative.iter().map(|&k| -eigen.S()[k].re).fold(0.0, f64::max);
    (!negative.is_empty()).then_some(Violation { omega, most, directions })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `s/(s + 1) + r s²/((s + 0.1)² + 49)`-like: a resonance without a value or a slope at 0.
    fn with_resonance(residue: f64) -> PartialFractions {
        let pole = Complex64::new(-0.1, 7.0);
        // c/(s − λ) + c̄/(s − λ̄) with Re(c/λ) = −value/2, Re(c/λ²) = −slope/2: compensated by the two real poles.
        let c = Complex64::from(residue);
        let (value, slope) = (-2.0 * (c / pole).re, -2.0 * (c / (pole * pole)).re);
        // a/(s + 1) + b/(s + 2): a + b/2 = −value − 1, −a − b/4 = −slope + …
        let (wanted_value, wanted_slope) = (-value - 1.0, 1.0 - slope);
        let b = 4.0 * (wanted_value + wanted_slope);
        let a = wanted_value - 0.5 * b;
        PartialFractions {
            poles: vec![Complex64::from(-1.0), Complex64::from(-2.0), pole],
            outputs: DMatrix::from_row_slice(1, 3, &[a.into(), b.into(), c]),
            inputs: DMatrix::from_element(1, 3, Complex64::ONE),
            direct: DMatrix::identity(1, 1),
        }
    }

    const GRID: [f64; 3] = [1.0, 2.0, 30.0];

    /// The loss that is needed is that of the Hermitian part itself.
    #[test]
    fn a_fit_that_gives_energy_is_caught() {
        let found = |residue: f64, loss: Loss| violations(&with_resonance(residue), &GRID, loss);
        let none = Loss { size: 0.0, corner: 3.0 };
        assert!(found(0.1, none).is_empty() && found(-0.05, none).is_empty());
        let worst = found(-0.13, none).into_iter().max_by(|a, b| a.most.total_cmp(&b.most)).unwrap();
        println!("a resonance that gives energy: {worst:?}");
        let value = with_resonance(-0.13).evaluate(Complex64::new(0.0, worst.omega))[(0, 0)].re;
        assert!((worst.omega - 7.0).abs() < 0.2 && value < -0.1);
        let scale = (worst.omega * worst.omega + 9.0) / (worst.omega * worst.omega);
        assert!((worst.most + value * scale).abs() < 1e-12);
    }

    #[test]
    fn the_loss_makes_it_passive_and_vanishes_at_zero() {
        for corner in [3.0, 20.0] {
            let mut fractions = with_resonance(-0.13);
            let before = fractions.clone();
            let needed = violations(&fractions, &GRID, Loss { size: 0.0, corner });
            let size = 1.001 * needed.iter().map(|found| found.most).fold(0.0, f64::max);
            let loss = Loss { size, corner };
            assert!(size > 0.1 && violations(&fractions, &GRID, loss).is_empty());
            loss.added_to(&mut fractions);
            for omega in (1..4000).map(|k| 0.01 * f64::from(k)) {
                let s = Complex64::new(0.0, omega);
                let value = fractions.evaluate(s)[(0, 0)];
                assert!(value.re >= 0.0);
                assert!((value - before.evaluate(s)[(0, 0)] - loss.size * s / (s + corner)).norm() < 1e-12);
            }
            assert!(fractions.evaluate(Complex64::ZERO)[(0, 0)].norm() < 1e-12);
        }
    }
}
