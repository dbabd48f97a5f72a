//! The critical time step is the exact limit of stability.

use crate::support;

use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::{CentralDifference, DynamicRelaxation};
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::{DamError, Kinematics, Mesh, Motion, RayleighCoefficients, Section, Structure};

/// Largest velocity after 4000 steps from `motion`, over the initial velocity of 1e-6 m/s.
fn growth(
    structure: &Structure,
    damping: RayleighCoefficients,
    motion: &Motion,
    gravity: f64,
    share: f64,
) -> f64 {
    let mut motion = motion.clone();
    for (i, v) in motion.velocity.iter_mut().enumerate() {
        if !structure.is_fixed(i) {
            *v = [1e-6 * (3.0 * i as f64).sin(), 1e-6 * (7.0 * i as f64).cos()];
        }
    }
    let loads = LoadPath::constant(structure.weight([0.0, -gravity]));
    let time_step = share * support::critical(structure, damping).limit;
    structure.accelerate(damping, &mut motion, &loads.start);
    let steps = CentralDifference { time_step, steps: 4000 };
    steps.advance(structure, damping, &mut motion, &loads, &mut Work::default());
    let finite = |v: &f64| if v.is_finite() { v.abs() } else { f64::INFINITY };
    motion.velocity.iter().flatten().map(finite).fold(0.0, f64::max) / 1e-6
}

/// With and without damping: bounded at 0.99 of the limit, unstable at 1.05.
#[test]
fn the_critical_time_step_is_sharp() {
    let rows: Vec<f64> = (0..=3).map(f64::from).collect();
    let mesh = Mesh::mapped(&Section::rectangle(4.0, 3.0), &[rows], 4);
    let base = mesh.base.clone();
    let structure = Structure::<Coulomb>::new(mesh, &support::stiff(31e9), Kinematics::Small, [], &base);
    let rest = structure.at_rest();
    for stiffness in [0.0, 1e-5, 1e-3] {
        let damping = RayleighCoefficients { mass: 1.0, stiffness };
        let critical = support::critical(&structure, damping);
        let (stable, unstable) =
            (growth(&structure, damping, &rest, 0.0, 0.99), growth(&structure, damping, &rest, 0.0, 1.05));
        let ratio = damping.ratio_at(critical.highest_frequency);
        println!(
            "ξ = {ratio:.2e} at ω_max: growth {stable:.1e} at 0.99, {unstable:.1e} at 1.05 of the limit"
        );
        assert!(stable < 10.0 && unstable > 1e10);
    }
}

/// The same for a stiff closed joint that determines the highest frequency; growth ends when contacts open.
#[test]
fn joints_count_in_the_critical_time_step() -> Result<(), DamError> {
    let mesh = Mesh::mapped(&Section::rectangle(4.0, 4.0), &[vec![0.0, 2.0], vec![2.0, 4.0]], 2);
    let base = mesh.base.clone();
    let law = Coulomb { friction: 10.0, normal_stiffness: 1e12, shear_stiffness: 1e12 };
    let structure =
        Structure::new(mesh, &support::stiff(31e9), Kinematics::Small, [(law, Integration::Nodal)], &base);
    let mut rest = structure.at_rest();
    let weight = structure.weight([0.0, -9.81]);
    DynamicRelaxation::default().relax(&structure, &mut rest, &weight)?;
    for stiffness in [0.0, 1e-4] {
        let damping = RayleighCoefficients { mass: 0.0, stiffness };
        let (stable, unstable) =
            (growth(&structure, damping, &rest, 9.81, 0.99), growth(&structure, damping, &rest, 9.81, 1.05));
        let highest = support::critical(&structure, damping).highest_frequency;
        println!("joint, ω = {highest:.0} rad/s, β = {stiffness}: growth {stable:.1e}, {unstable:.1e}");
        assert!(stable < 10.0 && unstable > 100.0);
    }
    Ok(())
}
