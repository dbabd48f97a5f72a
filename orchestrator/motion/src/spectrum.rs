//! What frequencies a record holds.

use super::{Component, GroundMotion};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

impl GroundMotion {
    /// Frequency below which `share` (0 to 1) of the Fourier energy of the horizontal acceleration lies, Hz.
    pub fn frequency_below_which(&self, share: f64) -> f64 {
        self.horizontal().frequency_below_which(share)
    }
}

impl Component {
    /// Frequency below which `share` (0 to 1) of the Fourier energy Σ|ü̂|² of the acceleration lies, Hz.
    ///
    /// The samples are followed by as many zeros, which halves the distance 1/(2NΔt) of the frequencies.
    pub fn frequency_below_which(&self, share: f64) -> f64 {
        let samples = self.acceleration();
        let length = (2 * samples.len()).next_power_of_two();
        let mut spectrum: Vec<Complex<f64>> = samples.iter().map(|a| Complex::from(*a)).collect();
        spectrum.resize(length, Complex::default());
        FftPlanner::new().plan_fft_forward(length).process(&mut spectrum);
        let energies = || spectrum[..=length / 2].iter().map(Complex::norm_sqr);
        let wanted = share * energies().sum::<f64>();
        let mut below = 0.0;
        let reached = energies().position(|energy| {
            below += energy;
            below >= wanted
        });
        reached.unwrap_or(length / 2) as f64 / (length as f64 * self.interval())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_has_its_own_frequency_and_a_stronger_one_decides() {
        let interval = 0.01;
        let motion = |weak: f64| {
            let at = |i: usize| {
                let phase = std::f64::consts::TAU * i as f64 * interval;
                (2.0 * phase).sin() + weak * (12.0 * phase).sin()
            };
            GroundMotion::of_samples("sines", interval, (0..2000).map(at).collect())
        };
        // 20 s resolve 0.05 Hz; the leakage of a cut sine holds a percent within a few times that.
        let alone = motion(0.0).frequency_below_which(0.99);
        assert!((alone - 2.0).abs() < 0.5, "{alone}");
        // The energy of the weak sine: 0.04 / 1.04 = 3.8 %; or 0.0025 / 1.0025 = 0.25 %.
        let heard = motion(0.2).frequency_below_which(0.99);
        assert!((heard - 12.0).abs() < 0.5, "{heard}");
        let unheard = motion(0.05).frequency_below_which(0.99);
        assert!((unheard - 2.0).abs() < 0.5, "{unheard}");
    }
}
