//! Response spectra.

use super::GroundMotion;

/// Pseudo-acceleration response spectrum `S_a = ω² max |x|` of oscillators on a point that accelerates by a:
///
/// ```text
/// ẍ + 2ξω ẋ + ω² x = −a
/// ```
///
/// from rest, each carried exactly over every interval in which a is constant. Peaks are looked for at the ends of equal
/// parts of the intervals, at least twenty a period.
///
/// **Shapes and units**: `acceleration` (m/s²) holds the means over the intervals (s); one S_a (m/s²) for each of
/// `periods` (s, positive); `damping` is ξ in [0, 1).
///
/// **Source**: N.C. Nigam, P.C. Jennings, Calculation of response spectra from strong-motion earthquake records,
/// Bulletin of the Seismological Society of America 59 (1969).
pub fn response_spectrum(intervals: &[f64], acceleration: &[f64], periods: &[f64], damping: f64) -> Vec<f64> {
    let peak = |&period: &f64| {
        let frequency = std::f64::consts::TAU / period;
        let damped = frequency * (1.0 - damping * damping).sqrt();
        let (mut x, mut v, mut peak) = (0.0f64, 0.0, 0.0f64);
        let mut carried = Carry::default();
        for (&interval, a) in intervals.iter().zip(acceleration) {
            let parts = (interval * LEAST_PARTS / period).ceil().max(1.0);
            carried.over(interval / parts, damping * frequency, damped);
            let rest = -a / (frequency * frequency);
            for _ in 0..parts as usize {
                [x, v] = carried.apply(x - rest, v, damping * frequency, frequency);
                x += rest;
                peak = peak.max(x.abs());
            }
        }
        frequency * frequency * peak
    };
    periods.iter().map(peak).collect()
}

impl GroundMotion {
    /// [`response_spectrum`] of the horizontal component, whose mean over an interval is that of its ends, and of two of the longest periods of
    /// rest after it.
    ///
    /// **Shapes and units**: one S_a (m/s²) for each of `periods` (s, positive); `damping` is ξ in [0, 1).
    pub fn response_spectrum(&self, periods: &[f64], damping: f64) -> Vec<f64> {
        let longest = periods.iter().copied().fold(0.0, f64::max);
        let rest = (2.0 * longest / self.interval()).ceil() as usize;
        let means = self.acceleration().windows(2).map(|pair| (pair[0] + pair[1]) / 2.0);
        let means: Vec<f64> = means.chain(std::iter::repeat_n(0.0, rest)).collect();
        response_spectrum(&vec![self.interval(); means.len()], &means, periods, damping)
    }
}

/// Parts of a period between which peaks are looked for.
const LEAST_PARTS: f64 = 20.0;

/// `e^{−ξωt}` with cosine and sine (the sine over the damped frequency) after a time.
#[derive(Default)]
struct Carry {
    time: f64,
    cos: f64,
    sin: f64,
}

impl Carry {
    fn over(&mut self, time: f64, decay: f64, damped: f64) {
        if self.time != time {
            let shrunk = (-decay * time).exp();
            let (sin, cos) = (damped * time).sin_cos();
            *self = Self { time, cos: shrunk * cos, sin: shrunk * sin / damped };
        }
    }

    fn apply(&self, x: f64, v: f64, decay: f64, frequency: f64) -> [f64; 2] {
        let Self { cos, sin, .. } = self;
        [(cos + decay * sin) * x + sin * v, (cos - decay * sin) * v - frequency * frequency * sin * x]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// Under a step an undamped oscillator overshoots to twice its rest, a damped one by `e^{−πξ/√(1−ξ²)}`.
    #[test]
    fn a_step_overshoots_as_in_the_textbook() {
        let (intervals, acceleration) = (vec![0.005; 2000], vec![3.0; 2000]);
        for damping in [0.0f64, 0.05, 0.2] {
            let overshoot = (-PI * damping / (1.0 - damping * damping).sqrt()).exp();
            for (found, period) in response_spectrum(&intervals, &acceleration, &[0.02, 0.3, 2.0], damping)
                .into_iter()
                .zip([0.02, 0.3, 2.0])
            {
                let exact = 3.0 * (1.0 + overshoot);
                assert!((found / exact - 1.0).abs() < 0.015, "ξ = {damping}, T = {period}: {found}, {exact}");
            }
        }
    }

    /// In resonance a sine of amplitude a rings up to a/2ξ.
    #[test]
    fn resonance_rings_up_to_its_limit() {
        let (interval, period) = (1e-3, 0.4);
        let mean = |i: i32| {
            let at = |n: i32| (TAU * f64::from(n) * interval / period).cos();
            (at(i) - at(i + 1)) * period / (TAU * interval)
        };
        let acceleration: Vec<f64> = (0..40_000).map(mean).collect();
        let found = response_spectrum(&vec![interval; 40_000], &acceleration, &[period], 0.05)[0];
        assert!((found / 10.0 - 1.0).abs() < 5e-3, "{found}");
    }

    /// A stiff oscillator follows its support, a soft one stays behind.
    #[test]
    fn the_ends_of_a_spectrum_are_those_of_the_motion() {
        let pulse: Vec<f64> =
            (0..1000).map(|i| if i < 500 { (PI * f64::from(i) / 500.0).sin() } else { 0.0 }).collect();
        let found = response_spectrum(&[0.002; 1000], &pulse, &[0.01, 1000.0], 0.05);
        assert!((found[0] - 1.0).abs() < 0.01 && found[1] < 1e-3, "{found:?}");
    }
}
