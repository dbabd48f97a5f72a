//! Whether a rational impedance can produce energy, and the smallest loss that prevents it.
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

use super::partial_fractions::PartialFractions;
use faer::{Mat, Side};
use num_complex::Complex64;
use rayon::prelude::*;

/// Ratio of the loss to the largest violation found, as the violation may be larger between the points of the grid.
const MARGIN: f64 = 1.2;
/// Frequencies above the largest given one: number of decades, and frequencies per decade.
const BEYOND: (i32, i32) = (4, 10);

/// A frequency at which a rational impedance can produce energy.
#[derive(Clone, Debug)]
pub(crate) struct Violation {
    /// ω, rad/s.
    pub omega: f64,
    /// −λ_min of the Hermitian part of the leading square block of G(iω), positive.
    pub most: f64,
    /// Its eigenvectors of negative λ.
    pub directions: Vec<Vec<Complex64>>,
}

/// Frequencies at which a rational impedance can produce energy.
///
/// The search covers `frequencies` (rad/s, ascending) and points between them, four decades above the largest, and every
/// pole and its flanks.
pub(crate) fn violations(fractions: &PartialFractions, frequencies: &[f64], allowed: f64) -> Vec<Violation> {
    let largest = frequencies.last().copied().unwrap_or(1.0);
    let mut grid: Vec<f64> = frequencies.to_vec();
    grid.extend(
        frequencies.windows(2).flat_map(|pair| [0.25, 0.5, 0.75].map(|t| pair[0] + t * (pair[1] - pair[0]))),
    );
    grid.extend((1..=BEYOND.0 * BEYOND.1).map(|i| largest * 10f64.powf(f64::from(i) / f64::from(BEYOND.1))));
    grid.extend(
        fractions
            .poles
            .iter()
            .filter(|pole| pole.im > 0.0)
            .flat_map(|pole| [-1.0, 0.0, 1.0].map(|t| pole.im + t * pole.re)),
    );
    grid.push(0.0);
    grid.sort_by(f64::total_cmp);
    grid.par_iter().filter_map(|&omega| violation(fractions, omega, allowed)).collect()
}

/// The smallest loss, `δ₀ + δ₁ s/(s + ω_c)` on the diagonal of the leading square block, that makes a rational impedance
/// passive at all points of the search; `corner` is ω_c (rad/s).
///
/// Both terms are passive. Below the corner only the first is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Loss {
    /// δ₀.
    pub everywhere: f64,
    /// δ₁.
    pub above_corner: f64,
}

impl Loss {
    /// The loss that compensates `violations`.
    pub fn against(violations: &[Violation], corner: f64) -> Self {
        let below = violations.iter().filter(|found| found.omega < corner);
        let everywhere = MARGIN * below.fold(0.0, |most, found| f64::max(most, found.most));
        let above = violations
            .iter()
            .filter(|found| found.omega >= corner)
            .map(|found| (MARGIN * found.most - everywhere) * (1.0 + (corner / found.omega).powi(2)));
        Self { everywhere, above_corner: above.fold(0.0, f64::max) }
    }

    /// The impedance with this loss.
    pub fn added_to(&self, fractions: &mut PartialFractions, corner: f64) {
        let size = fractions.direct.nrows();
        for i in 0..size {
            fractions.direct[(i, i)] += self.everywhere + self.above_corner;
        }
        if self.above_corner == 0.0 {
            return;
        }
        // s/(s + ω_c) = 1 − ω_c/(s + ω_c)
        let order = fractions.poles.len();
        fractions.poles.extend(std::iter::repeat_n(Complex64::from(-corner), size));
        fractions.outputs.resize_horizontally_mut(order + size, Complex64::ZERO);
        fractions.inputs.resize_horizontally_mut(order + size, Complex64::ZERO);
        for i in 0..size {
            fractions.outputs[(i, order + i)] = Complex64::from(-corner * self.above_corner);
            fractions.inputs[(i, order + i)] = Complex64::ONE;
        }
    }
}

/// The violation at iω; without directions if the eigenvalues do not converge.
fn violation(fractions: &PartialFractions, omega: f64, allowed: f64) -> Option<Violation> {
    let value = fractions.evaluate(Complex64::new(0.0, omega));
    let size = value.nrows();
    let hermitian = Mat::from_fn(size, size, |i, j| {
        0.5 * (value[(i, j)] + value[(j, i)].conj())
            + if i == j { Complex64::from(allowed) } else { Complex64::ZERO }
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
    let most = allowed + negative.iter().map(|&k| -eigen.S()[k].re).fold(0.0, f64::max);
    (!negative.is_empty()).then_some(Violation { omega, most, directions })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    /// `1 + c/(s − λ) + …` is passive for a small residue; for a large one the violation is found.
    #[test]
    fn a_fit_that_gives_energy_is_caught() {
        let fractions = |residue: f64| PartialFractions {
            poles: vec![Complex64::new(-0.1, 7.0)],
            outputs: DMatrix::from_element(1, 1, Complex64::from(residue)),
            inputs: DMatrix::from_element(1, 1, Complex64::from(1.0)),
            direct: DMatrix::identity(1, 1),
        };
        // At the pole G = 1 + residue/0.1 (1 + 1/(1 + (140 i))…): about 1 + 10 residue.
        let grid = [1.0, 2.0, 30.0];
        assert!(violations(&fractions(0.1), &grid, 0.0).is_empty());
        assert!(violations(&fractions(-0.09), &grid, 0.0).is_empty());
        let found = violations(&fractions(-0.11), &grid, 0.0);
        let worst = found.iter().max_by(|a, b| a.most.total_cmp(&b.most)).unwrap();
        println!("a resonance that gives energy: {worst:?}");
        assert!((worst.most - 0.1).abs() < 0.01 && (worst.omega - 7.0).abs() < 0.1);
    }

    #[test]
    fn the_loss_makes_it_passive() {
        for corner in [3.0, 20.0] {
            let mut fractions = PartialFractions {
                poles: vec![Complex64::new(-0.1, 7.0)],
                outputs: DMatrix::from_element(1, 1, Complex64::from(-0.12)),
                inputs: DMatrix::from_element(1, 1, Complex64::from(1.0)),
                direct: DMatrix::identity(1, 1),
            };
            let grid = [1.0, 2.0, 30.0];
            let loss = Loss::against(&violations(&fractions, &grid, 0.0), corner);
            assert!(if corner < 7.0 { loss.everywhere == 0.0 } else { loss.above_corner == 0.0 });
            loss.added_to(&mut fractions, corner);
            assert!(violations(&fractions, &grid, 0.0).is_empty());
        }
    }
}
