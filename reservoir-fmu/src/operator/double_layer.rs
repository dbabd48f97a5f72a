use std::f64::consts::PI;

/// Relative height below which a source lies on the element's line.
const FLAT: f64 = 1e-10;

/// Factor of `k K₁(kr)` in the double layer: `∂G/∂n_y = −(k K₁(kr)/2π) (r·n)/r`.
///
/// `r` from the source to the point on the element (m), `half` its half length (m). A source
/// on the element's own line gives exactly zero, not the rounding error of `r·n`.
pub(super) fn weight(r: [f64; 2], normal: [f64; 2], half: f64) -> f64 {
    let height = r[0] * normal[0] + r[1] * normal[1];
    let distance = r[0].hypot(r[1]);
    if height.abs() < FLAT * half { 0.0 } else { -0.5 / PI * height / distance }
}
