//! Bonded, weakening and dilating joints with both kinds of integration, against closed forms.

use crate::support;

use cofferdam_dam::contact::{ContactLaw, ContactStatus, Coulomb, Crack, Integration, MohrCoulomb, Touch};
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::{CentralDifference, DynamicRelaxation};
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::{
    CrackParameters, DamError, DamParameters, Kinematics, Mesh, Motion, RayleighCoefficients, Section,
    Structure,
};
use cofferdam_unit::variables::dam as variable;

const STIFFNESS: f64 = 1e9;
const WIDTH: f64 = 3.0;

fn law(cohesion: f64, tensile_strength: f64) -> MohrCoulomb {
    MohrCoulomb {
        residual: Coulomb { friction: 0.5, normal_stiffness: STIFFNESS, shear_stiffness: STIFFNESS },
        friction: 0.8,
        cohesion,
        tensile_strength,
        dilation: 0.0,
        dilation_slip: f64::INFINITY,
    }
}

/// Two blocks 3 m wide and 1 m high, the lower one fixed, at rest under `load` (Pa) on top.
fn blocks(
    law: MohrCoulomb,
    integration: Integration,
    load: [f64; 2],
) -> (Structure<MohrCoulomb>, Vec<[f64; 2]>) {
    let mesh = Mesh::mapped(&Section::rectangle(WIDTH, 2.0), &[vec![0.0, 1.0], vec![1.0, 2.0]], 3);
    let fixed: Vec<usize> = mesh.blocks[0].nodes.clone().collect();
    let cracks = [(law, integration)];
    let structure = Structure::new(mesh, &support::stiff(1e10), Kinematics::Corotational, cracks, &fixed);
    let mut forces = structure.weight([0.0; 2]);
    let bottom = structure.mesh.seams[0].upper.clone();
    for (&node, length) in bottom.iter().zip(structure.mesh.tributary_lengths(&bottom)) {
        (0..2).for_each(|d| forces[node][d] += load[d] * length);
    }
    (structure, forces)
}

fn rest(law: MohrCoulomb, integration: Integration, load: [f64; 2]) -> Result<Motion, DamError> {
    let (structure, forces) = blocks(law, integration, load);
    let mut motion = structure.at_rest();
    DynamicRelaxation { max_iterations: 20_000, ..Default::default() }.relax(
        &structure,
        &mut motion,
        &forces,
    )?;
    Ok(motion)
}

/// Below its strength a bond carries tension and shear like springs. Above its strength it carries no
/// tension, and shear only by friction.
#[test]
fn a_bond_holds_up_to_its_strength() {
    let bonded = law(3e5, 2e5);
    for integration in [Integration::Nodal, Integration::Gauss] {
        let pulled = rest(bonded, integration, [0.0, 1.9e5]).expect("the bond holds");
        let joints = &pulled.joints[0];
        let errors = joints.iter().map(|joint| (joint.gap * STIFFNESS / 1.9e5 - 1.0).abs());
        assert!(errors.fold(0.0, f64::max) < 1e-6 && joints.iter().all(|joint| joint.bonded));
        assert!(rest(bonded, integration, [0.0, 2.1e5]).is_err(), "the bond breaks in tension");
        // compression adds friction: 3e5 + 0.8 × 1e5
        let sheared = rest(bonded, integration, [3.7e5, -1e5]).expect("the bond holds");
        let held = |joint: &cofferdam_dam::contact::JointState| {
            joint.bonded && joint.status == ContactStatus::Sticking
        };
        assert!(sheared.joints[0].iter().all(held));
        assert!(
            rest(bonded, integration, [3.9e5, -1e5]).is_err(),
            "the bond breaks in shear: residual friction carries 0.5e5 only"
        );
    }
}

/// A weakening joint sticks up to its peak friction; afterwards it has its residual friction permanently.
#[test]
fn friction_falls_from_peak_to_residual() {
    let weakening = law(0.0, 0.0);
    let touch = |stretch: f64, bonded: bool| Touch {
        penetration: 1e-4,
        penetration_rate: 0.0,
        stretch,
        slip_rate: 0.0,
        damping: 0.0,
        bonded,
    };
    assert!(weakening.is_bonded());
    let peak = weakening.respond(&touch(0.79e-4, true));
    assert!(peak.bonded && !peak.slipping && (peak.shear - 0.79e5).abs() < 1e-6);
    let after = weakening.respond(&touch(0.81e-4, true));
    assert!(!after.bonded && after.slipping && (after.shear - 0.5e5).abs() < 1e-6);
    assert!((weakening.respond(&touch(0.7e-4, after.bonded)).shear - 0.5e5).abs() < 1e-6);
}

/// A block that is pushed along a dilating joint rises by tan ψ times its slip up to `dilation_slip`, and the
/// energy balance closes: work of the push = friction + springs + work against the load.
#[test]
fn a_dilating_joint_lifts_its_block() -> Result<(), DamError> {
    let mut dilating = law(0.0, 0.0);
    (dilating.friction, dilating.dilation, dilating.dilation_slip) = (0.5, 0.1, 0.02);
    for integration in [Integration::Nodal, Integration::Gauss] {
        let (structure, pressed) = blocks(dilating, integration, [0.0, -1e5]);
        let damping = RayleighCoefficients { mass: 0.0, stiffness: 1e-4 };
        let mut motion = structure.at_rest();
        DynamicRelaxation::default().relax(&structure, &mut motion, &pressed)?;
        let start = support::mean(&structure, &motion.displacement, 1);
        let stored = structure.stored_energy(&motion);
        let (_, pushed) = blocks(dilating, integration, [0.7e5, -1e5]);
        structure.accelerate(damping, &mut motion, &pushed);
        let steps = CentralDifference::covering(0.12, 0.2 * support::critical(&structure, damping).limit);
        let mut work = Work::default();
        steps.advance(&structure, damping, &mut motion, &LoadPath::constant(pushed), &mut work);
        let now = structure.stored_energy(&motion);
        let end = support::mean(&structure, &motion.displacement, 1);
        let (slip, rise) = (end[0] - start[0], end[1] - start[1]);
        let gained = now.kinetic + now.strain + now.contact - stored.kinetic - stored.strain - stored.contact;
        let balance = (work.input - work.friction - work.damping - gained) / work.input;
        println!("{integration:?}: slip {slip:.5} m, rise {rise:.6} m, balance {balance:.1e} of the input");
        assert!(slip > 0.03 && (rise / 0.002 - 1.0).abs() < 0.02 && balance.abs() < 2e-3);
    }
    Ok(())
}

/// Where sides that have dilated by 20 mm turn while a block slides over an end and back, the forces do the work that springs
/// and friction take. Their moment is that of the overlap, not that of the rise.
#[test]
fn sides_that_turn_while_dilated_do_no_other_work() {
    let mut dilating = law(0.0, 0.0);
    (dilating.friction, dilating.dilation, dilating.dilation_slip) = (0.5, 0.1, 0.2);
    for integration in [Integration::Nodal, Integration::Gauss] {
        let mesh = Mesh::mapped(&Section::rectangle(WIDTH, 2.0), &[vec![0.0, 1.0], vec![1.0, 2.0]], 3);
        let structure = Structure::new(
            mesh,
            &support::stiff(1e10),
            Kinematics::Corotational,
            [(dilating, integration)],
            &[],
        );
        let (rest, crack) = (&structure.mesh.nodes, &structure.cracks[0]);
        let mut motion = structure.at_rest();
        let mut forces = vec![[0.0; 2]; rest.len()];
        let (mut work, mut friction, mut worst, mut allowed) = (0.0, 0.0, 0.0f64, 0.0f64);
        let steps = 8000;
        for step in 0..=steps {
            // slides to 0.25 m with the rise, then both sides turn while it slides a little to and fro
            let t = f64::from(step) / f64::from(steps);
            let slid = 0.25 * (4.0 * t).min(1.0);
            let phase = 12.0 * std::f64::consts::PI * (t - 0.25).max(0.0);
            let (slide, turn) = (slid + 2e-3 * phase.sin(), 2e-3 * (phase.cos() - 1.0));
            let (sin, cos) = f64::sin_cos(turn);
            let earlier = forces.clone();
            let before = motion.displacement.clone();
            for (node, &[x, y]) in rest.iter().enumerate() {
                let above = structure.mesh.blocks[1].nodes.contains(&node);
                let (x_now, y_now) = if above { (x + slide, y + 0.1 * slid.min(0.2) - 1e-4) } else { (x, y) };
                let (a, b) = (x_now - 1.5, y_now - 1.0);
                motion.displacement[node] = [1.5 + cos * a - sin * b - x, 1.0 + sin * a + cos * b - y];
            }
            forces.fill([0.0; 2]);
            let (u, v, joints) = (&motion.displacement, &motion.velocity, &mut motion.joints[0]);
            let losses = crack.add_forces(u, v, 0.0, joints, &mut forces);
            let [mut moment, mut size] = [0.0; 2];
            for (node, &[x, y]) in rest.iter().enumerate() {
                let [fx, fy] = forces[node];
                moment += (x + u[node][0]) * fy - (y + u[node][1]) * fx;
                size += fx.abs();
                for d in 0..2 {
                    work -= (earlier[node][d] + forces[node][d]) / 2.0 * (u[node][d] - before[node][d]);
                }
            }
            let overlap = joints.iter().map(|joint| joint.penetration).fold(0.0, f64::max);
            if step == 0 {
                work = crack.energy(joints);
                continue;
            }
            (worst, allowed) = (worst.max(moment.abs()), allowed.max(size * overlap));
            friction += losses.friction;
        }
        let gap = (work - crack.energy(&motion.joints[0]) - friction) / friction;
        println!(
            "{integration:?}: gap {gap:.1e} of {friction:.3e} J/m, moment {worst:.0} N, shear × overlap {allowed:.0} N"
        );
        assert!(gap.abs() < 2e-5 && worst < allowed);
    }
}

/// A dam with a crack that is too strong to fail moves like the intact dam, with both kinds of integration.
#[test]
fn a_bond_that_never_fails_makes_an_intact_dam() -> Result<(), DamError> {
    let crest = |parameters: DamParameters| -> Result<Vec<f64>, DamError> {
        let mut dam = support::at_rest(parameters)?;
        let mut crest = Vec::new();
        for step in 1..=80 {
            support::shake(&mut dam, 0.0025, 0.025 * f64::from(step), support::bursts)?;
            crest.push(support::get(&dam, &variable::CREST_DISPLACEMENT)[0]);
        }
        let sliding = support::get(&dam, &variable::CRACK_SLIDING);
        assert!(sliding.iter().all(|sliding| sliding.abs() < 1e-4));
        Ok(crest)
    };
    let intact = crest(DamParameters { cracks: vec![], ..support::koyna(10.0) })?;
    let largest = intact.iter().fold(0.0f64, |a, b| a.max(b.abs()));
    for integration in [Integration::Nodal, Integration::Gauss] {
        let bonded = CrackParameters {
            cohesion: 1e12,
            tensile_strength: 1e12,
            normal_stiffness: 1e13,
            shear_stiffness: 1e13,
            integration,
            ..support::crack_at(66.5)
        };
        let strong = crest(DamParameters { cracks: vec![bonded], ..support::koyna(10.0) })?;
        let apart = strong.iter().zip(&intact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest;
        println!("{integration:?}: bonded crack against none, crest apart by {apart:.1e} of its largest");
        assert!(apart < 0.02);
    }
    Ok(())
}

/// Closure under uniform pressure: 1e-6 for matching meshes, 0.5 % for others, with either integration.
#[test]
fn joints_close_by_pressure_over_stiffness() -> Result<(), DamError> {
    let coulomb = Coulomb { friction: 0.5, normal_stiffness: 1e9, shear_stiffness: 1e9 };
    for integration in [Integration::Nodal, Integration::Gauss] {
        let matching = rest(law(0.0, 0.0), integration, [0.0, -1e5])?;
        let error = matching.joints[0].iter().map(|joint| (-joint.gap * STIFFNESS / 1e5 - 1.0).abs());
        let error = error.fold(0.0, f64::max);
        // stiff blocks, so that the pressure below is uniform; the ground is wider than the block
        let structure = support::block_on_ground([3.0, 0.6], 1e13, coulomb, integration);
        let mut motion = structure.at_rest();
        let weight = structure.weight([0.0, -support::GRAVITY]);
        DynamicRelaxation::default().relax(&structure, &mut motion, &weight)?;
        let closure = 2500.0 * 0.6 * support::GRAVITY / 1e9;
        let mean = -support::mean(&structure, &motion.displacement, 1)[1];
        println!("{integration:?}: closure, matching {error:.1e}, others {:.1e}", mean / closure - 1.0);
        assert!(error < 1e-6 && (mean / closure - 1.0).abs() < 5e-3);
    }
    Ok(())
}

/// With both kinds of integration, points that slid past the end and came back are in contact again.
#[test]
fn points_are_lost_and_found() {
    let mesh = Mesh::mapped(&Section::rectangle(4.0, 2.0), &[vec![0.0, 1.0], vec![1.0, 2.0]], 4);
    for integration in [Integration::Nodal, Integration::Gauss] {
        let crack = Crack::new(&mesh, &mesh.seams[0], law(1e5, 1e5), integration);
        let mut joints = crack.joints_at_rest();
        let still = vec![[0.0; 2]; mesh.nodes.len()];
        let mut press = |slide: f64| {
            let mut u = still.clone();
            mesh.seams[0].upper.iter().for_each(|&node| u[node] = [slide, -1e-4]);
            let mut forces = still.clone();
            crack.add_forces(&u, &still, 0.0, &mut joints, &mut forces);
            let lost = joints.iter().filter(|joint| joint.status == ContactStatus::Lost).count();
            (
                mesh.seams[0].upper.iter().map(|&node| forces[node][1]).sum::<f64>(),
                lost,
                joints.iter().filter(|j| j.bonded).count(),
            )
        };
        let (whole, none, bonded) = press(0.0);
        let (part, some, _) = press(1.5);
        let (again, found, still_bonded) = press(0.0);
        println!(
            "{integration:?}: {whole:.1}, after sliding {part:.1} with {some} contacts lost, after return {again:.1} N/m"
        );
        assert!((none, found) == (0, 0) && some >= 4 && bonded > 0 && still_bonded == 0);
        assert!(
            (whole / (1e-4 * STIFFNESS * 4.0) - 1.0).abs() < 1e-12 && (again / whole - 1.0).abs() < 1e-12
        );
        assert!((part / whole - 2.5 / 4.0).abs() < 1e-3);
    }
}
