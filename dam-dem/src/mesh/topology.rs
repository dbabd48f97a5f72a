//! Which polygons lie beside each other, and which of them make a block.

use std::cmp::Ordering;
use std::collections::HashMap;

use super::arrangement::Arrangement;
use super::plane_geometry::{Point, orientation};
use super::triangulation::Triangulation;

/// Corners of a triangle or a quadrilateral, counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Polygon {
    Triangle([usize; 3]),
    Quadrilateral([usize; 4]),
}

impl Polygon {
    pub fn corners(&self) -> &[usize] {
        match self {
            Self::Triangle(corners) => corners,
            Self::Quadrilateral(corners) => corners,
        }
    }
}

/// Polygons that fill the section, and meet side to side.
pub struct Tiling {
    pub points: Vec<Point>,
    pub polygons: Vec<Polygon>,
    /// For each edge of the arrangement the points along it, from its first end to its second.
    pub chains: Vec<Vec<usize>>,
}

impl From<Triangulation> for Tiling {
    fn from(triangulation: Triangulation) -> Self {
        let Triangulation { points, triangles, chains } = triangulation;
        Self { points, polygons: triangles.into_iter().map(Polygon::Triangle).collect(), chains }
    }
}

/// A side of a polygon: index of the polygon and of the corner where the side starts.
pub type Side = (usize, usize);

/// Most corners of a polygon.
pub const CORNERS: usize = 4;

/// The tiling with the blocks of its polygons.
pub struct Topology<'a> {
    pub arrangement: &'a Arrangement,
    pub tiling: &'a Tiling,
    /// The polygon's side that runs from one point to another.
    pub sides: HashMap<[usize; 2], Side>,
    /// The crack of each pair of points, in both directions.
    cracks: HashMap<[usize; 2], usize>,
    /// Block of each polygon.
    pub block_of: Vec<usize>,
    pub blocks: usize,
}

impl<'a> Topology<'a> {
    pub fn new(arrangement: &'a Arrangement, tiling: &'a Tiling) -> Self {
        let mut sides = HashMap::new();
        for (index, polygon) in tiling.polygons.iter().enumerate() {
            let corners = polygon.corners();
            for k in 0..corners.len() {
                sides.insert([corners[k], corners[(k + 1) % corners.len()]], (index, k));
            }
        }
        let mut cracks = HashMap::new();
        for (edge, chain) in arrangement.edges.iter().zip(&tiling.chains) {
            if let Some(crack) = edge.crack {
                for pair in chain.windows(2) {
                    cracks.insert([pair[0], pair[1]], crack);
                    cracks.insert([pair[1], pair[0]], crack);
                }
            }
        }
        let block_of = vec![usize::MAX; tiling.polygons.len()];
        let mut this = Self { arrangement, tiling, sides, cracks, block_of, blocks: 0 };
        this.fill();
        this.order();
        this
    }

    /// The indices of a polygon's corners.
    pub fn indices(&self, polygon: usize) -> &'a [usize] {
        self.tiling.polygons[polygon].corners()
    }

    /// The polygon on the other side, if there is one and no crack in between.
    pub fn across(&self, (polygon, k): Side) -> Option<Side> {
        let corners = self.indices(polygon);
        let reverse = [corners[(k + 1) % corners.len()], corners[k]];
        if self.cracks.contains_key(&reverse) { None } else { self.sides.get(&reverse).copied() }
    }

    fn fill(&mut self) {
        for start in 0..self.block_of.len() {
            if self.block_of[start] != usize::MAX {
                continue;
            }
            let mut pending = vec![start];
            self.block_of[start] = self.blocks;
            while let Some(polygon) = pending.pop() {
                for k in 0..self.indices(polygon).len() {
                    let Some((next, _)) = self.across((polygon, k)) else { continue };
                    if self.block_of[next] == usize::MAX {
                        self.block_of[next] = self.blocks;
                        pending.push(next);
                    }
                }
            }
            self.blocks += 1;
        }
    }

    pub fn corners(&self, polygon: usize) -> impl Iterator<Item = Point> + '_ {
        self.indices(polygon).iter().map(|&i| self.tiling.points[i])
    }

    /// Area and centroid of each block.
    pub fn areas(&self) -> Vec<(f64, Point)> {
        let mut sums = vec![[0.0; 3]; self.blocks];
        for (polygon, &block) in self.block_of.iter().enumerate() {
            let corners = self.indices(polygon);
            for k in 2..corners.len() {
                let [a, b, c] = [corners[0], corners[k - 1], corners[k]].map(|i| self.tiling.points[i]);
                let area = 0.5 * orientation(a, b, c);
                let sum = &mut sums[block];
                sum[0] += area;
                sum[1] += area * (a[0] + b[0] + c[0]) / 3.0;
                sum[2] += area * (a[1] + b[1] + c[1]) / 3.0;
            }
        }
        sums.into_iter().map(|[area, x, y]| (area, [x / area, y / area])).collect()
    }

    /// Numbers the blocks by (y, x) of their lowest point, the leftmost of several, then by (y, x) of their centroid.
    fn order(&mut self) {
        let mut lowest = vec![[f64::INFINITY; 2]; self.blocks];
        for (polygon, &block) in self.block_of.iter().enumerate() {
            for p in self.corners(polygon) {
                if by_height(&p, &lowest[block]).is_lt() {
                    lowest[block] = p;
                }
            }
        }
        let areas = self.areas();
        let mut order: Vec<usize> = (0..self.blocks).collect();
        order.sort_by(|&a, &b| {
            by_height(&lowest[a], &lowest[b]).then_with(|| by_height(&areas[a].1, &areas[b].1))
        });
        let mut number = vec![0; self.blocks];
        order.iter().enumerate().for_each(|(new, &old)| number[old] = new);
        self.block_of.iter_mut().for_each(|block| *block = number[*block]);
    }

    /// For each corner of each polygon the first corner ([`CORNERS`] times the polygon + k) of the same node: around a point,
    /// polygons that no crack separates share a node.
    pub fn shared_corners(&self) -> Vec<usize> {
        let mut root: Vec<usize> = (0..CORNERS * self.block_of.len()).collect();
        let find = |root: &mut Vec<usize>, mut i: usize| {
            while root[i] != i {
                root[i] = root[root[i]];
                i = root[i];
            }
            i
        };
        for polygon in 0..self.block_of.len() {
            let count = self.indices(polygon).len();
            for k in 0..count {
                let Some((other, m)) = self.across((polygon, k)) else { continue };
                for (one, two) in [(k, (m + 1) % self.indices(other).len()), ((k + 1) % count, m)] {
                    let (a, b) =
                        (find(&mut root, CORNERS * polygon + one), find(&mut root, CORNERS * other + two));
                    root[a.max(b)] = a.min(b);
                }
            }
        }
        (0..root.len()).map(|i| find(&mut root, i)).collect()
    }
}

/// Compares y, then x.
pub fn by_height(a: &Point, b: &Point) -> Ordering {
    a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0]))
}
