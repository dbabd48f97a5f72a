//! Incompressible water before a rigid face of any slope on a flat bed, p = 0 at the surface.
//!
//! For a face with the horizontal acceleration a into the water, `P = p − ρax` has a zero normal derivative on face and bed
//! and equals −ρax at the surface. The strip 0 < Im w < π/2 is mapped onto the water, bed and face from Im w = 0, the surface from
//! Im w = π/2, the heel from w = 0; with ζ = e^{2w} and the water's angle βπ at the heel
//!
//! ```text
//! dz/dζ = (h/π) (1 − ζ)^{β−1}/ζ,   P(u) = (1/π) ∫ sech(u − u′) [−ρa x_s(u′)] du′
//! ```
//!
//! **Source**: Chwang, A. T. (1978), Hydrodynamic pressures on sloping dams during earthquakes. Part 2. Exact theory,
//! Journal of Fluid Mechanics 87, 343–348, who posed the problem; the quadratures here have another form.
//! Checked by its static limits and by `tests/chwang_1978.rs`.

use std::f64::consts::PI;

/// Spacing of the trapezoidal rule in u; its error falls like e^{−π²/spacing}.
const SPACING: f64 = 0.05;
/// Half the range of u.
const RANGE: f64 = 40.0;

/// Pressures over ρa in m on a face that rises at `angle` (radians from the bed downstream, π/2: vertical, less: battered
/// with the water above it), at the fractions `along` (0 to 1) of its length from the heel.
pub fn pressures(depth: f64, angle: f64, along: &[f64]) -> Vec<f64> {
    let beta = 1.0 - angle / PI;
    let count = (RANGE / SPACING) as i32;
    let u = |i: i32| SPACING * f64::from(i);
    // x along the surface, from the top of the face (u = +∞): −∫_u^∞ (h/π) 2 (1 + e^{2u})^{β−1} du.
    let density = |u: f64| depth / PI * 2.0 * (1.0 + (2.0 * u).exp()).powf(beta - 1.0);
    let top = depth / angle.tan();
    let tail = depth / PI / (1.0 - beta) * (2.0 * RANGE * (beta - 1.0)).exp();
    let mut surface = vec![top - tail; 2 * count as usize + 1];
    for i in (0..2 * count).rev() {
        let (a, b) = (u(i - count), u(i + 1 - count));
        let step = SPACING / 6.0 * (density(a) + 4.0 * density(0.5 * (a + b)) + density(b));
        surface[i as usize] = surface[i as usize + 1] - step;
    }
    along
        .iter()
        .map(|&share| {
            let position = prevertex(beta, share);
            let x = share * depth / angle.tan();
            let sum: f64 = (-count..=count)
                .map(|i| -surface[(i + count) as usize] / (position - u(i)).cosh() * SPACING)
                .sum();
            if share < 1.0 { x + sum / PI } else { 0.0 }
        })
        .collect()
}

/// u of the point at a fraction of the face's length: `∫_0^u 2(e^{2v} − 1)^{β−1} dv = share π/sin πβ`.
fn prevertex(beta: f64, share: f64) -> f64 {
    // With t = 1 − e^{−2u}: the incomplete beta function ∫_0^t r^{β−1} (1 − r)^{−β} dr.
    let whole = PI / (PI * beta).sin();
    let [mut low, mut high] = [0.0, RANGE];
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if incomplete(beta, middle) < share * whole { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// `∫_0^u 2(e^{2v} − 1)^{β−1} dv`, by v = y^{1/β}, which is smooth at the heel.
fn incomplete(beta: f64, u: f64) -> f64 {
    let end = u.powf(beta);
    let points = 400;
    let spacing = end / f64::from(points);
    // v^{β−1} dv = dy/β; the rest, ((e^{2v} − 1)/v)^{β−1}, is smooth in v.
    let value = |y: f64| {
        let v = y.powf(1.0 / beta);
        let ratio = if v > 0.0 { (2.0 * v).exp_m1() / v } else { 2.0 };
        2.0 / beta * ratio.powf(beta - 1.0)
    };
    let simpson = |i: i32| {
        if i == 0 || i == points {
            1.0
        } else if i % 2 == 1 {
            4.0
        } else {
            2.0
        }
    };
    (0..=points).map(|i| simpson(i) * value(spacing * f64::from(i))).sum::<f64>() * spacing / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analytical::chopra_1967;
    use num_complex::Complex64;

    /// A vertical face: Westergaard's series at every point.
    #[test]
    fn a_vertical_face_has_the_series() {
        let shares = [0.0, 0.2, 0.5, 0.9, 1.0];
        let s = Complex64::new(1e-9, 0.0);
        for (share, p) in shares.iter().zip(pressures(1.0, 0.5 * PI, &shares)) {
            let exact = chopra_1967::pressure(s, 1.0, 1.0, *share).re;
            println!("share {share}: {p:.8} against {exact:.8}");
            assert!((p - exact).abs() < 2e-7);
        }
    }
}
