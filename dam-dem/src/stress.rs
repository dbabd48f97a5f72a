//! Principal stresses at selected points of the section, and the largest of all.

use nalgebra::{DMatrix, DVectorView};

use crate::model::Model;
use crate::section::ELEVATION_TOLERANCE;
use crate::{Kinematics, Mesh, Section, StressRecovery};

/// Nodes at which stresses are reported: heel and toe, then the upstream and the downstream face at each elevation between
/// base and crest where one of the faces changes its slope, or the next node to it. Where a crack ends there, the node of the
/// block below.
pub(crate) fn stress_points(section: &Section, mesh: &Mesh) -> Vec<usize> {
    let tolerance = ELEVATION_TOLERANCE * section.height();
    let mut bends: Vec<f64> = section.vertex_elevations().collect();
    bends.retain(|y| *y > tolerance && *y < section.height() - tolerance);
    bends.sort_by(f64::total_cmp);
    bends.dedup_by(|a, b| *a - *b < tolerance);
    let at = |level: f64| {
        let far = |node: &usize| (mesh.nodes[*node][1] - level).abs();
        // nodes of the block below come first
        [&mesh.upstream, &mesh.downstream]
            .map(|side| side.iter().min_by(|a, b| far(a).total_cmp(&far(b))).copied())
    };
    std::iter::once(0.0).chain(bends).flat_map(at).flatten().collect()
}

/// How stresses at nodes follow from the coordinates of a model.
#[derive(Clone, Debug)]
pub(crate) enum NodalStresses {
    /// By recovery at all corners of cells.
    OfElements(StressRecovery),
    /// Modes describe rotations to first order only, so that their stress, of small strains, is linear in their coordinates:
    /// three rows (xx, yy, xy) for each of the nodes, which are those on the outlines of the blocks, as a product with all
    /// would take longer than a step.
    OfModes { nodes: Vec<usize>, operator: DMatrix<f64> },
}

impl NodalStresses {
    /// The stresses of `model`.
    pub fn new(model: &Model) -> Self {
        let structure = &model.body().structure;
        let recovery = StressRecovery::new(&structure.mesh);
        let Some(modes) = model.superposition() else { return Self::OfElements(recovery) };
        let outline = recovery.outline();
        let mut operator = DMatrix::zeros(3 * outline.len(), modes.mode_count());
        for (mode, mut column) in operator.column_iter_mut().enumerate() {
            let mut coordinates = vec![0.0; modes.mode_count()];
            coordinates[mode] = 1.0;
            let shape: Vec<[f64; 2]> =
                (0..structure.mesh.nodes.len()).map(|node| modes.at_node(node, &coordinates)).collect();
            let stresses = recovery.stresses(&structure.cells, &shape, Kinematics::Small);
            for (i, &at) in outline.iter().enumerate() {
                (0..3).for_each(|k| column[3 * i + k] = stresses[at][k]);
            }
        }
        Self::OfModes { nodes: outline.iter().map(|&at| recovery.nodes()[at]).collect(), operator }
    }

    /// Principal stresses for the displacements (m, x then y of each node) or modal `coordinates`, with stress points at the
    /// nodes `points`.
    pub fn principal(
        &self,
        model: &Model,
        coordinates: &[f64],
        kinematics: Kinematics,
        points: &[usize],
    ) -> PrincipalStresses {
        match self {
            Self::OfElements(recovery) => {
                let cells = &model.body().structure.cells;
                let stresses = recovery.stresses(cells, coordinates.as_chunks().0, kinematics);
                PrincipalStresses::of(recovery.nodes(), &stresses, points)
            }
            Self::OfModes { nodes, operator } => {
                let stresses = operator * DVectorView::from_slice(coordinates, coordinates.len());
                PrincipalStresses::of(nodes, stresses.as_slice().as_chunks().0, points)
            }
        }
    }
}

/// Principal stresses of one instant, Pa, tension positive.
#[derive(Clone, Debug)]
pub(crate) struct PrincipalStresses {
    /// The larger and the smaller one at each stress point.
    pub at_points: Vec<[f64; 2]>,
    /// The largest of the whole dam, and the node where it is.
    pub largest: (f64, usize),
    /// The smallest.
    pub smallest: (f64, usize),
}

impl PrincipalStresses {
    /// Those of `stresses` (xx, yy, xy, Pa) at `nodes`, with stress points at the nodes `points`.
    pub fn of(nodes: &[usize], stresses: &[[f64; 3]], points: &[usize]) -> Self {
        let first = nodes.first().copied().unwrap_or_default();
        let (mut largest, mut smallest) = ((f64::NEG_INFINITY, first), (f64::INFINITY, first));
        let mut at_points = vec![[0.0; 2]; points.len()];
        for (&node, &stress) in nodes.iter().zip(stresses) {
            let [major, minor] = principal(stress);
            if major > largest.0 {
                largest = (major, node);
            }
            if minor < smallest.0 {
                smallest = (minor, node);
            }
            let here = at_points.iter_mut().zip(points).filter(|(_, point)| **point == node);
            here.for_each(|(at, _)| *at = [major, minor]);
        }
        Self { at_points, largest, smallest }
    }
}

/// Larger and smaller principal stress of (xx, yy, xy), Pa.
pub(crate) fn principal([xx, yy, xy]: [f64; 3]) -> [f64; 2] {
    let (mean, half) = ((xx + yy) / 2.0, (xx - yy) / 2.0);
    let radius = (half * half + xy * xy).sqrt();
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
            galleries: Vec::new(),
        };
        let mesh = Mesh::new(&section, &[66.5], &[], 10.0);
        let points = stress_points(&section, &mesh);
        let places: Vec<[f64; 2]> = points.iter().map(|&node| mesh.nodes[node]).collect();
        assert_eq!(places, [[0.0, 0.0], [70.0, 0.0], [0.0, 66.5], [19.25, 66.5]]);
        assert!(points.iter().all(|node| mesh.blocks[0].nodes.contains(node)));
    }
}
