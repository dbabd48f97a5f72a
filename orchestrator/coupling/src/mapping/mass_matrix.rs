//! Integrals of products of hat functions.

use nalgebra::DMatrix;

/// `∫ N Nᵀ ds` of the hat functions of a face, tridiagonal; it decouples where two points coincide.
#[derive(Clone, Debug)]
pub(super) struct MassMatrix {
    diagonal: Vec<f64>,
    /// Entries beside the diagonal: a sixth of each panel's length.
    beside: Vec<f64>,
}

impl MassMatrix {
    /// The matrix of points at `positions` (m), of which pairs may coincide.
    pub fn new(positions: &[f64]) -> Self {
        let beside: Vec<f64> = positions.windows(2).map(|pair| (pair[1] - pair[0]) / 6.0).collect();
        let mut diagonal = vec![0.0; positions.len()];
        for (i, sixth) in beside.iter().enumerate() {
            diagonal[i] += 2.0 * sixth;
            diagonal[i + 1] += 2.0 * sixth;
        }
        Self { diagonal, beside }
    }

    /// `M v`.
    pub fn times(&self, vector: &[f64]) -> Vec<f64> {
        let mut product: Vec<f64> = self.diagonal.iter().zip(vector).map(|(m, v)| m * v).collect();
        for (i, m) in self.beside.iter().enumerate() {
            product[i] += m * vector[i + 1];
            product[i + 1] += m * vector[i];
        }
        product
    }

    /// Overwrites b with `M⁻¹ b`, by elimination; no pivot vanishes, because the matrix is diagonally dominant.
    pub fn solve(&self, b: &mut [f64]) {
        let mut pivots = self.diagonal.clone();
        for (i, m) in self.beside.iter().enumerate() {
            let factor = m / pivots[i];
            pivots[i + 1] -= factor * m;
            b[i + 1] -= factor * b[i];
        }
        let last = b.len() - 1;
        b[last] /= pivots[last];
        for (i, m) in self.beside.iter().enumerate().rev() {
            b[i] = (b[i] - m * b[i + 1]) / pivots[i];
        }
    }
}

/// `∫ N Pᵀ ds` of the hat functions of the points at `rows` and at `columns` (m); one row for each of the former.
///
/// Between the points of both, the integrand is quadratic, and Gauss' rule with two points is exact.
pub(super) fn products(rows: &[f64], columns: &[f64]) -> DMatrix<f64> {
    /// Positions of the two points in the interval from 0 to 1.
    const POINTS: [f64; 2] = [0.211_324_865_405_187_13, 0.788_675_134_594_812_9];
    let mut matrix = DMatrix::zeros(rows.len(), columns.len());
    for (i, r) in rows.windows(2).enumerate() {
        for (j, c) in columns.windows(2).enumerate() {
            let (start, end) = (r[0].max(c[0]), r[1].min(c[1]));
            if start >= end {
                continue;
            }
            for point in POINTS {
                let position = start * (1.0 - point) + end * point;
                let hats = |panel: &[f64]| {
                    let length = panel[1] - panel[0];
                    [(panel[1] - position) / length, (position - panel[0]) / length]
                };
                for (k, n) in hats(r).into_iter().enumerate() {
                    for (l, p) in hats(c).into_iter().enumerate() {
                        matrix[(i + k, j + l)] += (end - start) / 2.0 * n * p;
                    }
                }
            }
        }
    }
    matrix
}
