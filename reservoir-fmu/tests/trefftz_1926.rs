//! A battered face in incompressible water against Trefftz's method (1926).

use crate::rectangular;

use cofferdam_reservoir::{Complex64, ReservoirError, ReservoirParameters, frequency_response};
use nalgebra::{DMatrix, DVector};
use rectangular::{DENSITY, DEPTH, SOUND_SPEED, THREADS, of_uniform_motion, parameters, projected};
use std::f64::consts::PI;

const BATTER: f64 = 0.1;

/// Pressure divided by ρ a_n on the face by `p = Σ A_m cos(λ_m y) e^{λ_m x}`, which satisfies bed,
/// surface and far end; ∂p/∂n = ρ on the face against every term (the variational form: its
/// energy, and thus ∫ p ds, converges twice as fast as p), solved by SVD.
fn trefftz(terms: usize, elevations: &[f64]) -> Vec<f64> {
    let slope = (1.0 + BATTER * BATTER).sqrt();
    let [nx, ny] = [1.0 / slope, -BATTER / slope];
    let lambda = |m: usize| (2 * m + 1) as f64 * PI / (2.0 * DEPTH);
    // terms scaled by their value at the top
    let growth = |m: usize, y: f64| (lambda(m) * BATTER * (y - DEPTH)).exp();
    let value = |m: usize, y: f64| growth(m, y) * (lambda(m) * y).cos() / lambda(m);
    let normal = |m: usize, y: f64| growth(m, y) * (nx * (lambda(m) * y).cos() - ny * (lambda(m) * y).sin());
    // midpoints in φ, y = h(1 − cos φ)/2: exponentially accurate for smooth integrands
    let points = 8 * terms;
    let rule = |i: usize| {
        let angle = PI * (i as f64 + 0.5) / points as f64;
        (0.5 * DEPTH * (1.0 - angle.cos()), 0.5 * DEPTH * angle.sin() * PI / points as f64)
    };
    let against = |m: usize, f: &dyn Fn(f64) -> f64| -> f64 {
        (0..points).map(rule).map(|(y, weight)| weight * value(m, y) * f(y)).sum()
    };
    let matrix = DMatrix::from_fn(terms, terms, |i, j| against(i, &|y| normal(j, y)));
    let right = DVector::from_fn(terms, |i, _| against(i, &|_| 1.0));
    let solution = matrix.svd(true, true).solve(&right, 1e-15).unwrap();
    let pressure = |y: f64| (0..terms).map(|m| solution[m] * value(m, y)).sum();
    elevations.iter().map(|&y| pressure(y)).collect()
}

fn battered(panels: usize, elements: usize) -> ReservoirParameters {
    ReservoirParameters {
        wet_face: cofferdam_unit::WetFace::straight([BATTER * DEPTH, DEPTH], panels).unwrap(),
        element_size: DEPTH * (1.0 + BATTER * BATTER).sqrt() / elements as f64,
        ..parameters(1.0, elements, 0.0025, 1.0)
    }
}

fn pressures(parameters: &ReservoirParameters, s: Complex64) -> Result<Vec<Complex64>, ReservoirError> {
    let k = frequency_response(parameters, &[s], THREADS)?.remove(0);
    Ok(of_uniform_motion(&k, s))
}

/// 0.1 % of the force; the Trefftz series itself has converged to a tenth of that.
#[test]
fn incompressible_limit() -> Result<(), ReservoirError> {
    let parameters = battered(32, 32);
    let force = |p: &[f64]| parameters.wet_face.nodal_forces(p).iter().map(|f| f[0]).sum::<f64>();
    let [coarse, fine] = [20, 40].map(|terms| {
        let series =
            |elevations: &[f64]| trefftz(terms, elevations).into_iter().map(Complex64::from).collect();
        projected(&parameters.wet_face, series).iter().map(|p| p.re).collect::<Vec<f64>>()
    });
    let p: Vec<f64> = pressures(&parameters, Complex64::new(1e-3, 0.0))?.iter().map(|p| p.re).collect();
    let converged = force(&coarse) / force(&fine) - 1.0;
    let error = force(&p) / force(&fine) - 1.0;
    let base = p[0] / fine[0] - 1.0;
    let incompressible =
        ReservoirParameters { fidelity: cofferdam_reservoir::Fidelity::Incompressible, ..parameters.clone() };
    let mass = cofferdam_reservoir::added_mass(&incompressible)?;
    let p: Vec<f64> = mass.row_iter().map(|row| row.sum() / DENSITY).collect();
    let exactly = force(&p) / force(&fine) - 1.0;
    println!("batter 1:10, incompressible model: force off by {exactly:.2e}");
    assert!(exactly.abs() < 1e-3);
    println!(
        "batter 1:10, static: force off by {error:.2e}, base pressure by {base:.2e}; Trefftz {converged:.1e}"
    );
    assert!(converged.abs() < 1e-4 && error.abs() < 1e-3 && base.abs() < 2e-3);
    Ok(())
}

/// Halving the elements divides the change of the force by three or more. Eight panels keep the
/// interface points away from the surface, where `p ~ r ln r` delays the asymptotic rate.
#[test]
fn force_converges() -> Result<(), ReservoirError> {
    let cut_off = PI * SOUND_SPEED / (2.0 * DEPTH);
    for ratio in [0.5, 1.5] {
        let s = Complex64::new(0.02, ratio) * cut_off;
        let force = |elements| -> Result<Complex64, ReservoirError> {
            let parameters = battered(8, elements);
            let p = pressures(&parameters, s)?;
            let part =
                |values: Vec<f64>| parameters.wet_face.nodal_forces(&values).iter().map(|f| f[0]).sum();
            let (re, im) = (p.iter().map(|p| p.re).collect(), p.iter().map(|p| p.im).collect());
            Ok(Complex64::new(part(re), part(im)))
        };
        let forces = [8, 16, 32, 64, 128].map(force).into_iter().collect::<Result<Vec<_>, _>>()?;
        let changes: Vec<f64> = forces.windows(2).map(|f| (f[0] - f[1]).norm() / f[1].norm()).collect();
        println!("batter 1:10, ω = {ratio} ω₁: force changes by {changes:.7?} from 8 to 128 elements");
        assert!(changes.windows(2).all(|c| c[0] > 3.0 * c[1]) && changes[1] < 1e-3);
    }
    Ok(())
}
