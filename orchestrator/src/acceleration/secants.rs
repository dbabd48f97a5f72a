use super::filtered_qr::FilteredQr;
use crate::convergence::norm;
use std::collections::VecDeque;

/// Model of a residual r(x) from the iterations of this and of past communication steps.
///
/// Differences Δx and Δr between consecutive iterations of a step, newest first. A Δr that depends on newer ones is
/// left out of the model.
#[derive(Clone, Debug)]
pub struct Secants {
    /// Number of past communication steps whose differences are used.
    reused_steps: u64,
    /// Least independent part of a Δr, as a share of its norm.
    filter: f64,
    step: u64,
    /// Norm of the step's first residual.
    first: f64,
    previous: Option<Iterate>,
    /// Newest first.
    differences: VecDeque<Difference>,
    /// Differences that the last projection used.
    used: usize,
}

/// Differences smaller than this share of a step's first residual are dominated by rounding and are not used.
const NOISE: f64 = 1e-6;

#[derive(Clone, Debug)]
struct Iterate {
    guess: Vec<f64>,
    residual: Vec<f64>,
}

#[derive(Clone, Debug)]
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
        let differences = VecDeque::new();
        Self { reused_steps, filter, step: 0, first: 0.0, previous: None, differences, used: 0 }
    }

    /// Number of differences that the last projection used.
    pub fn used(&self) -> usize {
        self.used
    }

    /// Begins a communication step; no differences are formed between iterations of different steps.
    pub fn begin_step(&mut self) {
        self.previous = None;
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
            if finite && norm(residual.iter().copied()) > NOISE * self.first {
                self.differences.push_front(Difference { step: self.step, guess, residual });
            }
            // This number is enough, even if most are filtered out.
            self.differences.truncate(4 * previous.guess.len());
        } else {
            self.first = norm(residual.iter().copied());
        }
        self.previous = Some(Iterate { guess: guess.to_vec(), residual: residual.to_vec() });
    }

    /// Expresses `residual` by the differences; none are used if the result would not be finite.
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
        let (mut change, mut rest) = (vec![0.0; residual.len()], residual.to_vec());
        for (coefficient, difference) in qr.solve(residual).into_iter().zip(&kept) {
            change.iter_mut().zip(&difference.guess).for_each(|(x, d)| *x += coefficient * d);
            rest.iter_mut().zip(&difference.residual).for_each(|(x, d)| *x -= coefficient * d);
        }
        let finite = change.iter().chain(&rest).all(|x| x.is_finite());
        self.used = if finite { qr.len() } else { 0 };
        if finite {
            Projection { change, rest, columns: qr.len() }
        } else {
            Projection { change: vec![0.0; residual.len()], rest: residual.to_vec(), columns: 0 }
        }
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
}
