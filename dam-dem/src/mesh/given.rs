//! Meshes that were made elsewhere.

use std::collections::{HashMap, HashSet};

use cofferdam_unit::number::plain;
use serde::{Deserialize, Serialize};

use super::Mesh;
use super::arrangement::{Arrangement, CrackEdge, Edge};
use super::geometry_error::{Feature, GeometryError};
use super::plane_geometry::{Point, area, distance, orientation};
use super::quality::{LEAST_ANGLE, Quality};
use super::topology::{Polygon, Tiling};
use super::triangulation::MOST_CELLS;

/// Points closer than this share of the height are one.
const SNAP: f64 = 1e-6;
/// Largest distance of a point from the heel, m.
const FARTHEST: f64 = 1e6;

/// Triangles and quadrilaterals that fill the section, and its named lines as chains of points.
///
/// Polygons meet side to side, across cracks too: along these the mesh is parted. They may be in either direction. Points
/// that no polygon uses are left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GivenMesh {
    /// Points, m, with the heel as the origin.
    pub points: Vec<[f64; 2]>,
    /// Corners of triangles.
    pub triangles: Vec<[usize; 3]>,
    /// Corners of quadrilaterals, around each.
    pub quadrilaterals: Vec<[usize; 4]>,
    /// The upstream side, from the heel to the crest.
    pub upstream: Vec<usize>,
    /// The downstream side, from the toe to the crest.
    pub downstream: Vec<usize>,
    /// The base, from the heel to the toe.
    pub base: Vec<usize>,
    /// Chains of points along each crack, from upstream to downstream or, if it is vertical, from bottom to top.
    pub cracks: Vec<Vec<Vec<usize>>>,
}

/// Why a given mesh cannot be taken. Coordinates are in m.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GivenMeshError {
    /// Nothing to compute.
    #[error("the mesh has no triangles and no quadrilaterals; mesh the section's surface")]
    Empty,
    /// An index of a point that is not there.
    #[error("the mesh has {points} points, and refers to point {index}; write the whole mesh")]
    NoSuchPoint {
        /// The index.
        index: usize,
        /// Number of points.
        points: usize,
    },
    /// A coordinate that is not finite, or too far away.
    #[error("a point of the mesh is at ({}, {}); coordinates must be finite and within 1e6 m of the heel", point[0], point[1])]
    NotFinite {
        /// The point.
        point: [f64; 2],
    },
    /// Too many cells.
    #[error("the mesh leads to {cells:.3e} cells (limit {MOST_CELLS:.0e}); make it coarser")]
    TooManyCells {
        /// Number of cells.
        cells: f64,
    },
    /// A polygon without area, or a quadrilateral that is not convex.
    #[error("the mesh has a flat or concave cell at {}; improve the mesh there", near(point))]
    Shape {
        /// Mean of its corners.
        point: [f64; 2],
    },
    /// A thin triangle.
    #[error(
        "the mesh has an element with an angle of {angle:.2}° at {}, and the minimum is {LEAST_ANGLE}°; improve the mesh there",
        near(point)
    )]
    Sliver {
        /// Centroid.
        point: [f64; 2],
        /// Its smallest angle, degrees.
        angle: f64,
    },
    /// Two points at the same place.
    #[error(
        "two points of the mesh lie at {}; parts of the section must share their points, also along cracks, where the mesh is parted \
         afterwards: join coincident points and curves before meshing",
        near(point)
    )]
    DuplicatePoints {
        /// Where.
        point: [f64; 2],
    },
    /// A side that two polygons have in the same direction.
    #[error("cells of the mesh overlap at {}; mesh every part of the section once", near(point))]
    Overlap {
        /// Where.
        point: [f64; 2],
    },
    /// Parts of the mesh that meet in a point, or not at all.
    #[error(
        "the mesh falls apart at {}: all parts of the section must meet along sides of cells",
        near(point)
    )]
    Apart {
        /// Where.
        point: [f64; 2],
    },
    /// The heel is not at the origin.
    #[error("the base of the mesh begins at {}; the heel must be the origin, so shift the mesh", near(point))]
    HeelNotAtOrigin {
        /// Upstream end of the base.
        point: [f64; 2],
    },
    /// A base that is not level, or runs upstream.
    #[error(
        "the base of the mesh passes {}; it must run downstream from the heel at y = 0, below all else",
        near(point)
    )]
    Base {
        /// Where.
        point: [f64; 2],
    },
    /// A line that is not where it should be on the outline.
    #[error(
        "the outline at {} is not what the curves say: from the heel around the section come base, downstream side, crest (the rest) \
         and upstream side; extend or shorten the curves",
        near(point)
    )]
    Outline {
        /// Where.
        point: [f64; 2],
    },
    /// A line that is no side of cells.
    #[error(
        "{feature} runs from {} to {}, which is no side of a cell; embed its curve in the surface before meshing",
        near(from),
        near(to)
    )]
    NoSide {
        /// The line.
        feature: Feature,
        /// From here.
        from: [f64; 2],
        /// To here.
        to: [f64; 2],
    },
    /// Two cracks on the same line, or one on a side or a gallery.
    #[error("{first} and {second} share the line at {}; a line belongs to one of them", near(point))]
    Shared {
        /// One.
        first: Feature,
        /// The other.
        second: Feature,
        /// An end of it.
        point: [f64; 2],
    },
    /// A crack that ends within a block.
    #[error(
        "crack {crack} ends inside the concrete at {}; lead its curve to a side, a gallery or another crack: fracture is not modelled",
        near(end)
    )]
    EndsInside {
        /// Index of the crack.
        crack: usize,
        /// Its end.
        end: [f64; 2],
    },
    /// No point where the water begins.
    #[error(
        "the water stands at {level} m and {feature} of the mesh has points at {below} and {above} m; put a point at the water level"
    )]
    WaterLevel {
        /// The wet side.
        feature: Feature,
        /// Water level, m.
        level: f64,
        /// Elevation of the point below, m.
        below: f64,
        /// Elevation of the point above, m.
        above: f64,
    },
    /// What its blocks and cracks are refused for.
    #[error(transparent)]
    Blocks(#[from] GeometryError),
}

fn near(point: &[f64; 2]) -> String {
    format!("({}, {})", plain(point[0]), plain(point[1]))
}

impl GivenMeshError {
    /// The index of the crack that it is about.
    pub fn crack(&self) -> Option<usize> {
        let of = |feature: &Feature| match feature {
            Feature::Crack(crack) => Some(*crack),
            _ => None,
        };
        match self {
            Self::EndsInside { crack, .. } | Self::Blocks(GeometryError::NotSeparating { crack, .. }) => {
                Some(*crack)
            }
            Self::NoSide { feature, .. } => of(feature),
            Self::Shared { first, second, .. } => of(second).or(of(first)),
            _ => None,
        }
    }
}

impl Mesh {
    /// The cells, blocks and seams of a given mesh, with points at the `levels` (m, 0 for none) of the water upstream and downstream.
    /// `element_size` (m) is the length of a cell's side.
    ///
    /// **Errors**: [`GivenMeshError`].
    pub fn of_given(
        given: &GivenMesh,
        zones: &[Vec<[f64; 2]>],
        levels: [f64; 2],
        element_size: f64,
    ) -> Result<Self, GivenMeshError> {
        given.check_indices()?;
        let points = given.snapped(levels)?;
        let polygons = given.polygons(&points)?;
        let (edges, cracks) = edges(given, &points, &polygons)?;
        let chains = edges.iter().map(|edge| edge.ends.to_vec()).collect();
        let arrangement = Arrangement { points: points.clone(), edges, cracks };
        let tiling = Tiling { points, polygons, chains };
        let mut mesh = Self::of_tiling(&arrangement, &tiling, element_size, zones)?;
        let (angle, point) = Quality::of(&mesh.nodes, &mesh.cells).smallest_angle;
        let sound = angle >= LEAST_ANGLE;
        if !sound {
            return Err(GivenMeshError::Sliver { point, angle });
        }
        for seam in std::mem::take(&mut mesh.seams) {
            mesh.add_without_kinks(seam);
        }
        Ok(mesh)
    }
}

impl GivenMesh {
    fn check_indices(&self) -> Result<(), GivenMeshError> {
        if self.triangles.is_empty() && self.quadrilaterals.is_empty() {
            return Err(GivenMeshError::Empty);
        }
        let whole = if self.triangles.is_empty() { 1.0 } else { 4.0 };
        let cells = 3.0 * self.triangles.len() as f64 + whole * self.quadrilaterals.len() as f64;
        if cells > MOST_CELLS {
            return Err(GivenMeshError::TooManyCells { cells });
        }
        let points = self.points.len();
        let chains =
            [&self.upstream, &self.downstream, &self.base].into_iter().chain(self.cracks.iter().flatten());
        let corners = self.triangles.iter().flatten().chain(self.quadrilaterals.iter().flatten());
        if let Some(&index) = chains.flatten().chain(corners).find(|index| **index >= points) {
            return Err(GivenMeshError::NoSuchPoint { index, points });
        }
        // Written so that not-a-number fails.
        match self.points.iter().find(|p| !p.iter().all(|x| x.abs() <= FARTHEST)) {
            Some(&point) => Err(GivenMeshError::NotFinite { point }),
            None => Ok(()),
        }
    }

    /// The points, with the base at y = 0, the heel at the origin, and the water at its level, where they are nearly so.
    fn snapped(&self, levels: [f64; 2]) -> Result<Vec<Point>, GivenMeshError> {
        let mut points = self.points.clone();
        let sides = || self.upstream.iter().chain(&self.downstream);
        let height = sides().map(|&i| points[i][1]).fold(0.0, f64::max);
        let snap = SNAP * height;
        let is_near = |a: f64, b: f64| (a - b).abs() <= snap;
        for &index in &self.base {
            if !is_near(points[index][1], 0.0) {
                return Err(GivenMeshError::Base { point: points[index] });
            }
            points[index][1] = 0.0;
        }
        let Some(&heel) = self.base.first() else { return Err(GivenMeshError::Outline { point: [0.0; 2] }) };
        if !is_near(points[heel][0], 0.0) {
            return Err(GivenMeshError::HeelNotAtOrigin { point: points[heel] });
        }
        points[heel] = [0.0; 2];
        for ((side, level), feature) in [&self.upstream, &self.downstream]
            .into_iter()
            .zip(levels)
            .zip([Feature::Upstream, Feature::Downstream])
        {
            if level == 0.0 {
                continue;
            }
            if let Some(&index) = side.iter().find(|&&index| is_near(points[index][1], level)) {
                points[index][1] = level;
                continue;
            }
            let elevations = || side.iter().map(|&index| points[index][1]);
            let below = elevations().filter(|y| *y < level).fold(f64::NEG_INFINITY, f64::max);
            let above = elevations().filter(|y| *y > level).fold(f64::INFINITY, f64::min);
            // beyond the crest the depth is refused
            if above.is_finite() {
                return Err(GivenMeshError::WaterLevel { feature, level, below, above });
            }
        }
        Ok(points)
    }

    /// The polygons, counter-clockwise.
    fn polygons(&self, points: &[Point]) -> Result<Vec<Polygon>, GivenMeshError> {
        let place = |corners: &[usize]| {
            [0, 1].map(|axis| corners.iter().map(|&i| points[i][axis]).sum::<f64>() / corners.len() as f64)
        };
        let corners_of = |corners: &[usize]| corners.iter().map(|&i| points[i]).collect::<Vec<_>>();
        let is_convex = |corners: &[usize]| {
            let n = corners.len();
            (0..n).all(|k| {
                let [a, b, c] = [corners[k], corners[(k + 1) % n], corners[(k + 2) % n]].map(|i| points[i]);
                orientation(a, b, c) > 0.0
            })
        };
        let mut polygons = Vec::with_capacity(self.triangles.len() + self.quadrilaterals.len());
        for corners in &self.triangles {
            let mut corners = *corners;
            if area(&corners_of(&corners)) < 0.0 {
                corners.reverse();
            }
            polygons.push(Polygon::Triangle(corners));
        }
        for corners in &self.quadrilaterals {
            let mut corners = *corners;
            if area(&corners_of(&corners)) < 0.0 {
                corners.reverse();
            }
            polygons.push(Polygon::Quadrilateral(corners));
        }
        match polygons.iter().find(|polygon| !is_convex(polygon.corners())) {
            Some(polygon) => Err(GivenMeshError::Shape { point: place(polygon.corners()) }),
            None => Ok(polygons),
        }
    }
}

/// Points of polygons that lie at the same place as another.
fn check_duplicates(points: &[Point], polygons: &[Polygon], snap: f64) -> Result<(), GivenMeshError> {
    let used: HashSet<usize> =
        polygons.iter().flat_map(|polygon| polygon.corners().iter().copied()).collect();
    let mut used: Vec<usize> = used.into_iter().collect();
    used.sort_unstable();
    let square = |x: f64| (x / snap).floor() as i64;
    let mut known: HashMap<[i64; 2], usize> = HashMap::with_capacity(used.len());
    for index in used {
        let point = points[index];
        let [x, y] = point.map(square);
        for dx in -1..=1 {
            for dy in -1..=1 {
                let other = known.get(&[x.saturating_add(dx), y.saturating_add(dy)]);
                if other.is_some_and(|&other| distance(points[other], point) <= snap) {
                    return Err(GivenMeshError::DuplicatePoints { point });
                }
            }
        }
        known.insert([x, y], index);
    }
    Ok(())
}

/// The sides of polygons that have a polygon on their left only, as chains that close.
fn loops(
    points: &[Point],
    sides: &HashSet<[usize; 2]>,
    heel: usize,
) -> Result<Vec<Vec<usize>>, GivenMeshError> {
    let mut next: HashMap<usize, usize> = HashMap::new();
    for &[from, to] in sides.iter().filter(|[from, to]| !sides.contains(&[*to, *from])) {
        if next.insert(from, to).is_some() {
            return Err(GivenMeshError::Apart { point: points[from] });
        }
    }
    let mut starts: Vec<usize> = next.keys().copied().collect();
    // the outline first, from the heel; the rest in an order that does not depend on hashes
    starts.sort_unstable_by_key(|&start| (start != heel, start));
    let mut found = Vec::new();
    for start in starts {
        let (mut ring, mut at) = (Vec::new(), start);
        while let Some(to) = next.remove(&at) {
            ring.push(at);
            at = to;
        }
        if !ring.is_empty() {
            found.push(ring);
        }
    }
    Ok(found)
}

/// The edges of outline, galleries and cracks, each a side of polygons, and the cracks' own.
fn edges(
    given: &GivenMesh,
    points: &[Point],
    polygons: &[Polygon],
) -> Result<(Vec<Edge>, Vec<Vec<CrackEdge>>), GivenMeshError> {
    let height = points.iter().map(|p| p[1]).fold(0.0, f64::max);
    check_duplicates(points, polygons, (SNAP * height).max(f64::MIN_POSITIVE))?;
    let mut sides = HashSet::new();
    for polygon in polygons {
        let corners = polygon.corners();
        for k in 0..corners.len() {
            if !sides.insert([corners[k], corners[(k + 1) % corners.len()]]) {
                return Err(GivenMeshError::Overlap { point: points[corners[k]] });
            }
        }
    }
    let heel = given.base[0];
    let rings = loops(points, &sides, heel)?;
    let area_of = |ring: &[usize]| area(&ring.iter().map(|&i| points[i]).collect::<Vec<_>>());
    let outline = rings.first().filter(|ring| ring[0] == heel && area_of(ring) > 0.0);
    let Some(outline) = outline else { return Err(GivenMeshError::Outline { point: points[heel] }) };
    if let Some(other) = rings[1..].iter().find(|ring| area_of(ring) > 0.0) {
        return Err(GivenMeshError::Apart { point: points[other[0]] });
    }
    let mut edges = outline_edges(given, points, outline)?;
    for (gallery, ring) in rings[1..].iter().enumerate() {
        for (k, &from) in ring.iter().enumerate() {
            let ends = [from, ring[(k + 1) % ring.len()]];
            edges.push(Edge { ends, feature: Feature::Gallery(gallery), crack: None });
        }
    }
    let cracks = add_cracks(given, points, &sides, &mut edges)?;
    Ok((edges, cracks))
}

/// The edges of the outline, which is a closed chain from the heel.
fn outline_edges(
    given: &GivenMesh,
    points: &[Point],
    outline: &[usize],
) -> Result<Vec<Edge>, GivenMeshError> {
    let wrong = |at: usize| GivenMeshError::Outline { point: points[at] };
    let (count, base, downstream) = (outline.len(), given.base.len(), given.downstream.len());
    let upstream = given.upstream.len();
    if base < 2 || downstream < 2 || upstream < 2 {
        return Err(wrong(outline[0]));
    }
    let mut expected: Vec<usize> = given.base.clone();
    for (index, &point) in given.downstream.iter().enumerate() {
        match index {
            0 if expected[base - 1] != point => return Err(wrong(point)),
            0 => (),
            _ => expected.push(point),
        }
    }
    if let Some((_, &at)) = expected.iter().enumerate().find(|(k, at)| outline.get(*k) != Some(*at)) {
        return Err(wrong(at));
    }
    // from the heel backwards
    let backwards = |k: usize| outline[(count - k) % count];
    if let Some((_, &at)) =
        given.upstream.iter().enumerate().find(|(k, at)| *k >= count || backwards(*k) != **at)
    {
        return Err(wrong(at));
    }
    let (crest, top) = (base + downstream - 2, (count + 1 - upstream) % count);
    if top < crest {
        return Err(wrong(outline[crest.min(count - 1)]));
    }
    let on_base: HashSet<usize> = given.base.iter().copied().collect();
    if let Some(&low) = outline.iter().find(|at| points[**at][1] <= 0.0 && !on_base.contains(at)) {
        return Err(GivenMeshError::Base { point: points[low] });
    }
    if let Some(pair) = given.base.windows(2).find(|pair| points[pair[0]][0] >= points[pair[1]][0]) {
        return Err(GivenMeshError::Base { point: points[pair[1]] });
    }
    let feature = |k: usize| match k {
        k if k + 1 < base => Feature::Base,
        k if k < crest => Feature::Downstream,
        k if k < top => Feature::Crest,
        _ => Feature::Upstream,
    };
    let edge = |(k, &from): (usize, &usize)| Edge {
        ends: [from, outline[(k + 1) % count]],
        feature: feature(k),
        crack: None,
    };
    Ok(outline.iter().enumerate().map(edge).collect())
}

/// Adds the edges of cracks; returns those of each.
fn add_cracks(
    given: &GivenMesh,
    points: &[Point],
    sides: &HashSet<[usize; 2]>,
    edges: &mut Vec<Edge>,
) -> Result<Vec<Vec<CrackEdge>>, GivenMeshError> {
    let key = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
    let mut known: HashMap<[usize; 2], usize> =
        edges.iter().enumerate().map(|(index, edge)| (key(edge.ends), index)).collect();
    let boundary: HashSet<usize> = edges.iter().flat_map(|edge| edge.ends).collect();
    let mut cracks = Vec::with_capacity(given.cracks.len());
    let mut degree: HashMap<usize, usize> = HashMap::new();
    for (crack, chains) in given.cracks.iter().enumerate() {
        let mut parts = Vec::new();
        for ends in chains.iter().flat_map(|chain| chain.windows(2)).map(|pair| [pair[0], pair[1]]) {
            let feature = Feature::Crack(crack);
            if !sides.contains(&ends) && !sides.contains(&[ends[1], ends[0]]) {
                let [from, to] = ends.map(|i| points[i]);
                return Err(GivenMeshError::NoSide { feature, from, to });
            }
            let edge = *known.entry(key(ends)).or_insert_with(|| {
                edges.push(Edge { ends, feature, crack: None });
                edges.len() - 1
            });
            let first = match edges[edge] {
                Edge { crack: Some(other), .. } => Some(Feature::Crack(other)),
                Edge { feature: Feature::Base | Feature::Crack(_), .. } => None,
                Edge { feature, .. } => Some(feature),
            };
            if let Some(first) = first {
                return Err(GivenMeshError::Shared { first, second: feature, point: points[ends[0]] });
            }
            edges[edge].crack = Some(crack);
            ends.iter().for_each(|&end| *degree.entry(end).or_default() += 1);
            parts.push(CrackEdge { edge, forward: edges[edge].ends == ends });
        }
        if parts.is_empty() {
            return Err(GeometryError::CrackOutside { crack }.into());
        }
        cracks.push(parts);
    }
    for (crack, chain) in
        given.cracks.iter().enumerate().flat_map(|(i, chains)| chains.iter().map(move |c| (i, c)))
    {
        let ends = [chain.first(), chain.last()].into_iter().flatten();
        if let Some(&end) =
            ends.into_iter().find(|end| degree.get(end) == Some(&1) && !boundary.contains(end))
        {
            return Err(GivenMeshError::EndsInside { crack, end: points[end] });
        }
    }
    Ok(cracks)
}
