//! The simulation of a scene: scheme, acceleration, predictor, measures of convergence and communication steps are those of the
//! scene.

use crate::ground::ground_signals;
use crate::interface_work::WetFaceWork;
use crate::participant::SelfTest;
use crate::units::{DAM, unit_role};
use cofferdam_coupling::acceleration::Acceleration;
use cofferdam_coupling::convergence::{ConvergenceMeasure, Scales};
use cofferdam_coupling::participant::ParticipantError;
use cofferdam_coupling::scheme::{CouplingError, Graph, Predictor, Scheme, Settings, UnitId};
use cofferdam_coupling::simulation::{Simulation, SimulationError, UnitTest};
use cofferdam_motion::GroundMotion;
use cofferdam_scene::{OnFailure, Scene};

/// Change of a pressure by which the units are measured, as a share of the hydrostatic pressure at the base: far above
/// rounding, and too small to move a crack.
const PROBE: f64 = 1e-4;

/// Variable of a dam with the displacement (x, y) of its crest under weight and hydrostatic pressure, m.
const CREST_AT_REST: &str = "crest_static_displacement";

/// Scales of the exchanged pressures for a dam of `height` (m) in water of hydrostatic base pressure `ρgh` (Pa): u_ref = 1e-9 ×
/// height; ρgh is the typical pressure, so that ε is relative as long as pressures exceed a hundredth of it; no pressure may
/// exceed 10⁴ ρgh. Nothing is known of the motion.
pub fn scales(height: f64, hydrostatic_base_pressure: f64) -> Scales {
    Scales {
        expected: 0.0,
        change: 1e-9 * height,
        typical: hydrostatic_base_pressure,
        bound: 1e4 * hydrostatic_base_pressure,
    }
}

/// The simulation of `scene` with the units of `graph`, which fit it.
///
/// **Errors**: the units do not fit each other or the scheme.
pub fn simulation_of(
    scene: &Scene,
    ground_motion: &GroundMotion,
    mut graph: Graph,
) -> Result<Simulation, SimulationError> {
    let coupling = &scene.coupling;
    let base_pressure = scene.largest_hydrostatic_pressure();
    let settings = Settings {
        kind: scene.scheme(),
        iteration_limit: coupling.iteration_limit,
        accept_unconverged: coupling.on_failure == OnFailure::Continue,
    };
    let acceleration = Acceleration::new(coupling.acceleration, coupling.relaxation, PROBE * base_pressure)
        .reusing(coupling.reused_steps);
    let predictor = Predictor::new(coupling.predictor_order);
    let scales = Scales {
        // Half the inertia of the water column.
        expected: 0.5 * base_pressure * ground_motion.largest() / scene.gravity,
        ..scales(scene.height(), base_pressure)
    };
    let measure = ConvergenceMeasure::new(&coupling.measures, coupling.tolerance, scales);
    let ground = ground_signals(ground_motion);
    let scheme = Scheme::new(&mut graph, settings, acceleration, predictor, measure, ground)?;
    let scheme = with_work(scheme, &mut graph).map_err(CouplingError::from)?;
    let sources = scene.sources().into_iter().enumerate();
    let tested = |(number, _)| {
        let test = SelfTest::new(unit_role(UnitId(number)), PROBE * base_pressure);
        (UnitId(number), Box::new(test) as Box<dyn UnitTest>)
    };
    let mut simulation = Simulation::new(graph, scheme, scene.stepping());
    simulation.unit_tests = sources.filter(|(_, source)| source.is_foreign()).map(tested).collect();
    simulation.read_initially = Some((DAM, CREST_AT_REST.to_owned()));
    Ok(simulation)
}

/// A scheme that accounts for the work at the wet faces of `graph`.
///
/// **Errors**: a unit does not tell its points.
pub fn with_work(scheme: Scheme, graph: &mut Graph) -> Result<Scheme, ParticipantError> {
    let mut accounts = Vec::new();
    for interface in graph.interfaces().to_vec() {
        let account = WetFaceWork::new(graph, &interface)?;
        accounts.push(account.map(|account| Box::new(account) as _));
    }
    Ok(scheme.with_accounts(accounts))
}

/// Displacement (x, y) of the crest under weight and hydrostatic pressure, m, which a simulation has read; `None` before
/// initialisation and for a dam that does not have it.
pub fn crest_at_rest(simulation: &Simulation) -> Option<[f64; 2]> {
    simulation.initial_values.as_deref().and_then(|values| values.try_into().ok())
}
