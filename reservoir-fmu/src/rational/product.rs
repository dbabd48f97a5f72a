use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::DMatrix;
use num_complex::Complex64;

/// `a b`. nalgebra computes products of complex matrices one number after the other.
pub(super) fn product(a: &DMatrix<Complex64>, b: &DMatrix<Complex64>) -> DMatrix<Complex64> {
    of_views(view(a), view(b))
}

/// `a bᵀ`.
pub(super) fn product_with_transpose(a: &DMatrix<Complex64>, b: &DMatrix<Complex64>) -> DMatrix<Complex64> {
    of_views(view(a), view(b).transpose())
}

fn view(matrix: &DMatrix<Complex64>) -> MatRef<'_, Complex64> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}

fn of_views(a: MatRef<'_, Complex64>, b: MatRef<'_, Complex64>) -> DMatrix<Complex64> {
    let (rows, columns) = (a.nrows(), b.ncols());
    let mut product = DMatrix::zeros(rows, columns);
    let into = MatMut::from_column_major_slice_mut(product.as_mut_slice(), rows, columns);
    matmul(into, Accum::Replace, a, b, Complex64::ONE, Par::Seq);
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_those_of_the_definition() {
        let number = |i: usize, j: usize| Complex64::from_polar(1.0 + i as f64, (3 * i + 7 * j) as f64);
        for (rows, inner, columns) in [(1, 1, 1), (5, 3, 4), (13, 17, 9), (3, 0, 2)] {
            let a = DMatrix::from_fn(rows, inner, number);
            let b = DMatrix::from_fn(inner, columns, |i, j| number(j + 2, i));
            let exact = &a * &b;
            for found in [product(&a, &b), product_with_transpose(&a, &b.transpose())] {
                assert!((found - &exact).norm() <= 1e-13 * exact.norm(), "{rows} × {inner} × {columns}");
            }
        }
    }
}
