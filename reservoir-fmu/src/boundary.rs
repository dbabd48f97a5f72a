//! The boundary mesh: the water's outline divided into straight elements; elements share no nodes.
//!
//! Depends on `condition`, `outline` and `parameters`.

use crate::condition::BoundaryCondition;
use crate::outline::{Outline, Piece};
use crate::{ElementOrder, ReservoirParameters};
use std::f64::consts::LN_2;
use std::ops::Range;

/// A straight boundary element; the water is on its left going from `start` to `end`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// First end, m.
    pub start: [f64; 2],
    /// Second end, m.
    pub end: [f64; 2],
    /// Boundary condition.
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
        between(self.start, self.end, 0.5 * (1.0 + position))
    }
}

/// The point at the fraction `t` between two points; a coordinate that is equal in both is kept bit for bit.
fn between(start: [f64; 2], end: [f64; 2], t: f64) -> [f64; 2] {
    std::array::from_fn(|axis| {
        if start[axis] == end[axis] { start[axis] } else { start[axis] * (1.0 - t) + end[axis] * t }
    })
}

/// Elements in the order far end (downwards), bed (downstream), wet face (upwards), surface (upstream).
///
/// Nodes are numbered element by element.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryMesh {
    elements: Vec<Element>,
    order: ElementOrder,
}

impl BoundaryMesh {
    /// Meshes `outline` with the element sizes of `parameters`.
    ///
    /// On the face, element ends include its kinks and its coinciding points.
    pub fn new(outline: &Outline, parameters: &ReservoirParameters) -> Self {
        let mut elements = Vec::new();
        for piece in outline.pieces() {
            let grading = Grading::of(piece, parameters);
            let count = grading.count() as usize;
            let at = |i: usize| between(piece.start, piece.end, grading.share(i as f64 / count as f64));
            elements.extend((0..count).map(|i| Element {
                start: at(i),
                end: at(i + 1),
                condition: piece.condition,
            }));
        }
        Self { elements, order: parameters.element_order }
    }

    /// Number of elements that [`new`](Self::new) would make, even if they would not fit into memory.
    pub(crate) fn count(outline: &Outline, parameters: &ReservoirParameters) -> f64 {
        outline.pieces().iter().map(|piece| Grading::of(piece, parameters).count()).sum()
    }

    /// The elements.
    pub fn elements(&self) -> &[Element] {
        &self.elements
    }

    /// Shape functions of the elements.
    pub fn order(&self) -> ElementOrder {
        self.order
    }

    /// Coordinates of the nodes, m.
    pub fn nodes(&self) -> Vec<[f64; 2]> {
        self.elements.iter().flat_map(|e| self.order.nodes().iter().map(|&x| e.at(x))).collect()
    }

    /// Indices of the elements where `condition` holds.
    pub fn elements_of(&self, condition: BoundaryCondition) -> Range<usize> {
        let first = self.elements.iter().take_while(|e| e.condition != condition).count();
        first..first + self.elements.iter().filter(|e| e.condition == condition).count()
    }

    /// The nodes on the part of the boundary where `condition` holds.
    pub fn part(&self, condition: BoundaryCondition) -> Range<usize> {
        let (elements, nodes) = (self.elements_of(condition), self.order.nodes().len());
        nodes * elements.start..nodes * elements.end
    }
}

/// Lengths of the elements along a straight piece: at most `size`, and `finest` at a corner, from which each element
/// is at most twice as long as the one before.
///
/// The elements follow from their density 1/ℓ, with `ℓ = ln 2 (finest + distance from the corner)`, at most `size`:
/// N = ⌈∫ ds/ℓ⌉ elements, each with the same part of the integral. The j-th end from a corner then lies at
/// `finest (2^j − 1)` or closer.
struct Grading {
    length: f64,
    size: f64,
    finest: f64,
    /// Lengths of the graded ranges at both ends.
    graded: [f64; 2],
}

impl Grading {
    fn of(piece: &Piece, parameters: &ReservoirParameters) -> Self {
        let on_face = piece.condition == BoundaryCondition::WetFace;
        let elsewhere = parameters.bed_element_size.unwrap_or(parameters.element_size);
        let size = if on_face { parameters.element_size } else { elsewhere };
        let finest = parameters.corner_element_size.unwrap_or(size);
        let length = piece.length();
        let full = (size / LN_2 - finest).max(0.0);
        let most = if piece.corners == [true, true] { 0.5 * length } else { length };
        let graded = piece.corners.map(|corner| if corner && finest < size { full.min(most) } else { 0.0 });
        Self { length, size, finest, graded }
    }

    /// ∫ ds/ℓ over the graded ranges, and over the range between them.
    fn integrals(&self) -> [f64; 3] {
        let graded = |range: f64| (range / self.finest).ln_1p() / LN_2;
        let middle = (self.length - self.graded[0] - self.graded[1]).max(0.0);
        [graded(self.graded[0]), middle / self.size, graded(self.graded[1])]
    }

    /// Number of elements.
    fn count(&self) -> f64 {
        (self.integrals().iter().sum::<f64>() * (1.0 - 1e-9)).ceil().max(1.0)
    }

    /// Fraction of the length at which the fraction `t` of the integral is reached.
    fn share(&self, t: f64) -> f64 {
        if t == 0.0 || t == 1.0 || self.graded == [0.0; 2] {
            return t;
        }
        let [first, middle, last] = self.integrals();
        let reached = t * (first + middle + last);
        let graded = |integral: f64| self.finest * (integral * LN_2).exp_m1();
        let distance = if reached < first {
            graded(reached)
        } else if reached < first + middle {
            self.graded[0] + (reached - first) * self.size
        } else {
            self.length - graded(first + middle + last - reached)
        };
        distance / self.length
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_unit::WetFace;

    fn meshed(parameters: &ReservoirParameters) -> BoundaryMesh {
        BoundaryMesh::new(&Outline::new(parameters).unwrap(), parameters)
    }

    #[test]
    fn elements_break_at_kinks_and_coinciding_points_only() -> Result<(), cofferdam_unit::WetFaceError> {
        let face =
            WetFace::new(vec![[0.0, 0.0], [0.0, 4.0], [0.0, 10.0], [0.0, 10.0], [0.0, 12.0], [1.0, 20.0]])?;
        let parameters = ReservoirParameters {
            element_size: 5.0,
            far_end_distance: 10.0,
            ..ReservoirParameters::before(face)
        };
        let mesh = meshed(&parameters);
        let wet = &mesh.elements()[mesh.elements_of(BoundaryCondition::WetFace)];
        assert_eq!(wet.iter().map(|e| e.end[1]).collect::<Vec<_>>(), [5.0, 10.0, 12.0, 16.0, 20.0]);
        assert!(mesh.elements().iter().all(|e| e.length() <= 5.0));
        assert_eq!(mesh.part(BoundaryCondition::Radiation), 0..8);
        assert_eq!(mesh.part(BoundaryCondition::AbsorbingBed), 8..12);
        assert_eq!(mesh.part(BoundaryCondition::WetFace), 12..22);
        assert_eq!(mesh.part(BoundaryCondition::SurfaceWaves), 22..22);
        let constant = meshed(&ReservoirParameters { element_order: ElementOrder::Constant, ..parameters });
        assert_eq!(constant.part(BoundaryCondition::WetFace), 6..11);
        assert_eq!(constant.nodes()[6], [0.0, 2.5]);
        Ok(())
    }

    /// The mesh is closed, and lengths start with that at the corner and at most double.
    #[test]
    fn graded_elements_double_from_the_corners() -> Result<(), cofferdam_unit::WetFaceError> {
        let face = WetFace::new(vec![[0.0, 0.0], [0.0, 30.0], [8.0, 100.0]])?;
        for (size, bed, finest) in [(6.0, 11.0, 0.01), (6.0, 3.0, 4.1), (30.0, 90.0, 1.0), (5.0, 5.0, 9.0)] {
            let parameters = ReservoirParameters {
                bed: vec![[-20.0, 1.0], [-50.0, 10.0]],
                surface_waves: true,
                element_size: size,
                bed_element_size: Some(bed),
                corner_element_size: Some(finest),
                ..ReservoirParameters::before(face.clone())
            };
            let mesh = meshed(&parameters);
            let elements = mesh.elements();
            for (i, element) in elements.iter().enumerate() {
                let next = &elements[(i + 1) % elements.len()];
                assert_eq!(element.end, next.start);
                let most = if element.condition == BoundaryCondition::WetFace { size } else { bed };
                assert!(element.length() <= most * (1.0 + 1e-9), "{element:?}");
                let turns = (element.normal()[0] - next.normal()[0]).abs() > 1e-9;
                let ratio = next.length() / element.length();
                assert!(
                    turns || finest > size || (0.49999..2.00001).contains(&ratio),
                    "{ratio}: {element:?}"
                );
                let foot =
                    element.condition == BoundaryCondition::Radiation && next.condition != element.condition;
                if turns && !foot {
                    let longest = element.length().max(next.length());
                    assert!(longest <= finest * (1.0 + 1e-9), "{longest} at {:?}", element.end);
                }
            }
            println!("elements of {size}, {bed} and {finest} m: {}", elements.len());
            let outline = Outline::new(&parameters).unwrap();
            assert_eq!(BoundaryMesh::count(&outline, &parameters), elements.len() as f64);
        }
        Ok(())
    }
}
