use super::loewner::{Loewner, Sample, uniform};
use super::partial_fractions::PartialFractions;
use faer::Mat;
use faer::linalg::solvers::Solve;
use nalgebra::DMatrix;
use num_complex::Complex64;
use rayon::prelude::*;

/// Directions in which a sample is matched.
const DIRECTIONS: usize = 3;
/// Directions in which residues are fitted to a sample.
const RESIDUE_DIRECTIONS: usize = 6;
/// Ridge of the residues' normal equations, over their largest diagonal.
const RIDGE: f64 = 1e-14;
/// Share of the frequencies that the error is taken over; the rest keeps their end away.
const TRUSTED: f64 = 0.85;
/// Samples beyond the largest frequency.
const BEYOND: i32 = 30;
/// Times that samples are added.
const ROUNDS: usize = 3;
/// Shares of the largest singular value that are tried as the least one kept.
const THRESHOLDS: [f64; 4] = [1e-5, 1e-6, 1e-7, 1e-8];

/// A rational function, and how far it is from what it was made from.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    pub fractions: PartialFractions,
    /// Largest relative difference in Frobenius' norm at frequencies that were not matched.
    pub error: f64,
    /// Number of frequencies at which the function was asked for.
    pub solved: usize,
    /// All of them, rad/s, ascending.
    pub frequencies: Vec<f64>,
}

/// Fits `symbol` on `s = damping + iω` at the `frequencies` ω (rad/s, ascending) and between them.
///
/// The function is matched at the frequencies and checked half way between them; where it is further off than
/// `tolerance`, the checks become samples and new ones are put beside them. The fit is of `symbol` as a
/// function of iω. The closest one is returned when the rounds are over. At infinity it takes its value at the real s that is
/// `infinite` times the highest frequency; beyond the frequencies it is held off the axis with `held_weight`.
pub(crate) fn fit<E: Send>(
    symbol: impl Fn(Complex64) -> Result<DMatrix<Complex64>, E> + Sync,
    damping: f64,
    frequencies: &[f64],
    tolerance: f64,
    infinite: f64,
    held_weight: f64,
) -> Result<Option<Fit>, E> {
    let largest = frequencies.last().copied().unwrap_or(1.0);
    // High up, a real function's own value: what is left vanishes.
    let direct = symbol(Complex64::from(infinite * largest))?.map(|g| g.re);
    let at = |points: &[Complex64]| -> Result<Vec<Sample>, E> {
        let sample = |&s: &Complex64| {
            let mut value = symbol(s + damping)?;
            value.zip_apply(&direct, |g, d| *g -= d);
            Ok(Sample { s, value })
        };
        points.par_iter().map(sample).collect()
    };
    let sampled = |frequencies: &[f64]| {
        at(&frequencies.iter().map(|&omega| Complex64::new(0.0, omega)).collect::<Vec<_>>())
    };
    // Beyond the frequencies the function is held where it is smooth, off the axis.
    let beyond = |k: i32| largest * 1.12f64.powi(k + 1) * Complex64::new(0.1, 1.0);
    let held = at(&(0..BEYOND).map(beyond).collect::<Vec<_>>())?;
    let mut samples = sampled(frequencies)?;
    let mut checks = sampled(&middles(frequencies))?;
    let mut best: Option<Fit> = None;
    for round in 1..=ROUNDS {
        let Some(loewner) = Loewner::new(&samples, DIRECTIONS) else { return Ok(best) };
        let mut errors = Vec::new();
        let mut closest = f64::INFINITY;
        for order in loewner.orders(&THRESHOLDS) {
            let Some(mut fractions) = loewner.truncated(order) else { continue };
            // A pole that nothing was matched beside could be anything.
            for pole in &mut fractions.poles {
                pole.re = pole.re.min(-0.3 * (pole.im - 1.05 * largest));
            }
            refit(&mut fractions, &samples, (&held, held_weight), &direct);
            let found: Vec<f64> = checks
                .par_iter()
                .map(|check| difference(&fractions, check, &direct, TRUSTED * largest))
                .collect();
            let error = found.iter().copied().fold(0.0, f64::max);
            if error < closest {
                (closest, errors) = (error, found);
                if best.as_ref().is_none_or(|fit| error < fit.error) {
                    fractions.direct = direct.clone();
                    let solved = samples.len() + checks.len() + 1;
                    best = Some(Fit { fractions, error, solved, frequencies: Vec::new() });
                }
            }
            if error <= tolerance {
                break;
            }
        }
        if closest <= tolerance || errors.is_empty() || round == ROUNDS {
            break;
        }
        let (mut added, mut kept) = (Vec::new(), Vec::new());
        for (check, error) in checks.into_iter().zip(errors) {
            if error > 0.3 * tolerance { added.push(check) } else { kept.push(check) }
        }
        let known: Vec<f64> = samples.iter().map(|sample| sample.s.im).collect();
        let beside: Vec<f64> = added.iter().flat_map(|sample| middles_beside(sample.s.im, &known)).collect();
        checks = kept;
        checks.extend(sampled(&beside)?);
        samples.extend(added);
        samples.sort_by(|a, b| a.s.im.total_cmp(&b.s.im));
    }
    if let Some(fit) = &mut best {
        fit.frequencies = samples.iter().chain(&checks).map(|sample| sample.s.im).collect();
        fit.frequencies.sort_by(f64::total_cmp);
    }
    Ok(best)
}

/// Finds the residues' output directions anew, by least squares of the relative error at the samples.
fn refit(
    fractions: &mut PartialFractions,
    samples: &[Sample],
    (held, held_weight): (&[Sample], f64),
    direct: &DMatrix<f64>,
) {
    let (order, inputs) = (fractions.poles.len(), fractions.inputs.nrows());
    let mut random = 3;
    let equations = (samples.len() + held.len()) * RESIDUE_DIRECTIONS * 2;
    let (mut regressors, mut wanted) =
        (Mat::zeros(2 * order, equations), Mat::zeros(equations, direct.nrows()));
    let mut equation = 0;
    for Sample { s, value } in samples.iter().chain(held) {
        let weight = if s.re > 0.0 { held_weight } else { 1.0 } / whole(value, direct).norm();
        for _ in 0..RESIDUE_DIRECTIONS {
            let direction: Vec<f64> = (0..inputs).map(|_| uniform(&mut random)).collect();
            for (k, &pole) in fractions.poles.iter().enumerate() {
                let b: Complex64 =
                    direction.iter().enumerate().map(|(j, d)| fractions.inputs[(j, k)] * d).sum();
                let mirrored = if pole.im > 0.0 { b.conj() / (s - pole.conj()) } else { Complex64::ZERO };
                let (own, i) = (b / (s - pole), Complex64::I);
                // Factors of Re c and Im c; a real pole's Im c has none.
                let pair =
                    [own + mirrored, if pole.im > 0.0 { i * (own - mirrored) } else { Complex64::ZERO }];
                for (part, factor) in pair.into_iter().enumerate() {
                    regressors[(2 * k + part, equation)] = weight * factor.re;
                    regressors[(2 * k + part, equation + 1)] = weight * factor.im;
                }
            }
            for i in 0..direct.nrows() {
                let image: Complex64 = direction.iter().enumerate().map(|(j, d)| value[(i, j)] * d).sum();
                wanted[(equation, i)] = weight * image.re;
                wanted[(equation + 1, i)] = weight * image.im;
            }
            equation += 2;
        }
    }
    // Columns of equal norm, so that the ridge means the same to all.
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
    let Ok(factor) = normal.llt(faer::Side::Lower) else { return };
    let found = factor.solve(&scaled * wanted);
    fractions.outputs = DMatrix::from_fn(direct.nrows(), order, |i, k| {
        Complex64::new(found[(2 * k, i)] / norms[2 * k], found[(2 * k + 1, i)] / norms[2 * k + 1])
    });
}

fn middles(frequencies: &[f64]) -> Vec<f64> {
    frequencies.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect()
}

/// Half way from ω to the next ones of `known` (ascending) on either side.
fn middles_beside(omega: f64, known: &[f64]) -> impl Iterator<Item = f64> {
    let next = known.partition_point(|&other| other < omega);
    let neighbours = [next.checked_sub(1), Some(next)].map(|index| known.get(index?).copied());
    neighbours.into_iter().flatten().map(move |other| 0.5 * (omega + other))
}

/// `‖G̃ − G‖/‖G‖` at a check, 0 above `trusted`.
fn difference(fractions: &PartialFractions, check: &Sample, direct: &DMatrix<f64>, trusted: f64) -> f64 {
    if check.s.im > trusted {
        return 0.0;
    }
    (fractions.evaluate(check.s) - &check.value).norm() / whole(&check.value, direct).norm()
}

/// A value with the part at infinity.
fn whole(value: &DMatrix<Complex64>, direct: &DMatrix<f64>) -> DMatrix<Complex64> {
    value.zip_map(direct, |g, d| g + d)
}
