use faer::Mat;
use nalgebra::DMatrix;
use num_complex::Complex64;

/// A rational matrix function of s, real for real s:
///
/// ```text
/// G(s) = D + Σ_k c_k b_kᵀ / (s − λ_k)
/// ```
///
/// **Shapes**: D outputs × inputs, c_k outputs, b_k inputs. Of a pair of conjugate poles only the one with
/// Im λ > 0 is stored; it stands for both.
#[derive(Clone, Debug)]
pub(crate) struct PartialFractions {
    /// λ_k, 1/s; Re < 0, Im ≥ 0.
    pub poles: Vec<Complex64>,
    /// c_k, columns.
    pub outputs: DMatrix<Complex64>,
    /// b_k, columns.
    pub inputs: DMatrix<Complex64>,
    /// D.
    pub direct: DMatrix<f64>,
}

impl PartialFractions {
    /// G(s), outputs × inputs.
    pub fn evaluate(&self, s: Complex64) -> DMatrix<Complex64> {
        let (rows, columns, order) = (self.outputs.nrows(), self.inputs.nrows(), self.poles.len());
        // Both poles of a pair side by side: one product of 2 × order.
        let weights: Vec<[Complex64; 2]> = self
            .poles
            .iter()
            .map(|&pole| {
                let mirrored = if pole.im > 0.0 { 1.0 / (s - pole.conj()) } else { Complex64::ZERO };
                [1.0 / (s - pole), mirrored]
            })
            .collect();
        let outputs = Mat::from_fn(rows, 2 * order, |i, k| {
            let c = self.outputs[(i, k / 2)];
            weights[k / 2][k % 2] * if k % 2 == 0 { c } else { c.conj() }
        });
        let inputs = Mat::from_fn(2 * order, columns, |k, j| {
            let b = self.inputs[(j, k / 2)];
            if k % 2 == 0 { b } else { b.conj() }
        });
        let product = outputs * inputs;
        DMatrix::from_fn(rows, columns, |i, j| product[(i, j)] + self.direct[(i, j)])
    }

    /// `left G right`, whose poles are the same.
    pub fn transformed(&self, left: &DMatrix<f64>, right: &DMatrix<f64>) -> Self {
        let complex = |m: &DMatrix<f64>| m.map(Complex64::from);
        Self {
            poles: self.poles.clone(),
            outputs: complex(left) * &self.outputs,
            inputs: complex(&right.transpose()) * &self.inputs,
            direct: left * &self.direct * right,
        }
    }
}
