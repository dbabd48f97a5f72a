use super::super::Integration;
use super::position::Segment;

/// One side of a crack.
#[derive(Clone, Debug)]
pub(super) struct Side {
    pub nodes: Vec<usize>,
    /// Unloaded positions, m.
    pub rest: Vec<[f64; 2]>,
    /// Tributary lengths of the nodes that their contacts stand for, m: half of them, or all if the other side is the ground.
    pub weights: Vec<f64>,
    /// Unloaded length of the chain up to each node, m.
    pub abscissas: Vec<f64>,
}

/// A contact of one side with the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    /// Its side: 0 for the lower, 1 for the upper side.
    pub side: usize,
    /// Its point.
    pub point: Point,
    /// Part of the side that it represents, from and to this abscissa, m.
    pub part: [f64; 2],
    /// Length for which it stands, m: half of this part, as the contacts of the other side have the other half; all of it
    /// if the other side is the ground.
    pub weight: f64,
    /// Segments of its side on which its part begins and ends. The first search along the other side starts
    /// from `after`.
    pub before: usize,
    pub after: usize,
}

impl Contact {
    /// Sign of its slip when the block above slides downstream.
    #[inline(always)]
    pub fn downstream(&self) -> f64 {
        if self.side == 1 { 1.0 } else { -1.0 }
    }
}

/// A point of a side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// The nodes before and after it; for a point at a node, this node twice.
    pub nodes: [usize; 2],
    /// Position between them, from 0 to 1.
    pub share: f64,
    /// Unloaded position, m.
    pub rest: [f64; 2],
    /// Unloaded length of the side up to it, m.
    pub abscissa: f64,
}

impl Side {
    /// Unloaded length, m.
    #[inline(always)]
    pub fn length(&self) -> f64 {
        self.abscissas[self.abscissas.len() - 1]
    }

    /// A segment as seen from a point with this unloaded position (m).
    #[inline(always)]
    pub fn segment(&self, segment: usize, [x, y]: [f64; 2]) -> Segment<f64> {
        let [first, second] = [self.rest[segment], self.rest[segment + 1]];
        Segment {
            offsets: [[x - first[0], y - first[1]], [x - second[0], y - second[1]]],
            edge: [second[0] - first[0], second[1] - first[1]],
        }
    }

    /// From the first to the second node of a segment, m.
    #[inline(always)]
    pub fn edge(&self, segment: usize, u: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
        let [(a, p), (b, q)] = [segment, segment + 1].map(|i| (self.rest[i], u(self.nodes[i])));
        [b[0] - a[0] + (q[0] - p[0]), b[1] - a[1] + (q[1] - p[1])]
    }

    /// The point at `abscissa` (m along the side) on a segment.
    pub fn point(&self, segment: usize, abscissa: f64) -> Point {
        let (from, to) = (self.abscissas[segment], self.abscissas[segment + 1]);
        let share = (abscissa - from) / (to - from);
        let ([x0, y0], [x1, y1]) = (self.rest[segment], self.rest[segment + 1]);
        Point {
            nodes: [self.nodes[segment], self.nodes[segment + 1]],
            share,
            rest: [x0 + share * (x1 - x0), y0 + share * (y1 - y0)],
            abscissa,
        }
    }

    /// Abscissa of the point on the line of a segment that is closest to node `end` of the `other` side, m.
    #[inline(always)]
    pub fn foot(&self, segment: usize, other: &Self, end: usize, u: impl Fn(usize) -> [f64; 2]) -> f64 {
        let edge = self.edge(segment, &u);
        let ([from, p], [to, q]) =
            ([self.rest[segment], u(self.nodes[segment])], [other.rest[end], u(other.nodes[end])]);
        let offset = [to[0] - from[0] + (q[0] - p[0]), to[1] - from[1] + (q[1] - p[1])];
        let along = (offset[0] * edge[0] + offset[1] * edge[1]) / (edge[0] * edge[0] + edge[1] * edge[1]);
        self.abscissas[segment] + along * (self.abscissas[segment + 1] - self.abscissas[segment])
    }

    /// The contacts of this side (0 for the lower, 1 for the upper side) with the other side.
    /// They stand for this `share` of its length.
    pub fn contacts(&self, side: usize, integration: Integration, share_of_length: f64) -> Vec<Contact> {
        let last = self.nodes.len() - 1;
        let middle = |segment: usize| (self.abscissas[segment] + self.abscissas[segment + 1]) / 2.0;
        let at_node = |i: usize| Contact {
            side,
            point: Point {
                nodes: [self.nodes[i]; 2],
                share: 0.0,
                rest: self.rest[i],
                abscissa: self.abscissas[i],
            },
            part: [
                if i > 0 { middle(i - 1) } else { 0.0 },
                if i < last { middle(i) } else { self.abscissas[last] },
            ],
            weight: self.weights[i],
            before: i.saturating_sub(1),
            after: i.min(last - 1),
        };
        let on_segment = |segment: usize, share: f64| {
            let (from, to) = (self.abscissas[segment], self.abscissas[segment + 1]);
            Contact {
                side,
                point: self.point(segment, from + share * (to - from)),
                part: if share < 0.5 { [from, middle(segment)] } else { [middle(segment), to] },
                weight: (to - from) / 2.0 * share_of_length,
                before: segment,
                after: segment,
            }
        };
        let points = [0.5 - 0.5 / 3f64.sqrt(), 0.5 + 0.5 / 3f64.sqrt()];
        match integration {
            Integration::Nodal => (0..self.nodes.len()).map(at_node).collect(),
            Integration::Gauss => {
                (0..last).flat_map(|segment| points.map(|share| on_segment(segment, share))).collect()
            }
        }
    }
}
