//! Blocks that meet where no crack was.

use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::CentralDifference;
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::{
    Block, CrackParameters, CriticalTimeStep, Dam, DamError, DamParameters, Damping, Fidelity, Kinematics,
    Mesh, Motion, Seam, Section, Structure,
};
use cofferdam_unit::{CoSimulation, Messages, variables::dam as variable};

use crate::support;

const GRAVITY: f64 = 9.81;

/// Rectangles with these corners at the lower left (m), sizes (m), and columns and rows; no seams.
fn rectangles(blocks: &[([f64; 2], [f64; 2], [usize; 2])]) -> Mesh {
    let mut mesh: Option<Mesh> = None;
    for &([x0, y0], [width, height], [columns, rows]) in blocks {
        let levels = (0..=rows).map(|i| height * i as f64 / rows as f64).collect();
        let mut block = Mesh::mapped(&Section::rectangle(width, height), &[levels], columns);
        block.nodes.iter_mut().for_each(|[x, y]| (*x, *y) = (*x + x0, *y + y0));
        let Some(mesh) = &mut mesh else {
            mesh = Some(block);
            continue;
        };
        let (nodes, cells) = (mesh.nodes.len(), mesh.cells.len());
        mesh.nodes.append(&mut block.nodes);
        mesh.cells.extend(block.cells.iter().map(|cell| cell.map(|node| node + nodes)));
        mesh.blocks.push(Block { nodes: nodes..mesh.nodes.len(), cells: cells..mesh.cells.len() });
        mesh.ground = mesh.nodes.len()..mesh.nodes.len();
    }
    mesh.expect("a block")
}

/// Nodes of a block at this elevation, from upstream to downstream.
fn level(mesh: &Mesh, block: usize, y: f64) -> Vec<usize> {
    let mut nodes: Vec<usize> =
        mesh.blocks[block].nodes.clone().filter(|&node| (mesh.nodes[node][1] - y).abs() < 1e-9).collect();
    nodes.sort_by(|&a, &b| mesh.nodes[a][0].total_cmp(&mesh.nodes[b][0]));
    nodes
}

fn law(friction: f64) -> Coulomb {
    Coulomb { friction, normal_stiffness: 1e9, shear_stiffness: 0.5e9 }
}

/// A block of 4 m x 2 m, fixed or free, with a block on its right end, of 2 m x 1 m, and others; the first two have a crack
/// between them.
fn on_a_step(others: &[([f64; 2], [f64; 2], [usize; 2])], friction: f64, is_fixed: bool) -> Structure {
    let first = [([0.0, 0.0], [4.0, 2.0], [4, 2]), ([2.0, 2.0], [2.0, 1.0], [3, 2])];
    let mut mesh = rectangles(&[&first, others].concat());
    let (lower, upper) = (level(&mesh, 0, 2.0), level(&mesh, 1, 2.0));
    mesh.seams.push(Seam { crack: 0, below: 0, above: 1, lower, upper });
    let fixed: Vec<usize> = mesh.blocks[0].nodes.clone().filter(|_| is_fixed).collect();
    let laws = [(law(friction), Integration::Nodal)];
    Structure::new(mesh, &support::stiff(1e9), Kinematics::Corotational, laws, &fixed)
}

/// Steps of 5 ms until `until` (s) with stiffness damping `beta` (s) and time steps of this share of 2/ω; returns the work.
fn advance(
    structure: &Structure,
    motion: &mut Motion,
    [beta, share]: [f64; 2],
    gravity: f64,
    until: f64,
) -> Work {
    let damping = cofferdam_dam::RayleighCoefficients { mass: 0.0, stiffness: beta };
    let limit = CriticalTimeStep::of(structure, damping).expect("a time step").with_safety(0.9, share);
    let steps = CentralDifference::covering(5e-3, limit);
    let forces = structure.weight([0.0, -gravity]);
    structure.accelerate(damping, motion, &forces);
    let (loads, mut work) = (LoadPath::constant(forces), Work::default());
    for _ in 0..(until / 5e-3).round() as usize {
        steps.advance(structure, damping, motion, &loads, &mut work);
    }
    work
}

fn launch(structure: &Structure, motion: &mut Motion, block: usize, velocity: [f64; 2]) {
    structure.mesh.blocks[block].nodes.clone().for_each(|node| motion.velocity[node] = velocity);
}

/// Momentum of a block, N s/m.
fn momentum(structure: &Structure, motion: &Motion, block: usize) -> [f64; 2] {
    let nodes = structure.mesh.blocks[block].nodes.clone();
    nodes.fold([0.0; 2], |sum, n| [0, 1].map(|d| sum[d] + structure.mass[n] * motion.velocity[n][d]))
}

fn energy(structure: &Structure, motion: &Motion) -> f64 {
    let stored = structure.stored_energy(motion);
    stored.kinetic + stored.strain + stored.contact
}

/// It leaves the step at 3 m/s, falls 2 m and comes to rest on the ground beside it: no part is below the ground or in the step,
/// its weight rests on the ground, and no energy comes from nowhere.
#[test]
fn a_block_that_slides_off_a_step_lands_beside_it() {
    for friction in [0.0, 0.3] {
        let structure = on_a_step(&[], friction, true);
        let mut motion = structure.at_rest();
        launch(&structure, &mut motion, 1, [3.0, 0.0]);
        let before = energy(&structure, &motion);
        let work = advance(&structure, &mut motion, [1e-3, 0.2], GRAVITY, 5.0);
        let lost = work.friction + work.damping;
        let balance = before + work.input - energy(&structure, &motion) - lost;
        let peak = 0.5 * 5000.0 * 9.0 + 5000.0 * GRAVITY * 2.0;
        assert!(balance.abs() < 1e-3 * peak, "mu {friction}: {balance} of {peak} J/m");
        assert!(work.friction >= -1e-9 * peak);
        let place = |node: usize| {
            let (x, u) = (structure.mesh.nodes[node], motion.displacement[node]);
            [x[0] + u[0], x[1] + u[1]]
        };
        let nodes = structure.mesh.blocks[1].nodes.clone();
        for [x, y] in nodes.clone().map(place) {
            assert!(y > -1e-3 && (x > 4.0 - 1e-3 || y > 2.0 - 1e-3), "mu {friction}: a node at ({x}, {y})");
        }
        let lowest = nodes.clone().map(|node| place(node)[1]).fold(f64::INFINITY, f64::min);
        assert!(lowest < 1e-3, "mu {friction}: in the air at {lowest} m");
        let speed = nodes.map(|node| motion.velocity[node][1].abs()).fold(0.0, f64::max);
        assert!(speed < 0.05, "mu {friction}: {speed} m/s");
    }
}

/// A block slides to rest where no crack is, on a side that is stretched by 2 %: what friction took is what the block had.
#[test]
fn friction_on_a_stretched_side_takes_what_the_block_had() {
    let structure = on_a_step(&[([0.2, 2.0], [0.5, 0.5], [1, 1])], 0.3, true);
    let mut motion = structure.at_rest();
    for node in structure.mesh.blocks[0].nodes.clone() {
        motion.displacement[node][0] = 0.02 * structure.mesh.nodes[node][0];
    }
    launch(&structure, &mut motion, 2, [1.5, 0.0]);
    let before = energy(&structure, &motion);
    let work = advance(&structure, &mut motion, [1e-3, 0.1], GRAVITY, 0.8);
    let slid = motion.displacement[structure.mesh.blocks[2].nodes.start][0];
    let balance = before + work.input - energy(&structure, &motion) - work.friction - work.damping;
    println!("slid {slid:.3} m, {work:.1?}, balance {balance:.2} J/m");
    assert!(slid > 0.3 && balance.abs() < 2e-3 * work.friction);
}

/// Face against face without friction: what one loses the other gains, to rounding.
#[test]
fn blocks_that_collide_keep_their_momentum() {
    let structure = on_a_step(&[([-1.5, 2.001], [2.0, 1.0], [2, 3])], 0.0, false);
    let balances = [0.2, 0.1, 0.05].map(|share| {
        let mut motion = structure.at_rest();
        launch(&structure, &mut motion, 2, [2.0, 0.0]);
        let whole = momentum(&structure, &motion, 2)[0];
        let before = energy(&structure, &motion);
        let work = advance(&structure, &mut motion, [0.0, share], 0.0, 1.2);
        let [below, first, second] = [0, 1, 2].map(|block| momentum(&structure, &motion, block)[0]);
        let sum = below + first + second;
        assert!((sum - whole).abs() < 1e-12 * whole, "{below} + {first} + {second} of {whole}");
        assert!(first > 0.8 * whole && second < 0.2 * whole, "{first}, {second} of {whole}");
        assert_eq!(structure.meeting_place(&motion), None, "they have parted");
        ((before - energy(&structure, &motion) - work.friction - work.damping) / before).abs()
    });
    println!("balance errors {balances:?}");
    assert!(balances[0] < 5e-4 && balances[2] < balances[0] / 4.0, "{balances:?}");
}

/// A corner that passes another one outside is not held, and one that strikes inside is.
#[test]
fn corners_that_pass_do_not_lock() {
    for (offset, passes) in [(1e-4, true), (-0.05, false)] {
        let structure = on_a_step(&[([4.0 + offset, 4.5], [2.0, 1.0], [2, 2])], 1.0, true);
        let mut motion = structure.at_rest();
        let fall = -4.0;
        launch(&structure, &mut motion, 2, [0.0, fall]);
        advance(&structure, &mut motion, [0.0, 0.2], 0.0, 0.6);
        let nodes = structure.mesh.blocks[2].nodes.clone();
        let slowest = nodes.map(|node| motion.velocity[node][1]).fold(f64::NEG_INFINITY, f64::max);
        assert_eq!((slowest - fall).abs() < 1e-9, passes, "{offset} m: {slowest} m/s");
    }
}

/// A dam whose upper block is thrown off downstream.
fn thrown(fidelity: Fidelity) -> DamParameters {
    DamParameters {
        section: Section::rectangle(2.0, 4.0),
        water_depth: 0.0,
        cracks: vec![CrackParameters::sliding(3.0, 0.1, 1e9, 0.5e9)],
        damping: Damping::None,
        element_size: 0.5,
        fidelity,
        ..support::koyna(1.0)
    }
}

/// Steps of 5 ms up to `until` (s) with the ground going upstream at 30 m/s² for half a second.
fn throw(dam: &mut Dam, until: f64) -> Result<(), DamError> {
    while dam.state().time() < until - 1e-6 {
        let time = dam.state().time();
        let a = if time < 0.5 { -30.0 } else { 0.0 };
        dam.set(variable::GROUND_ACCELERATION.value_reference, &[a, 0.0])?;
        dam.step(time, 5e-3)?;
    }
    Ok(())
}

/// A state with meetings continues from bytes with the same bits.
#[test]
fn a_state_with_meetings_goes_on_from_bytes() -> Result<(), DamError> {
    let mut dam = support::at_rest(thrown(Fidelity::Dem))?;
    let closed = |dam: &Dam| {
        let motion = dam.state().motion().of_nodes().expect("nodes");
        dam.structure().meeting_place(motion).is_some()
    };
    while !closed(&dam) {
        let next = dam.state().time() + 5e-3;
        throw(&mut dam, next)?;
        assert!(dam.state().time() < 3.0, "the block never lands");
    }
    let time = dam.state().time();
    let bytes = dam.serialise_state(&dam.save_state())?;
    throw(&mut dam, time + 0.3)?;
    let mut other = Dam::new(thrown(Fidelity::Dem))?;
    other.restore_state(&other.deserialise_state(&bytes)?)?;
    throw(&mut other, time + 0.3)?;
    assert_eq!(dam.state().motion(), other.state().motion());
    Ok(())
}

/// What lands in the full model leaves the modes for ever, and is told of once.
#[test]
fn a_block_that_leaves_its_crack_is_told_of() -> Result<(), DamError> {
    for (fidelity, text) in [
        (Fidelity::Dem, "meets the ground"),
        (Fidelity::Reduced { modes: Some(4) }, "has left the crack at 3 m"),
    ] {
        let messages = Messages::default();
        messages.listen(|| -> Result<(), DamError> {
            let mut dam = support::at_rest(thrown(fidelity))?;
            throw(&mut dam, 2.0)
        })?;
        let told = messages.take().into_iter().filter(|message| message.2.contains(text)).count();
        assert_eq!(told, 1, "{fidelity:?}");
    }
    Ok(())
}
