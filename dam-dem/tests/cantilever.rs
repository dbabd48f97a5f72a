//! A slender cantilever against beam theory.

use crate::support;

use cofferdam_dam::analytical::cantilever::{first_frequency, tip_deflection};
use cofferdam_dam::contact::Coulomb;
use cofferdam_dam::integrator::DynamicRelaxation;
use cofferdam_dam::{DamError, Kinematics, Mesh, Section, Structure, modal};
use support::stiff;

const LENGTH: f64 = 40.0;
const MODULUS: f64 = 31e9;

/// Tip deflection and first frequency over those of beam theory, with `columns` cells over the depth of 1 m.
fn ratios(columns: usize) -> Result<[f64; 2], DamError> {
    let count = LENGTH as usize * columns;
    let rows = (0..=count).map(|i| i as f64 / columns as f64).collect();
    let mesh = Mesh::mapped(&Section::rectangle(1.0, LENGTH), &[rows], columns);
    let (base, top) = (mesh.base.clone(), support::top(&mesh));
    let structure = Structure::<Coulomb>::new(mesh, &stiff(MODULUS), Kinematics::Small, [], &base);
    let mut load = structure.weight([0.0; 2]);
    let force = 1e3;
    for (&node, length) in top.iter().zip(structure.mesh.tributary_lengths(&top)) {
        load[node][0] = force * length;
    }
    let mut motion = structure.at_rest();
    DynamicRelaxation { tolerance: 1e-7, ..DynamicRelaxation::default() }.relax(
        &structure,
        &mut motion,
        &load,
    )?;
    let deflection = support::mean_at(&motion.displacement, &top)[0];
    let frequency = modal::natural_frequencies(&structure, 1)?[0];
    Ok([
        deflection / tip_deflection(force, LENGTH, 1.0, MODULUS, MODULUS / 2.0),
        frequency / first_frequency(LENGTH, 1.0, MODULUS, 2500.0),
    ])
}

/// Constant-strain triangles are too stiff in bending, with an error of order 2. The extrapolated values are
/// those of the beam; its frequency neglects shear and rotary inertia, an error of 5e-4 here.
#[test]
fn it_tends_to_the_beam_with_order_two() -> Result<(), DamError> {
    let found = [ratios(4)?, ratios(8)?, ratios(16)?];
    for (what, which) in [("tip deflection", 0), ("first frequency", 1)] {
        let [coarse, middle, fine] = [0, 1, 2].map(|mesh| found[mesh][which]);
        let order = ((middle - coarse) / (fine - middle)).log2();
        let limit = fine + (fine - middle) / 3.0;
        println!(
            "cantilever, {what} over the beam's: {coarse:.4}, {middle:.4}, {fine:.4}; order {order:.2}, limit {limit:.5}"
        );
        assert!((order - 2.0).abs() < 0.2 && (limit - 1.0).abs() < 1e-3);
    }
    Ok(())
}
