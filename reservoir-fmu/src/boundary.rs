//! The boundary mesh: far end, bed and wet face in straight discontinuous linear elements.
//!
//! Depends on `condition`.

use crate::condition::BoundaryCondition;
use interface::WetFace;
use std::ops::Range;

/// Position of the two nodes of an element, ±1/√3: those of Gauss' two-point rule.
pub(crate) const NODE: f64 = 0.577_350_269_189_625_8;

/// Linear shape functions of an element's two nodes at ξ.
pub(crate) fn shape(position: f64) -> [f64; 2] {
    [0.5 * (1.0 - position / NODE), 0.5 * (1.0 + position / NODE)]
}

/// A straight boundary element; the water is on its left going from `start` to `end`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// First end, m.
    pub start: [f64; 2],
    /// Second end, m.
    pub end: [f64; 2],
    /// What holds on it.
    pub condition: BoundaryCondition,
}

impl Element {
    /// Length, m.
    pub fn length(&self) -> f64 {
        (self.end[0] - self.start[0]).hypot(self.end[1] - self.start[1])
    }

    /// Unit normal out of the water.
    pub fn normal(&self) -> [f64; 2] {
        let length = self.length();
        [(self.end[1] - self.start[1]) / length, -(self.end[0] - self.start[0]) / length]
    }

    /// Coordinates (m) at ξ in [−1, 1].
    pub fn at(&self, position: f64) -> [f64; 2] {
        let t = 0.5 * (1.0 + position);
        std::array::from_fn(|axis| self.start[axis] * (1.0 - t) + self.end[axis] * t)
    }
}

/// Elements in the order far end (downwards), bed (downstream), wet face (upwards).
///
/// Element e carries the nodes 2e and 2e + 1.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryMesh {
    elements: Vec<Element>,
}

impl BoundaryMesh {
    /// Meshes the water before `face` with elements no longer than `element_size` (m).
    ///
    /// The far end stands `far_end_distance` (m) upstream of the face's most upstream point.
    /// On the face, element ends include its kinks and its coinciding points.
    pub fn new(face: &WetFace, element_size: f64, far_end_distance: f64) -> Self {
        let upstream = face.points().iter().fold(0.0, |x: f64, p| x.min(p[0])) - far_end_distance;
        let mut elements = Vec::new();
        let mut mesh = |start: [f64; 2], end: [f64; 2], condition| {
            let length = (end[0] - start[0]).hypot(end[1] - start[1]);
            let count = (length / element_size * (1.0 - 1e-9)).ceil().max(1.0);
            let whole = Element { start, end, condition };
            let at = |i: usize| whole.at(2.0 * i as f64 / count - 1.0);
            elements.extend((0..count as usize).map(|i| Element { start: at(i), end: at(i + 1), condition }));
        };
        mesh([upstream, face.depth()], [upstream, 0.0], BoundaryCondition::Radiation);
        mesh([upstream, 0.0], [0.0, 0.0], BoundaryCondition::AbsorbingBed);
        for [first, last] in face.straight_pieces() {
            mesh(face.points()[first], face.points()[last], BoundaryCondition::WetFace);
        }
        Self { elements }
    }

    /// The elements.
    pub fn elements(&self) -> &[Element] {
        &self.elements
    }

    /// Coordinates of the nodes, m.
    pub fn nodes(&self) -> Vec<[f64; 2]> {
        self.elements.iter().flat_map(|e| [e.at(-NODE), e.at(NODE)]).collect()
    }

    /// The nodes on the part of the boundary where `condition` holds.
    pub fn part(&self, condition: BoundaryCondition) -> Range<usize> {
        let first = self.elements.iter().take_while(|e| e.condition != condition).count();
        let count = self.elements.iter().filter(|e| e.condition == condition).count();
        2 * first..2 * (first + count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_break_at_kinks_and_coinciding_points_only() -> Result<(), interface::WetFaceError> {
        let face =
            WetFace::new(vec![[0.0, 0.0], [0.0, 4.0], [0.0, 10.0], [0.0, 10.0], [0.0, 12.0], [1.0, 20.0]])?;
        let mesh = BoundaryMesh::new(&face, 5.0, 10.0);
        let wet: Vec<_> =
            mesh.elements().iter().filter(|e| e.condition == BoundaryCondition::WetFace).collect();
        assert_eq!(wet.iter().map(|e| e.end[1]).collect::<Vec<_>>(), [5.0, 10.0, 12.0, 16.0, 20.0]);
        assert!(mesh.elements().iter().all(|e| e.length() <= 5.0));
        assert_eq!(mesh.part(BoundaryCondition::Radiation), 0..8);
        assert_eq!(mesh.part(BoundaryCondition::AbsorbingBed), 8..12);
        assert_eq!(mesh.part(BoundaryCondition::WetFace), 12..22);
        Ok(())
    }
}
