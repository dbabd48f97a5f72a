//! Ground motions as signals, and back.

use crate::units::GROUND_ACCELERATION;
use cofferdam_coupling::signal::Signal;
use cofferdam_motion::{Component, GroundMotion};

/// Names of the signals of the ground along x and y.
const GROUND_SIGNALS: [&str; 2] = ["ground_motion", "ground_motion_vertical"];

/// The acceleration of the ground as the external signals that dams and waters receive, one for each component that the motion has.
pub fn ground_signals(motion: &GroundMotion) -> Vec<Signal> {
    let component = |(number, component): (usize, &Component)| Signal {
        source: component.source().to_owned(),
        held: component.is_held(),
        parts: if number == 0 { motion.aftershocks().to_vec() } else { Vec::new() },
        ..ground_signal(number, component.interval(), component.acceleration().to_vec())
    };
    motion.components().enumerate().map(component).collect()
}

/// The signal of the ground along x (`component` 0) or y (1) with these samples (m/s²), `interval` (s) apart.
pub fn ground_signal(component: usize, interval: f64, samples: Vec<f64>) -> Signal {
    Signal {
        quantity: "acceleration".to_owned(),
        unit: "m/s2".to_owned(),
        component,
        ..Signal::new(GROUND_SIGNALS[component.min(1)], GROUND_ACCELERATION, interval, samples)
    }
}

/// The component of a ground motion in a signal.
pub fn component_of(signal: &Signal) -> Component {
    let component = Component::of_samples(&signal.source, signal.interval, signal.samples.clone());
    if signal.held { component.held() } else { component }
}
