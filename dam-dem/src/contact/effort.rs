//! How much work contacts are, in tests: the work of many blocks is that of few, times their number.

use std::cell::Cell;

/// What has been done on this thread.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Effort {
    /// Segments onto which points were projected along cracks.
    pub segments: usize,
    /// Pairs of boxes that were compared.
    pub boxes: usize,
    /// Edges against which points were held where no crack is.
    pub edges: usize,
}

thread_local! {
    static SPENT: Cell<Effort> = const { Cell::new(Effort { segments: 0, boxes: 0, edges: 0 }) };
}

/// Adds to it.
pub(super) fn spend(change: impl Fn(&mut Effort)) {
    let mut spent = SPENT.get();
    change(&mut spent);
    SPENT.set(spent);
}

#[test]
fn the_work_of_a_block_does_not_grow_with_their_number() {
    use super::{Coulomb, Integration};
    use crate::energy::Work;
    use crate::integrator::CentralDifference;
    use crate::loads::LoadPath;
    use crate::{DampingCoefficients, Geometry, Kinematics, Material, Mesh, Plane, Section, Structure};

    let material = Material { young_modulus: 1e9, poisson_ratio: 0.2, density: 2500.0, plane: Plane::Stress };
    let law = Coulomb { friction: 0.5, normal_stiffness: 1e9, shear_stiffness: 0.5e9 };
    for (what, sizes) in [("wall", [[5, 2], [10, 5], [20, 10]]), ("stack", [[1, 10], [1, 50], [1, 200]])] {
        let spent = sizes.map(|[columns, rows]: [usize; 2]| {
            let [width, height] = [columns, rows].map(|count| count as f64);
            let upright = (1..columns).map(|i| vec![[i as f64, -1.0], [i as f64, height + 1.0]]);
            let level = (1..rows).map(|i| vec![[-1.0, i as f64], [width + 1.0, i as f64]]);
            let section = Section::rectangle(width, height);
            let mesh = Mesh::of_section(&Geometry {
                upstream: &section.upstream,
                downstream: &section.downstream,
                galleries: &[],
                cracks: &upright.chain(level).collect::<Vec<_>>(),
                upstream_levels: &[],
                downstream_levels: &[],
                element_size: 0.6,
                crack_sizes: &[],
            })
            .expect("a mesh");
            let blocks = mesh.blocks.len();
            assert_eq!(blocks, columns * rows);
            let laws = vec![(law, Integration::Nodal); columns + rows - 2];
            let structure = Structure::new(mesh, &material, Kinematics::Corotational, laws, &[]);
            let mut motion = structure.at_rest();
            // the blocks part and come together again
            for (index, block) in structure.mesh.blocks.iter().enumerate() {
                let v = [0.01, -0.02, 0.015, -0.005][index % 4];
                block.nodes.clone().for_each(|node| motion.velocity[node] = [v, -v]);
            }
            let (steps, none) = (CentralDifference { time_step: 1e-4, steps: 10 }, structure.weight([0.0; 2]));
            structure.accelerate(DampingCoefficients::NONE, &mut motion, &none);
            SPENT.set(Effort::default());
            let loads = LoadPath::constant(none);
            for _ in 0..20 {
                steps.advance(&structure, DampingCoefficients::NONE, &mut motion, &loads, &mut Work::default());
            }
            let contacts: usize = motion.joints.iter().map(Vec::len).sum();
            let Effort { segments, boxes, edges } = SPENT.get();
            let each = |count: usize, of: usize| count as f64 / of as f64;
            let found = [each(segments, 200 * contacts), each(edges, 20 * blocks), each(boxes, 20 * blocks)];
            println!(
                "{what} of {blocks} blocks, {contacts} contacts: {:.3} segments a contact and time step; a block and \
                 communication step {:.1} edges, {:.1} pairs of boxes",
                found[0], found[1], found[2]
            );
            found
        });
        let [few, _, many] = spent;
        // every contact is visited once a time step, and hardly looks farther than its own segment
        assert!(spent.iter().all(|[segments, ..]| (1.0..1.1).contains(segments)));
        // inner blocks have more neighbours than those on the outside: 3 a block in a small wall, 4 in a large one
        assert!(many[1] < 2.0 * few[1].max(1.0));
        // the boxes in a column of a wall overlap along it
        let neighbours = if what == "wall" { 30.0 } else { 3.0 };
        assert!(many[2] <= neighbours);
    }
}
