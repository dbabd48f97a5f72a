//! The hydrostatic load on a face, and Westergaard's pressure.

/// Pressure of the parabola p = −⅞ ρ a √(h (h − y)), Pa, at a height `y` (m) of water of this `depth` (m) and `density` (kg/m³)
/// before a rigid face that accelerates by `acceleration` (m/s², positive downstream, out of the water).
///
/// **Source**: H.M. Westergaard, Water pressures on dams during earthquakes, Transactions ASCE 98 (1933).
pub fn pressure(acceleration: f64, density: f64, depth: f64, y: f64) -> f64 {
    -0.875 * density * acceleration * (depth * (depth - y).max(0.0)).sqrt()
}

/// Force (x, y) of still water on a face, N/m: ∫ γ (h − y) n ds along the polyline `face` from its base up, n out of the water to
/// its right (seen upwards), γ (N/m³) its weight, h its `depth` (m).
pub fn static_force(face: &[[f64; 2]], weight: f64, depth: f64) -> [f64; 2] {
    let mut force = [0.0; 2];
    for pair in face.windows(2) {
        let [a, mut b] = [pair[0], pair[1]];
        if a[1] >= depth {
            break;
        }
        if b[1] > depth {
            let share = (depth - a[1]) / (b[1] - a[1]);
            b = [a[0] + share * (b[0] - a[0]), depth];
        }
        let mean = weight * (depth - (a[1] + b[1]) / 2.0);
        force[0] += mean * (b[1] - a[1]);
        force[1] -= mean * (b[0] - a[0]);
    }
    force
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_thrust_is_that_of_the_textbook_and_the_weight_above_a_batter_is_the_waters() {
        let [x, y] = static_force(&[[0.0, 0.0], [2.0, 10.0], [2.0, 20.0]], 9810.0, 15.0);
        assert!((x / (9810.0 * 15.0 * 15.0 / 2.0) - 1.0).abs() < 1e-14, "{x}");
        // A trapezoid of water stands on the batter: 2 m wide, 15 and 5 m high.
        assert!((y / (-9810.0 * 2.0 * 10.0) - 1.0).abs() < 1e-14, "{y}");
    }

    #[test]
    fn a_face_that_moves_into_the_water_is_pressed() {
        // Westergaard 1933: 7/8 of γ times the acceleration in g times the depth at the base.
        assert_eq!(pressure(-2.0, 1000.0, 80.0, 0.0), 0.875 * 1000.0 * 2.0 * 80.0);
        assert_eq!(pressure(2.0, 1000.0, 80.0, 81.0), 0.0);
    }
}
