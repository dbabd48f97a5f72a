//! The coupled solution converges with the square of the communication step.

use std::f64::consts::PI;
use toml::Table;
use whole_chain::scenario::Scenario;
use whole_chain::{order, relative_l2};

const REFERENCE: f64 = 0.000625;
const END: f64 = 0.8;

/// The crest's history along `axis` at multiples of 10 ms: intact dam, sin⁴ pulse of 0.4 s along the same axis, strict tolerance.
fn crest(communication_step: f64, axis: &str) -> Vec<f64> {
    let mut scenario = Scenario::shipped("koyna-intact");
    // Linear between samples at 10 ms, the longest step, so that the motion is the same for every step.
    let samples = (0..=40).map(|i| i as f64 * 0.01);
    let rows = samples.map(|t| format!("{t:.2},{},0\n", 0.3 * (PI * t / 0.4).sin().powi(4)));
    let rows = "time_s,pulse [g],still [g]\n".to_owned() + &rows.collect::<String>();
    std::fs::write(scenario.folder().join("pulse.csv"), rows).expect("the record is written");
    let (horizontal, vertical) = if axis == "x" { (1, 2) } else { (2, 1) };
    scenario.set("ground_motion.record.file", "pulse.csv").set("ground_motion.record.column", horizontal);
    scenario.set("ground_motion.vertical", Table::from_iter([("column".to_owned(), vertical.into())]));
    scenario.set("time.duration", END);
    scenario.set("time.communication_step", communication_step).set("coupling.tolerance", 1e-10);
    scenario.set("dam.element_size", 12.0).set("reservoir.element_size", 15.0);
    let histories = scenario.run();
    let every = (0.01 / communication_step).round() as usize;
    histories.column(&format!("dam.crest_displacement.{axis}")).iter().step_by(every).copied().collect()
}

#[test]
fn order_two() {
    for axis in ["x", "y"] {
        let reference = crest(REFERENCE, axis);
        let errors = [0.01, 0.005, 0.0025].map(|h| relative_l2(&crest(h, axis), &reference));
        // The reference has an error of its own, a sixteenth of the finest one's: 0.07 in the order.
        let orders = [order(errors[0], errors[1], 2.0), order(errors[1], errors[2], 2.0)];
        println!(
            "along {axis}, H = 10, 5, 2.5 ms: relative L2 {:.2e}, {:.2e}, {:.2e}; orders {orders:.3?}",
            errors[0], errors[1], errors[2]
        );
        assert!(orders.iter().all(|o| *o >= 1.9), "{orders:?}");
        assert!(errors[2] < 1e-3, "{errors:?}");
    }
}
