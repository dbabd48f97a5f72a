use interface::{CallError, StateError};
use num_complex::Complex64;

/// What can go wrong in the reservoir.
#[derive(Debug, thiserror::Error)]
pub enum ReservoirError {
    /// A call that breaks the contract of co-simulation units.
    #[error(transparent)]
    Call(#[from] CallError),
    /// The wave reflection coefficient is outside [0, 1].
    #[error(
        "the wave reflection coefficient is {value}; it must lie between 0 (absorbing bed) and 1 (rigid bed)"
    )]
    WaveReflectionCoefficient {
        /// Value given.
        value: f64,
    },
    /// A quantity that must be positive and finite is not.
    #[error("`{parameter}` is {value} {unit}; it must be positive and finite")]
    NotPositive {
        /// Name of the parameter.
        parameter: &'static str,
        /// Value given.
        value: f64,
        /// SI unit.
        unit: &'static str,
    },
    /// The horizon is shorter than one communication step.
    #[error(
        "the horizon of {horizon} s is shorter than the communication step of {communication_step} s; \
         raise `horizon` to the length of the run"
    )]
    HorizonTooShort {
        /// Horizon, s.
        horizon: f64,
        /// Communication step, s.
        communication_step: f64,
    },
    /// More than can be computed.
    #[error("the reservoir would have {value:.3e} {what}, {most:.0e} are the most; {remedy}")]
    TooMuch {
        /// What there is too much of.
        what: &'static str,
        /// How many.
        value: f64,
        /// How many there may be.
        most: f64,
        /// What to change.
        remedy: &'static str,
    },
    /// Compressible water has no added mass.
    #[error(
        "compressible water has a memory, so no added mass gives its pressure; choose the fidelity `westergaard` or \
         `incompressible`"
    )]
    Memory,
    /// A step would end after the horizon that the weights were made for.
    #[error(
        "a step to t = {end} s, {elapsed} s after the start, passes the horizon of {horizon} s that the \
         convolution weights cover; raise `horizon` to the length of the run"
    )]
    BeyondHorizon {
        /// End of the step, s.
        end: f64,
        /// The same since the start, s.
        elapsed: f64,
        /// Horizon, s.
        horizon: f64,
    },
    /// The ground moves vertically.
    #[error(
        "the ground accelerates vertically at {acceleration} m/s²; the reservoir does not model a vertically \
         moving bed yet: leave `ground_acceleration`[1] at zero"
    )]
    VerticalGroundMotion {
        /// Vertical acceleration given, m/s².
        acceleration: f64,
    },
    /// A complex frequency outside the half plane where the symbol is defined.
    #[error(
        "the complex frequency {frequency} 1/s is not in the right half plane; give it a positive real part"
    )]
    Frequency {
        /// Frequency given, 1/s.
        frequency: Complex64,
    },
    /// The fundamental solution could not be evaluated.
    #[error(
        "the fundamental solution failed at s = {frequency} 1/s ({source}); check the units of the \
         communication step, the sound speed and the depth"
    )]
    Kernel {
        /// Complex frequency, 1/s.
        frequency: Complex64,
        /// Reason.
        source: complex_bessel::Error,
    },
    /// The far end's map has no square root within rounding.
    #[error("the far end's map could not be computed at s = {frequency} 1/s; change `element_size` slightly")]
    FarEnd {
        /// Complex frequency, 1/s.
        frequency: Complex64,
    },
    /// A calculated pressure is NaN or infinite.
    #[error(
        "the pressure at interface point {index} is {value} Pa at t = {time} s; look for a diverging input in \
         the log"
    )]
    NonFinitePressure {
        /// Index of the point, from 0.
        index: usize,
        /// Value, Pa.
        value: f64,
        /// End of the step, s.
        time: f64,
    },
    /// The operating system refused the threads asked for.
    #[error("the threads asked for could not be started ({0}); ask for fewer")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

impl From<StateError> for ReservoirError {
    fn from(error: StateError) -> Self {
        Self::Call(error.into())
    }
}
