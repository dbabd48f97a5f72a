//! Added mass in the mass matrix: frequencies, forces, energy and motion against independent computations.

use crate::support;

use cofferdam_dam::{AddedMass, Dam, DamError, DamParameters, Damping, Kinematics, Material, Section};
use cofferdam_unit::{CoSimulation, WetFace, variables::dam as variable};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use std::f64::consts::PI;

const WATER: f64 = 1000.0;

/// Westergaard's added mass `⅞ ρ √(h(h − y))` at the points.
pub fn westergaard(face: &WetFace) -> Vec<Vec<f64>> {
    let h = face.depth();
    let mass = |i: usize| 0.875 * WATER * (h * (h - face.points()[i][1])).sqrt();
    let row = |i: usize| (0..face.len()).map(|j| if i == j { mass(i) } else { 0.0 }).collect();
    (0..face.len()).map(row).collect()
}

/// Incompressible water before a vertical face by its modes, which gives a full matrix: for the motion N_j
/// `p(y) = −ρ Σ_m 2/(h λ_m) cos λ_m y ∫ cos(λ_m y′) N_j dy′`.
pub fn incompressible(face: &WetFace) -> Vec<Vec<f64>> {
    let (h, points) = (face.depth(), face.points());
    let mut rows = vec![vec![0.0; points.len()]; points.len()];
    for m in 0..60 {
        let lambda = f64::from(2 * m + 1) * PI / (2.0 * h);
        let mut integrals = vec![0.0; points.len()];
        for panel in face.panels() {
            for k in 0..100 {
                let along = (f64::from(k) + 0.5) / 100.0;
                let y = points[panel.start][1] + along * panel.length;
                let part = (lambda * y).cos() * panel.length / 100.0;
                integrals[panel.start] += (1.0 - along) * part;
                integrals[panel.start + 1] += along * part;
            }
        }
        for (row, point) in rows.iter_mut().zip(points) {
            let factor = WATER * 2.0 / (h * lambda) * (lambda * point[1]).cos();
            row.iter_mut().zip(&integrals).for_each(|(a, integral)| *a += factor * integral);
        }
    }
    rows
}

pub fn with_water(parameters: &DamParameters, water: fn(&WetFace) -> Vec<Vec<f64>>) -> DamParameters {
    let face = parameters.wet_face().unwrap().unwrap();
    DamParameters { added_mass: Some(water(&face)), ..parameters.clone() }
}

pub fn intact(element_size: f64) -> DamParameters {
    DamParameters { cracks: Vec::new(), ..support::koyna(element_size) }
}

pub fn dense(size: usize, entries: &[(usize, usize, f64)]) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(size, size);
    entries.iter().for_each(|&(i, j, value)| matrix[(i, j)] += value);
    matrix
}

/// `½ (B A N + (B A N)ᵀ)` from the matrices of the dam without water.
pub fn water_mass(dam: &Dam, rows: &[Vec<f64>]) -> DMatrix<f64> {
    let m = dam.system_matrices();
    let (size, points) = (m.mass.len(), rows.len());
    let (mut b, mut n) = (DMatrix::<f64>::zeros(size, points), DMatrix::<f64>::zeros(points, size));
    m.pressure_forces.iter().for_each(|&(dof, point, value)| b[(dof, point)] += value);
    m.interface_motion.iter().for_each(|&(point, dof, value)| n[(point, dof)] += value);
    let x = b * DMatrix::from_fn(points, points, |i, j| rows[i][j]) * n;
    (&x + x.transpose()) / 2.0
}

/// Natural frequencies, rad/s, and the first mode of `K φ = ω² M φ`.
pub fn modes(stiffness: &DMatrix<f64>, mass: &DMatrix<f64>) -> (Vec<f64>, DVector<f64>) {
    let lower = mass.clone().cholesky().expect("mass is positive definite").l();
    let half = lower.solve_lower_triangular(stiffness).unwrap();
    let reduced = lower.solve_lower_triangular(&half.transpose()).unwrap();
    let eigen = SymmetricEigen::new((&reduced + reduced.transpose()) / 2.0);
    let mut order: Vec<usize> = (0..mass.nrows()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let first = eigen.eigenvectors.column(order[0]).into_owned();
    let mode = lower.transpose().solve_upper_triangular(&first).unwrap();
    (order.iter().map(|&i| eigen.eigenvalues[i].sqrt()).collect(), mode)
}

/// Frequencies from the matrices of the dam against a dense problem with the matrices of the empty dam and B
/// A N: equal to rounding. The bound on which the time step is based holds. The period of free vibration,
/// which uses no matrix, agrees with these frequencies up to the dispersion (ωΔt)²/24.
#[test]
fn natural_frequencies_with_water() -> Result<(), DamError> {
    let undamped =
        DamParameters { damping: Damping::None, gravity: 0.0, kinematics: Kinematics::Small, ..intact(9.0) };
    let empty = Dam::new(undamped.clone())?;
    let face = empty.wet_face().unwrap().clone();
    let matrices = empty.system_matrices();
    let size = matrices.mass.len();
    let stiffness = dense(size, &matrices.stiffness);
    let concrete = DMatrix::from_diagonal(&DVector::from_vec(matrices.mass.clone()));
    let (dry, _) = modes(&stiffness, &concrete);
    for (name, water) in [("Westergaard", westergaard as fn(&_) -> _), ("incompressible", incompressible)] {
        let (independent, mode) = modes(&stiffness, &(&concrete + water_mass(&empty, &water(&face))));
        let mut dam = Dam::new(with_water(&undamped, water))?;
        let m = dam.system_matrices();
        let (own, _) = modes(&stiffness, &(&concrete + dense(size, &m.added_mass)));
        let difference = (0..size).map(|i| (own[i] / independent[i] - 1.0).abs()).fold(0.0, f64::max);
        println!(
            "{name}: ω = {:.3?} rad/s, empty {:.3?}; the dam's own differ by at most {difference:.1e}",
            &independent[..4],
            &dry[..4]
        );
        assert!(difference < 1e-9);
        let (bound, highest) = (dam.critical_time_step().highest_frequency, own[size - 1]);
        let without = empty.critical_time_step().highest_frequency;
        println!(
            "  highest {highest:.0} rad/s, bound {bound:.0}, without water {without:.0}; least share {:.3}",
            dam.structure().added_mass.as_ref().unwrap().least_share()
        );
        assert!(highest < bound * (1.0 + 1e-9) && bound < 1.1 * without);
        assert_eq!(
            dam.natural_frequencies(2)?,
            empty.natural_frequencies(2)?,
            "natural frequencies must be those with an empty reservoir"
        );

        // free vibration from the shape of the first mode
        dam.initialise(0.0)?;
        let mut motion = dam.state().motion().of_nodes().unwrap().clone();
        let mut free = 0;
        for node in 0..dam.node_count() {
            if !dam.structure().is_fixed(node) {
                motion.displacement[node] = [0, 1].map(|d| 1e-3 * mode[free + d] / mode[m.crest[0]]);
                free += 2;
            }
        }
        let crest = *dam.structure().mesh.upstream.last().unwrap();
        let measured = period(&dam, motion, crest);
        let error = measured * independent[0] / (2.0 * PI) - 1.0;
        println!("  period of free vibration in the first mode off by {error:+.1e}");
        assert!(error.abs() < 1e-4);
    }
    Ok(())
}

/// A tenth of the time between the first and the eleventh positive zero crossing of the crest displacement, s.
fn period(dam: &Dam, mut motion: cofferdam_dam::Motion, crest: usize) -> f64 {
    let (structure, damping) = (dam.structure(), dam.damping_coefficients());
    let still = vec![[0.0; 2]; dam.node_count()];
    structure.accelerate(damping, &mut motion, &still);
    let loads = cofferdam_dam::loads::LoadPath::constant(still);
    let one =
        cofferdam_dam::integrator::CentralDifference { time_step: 0.5 * dam.time_step_limit(), steps: 1 };
    let (mut crossings, mut time) = (Vec::new(), 0.0);
    while crossings.len() < 11 {
        let before = motion.displacement[crest][0];
        one.advance(structure, damping, &mut motion, &loads, &mut cofferdam_dam::energy::Work::default());
        let after = motion.displacement[crest][0];
        if before < 0.0 && after >= 0.0 {
            crossings.push(time + one.time_step * before / (before - after));
        }
        time += one.time_step;
    }
    (crossings[10] - crossings[0]) / 10.0
}

/// A block is accelerated to 1 m/s² within 3 s, so smoothly that it hardly vibrates. The force on the ground
/// is `(m + m_w) a`, with m_w = 7/12 ρh² or 14ζ(3)/π³ ρh². The error of a concave pressure profile that is
/// linear along each of 40 panels is about 1e-3, that of the vibration about 1e-4.
#[test]
fn the_ground_moves_the_mass_of_the_water() -> Result<(), DamError> {
    let (width, height) = (10.0, 40.0);
    let block = DamParameters {
        section: Section::rectangle(width, height),
        water_depth: height,
        cracks: Vec::new(),
        material: Material { density: 2400.0, ..Default::default() },
        damping: Damping::None,
        gravity: 0.0,
        element_size: 1.0,
        ..support::koyna(1.0)
    };
    let face = block.wet_face()?.unwrap();
    for (water, exact) in [(westergaard as fn(&_) -> _, 7.0 / 12.0), (incompressible, 0.542_755)] {
        let mut dam = Dam::new(with_water(&block, water))?;
        assert_eq!(support::get(&dam, &variable::ADDED_MASS_INCLUDED), [1.0]);
        dam.initialise(0.0)?;
        for n in 1..=300 {
            let share = f64::from(n) / 300.0;
            let a = share - (2.0 * PI * share).sin() / (2.0 * PI);
            dam.set(variable::GROUND_ACCELERATION.value_reference, &[a, 0.0])?;
            dam.step(dam.state().time(), 0.01)?;
        }
        let mut elements = vec![[0.0; 2]; dam.node_count()];
        let mut motion = dam.state().motion().of_nodes().unwrap().clone();
        dam.structure().add_internal_forces(&mut motion, 0.0, &mut elements);
        let base = &dam.structure().mesh.base;
        let base_mass: f64 = base.iter().map(|&n| dam.structure().mass[n]).sum();
        // the heel is fixed and moves its own part of the water
        let rows = water(&face);
        let pushed = |point: usize| rows[point].iter().sum::<f64>();
        let met = |point: usize| {
            let mut motion = vec![0.0; face.len()];
            motion[point] = 1.0;
            let pressure: Vec<f64> =
                rows.iter().map(|row| row.iter().zip(&motion).map(|(a, m)| a * m).sum()).collect();
            face.nodal_forces(&pressure).iter().map(|f| f[0]).sum::<f64>()
        };
        let pressure: Vec<f64> = (0..face.len()).map(pushed).collect();
        let heel = (face.nodal_forces(&pressure)[0][0] + met(0)) / 2.0;
        let ground = base_mass + heel - base.iter().map(|&n| elements[n][0]).sum::<f64>();
        let concrete = 2400.0 * width * height;
        let error = (ground - concrete) / (exact * WATER * height * height) - 1.0;
        println!("force of the water on the ground: {error:+.1e} off {exact:.6} ρah²");
        assert!(error.abs() < 2e-3);
    }
    Ok(())
}

/// Undamped intact dam, 30 s of free vibration: total energy in the second half against that in the first half.
/// Tolerance: as without water, `free_vibration_keeps_its_energy_for_a_minute`.
#[test]
fn free_vibration_keeps_the_energy_of_dam_and_water() -> Result<(), DamError> {
    let undamped = DamParameters { damping: Damping::None, ..intact(10.0) };
    let mut dam = support::at_rest(with_water(&undamped, westergaard))?;
    support::shake(&mut dam, 5e-3, 0.5, |time| 3.0 * (12.0 * time).sin() * f64::from(time < 0.45))?;
    let mut means = [0.0; 2];
    let input = dam.state().energy().work.input;
    let mut worst = 0.0f64;
    for half in &mut means {
        for _ in 0..3000 {
            dam.step(dam.state().time(), 5e-3)?;
            let (gained, work) = (dam.state().energy().gained(), dam.state().energy().work);
            *half += (gained.kinetic + gained.strain - (work.input - input)) / 3000.0;
            worst = worst.max(dam.state().energy().balance_error().abs());
        }
    }
    let growth = means[1] / means[0] - 1.0;
    println!(
        "free vibration with water, 30 s: energy growth {growth:+.1e}, balance {:.1e}",
        worst / means[0]
    );
    assert!(growth.abs() < 1e-5 && worst < 1e-3 * means[0]);
    Ok(())
}

/// The cracked dam under bursts of 0.5 g: the energy balance closes as without water (same tolerance).
#[test]
fn the_ledger_closes_while_the_crack_slides() -> Result<(), DamError> {
    let cracked = support::koyna(5.0);
    for (name, parameters) in [("without", cracked.clone()), ("with", with_water(&cracked, westergaard))] {
        let mut dam = support::at_rest(parameters)?;
        let (mut peak, mut worst) = (0.0f64, 0.0f64);
        while dam.state().time() < 4.0 {
            let until = dam.state().time() + 2.5e-3;
            support::shake(&mut dam, 2.5e-3, until, support::bursts)?;
            peak = peak.max(support::get(&dam, &variable::KINETIC_ENERGY)[0]);
            worst = worst.max(support::get(&dam, &variable::ENERGY_BALANCE_ERROR)[0].abs());
        }
        let sliding = support::get(&dam, &variable::CRACK_SLIDING)[0];
        println!(
            "{name} water: slip {sliding:.3} m, balance error {:.1e} of peak kinetic energy",
            worst / peak
        );
        assert!(worst < 0.01 * peak);
    }
    Ok(())
}

/// Comparison with the trapezoidal rule on dense matrices, with damping, ground motion and an additional
/// pressure. Mass damping acts on the concrete only; the fixed heel also moves water. The error of the dam is
/// of first order in its time step, because damping lags by half a step.
#[test]
fn the_integrator_follows_its_matrices() -> Result<(), DamError> {
    let (step, steps) = (0.01, 10);
    let ground = |t: f64| [3.0 * (20.0 * t).sin(), 1.0 - (15.0 * t).cos()];
    let pressure = |t: f64, y: f64| 2e5 * (30.0 * t).sin() * (1.0 - y / 120.0);
    let mut errors = Vec::new();
    for safety in [0.9, 0.09] {
        let parameters = DamParameters {
            kinematics: Kinematics::Small,
            gravity: 0.0,
            time_step_safety: safety,
            ..intact(15.0)
        };
        let mut dam = Dam::new(with_water(&parameters, incompressible))?;
        let heights: Vec<f64> = dam.wet_face().unwrap().points().iter().map(|p| p[1]).collect();
        dam.initialise(0.0)?;
        for n in 1..=steps {
            let end = f64::from(n) * step;
            let values: Vec<f64> = heights.iter().map(|&y| pressure(end, y)).collect();
            dam.set(variable::INTERFACE_PRESSURE.value_reference, &values)?;
            dam.set(variable::GROUND_ACCELERATION.value_reference, &ground(end))?;
            dam.step(dam.state().time(), step)?;
        }
        let m = dam.system_matrices();
        let size = m.mass.len();
        let concrete = DMatrix::from_diagonal(&DVector::from_vec(m.mass.clone()));
        let stiffness = dense(size, &m.stiffness);
        let damping = &concrete * m.damping.mass + &stiffness * m.damping.stiffness;
        let mass = &concrete + dense(size, &m.added_mass);
        let load = |n: u32| {
            let t = f64::from(n) * step;
            let a = ground(t);
            let mut force = DVector::from_fn(size, |i, _| {
                let inertia = |d: usize| m.mass[i] * m.ground_influence[d][i] + m.added_ground_inertia[d][i];
                -inertia(0) * a[0] - inertia(1) * a[1]
            });
            m.pressure_forces.iter().for_each(|&(i, j, w)| force[i] += w * pressure(t, heights[j]));
            force
        };
        // 400 steps in each communication step: their error for the excited modes is (ωΔt)²/12, below 1e-5
        let (parts, dt) = (400, step / 400.0);
        let solve =
            (&mass + &damping * (dt / 2.0) + &stiffness * (dt * dt / 4.0)).cholesky().unwrap().inverse();
        let (mut u, mut v) = (DVector::zeros(size), DVector::zeros(size));
        let mut a: DVector<f64> = mass.cholesky().unwrap().solve(&load(0));
        for n in 0..steps {
            let (start, end) = (load(n), load(n + 1));
            for k in 1..=parts {
                let share = f64::from(k) / f64::from(parts);
                u += &v * dt + &a * (dt * dt / 4.0);
                v += &a * (dt / 2.0);
                let force = &start * (1.0 - share) + &end * share - &damping * &v - &stiffness * &u;
                a = &solve * force;
                u += &a * (dt * dt / 4.0);
                v += &a * (dt / 2.0);
            }
        }
        let crest = support::get(&dam, &variable::CREST_DISPLACEMENT);
        let exact = m.crest.map(|dof| u[dof]);
        let error = (crest[0] - exact[0]).hypot(crest[1] - exact[1]) / exact[0].hypot(exact[1]);
        println!("safety {safety}: {} time steps, error {error:.2e}", dam.time_steps_per(step));
        errors.push(error);
    }
    assert!(errors[1] < 2e-4 && errors[0] < 5e-3 && errors[1] < 0.2 * errors[0]);
    Ok(())
}

/// With damping and a partly negative added mass (μ < 1), the dam uses the critical time step of its structure.
#[test]
fn the_time_step_is_that_of_the_structure() -> Result<(), DamError> {
    let dam = Dam::new(with_water(&intact(9.0), westergaard))?;
    let (structure, damping) = (dam.structure(), dam.damping_coefficients());
    let least = structure.added_mass.as_ref().map_or(1.0, AddedMass::least_share);
    assert!(least < 1.0 && damping.rayleigh.mass > 0.0);
    assert_eq!(dam.critical_time_step(), support::critical(structure, damping));
    Ok(())
}

#[test]
fn an_added_mass_of_another_face_is_refused() {
    let parameters = intact(10.0);
    let points = parameters.wet_face().unwrap().unwrap().len();
    let error = |water_depth: f64, rows: Vec<Vec<f64>>| {
        Dam::new(DamParameters { water_depth, added_mass: Some(rows), ..parameters.clone() }).unwrap_err()
    };
    let square = vec![vec![0.0; points]; points];
    let mut ragged = square.clone();
    ragged[3].pop();
    let mut nan = square.clone();
    nan[1][2] = f64::NAN;
    let shape = |found, points| DamError::AddedMassShape { found, points };
    assert_eq!(error(91.75, vec![vec![0.0; points]; points - 1]), shape(points - 1, points));
    assert_eq!(error(91.75, ragged), shape(points - 1, points));
    assert_eq!(error(0.0, square), shape(points, 0));
    assert_eq!(error(0.0, Vec::new()), shape(0, 0));
    assert!(shape(0, 0).to_string().contains("leave `added_mass` out"));
    assert!(matches!(error(91.75, nan), DamError::OutOfRange { parameter: "added_mass", .. }));
    let row = |i: usize| (0..points).map(|j| if i == j { -1e5 } else { 0.0 }).collect();
    let negative = error(91.75, (0..points).map(row).collect());
    assert!(matches!(negative, DamError::AddedMassNegative { share, .. } if share > 0.5), "{negative}");
}
