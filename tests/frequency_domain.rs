//! The intact dam with compressible water against solutions in the frequency domain.

use cofferdam_dam::Dam;
use cofferdam_motion::GroundMotion;
use cofferdam_reservoir::{Fidelity, ReservoirParameters};
use cofferdam_unit::WetFace;
use std::num::NonZeroUsize;
use std::sync::LazyLock;
use toml::{Table, Value};
use whole_chain::frequency_domain::{LinearDam, TransferFunction};
use whole_chain::koyna;
use whole_chain::quadratic_elements;
use whole_chain::scenario::{Scenario, root};
use whole_chain::{order, peak, relative_l2};

const H: f64 = 0.0025;
/// The strong part of the record, s.
const START: f64 = 3.0;
const END: f64 = 8.0;

/// The scene `koyna-intact`, cropped, with the dam's elements of `element_size`.
fn scenario(element_size: f64) -> Scenario {
    let mut scenario = Scenario::shipped("koyna-intact");
    scenario.set("ground_motion.record.start", START).set("ground_motion.record.end", END);
    scenario.set("time.duration", END - START).set("dam.element_size", element_size);
    scenario.set("reservoir.element_size", koyna::DEPTH / 16.0);
    scenario
}

/// The dam's own matrices, and the Rayleigh coefficients it uses.
fn own_matrices(element_size: f64) -> (LinearDam, WetFace) {
    let dam = Dam::new(koyna::dam(element_size, false)).expect("the dam is valid");
    (LinearDam::of(&dam), dam.wet_face().expect("there is water").clone())
}

/// The dam with its water in the frequency domain. Twice the communication step: the crest's displacement has no content above
/// 100 Hz.
fn coupled(dam: &LinearDam, water: &ReservoirParameters) -> TransferFunction {
    let modes = dam.modes();
    println!("{} degrees of freedom, ω = {:.3?} rad/s", dam.mass.nrows(), modes.frequencies(4));
    modes.transfer_function(2.0 * H, ((END - START) / H) as usize / 2, |s| {
        cofferdam_reservoir::frequency_response(water, s, NonZeroUsize::MIN.saturating_add(1))
            .expect("a response")
    })
}

/// The water of the scene on `wet_face`.
fn water(wet_face: WetFace) -> ReservoirParameters {
    koyna::reservoir(wet_face, H, END - START)
}

/// What moves the ground in `scenario`.
fn motion(scenario: &Scenario) -> GroundMotion {
    cofferdam_assembly::read_scene(&scenario.write(), &[]).expect("the scene is valid").ground_motion
}

/// The crest's horizontal history in the frequency domain, at every second communication point.
fn crest(dam: &LinearDam, wet_face: WetFace) -> Vec<f64> {
    let [along_x, _] = coupled(dam, &water(wet_face)).crest_history(&motion(&scenario(5.0)));
    along_x
}

/// With the dam's own matrices at 5 m.
static OWN: LazyLock<TransferFunction> = LazyLock::new(|| {
    let (dam, wet_face) = own_matrices(5.0);
    coupled(&dam, &water(wet_face))
});

/// Eight-node elements with the damping of the dam at 5 m.
static QUADRATIC: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let (own, _) = own_matrices(5.0);
    let (dam, wet_face) = quadratic_elements::koyna(6, 8.0, own.rayleigh);
    crest(&dam, wet_face)
});

#[test]
fn the_quadratic_elements_have_converged() {
    let rayleigh = [0.0, 0.0];
    let frequencies =
        |columns, size| quadratic_elements::koyna(columns, size, rayleigh).0.modes().frequencies(4);
    let (coarse, fine) = (frequencies(4, 12.0), frequencies(6, 8.0));
    for (coarse, fine) in coarse.iter().zip(&fine) {
        assert!((coarse / fine - 1.0).abs() < 3e-3, "{coarse} against {fine}");
    }
}

#[test]
fn same_matrices_in_the_frequency_domain() {
    let [exact, _] = OWN.crest_history(&motion(&scenario(5.0)));
    let run: Vec<f64> =
        scenario(5.0).run().column("dam.crest_displacement.x").iter().step_by(2).copied().collect();
    assert_eq!(run.len(), exact.len());
    let (error, peaks) = (relative_l2(&run, &exact), peak(&run) / peak(&exact) - 1.0);
    println!("time against frequency domain, same matrices: L2 {error:.2e}, peak {peaks:+.2e}");
    assert!(error <= 0.01 && peaks.abs() <= 1e-3, "{error}, {peaks}");
}

/// Another record stands in for the vertical component, and moves the ground alone or with the horizontal one.
#[test]
fn same_matrices_under_vertical_motion() {
    let lifted = |water: &ReservoirParameters, horizontal: bool| {
        let mut scenario = scenario(5.0);
        let file = root().join("scenes/records/northridge-1994-beverly-hills-279.csv");
        let vertical = [
            ("file", Value::from(file.to_string_lossy().into_owned())),
            ("scale", Value::from(2.0 / 3.0)),
            ("polarity", Value::from(-1)),
        ];
        let vertical: Table = vertical.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
        scenario.set("ground_motion.vertical", vertical);
        if !horizontal {
            let rows: String = (0..=1000).map(|i| format!("{:.2},0\n", f64::from(i) * 0.01)).collect();
            std::fs::write(scenario.folder().join("still.csv"), rows).expect("the record is written");
            scenario.set("ground_motion.record.file", "still.csv");
        }
        scenario.set("reservoir.wave_reflection_coefficient", water.wave_reflection_coefficient);
        if water.fidelity == Fidelity::Incompressible {
            scenario.set("reservoir.fidelity", "incompressible");
            // Water without memory receives means over the steps, whose error is larger than that of the convolution.
            scenario.set("time.communication_step", H / 2.0);
        }
        scenario
    };
    let (dam, wet_face) = own_matrices(5.0);
    let scene = water(wet_face);
    let absorbing = ReservoirParameters { wave_reflection_coefficient: 0.75, ..scene.clone() };
    let incompressible = ReservoirParameters { fidelity: Fidelity::Incompressible, ..scene.clone() };
    let others = [&absorbing, &incompressible].map(|water| coupled(&dam, water));
    for (water, transfer) in [(&scene, &*OWN), (&absorbing, &others[0]), (&incompressible, &others[1])] {
        for horizontal in [false, true] {
            let scenario = lifted(water, horizontal);
            let exact = transfer.crest_history(&motion(&scenario));
            let histories = scenario.run();
            for (axis, exact) in ["x", "y"].into_iter().zip(&exact) {
                let run = histories.column(&format!("dam.crest_displacement.{axis}"));
                let run: Vec<f64> = run.iter().step_by(run.len() / (exact.len() - 1)).copied().collect();
                let (error, peaks) = (relative_l2(&run, exact), peak(&run) / peak(exact) - 1.0);
                println!(
                    "{:?} water, α = {}, {}, crest along {axis}, at most {:.2} mm: L2 {error:.2e}, peak {peaks:+.2e}",
                    water.fidelity,
                    water.wave_reflection_coefficient,
                    if horizontal { "both components" } else { "vertical component alone" },
                    1e3 * peak(exact),
                );
                assert!(error <= 0.01 && peaks.abs() <= 1e-3, "{error}, {peaks}");
            }
        }
    }
}

#[test]
fn an_independent_discretisation() {
    let reference = &*QUADRATIC;
    let sizes = [10.0, 5.0, 10.0 / 3.0];
    let mut errors = Vec::new();
    for size in sizes {
        let own = if size == 5.0 {
            let [own, _] = OWN.crest_history(&motion(&scenario(5.0)));
            own
        } else {
            let (dam, wet_face) = own_matrices(size);
            crest(&dam, wet_face)
        };
        let (error, peaks) = (relative_l2(&own, reference), peak(&own) / peak(reference) - 1.0);
        println!("elements of {size:.2} m against quadratic ones: L2 {error:.3e}, peak {peaks:+.3e}");
        errors.push((error, peaks));
    }
    let orders = [order(errors[0].0, errors[1].0, 2.0), order(errors[1].0, errors[2].0, 1.5)];
    println!("orders {orders:.2?}");
    assert!(errors[0].0 > errors[1].0 && errors[1].0 > errors[2].0, "{errors:?}");
    assert!(errors[2].1.abs() <= 0.01, "{errors:?}");
}
