/// `V = Q R` of columns given one after the other; a column that depends on earlier ones is left out.
///
/// Modified Gram–Schmidt is applied twice, which keeps Q orthogonal to rounding. Earlier columns take precedence.
///
/// **Source**: the filter is the one called QR2 by Haelterman, Bogaers, Scheufele, Uekermann and Mehl (2016).
#[derive(Clone, Debug, Default)]
pub struct FilteredQr {
    q: Vec<Vec<f64>>,
    /// Columns of the upper triangle.
    r: Vec<Vec<f64>>,
}

impl FilteredQr {
    /// Takes `column` if its part orthogonal to the earlier ones exceeds `limit` times its norm; returns whether it
    /// was taken.
    pub fn insert(&mut self, column: &[f64], limit: f64) -> bool {
        let mut rest = column.to_vec();
        let mut coefficients = vec![0.0; self.q.len()];
        for _ in 0..2 {
            for (q, coefficient) in self.q.iter().zip(&mut coefficients) {
                let along = dot(q, &rest);
                *coefficient += along;
                rest.iter_mut().zip(q).for_each(|(x, q)| *x -= along * q);
            }
        }
        let (new, whole) = (dot(&rest, &rest).sqrt(), dot(column, column).sqrt());
        // A column of zeros, or one that is not finite, is left out too.
        if !(new > limit * whole && whole.is_finite()) {
            return false;
        }
        coefficients.push(new);
        self.r.push(coefficients);
        self.q.push(rest.iter().map(|x| x / new).collect());
        true
    }

    /// Number of columns taken.
    pub fn len(&self) -> usize {
        self.q.len()
    }

    /// `argmin ‖V c − b‖₂` with the first `columns` columns taken: one coefficient for each.
    pub fn solve(&self, right_side: &[f64], columns: usize) -> Vec<f64> {
        let mut c: Vec<f64> = self.q.iter().take(columns).map(|q| dot(q, right_side)).collect();
        for i in (0..c.len()).rev() {
            c[i] /= self.r[i][i];
            let known = c[i];
            c[..i].iter_mut().zip(&self.r[i]).for_each(|(x, r)| *x -= r * known);
        }
        c
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_squares_leave_a_residual_normal_to_all_columns() {
        let columns = [[1.0, 2.0, 3.0, 4.0], [1.0, -1.0, 1.0, -1.0], [0.0, 1.0, 0.0, 2.0]];
        let right_side = [1.0, 0.0, -2.0, 5.0];
        let mut qr = FilteredQr::default();
        assert!(columns.iter().all(|column| qr.insert(column, 1e-10)));
        let c = qr.solve(&right_side, 3);
        let rest: Vec<f64> = (0..4)
            .map(|i| right_side[i] - columns.iter().zip(&c).map(|(v, c)| v[i] * c).sum::<f64>())
            .collect();
        for column in &columns {
            assert!(dot(column, &rest).abs() < 1e-13, "{}", dot(column, &rest));
        }
    }

    #[test]
    fn dependent_zero_and_infinite_columns_are_left_out() {
        let mut qr = FilteredQr::default();
        assert!(qr.insert(&[1.0, 1.0, 0.0], 1e-2));
        assert!(!qr.insert(&[2.0, 2.0, 1e-3], 1e-2));
        assert!(!qr.insert(&[0.0, 0.0, 0.0], 1e-2));
        assert!(!qr.insert(&[f64::NAN, 0.0, 0.0], 1e-2));
        assert!(!qr.insert(&[f64::INFINITY, 0.0, 0.0], 1e-2));
        assert!(qr.insert(&[1.0, 0.0, 0.0], 1e-2));
        assert_eq!(qr.len(), 2);
        let c = qr.solve(&[3.0, 2.0, 7.0], 2);
        let first = qr.solve(&[3.0, 2.0, 7.0], 1);
        assert!(first.len() == 1 && (first[0] - 2.5).abs() < 1e-14, "the first alone: {first:?}");
        assert!((c[0] - 2.0).abs() < 1e-14 && (c[1] - 1.0).abs() < 1e-14, "{c:?}");
    }

    #[test]
    fn columns_that_nearly_depend_leave_q_orthogonal() {
        let mut qr = FilteredQr::default();
        for k in 0..6 {
            let column: Vec<f64> = (0..40).map(|i| (f64::from(i) / 40.0).powi(k)).collect();
            qr.insert(&column, 1e-6);
        }
        for (i, a) in qr.q.iter().enumerate() {
            for (j, b) in qr.q.iter().enumerate() {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((dot(a, b) - expected).abs() < 1e-14, "{i} {j}");
            }
        }
    }
}
