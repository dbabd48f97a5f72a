//! Motions that differ a little.

use super::{Component, GroundMotion};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Sets the noise of the vertical component apart from that of the horizontal one.
const OF_VERTICAL: u64 = 0x9e37_79b9_7f4a_7c15;
/// Sets the noise of each shock of a sequence apart from that of the one before.
const OF_SHOCK: u64 = 0xd1b5_4a32_d192_ed03;

impl GroundMotion {
    /// The same with noise in each component: of the frequencies of the component, with random phases, its root mean square the
    /// `share` of the component's. The same `seed` gives the same noise. In a sequence each shock has its own, and the ground between
    /// them stays still.
    #[must_use]
    pub fn with_noise(&self, share: f64, seed: u64) -> Self {
        let mut moved = self.clone();
        if self.aftershocks().is_empty() {
            moved.horizontal = self.horizontal.with_noise(share, seed);
            moved.vertical = self.vertical().map(|vertical| vertical.with_noise(share, seed ^ OF_VERTICAL));
            return moved;
        }
        let components = std::iter::once(&mut moved.horizontal).chain(&mut moved.vertical);
        for (component, seed) in components.zip([seed, seed ^ OF_VERTICAL]) {
            for (number, range) in self.ranges(component).into_iter().enumerate() {
                let shock = &mut component.acceleration[range];
                let moves = |a: &f64| *a != 0.0;
                if let (Some(first), Some(last)) =
                    (shock.iter().position(moves), shock.iter().rposition(moves))
                {
                    add_noise(&mut shock[first..=last], share, seed ^ OF_SHOCK.wrapping_mul(number as u64));
                }
            }
        }
        moved
    }
}

impl Component {
    /// The same with noise: of the frequencies of this motion, with random phases, its root mean square the `share` of this
    /// motion's. The same `seed` gives the same noise.
    ///
    /// ```text
    /// a + share · F⁻¹(|F(a)| e^{iφ}),   φ uniform
    /// ```
    ///
    /// A factor on a motion is one direction in which it can change, along which results move smoothly; noise is a sample of all that
    /// the motion could have been as well.
    #[must_use]
    pub fn with_noise(&self, share: f64, seed: u64) -> Self {
        let mut moved = self.clone();
        add_noise(&mut moved.acceleration, share, seed);
        moved
    }
}

fn add_noise(samples: &mut [f64], share: f64, seed: u64) {
    let count = samples.len();
    let mut planner = FftPlanner::new();
    let mut spectrum: Vec<Complex<f64>> = samples.iter().map(|a| Complex::from(*a)).collect();
    planner.plan_fft_forward(count).process(&mut spectrum);
    let mut random = fastrand::Rng::with_seed(seed);
    let amplitudes: Vec<f64> = spectrum.iter().map(|value| value.norm()).collect();
    spectrum.fill(Complex::default());
    // no mean; a real sum, so that a frequency and its mirror image have conjugate values
    for k in 1..count.div_ceil(2) {
        let value = Complex::from_polar(amplitudes[k], TAU * random.f64());
        (spectrum[k], spectrum[count - k]) = (value, value.conj());
    }
    planner.plan_fft_inverse(count).process(&mut spectrum);
    for (sample, noise) in samples.iter_mut().zip(&spectrum) {
        *sample += share * noise.re / count as f64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_frequencies_of_the_motion_and_the_share_of_its_strength() {
        // Between 2 and 5 Hz, 20 s.
        let at = |i: i32| {
            let t = 0.01 * f64::from(i);
            (2..=5).map(|f| (TAU * f64::from(f) * t + f64::from(f * f)).sin()).sum::<f64>()
        };
        for count in [2000, 2001] {
            let motion = GroundMotion::of_samples("sines", 0.01, (0..count).map(at).collect());
            let noise = |seed: u64| -> Vec<f64> {
                let moved = motion.with_noise(0.01, seed);
                moved.acceleration().iter().zip(motion.acceleration()).map(|(a, b)| a - b).collect()
            };
            let (first, second) = (noise(1), noise(2));
            let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let strength = product(motion.acceleration(), motion.acceleration());
            let ratio = (product(&first, &first) / strength).sqrt();
            assert!((ratio / 0.01 - 1.0).abs() < 1e-3, "{ratio}");
            assert!(product(&first, &second).abs() < 0.9 * product(&first, &first), "two seeds, one noise");
            assert_eq!(first, noise(1));
            // What lies at 1 Hz, where the motion has nothing, is far below what lies at 2 Hz.
            let at_frequency = |f: f64| {
                let sum = |of: fn(f64) -> f64| -> f64 {
                    first.iter().enumerate().map(|(i, a)| a * of(TAU * f * 0.01 * i as f64)).sum()
                };
                sum(f64::sin).hypot(sum(f64::cos))
            };
            assert!(
                at_frequency(1.0) < 0.05 * at_frequency(2.0),
                "{} {}",
                at_frequency(1.0),
                at_frequency(2.0)
            );
        }
        let still = GroundMotion::of_samples("none", 0.1, vec![0.0; 9]);
        assert_eq!(still.with_noise(0.01, 1), still);
    }
    #[test]
    fn every_shock_of_a_sequence_has_its_own_noise_and_the_rest_has_none() {
        let wave = |strength: f64| {
            let at = |t: f64| (2..=9).map(|f| (TAU * f64::from(f) * t + f64::from(f * f)).sin()).sum::<f64>();
            let samples = (1..400).map(|i| strength * at(0.01 * f64::from(i))).collect();
            GroundMotion::of_samples("sines", 0.01, samples)
        };
        let joined = wave(1.0).followed_by(&[(2.0, wave(0.5)), (3.0, wave(1.0))]).expect("equal intervals");
        let moved = joined.with_noise(0.1, 3);
        assert_eq!((moved.begins(), moved.rest_from()), (joined.begins(), joined.rest_from()));
        let noise: Vec<Vec<f64>> = moved
            .shocks()
            .iter()
            .zip(joined.shocks())
            .map(|(moved, own)| {
                moved.acceleration().iter().zip(own.acceleration()).map(|(a, b)| a - b).collect()
            })
            .collect();
        let strength = |values: &[f64]| values.iter().map(|a| a * a).sum::<f64>().sqrt();
        for (noise, own) in noise.iter().zip(joined.shocks()) {
            let share = strength(noise) / strength(own.acceleration());
            assert!((share / 0.1 - 1.0).abs() < 0.02, "{share}");
        }
        // the third is the first again, but not its noise
        let apart: Vec<f64> = noise[0].iter().zip(&noise[2][1..]).map(|(a, b)| a - b).collect();
        assert!(strength(&apart) > 0.5 * strength(&noise[0]));
        for [end, begin] in [[4.1, 5.9], [10.1, 12.9]] {
            assert!((0..100).all(|n| moved.at(end + (begin - end) * f64::from(n) / 99.0) == [0.0; 2]));
        }
    }
}
