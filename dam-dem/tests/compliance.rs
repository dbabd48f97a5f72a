//! The interface compliance of a step: it is reciprocal, and predicts the motion of the dam while nothing slips.

use crate::support;

use cofferdam_dam::{DamError, DamParameters, Damping, Fidelity};
use cofferdam_unit::{CoSimulation, variables::dam as variable};
use nalgebra::DMatrix;
use support::{at_rest, get, koyna};

const STEP: f64 = 2.5e-3;

/// Reciprocity (Maxwell, Betti): the displacement at i under a force at j equals that at j under the same
/// force at i. The nodal forces of pressures are `B = Nᵀ M`, with the mass matrix M of the face, so that
/// `C M⁻¹` is symmetric.
#[test]
fn an_undamped_dam_is_reciprocal() -> Result<(), DamError> {
    for fidelity in [Fidelity::Dem, Fidelity::Reduced { modes: None }] {
        let dam = at_rest(DamParameters { damping: Damping::None, fidelity, ..koyna(5.0) })?;
        let compliance = dam.interface_compliance(STEP, 1e4)?;
        let face = dam.wet_face().ok_or(DamError::Singular)?;
        let points = face.len();
        let forces = |j: usize| {
            let mut unit = vec![0.0; points];
            unit[j] = 1.0;
            face.nodal_forces(&unit)
        };
        let (normals, columns): (Vec<_>, Vec<_>) = (face.normals(), (0..points).map(forces).collect());
        let mass = DMatrix::from_fn(points, points, |i, j| {
            columns[j][i][0] * normals[i][0] + columns[j][i][1] * normals[i][1]
        });
        let inverse = mass.try_inverse().ok_or(DamError::Singular)?;
        // the heel does not move, so that it is left out of the comparison
        for (name, matrix) in
            [("displacement", &compliance.displacement), ("acceleration", &compliance.acceleration)]
        {
            let of_forces = (matrix * &inverse).view((1, 1), (points - 1, points - 1)).into_owned();
            let error = (&of_forces - of_forces.transpose()).norm() / of_forces.norm();
            println!("{fidelity:?}: reciprocity of {name} {error:.1e}");
            assert!(error < 1e-5, "{name}");
            assert!(
                of_forces.diagonal().iter().all(|own| *own > 0.0),
                "{name}: a point must move in the direction of the pressure"
            );
        }
    }
    Ok(())
}

/// The compliance predicts a step under any pressure that leaves the crack closed, and does not change the dam.
#[test]
fn it_foretells_a_step_from_rest() -> Result<(), DamError> {
    let mut dam = at_rest(koyna(5.0))?;
    let before = dam.save_state();
    let compliance = dam.interface_compliance(STEP, 1e4)?;
    assert_eq!(dam.save_state(), before);
    let pressure: Vec<f64> =
        (0..dam.size(&variable::INTERFACE_PRESSURE)).map(|i| 2e4 * (0.5 * i as f64).sin()).collect();
    dam.set(variable::INTERFACE_PRESSURE.value_reference, &pressure)?;
    dam.step(0.0, STEP)?;
    let pressure = nalgebra::DVector::from_vec(pressure);
    for (variable, matrix) in [
        (variable::INTERFACE_DISPLACEMENT, &compliance.displacement),
        (variable::INTERFACE_ACCELERATION, &compliance.acceleration),
    ] {
        let found = nalgebra::DVector::from_vec(get(&dam, &variable));
        let error = (matrix * &pressure - &found).norm() / found.norm();
        println!("{} predicted with a relative error of {error:.1e}", variable.name);
        assert!(error < 1e-4, "{}", variable.name);
    }
    assert!(dam.interface_compliance(STEP, 0.0).is_err());
    assert!(dam.interface_compliance(-1.0, 1e4).is_err());
    Ok(())
}
