use super::loewner::{Loewner, Sample};
use super::partial_fractions::PartialFractions;
use super::residues::Residues;
use nalgebra::DMatrix;
use num_complex::Complex64;
use rayon::prelude::*;

/// Number of directions in which a sample is matched.
const DIRECTIONS: usize = 3;
/// Fraction of the frequencies that count for the error; the others keep the end effects away from them.
const TRUSTED: f64 = 0.85;
/// Number of samples above the largest frequency.
const BEYOND: i32 = 30;
/// Number of times that samples are added.
const ROUNDS: usize = 3;
/// Fractions of the largest singular value that are tried as the smallest one kept.
const THRESHOLDS: [f64; 3] = [1e-6, 1e-7, 1e-8];

/// A rational function, and its error.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    pub fractions: PartialFractions,
    /// Largest relative difference in the Frobenius norm at all computed frequencies.
    pub error: f64,
    /// Number of frequencies at which the function was computed.
    pub solved: usize,
    /// These frequencies, rad/s, ascending.
    pub frequencies: Vec<f64>,
}

/// Fits `symbol` on `s = damping + iω` at the `frequencies` ω (rad/s, ascending) and between them.
///
/// The function is matched at the frequencies and checked half way between them. Where the error is above `tolerance`, the
/// checks become samples, and new checks are added beside them. The result is a function of iω. The fit with the smallest
/// error is made passive and returned. Its value at infinity is that of `symbol` at the real s that is `infinite` times the
/// highest frequency; above the frequencies it is fitted to samples off the imaginary axis.
pub(crate) fn fit<E: Send>(
    symbol: impl Fn(Complex64) -> Result<DMatrix<Complex64>, E> + Sync,
    damping: f64,
    frequencies: &[f64],
    tolerance: f64,
    infinite: f64,
) -> Result<Option<Fit>, E> {
    let largest = frequencies.last().copied().unwrap_or(1.0);
    // The value at a large real s, so that the rest vanishes at infinity.
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
    // Above the frequencies the samples lie off the axis, where the function is smooth.
    let beyond = |k: i32| largest * 1.12f64.powi(k + 1) * Complex64::new(0.1, 1.0);
    let held = at(&(0..BEYOND).map(beyond).collect::<Vec<_>>())?;
    let mut samples = sampled(frequencies)?;
    let mut checks = sampled(&middles(frequencies))?;
    let mut best: Option<(PartialFractions, Residues, f64)> = None;
    for round in 1..=ROUNDS {
        let Some(loewner) = Loewner::new(&samples, DIRECTIONS) else { break };
        let candidate = |&order: &usize| {
            let mut fractions = loewner.truncated(order)?;
            // A pole without a sample nearby is not reliable.
            for pole in &mut fractions.poles {
                pole.re = pole.re.min(-0.1 * (pole.im - largest));
            }
            fractions.direct = direct.clone();
            let residues = Residues::fitted(&mut fractions, &samples, &held)?;
            let errors: Vec<f64> =
                checks.par_iter().map(|check| difference(&fractions, check, TRUSTED * largest)).collect();
            Some((fractions, residues, errors))
        };
        let candidates: Vec<_> = loewner.orders(&THRESHOLDS).par_iter().map(candidate).collect();
        let mut errors = Vec::new();
        let mut closest = f64::INFINITY;
        // The one with the fewest states within the tolerance, or else the one with the smallest error.
        for (fractions, residues, found) in candidates.into_iter().flatten() {
            let error = found.iter().copied().fold(0.0, larger);
            if closest > tolerance && error < closest {
                (closest, errors) = (error, found);
                if best.as_ref().is_none_or(|(_, _, least)| error < *least) {
                    best = Some((fractions, residues, error));
                }
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
    let Some((fractions, residues, _)) = best else { return Ok(None) };
    samples.extend(checks);
    let mut frequencies: Vec<f64> = samples.iter().map(|sample| sample.s.im).collect();
    frequencies.sort_by(f64::total_cmp);
    let fractions = residues.made_passive(&fractions, &frequencies);
    let difference = |sample| difference(&fractions, sample, TRUSTED * largest);
    let error = samples.par_iter().map(difference).reduce(|| 0.0, larger);
    let solved = samples.len() + held.len() + 1;
    Ok(Some(Fit { fractions, error, solved, frequencies }))
}

/// The larger number; NaN counts as larger than all numbers.
fn larger(a: f64, b: f64) -> f64 {
    if b.is_nan() { f64::INFINITY } else { a.max(b) }
}

fn middles(frequencies: &[f64]) -> Vec<f64> {
    frequencies.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect()
}

/// The midpoints between ω and its neighbours in `known` (ascending).
fn middles_beside(omega: f64, known: &[f64]) -> impl Iterator<Item = f64> {
    let next = known.partition_point(|&other| other < omega);
    let neighbours = [next.checked_sub(1), Some(next)].map(|index| known.get(index?).copied());
    neighbours.into_iter().flatten().map(move |other| 0.5 * (omega + other))
}

/// `‖G̃ − G‖/‖G‖` at a check, 0 above `trusted`.
fn difference(fractions: &PartialFractions, Sample { s, value }: &Sample, trusted: f64) -> f64 {
    if s.im > trusted {
        return 0.0;
    }
    let whole = value.zip_map(&fractions.direct, |g, d| g + d);
    (fractions.evaluate(*s) - &whole).norm() / whole.norm()
}
