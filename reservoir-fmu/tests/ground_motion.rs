//! Motion of the ground: level beds against closed forms, any bed against a linear field.

use crate::rectangular;

use cofferdam_reservoir::analytical::chakrabarti_chopra_1973;
use cofferdam_reservoir::{
    Complex64, ElementOrder, Fidelity, Method, Reservoir, ReservoirError, ReservoirParameters, added_mass,
    frequency_response, ground_added_mass,
};
use cofferdam_unit::variables::reservoir::{BASE_PRESSURE, GROUND_ACCELERATION};
use cofferdam_unit::{CoSimulation, WetFace};
use nalgebra::DVector;
use rectangular::{DENSITY, DEPTH, SOUND_SPEED, THREADS, parameters};
use std::f64::consts::PI;

const CUT_OFF: f64 = PI * SOUND_SPEED / (2.0 * DEPTH);

/// 0.1 %: at least nine linear elements per wavelength. Far end at h/4, h/2, h.
#[test]
fn vertical_motion_of_a_level_bed() -> Result<(), ReservoirError> {
    for alpha in [1.0, 0.75, 0.5, 0.0] {
        for ratio in [0.01, 0.5, 0.97, 1.5, 2.5, 3.6] {
            let s = Complex64::new(0.0, ratio * CUT_OFF);
            for share in [0.25, 0.5, 1.0] {
                let parameters = ReservoirParameters {
                    far_end_distance: share * DEPTH,
                    ..parameters(alpha, 16, 0.0025, 1.0)
                };
                let k = frequency_response(&parameters, &[s], THREADS)?.remove(0);
                let exact = rectangular::projected(&parameters.wet_face, |elevations| {
                    let at = |&y: &f64| chakrabarti_chopra_1973::pressure(s, DEPTH, SOUND_SPEED, alpha, y);
                    elevations.iter().map(at).collect()
                });
                let points = k.nrows();
                let found: Vec<_> = k.column(points + 1).iter().map(|p| p / (s * DENSITY)).collect();
                let error = rectangular::difference(&parameters.wet_face, &found, &exact);
                println!(
                    "α = {alpha}, Ω = {ratio}, far end at {share} h: vertical motion off by {error:.1e}"
                );
                assert!(error < if ratio == 0.97 { 1e-2 } else { 1e-3 });
                assert!(k.column(points).iter().all(|p| *p == Complex64::ZERO), "a level bed slides");
            }
        }
    }
    Ok(())
}

/// Ground that rises with 1 m/s² from the start time on, set before initialisation: p = ρ c a t at the base until the first
/// echo. An error of half a step would be 5 %.
#[test]
fn the_first_step_begins_with_the_ground_as_it_is_then() -> Result<(), ReservoirError> {
    for method in [Method::Radau2, Method::Recursive, Method::FiniteElements] {
        let mut unit =
            Reservoir::new(ReservoirParameters { method, ..parameters(1.0, 16, 0.0025, 0.1) }, THREADS)?;
        unit.set(GROUND_ACCELERATION.value_reference, &[0.0, 1.0])?;
        unit.initialise(0.0)?;
        for step in 0..10 {
            unit.set(GROUND_ACCELERATION.value_reference, &[0.0, 1.0])?;
            unit.step(f64::from(step) * 0.0025, 0.0025)?;
        }
        let mut pressure = [0.0];
        unit.get(BASE_PRESSURE.value_reference, &mut pressure)?;
        let error = pressure[0] / (DENSITY * SOUND_SPEED * 0.025) - 1.0;
        println!("{method:?}: ground that moves at once, base pressure after ten steps {error:+.1e} off");
        assert!(error.abs() < 0.02);
    }
    Ok(())
}

/// Bed and face move upwards together: p = ρ a (h − y) in incompressible water, whatever the shape.
/// The pressure is linear in space, so the only errors are those of the quadrature and the far end.
#[test]
fn a_vessel_that_rises_weighs_more() -> Result<(), ReservoirError> {
    let faces = [[[0.0, 0.0], [0.0, 60.0], [30.0, DEPTH]], [[0.0, 0.0], [-25.0, 90.0], [-30.0, DEPTH]]];
    for face in faces {
        for bed in
            [vec![], vec![[-40.0, 0.0], [-90.0, 50.0]], vec![[-60.0, 0.0], [-50.0, -30.0], [-150.0, -20.0]]]
        {
            for element_order in [ElementOrder::Linear, ElementOrder::Constant] {
                let parameters = ReservoirParameters {
                    wet_face: WetFace::new(face.to_vec()).unwrap().respaced(12.0).unwrap(),
                    bed: bed.clone(),
                    fidelity: Fidelity::Incompressible,
                    element_order,
                    ..parameters(1.0, 16, 0.01, 1.0)
                };
                let (of_face, of_ground) = (added_mass(&parameters)?, ground_added_mass(&parameters)?);
                // At a kink one velocity belongs to two normals: that of the lower piece is taken.
                let moved: DVector<f64> = DVector::from_iterator(
                    parameters.wet_face.len(),
                    parameters.wet_face.normals().iter().map(|n| n[1]),
                );
                let pressure = -(of_face * moved + of_ground.column(1));
                let middle = parameters.wet_face.len() / 4;
                let exact = DENSITY * (DEPTH - parameters.wet_face.points()[middle][1]);
                let off = pressure[middle] / exact - 1.0;
                println!("{element_order:?}, bed {bed:?}: pressure at the lower quarter off by {off:+.1e}");
                assert!(off.abs() < 2e-2);
            }
        }
    }
    Ok(())
}
