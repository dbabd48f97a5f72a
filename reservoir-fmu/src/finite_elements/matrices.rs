use crate::ReservoirError;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::Llt;
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Mat, Side};
use num_complex::Complex64;

/// Mass, damping and stiffness of the water, symmetric, on one pattern.
///
/// `M p̈ + C ṗ + K p = …`; unknowns × unknowns, row by row, M in s², C in s, K without unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrices {
    starts: Vec<usize>,
    columns: Vec<usize>,
    mass: Vec<f64>,
    damping: Vec<f64>,
    stiffness: Vec<f64>,
}

/// An entry before assembly: row, column, and its contributions to M, C and K.
pub type Entry = (usize, usize, [f64; 3]);

impl Matrices {
    /// Sums the entries in the given order, so that symmetric entries give exactly symmetric matrices.
    pub fn new(size: usize, mut entries: Vec<Entry>) -> Self {
        entries.sort_by_key(|&(row, column, _)| (row, column));
        let mut matrices = Self {
            starts: vec![0; size + 1],
            columns: Vec::new(),
            mass: Vec::new(),
            damping: Vec::new(),
            stiffness: Vec::new(),
        };
        let mut last = None;
        for (row, column, [mass, damping, stiffness]) in entries {
            if last != Some((row, column)) {
                matrices.columns.push(column);
                matrices.mass.push(0.0);
                matrices.damping.push(0.0);
                matrices.stiffness.push(0.0);
                last = Some((row, column));
            }
            let at = matrices.columns.len() - 1;
            matrices.mass[at] += mass;
            matrices.damping[at] += damping;
            matrices.stiffness[at] += stiffness;
            matrices.starts[row + 1] = matrices.columns.len();
        }
        for row in 0..size {
            matrices.starts[row + 1] = matrices.starts[row + 1].max(matrices.starts[row]);
        }
        matrices
    }

    /// These matrices and further entries.
    pub fn plus(&self, further: Vec<Entry>) -> Self {
        let rows =
            (0..self.size()).flat_map(|row| (self.starts[row]..self.starts[row + 1]).map(move |k| (row, k)));
        let own =
            rows.map(|(row, k)| (row, self.columns[k], [self.mass[k], self.damping[k], self.stiffness[k]]));
        Self::new(self.size(), own.chain(further).collect())
    }

    /// With C + ηK in place of C; η in s.
    pub fn with_viscosity(mut self, viscosity: f64) -> Self {
        self.damping.iter_mut().zip(&self.stiffness).for_each(|(c, k)| *c += viscosity * k);
        self
    }

    /// Number of unknowns.
    pub fn size(&self) -> usize {
        self.starts.len() - 1
    }

    /// `M p + f K ψ`.
    pub fn mass_and_stiffness(&self, p: &[f64], factor: f64, psi: &[f64]) -> Vec<f64> {
        (0..self.size())
            .map(|row| {
                let entries = self.starts[row]..self.starts[row + 1];
                entries
                    .map(|k| {
                        self.mass[k] * p[self.columns[k]] + factor * self.stiffness[k] * psi[self.columns[k]]
                    })
                    .sum()
            })
            .collect()
    }

    /// `pᵀ M p`, `pᵀ C p` and `pᵀ K p`.
    pub fn forms(&self, p: &[f64]) -> [f64; 3] {
        let mut forms = [0.0; 3];
        for row in 0..self.size() {
            for k in self.starts[row]..self.starts[row + 1] {
                let product = p[row] * p[self.columns[k]];
                for (form, values) in forms.iter_mut().zip([&self.mass, &self.damping, &self.stiffness]) {
                    *form += values[k] * product;
                }
            }
        }
        forms
    }

    /// The sum of the three matrices with one factor each; it is symmetric, so rows and columns are equal.
    fn combined<T>(&self, combine: impl Fn(f64, f64, f64) -> T) -> SparseColMat<usize, T> {
        let (n, starts, columns) = (self.size(), self.starts.clone(), self.columns.clone());
        let values =
            (0..self.columns.len()).map(|k| combine(self.mass[k], self.damping[k], self.stiffness[k]));
        SparseColMat::new(SymbolicSparseColMat::new_checked(n, n, starts, None, columns), values.collect())
    }

    /// Cholesky factors of `M + H/2 C + H²/4 K`.
    ///
    /// **Errors**: [`ReservoirError::FiniteElementSystem`].
    pub fn factor(&self, step: f64) -> Result<Llt<usize, f64>, ReservoirError> {
        let half = 0.5 * step;
        self.combined(|mass, damping, stiffness| mass + half * damping + half * half * stiffness)
            .sp_cholesky(Side::Lower)
            .map_err(|_| ReservoirError::FiniteElementSystem { rate: 2.0 / step })
    }

    /// Solves `(s² M + s C + K) x = b` for every column of b.
    ///
    /// **Errors**: [`ReservoirError::FiniteElementSystem`].
    pub fn solve_at(
        &self,
        s: Complex64,
        mut right: Mat<Complex64>,
    ) -> Result<Mat<Complex64>, ReservoirError> {
        let factors = self
            .combined(|mass, damping, stiffness| s * s * mass + s * damping + stiffness)
            .sp_lu()
            .map_err(|_| ReservoirError::FiniteElementSystem { rate: s.norm() })?;
        factors.solve_in_place(right.as_mut());
        Ok(right)
    }
}

/// `A⁻¹ b` by the Cholesky factors of A.
pub fn solve(factors: &Llt<usize, f64>, right: &[f64]) -> Vec<f64> {
    let mut column = Mat::from_fn(right.len(), 1, |i, _| right[i]);
    factors.solve_in_place(column.as_mut());
    (0..right.len()).map(|i| column[(i, 0)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of three unknowns, an empty row between them: products and solutions against the dense matrix.
    #[test]
    fn products_and_solutions_of_a_small_system() {
        let entries = vec![
            (3, 3, [2.0, 0.5, 1.0]),
            (0, 0, [1.0, 0.0, 2.0]),
            (0, 1, [0.25, 0.0, -1.0]),
            (1, 0, [0.25, 0.0, -1.0]),
            (1, 1, [0.5, 0.0, 1.0]),
            (1, 1, [0.5, 0.0, 1.0]),
            (2, 2, [1.0, 0.0, 1.0]),
        ];
        let matrices = Matrices::new(4, entries);
        let (p, psi) = ([1.0, 2.0, 3.0, 4.0], [0.5, -1.0, 0.0, 2.0]);
        let product = matrices.mass_and_stiffness(&p, -2.0, &psi);
        assert_eq!(product, [1.5 - 4.0, 2.25 + 5.0, 3.0, 8.0 - 4.0]);
        assert_eq!(matrices.forms(&p), [1.0 + 1.0 + 4.0 + 9.0 + 32.0, 8.0, 2.0 - 4.0 + 8.0 + 9.0 + 16.0]);
        let solution = solve(&matrices.factor(2.0).unwrap(), &[3.0, -0.75 + 6.0, 6.0, 17.5]);
        // A = M + C + K with H = 2.
        let a = |x: &[f64]| [3.0 * x[0] - 0.75 * x[1], -0.75 * x[0] + 3.0 * x[1], 2.0 * x[2], 3.5 * x[3]];
        for (b, expected) in a(&solution).iter().zip([3.0, 5.25, 6.0, 17.5]) {
            assert!((b - expected).abs() < 1e-14);
        }
    }
}
