//! A participant of one's own: a rigid block on a spring takes the dam's place before the water.
//!
//! `cargo run --release -p cofferdam-assembly --example own_participant`

use cofferdam_assembly::simulation::scales;
use cofferdam_assembly::units::{DAM, GROUND_ACCELERATION, pair};
use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
use cofferdam_coupling::convergence::{ConvergenceMeasure, Measure};
use cofferdam_coupling::participant::{
    Channel, ChannelShape, Description, InProcess, Layout, Messages, Occasion, Participant, ParticipantError,
};
use cofferdam_coupling::scheme::{Interval, Predictor, Scheme, Settings};
use cofferdam_coupling::signal::Signal;
use cofferdam_reservoir::{Reservoir, ReservoirParameters};
use cofferdam_unit::{Capabilities, Fingerprint, WetFace};
use std::num::NonZeroUsize;

/// Displacement, velocity, force of the water, ground acceleration; for 1000 t on a spring of 400 MN/m.
type State = [f64; 4];

struct Block {
    description: Description,
    face: WetFace,
    now: State,
    saved: State,
}

impl Participant for Block {
    fn description(&self) -> &Description {
        &self.description
    }

    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        let axis = usize::from(variable == "interface_y");
        Ok(self.face.points().iter().map(|p| p[axis]).collect())
    }

    fn initialise(&mut self, _: f64, _: &[f64], outputs: &mut [f64]) -> Result<(), ParticipantError> {
        outputs.fill(0.0);
        Ok(())
    }

    /// Trapezoidal rule for m ü + k u = f − m a_g.
    fn step(&mut self, at: &Occasion, inputs: &[f64], outputs: &mut [f64]) -> Result<(), ParticipantError> {
        let h = at.communication_step;
        let (n, [u, v, force, ground], mass, stiffness) = (self.face.len(), self.now, 1e6, 4e8);
        let forces = self.face.nodal_forces(&inputs[..n]);
        let (force_end, ground_end) = (forces.iter().map(|f| f[0]).sum::<f64>(), inputs[2 * n]);
        let load = 0.5 * (force + force_end) / mass - 0.5 * (ground + ground_end);
        let w2 = stiffness / mass;
        let v_end = (v * (1.0 - 0.25 * w2 * h * h) + h * (load - w2 * u)) / (1.0 + 0.25 * w2 * h * h);
        self.now = [u + 0.5 * h * (v + v_end), v_end, force_end, ground_end];
        outputs[..n].fill(self.now[0]);
        outputs[n..].fill((v_end - v) / h + 0.5 * (ground + ground_end));
        Ok(())
    }

    fn save_state(&mut self) -> Result<(), ParticipantError> {
        self.saved = self.now;
        Ok(())
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        self.now = self.saved;
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (h, face) = (0.0025, WetFace::straight([0.0, 50.0], 10)?);
    let channel = |name: &str, size| Channel {
        name: name.into(),
        value_reference: 0,
        unit: String::new(),
        size,
        shape: if name == "ground_acceleration" { ChannelShape::Plane } else { ChannelShape::WetFace },
    };
    let n = face.len();
    let inputs = [("interface_pressure", n), ("hydrostatic_pressure", n), ("ground_acceleration", 2)];
    let outputs = [("interface_displacement", n), ("interface_acceleration", n)];
    let description = Description {
        name: "dam".into(),
        solver: "block on a spring".into(),
        fingerprint: Fingerprint::of("block", &face)?,
        inputs: Layout::new(inputs.map(|(name, size)| channel(name, size)).into()),
        outputs: Layout::new(outputs.map(|(name, size)| channel(name, size)).into()),
        readable: Layout::default(),
        capabilities: Capabilities {
            variable_communication_step: true,
            directional_derivative: false,
            saved_state: true,
        },
    };
    let water = ReservoirParameters {
        wave_reflection_coefficient: 0.9,
        communication_step: h,
        horizon: 1.0,
        ..ReservoirParameters::before(face.clone())
    };
    let reservoir =
        InProcess::new(Reservoir::new(water, NonZeroUsize::MIN)?, "reservoir", Messages::default());
    let dam = Block { description, face, now: [0.0; 4], saved: [0.0; 4] };
    let mut graph = pair(Box::new(dam), Box::new(reservoir))?;
    let aitken = Acceleration::new(AccelerationKind::Aitken, 0.9, 1.0);
    let measure = ConvergenceMeasure::new(
        &[Measure::Change, Measure::Relative],
        1e-6,
        scales(50.0, 1000.0 * 9.81 * 50.0),
    );
    let acceleration = (0..200).map(|step| if step == 0 { 0.0 } else { 2.0 }).collect();
    let ground = Signal::new("ground_motion", GROUND_ACCELERATION, h, acceleration);
    let mut scheme =
        Scheme::new(&mut graph, Settings::default(), aitken, Predictor::new(2), measure, vec![ground])?;
    scheme.initialise(&mut graph, 0.0)?;
    for step in 1..=400_u32 {
        let time = f64::from(step) * h;
        let interval = Interval::new(step.into(), time - h, h);
        let report = scheme.advance(&mut graph, &[interval])?;
        if step % 40 == 0 {
            let displacement = report.accepted(DAM, interval.step).map_or(f64::NAN, |e| 1e3 * e.outputs[0]);
            println!("{time:.2} s: {displacement:+.3} mm, {} iterations", report.iterations());
        }
    }
    Ok(())
}
