use super::QuadraturePoint;
use std::borrow::Cow;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Legendre polynomial `P_n(x)` and its derivative, by the three-term recurrence.
///
/// At x = ±1 the derivative is the limit `±1^{n+1} n(n+1)/2`.
pub(crate) fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut p, mut previous, mut dp, mut previous_dp) = (1.0, 0.0, 0.0, 0.0);
    for degree in 0..n {
        let d = degree as f64;
        let next = ((2.0 * d + 1.0) * x * p - d * previous) / (d + 1.0);
        let next_dp = previous_dp + (2.0 * d + 1.0) * p;
        (previous, p) = (p, next);
        (previous_dp, dp) = (dp, next_dp);
    }
    (p, dp)
}

/// Rules, each computed once.
const KEPT: usize = 32;

/// Gauss–Legendre rule of `n` points on [−1, 1], exact to degree 2n − 1.
pub(crate) fn gauss_legendre(n: usize) -> Cow<'static, [QuadraturePoint]> {
    static RULES: LazyLock<Vec<Vec<QuadraturePoint>>> = LazyLock::new(|| (0..=KEPT).map(rule).collect());
    if n <= KEPT { Cow::Borrowed(&RULES[n]) } else { Cow::Owned(rule(n)) }
}

fn rule(n: usize) -> Vec<QuadraturePoint> {
    (0..n)
        .map(|i| {
            let mut x = -(PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            for _ in 0..8 {
                let (p, dp) = legendre(n, x);
                x -= p / dp;
            }
            let (_, dp) = legendre(n, x);
            QuadraturePoint { position: x, weight: 2.0 / ((1.0 - x * x) * dp * dp) }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_for_polynomials() {
        for n in [2, 5, 9, 20] {
            for degree in 0..2 * n {
                let sum: f64 =
                    gauss_legendre(n).iter().map(|q| q.weight * q.position.powi(degree as i32)).sum();
                let exact = if degree % 2 == 0 { 2.0 / (degree as f64 + 1.0) } else { 0.0 };
                assert!((sum - exact).abs() < 1e-14, "n = {n}, degree {degree}: {sum} against {exact}");
            }
        }
    }
}
