//! The outline of the dam's cross-section.

use serde::{Deserialize, Serialize};

/// Elevations closer than this share of the height count as one.
pub(crate) const ELEVATION_TOLERANCE: f64 = 1e-6;

/// Outline of a cross-section by its two sides, each from base to crest. Base and crest are the straight lines between their ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Section {
    /// Vertices of the upstream side, m, the first one the origin.
    pub upstream: Vec<[f64; 2]>,
    /// Vertices of the downstream side, m.
    pub downstream: Vec<[f64; 2]>,
    /// Outlines of holes, m.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub galleries: Vec<Vec<[f64; 2]>>,
}

/// The tallest monolith of Koyna Dam, 103 m high, with a vertical upstream side and the neck at 66.5 m.
///
/// **Source**: A.K. Chopra and P. Chakrabarti, *The Koyna earthquake and the damage to Koyna Dam*, 1973.
impl Default for Section {
    fn default() -> Self {
        Self::new(vec![[0.0, 0.0], [0.0, 103.0]], vec![[70.0, 0.0], [19.25, 66.5], [14.8, 103.0]])
    }
}

impl Section {
    /// A section without galleries: the vertices of both sides (m), each from base to crest.
    pub fn new(upstream: Vec<[f64; 2]>, downstream: Vec<[f64; 2]>) -> Self {
        Self { upstream, downstream, galleries: Vec::new() }
    }

    /// A rectangle with its heel at the origin.
    pub fn rectangle(width: f64, height: f64) -> Self {
        Self::new(vec![[0.0, 0.0], [0.0, height]], vec![[width, 0.0], [width, height]])
    }

    /// Elevation of the highest point, m.
    pub fn height(&self) -> f64 {
        self.vertex_elevations().fold(0.0, f64::max)
    }

    /// Area of the section, m².
    pub fn area(&self) -> f64 {
        let below = |side: &[[f64; 2]]| -> f64 {
            side.windows(2).map(|s| (s[0][0] + s[1][0]) / 2.0 * (s[1][1] - s[0][1])).sum()
        };
        let crest = match (self.downstream.last(), self.upstream.last()) {
            (Some(&right), Some(&left)) => below(&[right, left]),
            _ => 0.0,
        };
        let gallery = |gallery: &Vec<[f64; 2]>| {
            let closing = [gallery[gallery.len() - 1], gallery[0]];
            (below(gallery) + below(&closing)).abs()
        };
        let galleries: f64 = self.galleries.iter().filter(|gallery| !gallery.is_empty()).map(gallery).sum();
        below(&self.downstream) - below(&self.upstream) + crest - galleries
    }

    /// x of both sides at elevation `y`, m.
    pub fn sides_at(&self, y: f64) -> [f64; 2] {
        [x_at(&self.upstream, y), x_at(&self.downstream, y)]
    }

    /// Elevations of all vertices, m, unsorted.
    pub fn vertex_elevations(&self) -> impl Iterator<Item = f64> + '_ {
        self.upstream.iter().chain(&self.downstream).map(|p| p[1])
    }

    /// Whether rows of cells can fill it: both sides ascend from a level base to a level crest, begin at the heel and do not
    /// cross, and there is no gallery.
    pub(crate) fn has_rows(&self) -> bool {
        let ascends = |side: &[[f64; 2]]| {
            side.len() > 1
                && side[0][1] == 0.0
                && side.iter().flatten().all(|x| x.is_finite())
                && side.windows(2).all(|pair| pair[0][1] < pair[1][1])
        };
        let crest = |side: &[[f64; 2]]| side.last().map(|point| point[1]);
        ascends(&self.upstream)
            && ascends(&self.downstream)
            && self.upstream[0] == [0.0, 0.0]
            && crest(&self.upstream) == crest(&self.downstream)
            && self.galleries.is_empty()
            && self.vertex_elevations().all(|y| {
                let [left, right] = self.sides_at(y);
                right > left
            })
    }
}

/// x of a side at elevation `y`; the side is extended beyond its ends.
fn x_at(side: &[[f64; 2]], y: f64) -> f64 {
    let above = side.partition_point(|p| p[1] < y).clamp(1, side.len() - 1);
    let ([x0, y0], [x1, y1]) = (side[above - 1], side[above]);
    if y == y1 { x1 } else { x0 + (x1 - x0) * (y - y0) / (y1 - y0) }
}
