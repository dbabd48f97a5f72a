//! A column of two layers that is held at its base, with ν = 0. Tested in `tests/zones.rs`.

use std::f64::consts::PI;

/// A layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Height, m.
    pub height: f64,
    /// Young's modulus E, Pa.
    pub young_modulus: f64,
    /// Density ρ, kg/m³.
    pub density: f64,
}

impl Layer {
    /// Velocity of waves along the column, `√(E/ρ)`, m/s.
    fn velocity(&self) -> f64 {
        (self.young_modulus / self.density).sqrt()
    }
}

/// Settlement (m) at the height `y` (m) under the column's weight and a pressure `top` (Pa) on it:
///
/// ```text
/// v(y) = ∫₀^y σ(z)/E dz,   σ(z) = top + g ∫_z^h ρ
/// ```
///
/// **Units**: `gravity` m/s².
pub fn settlement([lower, upper]: [Layer; 2], gravity: f64, top: f64, y: f64) -> f64 {
    // σ/E of a layer is linear in z
    let within = |layer: Layer, above: f64, up_to: f64| {
        let mean = above + gravity * layer.density * (layer.height - up_to / 2.0);
        mean * up_to / layer.young_modulus
    };
    let middle = top + gravity * upper.density * upper.height;
    let below = within(lower, middle, y.min(lower.height));
    below + within(upper, top, (y - lower.height).max(0.0))
}

/// The lowest natural frequency of motion along the column, rad/s: the first root of
///
/// ```text
/// tan(ω h₁/c₁) tan(ω h₂/c₂) = ρ₁c₁ / ρ₂c₂
/// ```
///
/// from `sin(ω y/c₁)` below and `cos(ω (h − y)/c₂)` above, with the same displacement and force where they meet.
pub fn first_frequency([lower, upper]: [Layer; 2]) -> f64 {
    let [first, second] = [lower, upper].map(|layer| layer.height / layer.velocity());
    let ratio = lower.density * lower.velocity() / (upper.density * upper.velocity());
    let rest =
        |w: f64| (w * first).sin() * (w * second).sin() - ratio * (w * first).cos() * (w * second).cos();
    // below the first pole of both tangents their product grows from 0 without bound
    let (mut least, mut most) = (0.0, PI / 2.0 / first.max(second));
    for _ in 0..200 {
        let middle = (least + most) / 2.0;
        if rest(middle) < 0.0 { least = middle } else { most = middle }
    }
    (least + most) / 2.0
}
