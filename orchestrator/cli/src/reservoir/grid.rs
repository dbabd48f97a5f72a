//! A grid of quadrilaterals between far end and wet face, bed and surface.

use super::{Failure, unfit};
use cofferdam_reservoir::ReservoirParameters;

/// Points, and the four points of each cell, anticlockwise.
pub struct Grid {
    pub points: Vec<[f64; 2]>,
    pub cells: Vec<[usize; 4]>,
}

/// Distance of the grid from the boundary as a share of the depth; on the boundary the kernels are singular.
const INSET: f64 = 1e-3;
/// Largest number of points of a grid.
const MOST: f64 = 1e6;

impl Grid {
    /// The near field of the parameters' water in cells of about `size` (m), by Coons' transfinite interpolation of its
    /// four sides.
    ///
    /// **Errors**: too many points; sides between which the interpolation folds.
    pub fn of(parameters: &ReservoirParameters, size: f64) -> Result<Self, Failure> {
        let face = parameters.wet_face.points();
        let (depth, bed) = (parameters.wet_face.depth(), &parameters.bed);
        let most_upstream = face.iter().chain(bed).fold(0.0f64, |x, point| x.min(point[0]));
        let upstream = most_upstream - parameters.far_end_distance;
        let level = bed.last().map_or(0.0, |corner| corner[1]);
        let heel = std::iter::once([0.0, 0.0]);
        let bottom: Vec<[f64; 2]> =
            std::iter::once([upstream, level]).chain(bed.iter().rev().copied()).chain(heel).collect();
        let sides = Sides {
            bottom: Side::new(&bottom),
            top: Side::new(&[[upstream, depth], face[face.len() - 1]]),
            left: Side::new(&[[upstream, level], [upstream, depth]]),
            right: Side::new(face),
        };
        let count = |a: &Side, b: &Side| (a.length().max(b.length()) / size).ceil().max(2.0);
        let [across, up] = [count(&sides.bottom, &sides.top), count(&sides.left, &sides.right)];
        if across * up > MOST {
            return Err(unfit(format!(
                "cells of {size} m make a grid of {:.1e} points, more than {MOST:.0e}; raise --size",
                across * up
            )));
        }
        let [columns, rows] = [across as usize, up as usize];
        let shares =
            |count: usize, inset: f64| move |i: usize| inset + (1.0 - 2.0 * inset) * i as f64 / count as f64;
        let (u, v) = (shares(columns, (INSET * depth / sides.bottom.length()).min(0.1)), shares(rows, INSET));
        let points: Vec<[f64; 2]> = (0..=rows)
            .flat_map(|j| (0..=columns).map(move |i| (i, j)))
            .map(|(i, j)| sides.at(u(i), v(j)))
            .collect();
        let corner = |i: usize, j: usize| j * (columns + 1) + i;
        let cells: Vec<[usize; 4]> = (0..rows)
            .flat_map(|j| (0..columns).map(move |i| (i, j)))
            .map(|(i, j)| [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)])
            .collect();
        let grid = Self { points, cells };
        match grid.folded() {
            None => Ok(grid),
            Some([x, y]) => Err(unfit(format!(
                "no grid fits between this bed and this face: it folds near ({x:.3}, {y:.3}) m; a bed that overhangs \
                 cannot be shown"
            ))),
        }
    }

    /// A corner at which a cell is folded.
    fn folded(&self) -> Option<[f64; 2]> {
        let turns_left =
            |[a, b, c]: [[f64; 2]; 3]| (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) > 0.0;
        self.cells.iter().find_map(|cell| {
            let corners = cell.map(|index| self.points[index]);
            let wrong = (0..4).find(|k| !turns_left([*k, k + 1, k + 2].map(|i| corners[i % 4])));
            wrong.map(|k| corners[(k + 1) % 4])
        })
    }
}

struct Sides {
    bottom: Side,
    top: Side,
    left: Side,
    right: Side,
}

impl Sides {
    fn at(&self, u: f64, v: f64) -> [f64; 2] {
        let [bottom, top, left, right] =
            [self.bottom.at(u), self.top.at(u), self.left.at(v), self.right.at(v)];
        let corners = [self.bottom.at(0.0), self.bottom.at(1.0), self.top.at(0.0), self.top.at(1.0)];
        let shares = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
        [0, 1].map(|axis| {
            let between: f64 = corners.iter().zip(shares).map(|(corner, share)| share * corner[axis]).sum();
            (1.0 - v) * bottom[axis] + v * top[axis] + (1.0 - u) * left[axis] + u * right[axis] - between
        })
    }
}

/// A polygonal line, parametrised by the share of its length.
struct Side {
    points: Vec<[f64; 2]>,
    /// Length up to each point, m.
    lengths: Vec<f64>,
}

impl Side {
    fn new(points: &[[f64; 2]]) -> Self {
        let mut length = 0.0;
        let mut lengths = vec![0.0];
        for pair in points.windows(2) {
            length += (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
            lengths.push(length);
        }
        Self { points: points.to_vec(), lengths }
    }

    fn length(&self) -> f64 {
        self.lengths[self.lengths.len() - 1]
    }

    fn at(&self, share: f64) -> [f64; 2] {
        let along = share * self.length();
        let above = self.lengths.partition_point(|length| *length < along).clamp(1, self.points.len() - 1);
        let (from, to) = (self.lengths[above - 1], self.lengths[above]);
        // Two points of a crack coincide.
        let t = if to > from { (along - from) / (to - from) } else { 0.0 };
        [0, 1].map(|axis| self.points[above - 1][axis] * (1.0 - t) + self.points[above][axis] * t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_unit::WetFace;

    fn area(grid: &Grid) -> f64 {
        let of = |cell: &[usize; 4]| {
            let p = cell.map(|i| grid.points[i]);
            (0..4).map(|k| p[k][0] * p[(k + 1) % 4][1] - p[(k + 1) % 4][0] * p[k][1]).sum::<f64>() / 2.0
        };
        grid.cells.iter().map(of).sum()
    }

    /// The inset takes twice 10⁻³ of the height and twice 0.1 m of the bottom's length; cells cut few corners.
    #[test]
    fn the_grid_fills_the_near_field() {
        let face = WetFace::new(vec![[0.0, 0.0], [4.0, 40.0], [4.0, 40.0], [4.0, 70.0], [10.0, 100.0]])
            .expect("a face");
        let level =
            ReservoirParameters { far_end_distance: 80.0, ..ReservoirParameters::before(face.clone()) };
        let bed = vec![[-20.0, -5.0], [-60.0, -10.0]];
        let sloped = ReservoirParameters { bed, ..level.clone() };
        // Left of the face: 4·40/2 + 4·30 + 7·30; below y = 0: 20·5/2 + 40·7.5 + 80·10.
        let beside_face = 80.0 + 120.0 + 210.0;
        for (parameters, exact, bottom) in [
            (level, 8000.0 + beside_face, 80.0),
            (
                sloped,
                14_000.0 + beside_face + 50.0 + 300.0 + 800.0,
                20f64.hypot(5.0) + 40f64.hypot(5.0) + 80.0,
            ),
        ] {
            let grid = Grid::of(&parameters, 2.5).expect("a grid");
            let share = area(&grid) / exact;
            println!("{} points, {share:.5} of the area", grid.points.len());
            assert!((share - (1.0 - 2e-3 - 0.2 / bottom)).abs() < 2e-4, "{share}");
            assert!(grid.points.iter().all(|p| p[1] < 100.0 && p[1] > -10.0 && p[0] < 10.0));
        }
    }

    #[test]
    fn a_fold_and_too_many_points_are_refused() {
        let face = WetFace::straight([0.0, 100.0], 10).expect("a face");
        let parameters = ReservoirParameters::before(face);
        let said = Grid::of(&parameters, 1e-3).err().map(|error| error.to_string()).expect("too many");
        assert!(said.contains("--size"), "{said}");
        // A bed that rises nearly to the surface and goes back below itself.
        let bed = vec![[-80.0, 10.0], [-80.0, 90.0], [-10.0, 95.0], [-100.0, 97.0]];
        let said =
            Grid::of(&ReservoirParameters { bed, ..parameters }, 5.0).err().map(|error| error.to_string());
        assert!(said.is_some_and(|said| said.contains("folds")));
    }
}
