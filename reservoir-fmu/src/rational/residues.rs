use super::loewner::{Sample, uniform};
use super::partial_fractions::{Evaluator, PartialFractions};
use super::passivity::{Loss, Violation, scaled, violations};
use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};
use nalgebra::DMatrix;
use num_complex::Complex64;

/// Number of directions in which a sample is fitted.
const DIRECTIONS: usize = 6;
/// Weight of the samples off the axis.
const HELD: f64 = 0.01;
/// Regularisation of the normal equations, whose diagonal is 1, per equation.
const RIDGE: f64 = 1e-14;
/// Norm of a sample, over that of a plane wave, above which its error counts absolutely: at a cut-off frequency, a small share
/// of a large response would still be large for velocities that meet no resistance.
const LARGE: f64 = 0.5;
/// Target of the Hermitian part, over the loss, where it is more negative than the loss compensates.
const LEAST: f64 = -0.5;
/// Number of searches for violations.
const ROUNDS: usize = 20;
/// Largest number of sweeps over the multipliers, and change of the Hermitian part in a sweep at which they end.
const SWEEPS: usize = 2000;
const SETTLED: f64 = 1e-7;
/// Number of corrections of the static values.
const CORRECTIONS: usize = 3;

/// Residues of given poles by least squares: the output directions c_k with the smallest relative error, among those with
/// `G(0) = 0` and a given `G′(0)`.
///
/// The unknowns of a row of outputs are Re c_k and Im c_k of every pole. All rows have the same normal matrix N and the same
/// static equations E.
pub(crate) struct Residues {
    /// Norms of the columns of the unknowns.
    norms: Vec<f64>,
    /// Factors of the normal matrix N, with columns scaled to norm 1.
    factor: Llt<f64>,
    statics: Statics,
}

/// The equations `E u = e` of a row's scaled unknowns u: value and slope at s = 0 for every input of a pole.
struct Statics {
    /// E, rows scaled to norm 1.
    equations: Mat<f64>,
    /// The input, whether it is the slope, and the scale of a row.
    rows: Vec<(usize, bool, f64)>,
    /// N⁻¹ Eᵀ.
    solved: Mat<f64>,
    /// Factors of E N⁻¹ Eᵀ.
    factor: Llt<f64>,
}

/// One half-space of residues: `Re x*V(ω)x ≥ LEAST δ` with `V = −(ω² + ω₀²) R(iω)`, which is linear in them.
struct Cut {
    omega: f64,
    direction: Vec<Complex64>,
    /// Re x, Im x.
    rows: [Vec<f64>; 2],
    /// f: factors of a row's scaled unknowns, Re and Im.
    columns: Mat<f64>,
    /// `(N⁻¹ − N⁻¹Eᵀ (E N⁻¹ Eᵀ)⁻¹ E N⁻¹) f`: the moves that keep the static values.
    solved: Mat<f64>,
}

impl Residues {
    /// Fits the outputs of `fractions` to samples of `G − D`, with `G(0) = 0` and `G′(0) = slope` (outputs × inputs); the
    /// `held` samples have a small weight.
    ///
    /// None if the equations have no solution: too few poles, or poles that are too much alike.
    pub fn fitted(
        fractions: &mut PartialFractions,
        samples: &[Sample],
        held: &[Sample],
        slope: &DMatrix<f64>,
    ) -> Option<Self> {
        let (order, inputs, outputs) =
            (fractions.poles.len(), fractions.inputs.nrows(), fractions.direct.nrows());
        let mut random = 3;
        let equations = (samples.len() + held.len()) * DIRECTIONS * 2;
        let (mut regressors, mut wanted) = (Mat::zeros(2 * order, equations), Mat::zeros(equations, outputs));
        let weighted =
            samples.iter().map(|sample| (sample, 1.0)).chain(held.iter().map(|sample| (sample, HELD)));
        for (n, (Sample { s, value }, weight)) in weighted.enumerate() {
            let weight = weight
                / value.zip_map(&fractions.direct, |g, d| g + d).norm().min(LARGE * (outputs as f64).sqrt());
            for direction in 0..DIRECTIONS {
                let equation = 2 * (n * DIRECTIONS + direction);
                let x: Vec<Complex64> = (0..inputs).map(|_| uniform(&mut random).into()).collect();
                for (k, factor) in factors(fractions, &x, |pole| 1.0 / (s - pole)).into_iter().enumerate() {
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
        let factor = normal.llt(Side::Lower).ok()?;
        let statics = Statics::new(fractions, &norms, &factor)?;
        let mut found = factor.solve(&scaled * wanted);
        let values = Mat::from_fn(statics.rows.len(), outputs, |row, i| {
            let (j, is_slope, scale) = statics.rows[row];
            scale * if is_slope { slope[(i, j)] } else { -fractions.direct[(i, j)] }
        });
        for _ in 0..CORRECTIONS {
            let missing = &values - &statics.equations * &found;
            found += &statics.solved * statics.factor.solve(missing);
        }
        fractions.outputs = DMatrix::zeros(outputs, order);
        let residues = Self { norms, factor, statics };
        residues.add(fractions, &found);
        Some(residues)
    }

    /// Changes the outputs by the smallest amount, in the norm of the fit, that makes `G` passive together with `loss`. The
    /// static values do not change.
    ///
    /// Every violation gives half-spaces in which the residues must lie, one for each negative eigenvalue. The dual of
    /// `min ½ Σ_i u_iᵀ N u_i` within all half-spaces found so far, `E u_i = 0`, is solved by coordinate descent; then
    /// [`violations`] searches again, at `frequencies` and its other points. Also returns the loss that is needed, which is
    /// larger than `loss` if there still are some at last.
    pub fn made_passive(
        &self,
        fractions: &PartialFractions,
        frequencies: &[f64],
        loss: Loss,
    ) -> (PartialFractions, f64) {
        let mut passive = fractions.clone();
        let beyond = fractions.beyond_slope();
        let beyond = Evaluator::of(&beyond);
        let mut cuts: Vec<Cut> = Vec::new();
        let mut gram = Mat::<f64>::zeros(0, 0);
        let mut multipliers: Vec<f64> = Vec::new();
        for _ in 0..ROUNDS {
            let found = violations(&passive, frequencies, loss);
            if found.is_empty() {
                return (passive, loss.size);
            }
            let old = cuts.len();
            for violation in deepest(&found) {
                let directions = violation.directions.iter();
                cuts.extend(directions.map(|x| self.cut(fractions, violation.omega, loss.corner, x)));
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
            let missing: Vec<f64> =
                cuts.iter().map(|cut| LEAST * loss.size - cut.value(&beyond, loss.corner)).collect();
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
        let worst = violations(&passive, frequencies, loss).iter().map(|v| v.most).fold(loss.size, f64::max);
        (passive, worst)
    }

    fn cut(&self, fractions: &PartialFractions, omega: f64, corner: f64, x: &[Complex64]) -> Cut {
        let mut whole = x.to_vec();
        whole.resize(fractions.inputs.nrows(), Complex64::ZERO);
        let factors = factors(fractions, &whole, |pole| {
            -(omega * omega + corner * corner) / (pole * pole * (Complex64::new(0.0, omega) - pole))
        });
        let columns =
            Mat::from_fn(factors.len(), 2, |k, part| [factors[k].re, factors[k].im][part] / self.norms[k]);
        let mut solved = self.factor.solve(&columns);
        let kept = self.statics.factor.solve(&self.statics.equations * &solved);
        solved -= &self.statics.solved * kept;
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

impl Statics {
    fn new(fractions: &PartialFractions, norms: &[f64], normal: &Llt<f64>) -> Option<Self> {
        let inputs = fractions.inputs.nrows();
        let (mut rows, mut equations) = (Vec::new(), Vec::new());
        for j in 0..inputs {
            let unit: Vec<Complex64> =
                (0..inputs).map(|i| if i == j { Complex64::ONE } else { Complex64::ZERO }).collect();
            for is_slope in [false, true] {
                let factors =
                    factors(fractions, &unit, |pole| -1.0 / if is_slope { pole * pole } else { pole });
                let row: Vec<f64> =
                    factors.iter().zip(norms).map(|(factor, norm)| factor.re / norm).collect();
                let norm = row.iter().map(|x| x * x).sum::<f64>().sqrt();
                // Over a level bed the ground's motion along x is no input of any pole.
                if norm > 0.0 {
                    rows.push((j, is_slope, 1.0 / norm));
                    equations.push(row);
                }
            }
        }
        let equations = Mat::from_fn(rows.len(), norms.len(), |row, k| rows[row].2 * equations[row][k]);
        let solved = normal.solve(equations.transpose());
        let factor = (&equations * &solved).llt(Side::Lower).ok()?;
        Some(Self { equations, rows, solved, factor })
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

    /// `Re x*V(ω)x` of R given as `beyond`.
    fn value(&self, beyond: &Evaluator<'_>, corner: f64) -> f64 {
        let value = scaled(beyond, self.omega, corner);
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

/// Coefficients of Re c_k and Im c_k of every pole in `Σ_k c_k b_kᵀ x weight(λ_k)`; 0 for Im c of a real pole.
fn factors(
    fractions: &PartialFractions,
    x: &[Complex64],
    weight: impl Fn(Complex64) -> Complex64,
) -> Vec<Complex64> {
    let factor = |(k, &pole): (usize, &Complex64)| {
        let along = |conjugate: bool| -> Complex64 {
            let b = |j: usize| fractions.inputs[(j, k)];
            x.iter().enumerate().map(|(j, x)| if conjugate { b(j).conj() } else { b(j) } * x).sum()
        };
        let own = along(false) * weight(pole);
        if pole.im > 0.0 {
            let mirrored = along(true) * weight(pole.conj());
            [own + mirrored, Complex64::I * (own - mirrored)]
        } else {
            [own, Complex64::ZERO]
        }
    };
    fractions.poles.iter().enumerate().flat_map(factor).collect()
}

/// `max missingᵀ μ − ½ μᵀ gram μ` over μ ≥ 0 by coordinate descent, until no `gram μ` changes by more than [`SETTLED`].
///
/// A half-space that no move can reach keeps its multiplier.
fn ascend(gram: &Mat<f64>, missing: &[f64], multipliers: &mut [f64]) {
    let count = missing.len();
    let mut slope: Vec<f64> = (0..count)
        .map(|p| missing[p] - (0..count).map(|q| gram[(q, p)] * multipliers[q]).sum::<f64>())
        .collect();
    for _ in 0..SWEEPS {
        let mut moved = 0.0f64;
        for p in (0..count).filter(|&p| gram[(p, p)] > 0.0) {
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

    /// `s/(s + 0.5) v₁v₁ᵀ + s/(s + 1.5) v₂v₂ᵀ + s/((s + 0.2)² + 9) wwᵀ`: passive, 0 at s = 0; and its slope there.
    fn passive_water() -> (PartialFractions, DMatrix<f64>) {
        let columns = DMatrix::from_row_slice(2, 3, &[1.0, 0.1, 0.3, 0.2, 1.0, -0.7]);
        let pair = Complex64::new(-0.2, 3.0);
        let outer = |k: usize| columns.column(k) * columns.column(k).transpose();
        let residues = [Complex64::from(-0.5), Complex64::from(-1.5), pair / Complex64::new(0.0, 6.0)];
        let slope = outer(0) / 0.5 + outer(1) / 1.5 + outer(2) / 9.04;
        let water = PartialFractions {
            poles: vec![Complex64::from(-0.5), Complex64::from(-1.5), pair],
            outputs: DMatrix::from_fn(2, 3, |i, k| residues[k] * columns[(i, k)]),
            inputs: columns.map(Complex64::from),
            direct: outer(0) + outer(1),
        };
        (water, slope)
    }

    fn samples_of(water: &PartialFractions, frequencies: &[f64]) -> Vec<Sample> {
        let sample = |&omega: &f64| {
            let s = Complex64::new(0.0, omega);
            Sample { s, value: water.evaluate(s) - water.direct.map(Complex64::from) }
        };
        frequencies.iter().map(sample).collect()
    }

    /// The same water with a pole above all samples.
    fn with_another_pole(water: &PartialFractions) -> PartialFractions {
        let mut more = water.clone();
        more.poles.push(Complex64::new(-0.1, 9.0));
        more.inputs = more.inputs.insert_column(3, Complex64::ONE);
        more.outputs = more.outputs.insert_column(3, Complex64::ZERO);
        more
    }

    const FREQUENCIES: std::ops::Range<u32> = 1..60;

    fn frequencies() -> Vec<f64> {
        FREQUENCIES.map(|k| 0.1 * f64::from(k)).collect()
    }

    /// Value and slope at 0 are those asked for, whatever the samples say; a slope of its own fits the samples to rounding.
    #[test]
    fn static_values_are_exact() {
        let (water, slope) = passive_water();
        let samples = samples_of(&water, &frequencies());
        for (factor, most) in [(1.0, 1e-9), (1.1, f64::INFINITY)] {
            let mut fitted = with_another_pole(&water);
            Residues::fitted(&mut fitted, &samples, &[], &(&slope * factor)).unwrap();
            let (value, beyond) = (fitted.evaluate(Complex64::ZERO), fitted.beyond_slope());
            let s = Complex64::new(0.0, 1.0);
            let found = (fitted.evaluate(s) - &value - beyond.evaluate(s) * (s * s)).map(|z| z.im);
            assert!(value.norm() < 1e-11 && (found - &slope * factor).norm() < 1e-11);
            let off =
                samples.iter().map(|sample| (fitted.evaluate(sample.s) - water.evaluate(sample.s)).norm());
            assert!(off.fold(0.0, f64::max) < most);
        }
    }

    /// A resonance above all samples produces energy in one direction; this is removed without loss of accuracy, and without
    /// a change of the static values.
    #[test]
    fn a_resonance_between_no_samples_is_made_passive() {
        let (water, slope) = passive_water();
        let frequencies = frequencies();
        let mut fitted = with_another_pole(&water);
        let loss = Loss { size: 1e-3, corner: 2.0 };
        let residues = Residues::fitted(&mut fitted, &samples_of(&water, &frequencies), &[], &slope).unwrap();
        let cut = residues.cut(&fitted, 9.0, loss.corner, &[Complex64::ONE, Complex64::ZERO]);
        let wrong = Mat::from_fn(8, 2, |k, i| cut.rows[0][i] * cut.solved[(k, 0)]);
        residues.add(&mut fitted, &(wrong * faer::Scale(-3.0 / cut.product(&cut))));
        let before = violations(&fitted, &frequencies, loss);
        let (passive, needed) = residues.made_passive(&fitted, &frequencies, loss);
        let worst = before.iter().map(|v| v.most).fold(0.0, f64::max);
        let off = |f: &PartialFractions, s: f64| {
            (f.evaluate(Complex64::new(0.0, s)) - water.evaluate(Complex64::new(0.0, s))).norm()
        };
        let furthest = |f| frequencies.iter().map(|&omega| off(f, omega)).fold(0.0, f64::max);
        println!(
            "gave {worst:.2}; off the samples by {:.1e}, was {:.1e}",
            furthest(&passive),
            furthest(&fitted)
        );
        assert!(worst > 1.0 && needed <= loss.size && violations(&passive, &frequencies, loss).is_empty());
        assert!(furthest(&passive) < furthest(&fitted) && off(&passive, 0.0) < 1e-11);
    }

    /// Too few poles for the static values: no fit, and no panic.
    #[test]
    fn too_few_poles_are_no_fit() {
        let (water, slope) = passive_water();
        let mut few = water.clone();
        few.poles.truncate(1);
        few.inputs = few.inputs.remove_columns(1, 2);
        assert!(Residues::fitted(&mut few, &samples_of(&water, &frequencies()), &[], &slope).is_none());
    }
}
