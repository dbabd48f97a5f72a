//! How strong a record is.

use super::{GroundMotion, STANDARD_GRAVITY};
use std::f64::consts::PI;

impl GroundMotion {
    /// Arias intensity of the horizontal component, I = π/(2g) ∫ ü² dt, m/s, and the time between 5 and 95 % of it, s, by the rectangle rule.
    pub fn arias_intensity(&self) -> (f64, f64) {
        let scale = PI / (2.0 * STANDARD_GRAVITY) * self.interval();
        let total: f64 = self.acceleration().iter().map(|a| scale * a * a).sum();
        let reached = |share: f64| {
            let mut sum = 0.0;
            let below = |a: &&f64| {
                sum += scale * **a * **a;
                sum < share * total
            };
            self.acceleration().iter().take_while(below).count()
        };
        (total, (reached(0.95) - reached(0.05)) as f64 * self.interval())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_intensity_of_a_sine() {
        // ∫ sin² over ten periods of 1 s is 5 s; 90 % of it take 9 s.
        let samples = (0..=10_000).map(|i| 2.0 * (2.0 * PI * f64::from(i) * 1e-3).sin()).collect();
        let (intensity, duration) = GroundMotion::of_samples("sine", 1e-3, samples).arias_intensity();
        assert!((intensity / (PI / (2.0 * STANDARD_GRAVITY) * 20.0) - 1.0).abs() < 1e-6, "{intensity}");
        assert!((duration - 9.0).abs() < 0.01, "{duration}");
        let still = GroundMotion::of_samples("none", 0.1, vec![0.0; 9]).arias_intensity();
        assert_eq!(still, (0.0, 0.0));
    }
}
