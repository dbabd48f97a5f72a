//! Meshes that were made elsewhere: triangles and quadrilaterals, parted along cracks.

use crate::support;

use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::{Feature, GeometryError, GivenMesh, GivenMeshError, Kinematics, Mesh, Structure};

/// A square of 4 m: two quadrilaterals and four triangles around a point that is not its middle.
///
/// ```text
///   6───7───8
///   │ ╱ │ q │
///   3───4───5
///   │ q │ ╲ │
///   0───1───2
/// ```
fn square() -> GivenMesh {
    let mut points: Vec<[f64; 2]> =
        (0..9).map(|i| [2.0 * f64::from(i % 3), 2.0 * f64::from(i / 3)]).collect();
    points[4] = [2.3, 1.8];
    GivenMesh {
        points,
        triangles: vec![[1, 2, 4], [2, 5, 4], [3, 4, 7], [3, 7, 6]],
        quadrilaterals: vec![[0, 1, 4, 3], [4, 5, 8, 7]],
        upstream: vec![0, 3, 6],
        downstream: vec![2, 5, 8],
        base: vec![0, 1, 2],
        cracks: Vec::new(),
    }
}

fn cracked() -> GivenMesh {
    GivenMesh { cracks: vec![vec![vec![3, 4, 5]]], ..square() }
}

fn mesh(given: &GivenMesh) -> Result<Mesh, GivenMeshError> {
    Mesh::of_given(given, &[], [0.0; 2], 0.8)
}

/// Patch test: with displacements that are linear in x and y, stress is the same everywhere and no inner node feels a force.
#[test]
fn uniform_strain_is_exact() -> Result<(), GivenMeshError> {
    let none: [(Coulomb, Integration); 0] = [];
    let structure = Structure::new(mesh(&square())?, &support::stiff(3e10), Kinematics::Small, none, &[]);
    let mut motion = structure.at_rest();
    for (u, [x, y]) in motion.displacement.iter_mut().zip(&structure.mesh.nodes) {
        *u = [1e-3 * x - 2e-3 * y, 4e-4 * x + 7e-4 * y];
    }
    let mut forces = vec![[0.0; 2]; structure.mesh.nodes.len()];
    structure.add_internal_forces(&mut motion, 0.0, &mut forces);
    let largest = forces.as_flattened().iter().fold(0.0f64, |most, force| most.max(force.abs()));
    let (mut inner, mut count) = (0.0f64, 0);
    for (force, [x, y]) in forces.iter().zip(&structure.mesh.nodes) {
        if *x > 1e-9 && *x < 4.0 - 1e-9 && *y > 1e-9 && *y < 4.0 - 1e-9 {
            (inner, count) = (inner.max(force[0].abs()).max(force[1].abs()), count + 1);
        }
    }
    println!("{count} inner nodes, {inner:e} of {largest:e} N/m");
    assert!(count > 30 && inner < 1e-12 * largest);
    Ok(())
}

#[test]
fn the_mesh_is_parted_along_cracks() -> Result<(), GivenMeshError> {
    let found = mesh(&cracked())?;
    assert_eq!((found.blocks.len(), found.cells.len(), found.seams.len()), (2, 20, 1));
    let area: f64 = found
        .triangles()
        .map(|corners| {
            let [a, b, c] = corners.map(|i| found.nodes[i]);
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
        })
        .sum();
    assert!((area - 16.0).abs() < 1e-12, "{area}");
    let seam = &found.seams[0];
    let length = 2.3f64.hypot(0.2) + 1.7f64.hypot(0.2);
    for side in [&seam.lower, &seam.upper] {
        assert!((found.length(side) - length).abs() < 1e-12);
    }
    assert_eq!((seam.below, seam.above), (0, 1));
    assert_eq!(found.base.len(), 5);
    assert_eq!(found.doubled_nodes().count(), 5);
    // in whatever direction its polygons are given
    let mut turned = cracked();
    turned.triangles.iter_mut().for_each(|corners| corners.reverse());
    turned.quadrilaterals.iter_mut().for_each(|corners| corners.reverse());
    let turned = mesh(&turned)?;
    let sum = |mesh: &Mesh| mesh.nodes.iter().flatten().sum::<f64>();
    assert_eq!(turned.blocks.len(), 2);
    assert!((sum(&turned) - sum(&found)).abs() < 1e-12);
    assert!(turned.quality().smallest_angle.0 > 0.0);
    Ok(())
}

#[test]
fn a_joint_to_the_ground_is_a_crack_along_the_base() -> Result<(), GivenMeshError> {
    let found = mesh(&GivenMesh { cracks: vec![vec![vec![0, 1, 2]]], ..square() })?;
    assert!(found.base.is_empty() && found.is_ground(found.seams[0].below));
    // the ground continues by the width of the base at either end
    assert!((found.length(&found.seams[0].lower) - 12.0).abs() < 1e-12);
    Ok(())
}

/// Quadrilaterals alone become cells as they are.
#[test]
fn quadrilaterals_are_cells() -> Result<(), GivenMeshError> {
    let given = GivenMesh {
        triangles: Vec::new(),
        quadrilaterals: vec![[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]],
        ..cracked()
    };
    let found = mesh(&given)?;
    assert_eq!((found.blocks.len(), found.cells.len(), found.nodes.len()), (2, 4, 9 + 3 + 4));
    Ok(())
}

#[test]
fn what_makes_no_dam_is_refused() {
    type Change = fn(&mut GivenMesh);
    type Expected = fn(&GivenMeshError) -> bool;
    let cases: &[(Change, Expected)] = &[
        (|m| (m.triangles, m.quadrilaterals) = Default::default(), |e| matches!(e, GivenMeshError::Empty)),
        (|m| m.base[1] = 9, |e| matches!(e, GivenMeshError::NoSuchPoint { index: 9, points: 9 })),
        (|m| m.points[4][0] = f64::NAN, |e| matches!(e, GivenMeshError::NotFinite { .. })),
        (|m| m.points[4] = [0.5, 0.5], |e| matches!(e, GivenMeshError::Shape { .. })),
        (|m| m.quadrilaterals[0] = [0, 4, 1, 3], |e| matches!(e, GivenMeshError::Shape { .. })),
        (|m| m.points[7] = [3.9, 3.98], |e| matches!(e, GivenMeshError::Sliver { .. })),
        (|m| m.triangles.push([1, 2, 4]), |e| matches!(e, GivenMeshError::Overlap { .. })),
        (
            |m| {
                m.points.push(m.points[4]);
                m.quadrilaterals[1][0] = 9;
            },
            |e| matches!(e, GivenMeshError::DuplicatePoints { point: [2.3, 1.8] }),
        ),
        (
            |m| drop(m.triangles.drain(..2)),
            |e| matches!(e, GivenMeshError::Apart { .. } | GivenMeshError::Outline { .. }),
        ),
        (
            |m| {
                m.points.extend([[9.0, 1.0], [10.0, 1.0], [9.0, 2.0]]);
                m.triangles.push([9, 10, 11]);
            },
            |e| matches!(e, GivenMeshError::Apart { point: [9.0, 1.0] }),
        ),
        (
            |m| m.points.iter_mut().for_each(|p| p[0] += 1.0),
            |e| matches!(e, GivenMeshError::HeelNotAtOrigin { point: [1.0, 0.0] }),
        ),
        (|m| m.points[1][1] = 0.1, |e| matches!(e, GivenMeshError::Base { point: [2.0, 0.1] })),
        (|m| m.base.truncate(2), |e| matches!(e, GivenMeshError::Outline { .. })),
        (|m| m.upstream.reverse(), |e| matches!(e, GivenMeshError::Outline { .. })),
        (|m| m.downstream.truncate(1), |e| matches!(e, GivenMeshError::Outline { .. })),
        (
            |m| m.cracks[0][0] = vec![3, 8, 5],
            |e| {
                matches!(
                    e,
                    GivenMeshError::NoSide { feature: Feature::Crack(0), from: [0.0, 2.0], to: [4.0, 4.0] }
                )
            },
        ),
        (
            |m| m.cracks.push(vec![vec![1, 4, 5]]),
            |e| matches!(e, GivenMeshError::Shared { second: Feature::Crack(1), .. }),
        ),
        (
            |m| m.cracks[0] = vec![vec![0, 3]],
            |e| matches!(e, GivenMeshError::Shared { first: Feature::Upstream, .. }),
        ),
        (
            |m| m.cracks[0][0] = vec![3, 4],
            |e| matches!(e, GivenMeshError::EndsInside { crack: 0, end: [2.3, 1.8] }),
        ),
        (
            |m| m.cracks[0] = Vec::new(),
            |e| matches!(e, GivenMeshError::Blocks(GeometryError::CrackOutside { crack: 0 })),
        ),
    ];
    for (number, (change, expected)) in cases.iter().enumerate() {
        let mut given = cracked();
        change(&mut given);
        let error = mesh(&given).map(|_| ()).expect_err("it is wrong");
        println!("{number}: {error}");
        assert!(expected(&error), "{number}: {error:?}");
    }
    let error = Mesh::of_given(&cracked(), &[], [3.0, 0.0], 0.8).map(|_| ());
    let level = GivenMeshError::WaterLevel { feature: Feature::Upstream, level: 3.0, below: 2.0, above: 4.0 };
    assert_eq!(error, Err(level));
}

/// A point within a millionth of the height is at the water level, the base, the heel.
#[test]
fn points_are_put_where_they_nearly_are() -> Result<(), GivenMeshError> {
    let mut given = cracked();
    given.points[3][1] += 1e-9;
    given.points[0] = [-1e-10, 2e-17];
    given.points[1][1] = -1e-12;
    let found = Mesh::of_given(&given, &[], [2.0, 0.0], 0.8)?;
    assert_eq!(found.nodes[found.upstream[0]], [0.0, 0.0]);
    assert!(found.base.iter().all(|&node| found.nodes[node][1] == 0.0));
    let wet = found.upstream_nodes_to(2.0);
    assert_eq!(found.nodes[wet[wet.len() - 1]], [0.0, 2.0]);
    Ok(())
}

/// A given mesh keeps its cells: each is in the zone that its centre lies in, and a zone without any is refused.
#[test]
fn zones_go_by_the_centres_of_cells() -> Result<(), GivenMeshError> {
    let zone = |[x0, x1]: [f64; 2]| vec![[x0, -1.0], [x1, -1.0], [x1, 5.0], [x0, 5.0]];
    let found = Mesh::of_given(&square(), &[zone([-1.0, 2.1])], [0.0; 2], 0.8)?;
    assert_eq!(found.cells, mesh(&square())?.cells);
    let inside = |cell: usize| found.nodes[found.cells[cell][4]][0] < 2.1;
    let zones: Vec<Option<usize>> = (0..found.cells.len()).map(|cell| inside(cell).then_some(0)).collect();
    assert_eq!(found.zones, zones);
    assert!(zones.contains(&None) && zones.contains(&Some(0)));
    let error = Mesh::of_given(&square(), &[zone([4.5, 6.0])], [0.0; 2], 0.8).map(|_| ());
    assert!(matches!(error, Err(GivenMeshError::Blocks(GeometryError::EmptyZone { zone: 0 }))), "{error:?}");
    Ok(())
}
