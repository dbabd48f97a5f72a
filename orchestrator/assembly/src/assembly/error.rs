use cofferdam_coupling::participant::ParticipantError;
use cofferdam_coupling::scheme::CouplingError;
use cofferdam_dam::DamError;
use cofferdam_reservoir::ReservoirError;
use cofferdam_scene::mesh_file::MeshFileError;
use cofferdam_unit::WetFaceError;

/// Most time steps of the dam in a communication step: beyond, no run would end.
pub(super) const MOST_TIME_STEPS: usize = 20_000;

/// A unit that cannot be made from a scene.
#[derive(Debug, thiserror::Error)]
pub enum AssemblyError {
    /// The scene has no such unit.
    #[error(
        "the scene has no unit number {number}; the dam is number 0, the reservoir number 1, and the tailwater number 2 where there \
         is a [tailwater]"
    )]
    NoUnit {
        /// Number asked for.
        number: usize,
    },
    /// The scene has no dam that this program computes.
    #[error(
        "the scene has no dam that this program computes; give it a [dam] with a `fidelity` other than \"fmu\", \"command\" and \"log\""
    )]
    NoDam,
    /// The dam.
    #[error(transparent)]
    Dam(#[from] DamError),
    /// The reservoir.
    #[error(transparent)]
    Reservoir(#[from] ReservoirError),
    /// The tailwater.
    #[error("tailwater: {0}")]
    Tailwater(#[source] ReservoirError),
    /// The dam's time step is next to nothing.
    #[error(
        "the dam needs {time_steps} time steps of {limit:e} s in a communication step (limit {MOST_TIME_STEPS}); \
         lower the joint stiffness or the damping, or use larger elements"
    )]
    TimeSteps {
        /// Time steps per communication step.
        time_steps: usize,
        /// Longest stable time step, s.
        limit: f64,
    },
    /// The prescribed dam, or the empty reservoir.
    #[error(transparent)]
    Face(#[from] cofferdam_unit::StateError),
    /// The units cannot be connected.
    #[error(transparent)]
    Graph(#[from] CouplingError),
    /// There is no water to compute.
    #[error("the reservoir is empty: `reservoir.fidelity` is \"none\"; choose another fidelity")]
    Empty,
    /// The water is another program's.
    #[error(
        "`reservoir.fidelity` is {fidelity:?}: this program does not compute that water; choose another fidelity"
    )]
    Foreign {
        /// The word in the scene.
        fidelity: String,
    },
    /// A unit that is a process, where there is none for it.
    #[error(
        "{unit}: it is a process of its own (`{unit}.command`), which this command does not start; use `cofferdam run`"
    )]
    Process {
        /// Name of the unit.
        unit: &'static str,
    },
    /// A unit of another program.
    #[error(transparent)]
    Participant(#[from] ParticipantError),
    /// The mesh of the dam.
    #[error(transparent)]
    Mesh(#[from] MeshFileError),
    /// The wet face.
    #[error(transparent)]
    WetFace(#[from] WetFaceError),
}
