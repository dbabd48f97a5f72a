//! Natural modes, empty and in water, against dense eigensolutions of independently assembled matrices.

use crate::added_mass::{dense, incompressible, intact, modes, water_mass, westergaard, with_water};
use crate::support;

use cofferdam_dam::{Dam, DamError, DamParameters, Fidelity, Structure, contact::MohrCoulomb};
use nalgebra::{DMatrix, DVector};

/// `φᵀ (M + X) ψ` from the masses and the water of the nodes.
fn product(structure: &Structure<MohrCoulomb>, phi: &[[f64; 2]], psi: &[[f64; 2]]) -> f64 {
    let concrete: f64 = (structure.mass.iter().zip(phi).zip(psi))
        .map(|((mass, a), b)| mass * (a[0] * b[0] + a[1] * b[1]))
        .sum();
    let water = structure.added_mass.iter().flat_map(|water| water.entries());
    concrete + water.map(|([a, p], [b, q], value)| phi[a][p] * value * psi[b][q]).sum::<f64>()
}

/// Frequencies and the first shape against a dense problem with B A N: the iteration ends at 1e-11 of ω², a shape is then exact
/// to the root of that.
#[test]
fn modes_in_water_are_those_of_the_dense_problem() -> Result<(), DamError> {
    let parameters = intact(9.0);
    let dam = Dam::new(parameters.clone())?;
    let (face, matrices) = (dam.wet_face().unwrap().clone(), dam.system_matrices());
    let size = matrices.mass.len();
    let stiffness = dense(size, &matrices.stiffness);
    let concrete = DMatrix::from_diagonal(&DVector::from_vec(matrices.mass.clone()));
    let empty = parameters.natural_modes(4)?;
    assert_eq!(empty.frequencies, dam.natural_frequencies(4)?);
    for water in [westergaard as fn(&_) -> _, incompressible] {
        let full = with_water(&parameters, water).natural_modes(4)?;
        let (frequencies, first) = modes(&stiffness, &(&concrete + water_mass(&dam, &water(&face))));
        println!(
            "full {:.3?}, dense {:.3?}, empty {:.3?}",
            full.frequencies,
            &frequencies[..4],
            empty.frequencies
        );
        for (mode, omega) in full.frequencies.iter().enumerate() {
            assert!((omega / frequencies[mode] - 1.0).abs() < 1e-9);
            assert!(*omega < empty.frequencies[mode]);
        }
        // the order of the free degrees of freedom is that of the nodes
        let free = (0..dam.node_count()).filter(|&node| !dam.structure().is_fixed(node));
        let shape: Vec<f64> = free.flat_map(|node| full.shapes[0][node]).collect();
        let sign = first[matrices.crest[0]].signum();
        let off = shape.iter().zip(first.iter()).map(|(a, b)| (a - sign * b).abs()).fold(0.0, f64::max);
        println!("  first shape off by {:.1e}", off / first.amax());
        assert!(off < 1e-6 * first.amax());
    }
    Ok(())
}

#[test]
fn water_without_mass_changes_no_bit() -> Result<(), DamError> {
    let parameters = support::koyna(10.0);
    let massless = with_water(&parameters, |face| vec![vec![0.0; face.len()]; face.len()]);
    assert_eq!(massless.natural_modes(4)?, parameters.natural_modes(4)?);
    Ok(())
}

/// Of the cracked dam at any fidelity: shapes are orthonormal with the masses of all nodes and of the water, do not move the
/// base, and pass the crack.
#[test]
fn shapes_are_orthonormal_and_continuous() -> Result<(), DamError> {
    for parameters in [support::koyna(5.0), with_water(&support::koyna(5.0), incompressible)] {
        let dam = Dam::new(parameters.clone())?;
        let found = parameters.natural_modes(4)?;
        let mut worst = 0.0f64;
        for (i, phi) in found.shapes.iter().enumerate() {
            for (j, psi) in found.shapes.iter().enumerate() {
                worst = worst.max((product(dam.structure(), phi, psi) - f64::from(u8::from(i == j))).abs());
            }
            let mesh = &dam.structure().mesh;
            assert!(mesh.base.iter().all(|&node| phi[node] == [0.0; 2]));
            assert!(mesh.doubled_nodes().all(|(lower, upper)| phi[lower] == phi[upper]));
            let crest = phi[mesh.upstream[mesh.upstream.len() - 1]];
            assert!(i > 0 || crest[0] > 0.0, "the first mode moves the crest downstream: {crest:?}");
        }
        println!("orthonormal to {worst:.1e}");
        assert!(worst < 1e-8);
        let intact = DamParameters { fidelity: Fidelity::Intact { modes: None }, ..parameters };
        assert_eq!(intact.natural_modes(4)?, found, "fidelity makes no difference");
    }
    Ok(())
}

#[test]
fn too_many_modes_and_a_wrong_shape_are_refused() {
    let parameters = intact(20.0);
    assert!(matches!(parameters.natural_modes(100_000), Err(DamError::TooManyFrequencies { .. })));
    let wrong = DamParameters { added_mass: Some(vec![vec![0.0]]), ..parameters };
    assert!(matches!(wrong.natural_modes(4), Err(DamError::AddedMassShape { .. })));
}
