//! `[coupling]`: how the units are coupled.

use cofferdam_coupling::acceleration::{AccelerationKind, REUSED_STEPS};
use cofferdam_coupling::convergence::{Measure, Tolerance};
use cofferdam_coupling::scheme::SchemeKind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the units are coupled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CouplingScene {
    /// Coupling scheme.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend(
        "otherwise" = "`\"added-mass\"` for a computed dam in water without memory, else `\"serial-implicit\"`"
    ))]
    pub scheme: Option<SchemeKind>,
    /// Number of communication steps that are iterated together, as one; implicit schemes only.
    #[schemars(range(min = 1, max = 10_000))]
    pub window: usize,
    /// Tolerance ε of the iteration: a number, relative to the current pressure, or `"balanced"`.
    pub tolerance: Tolerance,
    /// Measures that must all be below ε.
    pub measures: Vec<Measure>,
    /// Maximum number of iterations of a step for each acceleration that is tried. Iterations that measure and check the
    /// units (a Jacobian, the rounding floor, restored states) do not count.
    #[schemars(range(min = 2, max = 100_000))]
    pub iteration_limit: u32,
    /// What is done when the iterations run out, or no longer reduce the residual.
    pub on_failure: OnFailure,
    /// Acceleration of the iteration. If a quasi-Newton acceleration does not converge in a step, its history is cleared;
    /// then IQN-ILS without history and Aitken's relaxation are tried for this step. Summary and log report it.
    pub acceleration: AccelerationKind,
    /// Number of past communication steps whose iterations the quasi-Newton accelerations reuse; 0 for the current step alone.
    #[schemars(range(min = 0, max = 1000))]
    pub reused_steps: u64,
    /// Relaxation factor: the constant one, or the first one (Aitken, IQN-ILS without a past).
    #[schemars(range(min = 1e-6, max = 1.5))]
    pub relaxation: f64,
    /// Order of the extrapolation that makes the first guess of a step.
    #[schemars(range(min = 0, max = 2))]
    pub predictor_order: usize,
}

impl Default for CouplingScene {
    fn default() -> Self {
        Self {
            scheme: None,
            window: 1,
            tolerance: Tolerance::Balanced,
            measures: vec![Measure::Relative],
            iteration_limit: 100,
            on_failure: OnFailure::Stop,
            acceleration: AccelerationKind::InterfaceJacobian,
            reused_steps: REUSED_STEPS,
            relaxation: 0.9,
            predictor_order: 2,
        }
    }
}

/// What is done when a communication step does not converge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OnFailure {
    /// The run stops, with exit status 3.
    Stop,
    /// The run continues from the last iteration, and summary, histories and log say so; never from a divergence.
    Continue,
    /// The step is started again with half its length, up to ten times or down to `time.adaptive.shortest`: for water without
    /// memory or water by recursion, and implicit schemes.
    Halve,
}
