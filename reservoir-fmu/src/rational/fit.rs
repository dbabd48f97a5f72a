use super::loewner::{Loewner, Sample};
use super::partial_fractions::{Evaluator, PartialFractions};
use super::passivity::Loss;
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
/// Factor of the tolerance with which fewer poles are tried, too.
const LOOSER: f64 = 3.0;
/// Fractions of the largest singular value that are tried as the smallest one kept.
const THRESHOLDS: [f64; 3] = [1e-6, 1e-7, 1e-8];

/// A passive rational function, and its error.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    /// With the loss.
    pub fractions: PartialFractions,
    /// Largest relative difference in the Frobenius norm at all computed frequencies.
    pub error: f64,
    /// Number of frequencies at which the function was computed.
    pub solved: usize,
    /// δ of the loss in it, over ρc.
    pub loss: f64,
    /// The loss over ρc without which it can produce energy; at most that in it if it is passive.
    pub needed: f64,
}

/// What a fit is held to.
pub(crate) struct Target<'a> {
    /// Frequencies ω, rad/s, ascending, at which the function is computed at first.
    pub frequencies: &'a [f64],
    /// Growth e^{σt} of the motion with which it is computed: σ, 1/s.
    pub damping: f64,
    /// Its slope at s = 0, the added mass.
    pub slope: &'a DMatrix<f64>,
    /// Real s, divided by the highest frequency, at which it has its value at infinity.
    pub infinite: f64,
    /// ω₀ of the loss, rad/s.
    pub corner: f64,
}

/// Fits `symbol` on `s = damping + iω` at the frequencies ω of `target` and between them, with its value 0 and its slope at
/// s = 0, and makes the fit passive by a loss.
///
/// The function is matched at the frequencies and checked half way between them. Where the error is above `tolerance`, the
/// checks become samples, and new checks are added beside them. With damping σ the samples are `iω (G/s)(σ + iω)`, which has
/// the same slope at 0. Above the frequencies the function is fitted to samples off the imaginary axis. Of all fits the one
/// with the fewest poles within the tolerance is taken, and the one within [`LOOSER`] times it. Either is made
/// passive with the `losses` (ascending), and the one with the smaller error is returned; if none will do, the fit that needs
/// the least, and `needed` is above its loss. None if the error is above `futile` even without a loss.
pub(crate) fn fit<E: Send>(
    symbol: impl Fn(Complex64) -> Result<DMatrix<Complex64>, E> + Sync,
    target: &Target<'_>,
    tolerance: f64,
    losses: &[f64],
    futile: f64,
) -> Result<Option<Fit>, E> {
    let Target { frequencies, damping, slope, infinite, corner } = *target;
    let largest = frequencies.last().copied().unwrap_or(1.0);
    // The value at a large real s, so that the rest vanishes at infinity.
    let direct = symbol(Complex64::from(infinite * largest))?.map(|g| g.re);
    let at = |points: &[Complex64]| -> Result<Vec<Sample>, E> {
        let sample = |&s: &Complex64| {
            let mut value = symbol(s + damping)?;
            value.zip_apply(&direct, |g, d| *g = *g * (s / (s + damping)) - d);
            Ok(Sample { s, value })
        };
        points.par_iter().map(sample).collect()
    };
    let sampled = |frequencies: &[f64]| {
        at(&frequencies.iter().map(|&omega| Complex64::new(0.0, omega)).collect::<Vec<_>>())
    };
    // The residues for given poles.
    let fitted = |mut fractions: PartialFractions, samples: &[Sample], held: &[Sample]| {
        fractions.direct.clone_from(&direct);
        let residues = Residues::fitted(&mut fractions, samples, held, slope)?;
        Some((fractions, residues))
    };
    // Above the frequencies the samples lie off the axis, where the function is smooth.
    let beyond = |k: i32| largest * 1.12f64.powi(k + 1) * Complex64::new(0.1, 1.0);
    let held = at(&(0..BEYOND).map(beyond).collect::<Vec<_>>())?;
    let mut samples = sampled(frequencies)?;
    let mut checks = sampled(&middles(frequencies))?;
    let mut tried: Vec<(PartialFractions, f64)> = Vec::new();
    for round in 1..=ROUNDS {
        let Some(loewner) = Loewner::new(&samples, DIRECTIONS) else { break };
        let candidate = |&order: &usize| {
            let mut fractions = loewner.truncated(order)?;
            // A pole without a sample nearby is not reliable.
            for pole in &mut fractions.poles {
                pole.re = pole.re.min(-0.1 * (pole.im - largest));
            }
            let (fractions, _) = fitted(fractions, &samples, &held)?;
            let found = Evaluator::of(&fractions);
            let difference = |check| difference(&found, &direct, check, TRUSTED * largest);
            let errors: Vec<f64> = checks.par_iter().map(difference).collect();
            Some((fractions, errors))
        };
        let candidates: Vec<_> = loewner.orders(&THRESHOLDS).par_iter().map(candidate).collect();
        let (mut errors, mut closest) = (Vec::new(), f64::INFINITY);
        for (fractions, found) in candidates.into_iter().flatten() {
            let error = found.iter().copied().fold(0.0, larger);
            if closest > tolerance && error < closest {
                (closest, errors) = (error, found);
            }
            tried.push((fractions, error));
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
    let mut all = samples.clone();
    all.extend(checks);
    all.sort_by(|a, b| a.s.im.total_cmp(&b.s.im));
    let frequencies: Vec<f64> = all.iter().map(|sample| sample.s.im).collect();
    // Of more poles, the fit is closer but can be harder to make passive.
    let mut fits: Vec<(PartialFractions, Residues)> = Vec::new();
    for tolerance in [tolerance, LOOSER * tolerance] {
        let Some(poles) = fewest(&tried, tolerance, futile) else { continue };
        if fits.iter().all(|(other, _)| other.poles != poles.poles) {
            fits.extend(fitted(poles.clone(), &samples, &held));
        }
    }
    let (mut best, mut least): (Option<Fit>, Option<Fit>) = (None, None);
    for &size in losses {
        // A larger loss has a larger error.
        if best.as_ref().is_some_and(|best| best.error <= size) {
            break;
        }
        let loss = Loss { size, corner };
        for (lossless, residues) in &fits {
            let (mut fractions, needed) = residues.made_passive(lossless, &frequencies, loss);
            loss.added_to(&mut fractions);
            let passive = Evaluator::of(&fractions);
            let difference = |sample| difference(&passive, &direct, sample, TRUSTED * largest);
            let error = all.par_iter().map(difference).reduce(|| 0.0, larger);
            let solved = all.len() + held.len() + 1;
            let found = Fit { fractions, error, solved, loss: size, needed };
            if needed > size {
                least = least.filter(|least| least.needed <= needed).or(Some(found));
            } else {
                best = best.filter(|best| best.error <= error).or(Some(found));
                // The other fits are less close.
                break;
            }
        }
    }
    Ok(best.or(least))
}

/// Of the fits and their errors the one with the fewest poles within the tolerance, or else the closest; none if even that
/// is futile.
fn fewest(tried: &[(PartialFractions, f64)], tolerance: f64, futile: f64) -> Option<&PartialFractions> {
    let order = |fractions: &PartialFractions| fractions.poles.len();
    let within = tried.iter().filter(|(_, error)| *error <= tolerance).min_by_key(|(tried, _)| order(tried));
    let closest = || tried.iter().min_by(|(_, a), (_, b)| a.total_cmp(b));
    within.or_else(closest).filter(|(_, error)| *error <= futile).map(|(fractions, _)| fractions)
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

/// `‖G̃ − G‖/‖G‖` at a check of `G − D`, 0 above `trusted`.
fn difference(
    found: &Evaluator<'_>,
    direct: &DMatrix<f64>,
    Sample { s, value }: &Sample,
    trusted: f64,
) -> f64 {
    if s.im > trusted {
        return 0.0;
    }
    let whole = value.zip_map(direct, |g, d| g + d);
    (found.at(*s) - &whole).norm() / whole.norm()
}
