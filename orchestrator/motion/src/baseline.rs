//! Whether a record comes to rest.

use super::{Component, GroundMotion};

/// Largest and last of a history.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drift {
    /// Largest absolute value.
    pub peak: f64,
    /// Value at the end.
    pub end: f64,
}

impl Drift {
    fn of(history: &[f64]) -> Self {
        let peak = history.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()));
        Self { peak, end: history.last().copied().unwrap_or(0.0) }
    }

    /// What remains at the end over the peak; 0 for a history that is zero.
    pub fn share(self) -> f64 {
        if self.peak > 0.0 { self.end.abs() / self.peak } else { 0.0 }
    }
}

impl GroundMotion {
    /// Horizontal velocity (m/s) and displacement (m) of the ground, by the trapezoidal rule from rest.
    pub fn drift(&self) -> [Drift; 2] {
        self.horizontal().drift()
    }
}

impl Component {
    /// Velocity (m/s) and displacement (m) of the ground, by the trapezoidal rule from rest.
    pub fn drift(&self) -> [Drift; 2] {
        let velocity = self.integral(self.acceleration());
        [Drift::of(&velocity), Drift::of(&self.integral(&velocity))]
    }

    fn integral(&self, history: &[f64]) -> Vec<f64> {
        let mut sum = 0.0;
        let steps = history.windows(2).map(|pair| {
            sum += 0.5 * (pair[0] + pair[1]) * self.interval();
            sum
        });
        std::iter::once(0.0).chain(steps).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_offset_of_the_baseline_is_a_drift() {
        // ü = sin ωt, ω = 2π: u̇ = (1 − cos ωt)/ω, peak 2/ω; u = t/ω − sin ωt/ω².
        let omega = std::f64::consts::TAU;
        let interval = 1e-3;
        let samples = |offset: f64| (0..=4000).map(move |i| (omega * f64::from(i) * interval).sin() + offset);
        let motion = |offset| GroundMotion::of_samples("sine", interval, samples(offset).collect());
        let [velocity, displacement] = motion(0.0).drift();
        // The trapezoidal rule errs by (ωΔt)²/12 = 3e-6.
        assert!((velocity.peak * omega / 2.0 - 1.0).abs() < 1e-5, "{velocity:?}");
        assert!(velocity.share() < 1e-5, "{velocity:?}");
        assert!((displacement.end * omega / 4.0 - 1.0).abs() < 1e-5, "{displacement:?}");
        assert!((motion(0.1).drift()[0].end - 0.4).abs() < 1e-5);
    }
}
