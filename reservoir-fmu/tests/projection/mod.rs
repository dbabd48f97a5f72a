//! Fields on the wet face as finite element water gives them: the panels' mean-square projection.
#![allow(dead_code)] // every test file uses its part

use interface::WetFace;
use nalgebra::{DMatrix, DVector};
use reservoir::Complex64;

/// M_Γ, from the panels.
pub fn panel_mass(face: &WetFace) -> DMatrix<f64> {
    let mut mass = DMatrix::zeros(face.len(), face.len());
    for panel in face.panels() {
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            mass[(panel.start + i, panel.start + j)] += panel.length / if i == j { 3.0 } else { 6.0 };
        }
    }
    mass
}

/// Mean-square projection onto the panels of a function of the elevation on a vertical face; Simpson's rule on 8 parts
/// of a panel.
pub fn projected(face: &WetFace, f: impl Fn(f64) -> Complex64) -> DVector<Complex64> {
    let mut load = DVector::<Complex64>::zeros(face.len());
    for panel in face.panels() {
        let y = face.points()[panel.start][1];
        for i in 0..=8 {
            let weight =
                if i == 0 || i == 8 { 1.0 } else { f64::from(2 + 2 * (i % 2)) } * panel.length / 24.0;
            let along = f64::from(i) / 8.0;
            let value = f(y + along * panel.length) * weight;
            load[panel.start] += value * (1.0 - along);
            load[panel.start + 1] += value * along;
        }
    }
    let factors = panel_mass(face).cholesky().unwrap();
    let [re, im] = [load.map(|z| z.re), load.map(|z| z.im)].map(|part| factors.solve(&part));
    DVector::from_fn(face.len(), |i, _| Complex64::new(re[i], im[i]))
}

/// Distance over the exact vector's norm.
pub fn relative(found: &DVector<Complex64>, exact: &DVector<Complex64>) -> f64 {
    (found - exact).norm() / exact.norm()
}
