/// Mean elevation over the length of the line through `points`, m. The results of cracks come in its order.
pub fn mean_elevation(points: &[[f64; 2]]) -> f64 {
    let (mut moment, mut length) = (0.0, 0.0);
    for pair in points.windows(2) {
        let part = (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
        moment += part * (pair[0][1] + pair[1][1]) / 2.0;
        length += part;
    }
    if length > 0.0 { moment / length } else { points.first().map_or(0.0, |point| point[1]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longer_part_weighs_more() {
        assert_eq!(mean_elevation(&[[0.0, 2.0], [3.0, 2.0], [3.0, 3.0]]), 2.125);
        assert_eq!((mean_elevation(&[[1.0, 4.0]]), mean_elevation(&[])), (4.0, 0.0));
    }
}
