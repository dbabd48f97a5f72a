//! Mass damping that lets blocks slide and rock freely.
//!
//! `C = α M` is a drag against the ground. It damps the vibration of a dam whose cracks are closed, and would also slow
//! down a block that slides or rocks, which no material does. Mass damping therefore acts on the motion without the
//! rigid motion R j that the jumps of the cracks give to what lies above them ([`Parting`]):
//!
//! ```text
//! C = α Pᵀ M P,   P v = v − R j,   j = J v
//! −C v = −α M v + q,   q = α (M R j + Jᵀ Rᵀ M P v)
//! ```
//!
//! C is symmetric and positive semidefinite in every state of the contacts: it never gives energy. With closed cracks
//! j = 0 and C = α M. A block that slides or rocks without deformation feels nothing: P v = 0.
//!
//! **Source**: the error of C = α M, J.F. Hall, *Problems encountered from the use (or misuse) of Rayleigh damping*,
//! Earthquake Engineering and Structural Dynamics 35 (2006), who bounds stiffness damping and omits mass damping instead;
//! tested in `structure.rs` and `tests/sliding_damping.rs`.

use crate::contact::Parting;

/// The force q that releases blocks from mass damping.
#[derive(Debug, Default)]
pub(crate) struct Release {
    /// How the sides of each crack part; none if mass damping also drags blocks.
    pub partings: Vec<Parting>,
    /// Rigid motion of each block above a crack, from all cracks below it.
    pub rates: Vec<[f64; 3]>,
}

impl Release {
    /// For this number of `cracks` and evaluations that are a `time_step` (s) apart; none if there is no mass damping, or if it drags blocks.
    pub fn of_cracks(cracks: usize, time_step: f64) -> Self {
        Self { partings: vec![Parting::every(time_step); cracks], rates: vec![[0.0; 3]; cracks] }
    }

    /// Computes the rigid motions; returns whether a crack parts.
    pub fn find_rates(&mut self) -> bool {
        let mut sum = [0.0; 3];
        for (parting, rate) in self.partings.iter().zip(&mut self.rates) {
            sum = plus(sum, parting.rate());
            *rate = sum;
        }
        !self.partings.iter().all(Parting::is_closed)
    }
}

pub(crate) fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
