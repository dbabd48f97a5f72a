//! What limits the time step is found where it is.

use crate::support;

use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::{
    CrackParameters, Dam, DamError, Fidelity, Kinematics, LimitingPart, Material, Mesh, PartKind, Section,
    Structure,
};

fn limiting_part(cracks: Vec<CrackParameters>) -> Result<LimitingPart, DamError> {
    let mut parameters = support::koyna(10.0);
    parameters.cracks = cracks;
    let dam = Dam::new(parameters)?;
    let part = *dam.limiting_part().expect("all elements are there");
    println!("{part:?}, slowdown {}", part.slowdown());
    let critical = dam.critical_time_step().highest_frequency;
    assert_eq!(part.highest_frequency, critical);
    Ok(part)
}

/// A block of 1.2 m between two cracks, in a mesh of 10 m: the highest mode is the block's stretching over its height, in
/// whatever element of it is smallest.
#[test]
fn a_thin_block_limits_the_time_step() -> Result<(), DamError> {
    let soft = |elevation| CrackParameters::sliding(elevation, 1.0, 1e9, 1e9);
    let part = limiting_part(vec![soft(40.0), soft(41.2)])?;
    assert_eq!(part.kind, PartKind::Element { block: 1 });
    assert!((40.0..=41.2).contains(&part.place[1]), "{:?}", part.place);
    assert!(part.share > 0.99 && part.slowdown() > 3.0, "{part:?}");
    let without = limiting_part(vec![soft(40.0)])?;
    assert!(without.slowdown() < 1.5, "{without:?}");
    Ok(())
}

#[test]
fn a_stiff_crack_limits_the_time_step() -> Result<(), DamError> {
    let stiff = |elevation| CrackParameters::sliding(elevation, 1.0, 1e13, 1e13);
    for (cracks, expected, elevation) in [
        (vec![support::crack_at(30.0), stiff(66.5)], 1, 66.5),
        (vec![support::crack_at(66.5), stiff(30.0)], 0, 30.0),
        (vec![support::crack_at(66.5), stiff(0.0)], 0, 0.0),
    ] {
        let part = limiting_part(cracks)?;
        assert_eq!(part.kind, PartKind::Contact { crack: expected });
        assert_eq!(part.place[1], elevation);
        assert!(part.share > 0.9 && part.slowdown() > 3.0, "{part:?}");
    }
    Ok(())
}

/// One cell of 2 m × 2 m, free, ν = 0: each of its triangles has, with the gradients (±½, −½) and (0, 1) 1/m,
/// B Bᵀ = diag(½, 3/2, ·) but for shear, whose own value is 2; so λ_max(D B Bᵀ) = 3E/2 and ω_e² = 9E/2ρ.
#[test]
fn the_frequency_of_an_element_is_exact() {
    let material =
        Material { young_modulus: 2e10, poisson_ratio: 0.0, density: 2500.0, ..Default::default() };
    let mesh = Mesh::mapped(&Section::rectangle(2.0, 2.0), &[vec![0.0, 2.0]], 1);
    let none: [(Coulomb, Integration); 0] = [];
    let structure = Structure::new(mesh, &material, Kinematics::Small, none, &[]);
    let part = LimitingPart::new(&structure).expect("it converges");
    let exact = (4.5 * 2e10 / 2500.0f64).sqrt();
    assert!((part.median_frequency / exact - 1.0).abs() < 1e-12, "{part:?}, {exact}");
    assert!(part.highest_frequency <= exact);
}

#[test]
fn modes_are_nowhere() -> Result<(), DamError> {
    let mut parameters = support::koyna(10.0);
    parameters.fidelity = Fidelity::Reduced { modes: Some(2) };
    assert!(Dam::new(parameters)?.limiting_part().is_none());
    Ok(())
}
