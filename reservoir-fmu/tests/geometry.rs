//! Faces and beds that are neither vertical nor level: self-convergence, reciprocity, passivity, field points.

use crate::rectangular;

use cofferdam_reservoir::analytical::{chakrabarti_chopra_1973, chopra_1967};
use cofferdam_reservoir::{
    Complex64, ElementOrder, ReservoirError, ReservoirParameters, field_response, frequency_response,
};
use cofferdam_unit::WetFace;
use nalgebra::{DMatrix, SymmetricEigen};
use rectangular::{DENSITY, DEPTH, SOUND_SPEED, THREADS, consistent_mass, parameters};
use std::f64::consts::PI;

const CUT_OFF: f64 = PI * SOUND_SPEED / (2.0 * DEPTH);

type Shape = (&'static str, Vec<[f64; 2]>, Vec<[f64; 2]>);

fn shapes() -> Vec<Shape> {
    vec![
        ("battered", vec![[0.0, 0.0], [36.0, DEPTH]], vec![]),
        ("kinked", vec![[0.0, 0.0], [30.0, 60.0], [30.0, DEPTH]], vec![]),
        ("overhanging", vec![[0.0, 0.0], [-20.0, 100.0], [-20.0, DEPTH]], vec![]),
        ("sloped bed", vec![[0.0, 0.0], [0.0, DEPTH]], vec![[-50.0, 5.0], [-120.0, 40.0]]),
        ("deep pool", vec![[0.0, 0.0], [10.0, DEPTH]], vec![[-10.0, -30.0], [-90.0, -30.0], [-100.0, 0.0]]),
    ]
}

fn of_shape((_, face, bed): &Shape, elements: f64, panel: f64) -> ReservoirParameters {
    let wet_face = WetFace::new(face.clone()).unwrap().respaced(panel).unwrap();
    let element_size = DEPTH / elements;
    ReservoirParameters { wet_face, bed: bed.clone(), element_size, ..parameters(0.8, 16, 0.0025, 1.0) }
}

/// Total force of a face that moves along x, from the graded mesh of h/16 to one of h/64: 0.1 %.
#[test]
fn force_converges_on_every_shape() -> Result<(), ReservoirError> {
    for shape in shapes() {
        for waves in [false, true] {
            for ratio in [0.4, 1.7] {
                let s = Complex64::new(0.0, ratio * CUT_OFF);
                let force = |elements: f64, order: ElementOrder| -> Result<Complex64, ReservoirError> {
                    let parameters = ReservoirParameters {
                        surface_waves: waves,
                        element_order: order,
                        corner_element_size: Some(DEPTH / elements / 4.0),
                        ..of_shape(&shape, elements, DEPTH / 12.0)
                    };
                    let face = &parameters.wet_face;
                    let k = frequency_response(&parameters, &[s], THREADS)?.remove(0);
                    let n_x: Vec<f64> = face.normals().iter().map(|n| n[0]).collect();
                    let mass = consistent_mass(face);
                    let points = face.len();
                    let weights: Vec<f64> = mass.row_iter().map(|row| row.sum()).collect();
                    Ok((0..points)
                        .flat_map(|i| (0..points).map(move |j| (i, j)))
                        .map(|(i, j)| weights[i] * n_x[i] * k[(i, j)] * n_x[j])
                        .sum())
                };
                let exact = force(48.0, ElementOrder::Linear)?;
                let [linear, constant] = [ElementOrder::Linear, ElementOrder::Constant]
                    .map(|order| force(16.0, order).map(|f| (f / exact - 1.0).norm()));
                let (linear, constant) = (linear?, constant?);
                println!(
                    "{}, waves {waves}, Ω = {ratio}: force of h/16 off by {linear:.1e}, with constant elements {constant:.1e}",
                    shape.0
                );
                assert!(linear < 1e-3 && constant < 2e-2);
            }
        }
    }
    Ok(())
}

/// M K is symmetric to rounding. `−Re v*MKv ≥ 0`, v normalised in M, divided by ρc: with elements half as long as the panels
/// everywhere, except less than 1e-3 at real frequencies below cut-off, where nothing is radiated and 0 is exact.
#[test]
fn reciprocity_and_passivity_on_every_shape() -> Result<(), ReservoirError> {
    for shape in shapes() {
        for waves in [false, true] {
            let parameters =
                ReservoirParameters { surface_waves: waves, ..of_shape(&shape, 24.0, DEPTH / 12.0) };
            let mass = consistent_mass(&parameters.wet_face);
            let inverse = mass.clone().cholesky().unwrap().l().try_inverse().unwrap().map(Complex64::from);
            for damping in [0.0, 0.01, 0.3, 3.0] {
                let s: Vec<Complex64> =
                    (0..60).map(|i| Complex64::new(damping, 0.031 + 0.5 * f64::from(i)) * CUT_OFF).collect();
                let (mut asymmetry, mut least) = (0.0f64, f64::INFINITY);
                for k in frequency_response(&parameters, &s, THREADS)? {
                    let energy = mass.map(Complex64::from) * k.columns(0, k.nrows());
                    asymmetry = asymmetry.max((&energy - energy.transpose()).norm() / energy.norm());
                    let normed = &inverse * energy * inverse.adjoint();
                    let hermitian: DMatrix<Complex64> =
                        (&normed + normed.adjoint()) * Complex64::from(-0.5 / (DENSITY * SOUND_SPEED));
                    least = least.min(SymmetricEigen::new(hermitian).eigenvalues.min());
                }
                println!(
                    "{}, waves {waves}, Re s = {damping} ω₁: asymmetry {asymmetry:.1e}, least eigenvalue {least:+.1e} ρc",
                    shape.0
                );
                assert!(asymmetry < 1e-12 && least > if damping == 0.0 { -1e-3 } else { 0.0 });
            }
        }
    }
    Ok(())
}

/// Rigid level bed: the channel's modes for horizontal and its plane wave for vertical motion, to 0.1 %.
#[test]
fn pressure_inside_the_water() -> Result<(), ReservoirError> {
    let parameters = parameters(1.0, 16, 0.0025, 1.0);
    let s = Complex64::new(0.0, 1.5 * CUT_OFF);
    let points = [[-80.0, 3.0], [-45.0, 90.0], [-10.0, 150.0], [-1e-3, 90.0], [-60.0, 179.999]];
    let field = field_response(&parameters, s, &points, THREADS)?;
    let columns = field.ncols() - 2;
    for (row, &[x, y]) in points.iter().enumerate() {
        let exact: Complex64 = (0..2000)
            .map(|m| {
                let sign = if m % 2 == 0 { 1.0 } else { -1.0 };
                let lambda = f64::from(2 * m + 1) * PI / (2.0 * DEPTH);
                let kappa = (lambda * lambda + (s / SOUND_SPEED).powi(2)).sqrt();
                2.0 * sign / (lambda * DEPTH) / kappa * (lambda * y).cos() * (kappa * x).exp()
            })
            .sum();
        let vertical = chakrabarti_chopra_1973::pressure(s, DEPTH, SOUND_SPEED, 1.0, y);
        let scale = chopra_1967::pressure(s, DEPTH, SOUND_SPEED, 0.0).norm();
        let found = -field.row(row).columns(0, columns).sum() / (s * DENSITY);
        let lifted = field[(row, columns + 1)] / (s * DENSITY);
        let errors = [(found - exact).norm() / scale, (lifted - vertical).norm() / scale];
        println!(
            "({x}, {y}) m: horizontal off by {:.1e}, vertical by {:.1e} of the base",
            errors[0], errors[1]
        );
        assert!(errors.iter().all(|e| *e < 1e-3));
    }
    for outside in [[1.0, 50.0], [-91.0, 50.0], [-5.0, 180.0], [-5.0, f64::NAN]] {
        let error = field_response(&parameters, s, &[[-5.0, 50.0], outside], THREADS).unwrap_err();
        assert!(matches!(error, ReservoirError::FieldPoint { index: 1, .. }), "{error}");
    }
    Ok(())
}
