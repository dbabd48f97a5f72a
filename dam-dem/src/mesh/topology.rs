//! Which triangles lie beside each other, and which of them make a block.

use std::cmp::Ordering;
use std::collections::HashMap;

use super::arrangement::Arrangement;
use super::plane_geometry::{Point, orientation};
use super::triangulation::Triangulation;

/// A side of a triangle: index of the triangle and of the corner where the side starts.
pub type Side = (usize, usize);

/// The triangulation with the blocks of its triangles.
pub struct Topology<'a> {
    pub arrangement: &'a Arrangement,
    pub triangulation: &'a Triangulation,
    /// The triangle side that runs from one point to another.
    pub sides: HashMap<[usize; 2], Side>,
    /// The crack of each pair of points, in both directions.
    cracks: HashMap<[usize; 2], usize>,
    /// Block of each triangle.
    pub block_of: Vec<usize>,
    pub blocks: usize,
}

impl<'a> Topology<'a> {
    pub fn new(arrangement: &'a Arrangement, triangulation: &'a Triangulation) -> Self {
        let mut sides = HashMap::new();
        for (index, triangle) in triangulation.triangles.iter().enumerate() {
            for k in 0..3 {
                sides.insert([triangle[k], triangle[(k + 1) % 3]], (index, k));
            }
        }
        let mut cracks = HashMap::new();
        for (edge, chain) in arrangement.edges.iter().zip(&triangulation.chains) {
            if let Some(crack) = edge.crack {
                for pair in chain.windows(2) {
                    cracks.insert([pair[0], pair[1]], crack);
                    cracks.insert([pair[1], pair[0]], crack);
                }
            }
        }
        let block_of = vec![usize::MAX; triangulation.triangles.len()];
        let mut this = Self { arrangement, triangulation, sides, cracks, block_of, blocks: 0 };
        this.fill();
        this.order();
        this
    }

    /// The triangle on the other side, if there is one and no crack in between.
    pub fn across(&self, (triangle, k): Side) -> Option<Side> {
        let corners = self.triangulation.triangles[triangle];
        let reverse = [corners[(k + 1) % 3], corners[k]];
        if self.cracks.contains_key(&reverse) { None } else { self.sides.get(&reverse).copied() }
    }

    fn fill(&mut self) {
        for start in 0..self.block_of.len() {
            if self.block_of[start] != usize::MAX {
                continue;
            }
            let mut pending = vec![start];
            self.block_of[start] = self.blocks;
            while let Some(triangle) = pending.pop() {
                for k in 0..3 {
                    let Some((next, _)) = self.across((triangle, k)) else { continue };
                    if self.block_of[next] == usize::MAX {
                        self.block_of[next] = self.blocks;
                        pending.push(next);
                    }
                }
            }
            self.blocks += 1;
        }
    }

    pub fn corners(&self, triangle: usize) -> [Point; 3] {
        self.triangulation.triangles[triangle].map(|i| self.triangulation.points[i])
    }

    /// Area and centroid of each block.
    pub fn areas(&self) -> Vec<(f64, Point)> {
        let mut sums = vec![[0.0; 3]; self.blocks];
        for (triangle, &block) in self.block_of.iter().enumerate() {
            let [a, b, c] = self.corners(triangle);
            let area = 0.5 * orientation(a, b, c);
            let sum = &mut sums[block];
            sum[0] += area;
            sum[1] += area * (a[0] + b[0] + c[0]) / 3.0;
            sum[2] += area * (a[1] + b[1] + c[1]) / 3.0;
        }
        sums.into_iter().map(|[area, x, y]| (area, [x / area, y / area])).collect()
    }

    /// Numbers the blocks by (y, x) of their lowest point, the leftmost of several, then by (y, x) of their centroid.
    fn order(&mut self) {
        let mut lowest = vec![[f64::INFINITY; 2]; self.blocks];
        for (triangle, &block) in self.block_of.iter().enumerate() {
            for p in self.corners(triangle) {
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

    /// For each corner of each triangle the first corner (three times the triangle + k) of the same node: around a point,
    /// triangles that no crack separates share a node.
    pub fn shared_corners(&self) -> Vec<usize> {
        let mut root: Vec<usize> = (0..3 * self.block_of.len()).collect();
        let find = |root: &mut Vec<usize>, mut i: usize| {
            while root[i] != i {
                root[i] = root[root[i]];
                i = root[i];
            }
            i
        };
        for triangle in 0..self.block_of.len() {
            for k in 0..3 {
                let Some((other, m)) = self.across((triangle, k)) else { continue };
                for (one, two) in [(k, (m + 1) % 3), ((k + 1) % 3, m)] {
                    let (a, b) = (find(&mut root, 3 * triangle + one), find(&mut root, 3 * other + two));
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
