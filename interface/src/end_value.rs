use serde::{Deserialize, Serialize};

/// The acceleration at the end of a communication step, from the means over it and over the step before.
///
/// ```text
/// a_end = ā_n + (ā_n − ā_{n−1}) H_n / (H_n + H_{n−1})
/// ```
///
/// This is exact for an acceleration that is linear in time, otherwise of second order. With equal steps it is
/// `1.5 ā_n − 0.5 ā_{n−1}`, BDF2 of the velocity. Before the first step everything is taken to be at rest for a step
/// of the same length. It depends on the means only, that is, on velocities: unlike the acceleration that acts at the
/// end itself, it does not jump with a pressure that is only guessed, so that a fixed point of both units is found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EndAcceleration {
    /// ā_n of each point, m/s².
    pub mean: Vec<f64>,
    /// a_end of each point, m/s².
    pub at_end: Vec<f64>,
    /// H_n, s; 0 before the first step.
    pub length: f64,
    /// `H_n / (H_n + H_{n−1})`.
    pub share: f64,
}

impl EndAcceleration {
    /// That of `points` points at rest.
    pub fn at_rest(points: usize) -> Self {
        Self { mean: vec![0.0; points], at_end: vec![0.0; points], length: 0.0, share: 0.5 }
    }

    /// Takes a step of `length` (s) with the means `mean` (m/s²), one for each point.
    pub fn step(&mut self, mean: &[f64], length: f64) {
        let before = if self.length > 0.0 { self.length } else { length };
        (self.length, self.share) = (length, length / (length + before));
        for ((last, end), mean) in self.mean.iter_mut().zip(&mut self.at_end).zip(mean) {
            (*end, *last) = (mean + (mean - *last) * self.share, *mean);
        }
    }

    /// Whether it has the values of `points` points.
    pub fn is_of(&self, points: usize) -> bool {
        self.mean.len() == points && self.at_end.len() == points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// a(t) = 2 + 3t over steps of unequal length: exact from the second step on.
    #[test]
    fn a_linear_acceleration_is_exact() {
        let mut acceleration = EndAcceleration::at_rest(1);
        let mut time = 0.0;
        for (step, length) in [0.5, 0.5, 1.25, 0.125].into_iter().enumerate() {
            let mean = 2.0 + 3.0 * (time + length / 2.0);
            acceleration.step(&[mean], length);
            time += length;
            let at_end = 2.0 + 3.0 * time;
            assert_eq!((acceleration.at_end[0] - at_end).abs() < 1e-14, step > 0, "step {step}");
        }
        assert_eq!((acceleration.length, acceleration.share), (0.125, 0.125 / 1.375));
    }
}
