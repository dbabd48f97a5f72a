//! Westergaard's water in the dam's mass matrix: the first natural frequency, with the profile's integrals and sampled.

use cofferdam_dam::{Dam, DamParameters, SystemMatrices};
use cofferdam_reservoir::{Fidelity, ReservoirParameters};
use cofferdam_unit::WetFace;
use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use nalgebra::DMatrix;
use whole_chain::koyna::{DEPTH, dam};

type Failure = Box<dyn std::error::Error>;

const WATER: f64 = 1000.0;

fn profile(y: f64) -> f64 {
    0.875 * WATER * (DEPTH * (DEPTH - y)).max(0.0).sqrt()
}

fn integrated(face: &WetFace) -> Result<DMatrix<f64>, Failure> {
    let water = ReservoirParameters::before(face.clone());
    Ok(cofferdam_reservoir::added_mass(&ReservoirParameters { fidelity: Fidelity::Westergaard, ..water })?)
}

/// The same integrals by the midpoint rule, 4000 points a panel: off by 4000^{−3/2}, 4e-6, of the uppermost panel's.
fn by_midpoints(face: &WetFace) -> Result<DMatrix<f64>, Failure> {
    let [mut moved, mut mass] = [0, 1].map(|_| DMatrix::<f64>::zeros(face.len(), face.len()));
    for panel in face.panels() {
        for k in 0..4000 {
            let along = (f64::from(k) + 0.5) / 4000.0;
            let y = face.points()[panel.start][1] + along * panel.length;
            for (i, one) in [1.0 - along, along].into_iter().enumerate() {
                for (j, other) in [1.0 - along, along].into_iter().enumerate() {
                    let part = one * other * panel.length / 4000.0;
                    mass[(panel.start + i, panel.start + j)] += part;
                    moved[(panel.start + i, panel.start + j)] += part * profile(y);
                }
            }
        }
    }
    Ok(mass.try_inverse().ok_or("a mass matrix has an inverse")? * moved)
}

fn sampled(face: &WetFace) -> Result<DMatrix<f64>, Failure> {
    Ok(DMatrix::from_fn(
        face.len(),
        face.len(),
        |i, j| if i == j { profile(face.points()[i][1]) } else { 0.0 },
    ))
}

/// ω₁ of `K φ = ω² (M + X) φ` by inverse iteration, rad/s.
fn first_frequency(matrices: &SystemMatrices) -> Result<f64, Failure> {
    let n = matrices.mass.len();
    let entries: Vec<_> = matrices.stiffness.iter().map(|&(i, j, k)| Triplet::new(i, j, k)).collect();
    let stiffness = SparseColMat::try_new_from_triplets(n, n, &entries)?.sp_cholesky(Side::Lower)?;
    let mut shape = Mat::from_fn(n, 1, |i, _| matrices.ground_influence[0][i]);
    let mut squared = 0.0;
    for _ in 0..40 {
        let mut inertia = Mat::from_fn(n, 1, |i, _| matrices.mass[i] * shape[(i, 0)]);
        matrices.added_mass.iter().for_each(|&(i, j, x)| inertia[(i, 0)] += x * shape[(j, 0)]);
        let next = stiffness.solve(&inertia);
        squared = (shape.transpose() * &inertia)[(0, 0)] / (next.transpose() * &inertia)[(0, 0)];
        shape = &next * faer::Scale(1.0 / next.norm_l2());
    }
    Ok(squared.sqrt())
}

fn with_water(
    parameters: &DamParameters,
    water: fn(&WetFace) -> Result<DMatrix<f64>, Failure>,
) -> Result<f64, Failure> {
    let rows = water(&parameters.wet_face()?.ok_or("a wet face")?)?;
    let added_mass = Some(rows.row_iter().map(|row| row.iter().copied().collect()).collect());
    let dam = Dam::new(DamParameters { added_mass, ..parameters.clone() })?;
    first_frequency(&dam.system_matrices())
}

/// The frequency with the reservoir's matrix is that with a plain quadrature of the same integrals. It converges with the
/// mesh as that of the empty dam does: of order two in its smooth part and, with the strains' singularity r^{λ−1} in the
/// corner of a clamped base, λ > 0.7, of order 2λ in the end.
#[test]
fn the_first_frequency_is_that_of_the_integrated_profile_and_converges() -> Result<(), Failure> {
    let mut found = Vec::new();
    for size in [10.0, 5.0, 2.5] {
        let intact = dam(size, false);
        let [exact, plain, points] = [
            with_water(&intact, integrated)?,
            with_water(&intact, by_midpoints)?,
            with_water(&intact, sampled)?,
        ];
        println!(
            "{size} m: ω₁ = {exact:.4} rad/s, by midpoints {:+.1e}, sampled at the points {:+.3} %",
            plain / exact - 1.0,
            100.0 * (points / exact - 1.0)
        );
        assert!((plain / exact - 1.0).abs() < 1e-6);
        found.push(exact);
    }
    let order = ((found[0] - found[1]) / (found[1] - found[2])).log2();
    println!("order {order:.2}");
    assert!(order > 1.4);
    Ok(())
}
