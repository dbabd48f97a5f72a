//! The pressure under a whole record at once, by one damped Fourier transform of the motion and its inverse.
//!
//! Depends on `added_mass`, `condition` and `system`.

use crate::added_mass::whole_added_mass;
use crate::condition::FarEndCondition;
use crate::system::boundary_system;
use crate::{ReservoirError, ReservoirParameters};
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;
use rayon::prelude::*;
use rustfft::FftPlanner;
use std::f64::consts::PI;
use std::num::NonZeroUsize;

/// `e^{−σP}`: fraction of the pressure one period P later that the transform adds (wrap-around). Undoing the damping
/// magnifies the error of K(s), about 1e-9, by up to `e^{σP/2}` = 1e4 at the end of the record, P/2.
const WRAP_AROUND: f64 = 1e-8;
/// Fraction of the highest frequency π/H up to which the window w is 1.
const KEPT: f64 = 0.6;
/// Largest number of instants of a record.
const MOST_INSTANTS: usize = 1_000_000;

/// Pressure at all interface points and instants, for accelerations that are known beforehand.
///
/// With a period P twice the record, `s_k = σ + 2πik/P`, acceleration a linear in between and velocity v
/// from rest,
///
/// ```text
/// A(s) = H [sinh(sH/2)/(sH/2)]² Σ_n a_n e^{−s nH} − a_0 (e^{sH} − 1 − sH)/(s² H)
/// p_n  = −ρc v_n + (e^{σ nH}/P) Σ_k w(ω_k) (K(s_k) + ρc) A(s_k)/s_k · e^{iω_k nH},     |ω_k| < π/H
/// ```
///
/// The motion is transformed exactly, so that only the sum over frequencies approximates.
/// *Wrap-around*: on Re s = σ the sum is periodic, and adds `e^{−σP}` = 1e-8 of the value one period later
/// (of p + ρc v, which under a constant acceleration is then about ten times p).
/// *The highest frequency*: the plane wave's −ρc v is left out of the sum, so that the part beyond π/H is small.
/// From 0.6 π/H on, w reduces the sum to zero with all derivatives continuous: the ringing after a sharp cut would fall
/// with time only like 1/t, and e^{σt} would magnify it. The error is of order 5/2 in H beside a kink of `a`, and of
/// order 3/2 beside a jump from rest, because the pressure behind their echoes begins like t^{5/2} and t^{3/2}.
///
/// **Shapes and units**: `acceleration` has one row per interface point, along n, then one for the ground along x and one
/// along y (m/s², all total). It has one column per instant, `communication_step` apart, and starts from rest. Pressures
/// in Pa: one row per point, one column per instant. For water without memory `p_n = −A a_n` with its added mass; method
/// and horizon have no effect. Results do not depend on the number of threads, bit for bit.
///
/// The motion must not depend on the pressure; for coupling, [`Reservoir`](crate::Reservoir) goes step by step.
///
/// **Errors**: parameters out of range, [`ReservoirError::RecordShape`], [`ReservoirError::NonFiniteRecord`],
/// [`ReservoirError::TooMuch`], those of [`frequency_response`](crate::frequency_response()) and of
/// [`added_mass`](crate::added_mass()), [`ReservoirError::NonFinitePressure`].
///
/// **Source**: damped transforms of this kind are those of Wilcox (1978), Numerical Laplace transformation and
/// inversion, International Journal of Electrical Engineering Education 15, 247–265. Checked by `tests/whole_record.rs`.
pub fn pressure_of_record(
    parameters: &ReservoirParameters,
    acceleration: &DMatrix<f64>,
    threads: NonZeroUsize,
) -> Result<DMatrix<f64>, ReservoirError> {
    pressure_before(FarEndCondition::Outgoing, parameters, acceleration, threads)
}

/// The same with any condition at the far end.
pub(crate) fn pressure_before(
    far_end: FarEndCondition,
    parameters: &ReservoirParameters,
    acceleration: &DMatrix<f64>,
    threads: NonZeroUsize,
) -> Result<DMatrix<f64>, ReservoirError> {
    parameters.validate()?;
    let (points, step) = (parameters.wet_face.len(), parameters.communication_step);
    check_record(acceleration, points + 2)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build()?;
    let pressure = if parameters.fidelity.has_memory() {
        let system = boundary_system(parameters)?.ending(far_end);
        let impedance = parameters.density * parameters.sound_speed;
        pool.install(|| transformed(|s| system.symbol(s), impedance, step, acceleration))?
    } else {
        -(whole_added_mass(parameters)? * acceleration)
    };
    match pressure.iter().position(|p| !p.is_finite()) {
        None => Ok(pressure),
        Some(position) => {
            let (instant, index) = (position / points, position % points);
            let value = pressure[(index, instant)];
            Err(ReservoirError::NonFinitePressure { index, value, time: instant as f64 * step })
        }
    }
}

/// Checks that the record has `expected` inputs.
pub(crate) fn check_record(acceleration: &DMatrix<f64>, expected: usize) -> Result<(), ReservoirError> {
    let (rows, instants) = acceleration.shape();
    if rows != expected || instants == 0 {
        return Err(ReservoirError::RecordShape { rows, instants, expected });
    }
    if instants > MOST_INSTANTS {
        let (value, most) = (instants as f64, MOST_INSTANTS as f64);
        let (what, remedy) = ("instants of a record", "shorten it, or lengthen `communication_step`");
        return Err(ReservoirError::TooMuch { what, value, most, remedy });
    }
    match acceleration.iter().position(|a| !a.is_finite()) {
        None => Ok(()),
        Some(position) => {
            let (instant, row) = (position / rows, position % rows);
            Err(ReservoirError::NonFiniteRecord { row, instant, value: acceleration[(row, instant)] })
        }
    }
}

/// The pressure of water with the symbol K(s), outputs × inputs, on the current rayon pool. The first inputs belong to the
/// same points as the outputs; for these the plane wave has the `impedance` ρc (Pa·s/m).
fn transformed<E: Send>(
    symbol: impl Fn(Complex64) -> Result<DMatrix<Complex64>, E> + Sync,
    impedance: f64,
    step: f64,
    acceleration: &DMatrix<f64>,
) -> Result<DMatrix<f64>, E> {
    let (inputs, instants) = acceleration.shape();
    let length = 2 * instants.max(32);
    let period = length as f64 * step;
    let sigma = -WRAP_AROUND.ln() / period;
    let mut planner = FftPlanner::new();
    let (forward, back) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
    let spectra: Vec<Vec<Complex64>> = (0..inputs)
        .into_par_iter()
        .map(|input| {
            let mut values = vec![Complex64::ZERO; length];
            for (n, value) in values[..instants].iter_mut().enumerate() {
                *value = (acceleration[(input, n)] * (-sigma * n as f64 * step).exp()).into();
            }
            forward.process(&mut values);
            values
        })
        .collect();
    let answers = (0..length / 2)
        .into_par_iter()
        .map(|k| {
            let s = Complex64::new(sigma, 2.0 * PI * k as f64 / period);
            let [hat, early] = transforms(s, step);
            let velocity =
                DVector::from_fn(inputs, |i, _| (hat * spectra[i][k] - early * acceleration[(i, 0)]) / s);
            let mut pressure = symbol(s)? * &velocity;
            for (point, p) in pressure.iter_mut().enumerate() {
                *p = (*p + impedance * velocity[point]) * share(2.0 * k as f64 / length as f64);
            }
            Ok(pressure)
        })
        .collect::<Result<Vec<_>, E>>()?;
    let points = answers[0].len();
    let histories: Vec<Vec<f64>> = (0..points)
        .into_par_iter()
        .map(|point| {
            let mut values = vec![Complex64::ZERO; length];
            for (k, answer) in answers.iter().enumerate() {
                values[k] = answer[point];
                values[(length - k) % length] = answer[point].conj();
            }
            // Real at k = 0.
            back.process(&mut values);
            let (mut velocity, mut before) = (0.0, acceleration[(point, 0)]);
            (0..instants)
                .map(|n| {
                    let now = acceleration[(point, n)];
                    if n > 0 {
                        velocity += 0.5 * step * (before + now);
                    }
                    before = now;
                    let undamped = (sigma * n as f64 * step).exp() / period * values[n].re;
                    undamped - impedance * velocity
                })
                .collect()
        })
        .collect();
    Ok(DMatrix::from_fn(points, instants, |point, n| histories[point][n]))
}

/// Transforms of the hat function on [−H, H], and of its half before 0.
fn transforms(s: Complex64, step: f64) -> [Complex64; 2] {
    let x = s * step;
    let half = (0.5 * x).sinh() / (0.5 * x);
    [step * half * half, step * (x.exp() - 1.0 - x) / (x * x)]
}

/// The window w: 1 up to `KEPT` of the highest frequency, 0 at the highest frequency, all derivatives continuous.
fn share(ratio: f64) -> f64 {
    let x = (ratio - KEPT) / (1.0 - KEPT);
    if x <= 0.0 { 1.0 } else { 1.0 / (1.0 + (1.0 / (1.0 - x) - 1.0 / x).exp()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analytical::chopra_1967;
    use std::convert::Infallible;

    const DEPTH: f64 = 180.0;
    const SOUND_SPEED: f64 = 1440.0;

    /// K of the base pressure over ρc under uniform motion along n.
    fn base(s: Complex64) -> Result<DMatrix<Complex64>, Infallible> {
        let pressure = chopra_1967::pressure(s, DEPTH, SOUND_SPEED, 0.0) / SOUND_SPEED;
        Ok(DMatrix::from_element(1, 1, -s * pressure))
    }

    /// Largest error over the largest value, and that of the last tenth.
    fn errors(step: f64, duration: f64, record: &[(f64, f64)], at: impl Fn(f64) -> f64) -> [f64; 2] {
        let count = (duration / step).round() as usize + 1;
        let motion = DMatrix::from_fn(1, count, |_, n| -at(n as f64 * step));
        let Ok(found) = transformed(base, 1.0, step, &motion);
        let exact: Vec<f64> = (0..count)
            .map(|n| chopra_1967::base_pressure(record, DEPTH, SOUND_SPEED, n as f64 * step))
            .collect();
        let peak = exact.iter().fold(0.0, |most: f64, p| most.max(p.abs()));
        let worst = |from: usize| {
            (from..count).fold(0.0, |most: f64, n| most.max((found[(0, n)] - exact[n]).abs())) / peak
        };
        [worst(0), worst(count * 9 / 10)]
    }

    /// A ramp in 0.1 s, held, and a step at once, for 4 s, against their closed form: no boundary elements. The response
    /// to a kink of acceleration begins, with an echo, like t^{5/2}, that to a jump like t^{3/2}.
    #[test]
    fn order_in_the_step() {
        for (name, rise, least, most) in [("ramp", 0.1, 2.0, 1e-5), ("step", 0.0, 1.0, 1e-3)] {
            let record = if rise > 0.0 { vec![(0.0, 0.0), (rise, 1.0)] } else { vec![(0.0, 1.0)] };
            let at = |t: f64| if rise > 0.0 { (t / rise).min(1.0) } else { 1.0 };
            let found = [0.01, 0.005, 0.0025].map(|step| {
                let [error, late] = errors(step, 4.0, &record, at);
                println!("{name}, H = {step} s: error {error:.2e} of the peak, in the last tenth {late:.2e}");
                [error, late]
            });
            let order = 0.5 * (found[0][0] / found[2][0]).log2();
            println!("{name}: order {order:.2}");
            // The error that is magnified by undoing the damping does not grow towards the end.
            assert!(order > least && found[2][0] < most && found.iter().all(|[all, late]| late < all));
        }
    }

    #[test]
    fn what_is_kept_falls_smoothly() {
        assert_eq!([share(0.0), share(KEPT), share(1.0)], [1.0, 1.0, 0.0]);
        assert!((share(0.5 * (1.0 + KEPT)) - 0.5).abs() < 1e-15);
    }
}
