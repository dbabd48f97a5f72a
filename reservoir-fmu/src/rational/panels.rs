use nalgebra::DMatrix;
use pulp::{Arch, Simd, WithSimd};
use serde::{Deserialize, Serialize};

/// Rows that are summed together.
const ROWS: usize = 16;

/// A real matrix for products with vectors, in panels of 16 rows; a panel holds the columns from its first to its last
/// nonzero one.
///
/// The order of the sums does not depend on the width of the processor's registers.
#[derive(Serialize, Deserialize)]
pub(crate) struct Panels {
    rows: usize,
    columns: usize,
    panels: Vec<Panel>,
}

#[derive(Serialize, Deserialize)]
struct Panel {
    first: usize,
    columns: Vec<[f64; ROWS]>,
}

impl Panels {
    /// The panels of `matrix`.
    pub fn of(matrix: &DMatrix<f64>) -> Self {
        let (rows, columns) = matrix.shape();
        let panel = |start: usize| {
            let at = |row: usize, column: usize| if row < rows { matrix[(row, column)] } else { 0.0 };
            let used = |&column: &usize| (start..start + ROWS).any(|row| at(row, column) != 0.0);
            let first = (0..columns).find(used).unwrap_or(0);
            let end = (first..columns).rev().find(used).map_or(first, |last| last + 1);
            let column = |column: usize| std::array::from_fn(|row| at(start + row, column));
            Panel { first, columns: (first..end).map(column).collect() }
        };
        Self { rows, columns, panels: (0..rows).step_by(ROWS).map(panel).collect() }
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// `matrix × vector`.
    pub fn product(&self, vector: &[f64]) -> Vec<f64> {
        Arch::new().dispatch(Product { of: self, vector })
    }
}

/// A product, with the processor's widest registers.
struct Product<'a> {
    of: &'a Panels,
    vector: &'a [f64],
}

impl WithSimd for Product<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<f64> {
        let mut result = Vec::with_capacity(ROWS * self.of.panels.len());
        for Panel { first, columns } in &self.of.panels {
            // Two independent sums, of even and of odd columns, so that neither waits for the other.
            let (mut even, mut odd) = ([0.0; ROWS], [0.0; ROWS]);
            let vector = &self.vector[*first..][..columns.len()];
            let (pairs, last) = columns.as_chunks::<2>();
            let (vector_pairs, vector_last) = vector.as_chunks::<2>();
            for ([a, b], [x, y]) in pairs.iter().zip(vector_pairs) {
                for row in 0..ROWS {
                    even[row] += a[row] * x;
                    odd[row] += b[row] * y;
                }
            }
            for (a, x) in last.iter().zip(vector_last) {
                for row in 0..ROWS {
                    even[row] += a[row] * x;
                }
            }
            for row in 0..ROWS {
                even[row] += odd[row];
            }
            result.extend_from_slice(&even);
        }
        result.truncate(self.of.rows);
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    /// The product equals the dense one to rounding, with zeros in every corner, and fewer numbers are stored.
    #[test]
    fn a_product_is_that_of_the_whole_matrix() {
        for (rows, columns) in [(1, 1), (16, 3), (40, 42), (120, 42), (37, 200), (5, 0)] {
            let matrix = DMatrix::from_fn(rows, columns, |i, j| {
                let inside = (i / 7 + j / 5) % 3 != 1 && j + 20 > i && i + 30 > j;
                if inside { ((i * 31 + j * 17) as f64).sin() } else { 0.0 }
            });
            let vector = DVector::from_fn(columns, |j, _| (0.7 * j as f64).cos());
            let panels = Panels::of(&matrix);
            let product = DVector::from_vec(panels.product(vector.as_slice()));
            let off = (product - &matrix * vector).amax();
            let held: usize = panels.panels.iter().map(|panel| ROWS * panel.columns.len()).sum();
            println!("{rows} × {columns}: {held} numbers held, off by {off:.1e}");
            assert!(off < 1e-13 && held <= rows.next_multiple_of(ROWS) * columns);
        }
        let corner = DMatrix::from_fn(64, 50, |i, j| if i < 16 && j >= 40 { 1.0 } else { 0.0 });
        let panels = Panels::of(&corner).panels;
        assert_eq!(panels.iter().map(|panel| panel.columns.len()).collect::<Vec<_>>(), [10, 0, 0, 0]);
    }
}
