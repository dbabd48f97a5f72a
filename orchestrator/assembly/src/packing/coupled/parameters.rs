use super::CoupledError;
use crate::Assembly;
use crate::ground::{component_of, ground_signals};
use crate::packing::without_paths;
use crate::simulation::simulation_of;
use cofferdam_coupling::convergence::Tolerance;
use cofferdam_coupling::participant::{InProcess, Messages, Participant};
use cofferdam_coupling::scheme::Graph;
use cofferdam_coupling::signal::Signal;
use cofferdam_coupling::simulation::Simulation;
use cofferdam_coupling::stepping::Stepping;
use cofferdam_dam::DamParameters;
use cofferdam_motion::{Component, GroundMotion};
use cofferdam_reservoir::{Reservoir, ReservoirParameters};
use cofferdam_scene::{OnFailure, Scene};
use cofferdam_unit::Packable;
use serde::{Deserialize, Serialize};
use std::num::NonZeroUsize;

/// Tolerances that a scene may have.
const TOLERANCES: std::ops::RangeInclusive<f64> = 1e-14..=0.1;
/// More steps than any simulation takes: the importer decides when it ends.
const ENDLESS: u64 = 1 << 40;

/// Everything from which the coupled unit is made.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoupledParameters {
    /// 1 if the ground moves as in the scene, 0 if an input moves it.
    pub use_record: f64,
    /// Factor of the ground motion of the scene.
    pub record_scale: f64,
    /// Tolerance of the iteration; 0 for the balanced one.
    pub coupling_tolerance: f64,
    /// 1 if the inputs have the values that are set over the whole next step, 0 if they change linearly within it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub inputs_held: f64,
    /// Parameters of the dam.
    pub dam: DamParameters,
    /// Parameters of the reservoir and, if there is one, the tailwater.
    pub waters: Vec<ReservoirParameters>,
    /// The scene, for scheme and steps.
    pub scene: Scene,
    /// Ground motion of the scene.
    pub record: Signal,
    /// Its vertical component.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertical: Option<Signal>,
}

impl CoupledParameters {
    /// The parameters of the units of `scene`, moved by `motion`.
    ///
    /// **Errors**: units that this program does not compute, steps of varying length or in windows, and those of the units.
    pub fn of(scene: &Scene, motion: &GroundMotion) -> Result<Self, CoupledError> {
        if scene.computed_dam().is_none() {
            return Err(CoupledError::Unfit(
                "its dam is prescribed or another program's; give it a [dam] of this program",
            ));
        }
        if scene.waters().any(|(_, water)| water.solver().is_none()) {
            return Err(CoupledError::Unfit(
                "a water is missing or another program's; choose a `reservoir.fidelity` of this program",
            ));
        }
        if scene.time.adaptive.is_some()
            || scene.coupling.window > 1
            || scene.coupling.on_failure == OnFailure::Halve
        {
            return Err(CoupledError::Unfit(
                "its steps vary or are iterated in windows; leave out [time.adaptive], `coupling.window` and \
                 `coupling.on_failure = \"halve\"`",
            ));
        }
        let assembly = Assembly::of(scene);
        let waters = scene.waters().map(|(side, _)| assembly.water_parameters(side));
        let mut signals = ground_signals(motion).into_iter();
        let (Some(record), vertical) = (signals.next(), signals.next()) else {
            return Err(CoupledError::Unfit("its ground has no motion"));
        };
        let coupling_tolerance = match scene.coupling.tolerance {
            Tolerance::Relative(tolerance) => tolerance,
            Tolerance::Balanced => 0.0,
        };
        Ok(Self {
            use_record: 0.0,
            record_scale: 1.0,
            coupling_tolerance,
            inputs_held: 0.0,
            dam: assembly.dam_parameters(assembly.scheme_mass())?,
            waters: waters.collect::<Result<_, _>>()?,
            scene: without_paths(scene),
            record,
            vertical,
        })
    }

    /// Whether inputs move the ground, and are constant within a step.
    pub(super) fn holds_inputs(&self) -> bool {
        self.inputs_held == 1.0 && self.use_record == 0.0
    }

    /// The ground motion of the scene, times `record_scale` if it is used.
    fn motion(&self) -> GroundMotion {
        let scale = if self.use_record == 1.0 { self.record_scale } else { 1.0 };
        let scaled = |signal: &Signal| {
            let samples = signal.samples.iter().map(|sample| sample * scale).collect();
            component_of(&Signal { samples, ..signal.clone() })
        };
        GroundMotion::from(scaled(&self.record)).with_vertical(self.vertical.as_ref().map(scaled))
    }

    /// The units, made on these threads, the waters from what was prepared for them where there is something.
    fn graph(
        &self,
        scene: &Scene,
        prepared: &[Option<Vec<u8>>],
        threads: NonZeroUsize,
    ) -> Result<Graph, CoupledError> {
        let assembly = Assembly::with(scene, threads);
        let messages = Messages::default();
        let (dam, _) = messages.listen(|| assembly.make_dam(self.dam.clone()))?;
        let dam = dam.on_threads(threads)?;
        let dam = if self.holds_inputs() { dam.holding_the_ground() } else { dam };
        let mut units: Vec<Box<dyn Participant>> = vec![Box::new(InProcess::new(dam, "dam", messages))];
        for (number, parameters) in self.waters.iter().enumerate() {
            let messages = Messages::default();
            let inputs_held = f64::from(u8::from(self.holds_inputs()));
            let parameters = ReservoirParameters { inputs_held, ..parameters.clone() };
            let water = messages.listen(|| match prepared.get(number).and_then(Option::as_deref) {
                Some(bytes) => Reservoir::from_prepared(parameters, bytes, threads),
                None => Reservoir::new(parameters, threads),
            })?;
            units.push(Box::new(InProcess::new(water, "water", messages)));
        }
        Ok(Graph::new(units, assembly.interfaces())?)
    }

    /// The run with these units, which does not end by itself.
    pub(super) fn simulation(
        &self,
        prepared: &[Option<Vec<u8>>],
        threads: NonZeroUsize,
    ) -> Result<Simulation, CoupledError> {
        let refused = |name, value, remedy| Err(CoupledError::Parameter { name, value, remedy });
        for (name, flag) in [("use_record", self.use_record), ("inputs_held", self.inputs_held)] {
            if ![0.0, 1.0].contains(&flag) {
                return refused(name, flag, "set it to 0 or 1");
            }
        }
        if self.coupling_tolerance != 0.0 && !TOLERANCES.contains(&self.coupling_tolerance) {
            let remedy = "set it to a number between 1e-14 and 0.1, or to 0 for the balanced tolerance";
            return refused("coupling_tolerance", self.coupling_tolerance, remedy);
        }
        let finite = |component: &Component| component.acceleration().iter().all(|a| a.is_finite());
        if !self.motion().components().all(finite) {
            return refused(
                "record_scale",
                self.record_scale,
                "set it so that no acceleration becomes infinite",
            );
        }
        let mut scene = self.scene.clone();
        scene.coupling.tolerance = match self.coupling_tolerance {
            0.0 => Tolerance::Balanced,
            tolerance => Tolerance::Relative(tolerance),
        };
        // Scales of the coupling depend on it.
        if let Some(ReservoirParameters { density, .. }) = self.waters.first() {
            if !(density.is_finite() && *density > 0.0) {
                return refused("water_density", *density, "set it to a positive number, kg/m³");
            }
            scene.reservoir.density = *density;
        }
        let graph = self.graph(&scene, prepared, threads)?;
        let mut simulation = simulation_of(&scene, &self.motion(), graph)?;
        simulation.stepping = Stepping { steps: ENDLESS, ..simulation.stepping };
        Ok(simulation)
    }
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
