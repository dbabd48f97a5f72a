//! Coupling schemes: how the units take communication steps together.
//!
//! The units form a [`Graph`]. At each [`Interface`] a first unit maps what it receives to what goes forward, p ↦ a = F(p), and a
//! second unit maps that to what goes backward, a ↦ p = S(a); with more units, F stands for all first and S for all second
//! ones. Over a window of one or several communication steps:
//!
//! | scheme | an iteration | repeated until |
//! |---|---|---|
//! | serial explicit | the first unit with the predicted p, the second with its a | never |
//! | parallel explicit | both at once, with predicted p and a | never |
//! | serial implicit (Gauss–Seidel) | the first unit with the guessed p, the second with its a | p = S(F(p)) |
//! | parallel implicit (Jacobi) | both at once, with guessed p and a | p = S(a) and a = F(p) |
//! | one-way | the first unit, which includes the response of the second, then the second, for p | never |

mod account;
mod coupled;
mod error;
mod evaluation;
mod frozen;
mod graph;
mod iteration;
mod link;
mod predictor;

pub use account::{Account, Crossing, InterfaceReport, InterfaceWork};
pub use coupled::{Scheme, SchemeState, Settings};
pub use error::{CouplingError, StepFailure};
pub use graph::{Direction, Field, Graph, Interface, Port, UnitId};
pub use iteration::{IterationReport, Purpose, WorstPoint};
pub use link::{check_points, interface_points};
pub use predictor::Predictor;

use crate::acceleration::Correction;
use crate::convergence::Residuals;
use crate::participant::{Message, Occasion};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// The scheme that a scene chooses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SchemeKind {
    /// The first unit (a dam) with predicted values (the pressure), then the second (its reservoir); nothing is repeated.
    SerialExplicit,
    /// Both at once with predicted values; nothing is repeated.
    ParallelExplicit,
    /// Gauss–Seidel: the first unit, then the second, repeated until they agree.
    #[default]
    SerialImplicit,
    /// Jacobi: both at once, repeated until they agree.
    ParallelImplicit,
    /// The first unit includes the response of the second (the added mass of the water is in the dam's mass matrix), which
    /// only reports its answer (the pressure).
    #[serde(rename = "added-mass")]
    OneWay,
}

impl SchemeKind {
    /// Whether steps are repeated until the units agree.
    pub fn is_implicit(self) -> bool {
        matches!(self, Self::SerialImplicit | Self::ParallelImplicit)
    }

    /// Whether both units step at the same time.
    pub fn is_parallel(self) -> bool {
        matches!(self, Self::ParallelExplicit | Self::ParallelImplicit)
    }
}

/// One communication step: from `time` on, for `communication_step`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Number of the step, from 1; 0 is initialisation.
    pub step: u64,
    /// Start of the step, s.
    pub time: f64,
    /// Length of the step, s; 0 at initialisation.
    pub communication_step: f64,
    /// When external signals are evaluated, s: the end of the step. Of equal steps it is the multiple of their length, from
    /// which the sum of start and length may differ by rounding.
    pub signal_time: f64,
}

impl Interval {
    /// Step number `step` from `time` on, of this length (s).
    pub fn new(step: u64, time: f64, communication_step: f64) -> Self {
        Self { step, time, communication_step, signal_time: time + communication_step }
    }

    /// End of the step, s.
    pub fn end(&self) -> f64 {
        self.time + self.communication_step
    }
}

/// One request and its answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Exchange {
    /// Unit that was called.
    pub unit: UnitId,
    /// The step that it was to take.
    pub occasion: Occasion,
    /// Whether the run continued with these values.
    pub accepted: bool,
    /// The request, in the order of the unit's input layout.
    pub inputs: Vec<f64>,
    /// The answer, in the order of the unit's output layout; empty if the unit failed and gave none.
    pub outputs: Vec<f64>,
    /// When the request was sent, from the start of the run.
    pub sent: Duration,
    /// When the answer arrived, from the start of the run.
    pub answered: Duration,
}

/// Report of a window of communication steps; usually a window is one step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WindowReport {
    /// The steps; step 0 is initialisation.
    pub steps: Vec<Interval>,
    /// Number of the attempt, from 1; each attempt has other steps.
    pub attempt: u32,
    /// Every exchange, in order.
    pub exchanges: Vec<Exchange>,
    /// Whether the units agree to the tolerance, or no agreement was required. A window can be accepted without
    /// convergence.
    pub converged: bool,
    /// What every iteration did; empty at initialisation.
    pub iterates: Vec<IterationReport>,
    /// Why no further iteration followed, in a few words: `converged`, or an error.
    pub outcome: String,
    /// Accelerations that were given up in this window, because they brought no convergence.
    pub fallbacks: u32,
    /// Largest error of the linear interpolation of the backward fields within the step (2-norm): an estimate of the
    /// coupling error that does not depend on the tolerance. `None` in the first steps and for windows of several.
    pub interpolation_error: Option<f64>,
    /// Largest norm of the backward fields in the run before this window and, if the window is a single step, in this step.
    pub largest: f64,
    /// All interfaces at the end of each step, once accepted.
    pub interfaces: Vec<Vec<InterfaceReport>>,
    /// Change of the residual when values change by rounding; `None` until it is measured.
    pub rounding_floor: Option<f64>,
    /// Time spent in each unit, including saving and restoring states.
    pub solver_time: Vec<Duration>,
    /// Time in which a unit was computing: the sum of all, or the longest where all compute at once.
    pub unit_time: Duration,
    /// Messages of the units.
    pub messages: Vec<Message>,
}

impl WindowReport {
    /// Number of the first step; 0 is initialisation.
    pub fn step(&self) -> u64 {
        self.steps.first().map_or(0, |interval| interval.step)
    }

    /// Start of the window, s.
    pub fn time(&self) -> f64 {
        self.steps.first().map_or(0.0, |interval| interval.time)
    }

    /// End of the window, s.
    pub fn end(&self) -> f64 {
        self.steps.last().map_or(0.0, Interval::end)
    }

    /// Number of iterations, including the confirming one.
    pub fn iterations(&self) -> u32 {
        self.exchanges.last().map_or(0, |e| e.occasion.iteration)
    }

    /// Residuals of the last iteration that compared anything.
    pub fn residuals(&self) -> Option<Residuals> {
        self.iterates.iter().rev().find_map(|iterate| iterate.residuals)
    }

    /// How the last guess towards the solution came about.
    pub fn correction(&self) -> Option<Correction> {
        self.iterates.iter().rev().find(|i| i.purpose == Purpose::Solution).map(|i| i.correction)
    }

    /// The interpolation error over the largest norm of the run so far.
    pub fn relative_interpolation_error(&self) -> Option<f64> {
        self.interpolation_error.filter(|_| self.largest > 0.0).map(|error| error / self.largest)
    }

    /// Whether the run continued with it.
    pub fn is_accepted(&self) -> bool {
        self.exchanges.iter().any(|e| e.accepted)
    }

    /// The accepted exchange with `unit` in step number `step`.
    pub fn accepted(&self, unit: UnitId, step: u64) -> Option<&Exchange> {
        self.exchanges.iter().rev().find(|e| e.unit == unit && e.accepted && e.occasion.step == step)
    }

    /// Work at all interfaces in step `index` of the window; `None` if it is unknown at one.
    pub fn work(&self, index: usize) -> Option<InterfaceWork> {
        let mut sum = InterfaceWork::default();
        for interface in self.interfaces.get(index)? {
            sum += interface.work?;
        }
        Some(sum)
    }

    /// Lowest value of the backward fields with their constant parts, at all interfaces at the end of step `index` of the window.
    pub fn lowest(&self, index: usize) -> Option<f64> {
        let interfaces = self.interfaces.get(index)?;
        Some(interfaces.iter().fold(f64::INFINITY, |lowest, interface| lowest.min(interface.lowest)))
    }

    /// Number of steps that `unit` took, and of those that repeated a step.
    pub fn calls(&self, unit: UnitId) -> [u64; 2] {
        let calls = self.exchanges.iter().filter(|e| e.unit == unit && e.occasion.step > 0);
        let repeated = |e: &&Exchange| e.occasion.iteration > 1 || e.occasion.attempt > 1;
        [calls.clone().count() as u64, calls.filter(repeated).count() as u64]
    }
}
