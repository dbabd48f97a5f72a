//! Stiffness damping with a memory: limit of stability, energy, and convergence to damping without memory.

use crate::support;

use cofferdam_dam::contact::Coulomb;
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::CentralDifference;
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::{
    Dam, DamError, DamParameters, DampingCoefficients, Kinematics, Mesh, Motion, RayleighCoefficients,
    Section, Structure,
};
use cofferdam_unit::variables::dam as variable;
use nalgebra::DMatrix;

/// A column of `cells` cells on the ground.
fn column(cells: usize) -> Structure {
    let rows: Vec<f64> = (0..=cells).map(|i| i as f64).collect();
    let mesh = Mesh::mapped(&Section::rectangle(1.3, cells as f64), &[rows], 1);
    let base = mesh.base.clone();
    Structure::<Coulomb>::new(mesh, &support::stiff(31e9), Kinematics::Small, [], &base)
}

fn with_memory(mass: f64, stiffness: f64, memory: f64) -> DampingCoefficients {
    DampingCoefficients {
        rayleigh: RayleighCoefficients { mass, stiffness },
        memory,
        ..DampingCoefficients::NONE
    }
}

fn free(structure: &Structure) -> Vec<usize> {
    (0..structure.mesh.nodes.len()).filter(|&i| !structure.is_fixed(i)).collect()
}

/// All values of a motion that change in a time step: displacements, velocities, accelerations and damping stresses.
fn values<'a>(structure: &Structure, motion: &'a mut Motion) -> Vec<&'a mut f64> {
    let free = free(structure);
    let nodes = |field: &'a mut Vec<[f64; 2]>| {
        let moving = field.iter_mut().enumerate().filter(|(i, _)| free.contains(i));
        moving.flat_map(|(_, value)| value.iter_mut()).collect::<Vec<_>>()
    };
    let mut all = nodes(&mut motion.displacement);
    all.extend(nodes(&mut motion.velocity));
    all.extend(nodes(&mut motion.acceleration));
    let stresses = motion.viscous.iter_mut().flatten().flatten();
    all.extend(stresses.map(|lanes| &mut lanes[0]));
    all
}

/// Largest absolute eigenvalue of the map of one time step, from its powers.
fn amplification(structure: &Structure, damping: DampingCoefficients, share: f64) -> f64 {
    let time_step = share * support::critical(structure, damping).limit;
    let still = LoadPath::constant(structure.weight([0.0; 2]));
    let free = 2 * free(structure).len();
    // units: displacement in m, velocity in m/step, acceleration in m/step², stress as the acceleration that
    // it causes
    let mass = structure.mass[structure.mesh.nodes.len() - 1];
    let unit = |i: usize| match i / free {
        0 => 1.0,
        1 => 1.0 / time_step,
        2 => 1.0 / (time_step * time_step),
        _ => mass / (time_step * time_step),
    };
    let size = values(structure, &mut structure.at_rest()).len();
    let columns: Vec<Vec<f64>> = (0..size)
        .map(|i| {
            let mut motion = structure.at_rest();
            *values(structure, &mut motion)[i] = unit(i);
            let one = CentralDifference { time_step, steps: 1 };
            one.advance(structure, damping, &mut motion, &still, &mut Work::default());
            values(structure, &mut motion).iter().enumerate().map(|(j, x)| **x / unit(j)).collect()
        })
        .collect();
    let mut power = DMatrix::from_fn(size, size, |i, j| columns[j][i]);
    // ‖Aⁿ‖^(1/n) at n = 2²⁶ steps, by squaring
    let mut logarithm = 0.0;
    for _ in 0..26 {
        let norm = power.norm();
        power /= norm;
        power = &power * &power;
        logarithm = 2.0 * (logarithm + norm.ln());
    }
    ((logarithm + power.norm().ln()) / 2f64.powi(26)).exp()
}

/// The map of one step just below and just above the limit. Tolerance: the power of 2²⁶ steps, of a map with
/// entries of 1e6, has an error of 14/2²⁶.
#[test]
fn the_limit_is_that_of_the_true_amplification() {
    for (mass, stiffness, memory) in [
        (0.0, 1e-4, 0.0),
        (0.0, 1e-4, 0.5),
        (50.0, 1e-4, 0.5),
        (0.0, 1e-3, 0.8),
        (20.0, 0.0, 0.8),
        (0.0, 1e-5, 0.9),
    ] {
        let (structure, damping) = (column(1), with_memory(mass, stiffness, memory));
        let [below, above] = [0.999, 1.001].map(|share| amplification(&structure, damping, share));
        let ratio = damping.rayleigh.ratio_at(support::critical(&structure, damping).highest_frequency);
        println!(
            "ξ = {ratio:.1e}, m = {memory}: largest |z| {below:.5} at 0.999, {above:.5} at 1.001 of the limit"
        );
        assert!(below < 1.0 + 1e-6 && above > 1.0 + 1e-5);
    }
}

/// A column vibrates freely in all its modes. The initial energy equals the damping work plus the remaining
/// energy, except for the error (ωΔt)²/8 of central differences, which decreases with the square of the time
/// step.
#[test]
fn the_ledger_closes_with_memory() {
    let mut errors = Vec::new();
    for share in [0.4, 0.2, 0.1] {
        let (structure, damping) = (column(6), with_memory(0.0, 2e-4, 0.7));
        let mut motion = structure.at_rest();
        for (i, v) in motion.velocity.iter_mut().enumerate().filter(|(i, _)| !structure.is_fixed(*i)) {
            *v = [(3.0 * i as f64).sin(), (7.0 * i as f64).cos()];
        }
        let still = LoadPath::constant(structure.weight([0.0; 2]));
        structure.accelerate(damping, &mut motion, &still.start);
        let start = structure.kinetic_energy(&motion);
        let steps = CentralDifference::covering(5e-3, share * support::critical(&structure, damping).limit);
        let mut work = Work::default();
        steps.advance(&structure, damping, &mut motion, &still, &mut work);
        let left = structure.kinetic_energy(&motion) + structure.strain_energy(&motion);
        errors.push(((start - left - work.damping) / start).abs());
        println!(
            "{} steps: {:.1e} of the energy remains, balance error {:.1e}",
            steps.steps,
            left / start,
            errors[errors.len() - 1]
        );
        assert!(left < 0.9 * start && work.damping > 0.0);
    }
    assert!(errors[2] < 0.1 * errors[0] && errors[2] < 1e-2);
}

/// The first half-cycle of a column, against the result without memory and with a twentieth of the time step.
/// The error is of first order in the time step: damping lags by half a step plus the time of the memory.
#[test]
fn memory_fades_with_the_time_step() {
    let top = |memory: f64, time_step: f64| {
        let (structure, damping) = (column(20), with_memory(0.0, 5e-4, memory));
        let mut motion = structure.at_rest();
        let push = LoadPath::constant(structure.weight([10.0, 0.0]));
        structure.accelerate(damping, &mut motion, &push.start);
        let steps = CentralDifference::covering(0.1, time_step);
        steps.advance(&structure, damping, &mut motion, &push, &mut Work::default());
        motion.velocity[structure.mesh.nodes.len() - 2][0]
    };
    let limit = support::critical(&column(20), with_memory(0.0, 5e-4, 0.0)).limit;
    let exact = top(0.0, limit / 20.0);
    let errors = [1.0, 0.5, 0.25].map(|share| (top(0.5, share * limit) / exact - 1.0).abs());
    let orders = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
    println!("velocity of the top {exact:.5} m/s, errors {errors:?}, orders {orders:.2?}");
    assert!(orders.iter().all(|order| (0.85..1.6).contains(order)) && errors[0] < 1e-3);
}

/// A dam uses the memory that its damping requires. It slides by the same distance with time steps a ninth as
/// long, with which the same memory lasts a ninth of the time. Tolerance: 1 %, about the change if the time
/// step is halved.
#[test]
fn sliding_with_memory_hardly_depends_on_the_time_step() -> Result<(), DamError> {
    let slid = |safety: f64| -> Result<(Dam, f64), DamError> {
        let mut dam = support::at_rest(DamParameters { time_step_safety: safety, ..support::koyna(5.0) })?;
        support::shake(&mut dam, 2.5e-3, 3.0, support::bursts)?;
        let sliding = support::get(&dam, &variable::CRACK_SLIDING)[0];
        Ok((dam, sliding))
    };
    let (dam, sliding) = slid(0.9)?;
    let (_, fine) = slid(0.1)?;
    let memory = dam.damping_coefficients().memory;
    println!(
        "m = {memory:.3}, {} time steps in 2.5 ms: sliding {sliding:.5} m, with steps a ninth as long {fine:.5} m",
        dam.time_steps_per(2.5e-3)
    );
    assert!(memory > 0.0 && sliding.abs() > 0.01 && (sliding / fine - 1.0).abs() < 0.01);
    Ok(())
}

/// The solution of the state of rest leaves no rates and dashpot stresses in the contacts.
#[test]
fn rest_remembers_no_motion() -> Result<(), DamError> {
    let dam = support::at_rest(support::koyna(5.0))?;
    let joints = dam.state().motion().joints().iter().flatten();
    assert!(dam.damping_coefficients().memory > 0.0);
    for joint in joints {
        assert_eq!((joint.rates, joint.dashpots), ([0.0; 2], [0.0; 2]));
    }
    Ok(())
}
