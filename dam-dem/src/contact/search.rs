/// A chain of segments, and a point beside it. (No closure, which would be compiled into some of the code for the widest registers and
/// called from the rest.)
pub(super) trait Chain {
    /// The scalar product of the point's offset from the first node of a `segment` with the segment vector, and the squared length of
    /// the segment; the segment vector.
    fn project(&self, segment: usize) -> ([f64; 2], [f64; 2]);
}

/// Segment of a `chain` of `count` onto which its point projects, found by a walk from the segment `start`, and the result
/// of [`Chain::project`] for this segment.
///
/// The walk never changes its
/// direction, so that it always ends. It leaves a segment only by more than a [`MARGIN`]: a point opposite a node, as on
/// the axis of a symmetric stack, would otherwise change its segment, and the direction of its force, by rounding errors, and
/// find no rest. For a point beyond an end of the chain the end segment is returned.
#[inline(always)]
pub(super) fn find_segment(start: usize, count: usize, chain: &impl Chain) -> (usize, [f64; 2], [f64; 2]) {
    let mut segment = start.min(count - 1);
    let ([mut along, mut whole], mut edge) = chain.project(segment);
    // the first comparison is true of hardly any point, and spares the product
    let is_before = |along: f64, whole: f64| along < 0.0 && along < -MARGIN * whole;
    let is_behind = |along: f64, whole: f64| along > whole && along > (1.0 + MARGIN) * whole;
    let backwards = is_before(along, whole);
    while if backwards {
        is_before(along, whole) && segment > 0
    } else {
        is_behind(along, whole) && segment + 1 < count
    } {
        segment = if backwards { segment - 1 } else { segment + 1 };
        ([along, whole], edge) = chain.project(segment);
    }
    (segment, [along, whole], edge)
}

/// Distance beyond an end of a segment, as a share of its length, up to which a point still belongs to it.
pub(super) const MARGIN: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    struct Beside<const N: usize> {
        ends: [f64; N],
        x: f64,
    }

    impl<const N: usize> Chain for Beside<N> {
        fn project(&self, i: usize) -> ([f64; 2], [f64; 2]) {
            let whole = self.ends[i + 1] - self.ends[i];
            ([(self.x - self.ends[i]) * whole, whole * whole], [whole, 0.0])
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
