use super::{QuadraturePoint, gauss_legendre};

/// Points on either side of the singularity.
const POINTS: usize = 20;

/// Rule for `f(ξ) + g(ξ) ln|ξ − ξ₀|` with smooth f, g and `singularity` ξ₀ in [−1, 1].
///
/// Each side is mapped by `ξ = ξ₀ ± ℓu⁴`, which turns `ln ξ dξ` into `u³ ln u du`: Gauss'
/// rule in u then converges like n⁻⁸. The points are added to `rule`.
pub(crate) fn log_singular(singularity: f64, rule: &mut Vec<QuadraturePoint>) {
    for (side, length) in [(-1.0, 1.0 + singularity), (1.0, 1.0 - singularity)] {
        if length < 1e-12 {
            continue;
        }
        for q in gauss_legendre(POINTS).iter() {
            let u = 0.5 * (1.0 + q.position);
            rule.push(QuadraturePoint {
                position: singularity + side * length * u.powi(4),
                weight: 0.5 * q.weight * length * 4.0 * u.powi(3),
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gauss of 20 points in u leaves 1e-9.
    /// ∫ ln|ξ − a| dξ = (1 − a) ln(1 − a) + (1 + a) ln(1 + a) − 2.
    #[test]
    fn integrates_the_logarithm() {
        for a in [-1.0, -0.57735, 0.0, 0.57735, 1.0f64] {
            let mut rule = Vec::new();
            log_singular(a, &mut rule);
            let sum: f64 = rule.iter().map(|q| q.weight * (q.position - a).abs().ln()).sum();
            let part = |x: f64| if x > 0.0 { x * x.ln() } else { 0.0 };
            let exact = part(1.0 - a) + part(1.0 + a) - 2.0;
            assert!((sum - exact).abs() < 2e-9, "{sum} against {exact}");
        }
    }
}
