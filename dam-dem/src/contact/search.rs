/// Segment of a chain on which a point projects, found by walking from the segment `start`.
///
/// `project(segment)` is the position of the projection along a segment, 0 at its first and 1 at
/// its last node. The walk keeps its direction, so it ends; beyond an end of the chain the end
/// segment is returned with a position outside [0, 1].
pub(super) fn find_segment(start: usize, count: usize, project: impl Fn(usize) -> f64) -> (usize, f64) {
    let mut segment = start.min(count - 1);
    let mut position = project(segment);
    if position < 0.0 {
        while position < 0.0 && segment > 0 {
            segment -= 1;
            position = project(segment);
        }
    } else {
        while position > 1.0 && segment + 1 < count {
            segment += 1;
            position = project(segment);
        }
    }
    (segment, position)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walking_finds_what_a_scan_finds() {
        let ends = [0.0, 1.0, 1.5, 4.0, 4.2, 7.0];
        let count = ends.len() - 1;
        let project = |x: f64| move |i: usize| (x - ends[i]) / (ends[i + 1] - ends[i]);
        for (x, start) in (-10..85).flat_map(|x| (0..count).map(move |s| (0.097 * f64::from(x), s))) {
            let scan = (0..count).find(|&i| (0.0..=1.0).contains(&project(x)(i))).unwrap_or(if x < 0.0 {
                0
            } else {
                count - 1
            });
            let (walked, position) = find_segment(start, count, project(x));
            assert!(walked == scan || position == 0.0, "x = {x} from {start}");
        }
    }
}
