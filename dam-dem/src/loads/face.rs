use super::LoadBasis;
use crate::Mesh;

/// A side of the dam.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Upstream,
    Downstream,
}

/// Nodal forces of a stress on one side of the dam up to `level` (m), linear in the depth z below it: `σ_h = horizontal z` on the
/// vertical, `σ_v = vertical z` on the horizontal projection of the face (N/m³); both are equal for water.
pub(crate) fn of_depth(mesh: &Mesh, side: Side, level: f64, [horizontal, vertical]: [f64; 2]) -> LoadBasis {
    let (chain, inwards) = match side {
        Side::Upstream => (&mesh.upstream, 1.0),
        Side::Downstream => (&mesh.downstream, -1.0),
    };
    let mut entries = Vec::new();
    for pair in chain.windows(2) {
        let [lower, upper] = [pair[0], pair[1]].map(|node| mesh.nodes[node]);
        let [dx, dy] = [upper[0] - lower[0], upper[1] - lower[1]];
        if dy <= 0.0 || lower[1] >= level {
            continue;
        }
        // the wet part of the panel, from its lower end
        let part = ((level - lower[1]) / dy).min(1.0);
        let depth = |share: f64| level - lower[1] - share * dy;
        // ∫ z N over the part, z linear, N the shape of the upper and of the lower node: Simpson's rule is exact
        let simpson =
            |value: &dyn Fn(f64) -> f64| part / 6.0 * (value(0.0) + 4.0 * value(part / 2.0) + value(part));
        let of_upper = simpson(&|share| depth(share) * share);
        let of_lower = simpson(&|share| depth(share) * (1.0 - share));
        for (node, moment) in [(pair[0], of_lower), (pair[1], of_upper)] {
            let force = [inwards * horizontal * moment * dy, -inwards * vertical * moment * dx];
            entries.push((node, 0, force));
        }
    }
    LoadBasis { columns: 1, entries }
}

/// Nodal forces of Westergaard's pressure on the upstream side for a horizontal acceleration `a` of the dam against the water, with
/// `ρ a` in N/m³ and water up to `level` (m): `p = ⅞ ρ a √(h z)` on the vertical projection of the face, h its whole depth and z
/// the depth below the surface.
///
/// **Source**: H.M. Westergaard, *Water pressures on dams during earthquakes*, 1933.
pub(crate) fn westergaard(mesh: &Mesh, level: f64, inertia: f64) -> LoadBasis {
    let mut entries = Vec::new();
    for pair in mesh.upstream.windows(2) {
        let [lower, upper] = [pair[0], pair[1]].map(|node| mesh.nodes[node]);
        let dy = upper[1] - lower[1];
        if dy <= 0.0 || lower[1] >= level {
            continue;
        }
        // ∫ √z N dz, with N = (deepest − z)/dy at the upper node
        let deepest = level - lower[1];
        let [from, to] = [(deepest - dy).max(0.0), deepest];
        let moment = |power: f64| (to.powf(power) - from.powf(power)) / power;
        let (whole, first) = (moment(1.5), moment(2.5));
        let of_upper = (deepest * whole - first) / dy;
        for (node, integral) in [(pair[0], whole - of_upper), (pair[1], of_upper)] {
            entries.push((node, 0, [0.875 * inertia * level.sqrt() * integral, 0.0]));
        }
    }
    LoadBasis { columns: 1, entries }
}

/// Nodal forces of a `force` (N/m) at a `point` (m) of the dam: on the corners of the triangle in which it lies, with the weights of
/// linear interpolation, so that force and moment are exact; `None` outside the dam.
pub(super) fn at_point(mesh: &Mesh, point: [f64; 2], force: [f64; 2]) -> Option<LoadBasis> {
    let weights = |nodes: [usize; 3]| {
        let [a, b, c] = nodes.map(|node| mesh.nodes[node]);
        let cross = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
            (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1])
        };
        let area = cross(a, b, c);
        [cross(point, b, c) / area, cross(a, point, c) / area, cross(a, b, point) / area]
    };
    let least = |weights: [f64; 3]| weights.into_iter().fold(f64::INFINITY, f64::min);
    let (nodes, found) = mesh
        .triangles()
        .map(|nodes| (nodes, weights(nodes)))
        .max_by(|(_, a), (_, b)| least(*a).total_cmp(&least(*b)))?;
    found.iter().all(|weight| *weight > -BESIDE).then(|| {
        let entry = |(node, weight): (usize, f64)| (node, 0, force.map(|force| weight * force));
        LoadBasis { columns: 1, entries: nodes.into_iter().zip(found).map(entry).collect() }
    })
}

/// How far beside a triangle a point on its edge may lie by rounding, as a share of its size.
const BESIDE: f64 = 1e-6;
