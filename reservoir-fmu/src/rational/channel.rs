//! Water over a level bed before a vertical face: its impedance in the channel's own functions.
//!
//! With the functions φ_m of a rigid bed `B = Λ + q s b bᵀ + (s/c)² I` is the channel's operator,
//! `b_m = φ_m(0)`. Then
//!
//! ```text
//! p = −ρ s B^{-1/2} v,   B^{-1/2} = (2/π) ∫₀^∞ (B + t²)⁻¹ dt = D^{-1/2} − (2/π) q s ∫₀^∞ d dᵀ/(1 + q s bᵀd) dt,
//! D = Λ + (s/c)²,  d(t) = (D + t²)⁻¹ b
//! ```
//!
//! (Sherman and Morrison). The poles in t lie outside the first quadrant for Im s ≥ 0, so that the path may be
//! turned to `t = e^{iπ/4} e^x`, where the trapezoidal rule in x converges exponentially. At its cut-off
//! frequency a function's D is 0, and both terms are infinite while their difference is finite. The function
//! nearest to its cut-off frequency is therefore treated apart.

use super::product::{product, product_with_transpose};
use crate::quadrature::{gauss_legendre, legendre};
use crate::{ReservoirError, ReservoirParameters};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use num_complex::Complex64;
use std::f64::consts::PI;

/// Number of functions over the depth per interface point.
const FUNCTIONS_PER_POINT: f64 = 2.5;
/// Smallest and largest number of functions.
const FUNCTIONS: (f64, f64) = (32.0, 256.0);
/// Step of the trapezoidal rule in ln|t|: e^{−2π (π/4)/0.25} = 3e-9.
const SPACING: f64 = 0.25;
/// Ends of the path, divided by the lowest and the highest λ.
const PATH: (f64, f64) = (1e-8, 1e3);

/// The channel, projected on the interface points.
pub(crate) struct Channel {
    /// λ², 1/m².
    squared: Vec<f64>,
    /// b = φ(0), m^{-1/2}.
    at_bed: Vec<f64>,
    /// `∫ φ_m N_i dy` in the coordinates of the face: points × functions.
    projection: DMatrix<Complex64>,
    /// `projection projectionᵀ`.
    within: DMatrix<Complex64>,
    /// λ of the shortest waves that the functions represent, 1/m.
    shortest: f64,
    sound_speed: f64,
    admittance: f64,
}

impl Channel {
    /// The channel of `parameters`; `of_integrals` are the face's coordinates of integrals with its hat functions.
    pub fn new(
        parameters: &ReservoirParameters,
        of_integrals: &DMatrix<f64>,
    ) -> Result<Self, ReservoirError> {
        let (face, depth) = (&parameters.wet_face, parameters.wet_face.depth());
        let size = (FUNCTIONS_PER_POINT * face.len() as f64).clamp(FUNCTIONS.0, FUNCTIONS.1) as usize;
        let (squared, vectors) = functions(size, depth)?;
        let rule = gauss_legendre(32);
        // Integrals of the polynomials with the hat functions, then of the functions.
        let mut integrals = DMatrix::<f64>::zeros(size, face.len());
        for panel in face.panels() {
            let [start, end] = [face.points()[panel.start][1], face.points()[panel.start + 1][1]];
            for q in rule.iter() {
                let along = 0.5 * (1.0 + q.position);
                let position = 2.0 * (start + along * (end - start)) / depth - 1.0;
                let weight = 0.5 * q.weight * panel.length;
                for (i, value) in basis(size, position).into_iter().enumerate() {
                    integrals[(i, panel.start)] += weight * value * (1.0 - along);
                    integrals[(i, panel.start + 1)] += weight * value * along;
                }
            }
        }
        let at_bed = vectors.transpose() * DVector::from_vec(basis(size, -1.0));
        let projection = of_integrals * (integrals.transpose() * vectors);
        Ok(Self {
            squared,
            at_bed: at_bed.data.into(),
            within: (&projection * projection.transpose()).map(Complex64::from),
            projection: projection.map(Complex64::from),
            shortest: 2.0 * size as f64 / depth,
            sound_speed: parameters.sound_speed,
            admittance: parameters.bed_admittance(),
        })
    }

    /// Ĝ(s): points × (points + 2), `ground` being the coordinate of the ground's velocity along y.
    pub fn symbol(&self, s: Complex64, ground: f64) -> DMatrix<Complex64> {
        let size = self.squared.len();
        let points = self.projection.nrows();
        let wavenumber = s / self.sound_speed;
        let diagonal: Vec<Complex64> = self.squared.iter().map(|l| l + wavenumber * wavenumber).collect();
        let bed = self.admittance * s;
        // The remainder: waves shorter than π points per wave.
        let rest = wavenumber / (wavenumber * wavenumber + self.shortest * self.shortest).sqrt();
        let absorbing = self.admittance > 0.0;
        let nearest =
            (0..size).min_by(|&a, &b| diagonal[a].norm().total_cmp(&diagonal[b].norm())).unwrap_or(0);
        let closed = |m: usize| absorbing && m == nearest;
        let plain = |m: usize| if closed(m) { Complex64::ZERO } else { wavenumber / diagonal[m].sqrt() };
        let mut weighted = self.projection.clone();
        weighted.column_iter_mut().enumerate().for_each(|(m, mut column)| column *= plain(m));
        let mut symbol = product_with_transpose(&weighted, &self.projection);
        symbol += (DMatrix::identity(points, points) - &self.within) * rest;
        if absorbing {
            let Path { nodes, weights, own } = self.path(&diagonal, bed, nearest);
            let projected = product(&self.projection, &nodes);
            let mut weighted = projected.clone();
            let columns = weighted.column_iter_mut().zip(&weights);
            columns.for_each(|(mut column, [weight, _])| column *= weight * wavenumber);
            symbol -= product_with_transpose(&weighted, &projected);
            let along = self.projection.column(nearest).into_owned();
            let across =
                projected * DVector::from_iterator(weights.len(), weights.iter().map(|w| w[1] * wavenumber));
            symbol -= &across * along.transpose() + &along * across.transpose();
            symbol += &along * along.transpose() * (own * wavenumber);
        }
        // The bed moves up: B a = −s b, over −ρc.
        let over: Vec<Complex64> = (0..size).map(|m| self.at_bed[m] / diagonal[m]).collect();
        let through: Complex64 = over.iter().zip(&self.at_bed).map(|(a, b)| a * b).sum();
        let factor = -wavenumber * ground / (1.0 + bed * through);
        let column = &self.projection * DVector::from_iterator(size, over.iter().map(|a| a * factor));
        let mut whole = DMatrix::zeros(points, points + 2);
        whole.columns_mut(0, points).copy_from(&symbol);
        whole.set_column(points + 1, &column);
        whole
    }

    /// Ĝ′(0), the added mass: `∂p/∂n = 0` holds on the bed, `B = Λ`.
    pub fn slope(&self, ground: f64) -> DMatrix<f64> {
        let (points, size) = self.projection.shape();
        let projection = self.projection.map(|z| z.re);
        let weighted = |weight: &dyn Fn(f64) -> f64| {
            DMatrix::from_fn(points, size, |i, m| {
                projection[(i, m)] * weight(self.squared[m]) / self.sound_speed
            })
        };
        let within = self.within.map(|z| z.re);
        let rest = (DMatrix::identity(points, points) - within) / (self.shortest * self.sound_speed);
        let mut slope = DMatrix::zeros(points, points + 2);
        slope
            .columns_mut(0, points)
            .copy_from(&(weighted(&|l| 1.0 / l.sqrt()) * projection.transpose() + rest));
        let lifted = weighted(&|l| -ground / l) * DVector::from_column_slice(&self.at_bed);
        slope.set_column(points + 1, &lifted);
        slope
    }

    /// The integral over t, with the function `nearest` to its cut-off treated apart.
    fn path(&self, diagonal: &[Complex64], bed: Complex64, nearest: usize) -> Path {
        let size = diagonal.len();
        let first = (PATH.0 * self.squared[0].sqrt()).ln();
        let last = (PATH.1 * self.squared[size - 1].sqrt()).ln();
        let count = ((last - first) / SPACING).ceil() as usize;
        let mut nodes = DMatrix::zeros(size, count);
        let mut own = Complex64::ZERO;
        let weights = (0..count)
            .map(|k| {
                let t = Complex64::from_polar((first + SPACING * k as f64).exp(), PI / 4.0);
                let mut through = Complex64::ZERO;
                for m in (0..size).filter(|&m| m != nearest) {
                    let d = self.at_bed[m] / (diagonal[m] + t * t);
                    through += self.at_bed[m] * d;
                    nodes[(m, k)] = d;
                }
                let (others, b, d) = (1.0 + bed * through, self.at_bed[nearest], diagonal[nearest] + t * t);
                let weight = 2.0 / PI * SPACING * t / (d * others + bed * b * b);
                own += weight * others;
                [weight * bed * d, weight * bed * b]
            })
            .collect();
        // The rest of the sum of (2/π) Δx/t beyond the end of the path, for the function treated apart.
        let end = Complex64::from_polar((-first - SPACING * (count - 1) as f64).exp(), -PI / 4.0);
        own += 2.0 / PI * SPACING / SPACING.exp_m1() * end;
        Path { nodes, weights, own }
    }
}

/// The integral over t in terms of d, whose component of the function nearest to its cut-off is left out.
struct Path {
    /// d(t) at the nodes, columns.
    nodes: DMatrix<Complex64>,
    /// Weights of `d dᵀ` and of d times the function treated apart.
    weights: Vec<[Complex64; 2]>,
    /// B^{-1/2} of that function.
    own: Complex64,
}

/// `P_i(t) − P_{i+1}(t)`, i < `size`: zero at the surface t = 1.
fn basis(size: usize, t: f64) -> Vec<f64> {
    (0..size).map(|i| legendre(i, t).0 - legendre(i + 1, t).0).collect()
}

/// λ_m² (ascending, 1/m²) and the coefficients of φ_m in the basis, orthonormal over the depth, of a rigid bed.
fn functions(size: usize, depth: f64) -> Result<(Vec<f64>, DMatrix<f64>), ReservoirError> {
    let rule = gauss_legendre(size + 2);
    let (mut values, mut slopes) = (DMatrix::zeros(rule.len(), size), DMatrix::zeros(rule.len(), size));
    for (k, q) in rule.iter().enumerate() {
        for i in 0..size {
            let ((p, dp), (next, dnext)) = (legendre(i, q.position), legendre(i + 1, q.position));
            values[(k, i)] = (p - next) * (0.5 * depth * q.weight).sqrt();
            slopes[(k, i)] = (dp - dnext) * (2.0 / depth * q.weight).sqrt();
        }
    }
    let singular = ReservoirError::FarEnd { frequency: Complex64::ZERO };
    let mass: DMatrix<f64> = values.transpose() * &values;
    let inverse = mass.cholesky().and_then(|c| c.l().try_inverse()).ok_or(singular)?;
    let eigen = SymmetricEigen::new(&inverse * (slopes.transpose() * &slopes) * inverse.transpose());
    let mut order: Vec<usize> = (0..size).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let vectors = inverse.transpose() * eigen.eigenvectors;
    Ok((order.iter().map(|&m| eigen.eigenvalues[m]).collect(), vectors.select_columns(&order)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Far below the first cut-off frequency `Ĝ(s)/s` is the slope, also over a bed that absorbs.
    #[test]
    fn the_slope_is_that_of_the_symbol() -> Result<(), Box<dyn std::error::Error>> {
        for alpha in [1.0, 0.5, 0.0] {
            let parameters = ReservoirParameters {
                wave_reflection_coefficient: alpha,
                ..ReservoirParameters::before(WetFace::straight([0.0, 100.0], 12)?)
            };
            let coordinates = Coordinates::new(&parameters.wet_face, 1.44e6).ok_or("no coordinates")?;
            let channel = Channel::new(&parameters, &coordinates.of_integrals())?;
            let (s, slope) = (Complex64::new(1e-4, 0.0), channel.slope(coordinates.ground_scale()));
            let symbol = channel.symbol(s, coordinates.ground_scale()).map(|g| (g / s).re);
            let off = (&symbol - &slope).norm() / slope.norm();
            println!("α = {alpha}: Ĝ/s at {s} off the slope by {off:.1e}");
            assert!(off < 2e-5);
        }
        Ok(())
    }
    use crate::analytical::fenves_chopra_1984;
    use crate::rational::coordinates::Coordinates;
    use cofferdam_unit::WetFace;

    /// The force of a uniform motion, divided by ρ a h², against the modes with each eigenvalue computed separately.
    #[test]
    fn force_equals_the_modal_series() -> Result<(), Box<dyn std::error::Error>> {
        let (depth, c) = (100.0, 1440.0);
        for alpha in [0.9, 0.5, 0.0] {
            let parameters = ReservoirParameters {
                wave_reflection_coefficient: alpha,
                ..ReservoirParameters::before(WetFace::straight([0.0, depth], 20)?)
            };
            let coordinates = Coordinates::new(&parameters.wet_face, 1000.0 * c).ok_or("no coordinates")?;
            let channel = Channel::new(&parameters, &coordinates.of_integrals())?;
            let (left, right) = coordinates.restoring();
            for ratio in [0.1, 0.9, 1.0, 2.4, 7.3, 19.1] {
                let s = Complex64::new(0.0, ratio * PI * c / (2.0 * depth));
                let symbol = channel.symbol(s, coordinates.ground_scale());
                let k = left.map(Complex64::from) * symbol * right.map(Complex64::from);
                let p: Vec<Complex64> =
                    (0..21).map(|i| -k.row(i).columns(0, 21).sum() / (s * 1000.0)).collect();
                let exact = fenves_chopra_1984::force(s, depth, c, alpha);
                // The projection by hat functions preserves the integral.
                let force: Complex64 = p.windows(2).map(|pair| (pair[0] + pair[1]) * depth / 40.0).sum();
                let error = (force - exact).norm() / exact.norm();
                println!("α = {alpha}, ω = {ratio} ω₁: force off the modal series by {error:.1e}");
                assert!(error < 3e-4);
            }
        }
        Ok(())
    }
}
