use nalgebra::{DMatrix, SymmetricEigen};
use num_complex::Complex64;

/// Smallest singular value of the response at a high frequency, divided by ρc, that counts.
const LEAST: f64 = 1e-2;

/// The velocities at the interface points that the elements represent.
///
/// Where panels are finer than the elements, some velocities cause no pressure. For these the impedance and its Hermitian
/// part are zero, and the error of a fit could produce energy. They are left out of inputs and outputs, so that they cause
/// no pressure after the fit either.
pub(crate) struct Range {
    /// Orthonormal columns: points × rank.
    basis: DMatrix<f64>,
    /// The same for all velocities, with those of the ground: inputs × (rank + inputs of the ground).
    inputs: DMatrix<f64>,
}

impl Range {
    /// The range from Ĝ at a frequency at which the impedance of every represented velocity is about ρc.
    pub fn of(high: &DMatrix<Complex64>) -> Self {
        let (points, inputs) = high.shape();
        let face = high.columns(0, points).map(|g| g.re);
        let eigen = SymmetricEigen::new(face.transpose() * face);
        let felt: Vec<usize> = (0..points).filter(|&k| eigen.eigenvalues[k] > LEAST * LEAST).collect();
        let (rank, ground) = (felt.len(), inputs - points);
        let basis = match rank < points {
            true => eigen.eigenvectors.select_columns(&felt),
            false => DMatrix::identity(points, points),
        };
        let mut whole = DMatrix::zeros(inputs, rank + ground);
        whole.view_mut((0, 0), (points, rank)).copy_from(&basis);
        whole.view_mut((points, rank), (ground, ground)).fill_with_identity();
        Self { basis, inputs: whole }
    }

    /// Ĝ within the range: rank × (rank + inputs of the ground).
    pub fn within(&self, value: &DMatrix<Complex64>) -> DMatrix<Complex64> {
        let complex = |m: &DMatrix<f64>| m.map(Complex64::from);
        complex(&self.basis.transpose()) * value * complex(&self.inputs)
    }

    /// The left and right factors that turn it into Ĝ again.
    pub fn restoring(&self) -> (&DMatrix<f64>, DMatrix<f64>) {
        (&self.basis, self.inputs.transpose())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three points, of which only the sum of the last two is represented: the part within the range gives the whole.
    #[test]
    fn nothing_that_is_felt_is_lost() {
        let felt = DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 0.0, 0.5f64.sqrt(), 0.0, 0.5f64.sqrt()]);
        let inner = DMatrix::from_row_slice(2, 2, &[1.0, 0.2, 0.2, 0.7]);
        let mut value = DMatrix::zeros(3, 4);
        value.columns_mut(0, 3).copy_from(&(&felt * inner * felt.transpose()));
        value.set_column(3, &(&felt * nalgebra::DVector::from_vec(vec![0.3, -0.1])));
        let value = value.map(|x| Complex64::new(x, 2.0 * x));
        let range = Range::of(&value);
        let (left, right) = range.restoring();
        let within = range.within(&value);
        assert_eq!(within.shape(), (2, 3));
        let again = left.map(Complex64::from) * within * right.map(Complex64::from);
        assert!((again - value).norm() < 1e-14);
    }
}
