use crate::AssemblyError;
use cofferdam_coupling::run_state::RunStateError;
use cofferdam_coupling::scheme::CouplingError;
use cofferdam_coupling::simulation::SimulationError;
use cofferdam_dam::DamError;
use cofferdam_reservoir::ReservoirError;
use cofferdam_unit::{CallError, StateError};

/// A coupled unit that cannot be made, or a step that failed.
#[derive(Debug, thiserror::Error)]
pub enum CoupledError {
    /// A call that breaks the contract.
    #[error(transparent)]
    Call(#[from] CallError),
    /// The dam.
    #[error(transparent)]
    Dam(#[from] DamError),
    /// A water.
    #[error("the water: {0}")]
    Reservoir(#[from] ReservoirError),
    /// The units.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The coupling.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A state.
    #[error(transparent)]
    State(#[from] RunStateError),
    /// A scene whose units or steps cannot be those of one unit.
    #[error("the scene cannot be one coupled unit: {0}")]
    Unfit(&'static str),
    /// A value of a parameter.
    #[error("`{name}` is {value}; {remedy}")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        remedy: &'static str,
    },
    /// The coupling, in a run that does not begin at time 0.
    #[error("{cause}{}", counted_from(*start_time))]
    Later {
        /// What failed.
        cause: SimulationError,
        /// The importer's time at the start of the run, s.
        start_time: f64,
    },
    /// The state could not be saved.
    #[error("the state could not be saved: {0}")]
    NotSaved(String),
}

impl From<StateError> for CoupledError {
    fn from(error: StateError) -> Self {
        CallError::from(error).into()
    }
}

impl From<CouplingError> for CoupledError {
    fn from(error: CouplingError) -> Self {
        SimulationError::from(error).into()
    }
}

/// What times in a message of the run mean where the importer does not begin at 0.
pub(super) fn counted_from(start_time: f64) -> String {
    if start_time == 0.0 { String::new() } else { format!(" (times count from the start at {start_time} s)") }
}
