//! The wet faces of the dam, and the nodal forces of pressure on them.

use cofferdam_unit::{WetFace, WetFaceError};
use std::ops::Range;

use crate::Mesh;
use crate::load_basis::LoadBasis;

/// Nodal forces of a pressure that is linear along each panel: `F = B p`, with precomputed weights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PressureLoad(pub(crate) LoadBasis);

impl PressureLoad {
    /// Pressure on `nodes`, one node for each point of `face`.
    pub fn new(face: &WetFace, nodes: &[usize]) -> Self {
        let mut new = Self::default();
        new.append(face, nodes, 0);
        new
    }

    /// Adds a `face`, of which the points are counted from `first` on.
    fn append(&mut self, face: &WetFace, nodes: &[usize], first: usize) {
        let mut unit = vec![0.0; face.len()];
        for point in 0..face.len() {
            unit[point] = 1.0;
            let forces = face.nodal_forces(&unit);
            let loaded = (0..face.len()).filter(|&i| forces[i] != [0.0, 0.0]);
            self.0.entries.extend(loaded.map(|i| (nodes[i], first + point, forces[i])));
            unit[point] = 0.0;
        }
        self.0.columns = first + face.len();
    }

    /// Node, interface point, and force per pressure, m, of all entries of B.
    pub fn entries(&self) -> &[(usize, usize, [f64; 2])] {
        &self.0.entries
    }

    /// Adds `B p` to `forces` (N/m); `pressure` (Pa) holds one value for each interface point.
    pub fn add(&self, pressure: &[f64], forces: &mut [[f64; 2]]) {
        self.0.add(pressure, forces);
    }
}

/// The points of the wet faces, those of the upstream one first, and the nodes on them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wet {
    /// The upstream face and that of the tailwater; `None` without water.
    pub faces: [Option<WetFace>; 2],
    pub normals: Vec<[f64; 2]>,
    pub nodes: Vec<usize>,
    pub load: PressureLoad,
}

impl Wet {
    /// The wet faces of a mesh with water up to `levels` (m) upstream and downstream, 0 for none; `None` without any water.
    pub fn below(mesh: &Mesh, levels: [f64; 2]) -> Result<Option<Self>, WetFaceError> {
        let mut wet = Self::default();
        let [upstream, downstream] = levels;
        for (side, level, nodes) in [
            (0, upstream, mesh.upstream_nodes_to(upstream)),
            (1, downstream, mesh.downstream_nodes_to(downstream)),
        ] {
            if level == 0.0 {
                continue;
            }
            let nodes = double_at_kinks(mesh, &nodes);
            let face = WetFace::new(nodes.iter().map(|&node| mesh.nodes[node]).collect())?;
            wet.load.append(&face, &nodes, wet.nodes.len());
            wet.normals.extend(face.normals());
            wet.nodes.extend(nodes);
            wet.faces[side] = Some(face);
        }
        Ok((!wet.nodes.is_empty()).then_some(wet))
    }

    /// Number of points of both faces.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// The points of the upstream face among all, and those of the tailwater's.
    pub fn ranges(&self) -> [Range<usize>; 2] {
        let upstream = self.faces[0].as_ref().map_or(0, WetFace::len);
        [0..upstream, upstream..self.len()]
    }

    /// Depth of each point below its water's level, 0 at the points of the other `side`.
    pub fn depths(&self, side: usize) -> Vec<f64> {
        let mut depths = vec![0.0; self.len()];
        if let Some(face) = &self.faces[side] {
            for (depth, point) in depths[self.ranges()[side].clone()].iter_mut().zip(face.points()) {
                *depth = face.depth() - point[1];
            }
        }
        depths
    }

    /// Hydrostatic pressure at the points for the `specific_weights` of the water upstream and downstream (N/m³), Pa.
    pub fn hydrostatic(&self, specific_weights: [f64; 2]) -> Vec<f64> {
        let [upstream, downstream] = [0, 1].map(|side| self.depths(side));
        let pressure = |(a, b)| specific_weights[0] * a + specific_weights[1] * b;
        upstream.iter().zip(&downstream).map(pressure).collect()
    }
}

/// The chain of nodes, in which nodes at a kink of the face occur twice, so that the points of each panel
/// have the normal of this panel. Nodes at a crack are doubled already.
fn double_at_kinks(mesh: &Mesh, chain: &[usize]) -> Vec<usize> {
    let turn = |[a, b, c]: [usize; 3]| {
        let [a, b, c] = [a, b, c].map(|node| mesh.nodes[node]);
        (b[0] - a[0]) * (c[1] - b[1]) - (c[0] - b[0]) * (b[1] - a[1])
    };
    let mut nodes = Vec::new();
    for (i, &node) in chain.iter().enumerate() {
        nodes.push(node);
        if i > 0 && i + 1 < chain.len() {
            let [before, after] = [chain[i - 1], chain[i + 1]];
            let length = mesh.nodes[after][1] - mesh.nodes[before][1];
            let alone = mesh.nodes[before] != mesh.nodes[node] && mesh.nodes[after] != mesh.nodes[node];
            if alone && turn([before, node, after]).abs() > KINK * length * length {
                nodes.push(node);
            }
        }
    }
    nodes
}

/// Smallest change of direction that counts as a kink, approximately the sine of its angle.
const KINK: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kink_has_two_points_with_a_normal_each() -> Result<(), WetFaceError> {
        let section = crate::Section::new(
            vec![[0.0, 0.0], [4.0, 40.0], [4.0, 100.0]],
            vec![[70.0, 0.0], [20.0, 100.0]],
        );
        for (cracks, points) in [(vec![], 12), (vec![40.0], 12), (vec![70.0], 13)] {
            let mesh = Mesh::new(&section, &cracks, &[100.0], 10.0);
            let wet = Wet::below(&mesh, [100.0, 0.0])?.map(|wet| (wet.len(), wet.normals));
            let (count, normals) = wet.unwrap_or_default();
            assert_eq!(count, points);
            assert!(normals.iter().all(|n| n[1] == 0.0 || (n[1] / n[0] + 0.1).abs() < 1e-12), "{normals:?}");
        }
        Ok(())
    }

    #[test]
    fn the_weights_give_the_forces_of_the_wet_face() -> Result<(), cofferdam_unit::WetFaceError> {
        let face = WetFace::new(vec![[0.0, 0.0], [0.4, 3.0], [0.4, 3.0], [0.5, 7.0]])?;
        let pressure = [3.0, -1.0, 2.0, 5.0];
        let mut forces = vec![[0.0; 2]; 4];
        PressureLoad::new(&face, &[0, 1, 2, 3]).add(&pressure, &mut forces);
        for (a, b) in forces.iter().flatten().zip(face.nodal_forces(&pressure).iter().flatten()) {
            assert!((a - b).abs() < 1e-14);
        }
        Ok(())
    }
}
