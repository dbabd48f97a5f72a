use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Extrapolates the accepted values to the end of the next step, for its first guess.
///
/// Order 0: p₀; order 1: 2p₀ − p₁; order 2: 3p₀ − 3p₁ + p₂, with p₀ the newest; steps of
/// equal length. Begins with the order that the history allows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Predictor {
    order: usize,
    history: VecDeque<Vec<f64>>,
}

impl Predictor {
    /// Highest order there is.
    pub const HIGHEST_ORDER: usize = 2;

    /// A predictor of `order` 0 to 2; higher ones count as 2.
    pub fn new(order: usize) -> Self {
        Self { order: order.min(Self::HIGHEST_ORDER), history: VecDeque::new() }
    }

    /// Takes accepted values.
    pub fn accept(&mut self, values: &[f64]) {
        self.history.truncate(self.order);
        self.history.push_front(values.to_vec());
    }

    /// Writes the extrapolated values; zero without a history.
    pub fn predict(&self, values: &mut [f64]) {
        let weights: &[f64] = match self.history.len() {
            0 => &[],
            1 => &[1.0],
            2 => &[2.0, -1.0],
            _ => &[3.0, -3.0, 1.0],
        };
        values.fill(0.0);
        for (weight, past) in weights.iter().zip(&self.history) {
            for (value, p) in values.iter_mut().zip(past) {
                *value += weight * p;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Predictor;

    #[test]
    fn polynomials_up_to_the_order_are_met_exactly() {
        for order in 0..=2 {
            let polynomial =
                |t: f64| 3.0 + if order > 0 { 2.0 * t } else { 0.0 } + if order > 1 { t * t } else { 0.0 };
            let mut predictor = Predictor::new(order);
            let mut guess = [1.0];
            predictor.predict(&mut guess);
            assert_eq!(guess, [0.0]);
            for step in 0..6 {
                if step > order {
                    predictor.predict(&mut guess);
                    assert_eq!(guess[0], polynomial(step as f64), "order {order}, step {step}");
                }
                predictor.accept(&[polynomial(step as f64)]);
            }
        }
    }
}
