use crate::boundary::{BoundaryMesh, Element};
use crate::condition::BoundaryCondition;
use crate::outline::Outline;
use crate::{ReservoirError, ReservoirParameters};
use spade::{
    AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, RefinementResult,
    Triangulation,
};
use std::collections::HashMap;

/// Smallest angle of a triangle, degrees; refinement provably ends up to 20.7°, in practice up to 30°.
const LEAST_ANGLE: f64 = 28.0;

/// Largest number of triangles.
const MOST_TRIANGLES: f64 = 4e5;

/// An edge of a triangle on the outline, in counterclockwise direction.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryEdge {
    /// Node at the start, in the middle, at the end.
    pub nodes: [usize; 3],
    /// Boundary condition.
    pub condition: BoundaryCondition,
    /// Length of the wet face up to the edge's start, m; used on the face only.
    pub arc: f64,
    /// Length, m.
    pub length: f64,
    /// Unit normal out of the water.
    pub normal: [f64; 2],
}

/// Triangles of six nodes: the corners counterclockwise, then the middles of the sides from the first corner to the
/// second, the second to the third, the third to the first. Sides are straight.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh {
    /// Coordinates of the nodes, m.
    pub nodes: Vec<[f64; 2]>,
    /// The nodes of each triangle.
    pub triangles: Vec<[usize; 6]>,
    /// The edges on the outline, counterclockwise from the heel.
    pub boundary: Vec<BoundaryEdge>,
}

impl TriangleMesh {
    /// Triangulates the parameters' water: a Delaunay triangulation within its boundary elements, refined until no angle
    /// is below 28° (except angles of the outline) and no triangle is larger than half the square of the larger element
    /// size. Towards short boundary elements the triangles become small accordingly.
    ///
    /// The result is the same bit for bit every time: nothing runs in parallel, and no unordered set is iterated.
    ///
    /// **Errors**: those of the outline, [`ReservoirError::TooMuch`], [`ReservoirError::Mesh`].
    pub fn new(parameters: &ReservoirParameters) -> Result<Self, ReservoirError> {
        let size = parameters.element_size;
        let largest = parameters.bed_element_size.unwrap_or(size).max(size);
        let ring = ring(parameters)?;
        let expected = 2.0 * (2.0 * area(&ring) / (largest * largest)) + 8.0 * ring.len() as f64;
        if expected > MOST_TRIANGLES {
            let (what, most) = ("finite elements", MOST_TRIANGLES);
            let remedy = "raise `element_size`, or lower `far_end_distance`";
            return Err(ReservoirError::TooMuch { what, value: expected, most, remedy });
        }
        let refined = refine(&ring, largest, MOST_TRIANGLES as usize)?;
        Self::quadratic(&ring, &refined)
    }

    /// Triangles with their middle nodes, and the boundary's edges in order.
    fn quadratic(ring: &[Element], refined: &Refined) -> Result<Self, ReservoirError> {
        let mut nodes = refined.vertices.clone();
        let mut middles = HashMap::new();
        let mut triangles = Vec::with_capacity(refined.triangles.len());
        // The next vertex of each vertex along the boundary; edges that occur in both directions have been removed.
        let mut directed = HashMap::new();
        for &[a, b, c] in &refined.triangles {
            let middle = [[a, b], [b, c], [c, a]].map(|[from, to]| {
                directed.insert([from, to], ());
                *middles.entry([from.min(to), from.max(to)]).or_insert_with(|| {
                    nodes.push([0, 1].map(|axis| 0.5 * (nodes[from][axis] + nodes[to][axis])));
                    nodes.len() - 1
                })
            });
            triangles.push([a, b, c, middle[0], middle[1], middle[2]]);
        }
        let outer = directed.keys().filter(|[from, to]| !directed.contains_key(&[*to, *from]));
        let next: HashMap<usize, usize> = outer.map(|&[from, to]| (from, to)).collect();

        let mut boundary = Vec::with_capacity(next.len());
        let (mut vertex, mut arc) = (0, 0.0);
        for &Element { end, condition, .. } in ring {
            while nodes[vertex] != end || vertex == 0 && boundary.is_empty() {
                let to = *next.get(&vertex).ok_or(ReservoirError::Mesh)?;
                let middle = *middles.get(&[vertex.min(to), vertex.max(to)]).ok_or(ReservoirError::Mesh)?;
                let (start, stop) = (nodes[vertex], nodes[to]);
                let length = distance(start, stop);
                let normal = [(stop[1] - start[1]) / length, -(stop[0] - start[0]) / length];
                boundary.push(BoundaryEdge { nodes: [vertex, middle, to], condition, arc, length, normal });
                arc += length;
                vertex = to;
                if boundary.len() > next.len() {
                    return Err(ReservoirError::Mesh);
                }
            }
        }
        if vertex != 0 || boundary.len() != next.len() {
            return Err(ReservoirError::Mesh);
        }
        Ok(Self { nodes, triangles, boundary })
    }

    /// The boundary's edges where `condition` holds, counterclockwise.
    pub fn edges(&self, condition: BoundaryCondition) -> impl Iterator<Item = &BoundaryEdge> {
        self.boundary.iter().filter(move |edge| edge.condition == condition)
    }
}

/// The boundary elements of the water and its surface, counterclockwise from the heel.
fn ring(parameters: &ReservoirParameters) -> Result<Vec<Element>, ReservoirError> {
    let closed = ReservoirParameters { surface_waves: true, ..parameters.clone() };
    let boundary = BoundaryMesh::new(&Outline::new(&closed)?, &closed);
    let mut ring = boundary.elements().to_vec();
    ring.rotate_left(boundary.elements_of(BoundaryCondition::WetFace).start);
    Ok(ring)
}

/// Area that the elements enclose, m².
fn area(ring: &[Element]) -> f64 {
    ring.iter().map(|e| 0.5 * (e.start[0] * e.end[1] - e.start[1] * e.end[0])).sum()
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// Vertices, the elements' starts first, and triangles, counterclockwise.
struct Refined {
    vertices: Vec<[f64; 2]>,
    triangles: Vec<[usize; 3]>,
}

/// The refined constrained Delaunay triangulation of the ring's inside.
fn refine(ring: &[Element], size: f64, most: usize) -> Result<Refined, ReservoirError> {
    let points: Vec<Point2<f64>> = ring.iter().map(|e| Point2::new(e.start[0], e.start[1])).collect();
    let count = points.len();
    let sides = (0..count).map(|i| [i, (i + 1) % count]).collect();
    let mut conflict = false;
    let mut triangulation =
        ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(points, sides, |_| {
            conflict = true
        })
        .map_err(|_| ReservoirError::Mesh)?;
    if conflict || triangulation.num_vertices() != count {
        return Err(ReservoirError::Mesh);
    }
    let RefinementResult { excluded_faces, refinement_complete } = triangulation.refine(
        RefinementParameters::new()
            .exclude_outer_faces(true)
            .with_angle_limit(AngleLimit::from_deg(LEAST_ANGLE))
            .with_max_allowed_area(0.5 * size * size)
            .with_max_additional_vertices(most),
    );
    if !refinement_complete {
        return Err(ReservoirError::Mesh);
    }
    let mut outside = vec![false; triangulation.num_all_faces()];
    excluded_faces.iter().for_each(|face| outside[face.index()] = true);
    let vertices = triangulation.vertices().map(|v| [v.position().x, v.position().y]).collect();
    let inside = triangulation.inner_faces().filter(|face| !outside[face.fix().index()]);
    let triangles = inside.map(|face| face.vertices().map(|v| v.fix().index())).collect();
    Ok(Refined { vertices, triangles })
}

/// A kinked, overhanging face with a crack, over a bed with a trench. The kink has two coinciding points, so that the
/// normal velocity of a rigid motion is right on either side.
#[cfg(test)]
pub fn rugged(element_size: f64) -> ReservoirParameters {
    let face = vec![
        [0.0, 0.0],
        [1.0, 10.0],
        [2.0, 20.0],
        [2.0, 20.0],
        [-3.0, 30.0],
        [-3.0, 30.0],
        [-5.0, 34.0],
        [-5.0, 34.0],
        [0.0, 50.0],
    ];
    ReservoirParameters {
        bed: vec![[-10.0, -6.0], [-18.0, -6.0], [-25.0, 4.0]],
        element_size,
        far_end_distance: 30.0,
        wave_reflection_coefficient: 0.6,
        ..ReservoirParameters::before(cofferdam_unit::WetFace::new(face).expect("a face"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finite_elements::element::stiffness;

    /// The triangles fill the outline, have no angle below the least one, and follow the outline's pieces.
    #[test]
    fn triangles_fill_the_outline() -> Result<(), ReservoirError> {
        // A wedge of 18° at the water level, as before an embankment, keeps its angle and is meshed.
        let wedge = ReservoirParameters {
            element_size: 2.0,
            ..ReservoirParameters::before(cofferdam_unit::WetFace::straight([60.0, 20.0], 4).unwrap())
        };
        let (mesh, exact_area) = (TriangleMesh::new(&wedge)?, area(&ring(&wedge)?));
        let corners = |triangle: &[usize; 6]| [0, 1, 2].map(|i| mesh.nodes[triangle[i]]);
        let area: f64 = mesh.triangles.iter().map(|triangle| stiffness(corners(triangle)).0).sum();
        println!("wedge of 18°: {} triangles", mesh.triangles.len());
        assert!((area / exact_area - 1.0).abs() < 1e-12 && mesh.triangles.len() < 4000);
        for (size, bed_element_size, corner_element_size) in
            [(8.0, None, None), (3.0, Some(6.0), None), (5.0, None, Some(0.05)), (200.0, None, None)]
        {
            let parameters = ReservoirParameters { bed_element_size, corner_element_size, ..rugged(size) };
            let (mesh, exact_area) = (TriangleMesh::new(&parameters)?, super::area(&ring(&parameters)?));
            let (mut area, mut least): (f64, f64) = (0.0, 180.0);
            for triangle in &mesh.triangles {
                let corners = [0, 1, 2].map(|i| mesh.nodes[triangle[i]]);
                let (a, _) = stiffness(corners);
                assert!(a > 0.0);
                area += a;
                for i in 0..3 {
                    let [p, q, r] = [corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]];
                    let sine = 2.0 * a / (distance(p, q) * distance(p, r));
                    let cosine = (q[0] - p[0]) * (r[0] - p[0]) + (q[1] - p[1]) * (r[1] - p[1]);
                    least = least.min(sine.atan2(cosine / (distance(p, q) * distance(p, r))).to_degrees());
                }
            }
            let lengths = |condition| mesh.edges(condition).map(|edge| edge.length);
            let longest = lengths(BoundaryCondition::WetFace).fold(0.0, f64::max);
            let face: f64 = lengths(BoundaryCondition::WetFace).sum();
            let exact: f64 = parameters.wet_face.panels().map(|panel| panel.length).sum();
            println!(
                "size {size}, corners {corner_element_size:?}: {} triangles, {} nodes, least angle {least:.1}°, longest edge {longest:.2} m",
                mesh.triangles.len(),
                mesh.nodes.len()
            );
            assert!((area / exact_area - 1.0).abs() < 1e-12 && (face / exact - 1.0).abs() < 1e-12);
            assert!(least > 27.9 && longest <= size * (1.0 + 1e-9));
            let closed: f64 = mesh.boundary.iter().map(|e| e.length * e.normal[0]).sum();
            assert!(closed.abs() < 1e-11 && mesh.boundary[0].nodes[0] == 0);
        }
        Ok(())
    }
}
