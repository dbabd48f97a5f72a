//! The unknowns of a window: what they are, how they are guessed and moved, and what they give to the units.

use super::Scheme;
use crate::scheme::evaluation::Given;
use crate::scheme::{Direction, Exchange, Interval, SchemeKind};

impl Scheme {
    /// Number of values of a step that go backward.
    pub(super) fn backward_values(&self) -> usize {
        self.links.iter().map(|link| link.received()[0]).sum()
    }

    /// Number of unknowns of a step.
    pub(super) fn unknowns(&self) -> usize {
        let forward = self.links.iter().map(|link| link.received()[1]).sum();
        self.backward_values() + if self.settings.kind.is_parallel() { forward } else { 0 }
    }

    /// Which unknowns of a step are relaxed.
    pub(super) fn relaxed(&self) -> Vec<bool> {
        let of = |direction| self.links.iter().flat_map(move |link| link.relaxed(direction));
        let forward = of(Direction::Forward).take(self.unknowns() - self.backward_values());
        of(Direction::Backward).chain(forward).collect()
    }

    /// Moves the relaxed unknowns by the acceleration, and the others to their answer.
    pub(super) fn accelerate(&mut self, unknowns: &mut [f64], residual: &[f64]) {
        let Some(relaxed) = &self.relaxed else {
            return self.memory.acceleration.accelerate(unknowns, residual);
        };
        let picked = |values: &[f64]| -> Vec<f64> {
            let chosen = values.iter().zip(relaxed.iter().cycle()).filter(|(_, relaxed)| **relaxed);
            chosen.map(|(value, _)| *value).collect()
        };
        let (mut moved, of_moved) = (picked(unknowns), picked(residual));
        self.memory.acceleration.accelerate(&mut moved, &of_moved);
        let mut moved = moved.into_iter();
        for ((x, r), relaxed) in unknowns.iter_mut().zip(residual).zip(relaxed.iter().cycle()) {
            *x = if *relaxed { moved.next().unwrap_or(*x) } else { *x + r };
        }
    }

    /// The unknowns in the answers of all units.
    pub(super) fn unknowns_of(&self, answers: &[&Exchange]) -> Vec<f64> {
        let mut unknowns = self.backward(answers);
        if self.settings.kind.is_parallel() {
            for link in &self.links {
                let forward = link.forward(answers[link.first().0]);
                unknowns.extend(forward.iter().zip(link.weights()).map(|(a, weight)| weight * a));
            }
        }
        unknowns
    }

    /// The backward fields that the second units answered, at the first units' points.
    pub(super) fn backward(&self, answers: &[&Exchange]) -> Vec<f64> {
        self.links.iter().flat_map(|link| link.backward(answers[link.second().0])).collect()
    }

    /// The first guess of a window's unknowns.
    pub(super) fn guess(&self, steps: &[Interval]) -> Vec<f64> {
        let (size, start) = (self.unknowns(), steps.first().map_or(0.0, |interval| interval.time));
        let mut unknowns = vec![0.0; size * steps.len()];
        if self.settings.kind != SchemeKind::OneWay {
            for (interval, values) in steps.iter().zip(unknowns.chunks_mut(size)) {
                let ahead =
                    if interval.time == start { interval.communication_step } else { interval.end() - start };
                self.memory.predictor.predict(ahead, values);
            }
        }
        unknowns
    }

    /// What the unknowns x give to the units.
    pub(super) fn given(&self, unknowns: &[f64]) -> Given {
        let none = || vec![Vec::new(); self.links.len()];
        let (mut backward, mut forward) = (none(), none());
        for step in unknowns.chunks(self.unknowns()) {
            let mut rest = step;
            for (link, backward) in self.links.iter().zip(&mut backward) {
                let (of_link, others) = rest.split_at(link.received()[0]);
                backward.extend_from_slice(of_link);
                rest = others;
            }
            for (link, forward) in self.links.iter().zip(&mut forward) {
                // A serial scheme has no more unknowns.
                let (of_link, others) = rest.split_at(link.received()[1].min(rest.len()));
                forward.extend(of_link.iter().zip(link.weights()).map(|(a, weight)| a / weight));
                rest = others;
            }
        }
        Given { backward, forward }
    }
}
