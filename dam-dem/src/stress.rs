//! Stresses at selected points of the section.

use crate::section::ELEVATION_TOLERANCE;
use crate::{Mesh, Section};

/// A point on the outline of the section where stresses are computed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StressPoint {
    /// Unloaded position, m.
    pub place: [f64; 2],
    /// The triangles that meet there: index, corners and area (m²). Where a crack ends at the point, only
    /// triangles of the block below.
    pub triangles: Vec<(usize, [usize; 3], f64)>,
}

/// Heel and toe, then points on the upstream and the downstream face at each elevation between base and crest
/// where one of the faces changes its slope.
pub(crate) fn stress_points(section: &Section, mesh: &Mesh) -> Vec<StressPoint> {
    let tolerance = ELEVATION_TOLERANCE * section.height();
    let mut bends: Vec<f64> = section.vertex_elevations().collect();
    bends.retain(|y| *y > tolerance && *y < section.height() - tolerance);
    bends.sort_by(f64::total_cmp);
    bends.dedup_by(|a, b| *a - *b < tolerance);
    let at = |level: f64| {
        // nodes of the block below come first
        let row = (0..mesh.nodes.len()).filter(|&node| (mesh.nodes[node][1] - level).abs() < tolerance);
        let x = |node: &usize| mesh.nodes[*node][0];
        let upstream = row.clone().min_by(|a, b| x(a).total_cmp(&x(b)));
        let downstream = row.rev().max_by(|a, b| x(a).total_cmp(&x(b)));
        [upstream, downstream]
    };
    let nodes = std::iter::once(0.0).chain(bends).flat_map(at).flatten();
    nodes.map(|node| StressPoint { place: mesh.nodes[node], triangles: triangles_at(mesh, node) }).collect()
}

fn triangles_at(mesh: &Mesh, node: usize) -> Vec<(usize, [usize; 3], f64)> {
    let area = |[a, b, c]: [usize; 3]| {
        let [a, b, c] = [a, b, c].map(|node| mesh.nodes[node]);
        ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])) / 2.0
    };
    let found = mesh.triangles().enumerate().filter(|(_, corners)| corners.contains(&node));
    found.map(|(index, corners)| (index, corners, area(corners))).collect()
}

/// Larger and smaller principal stress of (xx, yy, xy), Pa.
pub(crate) fn principal([xx, yy, xy]: [f64; 3]) -> [f64; 2] {
    let (mean, radius) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
    [mean + radius, mean - radius]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_stresses_are_those_of_a_turned_state() {
        let (s, c) = 0.7f64.sin_cos();
        let (major, minor) = (3.0, -5.0);
        let turned = [c * c * major + s * s * minor, s * s * major + c * c * minor, s * c * (major - minor)];
        let found = principal(turned);
        assert!((found[0] - major).abs() < 1e-14 && (found[1] - minor).abs() < 1e-14, "{found:?}");
    }

    #[test]
    fn heel_toe_and_both_faces_at_a_bend_are_watched_below_a_crack() {
        let section = Section {
            upstream: vec![[0.0, 0.0], [0.0, 103.0]],
            downstream: vec![[70.0, 0.0], [19.25, 66.5], [14.8, 103.0]],
        };
        let mesh = Mesh::new(&section, &[66.5], &[], 10.0);
        let points = stress_points(&section, &mesh);
        let places: Vec<[f64; 2]> = points.iter().map(|point| point.place).collect();
        assert_eq!(places, [[0.0, 0.0], [70.0, 0.0], [0.0, 66.5], [19.25, 66.5]]);
        let below = mesh.blocks[0].cells.end * 4;
        assert!(points.iter().flat_map(|point| &point.triangles).all(|(triangle, ..)| *triangle < below));
        assert!(points.iter().all(|point| point.triangles.len() == 2));
    }
}
