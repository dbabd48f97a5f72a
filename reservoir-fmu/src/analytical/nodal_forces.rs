//! Nodal forces at the points of the wet face from a pressure that is known everywhere.

use cofferdam_unit::WetFace;
use num_complex::Complex64;

/// Positive positions of Gauss' rule of six points on [−1, 1], and their weights.
const RULE: [(f64, f64); 3] = [
    (0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_4),
];

/// `∫ p N_i ds` (N/m for p in Pa) of every point of `face`, with N its hat function along the panels. p is a function of
/// elevations (m) and is called once with all of them. Gauss' rule of six points per panel, graded upwards, because
/// p ~ r ln r near the surface.
pub fn nodal_forces(face: &WetFace, pressure: impl FnOnce(&[f64]) -> Vec<Complex64>) -> Vec<Complex64> {
    let mut nodes = Vec::new();
    for panel in face.panels() {
        let [low, high] = [0, 1].map(|end| face.points()[panel.start + end][1]);
        for (position, weight) in RULE.iter().flat_map(|&(x, w)| [(-x, w), (x, w)]) {
            let u = 0.5 * (1.0 - position);
            let along = 1.0 - u * u;
            nodes.push((panel.start, along, low + along * (high - low), u * weight * panel.length));
        }
    }
    let values = pressure(&nodes.iter().map(|node| node.2).collect::<Vec<_>>());
    let mut forces = vec![Complex64::ZERO; face.len()];
    for ((start, along, _, weight), value) in nodes.into_iter().zip(values) {
        forces[start] += weight * (1.0 - along) * value;
        forces[start + 1] += weight * along * value;
    }
    forces
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A panel of length ℓ from y₀ to y₁ under p = y: ℓ(2y₀ + y₁)/6 and ℓ(y₀ + 2y₁)/6.
    #[test]
    fn a_pressure_linear_in_elevation() {
        let face = WetFace::new(vec![[0.0, 0.0], [3.0, 4.0]]).unwrap();
        let forces = nodal_forces(&face, |at| at.iter().map(|y| (*y).into()).collect());
        for (force, expected) in forces.iter().zip([5.0 * 4.0 / 6.0, 5.0 * 8.0 / 6.0]) {
            assert!((force - expected).norm() < 1e-12, "{force}");
        }
    }
}
