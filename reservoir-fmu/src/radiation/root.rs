use nalgebra::DMatrix;
use num_complex::Complex64;
use std::f64::consts::FRAC_PI_4;

/// The root of `z` that belongs to an outgoing wave: for Im z ≥ 0 the principal one.
///
/// Its branch cut is the negative imaginary axis, so that rounding of Im z below zero does not turn a
/// propagating mode, z < 0 and root +i|κ|, into an incoming one.
pub(super) fn outgoing_root(z: Complex64) -> Complex64 {
    Complex64::from_polar(1.0, FRAC_PI_4) * Complex64::new(z.im, -z.re).sqrt()
}

/// The square root of `matrix + shift I` whose eigenvalues are [`outgoing_root`]s, from the complex Schur form
/// (Björck and Hammarling 1983) of the matrix without the shift: a large shift would hide the rest in rounding.
pub(super) fn matrix_root(matrix: DMatrix<Complex64>, shift: Complex64) -> Option<DMatrix<Complex64>> {
    let size = matrix.nrows();
    let (q, t) = nalgebra::linalg::Schur::try_new(matrix, f64::EPSILON, 100 * size)?.unpack();
    let mut root: DMatrix<Complex64> = DMatrix::zeros(size, size);
    for j in 0..size {
        root[(j, j)] = outgoing_root(t[(j, j)] + shift);
        for i in (0..j).rev() {
            let inner: Complex64 = (i + 1..j).map(|k| root[(i, k)] * root[(k, j)]).sum();
            root[(i, j)] = (t[(i, j)] - inner) / (root[(i, i)] + root[(j, j)]);
        }
    }
    Some(&q * root * q.adjoint())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Also where the matrix is below the rounding of the shift.
    #[test]
    fn root_squares_to_the_matrix() {
        for shift in [0.0, 1.0, 1e6, 1e12, 1e18].map(|size| Complex64::new(0.8, 0.6) * size) {
            let matrix = DMatrix::from_fn(12, 12, |i, j| {
                let diagonal = if i == j { (i * i) as f64 } else { 0.0 };
                Complex64::new(diagonal - 3.0, 0.7 * ((i + j) as f64).cos())
            });
            let root = matrix_root(matrix.clone(), shift).unwrap();
            let whole = matrix + DMatrix::identity(12, 12) * shift;
            assert!((&root * &root - &whole).norm() < 1e-11 * whole.norm(), "{shift}");
        }
    }

    /// Upper half plane: Re ≥ 0; beside the negative axis, on either side of it: +i.
    #[test]
    fn propagating_modes_go_out() {
        for angle in 0..=18 {
            let root = outgoing_root(Complex64::from_polar(4.0, f64::from(angle) * 10f64.to_radians()));
            assert!(root.re >= -1e-15 && root.im >= -1e-15 && (root.norm() - 2.0).abs() < 1e-15);
        }
        for im in [1e-300, 0.0, -0.0, -1e-16] {
            assert!((outgoing_root(Complex64::new(-9.0, im)) - 3.0 * Complex64::I).norm() < 1e-15);
            assert!((outgoing_root(Complex64::new(9.0, im)) - 3.0).norm() < 1e-15);
        }
    }
}
