//! Principal stresses at selected points of the section, and the largest of all.

use crate::modal_field::ModalField;
use crate::model::Model;
use crate::recovery::principal;
use crate::reduction::Superposition;
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
    /// Modes describe rotations to first order only, so that their stress, of small strains, is linear in their coordinates.
    OfModes {
        /// The nodes: those on the outlines of the blocks, as a product with all corners takes as long as the step at some meshes.
        nodes: Vec<usize>,
        /// xx, yy, xy at each of `nodes`, Pa.
        stresses: ModalField<3>,
    },
}

impl NodalStresses {
    /// The stresses of `model`.
    pub fn new(model: &Model, recovery: &StressRecovery) -> Self {
        let Some(modes) = model.superposition() else { return Self::OfElements(recovery.clone()) };
        let (nodes, stresses) = modal_stresses(model, modes, recovery, recovery.outline());
        Self::OfModes { nodes, stresses }
    }

    /// Stresses (xx, yy, xy, Pa) for the displacements (m, x then y of each node) or modal `coordinates`.
    pub fn stresses(&self, model: &Model, coordinates: &[f64], kinematics: Kinematics) -> Vec<[f64; 3]> {
        match self {
            Self::OfElements(recovery) => {
                let cells = &model.body().structure.cells;
                recovery.stresses(cells, coordinates.as_chunks().0, kinematics)
            }
            Self::OfModes { stresses, .. } => stresses.at(coordinates),
        }
    }

    /// Principal stresses of `stresses`, with stress points at the nodes `points`; with modes those on the outlines of the blocks.
    pub fn principal(&self, stresses: &[[f64; 3]], points: &[usize]) -> PrincipalStresses {
        match self {
            Self::OfElements(recovery) => {
                PrincipalStresses::of(recovery.nodes().iter().copied().zip(stresses.iter().copied()), points)
            }
            Self::OfModes { nodes, .. } => {
                PrincipalStresses::of(nodes.iter().copied().zip(stresses.iter().copied()), points)
            }
        }
    }
}

/// The nodes at these `places` among the corners of cells, and the stresses (xx, yy, xy, Pa) at them.
pub(crate) fn modal_stresses(
    model: &Model,
    modes: &Superposition,
    recovery: &StressRecovery,
    places: &[usize],
) -> (Vec<usize>, ModalField<3>) {
    let structure = &model.body().structure;
    let nodes: Vec<usize> = places.iter().map(|&at| recovery.nodes()[at]).collect();
    let stresses = ModalField::new(&structure.mesh, modes, &nodes, |shape| {
        let of_all = recovery.stresses(&structure.cells, shape, Kinematics::Small);
        places.iter().map(|&at| of_all[at]).collect()
    });
    (nodes, stresses)
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
    /// Those of the stresses (xx, yy, xy, Pa) at nodes, with stress points at the nodes `points`.
    fn of(stresses: impl Iterator<Item = (usize, [f64; 3])>, points: &[usize]) -> Self {
        let mut stresses = stresses.peekable();
        let first = stresses.peek().map_or(0, |(node, _)| *node);
        let (mut largest, mut smallest) = ((f64::NEG_INFINITY, first), (f64::INFINITY, first));
        let mut at_points = vec![[0.0; 2]; points.len()];
        for (node, stress) in stresses {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heel_toe_and_both_faces_at_a_bend_are_watched_below_a_crack() {
        let section = Section::default();
        let mesh = Mesh::new(&section, &[66.5], &[], 10.0);
        let points = stress_points(&section, &mesh);
        let places: Vec<[f64; 2]> = points.iter().map(|&node| mesh.nodes[node]).collect();
        assert_eq!(places, [[0.0, 0.0], [70.0, 0.0], [0.0, 66.5], [19.25, 66.5]]);
        assert!(points.iter().all(|node| mesh.blocks[0].nodes.contains(node)));
    }
}
