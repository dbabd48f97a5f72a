//! A slender cantilever beam of rectangular section, per metre of thickness. Tested in `tests/cantilever.rs`.
//!
//! **Source**: S.P. Timoshenko, *Strength of Materials, Part I*, 1955, section 39 (shear); S.P. Timoshenko,
//! D.H. Young, *Vibration Problems in Engineering*, 1955, section 53 (frequency).

/// Deflection of the tip under the transverse force `force` there, m: `F L³/3EI + 6FL/5GA`.
///
/// **Units**: `force` N/m, `length` and `depth` m, `young_modulus` and `shear_modulus` Pa.
pub fn tip_deflection(force: f64, length: f64, depth: f64, young_modulus: f64, shear_modulus: f64) -> f64 {
    force * length.powi(3) / (3.0 * young_modulus * depth.powi(3) / 12.0)
        + 1.2 * force * length / (shear_modulus * depth)
}

/// First circular frequency of bending, rad/s, without shear deformation and rotary inertia: `1.8751² √(EI/ρA) / L²`.
///
/// **Units**: as above, `density` kg/m³.
pub fn first_frequency(length: f64, depth: f64, young_modulus: f64, density: f64) -> f64 {
    /// First root of cos x cosh x = −1.
    const ROOT: f64 = 1.875_104_068_711_961;
    (ROOT / length).powi(2) * (young_modulus * depth * depth / (12.0 * density)).sqrt()
}

/// Bending stress at the face that the transverse force `force` at the tip pulls, `from_tip` below the tip, Pa: `6Fz/h²`.
///
/// **Units**: `force` N/m, `from_tip` and `depth` m. Exact at a distance from both ends, for any Poisson's ratio.
pub fn bending_stress(force: f64, from_tip: f64, depth: f64) -> f64 {
    6.0 * force * from_tip / (depth * depth)
}
