use crate::BoundaryCondition;
use cofferdam_unit::number::exact;
use cofferdam_unit::{CallError, StateError};
use num_complex::Complex64;

/// What can go wrong in the reservoir.
#[derive(Debug, thiserror::Error)]
pub enum ReservoirError {
    /// A downstream face that is not given as its water sees it.
    #[error(
        "the wet face starts at x = {x} m: a tailwater counts x from the toe, which is 0; make its parameters by \
         `ReservoirParameters::before`"
    )]
    NotFromTheToe {
        /// x of the first point, m.
        x: f64,
    },
    /// A call that breaks the contract of co-simulation units.
    #[error(transparent)]
    Call(#[from] CallError),
    /// The wave reflection coefficient is outside [0, 1].
    #[error(
        "the wave reflection coefficient is {value}; it must be between 0 (absorbing bed) and 1 (rigid bed)"
    )]
    WaveReflectionCoefficient {
        /// Value given.
        value: f64,
    },
    /// A quantity that must be positive and finite is not.
    #[error("`{parameter}` is {} {unit}; it must be positive and finite", exact(*value))]
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
    #[error("the reservoir would have {value:.3e} {what} (limit {most:.0e}); {remedy}")]
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
    /// A step of another length in explicit coupling.
    #[error(
        "a communication step of {asked} s was requested, but for explicit coupling the water of one step of {own} s is in \
         the dam's mass; set the step of the importer to {own} s, or export again with another `time.communication_step`"
    )]
    ExplicitStep {
        /// Requested length, s.
        asked: f64,
        /// Length for which dam and water were made, s.
        own: f64,
    },
    /// A complex frequency outside the half plane where the symbol is defined.
    #[error(
        "the complex frequency {frequency} 1/s is 0, not finite or has a negative real part; real frequencies ω > 0 \
         are s = iω"
    )]
    Frequency {
        /// Frequency given, 1/s.
        frequency: Complex64,
    },
    /// A real frequency at which a mode of the channel over a rigid bed begins to propagate.
    #[error(
        "at s = {frequency} 1/s the response of a rigid bed is infinite: mode {mode} of the channel upstream begins to \
         propagate at {cut_off} rad/s; move the frequency by more than a millionth, or lower \
         `wave_reflection_coefficient` below 1"
    )]
    CutOff {
        /// Frequency given, 1/s.
        frequency: Complex64,
        /// Number of the mode, from 1.
        mode: u64,
        /// Its cut-off frequency, rad/s.
        cut_off: f64,
    },
    /// A corner of the bed that is not finite or not below the surface.
    #[error(
        "corner {corner} of `bed` is ({x}, {y}) m; it must be finite and lie below the water level of {level} m"
    )]
    BedCorner {
        /// Number of the corner, from 1 at the first upstream of the heel.
        corner: usize,
        /// x, m.
        x: f64,
        /// y, m.
        y: f64,
        /// Elevation of the water level, m.
        level: f64,
    },
    /// The bed crosses or touches itself or another part of the water's boundary.
    #[error(
        "the bed upstream of its corner {corner}, at ({x}, {y}) m, has next to no length, turns back on itself, or crosses or \
         touches the {other} from ({}, {}) to ({}, {}) m; move that corner (0 is the heel) or the next of `bed`",
        start[0], start[1], end[0], end[1]
    )]
    BedCrosses {
        /// Number of the corner where the piece of bed begins, 0 at the heel, counted upstream.
        corner: usize,
        /// x of that corner, m.
        x: f64,
        /// y of that corner, m.
        y: f64,
        /// What it meets.
        other: BoundaryCondition,
        /// One end of the piece that it meets, m.
        start: [f64; 2],
        /// Its other end, m.
        end: [f64; 2],
    },
    /// A model of the water, or a use of it, that gravity waves do not go with.
    #[error("{what} cannot have gravity waves; {remedy}")]
    GravityWaves {
        /// The model or use.
        what: &'static str,
        /// What to change.
        remedy: &'static str,
    },
    /// Westergaard's water has a pressure on the face only.
    #[error("Westergaard's parabola gives no pressure inside the water; choose another `fidelity`")]
    NoField,
    /// A field point outside the meshed water.
    #[error(
        "field point {index}, ({x}, {y}) m, is not inside the water between dam and far end (x > {far_end} m), off its \
         boundary; move it, or raise `far_end_distance`"
    )]
    FieldPoint {
        /// Index of the point, from 0.
        index: usize,
        /// x, m.
        x: f64,
        /// y, m.
        y: f64,
        /// x of the far end, m.
        far_end: f64,
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
    /// The boundary elements' response is NaN or infinite.
    #[error(
        "the response of the boundary elements at s = {frequency} 1/s is not finite; raise `corner_element_size`, or check \
         the units of the sound speed and the depth"
    )]
    NonFiniteResponse {
        /// Complex frequency, 1/s.
        frequency: Complex64,
    },
    /// No rational function could be found at all.
    #[error(
        "no rational function could be fitted to this water's frequency response; choose the method `radau2` or `radau3`, or \
         panels of the wet face that are more alike"
    )]
    NotFitted,
    /// No rational function was found that is close enough to the frequency response, and passive.
    #[error(
        "no recursion was found for this water: the best is {error:.1e} off its frequency response and needs a loss of \
         {loss:.1e} ρc to be passive; choose the method `radau2` or `radau3`, or a coarser wet face"
    )]
    Recursion {
        /// Relative error.
        error: f64,
        /// Loss over ρc.
        loss: f64,
    },
    /// The hat functions of the wet face's points cannot be told apart.
    #[error(
        "the mass matrix of the wet face's points is not positive definite; move the points of the face apart, or check \
         that they are finite"
    )]
    InterfaceMass,
    /// The stages' frequencies of a convolution quadrature were not found.
    #[error("the stages' frequencies were not found at ζ = {zeta}; choose the method `bdf2` or `trapezoid`")]
    Stages {
        /// Point on the contour.
        zeta: Complex64,
    },
    /// The frequency response is not smooth enough along the contour of a convolution quadrature.
    #[error(
        "the frequency response is interpolated within {error:.1e} of its largest value only, {tolerance:.0e} are needed; \
         change `element_size` or `far_end_distance` slightly, or choose the method `finite-elements`"
    )]
    NotInterpolated {
        /// Relative error.
        error: f64,
        /// Largest that is accepted.
        tolerance: f64,
    },
    /// A memory of water that is stepped by another method.
    #[error("the state holds no memory of this water's method; restore a state that this unit saved")]
    ForeignMemory,
    /// The water could not be divided into finite elements.
    #[error(
        "the water could not be divided into triangles without angles below 28°; raise `corner_element_size`, or \
         avoid corners much sharper than that"
    )]
    Mesh,
    /// The system of the finite elements could not be factored.
    #[error(
        "the finite elements' system could not be factored at a rate of {rate} 1/s; check the units of the \
         communication step, the sound speed and the depth"
    )]
    FiniteElementSystem {
        /// |s|, or 2/H for steps in time, 1/s.
        rate: f64,
    },
    /// A record of another number of motions than the water has.
    #[error(
        "the record has {rows} rows of {instants} instants; it needs {expected} rows, one an interface point and two for \
         the ground, of at least one instant"
    )]
    RecordShape {
        /// Rows given.
        rows: usize,
        /// Instants given.
        instants: usize,
        /// Rows needed.
        expected: usize,
    },
    /// A window of too few steps.
    #[error("a window has {steps} steps; it needs two or more")]
    WindowTooShort {
        /// Steps given.
        steps: usize,
    },
    /// A record that holds NaN or an infinite value.
    #[error("row {row} of the record is {value} m/s² at instant {instant}, both from 0; it must be finite")]
    NonFiniteRecord {
        /// Row, from 0.
        row: usize,
        /// Instant, from 0.
        instant: usize,
        /// Value, m/s².
        value: f64,
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
