use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Extrapolates the accepted values to the end of the next steps, for their first guess.
///
/// The polynomial through the newest `order + 1` accepted values, of the highest order that the history allows; steps
/// may differ in length. For equal steps: order 0: p₀; order 1: 2p₀ − p₁; order 2: 3p₀ − 3p₁ + p₂, with p₀ the
/// newest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Predictor {
    order: usize,
    /// Newest first: length of the step that ends with them (s), and the values.
    history: VecDeque<(f64, Vec<f64>)>,
}

impl Predictor {
    /// Highest order there is.
    pub const HIGHEST_ORDER: usize = 2;

    /// A predictor of `order` 0 to 2; higher ones count as 2.
    pub fn new(order: usize) -> Self {
        Self { order: order.min(Self::HIGHEST_ORDER), history: VecDeque::new() }
    }

    /// Takes the order of another.
    pub fn set_order(&mut self, other: &Self) {
        self.order = other.order;
    }

    /// Keeps the first `size` values; forgets all where there are fewer. Whether there were as many.
    pub fn resize(&mut self, size: usize) -> bool {
        let same = self.history.iter().all(|(_, values)| values.len() == size);
        self.history.retain(|(_, values)| values.len() >= size);
        self.history.iter_mut().for_each(|(_, values)| values.truncate(size));
        same
    }

    /// Takes the accepted values at the end of a step of `length` (s).
    pub fn accept(&mut self, length: f64, values: &[f64]) {
        // The curvature needs three, for every order.
        self.history.truncate(Self::HIGHEST_ORDER);
        self.history.push_front((length, values.to_vec()));
    }

    /// Writes the values extrapolated by `ahead` (s, positive); zero without a history.
    pub fn predict(&self, ahead: f64, values: &mut [f64]) {
        values.fill(0.0);
        let used = self.history.len().min(self.order + 1);
        let mut back = 0.0;
        // Distances of the values from the requested point, in units of `ahead`: 1, 2, 3 for equal steps.
        let distances: Vec<f64> = std::iter::once(1.0)
            .chain(self.history.iter().map(|(length, _)| {
                back += length / ahead;
                1.0 + back
            }))
            .take(used)
            .collect();
        for (i, (_, past)) in self.history.iter().take(used).enumerate() {
            let others = distances.iter().enumerate().filter(|(j, _)| *j != i);
            let weight: f64 = others.map(|(_, d)| d / (d - distances[i])).product();
            for (value, p) in values.iter_mut().zip(past) {
                *value += weight * p;
            }
        }
    }

    /// Largest error of the linear interpolation over a step of `length` (s) to `values`, to leading order: `H²/8
    /// |p″|`, 2-norm, with p″ from the last three values; `None` with fewer. `values` may already be the newest
    /// accepted ones.
    pub fn interpolation_error(&self, length: f64, values: &[f64]) -> Option<f64> {
        let ((before, p), (_, q)) = self.history.front().zip(self.history.get(1))?;
        let curvature = |((new, old), older): ((&f64, &f64), &f64)| {
            2.0 * ((new - old) / length - (old - older) / before) / (length + before)
        };
        let curvatures = values.iter().zip(p).zip(q).map(curvature);
        Some(length * length / 8.0 * crate::convergence::norm(curvatures))
    }
}

#[cfg(test)]
mod tests {
    use super::Predictor;

    #[test]
    fn polynomials_up_to_the_order_are_met_exactly_by_steps_of_any_length() {
        for (order, lengths) in
            [[1.0; 6], [1.0, 0.5, 2.0, 0.25, 1.0, 4.0]].iter().flat_map(|l| (0..=2).map(move |o| (o, l)))
        {
            let polynomial =
                |t: f64| 3.0 + if order > 0 { 2.0 * t } else { 0.0 } + if order > 1 { t * t } else { 0.0 };
            let mut predictor = Predictor::new(order);
            let mut guess = [1.0];
            predictor.predict(1.0, &mut guess);
            assert_eq!(guess, [0.0]);
            let mut time = 0.0;
            predictor.accept(0.0, &[polynomial(time)]);
            for (step, length) in lengths.iter().enumerate() {
                if step >= order {
                    for ahead in [*length, 3.0 * length] {
                        predictor.predict(ahead, &mut guess);
                        let exact = polynomial(time + ahead);
                        assert!((guess[0] - exact).abs() < 1e-12 * exact, "order {order}, step {step}");
                    }
                }
                time += length;
                predictor.accept(*length, &[polynomial(time)]);
            }
        }
    }

    #[test]
    fn the_interpolation_error_of_a_parabola_is_exact() {
        let mut predictor = Predictor::new(0);
        assert_eq!(predictor.interpolation_error(1.0, &[0.0]), None);
        // p = t² at 0, 0.5 and 2.5: between the last two the chord misses (2/2)² = 1 at most.
        predictor.accept(0.0, &[0.0]);
        predictor.accept(0.5, &[0.25]);
        let missed = predictor.interpolation_error(2.0, &[6.25]);
        assert!(missed.is_some_and(|e| (e - 1.0).abs() < 1e-14), "{missed:?}");
    }
}
