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
    /// G(s), outputs × inputs; many s take less time by the [`Evaluator`].
    pub fn evaluate(&self, s: Complex64) -> DMatrix<Complex64> {
        Evaluator::of(self).at(s)
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

/// A rational function, to be evaluated at many s by products of real matrices:
///
/// ```text
/// c bᵀ g + c̄ b̄ᵀ ḡ = (Re c (g + ḡ) + Im c i(g − ḡ)) Re bᵀ + (Re c i(g − ḡ) − Im c (g + ḡ)) Im bᵀ
/// ```
///
/// with `g = 1/(s − λ)` and `ḡ = 1/(s − λ̄)`, which is 0 for a real pole.
pub(crate) struct Evaluator<'a> {
    fractions: &'a PartialFractions,
    /// Re c, then Im c of every pole.
    outputs: [Vec<f64>; 2],
    /// Rows: Re b, then Im b of each pole.
    inputs: DMatrix<f64>,
}

impl<'a> Evaluator<'a> {
    pub fn of(fractions: &'a PartialFractions) -> Self {
        let c = fractions.outputs.as_slice();
        let b = |part: usize, j: usize| {
            let b = fractions.inputs[(j, part / 2)];
            if part.is_multiple_of(2) { b.re } else { b.im }
        };
        Self {
            outputs: [c.iter().map(|c| c.re).collect(), c.iter().map(|c| c.im).collect()],
            inputs: DMatrix::from_fn(2 * fractions.poles.len(), fractions.inputs.nrows(), b),
            fractions,
        }
    }

    /// G(s), outputs × inputs.
    pub fn at(&self, s: Complex64) -> DMatrix<Complex64> {
        let PartialFractions { poles, direct, .. } = self.fractions;
        let (rows, columns) = direct.shape();
        // Real above imaginary parts.
        let mut left = DMatrix::zeros(2 * rows, 2 * poles.len());
        let [re, im] = self.outputs.each_ref().map(|part| part.chunks_exact(rows));
        for (((pole, p), q), columns) in
            poles.iter().zip(re).zip(im).zip(left.as_mut_slice().chunks_exact_mut(4 * rows))
        {
            let own = 1.0 / (s - pole);
            let mirrored = if pole.im > 0.0 { 1.0 / (s - pole.conj()) } else { Complex64::ZERO };
            let (sum, turned) = (own + mirrored, Complex64::I * (own - mirrored));
            let (first, second) = columns.split_at_mut(2 * rows);
            let ((a, b), (c, d)) = (first.split_at_mut(rows), second.split_at_mut(rows));
            for i in 0..rows {
                a[i] = p[i] * sum.re + q[i] * turned.re;
                b[i] = p[i] * sum.im + q[i] * turned.im;
                c[i] = p[i] * turned.re - q[i] * sum.re;
                d[i] = p[i] * turned.im - q[i] * sum.im;
            }
        }
        let product = left * &self.inputs;
        DMatrix::from_fn(rows, columns, |i, j| {
            Complex64::new(product[(i, j)] + direct[(i, j)], product[(rows + i, j)])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two outputs, three inputs, a real pole and a pair: each entry against the sum of its fractions.
    #[test]
    fn a_matrix_is_the_sum_of_its_fractions() {
        let number = |i: usize, j: usize| Complex64::from_polar(1.0 + i as f64, 0.7 * j as f64 + i as f64);
        let real = |real: bool, z: Complex64| if real { Complex64::from(z.re) } else { z };
        let fractions = PartialFractions {
            poles: vec![Complex64::new(-2.0, 0.0), Complex64::new(-0.5, 3.0)],
            outputs: DMatrix::from_fn(2, 2, |i, k| real(k == 0, number(i, k))),
            inputs: DMatrix::from_fn(3, 2, |i, k| real(k == 0, number(i + 2, k + 1))),
            direct: DMatrix::from_fn(2, 3, |i, j| number(i, j).im),
        };
        let PartialFractions { poles, outputs, inputs, direct } = &fractions;
        for s in [Complex64::new(0.0, 2.9), Complex64::new(4.0, -1.0)] {
            let found = fractions.evaluate(s);
            assert_eq!(found.shape(), (2, 3));
            for (i, j) in (0..2).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let residue = |k: usize| outputs[(i, k)] * inputs[(j, k)];
                let pair = residue(1) / (s - poles[1]) + residue(1).conj() / (s - poles[1].conj());
                let exact = direct[(i, j)] + residue(0) / (s - poles[0]) + pair;
                assert!((exact - found[(i, j)]).norm() < 1e-14 * exact.norm().max(1.0), "{i}, {j}: {exact}");
            }
        }
    }

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
            let term = |k: usize| {
                let (c, b, pole) = (fractions.outputs[(0, k)], fractions.inputs[(0, k)], fractions.poles[k]);
                let mirrored =
                    if pole.im > 0.0 { c.conj() * b.conj() / (s - pole.conj()) } else { Complex64::ZERO };
                c * b / (s - pole) + mirrored
            };
            let exact = 0.7 + term(0) + term(1);
            assert!((exact - fractions.evaluate(s)[(0, 0)]).norm() < 1e-14);
            let rest = fractions.beyond_slope().evaluate(s)[(0, 0)];
            let again = 0.7 - moment(1) - s * moment(2) + s * s * rest;
            assert!((again - fractions.evaluate(s)[(0, 0)]).norm() < 1e-14);
        }
    }
}
