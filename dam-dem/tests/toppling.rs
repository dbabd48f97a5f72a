//! A rectangular block on the ground under a horizontal acceleration that grows slowly topples at b/h of gravity.

use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::{CentralDifference, SparseNewton};
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::{
    DamError, DampingCoefficients, Kinematics, RayleighCoefficients, Structure, best_fit_rotation,
};

use crate::support::assembly::{Assembly, Position, rectangle};
use crate::support::{self, GRAVITY};

const SIZE: [f64; 2] = [1.0, 2.0];

/// The block, whose base has this many segments, on a fixed block with segments of another length.
fn block(segments: usize, integration: Integration, position: Position) -> Structure {
    let mut assembly = Assembly::new();
    let ground = assembly.add(&rectangle([5.0, 1.0], [19, 1]), |[x, y]| [x - 2.0, y - 1.0]);
    let block = assembly.add(&rectangle(SIZE, [segments, 4]), |place| place);
    assembly.join(0, (ground.block, &ground.top), (block.block, &block.base));
    let fixed: Vec<usize> = assembly.mesh.blocks[0].nodes.clone().collect();
    let law = Coulomb { friction: 10.0, normal_stiffness: 1e12, shear_stiffness: 1e12 };
    let mesh = position.of_mesh(assembly.mesh);
    Structure::new(mesh, &support::stiff(1e10), Kinematics::Corotational, [(law, integration)], &fixed)
}

/// Share of gravity at which the block begins to topple: when it has turned by 1e-3 rad. A rigid block about a corner then
/// has 0.3 % more than at the beginning, as the acceleration grows by 0.002 g in a second.
///
/// The joint is stiff: on a softer one the block topples earlier, with a longer part of its base in contact.
fn toppling(structure: &Structure, position: Position) -> Result<f64, DamError> {
    let rate = 0.002;
    let body = |share: f64| structure.weight(position.of([share * GRAVITY, -GRAVITY]));
    let mut motion = structure.at_rest();
    SparseNewton { tolerance: 1e-7, max_iterations: 300 }.relax(structure, &mut motion, &body(0.0))?;
    let free = DampingCoefficients::from(RayleighCoefficients { mass: 0.0, stiffness: 2e-5 });
    // up to almost the expected share the block is led there
    let led = RayleighCoefficients { mass: 50.0, stiffness: 2e-5 };
    let led = DampingCoefficients { drags_blocks: true, ..led.into() };
    let limit = 0.9 * support::critical(structure, led).limit;
    let mut grow = |damping: DampingCoefficients, from: f64, to: f64, duration: f64| {
        let [start, end] = [from, to].map(body);
        let change = start.iter().zip(&end).map(|(a, b)| [b[0] - a[0], b[1] - a[1]]).collect();
        let steps = CentralDifference::covering(duration, limit);
        steps.advance(structure, damping, &mut motion, &LoadPath { start, change }, &mut Work::default());
        let nodes = structure.mesh.blocks[1].nodes.clone();
        let points = nodes.map(|n| (structure.mass[n], structure.mesh.nodes[n], motion.displacement[n]));
        best_fit_rotation(points).abs()
    };
    let mut share = 0.985 * SIZE[0] / SIZE[1] * (1.0 - inset(structure));
    grow(led, 0.0, share, 0.5);
    let duration = 0.05;
    while share < 0.6 {
        let turned = grow(free, share, share + rate * duration, duration);
        share += rate * duration;
        if turned > 1e-3 {
            return Ok(share);
        }
    }
    Ok(f64::INFINITY)
}

/// Distance of the outermost contact of the block's own points from its corner over half its width.
fn inset(structure: &Structure) -> f64 {
    let nodes: &[usize] = structure.cracks[0].sides()[1];
    let corner = structure.mesh.nodes[nodes[0]];
    let away = |place: [f64; 2]| (place[0] - corner[0]).hypot(place[1] - corner[1]);
    let own = structure.cracks[0].places().take(2 * nodes.len() - 2).map(away);
    2.0 * own.fold(f64::INFINITY, f64::min) / SIZE[0]
}

/// Within 1 %. With nodes the block turns about its corner. With Gauss points it turns about the outermost one, 0.21
/// segments inside: with four segments 5.3 % of the width inside, so that it topples at 0.89 b/h, with eight 2.6 %.
#[test]
fn a_block_topples_at_width_over_height() -> Result<(), DamError> {
    let critical = SIZE[0] / SIZE[1];
    let (nodal, gauss) = (Integration::Nodal, Integration::Gauss);
    let one = [(4, nodal), (4, gauss), (8, gauss)].map(|case| (Position::ALL[0], case));
    let others = [(Position::ALL[4], (4, nodal)), (Position::ALL[1], (4, gauss))];
    for (position, (segments, integration)) in one.into_iter().chain(others) {
        let structure = block(segments, integration, position);
        let inset = inset(&structure);
        let measured = toppling(&structure, position)? / critical;
        let turns_inside = 0.5 * (1.0 - measured / 1.003);
        println!(
            "{position:?}, {segments} segments, {integration:?}: topples at {measured:.4} b/h, about a point \
                 {turns_inside:.4} of the width inside; outermost point {:.4} inside",
            inset / 2.0
        );
        assert!((measured / (1.0 - inset) - 1.0).abs() < 0.01);
        assert!(integration == gauss || (measured - 1.0).abs() < 0.01);
    }
    Ok(())
}
