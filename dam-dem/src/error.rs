use cofferdam_unit::number::exact;
use cofferdam_unit::{CallError, StateError, WetFaceError};

use crate::uplift::UpliftError;
use crate::{GeometryError, GivenMeshError};

/// What can go wrong in the dam.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DamError {
    /// A parameter outside its range.
    #[error("`{parameter}` is {value}; it must be {requirement}",
        value = exact(*value)
    )]
    OutOfRange {
        /// Name of the parameter.
        parameter: &'static str,
        /// Value given.
        value: f64,
        /// What the parameter must be.
        requirement: &'static str,
    },
    /// A section, or cracks in it, that cannot be meshed.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A mesh from elsewhere that cannot be taken.
    #[error(transparent)]
    GivenMesh(#[from] GivenMeshError),
    /// Elements larger than the dam.
    #[error(
        "`element_size` is {size} m, more than the dam's height of {crest} m; take a twentieth of that or less",
        size = exact(*size), crest = exact(*crest)
    )]
    ElementTooLarge {
        /// Nominal length of an element's side, m.
        size: f64,
        /// Elevation of the crest, m.
        crest: f64,
    },
    /// More elements than can be computed.
    #[error("`element_size` leads to {elements:.3e} elements of the dam (limit 1e6); increase it")]
    TooManyElements {
        /// Number of elements.
        elements: f64,
    },
    /// Two elevations at which rows of elements must end lie too close together.
    #[error(
        "vertices, cracks and water level at {lower} m and {upper} m are less than {least} m apart, a tenth of an \
         element; make them equal, move one, or use smaller elements",
        lower = exact(*lower), upper = exact(*upper), least = exact(*least)
    )]
    ThinRow {
        /// Lower elevation, m.
        lower: f64,
        /// Upper elevation, m.
        upper: f64,
        /// Least distance, m.
        least: f64,
    },
    /// A crack at or beyond the base or the crest.
    #[error(
        "a crack at {elevation} m lies outside the section; it must be between the base and the crest at {crest} m",
        elevation = exact(*elevation), crest = exact(*crest)
    )]
    CrackOutside {
        /// Elevation of the crack, m.
        elevation: f64,
        /// Elevation of the crest, m.
        crest: f64,
    },
    /// Two cracks at the same elevation.
    #[error("a crack lies at {elevation} m, where another one is, at {other} m; leave one of them out",
        elevation = exact(*elevation), other = exact(*other)
    )]
    DuplicateCrack {
        /// Elevation, m.
        elevation: f64,
        /// Elevation of the other crack, m.
        other: f64,
    },
    /// The water stands above the crest or below the base.
    #[error("the water is {depth} m deep; its depth must be between 0 (empty) and the crest at {crest} m",
        depth = exact(*depth), crest = exact(*crest)
    )]
    WaterDepth {
        /// Depth given, m.
        depth: f64,
        /// Elevation of the crest, m.
        crest: f64,
    },
    /// No node of the face lies at the water's level.
    #[error(
        "the water is {depth} m deep, and the mesh's face has no point there, only at {reached} m: a vertex, or the end of a crack or a \
         zone, lies too close to its level; move them apart or together, or take a smaller `element_size`",
        depth = exact(*depth), reached = exact(*reached)
    )]
    NoPointAtLevel {
        /// Depth given, m.
        depth: f64,
        /// Elevation of the highest point below it, m.
        reached: f64,
    },
    /// The added mass belongs to another wet face.
    #[error(
        "the added mass has a side of {found} values, the wet face has {points} interface points; make it from the \
         reservoir before the same dam, and leave `added_mass` out with an empty reservoir"
    )]
    AddedMassShape {
        /// Number of rows, or of values in a row.
        found: usize,
        /// Number of interface points; 0 with an empty reservoir.
        points: usize,
    },
    /// The added mass takes too much of the concrete's mass away.
    #[error(
        "the added mass is negative, {share:.3} of the concrete's mass in some motion of the wet face, and the limit is {most}; \
         check its sign (pressure −A a), or use a mesh whose elements at the water level are not so small"
    )]
    AddedMassNegative {
        /// Largest share of the concrete's mass.
        share: f64,
        /// Largest share allowed.
        most: f64,
    },
    /// A static load acts on a point that is not of the dam.
    #[error(
        "a point of the static load \"{load}\" lies outside the dam; give a point of the section, not in a gallery"
    )]
    PointOutside {
        /// The load's word.
        load: &'static str,
    },
    /// An invalid description of uplift.
    #[error("`uplift` of the crack at {elevation} m: {error}", elevation = exact(*elevation))]
    Uplift {
        /// Mean elevation of the crack, m.
        elevation: f64,
        /// What is wrong with it.
        error: UpliftError,
    },
    /// The water in a joint opens it until nothing holds.
    #[error(
        "uplift opens the joint at {elevation} m before the earthquake: once it is open over {percent:.0} % of its length, nothing \
         balances the loads; lower the water, add drains, or set `uplift = \"none\"` if no water enters it",
        elevation = exact(*elevation), percent = 100.0 * share
    )]
    UpliftOpens {
        /// Mean elevation of the crack, m.
        elevation: f64,
        /// Share of its length that is open.
        share: f64,
    },
    /// Rigid blocks without a crack between them.
    #[error(
        "rigid blocks need a crack that frees a block: without one the whole dam moves with the ground; give a crack, or choose another \
         fidelity"
    )]
    RigidWithoutCrack,
    /// Local damping below the full model.
    #[error(
        "local damping acts on nodes, and modes have none; choose another damping, or the fidelity \"dem\""
    )]
    LocalDampingOfModes,
    /// More natural frequencies were asked for than the mesh has.
    #[error(
        "{asked} natural frequencies were asked for, the mesh has {available}; refine it or ask for fewer"
    )]
    TooManyFrequencies {
        /// Number asked for.
        asked: usize,
        /// Number of free degrees of freedom.
        available: usize,
    },
    /// The stiffness matrix could not be factored.
    #[error("the stiffness of the intact dam is not positive definite; its section or mesh is degenerate")]
    Singular,
    /// The natural frequencies, or the highest frequency, did not converge.
    #[error(
        "frequencies of the dam: relative change {change:e} after {iterations} iterations, {tolerance:e} is asked for; ask for fewer frequencies, or look for elements and joints of very different size or stiffness"
    )]
    FrequenciesNotConverged {
        /// Iterations made.
        iterations: usize,
        /// Relative change in the last iteration.
        change: f64,
        /// Relative change asked for.
        tolerance: f64,
    },
    /// The state of rest before time 0 was not found.
    #[error(
        "static start: relative residual {residual:.1e} after {iterations} iterations, tolerance {tolerance:e}; the cracked dam may not stand under weight and water, or it is too soft: check friction, water depth, Young's modulus and the joints' stiffness (1e11 Pa/m is usual)"
    )]
    StaticNotConverged {
        /// Iterations made.
        iterations: usize,
        /// Norm of the residual forces over that of the loads.
        residual: f64,
        /// Residual asked for.
        tolerance: f64,
    },
    /// No state of rest exists.
    #[error(
        "the dam above the crack at {elevation} m would {way} under weight and water before the ground moves: its factor of safety is \
         {factor:.3}; raise friction, cohesion or tensile strength of the crack, or lower the water",
        elevation = exact(*elevation)
    )]
    CannotStand {
        /// Elevation of the crack, m.
        elevation: f64,
        /// `slide` or `overturn`.
        way: &'static str,
        /// Factor of safety, below 1.
        factor: f64,
    },
    /// A displacement or velocity is NaN or infinite.
    #[error(
        "the motion of {part} is not finite at t = {time} s; look for pressures or ground motion out of all bounds, or reduce `time_step_safety`"
    )]
    NonFinite {
        /// The node and its block, from the base up, or the mode.
        part: String,
        /// Time at the end of the communication step, s.
        time: f64,
    },
    /// The wet face cannot be made.
    #[error(transparent)]
    WetFace(#[from] WetFaceError),
    /// A call that breaks the contract.
    #[error(transparent)]
    Call(#[from] CallError),
    /// A state that cannot be read.
    #[error(transparent)]
    State(#[from] StateError),
    /// The operating system refused the threads asked for.
    #[error("the threads asked for could not be started ({0}); ask for fewer")]
    Threads(String),
}

impl DamError {
    /// The parameter that is out of range, if that is the error.
    pub(crate) fn parameter(&self) -> Option<&'static str> {
        if let Self::OutOfRange { parameter, .. } = self { Some(parameter) } else { None }
    }
}

impl From<rayon::ThreadPoolBuildError> for DamError {
    fn from(error: rayon::ThreadPoolBuildError) -> Self {
        Self::Threads(error.to_string())
    }
}

/// Something that is wrong with parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Paths of the parameters that it rests on, such as `cracks.0.elevation`; the first is the one to change.
    pub keys: Vec<String>,
    /// What is wrong.
    pub error: DamError,
}

impl Problem {
    pub(crate) fn of<const N: usize>(keys: [&str; N], error: DamError) -> Self {
        Self { keys: keys.map(str::to_owned).to_vec(), error }
    }
}

/// Refuses a `value` that is not finite or does not fulfil `holds`.
pub(crate) fn require(
    holds: bool,
    parameter: &'static str,
    value: f64,
    requirement: &'static str,
) -> Result<(), DamError> {
    if holds && value.is_finite() {
        Ok(())
    } else {
        Err(DamError::OutOfRange { parameter, value, requirement })
    }
}
