use std::f64::consts::PI;

/// Factor of `K₀(kr)` in the single layer: `G = K₀(kr)/2π`.
pub(super) fn weight() -> f64 {
    0.5 / PI
}
