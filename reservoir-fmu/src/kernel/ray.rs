use complex_bessel::{Scaling, besselk_seq};
use num_complex::Complex64;
use std::f64::consts::PI;

/// Chebyshev coefficients per piece.
const ORDER: usize = 15;
/// Length of a piece in ln r.
const PIECE: f64 = 1.4;
/// Below this |kr|, two terms of the ascending series are exact to rounding.
pub(super) const SMALL: f64 = 1e-3;
/// Above this Re(kr), the kernels are below 1e-17 and taken as zero.
const FAR: f64 = 39.0;
/// Euler's constant.
const EULER: f64 = 0.577_215_664_901_532_9;

/// `K₀(kr)` and `k K₁(kr)` along the ray of one complex wavenumber `k`.
///
/// The scaled functions `√z e^z K_ν(z)`, `z = kr`, are smooth in ln r: piecewise Chebyshev
/// interpolation there needs about a hundred library calls for all distances of a mesh.
pub(crate) struct Ray {
    wavenumber: Complex64,
    inverse_root: Complex64,
    start: f64,
    /// Re, Im of the scaled K₀, then of the scaled K₁.
    pieces: Vec<[[f64; 4]; ORDER]>,
}

impl Ray {
    /// Tabulates distances up to `farthest` (m); `wavenumber` in 1/m, not 0 and with a real part that is not negative.
    pub fn new(wavenumber: Complex64, farthest: f64) -> Result<Self, complex_bessel::Error> {
        let start = (SMALL / wavenumber.norm()).ln();
        let end = farthest.min(FAR / wavenumber.re.abs()).ln();
        let count = ((end - start) / PIECE).floor().max(0.0) as usize + 1;
        let pieces = (0..count)
            .map(|piece| coefficients(wavenumber, start + piece as f64 * PIECE))
            .collect::<Result<_, _>>()?;
        Ok(Self { wavenumber, inverse_root: 1.0 / wavenumber.sqrt(), start, pieces })
    }

    /// k, 1/m.
    pub fn wavenumber(&self) -> Complex64 {
        self.wavenumber
    }

    /// The smaller of `farthest` and the distance (m) beyond which the kernels are zero.
    pub fn reach(&self, farthest: f64) -> f64 {
        farthest.min(FAR / self.wavenumber.re.abs())
    }

    /// `[K₀(kr), k K₁(kr)]` at the distance r (m).
    pub fn at(&self, r: f64) -> [Complex64; 2] {
        let z = self.wavenumber * r;
        if z.re > FAR {
            return [Complex64::ZERO; 2];
        }
        let position = (r.ln() - self.start) / PIECE;
        if position < 0.0 {
            return ascending_series(self.wavenumber, z);
        }
        let piece = (position as usize).min(self.pieces.len() - 1);
        let x = 2.0 * (position - piece as f64) - 1.0;
        let [re0, im0, re1, im1] = clenshaw(&self.pieces[piece], x);
        let decay = Complex64::from_polar((-z.re).exp() / r.sqrt(), -z.im) * self.inverse_root;
        [decay * Complex64::new(re0, im0), decay * self.wavenumber * Complex64::new(re1, im1)]
    }
}

/// `K₀` and `kK₁` from the first terms of their ascending series, Abramowitz and Stegun 9.6.11–13.
pub(super) fn ascending_series(wavenumber: Complex64, z: Complex64) -> [Complex64; 2] {
    let quarter = z * z / 4.0;
    let log = (z / 2.0).ln() + EULER;
    let k0 = -log * (1.0 + quarter) + quarter;
    let k1 = 1.0 / z + z / 2.0 * (log - 0.5);
    [k0, wavenumber * k1]
}

fn coefficients(wavenumber: Complex64, start: f64) -> Result<[[f64; 4]; ORDER], complex_bessel::Error> {
    let mut coefficients = [[0.0; 4]; ORDER];
    for node in 0..ORDER {
        let angle = PI * (node as f64 + 0.5) / ORDER as f64;
        let z = wavenumber * (start + PIECE * 0.5 * (1.0 + angle.cos())).exp();
        let values = besselk_seq(0.0, z, 2, Scaling::Exponential)?.values;
        let [k0, k1] = [values[0] * z.sqrt(), values[1] * z.sqrt()];
        for (degree, row) in coefficients.iter_mut().enumerate() {
            let weight = if degree == 0 { 1.0 } else { 2.0 } / ORDER as f64 * (degree as f64 * angle).cos();
            for (sum, value) in row.iter_mut().zip([k0.re, k0.im, k1.re, k1.im]) {
                *sum += weight * value;
            }
        }
    }
    Ok(coefficients)
}

/// Four Chebyshev series at `x` in [−1, 1] by Clenshaw's recurrence.
fn clenshaw(coefficients: &[[f64; 4]; ORDER], x: f64) -> [f64; 4] {
    let (mut b1, mut b2) = ([0.0; 4], [0.0; 4]);
    for row in coefficients[1..].iter().rev() {
        let mut next = [0.0; 4];
        for lane in 0..4 {
            next[lane] = 2.0 * x * b1[lane] - b2[lane] + row[lane];
        }
        (b2, b1) = (b1, next);
    }
    std::array::from_fn(|lane| x * b1[lane] - b2[lane] + coefficients[0][lane])
}

#[cfg(test)]
mod tests {
    use super::*;
    use complex_bessel::besselk;

    /// Interpolation converges to rounding; 1e-11 leaves two digits for cancellation in e^{-z}.
    #[test]
    fn ray_table_equals_library() -> Result<(), complex_bessel::Error> {
        let mut worst: f64 = 0.0;
        for k in [(1e-8, 0.0), (0.0, 0.7), (2e-4, 0.02), (3e-4, 0.9), (0.5, 1.2), (1.7, 0.0)] {
            let k = Complex64::new(k.0, k.1);
            let ray = Ray::new(k, 400.0)?;
            for step in 0..2000 {
                let r = 1e-9 * (400.0f64 / 1e-9).powf(step as f64 / 1999.0);
                let z = k * r;
                if z.re > FAR - 1.0 {
                    continue;
                }
                let [k0, k1] = ray.at(r);
                let exact = [besselk(0.0, z)?, k * besselk(1.0, z)?];
                worst = worst.max((k0 - exact[0]).norm() / exact[0].norm());
                worst = worst.max((k1 - exact[1]).norm() / exact[1].norm());
            }
        }
        println!("ray table against library Bessel functions: largest relative difference {worst:.1e}");
        assert!(worst < 1e-11);
        Ok(())
    }
}
