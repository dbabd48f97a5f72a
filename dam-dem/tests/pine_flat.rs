//! Natural frequencies of Pine Flat Dam, empty and on a rigid base, in both kinds of mesh.
//!
//! The section has its real crest. The frequencies to compare with are an independent solution with 40 eight-node
//! elements.

use cofferdam_dam::contact::{Coulomb, Integration};
use cofferdam_dam::modal::natural_frequencies;
use cofferdam_dam::{DamError, Geometry, Kinematics, Material, Mesh, Plane, Section, Structure};

/// rad/s
const PLANE_STRESS: [f64; 4] = [19.77, 40.69, 54.91, 70.68];
const PLANE_STRAIN: [f64; 4] = [20.16, 41.29, 56.06, 71.60];

fn section() -> Section {
    Section::new(
        vec![[0.0, 0.0], [5.11, 102.17], [5.11, 121.92]],
        vec![
            [95.71, 0.0],
            [24.38, 91.44],
            [17.70, 102.17],
            [15.64, 106.68],
            [14.86, 112.41],
            [14.86, 121.92],
        ],
    )
}

/// The size of a cell, m, and the frequencies, rad/s.
fn frequencies(mesh: Mesh, plane: Plane) -> Result<(f64, Vec<f64>), DamError> {
    let material = Material { young_modulus: 22.75e9, density: 2528.0, plane, ..Default::default() };
    let base = mesh.base.clone();
    let size = (section().area() / mesh.cells.len() as f64).sqrt();
    let none: [(Coulomb, Integration); 0] = [];
    let structure = Structure::new(mesh, &material, Kinematics::Small, none, &base);
    Ok((size, natural_frequencies(&structure, 4)?))
}

/// `ω∞` of the least-squares fit `ω = ω∞ + c h²`.
fn extrapolated(found: &[(f64, Vec<f64>)], mode: usize) -> f64 {
    let points: Vec<[f64; 2]> = found.iter().map(|(h, omega)| [h * h, omega[mode]]).collect();
    let [x, y] = [0, 1].map(|d| points.iter().map(|point| point[d]).sum::<f64>() / points.len() as f64);
    let covariance: f64 = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
    y - x * covariance / points.iter().map(|point| (point[0] - x).powi(2)).sum::<f64>()
}

/// Tolerance: 1 % after extrapolation from three meshes; the finest of them is within 2 %.
fn compare(name: &str, mesh: impl Fn(f64) -> Mesh) -> Result<(), DamError> {
    for (plane, exact) in [(Plane::Stress, PLANE_STRESS), (Plane::Strain, PLANE_STRAIN)] {
        let found = [6.0, 4.2, 3.0].map(|size| frequencies(mesh(size), plane));
        let found = found.into_iter().collect::<Result<Vec<_>, _>>()?;
        for (mode, exact) in exact.into_iter().enumerate() {
            let limit = extrapolated(&found, mode);
            let each: Vec<String> = found.iter().map(|(h, w)| format!("{h:.2} m {:.3}", w[mode])).collect();
            let errors = [found[2].1[mode], limit].map(|omega| omega / exact - 1.0);
            println!(
                "{name}, {plane:?}, mode {}: {}; extrapolated {limit:.3}, reference {exact} rad/s, {:+.2e}",
                mode + 1,
                each.join(", "),
                errors[1]
            );
            assert!(errors[0].abs() < 2e-2 && errors[1].abs() < 1e-2);
        }
    }
    Ok(())
}

#[test]
fn rows_of_cells_have_its_frequencies() -> Result<(), DamError> {
    compare("rows", |size| Mesh::new(&section(), &[], &[], size))
}

#[test]
fn an_unstructured_mesh_has_its_frequencies() -> Result<(), DamError> {
    let section = section();
    compare("unstructured", |element_size| {
        Mesh::of_section(&Geometry {
            upstream: &section.upstream,
            downstream: &section.downstream,
            galleries: &[],
            cracks: &[],
            zones: &[],
            upstream_levels: &[],
            downstream_levels: &[],
            element_size,
            crack_sizes: &[],
        })
        .expect("the section is meshed")
    })
}
