//! Ten stacked blocks keep their weight, and free blocks their momenta.

use cofferdam_dam::contact::{Coulomb, Integration, MohrCoulomb};
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::{CentralDifference, SparseNewton};
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::{
    DamError, DampingCoefficients, Kinematics, Motion, RayleighCoefficients, Section, Structure,
};

use crate::support::assembly::{
    Assembly, LIFT, Meshing, Placed, Position, cases, rectangle, two_blocks, unstructured,
};
use crate::support::{self, GRAVITY};

const STIFFNESS: f64 = 1e10;

/// Ten blocks, each 1 m high and a little narrower than the one below, the lowest fixed.
fn stack(position: Position, meshing: Meshing, integration: Integration) -> Structure<MohrCoulomb> {
    let mut assembly = Assembly::new();
    let mut below: Option<Placed> = None;
    for block in 0..11 {
        let width = 4.0 - 0.1 * f64::from(block);
        let columns = if meshing == Meshing::Different && block % 2 == 1 { 5 } else { 4 };
        let part = match meshing {
            Meshing::Unstructured => unstructured(&Section::rectangle(width, 1.0), &[], 0.6),
            _ => rectangle([width, 1.0], [columns, 1]),
        };
        let placed = assembly.add(&part, |[x, y]| [x - width / 2.0, y + f64::from(block)]);
        if let Some(below) = below {
            let crack = below.block;
            assembly.join(crack, (below.block, &below.top), (placed.block, &placed.base));
        }
        below = Some(placed);
    }
    let fixed: Vec<usize> = assembly.mesh.blocks[0].nodes.clone().collect();
    let law = MohrCoulomb {
        residual: Coulomb { friction: 0.6, normal_stiffness: STIFFNESS, shear_stiffness: STIFFNESS },
        friction: 0.6,
        cohesion: 0.0,
        tensile_strength: 0.0,
        dilation: 0.0,
        dilation_slip: 1.0,
    };
    let mesh = position.of_mesh(assembly.mesh);
    let cracks = [(law, integration); 10];
    Structure::new(mesh, &support::stiff(STIFFNESS), Kinematics::Small, cracks, &fixed)
}

/// Each joint carries the load on all blocks above it, and the normal force across it is their weight. Tolerance: the
/// residual, times the number of blocks. The sum of the forces normal to the sides is the weight to 10⁻⁷, as the sides bend
/// where the meshes do not match and local shear has a component across the joint.
#[test]
fn ten_blocks_keep_their_weight() -> Result<(), DamError> {
    for ((position, meshing), integration) in
        cases().flat_map(|case| [(case, Integration::Nodal), (case, Integration::Gauss)])
    {
        let structure = stack(position, meshing, integration);
        for share in [0.0, 0.05] {
            let mut motion = structure.at_rest();
            let body = position.of([share * GRAVITY, -GRAVITY]);
            let loads = structure.weight(body);
            let solver = SparseNewton { tolerance: 1e-10, max_iterations: 3000 };
            let relaxed = solver.relax(&structure, &mut motion, &loads)?;
            let (mut carried, mut normal, mut reaction) = (0.0f64, 0.0f64, 0.0f64);
            for (joint, crack) in structure.cracks.iter().enumerate() {
                let above = structure.mesh.blocks[joint + 1].nodes.start;
                let mass: f64 = structure.mass[above..].iter().sum();
                let mut forces = vec![[0.0; 2]; loads.len()];
                let (u, v) = (&motion.displacement, &motion.velocity);
                crack.add_forces(u, v, 0.0, &mut motion.joints[joint], &mut forces);
                let resultant =
                    |forces: &[[f64; 2]]| [0, 1].map(|d| forces.iter().map(|f| f[d]).sum::<f64>());
                let [on_lower, on_upper] = [resultant(&forces[..above]), resultant(&forces[above..])];
                let weight = mass * GRAVITY;
                let off = |a: [f64; 2], b: [f64; 2]| (a[0] + b[0]).hypot(a[1] + b[1]) / weight;
                carried = carried.max(off(on_upper, body.map(|component| mass * component)));
                reaction = reaction.max(off(on_upper, on_lower));
                normal = normal.max((crack.forces(&motion.joints[joint]).normal / weight - 1.0).abs());
            }
            println!(
                "{position:?}, {meshing:?}, {integration:?}, {share} g: residual {:.0e}, load carried to {carried:.1e}, \
                 normal force {normal:.1e}, action and reaction {reaction:.1e}",
                relaxed.residual
            );
            assert!(carried < 1e-9 && reaction < 1e-14 && (share > 0.0 || normal < 1e-7));
        }
    }
    Ok(())
}

/// Relative to the origin of the turned mesh, m.
fn above_origin([x, y]: [f64; 2]) -> [f64; 2] {
    [x, y - LIFT]
}

/// Two blocks without any support fly towards each other, spin, collide again and again under no load. Momentum stays to
/// rounding. So does angular momentum without friction, as normal forces act on one line. Forces of friction act on two
/// surfaces that overlap, and change it by less than friction × overlap. Viscous stresses are not coaxial with the strain,
/// and change it by about their moment times the strain; here 10⁻⁷ of it.
#[test]
fn free_blocks_keep_their_momenta() {
    for (position, meshing) in cases() {
        for (friction, viscous) in [(0.0, 0.0), (0.5, 0.0), (0.0, 1e-4)] {
            let law = Coulomb { friction, normal_stiffness: 1e9, shear_stiffness: 1e9 };
            let mesh = position.of_mesh(two_blocks([3.0, 1.0], 0.5, meshing));
            let contacts = [(law, Integration::Nodal)];
            let structure =
                Structure::new(mesh, &support::stiff(1e9), Kinematics::Corotational, contacts, &[]);
            let mut motion = structure.at_rest();
            for (block, [v, w, spin]) in [(0, [0.1, 0.3, 0.05]), (1, [0.4, -0.5, -0.3])] {
                for node in structure.mesh.blocks[block].nodes.clone() {
                    let [x, y] = above_origin(structure.mesh.nodes[node]);
                    let drift = position.of([v, w]);
                    motion.velocity[node] = [drift[0] - spin * y, drift[1] + spin * x];
                }
            }
            let (start, size) = support::momenta(&structure, &motion, [0.0, LIFT]);
            let damping = DampingCoefficients::from(RayleighCoefficients { mass: 0.0, stiffness: viscous });
            let none = structure.weight([0.0; 2]);
            structure.accelerate(damping, &mut motion, &none);
            let steps =
                CentralDifference::covering(0.002, 0.5 * support::critical(&structure, damping).limit);
            let loads = LoadPath::constant(none);
            let (mut allowed, mut closed, mut hits) = (0.0, false, 0);
            let mut before = mean_momentum(&structure, &motion);
            for _ in 0..200 {
                steps.advance(&structure, damping, &mut motion, &loads, &mut Work::default());
                let after = mean_momentum(&structure, &motion);
                let deepest = motion.joints[0].iter().fold(0.0f64, |most, joint| most.max(-joint.gap));
                allowed += friction * 2.0 * deepest * (after[0] - before[0]).hypot(after[1] - before[1]);
                before = after;
                hits += usize::from(deepest > 0.0 && !closed);
                closed = deepest > 0.0;
            }
            let (end, _) = support::momenta(&structure, &motion, [0.0, LIFT]);
            let changes = [0, 1, 2].map(|i| (end[i] - start[i]).abs() / size[i]);
            let parted = [0, 1].map(|block| support::mean(&structure, &motion.velocity, block));
            println!(
                "{position:?}, {meshing:?}, μ = {friction}, β = {viscous} s, {} steps, {hits} hits, velocities \
                 {parted:.3?}: momenta changed by {:.1e}, {:.1e}, angular {:.1e}, friction × overlap {:.1e}",
                200 * steps.steps,
                changes[0],
                changes[1],
                changes[2],
                allowed / size[2]
            );
            assert!(hits > 0);
            assert!(changes[0].max(changes[1]) < 1e-12);
            let strained = if viscous > 0.0 { 1e-6 } else { 1e-12 };
            assert!(changes[2] < strained + 2.0 * allowed / size[2]);
        }
    }
}

/// Momentum of the upper block, N s/m.
fn mean_momentum(structure: &Structure, motion: &Motion) -> [f64; 2] {
    let mass: f64 = structure.mesh.blocks[1].nodes.clone().map(|node| structure.mass[node]).sum();
    support::mean(structure, &motion.velocity, 1).map(|v| mass * v)
}
