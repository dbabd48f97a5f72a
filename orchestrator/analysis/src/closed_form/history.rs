//! The closed forms over time.

use super::{Exact, Kind};
use crate::parallel;
use cofferdam_reservoir::Complex64;
use cofferdam_reservoir::analytical::{chopra_1967, fenves_chopra_1984};
use std::f64::consts::PI;
use std::num::NonZeroUsize;

/// Largest α of an absorbing bed: above it the response decays too slowly for a Fourier series.
const LEAST_DECAY: f64 = 0.99;
/// Exponent of the decay after which a response counts as zero.
const DIED_AWAY: f64 = 18.0;
/// Share of the largest amplitude below which a frequency is left out.
const NOT_THERE: f64 = 1e-4;

impl Exact {
    /// Pressures (Pa) at the base at 0, H, 2H, … for accelerations downstream (m/s²) at these times, linear in
    /// between, from rest: by echoes over a rigid bed; over an absorbing bed by the modes at every frequency of the
    /// motion, on `threads`. `None` if there is no closed form over time.
    pub fn base_pressures(&self, samples: &[f64], step: f64, threads: NonZeroUsize) -> Option<Vec<f64>> {
        match self.kind {
            Kind::Rigid => Some(self.base_pressures_by_echoes(samples, step)),
            Kind::Absorbing if self.alpha < LEAST_DECAY => {
                Some(self.base_pressures_by_modes(samples, step, threads))
            }
            _ => None,
        }
    }

    /// The sum of the responses to a ramp from each sample on, by the change of slope there.
    fn base_pressures_by_echoes(&self, samples: &[f64], step: f64) -> Vec<f64> {
        let Self { density, depth, sound_speed, .. } = *self;
        let answers = |to: fn(f64, f64, f64) -> f64| -> Vec<f64> {
            (0..samples.len()).map(|n| to(depth, sound_speed, n as f64 * step)).collect()
        };
        let of_step = answers(chopra_1967::base_pressure_of_acceleration_step);
        let of_ramp = answers(chopra_1967::base_pressure_of_acceleration_ramp);
        let slopes: Vec<f64> = samples.windows(2).map(|pair| (pair[1] - pair[0]) / step).collect();
        let before = std::iter::once(0.0).chain(slopes.iter().copied());
        let bends: Vec<f64> = slopes.iter().zip(before).map(|(slope, before)| slope - before).collect();
        (0..samples.len())
            .map(|n| {
                let ramps: f64 = bends[..n].iter().zip(of_ramp[..=n].iter().rev()).map(|(b, r)| b * r).sum();
                -density * sound_speed * (samples[0] * of_step[n] + ramps)
            })
            .collect()
    }

    /// Fourier series over a period in which the response decays; it decays at least like α^{ct/2h}.
    fn base_pressures_by_modes(&self, samples: &[f64], step: f64, threads: NonZeroUsize) -> Vec<f64> {
        let rate = -0.5 * self.sound_speed / self.depth * self.alpha.max(1e-6).ln();
        let length = samples.len() + (DIED_AWAY / (rate * step)).ceil() as usize;
        let mut spectrum: Vec<Complex64> = samples.iter().map(|a| Complex64::from(*a)).collect();
        spectrum.resize(length, Complex64::ZERO);
        let mut planner = rustfft::FftPlanner::new();
        planner.plan_fft_forward(length).process(&mut spectrum);
        let frequency = |k: usize| 2.0 * PI * k as f64 / (length as f64 * step);
        // The transform of hats of one step on either side, except the first, which starts at its peak.
        let excited = |k: usize| {
            let angle = frequency(k) * step;
            if k == 0 {
                return spectrum[0] - 0.5 * samples[0];
            }
            let (hat, a) = ((0.5 * angle).sin().powi(2) / (0.5 * angle).powi(2), Complex64::new(0.0, angle));
            let half = 1.0 / a - (1.0 - (-a).exp()) / (a * a);
            spectrum[k] * hat - samples[0] * (hat - half)
        };
        // At high frequencies the response per velocity is −ρc, so per acceleration it decreases.
        let strength = |k: usize| excited(k).norm() / (1.0 + frequency(k) * self.depth / self.sound_speed);
        let strongest = (0..length / 2).map(strength).fold(0.0, f64::max);
        let present: Vec<usize> = (0..length / 2).filter(|&k| strength(k) > NOT_THERE * strongest).collect();
        let Self { density, depth, sound_speed, alpha, .. } = *self;
        let answer = |&k: &usize| {
            let s = Complex64::new(0.0, frequency(k));
            -density * fenves_chopra_1984::pressures(s, depth, sound_speed, alpha, &[0.0])[0]
        };
        let answers = parallel::map(&present, threads, answer);
        let mut pressures = vec![Complex64::ZERO; length];
        for (&k, answer) in present.iter().zip(answers) {
            pressures[k] = excited(k) * answer / length as f64;
            if k > 0 {
                pressures[length - k] = pressures[k].conj();
            }
        }
        planner.plan_fft_inverse(length).process(&mut pressures);
        pressures[..samples.len()].iter().map(|p| p.re).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_form::Motion;
    use cofferdam_reservoir::ReservoirParameters;
    use cofferdam_unit::WetFace;

    fn parameters() -> ReservoirParameters {
        ReservoirParameters::before(WetFace::straight([0.0, 90.0], 8).expect("a face"))
    }

    /// Before the first echo p = −ρ c γ v at the base (Fenves and Chopra's corner); over a bed that hardly absorbs, and one
    /// that does not, the two ways agree as far as the beds do.
    #[test]
    fn histories_are_those_of_the_corner_and_of_the_echoes() {
        let step = 0.0025;
        let rise = |t: f64| if t < 0.04 { (PI * t / 0.04).sin().powi(2) } else { 0.0 };
        let samples: Vec<f64> = (0..200).map(|n| rise(f64::from(n) * step)).collect();
        for alpha in [0.9, 0.5, 0.1] {
            let parameters = ReservoirParameters { wave_reflection_coefficient: alpha, ..parameters() };
            let exact = Exact::of(&parameters, Motion::Horizontal).expect("a closed form");
            let pressures = exact.base_pressures(&samples, step, NonZeroUsize::MIN).expect("a history");
            let (mut velocity, mut worst) = (0.0, 0.0f64);
            let gamma = fenves_chopra_1984::early_base_pressure(alpha);
            let scale = 1000.0 * 1440.0 * gamma * 0.02;
            // The first echo comes after h/c = 62.5 ms.
            for n in 1..24 {
                velocity += 0.5 * step * (samples[n - 1] + samples[n]);
                worst = worst.max((pressures[n] + 1000.0 * 1440.0 * gamma * velocity).abs() / scale);
            }
            println!("α = {alpha}: off the corner's answer by {worst:.1e} of the largest");
            assert!(worst < 2e-3);
        }
        // An acceleration that is there at once, after ten steps; half a step too many or too few would be 5 %.
        let absorbing = ReservoirParameters { wave_reflection_coefficient: 0.1, ..parameters() };
        let exact = Exact::of(&absorbing, Motion::Horizontal).expect("a closed form");
        let pressure = exact.base_pressures(&[1.0; 20], 0.005, NonZeroUsize::MIN).expect("a history")[10];
        let expected = -1000.0 * 1440.0 * fenves_chopra_1984::early_base_pressure(0.1) * 0.05;
        println!("constant acceleration: {pressure:.1} Pa, the corner's answer {expected:.1} Pa");
        assert!((pressure / expected - 1.0).abs() < 1e-2);
        let exact = Exact::of(&parameters(), Motion::Horizontal).expect("a closed form");
        let [echoes, record] =
            [exact.base_pressures(&samples, step, NonZeroUsize::MIN).expect("a history"), {
                let record: Vec<_> = samples.iter().enumerate().map(|(n, a)| (n as f64 * step, *a)).collect();
                (0..200).map(|n| exact.base_pressure(&record, f64::from(n) * step)).collect()
            }];
        let peak = record.iter().fold(0.0f64, |most, p| most.max(p.abs()));
        let off = echoes.iter().zip(&record).fold(0.0f64, |worst, (p, q)| worst.max((p - q).abs())) / peak;
        println!("echoes of samples and of a record: {off:.1e}");
        assert!(off < 1e-10);
    }
}
