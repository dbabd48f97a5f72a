use super::filtered_qr::FilteredQr;
use crate::convergence::norm;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Model of a residual r(x) from the iterations of this and of past communication steps.
///
/// Differences Δx and Δr between consecutive iterations of a step, newest first. A Δr that depends on newer ones is
/// left out of the model, and one that is rounding; the newest is never left out for being small beside older ones: near
/// a kink of the units' response it alone is right.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Secants {
    /// Number of past communication steps whose differences are used.
    reused_steps: u64,
    /// Least independent part of a Δr, as a share of its norm.
    filter: f64,
    /// Change of a residual by rounding.
    floor: f64,
    step: u64,
    /// Norm of the step's first residual.
    first: f64,
    previous: Option<Iterate>,
    /// Newest first.
    differences: VecDeque<Difference>,
    /// Of the last projection.
    counts: SecantCounts,
}

/// Differences of past iterations in a guess: what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SecantCounts {
    /// Those that were kept of this and of past steps.
    pub known: usize,
    /// Those of them that do not depend on newer ones.
    pub independent: usize,
    /// Those that the guess used: fewer where the oldest asked for far too large a correction.
    pub used: usize,
}

/// Differences smaller than this multiple of the rounding floor are dominated by rounding and are not used.
const FLOORS: f64 = 100.0;
/// Largest correction of the guess over the residual. Differences of steps in which contacts opened or slipped may
/// contradict each other; their least squares are then far too large.
const LARGEST: f64 = 100.0;
/// Differences smaller than this share of their step's first residual are not used in later steps: what they say of the
/// units' response is small beside its change from step to step.
const NOISE: f64 = 1e-6;

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Iterate {
    guess: Vec<f64>,
    residual: Vec<f64>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Difference {
    step: u64,
    guess: Vec<f64>,
    residual: Vec<f64>,
}

/// A residual in terms of the differences: `r = ΔR c + r⊥`, c by least squares.
#[derive(Clone, Debug, PartialEq)]
pub struct Projection {
    /// `ΔX c`: the correction of the guess for the part that the differences explain.
    pub change: Vec<f64>,
    /// r⊥: the part that they do not explain.
    pub rest: Vec<f64>,
    /// Number of differences that were used.
    pub columns: usize,
}

impl Secants {
    /// A model without differences.
    pub fn new(reused_steps: u64, filter: f64) -> Self {
        let (differences, counts) = (VecDeque::new(), SecantCounts::default());
        Self { reused_steps, filter, floor: 0.0, step: 0, first: 0.0, previous: None, differences, counts }
    }

    /// Sets the number of past communication steps whose differences are used.
    pub fn reuse(&mut self, steps: u64) {
        self.reused_steps = steps;
    }

    /// Takes the change of a residual by rounding.
    pub fn set_floor(&mut self, floor: f64) {
        self.floor = floor;
    }

    /// Forgets all differences, and the last iteration.
    pub fn forget(&mut self) {
        self.previous = None;
        self.differences.clear();
    }

    /// What became of the differences in the last projection.
    pub fn counts(&self) -> SecantCounts {
        self.counts
    }

    /// Begins a communication step; no differences are formed between iterations of different steps.
    pub fn begin_step(&mut self) {
        self.previous = None;
        self.counts = SecantCounts::default();
        let least = NOISE * self.first;
        while let Some(newest) = self.differences.front()
            && newest.step == self.step
            && norm(newest.residual.iter().copied()) <= least
        {
            self.differences.pop_front();
        }
        self.step += 1;
        let oldest = self.step.saturating_sub(self.reused_steps);
        while self.differences.back().is_some_and(|difference| difference.step < oldest) {
            self.differences.pop_back();
        }
    }

    /// Takes an iteration.
    pub fn observe(&mut self, guess: &[f64], residual: &[f64]) {
        let minus = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
        if let Some(previous) = &self.previous {
            let (guess, residual) = (minus(guess, &previous.guess), minus(residual, &previous.residual));
            let finite = guess.iter().chain(&residual).all(|x| x.is_finite());
            if finite && norm(residual.iter().copied()) > FLOORS * self.floor {
                self.differences.push_front(Difference { step: self.step, guess, residual });
            }
            // This number is enough, even if most are filtered out.
            self.differences.truncate(4 * previous.guess.len());
        } else {
            self.first = norm(residual.iter().copied());
        }
        self.previous = Some(Iterate { guess: guess.to_vec(), residual: residual.to_vec() });
    }

    /// Expresses `residual` by the differences. The oldest are left out while the correction of the guess is much larger
    /// than the residual, all of them if it is not finite.
    pub fn project(&mut self, residual: &[f64]) -> Projection {
        let mut qr = FilteredQr::default();
        let mut kept = Vec::new();
        for difference in &self.differences {
            if qr.len() == residual.len() {
                break;
            }
            if qr.insert(&difference.residual, self.filter) {
                kept.push(difference);
            }
        }
        let largest = LARGEST * norm(residual.iter().copied());
        self.counts = SecantCounts { known: self.differences.len(), independent: qr.len(), used: 0 };
        for columns in (1..=qr.len()).rev() {
            let (mut change, mut rest) = (vec![0.0; residual.len()], residual.to_vec());
            for (coefficient, difference) in qr.solve(residual, columns).into_iter().zip(&kept) {
                change.iter_mut().zip(&difference.guess).for_each(|(x, d)| *x += coefficient * d);
                rest.iter_mut().zip(&difference.residual).for_each(|(x, d)| *x -= coefficient * d);
            }
            let finite = change.iter().chain(&rest).all(|x| x.is_finite());
            if finite && (columns == 1 || norm(change.iter().copied()) <= largest) {
                self.counts.used = columns;
                return Projection { change, rest, columns };
            }
        }
        Projection { change: vec![0.0; residual.len()], rest: residual.to_vec(), columns: 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_residual_along_known_differences_is_explained_wholly() {
        let mut secants = Secants::new(3, 1e-6);
        secants.begin_step();
        for (guess, residual) in
            [([0.0, 0.0], [1.0, 2.0]), ([1.0, 0.0], [3.0, 2.0]), ([1.0, 1.0], [3.0, 6.0])]
        {
            secants.observe(&guess, &residual);
        }
        // r moves by 2 along the first unknown and by 4 along the second.
        let Projection { change, rest, columns } = secants.project(&[5.0, -2.0]);
        assert_eq!(columns, 2);
        assert!((change[0] - 2.5).abs() < 1e-14 && (change[1] + 0.5).abs() < 1e-14, "{change:?}");
        assert!(rest.iter().all(|x| x.abs() < 1e-14), "{rest:?}");
    }

    #[test]
    fn equal_iterates_and_infinite_ones_explain_nothing() {
        let mut secants = Secants::new(3, 1e-3);
        secants.begin_step();
        for residual in [[1.0, 0.0], [1.0, 0.0], [f64::INFINITY, 0.0]] {
            secants.observe(&[1.0, 1.0], &residual);
        }
        let projection = secants.project(&[1.0, 3.0]);
        assert_eq!(projection, Projection { change: vec![0.0; 2], rest: vec![1.0, 3.0], columns: 0 });
    }

    #[test]
    fn differences_of_old_steps_are_forgotten() {
        let mut secants = Secants::new(2, 1e-3);
        for step in 0..20 {
            secants.begin_step();
            for k in 0..3 {
                secants.observe(&[f64::from(k), 0.0, 0.0], &[f64::from(k + step), f64::from(k * k), 1.0]);
            }
            assert!(secants.differences.len() <= 6, "{}", secants.differences.len());
        }
    }
    #[test]
    fn old_differences_that_contradict_new_ones_are_left_out() {
        let mut secants = Secants::new(3, 1e-3);
        secants.begin_step();
        secants.observe(&[0.0, 0.0], &[0.0, 0.0]);
        secants.observe(&[1.0, 0.0], &[1.0, 0.0]);
        secants.begin_step();
        secants.observe(&[0.0, 0.0], &[0.0, 0.0]);
        secants.observe(&[0.0, 1.0], &[1.0, 2e-3]);
        let Projection { change, columns, .. } = secants.project(&[0.0, 1.0]);
        assert_eq!(columns, 1);
        assert!(norm(change.iter().copied()) < 1.0, "{change:?}");
    }

    /// Two linear pieces that meet: of the piece in which the iteration ends only the newest, small difference tells.
    #[test]
    fn the_newest_difference_is_used_however_small_it_is() {
        let mut secants = Secants::new(3, 1e-3);
        secants.set_floor(1e-12);
        secants.begin_step();
        secants.observe(&[0.0, 0.0], &[1e5, 0.0]);
        secants.observe(&[1.0, 0.0], &[10.0, 0.0]);
        secants.observe(&[1.0, 1e-3], &[10.0, 0.01]);
        let Projection { change, rest, columns } = secants.project(&[0.0, 0.01]);
        assert_eq!(columns, 2);
        assert!((change[1] - 1e-3).abs() < 1e-15 && rest[1].abs() < 1e-15, "{change:?}");
        secants.observe(&[1.0, 1e-3], &[10.0, 0.01 + 1e-11]);
        assert_eq!(secants.differences.len(), 2, "rounding explains nothing");
        secants.begin_step();
        assert_eq!(secants.differences.len(), 1, "the small difference served its own step");
        secants.forget();
        assert_eq!(secants.project(&[0.0, 0.01]).columns, 0);
    }
}
