//! The shipped ramp scene, run by the program, against its closed form.

use cofferdam_reservoir::analytical::chopra_1967;
use whole_chain::peak;
use whole_chain::scenario::Scenario;

#[test]
fn base_pressure_of_the_ramp() {
    let histories = Scenario::shipped("rigid-dam-ramp").run();
    let (depth, sound_speed, density) = (180.0, 1440.0, 1000.0);
    // Towards the water: the face's acceleration along n is −1 m/s², its pressure positive.
    let exact = |t: &f64| {
        let velocity = chopra_1967::base_pressure(&[(0.0, 0.0), (0.1, 1.0)], depth, sound_speed, *t);
        density * sound_speed * velocity
    };
    let exact: Vec<f64> = histories.column("time").iter().map(exact).collect();
    let pressure = histories.column("reservoir.base_pressure");
    let errors: Vec<f64> = pressure.iter().zip(&exact).map(|(p, q)| p - q).collect();
    let error = peak(&errors) / peak(&exact);
    println!("peak C_p {:.4}, largest error over the peak {error:.2e}", peak(&exact) / (density * depth));
    assert_eq!(pressure.len(), 801);
    assert!(pressure[40] > 0.0);
    assert!(error <= 0.005, "{error}");
}
