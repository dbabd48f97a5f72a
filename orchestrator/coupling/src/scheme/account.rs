//! What passes through an interface, accounted for step by step.

use super::{Exchange, Interval};
use crate::signal::Signal;
use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// Work at an interface in a window of communication steps, J; per metre where the units are plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InterfaceWork {
    /// Work on the first unit by what it was given.
    pub on_first: f64,
    /// Work of the second unit by what it answered. The difference of the two is energy that the coupling produced, or lost
    /// if negative.
    pub by_second: f64,
}

impl InterfaceWork {
    /// Energy produced at the interface, J.
    pub fn produced(&self) -> f64 {
        self.on_first - self.by_second
    }
}

impl AddAssign for InterfaceWork {
    fn add_assign(&mut self, other: Self) {
        self.on_first += other.on_first;
        self.by_second += other.by_second;
    }
}

/// The exchanges with both units of an interface at the end of a step.
#[derive(Clone, Copy, Debug)]
pub struct Crossing<'a> {
    /// With the first unit.
    pub first: &'a Exchange,
    /// With the second unit.
    pub second: &'a Exchange,
    /// What the first unit was given of the backward fields; in a one-way scheme, which gives it nothing, what the second
    /// answered, at the first unit's points.
    pub given: &'a [f64],
    /// The external signals.
    pub signals: &'a [Signal],
}

/// Accounts for the work at an interface. Only who knows what the fields are can do that; the coupling calls it.
///
/// **Call order**: [`begin`](Self::begin) after initialisation, [`step`](Self::step) after every accepted step.
/// [`state`](Self::state) may be taken between steps, and [`resume`](Self::resume) of an equal account continues from there.
pub trait Account: Send + Sync {
    /// Begins at the end of initialisation.
    fn begin(&mut self, now: Crossing<'_>);

    /// The work of the step `interval`, which ends `now`.
    fn step(&mut self, interval: &Interval, now: Crossing<'_>) -> InterfaceWork;

    /// Its state as bytes.
    fn state(&self) -> Vec<u8>;

    /// Continues from the `state` of an equal account; whether the bytes are such a state.
    fn resume(&mut self, state: &[u8]) -> bool;
}

/// An interface at the end of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfaceReport {
    /// Work in the step; `None` without an [`Account`].
    pub work: Option<InterfaceWork>,
    /// Lowest value of the backward fields with their constant parts, at the first unit's points.
    pub lowest: f64,
    /// Relative difference of the work between the two units because of the mapping:
    /// [`Mapping::work_error`](crate::mapping::Mapping::work_error).
    pub mapping_error: f64,
}
