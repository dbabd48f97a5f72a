//! Where contacts are, for one contact (`N = f64`) or for several at once.

use super::super::search::Projection;
use crate::real::{Mask, Real};

/// A contact's point, with the displacements of its nodes.
#[derive(Clone, Copy)]
pub(super) struct MovedPoint<N> {
    /// Unloaded position, m.
    pub rest: [N; 2],
    /// Displacement of the node before it, m.
    pub first: [N; 2],
    /// What its displacement is more than that, m.
    pub turned: [N; 2],
}

impl<N: Real> MovedPoint<N> {
    /// The point between two nodes with these displacements (m), at this `share` of the way from the first to the second.
    #[inline(always)]
    pub fn new(rest: [N; 2], share: N, [first, second]: [[N; 2]; 2]) -> Self {
        Self { rest, first, turned: times(share, minus(second, first)) }
    }

    /// Displacement, m.
    #[inline(always)]
    pub fn displacement(&self) -> [N; 2] {
        plus(self.first, self.turned)
    }

    /// Current position, m.
    #[inline(always)]
    pub fn position(&self) -> [N; 2] {
        plus(plus(self.rest, self.first), self.turned)
    }
}

/// A segment of the other side, as seen from a contact's point.
#[derive(Clone, Copy, Default)]
pub(super) struct Segment<N> {
    /// From its two nodes to the point, unloaded, m.
    pub offsets: [[N; 2]; 2],
    /// From its first to its second node, unloaded, m.
    pub edge: [N; 2],
}

impl<N: Real> Segment<N> {
    /// The same with the displacement of the point and those of the segment's nodes, m. Differences of unloaded positions and of
    /// displacements are computed separately, so that no digits are lost.
    #[inline(always)]
    pub fn moved(&self, point: [N; 2], [first, second]: [[N; 2]; 2]) -> Self {
        Self {
            offsets: [
                plus(self.offsets[0], minus(point, first)),
                plus(self.offsets[1], minus(point, second)),
            ],
            edge: plus(self.edge, minus(second, first)),
        }
    }

    /// Projection of the point onto the segment's line.
    #[inline(always)]
    pub fn projection(&self) -> Projection<N> {
        Projection { along: product(self.offsets[0], self.edge), square: product(self.edge, self.edge) }
    }
}

/// Current position of a contact relative to the segment opposite.
#[derive(Clone, Copy, Default)]
pub(super) struct Position<N = f64> {
    /// Position along the segment, from 0 to 1.
    pub position: N,
    /// Directions along the segment and out of the other side.
    pub tangent: [N; 2],
    pub normal: [N; 2],
    /// Distance from the other side, m; negative for overlap.
    pub gap: N,
    /// Abscissa along the other side minus that along its own side, in unloaded lengths, m.
    pub slip: N,
    /// Unloaded length of the segment over the current one.
    pub shortening: N,
}

impl<N: Real> Position<N> {
    /// The position of a point opposite a `moved` segment. `downstream` is 1 for a point of the upper side and −1 for one of the lower
    /// side; `abscissas` are those of the segment's nodes less that of the point, and `at_rest` is its unloaded length, m.
    #[inline(always)]
    pub fn new(
        downstream: N,
        moved: &Segment<N>,
        Projection { along, square }: Projection<N>,
        abscissas: [N; 2],
        at_rest: N,
    ) -> Self {
        let inverse = square.constant(1.0) / square;
        let position = along * inverse;
        let scale = square.sqrt() * inverse;
        let tangent = times(scale, moved.edge);
        let normal = normal(downstream, tangent);
        // relative to the nearer end, so that the result is exact for matching nodes
        let nearer = position.constant(0.5).less_than(position);
        let [before, after] = moved.offsets;
        let offset = [nearer.select(after[0], before[0]), nearer.select(after[1], before[1])];
        let nearest = nearer.select(abscissas[1], abscissas[0]);
        Self {
            position,
            tangent,
            normal,
            gap: product(offset, normal),
            slip: nearest + product(offset, tangent) * scale * at_rest,
            shortening: at_rest * scale,
        }
    }

    /// Whether the `part` of its side (from and to this abscissa, m) that a contact represents certainly lies wholly opposite the other
    /// side, which has this `length` (m).
    #[inline(always)]
    pub fn is_inside(&self, [from, to]: [N; 2], length: N) -> N::Mask {
        // if a side is tilted, the slip gives the position of its end only approximately
        let margin = (to - from) * TILT;
        (margin - self.slip).less_than(from) & to.less_than(length - self.slip - margin)
    }
}

/// Largest error with which the slip gives the position of the other side's end, as a share of a contact's part:
/// 1 − cos θ for θ = 25°.
const TILT: f64 = 0.1;

/// Normal to a direction downstream, out of the other side: to the left on the upper side (`downstream` = 1), to the right on the lower
/// side (−1).
#[inline(always)]
pub(super) fn normal<N: Real>(downstream: N, [x, y]: [N; 2]) -> [N; 2] {
    [downstream * -y, downstream * x]
}

#[inline(always)]
pub(super) fn plus<N: Real>(a: [N; 2], b: [N; 2]) -> [N; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline(always)]
pub(super) fn minus<N: Real>(a: [N; 2], b: [N; 2]) -> [N; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

#[inline(always)]
pub(super) fn times<N: Real>(a: N, b: [N; 2]) -> [N; 2] {
    [a * b[0], a * b[1]]
}

#[inline(always)]
pub(super) fn product<N: Real>(a: [N; 2], b: [N; 2]) -> N {
    a[0] * b[0] + a[1] * b[1]
}
