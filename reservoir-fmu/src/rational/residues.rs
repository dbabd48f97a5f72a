use super::loewner::{Sample, uniform};
use super::partial_fractions::PartialFractions;
use super::passivity::{Violation, violations};
use faer::Mat;
use faer::linalg::solvers::{Llt, Solve};
use nalgebra::DMatrix;
use num_complex::Complex64;

/// Number of directions in which a sample is fitted.
const DIRECTIONS: usize = 6;
/// Weight of the samples off the axis.
const HELD: f64 = 0.01;
/// Regularisation of the normal equations, whose diagonal is 1, per equation.
const RIDGE: f64 = 1e-14;
/// Smallest allowed value of the Hermitian part; a loss compensates the rest.
const ALLOWED: f64 = 1e-3;
/// Target value where it is more negative.
const LEAST: f64 = -0.5 * ALLOWED;
/// Number of searches for violations.
const ROUNDS: usize = 8;
/// Largest number of sweeps over the multipliers, and change of the Hermitian part in a sweep at which they end.
const SWEEPS: usize = 2000;
const SETTLED: f64 = 1e-4 * ALLOWED;

/// Residues of given poles by least squares: the output directions c_k with the smallest relative error.
///
/// The unknowns of a row of outputs are Re c_k and Im c_k of every pole. All rows have the same normal matrix.
pub(crate) struct Residues {
    /// Norms of the columns of the unknowns.
    norms: Vec<f64>,
    /// Factors of the normal matrix N, with columns scaled to norm 1.
    factor: Llt<f64>,
}

/// One half-space of residues: `Re x*G(iω)x ≥ LEAST`, which is linear in them.
struct Cut {
    omega: f64,
    direction: Vec<Complex64>,
    /// Re x, Im x.
    rows: [Vec<f64>; 2],
    /// f: factors of a row's scaled unknowns, Re and Im.
    columns: Mat<f64>,
    /// N⁻¹ f.
    solved: Mat<f64>,
}

impl Residues {
    /// Fits the outputs of `fractions` to samples of `G − D`; the `held` ones have a small weight.
    ///
    /// None if the normal matrix is not positive definite.
    pub fn fitted(fractions: &mut PartialFractions, samples: &[Sample], held: &[Sample]) -> Option<Self> {
        let (order, inputs, outputs) =
            (fractions.poles.len(), fractions.inputs.nrows(), fractions.direct.nrows());
        let mut random = 3;
        let equations = (samples.len() + held.len()) * DIRECTIONS * 2;
        let (mut regressors, mut wanted) = (Mat::zeros(2 * order, equations), Mat::zeros(equations, outputs));
        let weighted =
            samples.iter().map(|sample| (sample, 1.0)).chain(held.iter().map(|sample| (sample, HELD)));
        for (n, (Sample { s, value }, weight)) in weighted.enumerate() {
            let weight = weight / value.zip_map(&fractions.direct, |g, d| g + d).norm();
            for direction in 0..DIRECTIONS {
                let equation = 2 * (n * DIRECTIONS + direction);
                let x: Vec<Complex64> = (0..inputs).map(|_| uniform(&mut random).into()).collect();
                for (k, factor) in factors(fractions, *s, &x).into_iter().enumerate() {
                    regressors[(k, equation)] = weight * factor.re;
                    regressors[(k, equation + 1)] = weight * factor.im;
                }
                for i in 0..outputs {
                    let image: Complex64 = x.iter().enumerate().map(|(j, x)| value[(i, j)] * x).sum();
                    wanted[(equation, i)] = weight * image.re;
                    wanted[(equation + 1, i)] = weight * image.im;
                }
            }
        }
        let norms: Vec<f64> =
            (0..2 * order).map(|k| regressors.row(k).norm_l2().max(f64::MIN_POSITIVE)).collect();
        let scaled = Mat::from_fn(2 * order, equations, |k, e| regressors[(k, e)] / norms[k]);
        let mut normal = &scaled * scaled.transpose();
        for k in 0..2 * order {
            normal[(k, k)] += RIDGE * equations as f64;
            if norms[k] == f64::MIN_POSITIVE {
                normal[(k, k)] = 1.0;
            }
        }
        let residues = Self { norms, factor: normal.llt(faer::Side::Lower).ok()? };
        let found = residues.factor.solve(&scaled * wanted);
        fractions.outputs = DMatrix::zeros(outputs, order);
        residues.add(fractions, &found);
        Some(residues)
    }

    /// Changes the outputs by the smallest amount that makes `G` passive, in the norm of the fit.
    ///
    /// Every violation gives half-spaces in which the residues must lie, one for each negative eigenvalue. The dual of
    /// `min ½ Σ_i u_iᵀ N u_i` within all half-spaces found so far is solved by coordinate descent; then
    /// [`violations`] searches again, at `frequencies` and its other points.
    pub fn made_passive(&self, fractions: &PartialFractions, frequencies: &[f64]) -> PartialFractions {
        let mut passive = fractions.clone();
        let mut cuts: Vec<Cut> = Vec::new();
        let mut gram = Mat::<f64>::zeros(0, 0);
        let mut multipliers: Vec<f64> = Vec::new();
        for _ in 0..ROUNDS {
            let found = violations(&passive, frequencies, ALLOWED);
            if found.is_empty() {
                break;
            }
            let old = cuts.len();
            for violation in deepest(&found) {
                cuts.extend(violation.directions.iter().map(|x| self.cut(fractions, violation.omega, x)));
            }
            let known = std::mem::replace(&mut gram, Mat::zeros(0, 0));
            gram = Mat::from_fn(cuts.len(), cuts.len(), |p, q| {
                if p < old && q < old {
                    known[(p, q)]
                } else if p <= q {
                    cuts[p].product(&cuts[q])
                } else {
                    0.0
                }
            });
            for p in 0..cuts.len() {
                for q in 0..p {
                    gram[(p, q)] = gram[(q, p)];
                }
            }
            let missing: Vec<f64> = cuts.iter().map(|cut| LEAST - cut.value(fractions)).collect();
            multipliers.resize(cuts.len(), 0.0);
            ascend(&gram, &missing, &mut multipliers);
            let mut change = Mat::zeros(self.norms.len(), fractions.direct.nrows());
            for (cut, &multiplier) in
                cuts.iter().zip(&multipliers).filter(|(_, multiplier)| **multiplier > 0.0)
            {
                for part in 0..2 {
                    for (i, row) in cut.rows[part].iter().enumerate() {
                        for k in 0..self.norms.len() {
                            change[(k, i)] += multiplier * row * cut.solved[(k, part)];
                        }
                    }
                }
            }
            passive = fractions.clone();
            self.add(&mut passive, &change);
        }
        passive
    }

    fn cut(&self, fractions: &PartialFractions, omega: f64, x: &[Complex64]) -> Cut {
        let mut whole = x.to_vec();
        whole.resize(fractions.inputs.nrows(), Complex64::ZERO);
        let factors = factors(fractions, Complex64::new(0.0, omega), &whole);
        let columns =
            Mat::from_fn(factors.len(), 2, |k, part| [factors[k].re, factors[k].im][part] / self.norms[k]);
        let solved = self.factor.solve(&columns);
        let rows = [x.iter().map(|x| x.re).collect(), x.iter().map(|x| x.im).collect()];
        Cut { omega, direction: x.to_vec(), rows, columns, solved }
    }

    /// Adds scaled unknowns × rows to the outputs.
    fn add(&self, fractions: &mut PartialFractions, unknowns: &Mat<f64>) {
        for k in 0..fractions.poles.len() {
            for i in 0..fractions.outputs.nrows() {
                let part = |part: usize| unknowns[(2 * k + part, i)] / self.norms[2 * k + part];
                fractions.outputs[(i, k)] += Complex64::new(part(0), part(1));
            }
        }
    }
}

impl Cut {
    fn product(&self, other: &Self) -> f64 {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        (0..2)
            .flat_map(|a| (0..2).map(move |b| (a, b)))
            .map(|(a, b)| {
                dot(&self.rows[a], &other.rows[b]) * (self.columns.col(a).transpose() * other.solved.col(b))
            })
            .sum()
    }

    /// `Re x*G(iω)x`.
    fn value(&self, fractions: &PartialFractions) -> f64 {
        let value = fractions.evaluate(Complex64::new(0.0, self.omega));
        let x = &self.direction;
        (0..x.len())
            .flat_map(|i| (0..x.len()).map(move |j| (i, j)))
            .map(|(i, j)| (x[i].conj() * value[(i, j)] * x[j]).re)
            .sum()
    }
}

/// The local maxima of the violations, which are sorted by ascending frequency.
fn deepest(found: &[Violation]) -> impl Iterator<Item = &Violation> {
    let most = |k: Option<usize>| k.and_then(|k| found.get(k)).map_or(0.0, |violation| violation.most);
    (0..found.len())
        .filter(move |&k| most(Some(k)) >= most(k.checked_sub(1)).max(most(Some(k + 1))))
        .map(|k| &found[k])
}

/// Coefficients of Re c_k and Im c_k of every pole in `G(s) x`; 0 for Im c of a real pole.
fn factors(fractions: &PartialFractions, s: Complex64, x: &[Complex64]) -> Vec<Complex64> {
    let factor = |(k, &pole): (usize, &Complex64)| {
        let along = |conjugate: bool| -> Complex64 {
            let b = |j: usize| fractions.inputs[(j, k)];
            x.iter().enumerate().map(|(j, x)| if conjugate { b(j).conj() } else { b(j) } * x).sum()
        };
        let own = along(false) / (s - pole);
        if pole.im > 0.0 {
            let mirrored = along(true) / (s - pole.conj());
            [own + mirrored, Complex64::I * (own - mirrored)]
        } else {
            [own, Complex64::ZERO]
        }
    };
    fractions.poles.iter().enumerate().flat_map(factor).collect()
}

/// `max missingᵀ μ − ½ μᵀ gram μ` over μ ≥ 0 by coordinate descent.
fn ascend(gram: &Mat<f64>, missing: &[f64], multipliers: &mut [f64]) {
    let count = missing.len();
    let mut slope: Vec<f64> = (0..count)
        .map(|p| missing[p] - (0..count).map(|q| gram[(q, p)] * multipliers[q]).sum::<f64>())
        .collect();
    for _ in 0..SWEEPS {
        let mut moved = 0.0f64;
        for p in 0..count {
            let wanted = f64::max(0.0, multipliers[p] + slope[p] / gram[(p, p)]);
            let change = wanted - multipliers[p];
            if change != 0.0 {
                multipliers[p] = wanted;
                for (q, slope) in slope.iter_mut().enumerate() {
                    *slope -= gram[(q, p)] * change;
                }
                moved = moved.max(change.abs() * gram[(p, p)]);
            }
        }
        if moved <= SETTLED {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A resonance above all samples produces energy in one direction; this is removed without loss of accuracy.
    #[test]
    fn a_resonance_between_no_samples_is_made_passive() {
        let direct = DMatrix::from_row_slice(2, 2, &[1.0, 0.2, 0.2, 1.0]);
        let within = PartialFractions {
            poles: vec![Complex64::new(-0.5, 0.0), Complex64::new(-0.2, 3.0)],
            outputs: DMatrix::from_row_slice(2, 2, &[0.3, 0.1, 0.3, 0.2]).map(Complex64::from),
            inputs: DMatrix::from_row_slice(2, 2, &[0.3, 0.1, 0.3, 0.2]).map(Complex64::from),
            direct: direct.clone(),
        };
        let frequencies: Vec<f64> = (1..60).map(|k| 0.1 * f64::from(k)).collect();
        let samples: Vec<Sample> = frequencies
            .iter()
            .map(|&omega| {
                let s = Complex64::new(0.0, omega);
                let value = within.evaluate(s) - direct.map(Complex64::from);
                Sample { s, value }
            })
            .collect();
        let mut fitted = within.clone();
        fitted.poles.push(Complex64::new(-0.1, 9.0));
        fitted.inputs = DMatrix::from_row_slice(2, 3, &[0.3, 0.1, 1.0, 0.3, 0.2, -0.5]).map(Complex64::from);
        let residues = Residues::fitted(&mut fitted, &samples, &[]).unwrap();
        for (i, residue) in [-0.4, 0.1].into_iter().enumerate() {
            fitted.outputs[(i, 2)] = residue.into();
        }
        let before = violations(&fitted, &frequencies, 0.0);
        let passive = residues.made_passive(&fitted, &frequencies);
        let worst = |found: &[Violation]| found.iter().map(|v| v.most).fold(0.0, f64::max);
        let after = violations(&passive, &frequencies, 0.0);
        let off = |f: &PartialFractions, s: f64| {
            (f.evaluate(Complex64::new(0.0, s)) - within.evaluate(Complex64::new(0.0, s))).norm()
        };
        let off = |f| frequencies.iter().map(|&omega| off(f, omega)).fold(0.0, f64::max);
        println!(
            "gave {:.2}, gives {:.1e}; off the samples by {:.1e}, was {:.1e}",
            worst(&before),
            worst(&after),
            off(&passive),
            off(&fitted)
        );
        assert!(worst(&before) > 1.0 && worst(&after) <= ALLOWED);
        assert!(off(&passive) < off(&fitted));
    }
}
