//! Periods of a bar and of a block on a joint. Tested in `tests/vibration.rs`.

use std::f64::consts::TAU;

/// First longitudinal period of a bar with one fixed end, `4L/c` with `c = √(E/ρ)`, s.
///
/// **Units**: `length` m, `young_modulus` Pa, `density` kg/m³.
pub fn bar_period(length: f64, young_modulus: f64, density: f64) -> f64 {
    4.0 * length * (density / young_modulus).sqrt()
}

/// Period of a rigid block on a closed joint, `2π √(m / (k_n A))`, s.
///
/// **Units**: `mass` kg/m, `normal_stiffness` Pa/m, `length` of the joint m.
pub fn joint_period(mass: f64, normal_stiffness: f64, length: f64) -> f64 {
    TAU * (mass / (normal_stiffness * length)).sqrt()
}
