//! Points and segments in the plane.

pub type Point = [f64; 2];

pub fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

pub fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub fn distance(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The point at share `t` of the way; exactly an end at 0 and 1.
pub fn between([a, b]: [Point; 2], t: f64) -> Point {
    if t == 1.0 { b } else { [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])] }
}

/// Twice the signed area of a triangle, positive if counter-clockwise.
pub fn orientation(a: Point, b: Point, c: Point) -> f64 {
    cross(minus(b, a), minus(c, a))
}

/// Share of the way along the segment where it is nearest to `p`.
pub fn nearest_share([a, b]: [Point; 2], p: Point) -> f64 {
    let d = minus(b, a);
    let length_squared = dot(d, d);
    if length_squared == 0.0 { 0.0 } else { (dot(minus(p, a), d) / length_squared).clamp(0.0, 1.0) }
}

/// The segment's point nearest to `p`; on a level or vertical one the coordinate of `p` is kept bit for bit.
pub fn nearest(segment: [Point; 2], p: Point) -> Point {
    let [a, b] = segment;
    let clamped = |axis: usize| p[axis].clamp(a[axis].min(b[axis]), a[axis].max(b[axis]));
    if a[0] == b[0] {
        [a[0], clamped(1)]
    } else if a[1] == b[1] {
        [clamped(0), a[1]]
    } else {
        between(segment, nearest_share(segment, p))
    }
}

/// Shares of the way along both lines where they meet, if they are not parallel.
pub fn meeting([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Option<[f64; 2]> {
    let (r, s) = (minus(b, a), minus(d, c));
    let determinant = cross(r, s);
    let shares = [cross(minus(c, a), s) / determinant, cross(minus(c, a), r) / determinant];
    shares.iter().all(|t| t.is_finite()).then_some(shares)
}

/// Whether the ends of each segment lie clearly on different sides of the other.
pub fn cross_properly(first: [Point; 2], second: [Point; 2]) -> bool {
    let separates = |[a, b]: [Point; 2], ends: [Point; 2]| {
        let [c, d] = ends.map(|p| orientation(a, b, p));
        let rounding = 1e-13 * distance(a, b) * (distance(a, ends[0]) + distance(a, ends[1]));
        c.min(d) < -rounding && c.max(d) > rounding
    };
    separates(first, second) && separates(second, first)
}

/// Smallest angle of a triangle, rad; negative if it is clockwise.
pub fn smallest_angle(corners: [Point; 3]) -> f64 {
    let twice_area = orientation(corners[0], corners[1], corners[2]);
    let angle = |i: usize| {
        let [p, q, r] = [corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]];
        twice_area.abs().atan2(dot(minus(q, p), minus(r, p)))
    };
    let least = angle(0).min(angle(1)).min(angle(2));
    if twice_area > 0.0 { least } else { -least }
}

/// Smallest altitude of a triangle; negative if it is clockwise.
pub fn smallest_altitude([a, b, c]: [Point; 3]) -> f64 {
    orientation(a, b, c) / distance(a, b).max(distance(b, c)).max(distance(c, a))
}

/// Area of a polygon, m², positive if counter-clockwise.
pub fn area(polygon: &[Point]) -> f64 {
    (1..polygon.len().max(2) - 1).map(|i| 0.5 * orientation(polygon[0], polygon[i], polygon[i + 1])).sum()
}
