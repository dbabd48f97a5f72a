use crate::real::Real;

/// Projection of a point onto the line of a segment.
#[derive(Clone, Copy)]
pub(super) struct Projection<N = f64> {
    /// Scalar product of the point's offset from the first node of the segment with the segment vector, m².
    pub along: N,
    /// Squared length of the segment, m².
    pub square: N,
}

impl<N: Real> Projection<N> {
    /// Whether the point lies before the first node of the segment by more than a [`MARGIN`].
    #[inline(always)]
    pub fn is_before(&self) -> N::Mask {
        self.along.less_than(self.along.constant(0.0)) & self.along.less_than(self.square * -MARGIN)
    }

    /// Whether the point lies behind the last node of the segment by more than a [`MARGIN`].
    #[inline(always)]
    pub fn is_behind(&self) -> N::Mask {
        self.square.less_than(self.along) & (self.square * (1.0 + MARGIN)).less_than(self.along)
    }
}

/// A chain of segments, and a point beside it. (No closure, which would be compiled into some of the code for the widest registers and
/// called from the rest.)
pub(super) trait Chain {
    /// A segment as seen from the point.
    type Segment;

    /// The projection of the point onto a `segment`, and the segment.
    fn project(&self, segment: usize) -> (Projection, Self::Segment);
}

/// Segment of a `chain` of `count` onto which its point projects, found by a walk from the segment `start`, and the result
/// of [`Chain::project`] for this segment.
///
/// The walk never changes its direction, so that it always ends. It leaves a segment only by more than a [`MARGIN`]: a point
/// opposite a node, as on the axis of a symmetric stack, would otherwise change its segment, and the direction of its force,
/// because of rounding errors, and never come to rest. For a point beyond an end of the chain the end segment is returned.
#[inline(always)]
pub(super) fn find_segment<C: Chain>(
    start: usize,
    count: usize,
    chain: &C,
) -> (usize, Projection, C::Segment) {
    let mut segment = start.min(count - 1);
    let (mut projection, mut found) = chain.project(segment);
    let backwards = projection.is_before();
    while if backwards {
        projection.is_before() && segment > 0
    } else {
        projection.is_behind() && segment + 1 < count
    } {
        segment = if backwards { segment - 1 } else { segment + 1 };
        (projection, found) = chain.project(segment);
    }
    (segment, projection, found)
}

/// Distance beyond an end of a segment, as a share of its length, up to which a point still belongs to it.
const MARGIN: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    struct Beside<const N: usize> {
        ends: [f64; N],
        x: f64,
    }

    impl<const N: usize> Chain for Beside<N> {
        type Segment = ();

        fn project(&self, i: usize) -> (Projection, ()) {
            let whole = self.ends[i + 1] - self.ends[i];
            (Projection { along: (self.x - self.ends[i]) * whole, square: whole * whole }, ())
        }
    }

    #[test]
    fn walking_finds_what_a_scan_finds() {
        let ends = [0.0, 1.0, 1.5, 4.0, 4.2, 7.0];
        let count = ends.len() - 1;
        for (x, start) in (-10..85).flat_map(|x| (0..count).map(move |s| (0.097 * f64::from(x), s))) {
            let inside = |i: &usize| (ends[*i]..=ends[i + 1]).contains(&x);
            let scan = (0..count).find(inside).unwrap_or(if x < 0.0 { 0 } else { count - 1 });
            let (walked, ..) = find_segment(start, count, &Beside { ends, x });
            assert!(walked == scan || x == ends[walked], "x = {x} from {start}");
        }
    }
}
