//! Matrices of straight-sided triangles with six nodes, and of their edges.

/// `∫ N_i N_j dA` over the triangle's area; nodes as in [`TriangleMesh`](super::mesh::TriangleMesh).
pub const MASS: [[f64; 6]; 6] = {
    let (a, b, c, d, e) = (6.0 / 180.0, -1.0 / 180.0, -4.0 / 180.0, 32.0 / 180.0, 16.0 / 180.0);
    [
        [a, b, b, 0.0, c, 0.0],
        [b, a, b, 0.0, 0.0, c],
        [b, b, a, c, 0.0, 0.0],
        [0.0, 0.0, c, d, e, e],
        [c, 0.0, 0.0, e, d, e],
        [0.0, c, 0.0, e, e, d],
    ]
};

/// `∫ N_i N_j ds` over the edge's length; nodes at the start, in the middle, at the end.
pub const EDGE_MASS: [[f64; 3]; 3] = [
    [4.0 / 30.0, 2.0 / 30.0, -1.0 / 30.0],
    [2.0 / 30.0, 16.0 / 30.0, 2.0 / 30.0],
    [-1.0 / 30.0, 2.0 / 30.0, 4.0 / 30.0],
];

/// `∫ N_i' N_j' ds` times the edge's length.
pub const EDGE_STIFFNESS: [[f64; 3]; 3] = [
    [7.0 / 3.0, -8.0 / 3.0, 1.0 / 3.0],
    [-8.0 / 3.0, 16.0 / 3.0, -8.0 / 3.0],
    [1.0 / 3.0, -8.0 / 3.0, 7.0 / 3.0],
];

/// `∫ N_i ds` over the edge's length.
pub const EDGE_MEAN: [f64; 3] = [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0];

/// Shape functions of an edge at t in [0, 1].
pub fn edge_shape(t: f64) -> [f64; 3] {
    [(1.0 - t) * (1.0 - 2.0 * t), 4.0 * t * (1.0 - t), t * (2.0 * t - 1.0)]
}

/// Area (m²) of the triangle with these corners, and `∫ ∇N_i · ∇N_j dA`.
///
/// The integrand is quadratic, so the midpoint rule with three points is exact.
pub fn stiffness(corners: [[f64; 2]; 3]) -> (f64, [[f64; 6]; 6]) {
    let [p, q, r] = corners;
    let double = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    // Gradients of the barycentric coordinates.
    let slopes = [[q, r], [r, p], [p, q]].map(|[a, b]| [(a[1] - b[1]) / double, (b[0] - a[0]) / double]);
    let mut matrix = [[0.0; 6]; 6];
    for midpoint in [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]] {
        let gradients: [[f64; 2]; 6] = std::array::from_fn(|i| {
            [0, 1].map(|axis| {
                if i < 3 {
                    (4.0 * midpoint[i] - 1.0) * slopes[i][axis]
                } else {
                    let (a, b) = (i - 3, (i - 2) % 3);
                    4.0 * (midpoint[a] * slopes[b][axis] + midpoint[b] * slopes[a][axis])
                }
            })
        });
        for (row, a) in matrix.iter_mut().zip(&gradients) {
            for (entry, b) in row.iter_mut().zip(&gradients) {
                *entry += double / 6.0 * (a[0] * b[0] + a[1] * b[1]);
            }
        }
    }
    (0.5 * double, matrix)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f64; 2]; 3] = [[0.3, -0.2], [2.1, 0.4], [0.9, 1.7]];

    fn nodes() -> [[f64; 2]; 6] {
        std::array::from_fn(|i| match i {
            0..3 => CORNERS[i],
            _ => [0, 1].map(|axis| 0.5 * (CORNERS[i - 3][axis] + CORNERS[(i - 2) % 3][axis])),
        })
    }

    /// Against the exact integral of |∇p|² by Gauss' rule of a far higher degree on the collapsed square.
    #[test]
    fn energy_and_square_of_a_quadratic() {
        let p = |x: f64, y: f64| 1.3 - x + 2.0 * y + 0.7 * x * x - 1.1 * x * y + 0.4 * y * y;
        let gradient = |x: f64, y: f64| [-1.0 + 1.4 * x - 1.1 * y, 2.0 - 1.1 * x + 0.8 * y];
        let (area, stiffness) = stiffness(CORNERS);
        let rule = crate::quadrature::gauss_legendre(6);
        let (mut square, mut energy) = (0.0, 0.0);
        for a in rule.iter() {
            for b in rule.iter() {
                let (u, v) = (0.5 * (1.0 + a.position), 0.5 * (1.0 + b.position));
                let [l, m] = [u, (1.0 - u) * v];
                let [x, y] =
                    [0, 1].map(|k| l * CORNERS[1][k] + m * CORNERS[2][k] + (1.0 - l - m) * CORNERS[0][k]);
                let weight = 0.25 * a.weight * b.weight * (1.0 - u) * 2.0 * area;
                square += weight * p(x, y).powi(2);
                let [gx, gy] = gradient(x, y);
                energy += weight * (gx * gx + gy * gy);
            }
        }
        let values = nodes().map(|[x, y]| p(x, y));
        let form = |matrix: &[[f64; 6]; 6]| -> f64 {
            (0..36).map(|k| values[k / 6] * matrix[k / 6][k % 6] * values[k % 6]).sum()
        };
        println!(
            "T6: square {:.1e}, energy {:.1e}",
            area * form(&MASS) / square - 1.0,
            form(&stiffness) / energy - 1.0
        );
        assert!((area * form(&MASS) / square - 1.0).abs() < 1e-13);
        assert!((form(&stiffness) / energy - 1.0).abs() < 1e-13);
    }

    #[test]
    fn edge_matrices_integrate_their_shapes() {
        let rule = crate::quadrature::gauss_legendre(4);
        let slope = |t: f64| [4.0 * t - 3.0, 4.0 - 8.0 * t, 4.0 * t - 1.0];
        for i in 0..3 {
            let mean: f64 =
                rule.iter().map(|q| 0.5 * q.weight * edge_shape(0.5 * (1.0 + q.position))[i]).sum();
            assert!((mean - EDGE_MEAN[i]).abs() < 1e-14);
            for j in 0..3 {
                let integral = |f: &dyn Fn(f64) -> [f64; 3]| -> f64 {
                    rule.iter()
                        .map(|q| {
                            let value = f(0.5 * (1.0 + q.position));
                            0.5 * q.weight * value[i] * value[j]
                        })
                        .sum()
                };
                assert!((integral(&edge_shape) - EDGE_MASS[i][j]).abs() < 1e-14);
                assert!((integral(&slope) - EDGE_STIFFNESS[i][j]).abs() < 1e-13);
            }
        }
    }
}
