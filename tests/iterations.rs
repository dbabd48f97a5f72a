//! Number of dam steps per communication step: a loss of efficiency fails here.

use whole_chain::scenario::Scenario;

/// Mean number of dam steps per communication step, without the measurement of the Jacobian, in one second of strong
/// motion of the cracked dam on a mesh of 10 m, to this tolerance.
fn mean(acceleration: &str, measures: &[&str], tolerance: impl Into<toml::Value>) -> f64 {
    let mut scenario = Scenario::shipped("koyna-coarse");
    scenario
        .set("ground_motion.record.start", 5.0)
        .set("ground_motion.record.end", 6.0)
        .set("time.quiet", 0.0);
    scenario.set("dam.element_size", 10.0).set("coupling.acceleration", acceleration);
    scenario.set("reservoir.method", "radau2");
    let names = measures;
    let measures: Vec<toml::Value> = measures.iter().map(|measure| (*measure).into()).collect();
    scenario.set("coupling.measures", measures).set("coupling.tolerance", tolerance);
    let histories = scenario.run();
    let counts = &histories.column("iterations")[1..];
    let most = counts.iter().skip(5).fold(0.0f64, |most, count| most.max(*count));
    let mean = counts.iter().skip(5).sum::<f64>() / (counts.len() - 5) as f64;
    println!("{acceleration}, {names:?}: {mean:.3} on the mean, {most} at most");
    mean
}

#[test]
fn dam_steps_a_communication_step_are_as_few_as_they_were() {
    let pressure = &["pressure"][..];
    for (acceleration, measures, most) in [
        ("interface-jacobian", pressure, 2.75),
        ("iqn-ils", pressure, 2.8),
        ("aitken", pressure, 4.5),
        ("constant", pressure, 5.4),
        ("interface-jacobian", &["pressure", "displacement"], 3.4),
        ("aitken", &["pressure", "displacement"], 4.6),
    ] {
        let mean = mean(acceleration, measures, 1e-6);
        assert!(mean <= most, "{acceleration} {measures:?}: {mean}");
    }
    let balanced = mean("interface-jacobian", pressure, "balanced");
    assert!(balanced <= 2.2, "{balanced}");
}
