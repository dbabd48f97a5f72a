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
use nalgebra::DMatrix;
use num_complex::Complex64;
use std::f64::consts::PI;

/// Pairs of poles.
const PAIRS: usize = 20;
/// Distances of the first and the last pole from the branch point.
const DISTANCES: [f64; 2] = [1e-6, 30.0];
/// Decay that is added, divided by the mode's frequency: without it, no finite number of poles is accurate at σ = i.
const DECAY: f64 = 1e-5;
/// Singular values below this fraction of the largest are left out.
const ROUNDING: f64 = 1e-13;

/// The recursion of such water.
pub(super) fn recursion(parameters: &ReservoirParameters, coordinates: &Coordinates) -> (Recursion, Quality) {
    let (face, depth) = (&parameters.wet_face, parameters.wet_face.depth());
    let (points, c) = (face.len(), parameters.sound_speed);
    let modes = points;
    let wavenumber = |m: usize| (2 * m + 1) as f64 * PI / (2.0 * depth);
    let Shared { poles, residues, error, loss } = shared();
    // ∫ φ_m N_i dy in the face's coordinates.
    let mut integrals = DMatrix::<f64>::zeros(modes, points);
    for panel in face.panels() {
        let rule = gauss_legendre(12 + (0.5 * wavenumber(modes) * panel.length) as usize);
        let [start, end] = [face.points()[panel.start][1], face.points()[panel.start + 1][1]];
        for q in rule.iter() {
            let along = 0.5 * (1.0 + q.position);
            let (y, weight) = (start + along * (end - start), 0.5 * q.weight * panel.length);
            for m in 0..modes {
                let value = weight * (2.0 / depth).sqrt() * (wavenumber(m) * y).cos();
                integrals[(m, panel.start)] += value * (1.0 - along);
                integrals[(m, panel.start + 1)] += value * along;
            }
        }
    }
    let shapes = integrals * coordinates.of_integrals().transpose();
    let rest = DMatrix::identity(points, points) - shapes.transpose() * &shapes;
    let (left, right) = coordinates.restoring();
    // Inputs: velocities of the modes, of the points, of the modes from the bed, and zeros for Im b. Outputs: pressures of
    // the modes and of the remainder. The modes are filled up to whole blocks with poles without input.
    let (of_face, width) = (right.view((0, 0), (points, points)), modes.next_multiple_of(LANES));
    let mut project = DMatrix::zeros(4 * width, points + 2);
    project.view_mut((0, 0), (modes, points)).copy_from(&(&shapes * of_face));
    project.view_mut((width, 0), (points, points)).fill_with_identity();
    // B a = −s b over −ρc, b = φ_m(0): −c s b/(s² + λ²c²)
    project.view_mut((2 * width, points + 1), (modes, 1)).fill(-c * (2.0 / depth).sqrt());
    let mut spread = DMatrix::zeros(points, 2 * width);
    spread.columns_mut(0, modes).copy_from(&(&left * shapes.transpose()));
    spread.columns_mut(width, points).copy_from(&(&left * &rest * of_face));
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
    let next = Complex64::from(-wavenumber(modes) * c);
    group(width, width, &|_| [next, next]);
    group(2 * width, 0, &|m| [Complex64::new(-DECAY, 1.0) * wavenumber(m) * c, Complex64::ONE]);
    let infinite: f64 = residues.iter().map(|residue| 2.0 * residue.re).sum();
    let mut direct = DMatrix::zeros(points, points + 2);
    direct.columns_mut(0, points).copy_from(&(shapes.transpose() * &shapes * infinite + &rest));
    for i in 0..points {
        direct[(i, i)] += loss.everywhere;
    }
    let states = 2 * modes * (PAIRS + 1) + points;
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
    (recursion, Quality { states, error, solved: 0, loss })
}

/// `G(σ) ≈ Σ_j r_j σ/(σ − p_j) + …` of conjugate pairs, and its error.
struct Shared {
    poles: Vec<Complex64>,
    residues: Vec<Complex64>,
    error: f64,
    loss: Loss,
}

/// The fit of G; it does not depend on any parameter.
fn shared() -> Shared {
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
    let mut found = vec![0.0; 2 * PAIRS];
    if let Ok(svd) = matrix.thin_svd() {
        let projected = svd.U().transpose() * wanted;
        let values = svd.S().column_vector();
        for k in (0..2 * PAIRS).filter(|&k| values[k] > ROUNDING * values[0]) {
            for (j, value) in found.iter_mut().enumerate() {
                *value += svd.V()[(j, k)] * projected[(k, 0)] / values[k];
            }
        }
    }
    let residues: Vec<Complex64> = found.chunks(2).map(|pair| Complex64::new(pair[0], pair[1])).collect();
    let fractions = PartialFractions {
        outputs: DMatrix::from_fn(1, PAIRS, |_, j| residues[j] * poles[j]),
        inputs: DMatrix::from_element(1, PAIRS, Complex64::ONE),
        direct: DMatrix::from_element(1, 1, residues.iter().map(|r| 2.0 * r.re).sum()),
        poles: poles.clone(),
    };
    let checks = axis(1601);
    let difference = |&omega: &f64| {
        let sigma = Complex64::new(0.0, omega);
        (fractions.evaluate(sigma)[(0, 0)] / exact(sigma) - 1.0).norm()
    };
    let error = checks.iter().map(difference).fold(0.0, f64::max);
    let loss = Loss::against(&violations(&fractions, &checks, 0.0), f64::INFINITY);
    Shared { poles, residues, error, loss }
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
        let Shared { error, loss, .. } = shared();
        println!("σ/√(1 + σ²): relative error {error:.1e}, loss {loss:?}");
        assert!(error < 2e-4 && loss.everywhere < 1e-4 && loss.above_corner == 0.0);
    }
}
