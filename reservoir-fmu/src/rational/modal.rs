//! Water over a level, rigid bed before a vertical face: all modes share one function.
//!
//! With `λ_m = (2m − 1)π/2h`, `σ = s/(λ_m c)` and the modes' orthonormal shapes `φ_m = √(2/h) cos λ_m y`
//!
//! ```text
//! p = −ρc Σ_m φ_m G(σ) ∫ φ_m v dy,   G(σ) = σ/√(1 + σ²)
//! ```
//!
//! so that one rational fit of G serves all modes, each at its own frequency. G is singular at ±i. The poles are placed on
//! the branch cuts to the left of these points, and the residues follow from linear least squares of the relative error.

use super::Quality;
use super::coordinates::Coordinates;
use super::lanes::LANES;
use super::panels::Panels;
use super::partial_fractions::PartialFractions;
use super::passivity::{Loss, violations};
use super::ports::{Group, Outputs, Ports, parts};
use super::recursion::Recursion;
use crate::ReservoirParameters;
use crate::quadrature::gauss_legendre;
use faer::Mat;
use nalgebra::{DMatrix, SymmetricEigen};
use num_complex::Complex64;
use std::f64::consts::PI;

/// Pairs of poles.
const PAIRS: usize = 24;
/// Distances of the first and the last pole from the branch point.
const DISTANCES: [f64; 2] = [2e-7, 30.0];
/// Decay that is added, divided by the mode's frequency: without it, no finite number of poles is accurate at σ = i.
const DECAY: f64 = 2e-6;
/// Shorter modes that give the mass of what the modes leave over, per mode.
const SHORT: usize = 15;
/// Share of a velocity that the modes leave over below which it counts as none.
const LEAST_SHARE: f64 = 1e-9;
/// ω₀ of the loss, divided by the mode's frequency.
const CORNER: f64 = 1.0;
/// Singular values below this fraction of the largest are left out.
const ROUNDING: f64 = 1e-13;

/// The recursion of such water.
///
/// None if the fit of G failed.
pub(super) fn recursion(
    parameters: &ReservoirParameters,
    coordinates: &Coordinates,
) -> Option<(Recursion, Quality)> {
    let (face, depth) = (&parameters.wet_face, parameters.wet_face.depth());
    let (points, c) = (face.len(), parameters.sound_speed);
    let modes = points;
    let wavenumber = |m: usize| (2 * m + 1) as f64 * PI / (2.0 * depth);
    let Shared { poles, residues, error, loss } = shared()?;
    // ∫ φ_m N_i dy in the face's coordinates.
    let all_modes = (1 + SHORT) * modes;
    let mut integrals = DMatrix::<f64>::zeros(all_modes, points);
    for panel in face.panels() {
        let rule = gauss_legendre(12 + (0.5 * wavenumber(all_modes) * panel.length) as usize);
        let [start, end] = [face.points()[panel.start][1], face.points()[panel.start + 1][1]];
        for q in rule.iter() {
            let along = 0.5 * (1.0 + q.position);
            let (y, weight) = (start + along * (end - start), 0.5 * q.weight * panel.length);
            for m in 0..all_modes {
                let value = weight * (2.0 / depth).sqrt() * (wavenumber(m) * y).cos();
                integrals[(m, panel.start)] += value * (1.0 - along);
                integrals[(m, panel.start + 1)] += value * along;
            }
        }
    }
    let all_shapes = integrals * coordinates.of_integrals().transpose();
    let shapes = all_shapes.rows(0, modes).into_owned();
    let rates: Vec<f64> = (modes..=all_modes).map(|m| wavenumber(m) * c).collect();
    let (rest, rates) = remainder(&shapes, &all_shapes.rows(modes, all_modes - modes).into_owned(), &rates);
    let (left, right) = coordinates.restoring();
    // Inputs: velocities of the modes, of the points, of the modes from the bed, and zeros for Im b. Outputs: pressures of
    // the modes and of the remainder. The modes are filled up to whole blocks with poles without input.
    let (of_face, width) = (right.view((0, 0), (points, points)), modes.next_multiple_of(LANES));
    let mut project = DMatrix::zeros(4 * width, points + 2);
    project.view_mut((0, 0), (modes, points)).copy_from(&(&shapes * of_face));
    project.view_mut((width, 0), (rates.len(), points)).copy_from(&(rest.transpose() * of_face));
    // B a = −s b over −ρc, b = φ_m(0): −c s b/(s² + λ²c²)
    project.view_mut((2 * width, points + 1), (modes, 1)).fill(-c * (2.0 / depth).sqrt());
    let mut spread = DMatrix::zeros(points, 2 * width);
    spread.columns_mut(0, modes).copy_from(&(&left * shapes.transpose()));
    spread.columns_mut(width, rates.len()).copy_from(&(&left * &rest));
    let (mut all, mut weights, mut groups, mut channels) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut group = |driven: usize, channel: usize, pole: &dyn Fn(usize) -> [Complex64; 2]| {
        groups.push(Group { first: all.len(), length: width, driven: [driven, 3 * width] });
        channels.push(channel);
        for [pole, residue] in (0..width).map(pole) {
            all.push(pole);
            weights.push(residue);
        }
    };
    for (pole, residue) in poles.iter().zip(&residues) {
        group(0, 0, &|m| [pole * wavenumber(m) * c, 2.0 * residue * pole * wavenumber(m) * c]);
    }
    // s/(s + ν) = 1 − ν/(s + ν)
    group(width, width, &|i| [Complex64::from(-rates.get(i).copied().unwrap_or(1.0)); 2]);
    // s/((s + d)² + ω²): no pressure under a steady velocity, in spite of the decay d.
    let steady = Complex64::new(1.0, DECAY);
    group(2 * width, 0, &|m| [Complex64::new(-DECAY, 1.0) * wavenumber(m) * c, steady]);
    // The loss: δ σ/(σ + 1) = δ − δ/(σ + 1).
    group(0, 0, &|m| [1.0, loss.size].map(|x| Complex64::from(-x * loss.corner * wavenumber(m) * c)));
    let infinite: f64 = residues.iter().map(|residue| 2.0 * residue.re).sum::<f64>() + loss.size;
    let mut direct = DMatrix::zeros(points, points + 2);
    direct
        .columns_mut(0, points)
        .copy_from(&(shapes.transpose() * &shapes * infinite + &rest * rest.transpose()));
    let states = 2 * modes * (PAIRS + 1) + modes + rates.len();
    let ports = Ports {
        groups,
        inputs: Panels::of(&project),
        outputs: Outputs::Channels {
            channels,
            residues: parts(weights.into_iter()),
            spread: Panels::of(&spread),
        },
    };
    let recursion = Recursion::new(all, ports, left * direct * right, parameters.communication_step);
    Some((recursion, Quality { states, error, solved: 0, loss: loss.size }))
}

/// What the `shapes` leave over, `I − shapesᵀ shapes`, as the impedance `Σ_i y_i y_iᵀ s/(s + ν_i)`: y (columns) and ν (1/s).
///
/// Its waves are shorter than those of the shapes, and far below their cut-off frequencies, where they are a mass: that of
/// the `short` shapes, with `rates` λ_m c, and the last rate for what these leave over.
fn remainder(shapes: &DMatrix<f64>, short: &DMatrix<f64>, rates: &[f64]) -> (DMatrix<f64>, Vec<f64>) {
    let points = shapes.ncols();
    let rest = DMatrix::identity(points, points) - shapes.transpose() * shapes;
    let last = rates[short.nrows()];
    let heavier =
        DMatrix::from_fn(short.nrows(), points, |m, i| short[(m, i)] * (1.0 / rates[m] - 1.0 / last));
    let mass = short.transpose() * heavier + &rest / last;
    // With rest = y₀ y₀ᵀ, y₀ = U p^{1/2}, the mass is y₀ (p^{-1/2} Uᵀ mass U p^{-1/2}) y₀ᵀ.
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(rest);
    let kept: Vec<usize> = (0..points).filter(|&i| eigenvalues[i] > LEAST_SHARE).collect();
    let scaled = |power: f64| {
        let columns = kept.iter().map(|&i| eigenvectors.column(i) * eigenvalues[i].powf(power));
        DMatrix::from_columns(&columns.collect::<Vec<_>>())
    };
    let weights = scaled(-0.5);
    let of_mass = SymmetricEigen::new(weights.transpose() * mass * &weights);
    let rates = of_mass.eigenvalues.iter().map(|mass| 1.0 / mass).collect();
    (scaled(0.5) * of_mass.eigenvectors, rates)
}

/// `G(σ) ≈ Σ_j r_j σ/(σ − p_j) + … + δ σ/(σ + ω₀)` of conjugate pairs and the loss, and its error.
struct Shared {
    poles: Vec<Complex64>,
    residues: Vec<Complex64>,
    loss: Loss,
    error: f64,
}

/// The fit of G, with G′(0) = 1, and passive; it does not depend on any parameter.
///
/// None if its singular values do not converge.
fn shared() -> Option<Shared> {
    let exact = |sigma: Complex64| {
        let damped = sigma + DECAY;
        sigma / (1.0 + damped * damped).sqrt()
    };
    let ratio = (DISTANCES[1] / DISTANCES[0]).powf(1.0 / (PAIRS - 1) as f64);
    let poles: Vec<Complex64> =
        (0..PAIRS).map(|j| Complex64::new(-DECAY - DISTANCES[0] * ratio.powi(j as i32), 1.0)).collect();
    let frequencies = axis(160);
    let rows = 2 * frequencies.len();
    let (mut matrix, mut wanted) = (Mat::zeros(rows, 2 * PAIRS), Mat::zeros(rows, 1));
    for (k, &omega) in frequencies.iter().enumerate() {
        let sigma = Complex64::new(0.0, omega);
        let weight = 1.0 / exact(sigma).norm();
        let target = exact(sigma) * weight;
        (wanted[(2 * k, 0)], wanted[(2 * k + 1, 0)]) = (target.re, target.im);
        for (j, pole) in poles.iter().enumerate() {
            let [own, mirrored] = [sigma / (sigma - pole), sigma / (sigma - pole.conj())];
            for (part, factor) in [own + mirrored, Complex64::I * (own - mirrored)].into_iter().enumerate() {
                matrix[(2 * k, 2 * j + part)] = weight * factor.re;
                matrix[(2 * k + 1, 2 * j + part)] = weight * factor.im;
            }
        }
    }
    // e·x = t: the slope at 0. What is orthogonal to e is free.
    let slope = Mat::from_fn(2 * PAIRS, 1, |j, _| {
        let inverse = -1.0 / poles[j / 2];
        2.0 * if j % 2 == 0 { inverse.re } else { -inverse.im }
    });
    let square = slope.squared_norm_l2();
    let along = &slope * (1.0 / square);
    let free = Mat::<f64>::identity(2 * PAIRS, 2 * PAIRS) - &slope * slope.transpose() / square;
    let svd = (&matrix * &free).thin_svd().ok()?;
    let projected = svd.U().transpose() * (wanted - &matrix * &along);
    let values = svd.S().column_vector();
    let scaled = Mat::from_fn(2 * PAIRS, 1, |k, _| {
        if values[k] > ROUNDING * values[0] { projected[(k, 0)] / values[k] } else { 0.0 }
    });
    let found = &along + &free * (svd.V() * scaled);
    let mut residues: Vec<Complex64> =
        (0..PAIRS).map(|j| Complex64::new(found[(2 * j, 0)], found[(2 * j + 1, 0)])).collect();
    let mut fractions = PartialFractions {
        outputs: DMatrix::from_fn(1, PAIRS, |_, j| residues[j] * poles[j]),
        inputs: DMatrix::from_element(1, PAIRS, Complex64::ONE),
        direct: DMatrix::from_element(1, 1, residues.iter().map(|r| 2.0 * r.re).sum()),
        poles: poles.clone(),
    };
    let checks = axis(1601);
    // Divided by its slope with the loss, the sum has the slope 1.
    let none = Loss { size: 0.0, corner: CORNER };
    let needed = violations(&fractions, &checks, none).iter().map(|found| found.most).fold(0.0, f64::max);
    let whole = 1.0 / (1.0 + needed / CORNER);
    let loss = Loss { size: whole * needed, corner: CORNER };
    fractions.outputs *= Complex64::from(whole);
    fractions.direct *= whole;
    residues.iter_mut().for_each(|residue| *residue *= whole);
    loss.added_to(&mut fractions);
    let difference = |&omega: &f64| {
        let sigma = Complex64::new(0.0, omega);
        (fractions.evaluate(sigma)[(0, 0)] / exact(sigma) - 1.0).norm()
    };
    let error = checks.iter().map(difference).fold(0.0, f64::max);
    Some(Shared { poles, residues, loss, error })
}

/// Frequencies from 1e-4 to 1e4, denser towards 1 from both sides, ascending.
fn axis(count: usize) -> Vec<f64> {
    let geometric = |first: f64, last: f64| {
        let ratio = (last / first).powf(1.0 / (count - 1) as f64);
        (0..count).map(move |k| first * ratio.powi(k as i32))
    };
    let mut axis: Vec<f64> = geometric(1e-4, 0.9).chain(geometric(1.1, 1e4)).chain([1.0]).collect();
    axis.extend(geometric(1e-8, 0.1).flat_map(|distance| [1.0 - distance, 1.0 + distance]));
    axis.sort_by(f64::total_cmp);
    axis
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Error and loss are a few parts in a hundred thousand everywhere.
    #[test]
    fn one_function_fits_all_modes() {
        let Shared { error, loss, .. } = shared().expect("singular values");
        println!("σ/√(1 + σ²): relative error {error:.1e} with a loss of {:.1e}", loss.size);
        assert!(error < 1e-4 && loss.size < 1e-4);
    }
}
