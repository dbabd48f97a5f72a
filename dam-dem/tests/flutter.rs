//! Blocks that vibrate by themselves while they slide: eigenvalues compared with the motion in time.

use crate::support;
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::CentralDifference;
use cofferdam_dam::loads::{LoadPath, PressureLoad};
use cofferdam_dam::{
    Dam, DamError, DamParameters, Damping, DampingCoefficients, DampingFrequencies, Fidelity, Material,
    RayleighCoefficients, Section,
};
use nalgebra::{Complex, DMatrix, DVector};

/// A dam 40 m high on a joint 1 m above its base; its block flutters while it slides downstream.
fn lift_joint() -> DamParameters {
    let section = Section::new(vec![[0.0, 0.0], [0.0, 40.0]], vec![[32.0, 0.0], [5.0, 34.0], [5.0, 40.0]]);
    let mut crack = support::crack_at(1.0);
    crack.friction_coefficient = 0.507;
    let material = Material { young_modulus: 25e9, density: 2400.0, ..Default::default() };
    DamParameters { section, water_depth: 37.0, cracks: vec![crack], material, ..support::koyna(2.5) }
}

/// The same with a straight downstream face, which does not flutter.
fn straight() -> DamParameters {
    let downstream = vec![[32.0, 0.0], [5.0, 40.0]];
    DamParameters { section: Section { downstream, ..lift_joint().section }, ..lift_joint() }
}

/// Interval of the samples of a motion, s.
const INTERVAL: f64 = 4e-3;
const SPECIFIC_WEIGHT: f64 = 9810.0;

/// Horizontal distance of the crest from the heel of the block at the ends of intervals, in which the block slides
/// downstream under its weight and the hydrostatic pressure. Strong damping has brought it to steady sliding before, and its
/// crest has then got a `kick` (m/s).
fn sliding(dam: &DamParameters, kick: f64) -> Result<Vec<f64>, DamError> {
    let made = Dam::new(dam.clone())?;
    let (structure, rayleigh) = (made.structure(), made.system_matrices().damping);
    let mut loads = structure.weight([0.0, -support::GRAVITY]);
    let nodes = structure.mesh.upstream_nodes_to(dam.water_depth);
    PressureLoad::new(made.wet_face().unwrap(), &nodes).add(&support::hydrostatic(&made), &mut loads);
    let block = &structure.mesh.blocks[1];
    let mut motion = structure.at_rest();
    block.nodes.clone().for_each(|node| motion.velocity[node][0] = 3.0);
    let mut advance = |kick: f64, rayleigh: RayleighCoefficients, samples: usize| -> Vec<f64> {
        let damping = DampingCoefficients::from(rayleigh);
        support::top(&structure.mesh).iter().for_each(|&node| motion.velocity[node][0] += kick);
        structure.accelerate(damping, &mut motion, &loads);
        let limit = 0.9 * support::critical(structure, damping).limit;
        let steps = CentralDifference::covering(INTERVAL, limit);
        let path = LoadPath::constant(loads.clone());
        let sample = |_| {
            steps.advance(structure, damping, &mut motion, &path, &mut Work::default());
            motion.displacement[support::top(&structure.mesh)[0]][0]
                - motion.displacement[structure.mesh.seams[0].upper[0]][0]
        };
        (0..samples).map(sample).collect()
    };
    advance(0.0, RayleighCoefficients { mass: 100.0, ..rayleigh }, 60);
    Ok(advance(kick, rayleigh, 200))
}

/// Exponents λ (1/s) of `x(t) = a + b t + c t² + Σ c_k exp(λ_k t)` by linear prediction from `order` samples (Prony's method).
fn exponents(history: &[f64], order: usize) -> Vec<Complex<f64>> {
    let change: Vec<f64> = history.windows(4).map(|x| x[3] - 3.0 * x[2] + 3.0 * x[1] - x[0]).collect();
    let rows = change.len() - order;
    let known = DMatrix::from_fn(rows, order, |i, j| change[i + j]);
    let next = DVector::from_fn(rows, |i, _| change[i + order]);
    let found = known.svd(true, true).solve(&next, 1e-14).unwrap();
    let companion = DMatrix::from_fn(order, order, |i, j| match i + 1 {
        row if row == order => found[j],
        row => f64::from(u8::from(row == j)),
    });
    companion.complex_eigenvalues().iter().map(|z| z.ln() / INTERVAL).collect()
}

/// Growth and frequency in time, with one section that flutters and one that does not, are those of the eigenvalues: with
/// and without mass damping, and with the mass of the water. Tolerance: 5 %.
#[test]
fn vibrations_grow_as_the_eigenvalues_say() -> Result<(), DamError> {
    let stiffness =
        Damping::Stiffness { ratio: 0.01, frequencies: DampingFrequencies::MultiplesOfFirst([1.0, 5.0]) };
    let variants = [
        ("broken slope", lift_joint(), true),
        (
            "broken slope, stiffness damping of 1 %",
            DamParameters { damping: stiffness, ..lift_joint() },
            true,
        ),
        ("broken slope, added mass", support::with_water(lift_joint()), true),
        ("straight slope", straight(), false),
    ];
    for (name, dam, flutters) in variants {
        let expected = dam.flutter([SPECIFIC_WEIGHT, 0.0])?[0];
        // what grows stays small, so that no contact opens, and what decays is seen for longer
        let history = sliding(&dam, if flutters { 1e-4 } else { 1e-2 })?;
        let off = |z: &Complex<f64>| {
            (z.re / expected.growth - 1.0).abs().max((z.im / expected.frequency - 1.0).abs())
        };
        let nearest = exponents(&history[10..], 12).into_iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        let found = nearest.ok_or(DamError::Singular)?;
        println!(
            "{name}: growth {:.3} 1/s at {:.2} rad/s, in time {:.3} 1/s at {:.2} rad/s",
            expected.growth, expected.frequency, found.re, found.im
        );
        assert!(expected.downstream && (expected.growth > 0.0) == flutters && off(&found) < 0.05);
    }
    Ok(())
}

/// Blocks that tip over do not slide steadily, and an intact dam has none.
#[test]
fn no_steady_sliding_no_flutter() -> Result<(), DamError> {
    let tall = support::koyna(10.0);
    assert_eq!(tall.flutter([SPECIFIC_WEIGHT, 0.0])?, []);
    let intact = DamParameters { fidelity: Fidelity::Intact { modes: None }, ..lift_joint() };
    assert_eq!(intact.flutter([SPECIFIC_WEIGHT, 0.0])?, []);
    Ok(())
}
