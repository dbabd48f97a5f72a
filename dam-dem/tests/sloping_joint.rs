//! The load at which what stands on a sloping joint moves, to a millionth of it.

use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::integrator::DynamicRelaxation;
use cofferdam_dam::{
    CrackLine, CrackParameters, Dam, DamError, DamParameters, Damping, Kinematics, Material, Plane, Section,
    Structure,
};
use cofferdam_unit::CoSimulation;

use crate::support::assembly::{cases, two_blocks};
use crate::support::{self, GRAVITY};

const FRICTION: f64 = 0.5;
/// Stiffness of the joints, Pa/m: a block turns by less than 1e-7. In stiffer ones rounding counts.
const JOINT: f64 = 1e11;
/// Young's modulus, Pa.
const STIFF: f64 = 1e12;
/// Residual over the loads below which a block is at rest. With a load of 10⁻⁶ too much there are 4 × 10⁻⁷ left.
const TOLERANCE: f64 = 1e-7;

/// Under its weight across the joint and a part of it along the joint, which is μ (1 ∓ 10⁻⁶).
#[test]
fn a_block_moves_at_its_friction_angle() -> Result<(), DamError> {
    let law = Coulomb { friction: FRICTION, normal_stiffness: JOINT, shear_stiffness: JOINT };
    let contacts = [Integration::Nodal, Integration::Gauss];
    for (position, meshing) in cases() {
        for (integration, direction) in contacts.into_iter().flat_map(|c| [(c, 1.0), (c, -1.0)]) {
            let mesh = position.of_mesh(two_blocks([3.0, 0.6], 2.0, meshing));
            let fixed: Vec<usize> = mesh.blocks[0].nodes.clone().collect();
            let material = support::stiff(STIFF);
            let structure = Structure::new(mesh, &material, Kinematics::Small, [(law, integration)], &fixed);
            let relax = |share: f64| {
                let body = position.of([direction * FRICTION * share * GRAVITY, -GRAVITY]);
                let solver = DynamicRelaxation { tolerance: TOLERANCE, max_iterations: 8000 };
                solver.relax(&structure, &mut structure.at_rest(), &structure.weight(body))
            };
            let [below, above] = [1.0 - 1e-6, 1.0 + 1e-6].map(relax);
            println!("{position:?}, {meshing:?}, {integration:?}, {direction:+}: {below:?}; {above:?}");
            assert!(below.is_ok() && matches!(above, Err(DamError::StaticNotConverged { .. })));
        }
    }
    Ok(())
}

/// A rectangle that a crack of this slope divides, with `friction` over the slope.
fn divided(slope: f64, share: f64) -> DamParameters {
    let (width, middle) = (4.0, 3.0);
    let line =
        CrackLine::Polyline(vec![[0.0, middle - slope * width / 2.0], [width, middle + slope * width / 2.0]]);
    let material =
        Material { young_modulus: STIFF, density: 2500.0, plane: Plane::Strain, ..Default::default() };
    DamParameters {
        section: Section::rectangle(width, 7.0),
        water_depth: 0.0,
        cracks: vec![CrackParameters {
            line,
            ..CrackParameters::sliding(0.0, slope.abs() * share, JOINT, JOINT)
        }],
        material,
        damping: Damping::None,
        kinematics: Kinematics::Small,
        element_size: 0.8,
        ..support::koyna(1.0)
    }
}

/// The factor of safety is μ over the slope to rounding; a dam with a factor of 1 + 10⁻⁶ is at rest, one with 1 − 10⁻⁶ is
/// refused, and its blocks have no state of rest either.
#[test]
fn the_limit_equilibrium_is_that_of_the_blocks() -> Result<(), DamError> {
    for slope in [-0.5, -0.2, 0.15, 0.4] {
        for share in [1.0 + 1e-6, 1.0 - 1e-6, 1.0] {
            let parameters = divided(slope, share);
            let factor = parameters.limit_equilibria([0.0; 2])?[0].sliding;
            assert!((factor / share - 1.0).abs() < 1e-12, "{factor}");
            let mut dam = Dam::new(parameters)?;
            let structure = dam.structure();
            let weight = structure.weight([0.0, -GRAVITY]);
            let solver = DynamicRelaxation { tolerance: TOLERANCE, max_iterations: 10_000 };
            let rest = solver.relax(structure, &mut structure.at_rest(), &weight);
            println!(
                "slope {slope}, μ/slope − 1 = {:.0e}, factor − 1 = {:.3e}: {rest:?}",
                share - 1.0,
                factor - 1.0
            );
            if share != 1.0 {
                let started = dam.initialise(0.0);
                assert_eq!(rest.is_ok(), share > 1.0);
                assert_eq!(started.is_ok(), share > 1.0, "{started:?}");
            }
        }
    }
    Ok(())
}
