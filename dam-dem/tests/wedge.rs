//! Wedges between two sloping joints, against the equilibrium of rigid bodies at the friction angle.

use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::integrator::DynamicRelaxation;
use cofferdam_dam::{DamError, Kinematics, Mesh, Section, Structure};

use crate::support::assembly::{Assembly, Position, rectangle, unstructured};
use crate::support::{self, GRAVITY};

/// Stiffness of joints, Pa/m: what stands on them turns by about 1e-7.
const JOINT: f64 = 1e11;

/// A quadrilateral from (columns, rows) between four corners, from the lower left on.
fn quadrilateral(corners: [[f64; 2]; 4]) -> impl Fn([f64; 2]) -> [f64; 2] {
    move |[x, y]| {
        let weights = [(1.0 - x) * (1.0 - y), x * (1.0 - y), x * y, (1.0 - x) * y];
        [0, 1].map(|d| corners.iter().zip(weights).map(|(corner, weight)| weight * corner[d]).sum())
    }
}

/// Each position with nodes, and one of them with Gauss points.
fn positions() -> impl Iterator<Item = (Position, Integration)> {
    let positions = Position::ALL.into_iter().skip(1).map(|position| (position, Integration::Nodal));
    positions.chain([(Position::ALL[1], Integration::Gauss)])
}

/// Whether the structure is at rest under its weight and a horizontal acceleration `pushed` (m/s²) of one block.
fn rests(structure: &Structure, position: Position, block: usize, pushed: f64) -> bool {
    let mut loads = structure.weight(position.of([0.0, -GRAVITY]));
    let push = position.of([pushed, 0.0]);
    for node in structure.mesh.blocks[block].nodes.clone() {
        (0..2).for_each(|d| loads[node][d] += structure.mass[node] * push[d]);
    }
    let solver = DynamicRelaxation { tolerance: 3e-8, max_iterations: 20_000 };
    let found = solver.relax(structure, &mut structure.at_rest(), &loads);
    println!("    pushed with {pushed:.6} m/s²: {found:?}");
    found.is_ok()
}

fn mass_of(structure: &Structure, block: usize) -> f64 {
    structure.mesh.blocks[block].nodes.clone().map(|node| structure.mass[node]).sum()
}

/// A triangular wedge in a notch with different slopes of its two sides. Pushed to the right it leaves the left side and
/// slides up the right one at `H = W tan(α + φ)`; pushed to the left the other way round.
#[test]
fn a_wedge_leaves_its_notch() -> Result<(), DamError> {
    let friction: f64 = 0.3;
    let law = Coulomb { friction, normal_stiffness: JOINT, shear_stiffness: JOINT };
    let (left, right, deep) = (1.5, 1.9, 1.0);
    // as a section it stands on its broad side
    let triangle = Section::new(vec![[0.0, 0.0], [right, deep]], vec![[left + right, 0.0], [right, deep]]);
    for (position, integration) in positions() {
        let mut assembly = Assembly::new();
        let tops = quadrilateral([[-left, -1.0], [0.0, -1.0], [0.0, 0.0], [-left, deep]]);
        let left_side = assembly.add(&rectangle([1.0, 1.0], [4, 1]), tops);
        let tops = quadrilateral([[0.0, -1.0], [right, -1.0], [right, deep], [0.0, 0.0]]);
        let right_side = assembly.add(&rectangle([1.0, 1.0], [5, 1]), tops);
        let wedge = assembly.add(&unstructured(&triangle, &[], 0.4), |[x, y]| [right - x, deep - y]);
        let up: Vec<usize> = wedge.upstream.iter().rev().copied().collect();
        assembly.join(0, (left_side.block, &left_side.top), (wedge.block, &wedge.downstream));
        assembly.join(0, (right_side.block, &right_side.top), (wedge.block, &up));
        let fixed: Vec<usize> = (0..assembly.mesh.blocks[wedge.block].nodes.start).collect();
        let mesh: Mesh = position.of_mesh(assembly.mesh);
        let material = support::stiff(1e12);
        let structure = Structure::new(mesh, &material, Kinematics::Small, [(law, integration)], &fixed);
        for (side, direction) in [(right, 1.0), (left, -1.0)] {
            let exact = GRAVITY * ((deep / side).atan() + friction.atan()).tan();
            println!("{position:?}, {integration:?}, exact {exact:.6} m/s²:");
            assert!(rests(&structure, position, wedge.block, direction * exact * (1.0 - 1e-6)));
            assert!(!rests(&structure, position, wedge.block, direction * exact * (1.0 + 1e-6)));
        }
    }
    Ok(())
}

/// A wedge on the ground under a block that stands against a wall, with friction in all three joints: the push that lifts
/// the block, and the pull that draws the wedge out.
#[test]
fn a_wedge_lifts_a_block_and_is_drawn_out() -> Result<(), DamError> {
    let friction = [0.2, 0.25, 0.15];
    let law = |friction| Coulomb { friction, normal_stiffness: JOINT, shear_stiffness: JOINT };
    let slope = 0.3f64;
    let thin = 0.6;
    for (position, integration) in positions() {
        let height = |x: f64| thin + slope * x;
        let mut assembly = Assembly::new();
        let ground = assembly.add(&rectangle([8.0, 1.0], [13, 1]), |[x, y]| [x - 3.0, y - 1.0]);
        let wall = assembly.add(&rectangle([1.0, 6.0], [1, 9]), |[x, y]| [x - 0.5, y + 0.9]);
        let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, height(4.0)], [0.0, thin]];
        let wedge = assembly.add(&rectangle([1.0, 1.0], [5, 2]), quadrilateral(corners));
        let corners = [[0.5, height(0.5)], [3.5, height(3.5)], [3.5, 4.0], [0.5, 4.0]];
        let block = assembly.add(&rectangle([1.0, 1.0], [4, 3]), quadrilateral(corners));
        assembly.join(0, (ground.block, &ground.top), (wedge.block, &wedge.base));
        assembly.join(1, (wedge.block, &wedge.top), (block.block, &block.base));
        assembly.join(2, (block.block, &block.upstream), (wall.block, &wall.downstream));
        let fixed: Vec<usize> = (0..assembly.mesh.blocks[wedge.block].nodes.start).collect();
        let mesh = position.of_mesh(assembly.mesh);
        let laws = friction.map(|friction| (law(friction), integration));
        let structure = Structure::new(mesh, &support::stiff(1e12), Kinematics::Small, laws, &fixed);
        let weights = [wedge.block, block.block].map(|block| mass_of(&structure, block) * GRAVITY);
        let pushed_in = push(weights, slope, friction);
        let drawn_out = push(weights, slope, friction.map(|friction| -friction));
        assert!(pushed_in > 0.0 && drawn_out < 0.0);
        for exact in [pushed_in, drawn_out] {
            let exact = -exact / mass_of(&structure, wedge.block);
            println!("{position:?}, {integration:?}, exact {exact:.6} m/s²:");
            assert!(rests(&structure, position, wedge.block, exact * (1.0 - 1e-6)));
            assert!(!rests(&structure, position, wedge.block, exact * (1.0 + 1e-6)));
        }
    }
    Ok(())
}

/// The push P on the wedge, N/m, at which all joints slide; the other way if friction is negative. With the normal forces
/// N₁ of the ground, N₂ between wedge and block, N₃ of the wall:
///
/// ```text
/// block: N₃ = N₂ (s + μ₂ c),  N₂ (c − μ₂ s) = W_b + μ₃ N₃
/// wedge: N₁ = W_w + N₂ (c − μ₂ s),  P = N₂ (s + μ₂ c) + μ₁ N₁
/// ```
fn push([wedge, block]: [f64; 2], slope: f64, [ground, between, wall]: [f64; 3]) -> f64 {
    let (sin, cos) = slope.atan().sin_cos();
    let (across, up) = (sin + between * cos, cos - between * sin);
    let pressed = block / (up - wall * across);
    pressed * across + ground * (wedge + pressed * up)
}
