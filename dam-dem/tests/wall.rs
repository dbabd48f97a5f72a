//! A wall of up to 200 blocks between cracks that cross each other.

use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::CentralDifference;
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::{DampingCoefficients, Kinematics, Structure};

use crate::support::assembly::wall;
use crate::support::{self, momenta};

fn structure(columns: usize, rows: usize, friction: f64, integration: Integration) -> Structure {
    let mesh = wall(columns, rows, 0.6);
    let law = Coulomb { friction, normal_stiffness: 1e9, shear_stiffness: 0.5e9 };
    let laws = vec![(law, integration); columns + rows - 2];
    Structure::new(mesh, &support::stiff(1e9), Kinematics::Corotational, laws, &[])
}

/// A number from −½ to ½ that belongs to a block.
fn random(block: usize, what: usize) -> f64 {
    (((block * 7 + what * 13 + 1) as f64 * 0.754_877_666).fract() * 57.0).fract() - 0.5
}

/// 20 × 10 blocks that nothing holds fly on together and jostle each other: momentum and, without friction, angular momentum
/// stay to rounding, and so does the sum of all contact forces.
#[test]
fn two_hundred_free_blocks_keep_their_momenta() {
    for (friction, integration) in
        [(0.0, Integration::Nodal), (0.0, Integration::Gauss), (0.5, Integration::Nodal)]
    {
        let structure = structure(20, 10, friction, integration);
        assert_eq!(structure.mesh.blocks.len(), 200);
        let mut motion = structure.at_rest();
        for (index, block) in structure.mesh.blocks.iter().enumerate() {
            let first = structure.mesh.nodes[block.nodes.start];
            let [v, w, spin] = [0, 1, 2].map(|what| 0.1 * random(index, what));
            for node in block.nodes.clone() {
                let [x, y] = structure.mesh.nodes[node];
                let jostle = [v - spin * (y - first[1]), w + spin * (x - first[0])];
                motion.velocity[node] = [0.3 - 0.05 * y + jostle[0], 0.2 + 0.05 * x + jostle[1]];
            }
        }
        let (start, size) = momenta(&structure, &motion, [0.0; 2]);
        let none = structure.weight([0.0; 2]);
        structure.accelerate(DampingCoefficients::NONE, &mut motion, &none);
        let steps = CentralDifference::covering(
            0.002,
            0.5 * support::critical(&structure, DampingCoefficients::NONE).limit,
        );
        let loads = LoadPath::constant(none);
        let mut closed = 0;
        for _ in 0..50 {
            steps.advance(&structure, DampingCoefficients::NONE, &mut motion, &loads, &mut Work::default());
            closed = closed.max(motion.joints.iter().flatten().filter(|joint| joint.gap < 0.0).count());
        }
        let (end, _) = momenta(&structure, &motion, [0.0; 2]);
        let changes = [0, 1, 2].map(|i| (end[i] - start[i]).abs() / size[i]);
        let (mut off, mut sum) = ([0.0; 2], 0.0);
        for (crack, joints) in structure.cracks.iter().zip(&mut motion.joints) {
            let mut forces = vec![[0.0; 2]; motion.displacement.len()];
            crack.add_forces(&motion.displacement, &motion.velocity, 0.0, joints, &mut forces);
            for force in forces {
                (0..2).for_each(|d| off[d] += force[d]);
                sum += force[0].hypot(force[1]);
            }
        }
        let unbalanced = off[0].hypot(off[1]) / sum;
        println!(
            "μ = {friction}, {integration:?}, {} contacts, {} steps, at most {closed} closed, {} meetings: momenta changed by \
             {}, action and reaction {unbalanced:.1e}",
            motion.joints.iter().map(Vec::len).sum::<usize>(),
            50 * steps.steps,
            motion.meetings.len(),
            changes.map(|change| format!("{change:.1e}")).join(", "),
        );
        assert!(closed > 400 && unbalanced < 1e-14);
        assert!(changes[0].max(changes[1]) < 1e-12 && (friction > 0.0 || changes[2] < 1e-12));
    }
}
