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

    /// `(G(s) − G(0) − s G′(0))/s² = Σ_k c_k b_kᵀ/(λ_k² (s − λ_k))`.
    pub fn beyond_slope(&self) -> Self {
        let mut beyond = self.clone();
        for (mut column, pole) in beyond.outputs.column_iter_mut().zip(&self.poles) {
            column /= pole * pole;
        }
        beyond.direct.fill(0.0);
        beyond
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

#[cfg(test)]
mod tests {
    use super::*;

    /// `G(0) + s G′(0) + s² (the rest)` is G again, with the value and the slope at 0 written out.
    #[test]
    fn value_and_slope_at_zero_are_taken_off() {
        let fractions = PartialFractions {
            poles: vec![Complex64::new(-2.0, 0.0), Complex64::new(-0.5, 3.0)],
            outputs: DMatrix::from_row_slice(1, 2, &[Complex64::new(1.5, 0.0), Complex64::new(0.3, -0.8)]),
            inputs: DMatrix::from_row_slice(1, 2, &[Complex64::new(1.0, 0.0), Complex64::new(0.2, 0.9)]),
            direct: DMatrix::from_element(1, 1, 0.7),
        };
        let products = [0, 1].map(|k| fractions.outputs[(0, k)] * fractions.inputs[(0, k)]);
        let moment = |power: i32| {
            products[0].re / (-2.0f64).powi(power) + 2.0 * (products[1] / fractions.poles[1].powi(power)).re
        };
        for s in [Complex64::new(0.0, 1e-3), Complex64::new(0.0, 2.9), Complex64::new(4.0, -1.0)] {
            let rest = fractions.beyond_slope().evaluate(s)[(0, 0)];
            let again = 0.7 - moment(1) - s * moment(2) + s * s * rest;
            assert!((again - fractions.evaluate(s)[(0, 0)]).norm() < 1e-14);
        }
    }
}
