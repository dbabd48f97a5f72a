//! Sloping faces in incompressible water against the exact theory.

use crate::rectangular;

use cofferdam_reservoir::analytical::chwang_1978;
use cofferdam_reservoir::{Complex64, Fidelity, ReservoirError, ReservoirParameters, added_mass};
use cofferdam_unit::WetFace;
use rectangular::{DENSITY, DEPTH, difference, parameters, projected};

/// 30° to 120° from the bed, horizontal motion: 0.1 % of the profile with linear elements of h/16.
#[test]
fn pressure_on_faces_of_any_slope() -> Result<(), ReservoirError> {
    for degrees in [30.0f64, 45.0, 60.0, 75.0, 90.0, 105.0, 120.0] {
        let angle = degrees.to_radians();
        let top = [if degrees == 90.0 { 0.0 } else { DEPTH / angle.tan() }, DEPTH];
        let mut errors = Vec::new();
        for elements in [8, 16] {
            let parameters = ReservoirParameters {
                wet_face: WetFace::straight(top, elements).unwrap(),
                fidelity: Fidelity::Incompressible,
                ..parameters(1.0, elements, 0.01, 1.0)
            };
            let face = &parameters.wet_face;
            // An acceleration towards the water, along −x, has the component −n_x along n.
            let n_x = angle.sin();
            let p: Vec<Complex64> =
                added_mass(&parameters)?.row_iter().map(|row| (row.sum() * n_x / DENSITY).into()).collect();
            let exact = projected(face, |elevations| {
                let along: Vec<f64> = elevations.iter().map(|y| y / DEPTH).collect();
                chwang_1978::pressures(DEPTH, angle, &along).into_iter().map(Complex64::from).collect()
            });
            errors.push(difference(face, &p, &exact));
        }
        let base = chwang_1978::pressures(1.0, angle, &[0.0])[0];
        println!("{degrees}°: base {base:.4} ρah, error {errors:.6?} with 8, 16 elements a depth");
        assert!(errors[1] < 1e-3 && errors[1] < 0.5 * errors[0]);
    }
    Ok(())
}
