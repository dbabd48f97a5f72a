//! Contacts in arbitrary positions: action and reaction, friction limit, no tension.

use crate::support;

use dam_dem::contact::{ContactLaw, Coulomb, Integration, Touch};
use dam_dem::{Kinematics, Mesh, Section, Structure};
use proptest::prelude::*;

const LAW: Coulomb = Coulomb { friction: 0.7, normal_stiffness: 1e9, shear_stiffness: 0.5e9 };

fn two_blocks() -> Structure {
    let mesh = Mesh::mapped(&Section::rectangle(6.0, 2.0), &[vec![0.0, 1.0], vec![1.0, 2.0]], 4);
    Structure::new(mesh, &support::stiff(1e9), Kinematics::Corotational, [(LAW, Integration::Nodal)], &[])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    /// Forces sum to zero; their moment is at most shear force times penetration.
    #[test]
    fn action_is_reaction(
        shifts in prop::collection::vec((-0.3f64..0.3, -0.02f64..0.02), 10),
        speeds in prop::collection::vec((-1.0f64..1.0, -1.0f64..1.0), 10),
        slide in -2.0f64..2.0,
    ) {
        let structure = two_blocks();
        let crack = &structure.cracks[0];
        let mut motion = structure.at_rest();
        let nodes: Vec<usize> = crack.sides().concat();
        for (i, &node) in nodes.iter().enumerate() {
            motion.displacement[node] = [shifts[i].0 + if i >= 5 { slide } else { 0.0 }, shifts[i].1];
            motion.velocity[node] = speeds[i].into();
        }
        let mut forces = vec![[0.0; 2]; structure.mesh.nodes.len()];
        let (rest, u, v) = (&structure.mesh.nodes, &motion.displacement, &motion.velocity);
        crack.add_forces(u, v, 1e-3, &mut motion.joints[0], &mut forces);
        let (mut sum, mut moment, mut size) = ([0.0; 2], 0.0, 0.0);
        for &node in &nodes {
            let [x, y] = [rest[node][0] + u[node][0], rest[node][1] + u[node][1]];
            let f = forces[node];
            sum = [sum[0] + f[0], sum[1] + f[1]];
            moment += x * f[1] - y * f[0];
            size += f[0].hypot(f[1]);
        }
        let deepest = motion.joints[0].iter().map(|joint| -joint.gap).fold(0.0, f64::max);
        prop_assert!(sum[0].abs().max(sum[1].abs()) <= 1e-12 * size);
        prop_assert!(moment.abs() <= LAW.friction * size * deepest + 1e-11 * size);
    }

    /// |T| ≤ μN, 0 ≤ N ≤ twice the spring force; slip never increases the energy of springs, and dashpots never add energy.
    #[test]
    fn coulomb_keeps_its_limits(
        penetration in -1e-3f64..1e-3, penetration_rate in -5.0f64..5.0,
        stretch in -1e-2f64..1e-2, slip_rate in -5.0f64..5.0, damping in 0.0f64..1e-3,
    ) {
        let touch = Touch { penetration, penetration_rate, stretch, slip_rate, damping, bonded: false };
        let response = LAW.respond(&touch);
        prop_assert!(response.normal >= 0.0);
        let spring = LAW.normal_stiffness * penetration.max(0.0);
        prop_assert!(response.normal <= 2.0 * spring * (1.0 + 1e-15));
        prop_assert!(response.shear.abs() <= LAW.friction * response.normal * (1.0 + 1e-15));
        prop_assert!(response.stretch.abs() <= stretch.abs());
        prop_assert!(penetration > 0.0 || response.normal == 0.0);
        let power = response.dashpots[0] * penetration_rate + response.dashpots[1] * slip_rate;
        prop_assert!(power >= 0.0);
    }
}
