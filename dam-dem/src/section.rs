//! The outline of the dam's cross-section.

use serde::{Deserialize, Serialize};

use crate::error::{DamError, Problem};

/// Elevations closer than this share of the height count as one.
pub(crate) const ELEVATION_TOLERANCE: f64 = 1e-6;

/// Outline of a cross-section by its two sides, each from base to crest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Section {
    /// Vertices of the upstream side, m, the first one the origin.
    pub upstream: Vec<[f64; 2]>,
    /// Vertices of the downstream side, m.
    pub downstream: Vec<[f64; 2]>,
}

impl Section {
    /// A rectangle with its heel at the origin.
    pub fn rectangle(width: f64, height: f64) -> Self {
        Self { upstream: vec![[0.0, 0.0], [0.0, height]], downstream: vec![[width, 0.0], [width, height]] }
    }

    /// Elevation of the crest, m.
    pub fn height(&self) -> f64 {
        self.upstream.last().map_or(0.0, |p| p[1])
    }

    /// Area of the section, m².
    pub fn area(&self) -> f64 {
        let below = |side: &[[f64; 2]]| -> f64 {
            side.windows(2).map(|s| (s[0][0] + s[1][0]) / 2.0 * (s[1][1] - s[0][1])).sum()
        };
        below(&self.downstream) - below(&self.upstream)
    }

    /// x of both sides at elevation `y`, m.
    pub fn sides_at(&self, y: f64) -> [f64; 2] {
        [x_at(&self.upstream, y), x_at(&self.downstream, y)]
    }

    /// Elevations of all vertices, m, unsorted.
    pub fn vertex_elevations(&self) -> impl Iterator<Item = f64> + '_ {
        self.upstream.iter().chain(&self.downstream).map(|p| p[1])
    }

    /// What is wrong: the sides must ascend from a level base to a level crest, begin at the heel and not cross.
    pub(crate) fn problems(&self) -> Vec<Problem> {
        let mut found = Vec::new();
        for (side, points) in [("upstream", &self.upstream), ("downstream", &self.downstream)] {
            let key = format!("section.{side}");
            if points.len() < 2 {
                found.push(Problem::of([&key], DamError::SideTooShort { side, found: points.len() }));
            }
            for (index, &[x, y]) in points.iter().enumerate() {
                let follows = if index == 0 { y == 0.0 } else { y > points[index - 1][1] };
                if !(x.is_finite() && y.is_finite() && follows) {
                    found.push(Problem::of([&key], DamError::SideNotAscending { side, index, x, y }));
                    break;
                }
            }
        }
        if !found.is_empty() {
            return found;
        }
        let [x, y] = self.upstream[0];
        if [x, y] != [0.0, 0.0] {
            found.push(Problem::of(["section.upstream"], DamError::HeelNotAtOrigin { x, y }));
        }
        let (upstream, downstream) = (self.height(), self.downstream[self.downstream.len() - 1][1]);
        if upstream != downstream {
            found.push(Problem::of(["section"], DamError::SidesNotLevel { upstream, downstream }));
        }
        let width = |y: f64| {
            let [left, right] = self.sides_at(y);
            right - left
        };
        let lowest = self.vertex_elevations().filter(|y| width(*y) <= 0.0).reduce(f64::min);
        if let Some(elevation) = lowest {
            let width = width(elevation);
            found.push(Problem::of(["section"], DamError::SidesCross { elevation, width }));
        }
        found
    }
}

/// x of a side at elevation `y`; the side is extended beyond its ends.
fn x_at(side: &[[f64; 2]], y: f64) -> f64 {
    let above = side.partition_point(|p| p[1] < y).clamp(1, side.len() - 1);
    let ([x0, y0], [x1, y1]) = (side[above - 1], side[above]);
    if y == y1 { x1 } else { x0 + (x1 - x0) * (y - y0) / (y1 - y0) }
}
