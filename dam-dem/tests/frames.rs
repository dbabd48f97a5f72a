//! Equivalence of a moving base and inertia forces in the frame of the base.

use crate::support;

use cofferdam_dam::contact::{ContactStatus, Coulomb, Integration};
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::{CentralDifference, DynamicRelaxation};
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::{DamError, Kinematics, Mesh, Motion, RayleighCoefficients, Section, Structure};
use std::f64::consts::TAU;
use support::{GRAVITY, stiff};

const AMPLITUDE: f64 = 0.3;
const FREQUENCY: f64 = 3.0;

fn ground(time: f64) -> f64 {
    AMPLITUDE * (TAU * FREQUENCY * time).sin()
}

/// Two blocks on a base whose points all move alike: displacements relative to the base equal those in the
/// frame of the base under `−m a_g`. Nothing slips, because rounding could move slip to another step.
/// Stiffness damping only, because mass damping acts on the motion relative to the base.
#[test]
fn a_moving_base_and_its_frame_agree() -> Result<(), DamError> {
    let mesh =
        Mesh::mapped(&Section::rectangle(3.0, 6.0), &[vec![0.0, 1.0, 2.0, 3.0], vec![3.0, 4.5, 6.0]], 3);
    let law = Coulomb { friction: 10.0, normal_stiffness: 1e9, shear_stiffness: 1e9 };
    let base = mesh.base.clone();
    let structure =
        Structure::new(mesh, &stiff(1e9), Kinematics::Corotational, [(law, Integration::Nodal)], &base);
    let damping = RayleighCoefficients { mass: 0.0, stiffness: 1e-4 };
    let step = 0.5 * support::critical(&structure, damping).limit;
    let forces = |a: f64| structure.weight([-a, -GRAVITY]);
    let mut rest = structure.at_rest();
    DynamicRelaxation::default().relax(&structure, &mut rest, &forces(0.0))?;
    let (mut relative, mut moving) = (rest.clone(), rest);
    structure.accelerate(damping, &mut relative, &forces(ground(0.0)));
    structure.accelerate(damping, &mut moving, &forces(0.0));
    let one = CentralDifference { time_step: step, steps: 1 };
    let weight = LoadPath::constant(forces(0.0));
    let (mut velocity, mut displacement) = (0.0, 0.0);
    let (mut worst, mut largest): (f64, f64) = (0.0, 0.0);
    let steps = (1.0 / step) as usize;
    for n in 0..steps {
        let [now, next] = [n, n + 1].map(|n| ground(n as f64 * step));
        let (start, end) = (forces(now), forces(next));
        let change = start.iter().zip(&end).map(|(a, b)| [b[0] - a[0], b[1] - a[1]]).collect();
        one.advance(&structure, damping, &mut relative, &LoadPath { start, change }, &mut Work::default());
        // the base moves by central differences, too
        for &node in &base {
            (moving.velocity[node], moving.acceleration[node]) = ([velocity, 0.0], [now, 0.0]);
        }
        let middle = velocity + 0.5 * step * now;
        one.advance(&structure, damping, &mut moving, &weight, &mut Work::default());
        (displacement, velocity) = (displacement + step * middle, middle + 0.5 * step * next);
        for (u, v) in moving.displacement.iter().zip(&relative.displacement) {
            worst = worst.max((u[0] - displacement - v[0]).abs()).max((u[1] - v[1]).abs());
            largest = largest.max(v[0].abs());
        }
        assert!(!slips(&relative) && !slips(&moving));
    }
    println!(
        "moving base against its frame, 1 s, {steps} steps: {:.1e} of the largest displacement",
        worst / largest
    );
    assert!(worst < 1e-10 * largest);
    Ok(())
}

fn slips(motion: &Motion) -> bool {
    motion.joints[0].iter().any(|joint| joint.status == ContactStatus::Slipping)
}
