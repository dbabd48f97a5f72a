//! The intact dam with compressible water against solutions in the frequency domain.

use cofferdam_dam::Dam;
use cofferdam_unit::WetFace;
use std::num::NonZeroUsize;
use std::sync::LazyLock;
use whole_chain::frequency_domain::LinearDam;
use whole_chain::koyna;
use whole_chain::quadratic_elements;
use whole_chain::scenario::Scenario;
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

/// The crest's history in the frequency domain, at every communication point.
fn crest(dam: &LinearDam, wet_face: WetFace) -> Vec<f64> {
    let modes = dam.modes();
    println!("{} degrees of freedom, ω = {:.3?} rad/s", dam.mass.nrows(), modes.frequencies(4));
    let scenario = scenario(5.0);
    let motion =
        cofferdam_assembly::read_scene(&scenario.write(), &[]).expect("the scene is valid").ground_motion;
    let duration = END - START;
    let parameters = koyna::reservoir(wet_face, H, duration);
    // Twice the communication step: the crest's displacement has no content above 100 Hz.
    modes.crest_history(&motion, 2.0 * H, (duration / H) as usize / 2, |s| {
        cofferdam_reservoir::frequency_response(&parameters, s, NonZeroUsize::MIN.saturating_add(1))
            .expect("a response")
            .into_iter()
            .map(|k| k.columns(0, k.nrows()).into_owned()) // the ground does not move along its normal
            .collect()
    })
}

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
    let (dam, wet_face) = own_matrices(5.0);
    let exact = crest(&dam, wet_face);
    let run: Vec<f64> =
        scenario(5.0).run().column("dam.crest_displacement.x").iter().step_by(2).copied().collect();
    assert_eq!(run.len(), exact.len());
    let (error, peaks) = (relative_l2(&run, &exact), peak(&run) / peak(&exact) - 1.0);
    println!("time against frequency domain, same matrices: L2 {error:.2e}, peak {peaks:+.2e}");
    assert!(error <= 0.01 && peaks.abs() <= 1e-3, "{error}, {peaks}");
}

#[test]
fn an_independent_discretisation() {
    let reference = &*QUADRATIC;
    let sizes = [10.0, 5.0, 10.0 / 3.0];
    let mut errors = Vec::new();
    for size in sizes {
        let (dam, wet_face) = own_matrices(size);
        let own = crest(&dam, wet_face);
        let (error, peaks) = (relative_l2(&own, reference), peak(&own) / peak(reference) - 1.0);
        println!("elements of {size:.2} m against quadratic ones: L2 {error:.3e}, peak {peaks:+.3e}");
        errors.push((error, peaks));
    }
    let orders = [order(errors[0].0, errors[1].0, 2.0), order(errors[1].0, errors[2].0, 1.5)];
    println!("orders {orders:.2?}");
    assert!(errors[0].0 > errors[1].0 && errors[1].0 > errors[2].0, "{errors:?}");
    assert!(errors[2].1.abs() <= 0.01, "{errors:?}");
}
