//! The intact dam with its reservoir in the frequency domain: a solution on a path of its own.
//!
//! With s = σ + iω and the dam's modes Φ (mass-normalised, all of them),
//! `u = Φ h(s) Φᵀ (B p − M r a_g)`, `h_k = 1/(ω_k² + s(α + βω_k²) + s²)`,
//! `p = Z(s) (s Nᵀu + n_x a_g/s)`, solved for p on the wet face. σ > 0 is the exponential
//! window that makes the inverse transform free of wrap-around and of resonance.

use cofferdam_dam::Dam;
use cofferdam_motion::GroundMotion;
use cofferdam_unit::WetFace;
use faer::Mat;
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;
use rustfft::FftPlanner;

/// A linear dam.
pub struct LinearDam {
    /// Stiffness, N/m.
    pub stiffness: Mat<f64>,
    /// Mass, kg.
    pub mass: Mat<f64>,
    /// Rayleigh coefficients: damping = α mass + β stiffness.
    pub rayleigh: [f64; 2],
    /// Nodal forces of a pressure at the interface points: degrees of freedom × points, m.
    pub pressure_force: Mat<f64>,
    /// Motion along n of the interface points: degrees of freedom × points.
    pub normal: Mat<f64>,
    /// n_x at the interface points.
    pub normal_x: Vec<f64>,
    /// Inertia load of a unit ground acceleration: M r, kg.
    pub ground_inertia: Vec<f64>,
    /// The crest's horizontal degree of freedom.
    pub crest: usize,
}

/// A dam by its modes.
pub struct ModalDam {
    squared_frequencies: Vec<f64>,
    rayleigh: [f64; 2],
    /// Φᵀ B, modes × points.
    force: DMatrix<f64>,
    /// Φᵀ N, modes × points.
    normal: DMatrix<f64>,
    normal_x: Vec<f64>,
    /// Φᵀ M r.
    ground: DVector<f64>,
    crest: Vec<f64>,
}

impl LinearDam {
    /// The dam's own matrices, and the Rayleigh coefficients it uses.
    pub fn of(dam: &Dam) -> Self {
        let matrices = dam.system_matrices();
        let normals = dam.wet_face().map_or(Vec::new(), WetFace::normals);
        let (count, points) = (matrices.mass.len(), normals.len());
        let mut stiffness = Mat::zeros(count, count);
        let mut pressure_force = Mat::zeros(count, points);
        let mut normal = Mat::zeros(count, points);
        matrices.stiffness.iter().for_each(|&(i, j, v)| stiffness[(i, j)] += v);
        matrices.pressure_forces.iter().for_each(|&(i, j, v)| pressure_force[(i, j)] += v);
        matrices.interface_motion.iter().for_each(|&(point, dof, v)| normal[(dof, point)] += v);
        let inertia = matrices.mass.iter().zip(&matrices.ground_influence[0]).map(|(m, r)| m * r).collect();
        Self {
            stiffness,
            mass: Mat::from_fn(count, count, |i, j| if i == j { matrices.mass[i] } else { 0.0 }),
            rayleigh: [matrices.damping.mass, matrices.damping.stiffness],
            pressure_force,
            normal,
            normal_x: normals.iter().map(|n| n[0]).collect(),
            ground_inertia: inertia,
            crest: matrices.crest[0],
        }
    }

    /// All modes of the dam.
    pub fn modes(&self) -> ModalDam {
        let n = self.mass.nrows();
        let lower = self.mass.llt(faer::Side::Lower).expect("mass is positive definite");
        let lower = lower.L();
        // A = L⁻¹ K L⁻ᵀ, Φ = L⁻ᵀ V.
        let mut a = self.stiffness.clone();
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(lower, a.as_mut(), faer::Par::Seq);
        let mut a = a.transpose().to_owned();
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(lower, a.as_mut(), faer::Par::Seq);
        let a = Mat::from_fn(n, n, |i, j| 0.5 * (a[(i, j)] + a[(j, i)]));
        let eigen = a.self_adjoint_eigen(faer::Side::Lower).expect("eigenvalues converge");
        let mut modes = eigen.U().to_owned();
        faer::linalg::triangular_solve::solve_upper_triangular_in_place(
            lower.transpose(),
            modes.as_mut(),
            faer::Par::Seq,
        );
        let project = |columns: &Mat<f64>| {
            let product = modes.transpose() * columns;
            DMatrix::from_fn(n, columns.ncols(), |i, j| product[(i, j)])
        };
        let ground = Mat::from_fn(n, 1, |i, _| self.ground_inertia[i]);
        ModalDam {
            squared_frequencies: (0..n).map(|k| eigen.S()[k]).collect(),
            rayleigh: self.rayleigh,
            force: project(&self.pressure_force),
            normal: project(&self.normal),
            normal_x: self.normal_x.clone(),
            ground: project(&ground).column(0).into_owned(),
            crest: (0..n).map(|k| modes[(self.crest, k)]).collect(),
        }
    }
}

impl ModalDam {
    /// The lowest `count` natural frequencies, rad/s.
    pub fn frequencies(&self, count: usize) -> Vec<f64> {
        self.squared_frequencies[..count].iter().map(|w| w.sqrt()).collect()
    }

    /// Crest displacement per ground acceleration at `s`, given the water's pressure per velocity.
    pub fn response(&self, s: Complex64, water: &DMatrix<Complex64>) -> Complex64 {
        let [alpha, beta] = self.rayleigh;
        let modal: Vec<Complex64> =
            self.squared_frequencies.iter().map(|w2| 1.0 / (w2 + s * (alpha + beta * w2) + s * s)).collect();
        let points = self.normal_x.len();
        // Normal displacement of the points by pressure at the points, and by the ground.
        let mut flexibility = DMatrix::<Complex64>::zeros(points, points);
        let mut by_ground = DVector::<Complex64>::zeros(points);
        for (k, h) in modal.iter().enumerate() {
            for i in 0..points {
                let n = self.normal[(k, i)] * h;
                by_ground[i] -= n * self.ground[k];
                for j in 0..points {
                    flexibility[(i, j)] += n * self.force[(k, j)];
                }
            }
        }
        let normal_x = DVector::from_iterator(points, self.normal_x.iter().map(|n| Complex64::from(*n)));
        let system = DMatrix::<Complex64>::identity(points, points) - water * &flexibility * s;
        let right = water * (by_ground * s + normal_x / s);
        let pressure = system.lu().solve(&right).expect("the coupled system is regular");
        let coordinate = |(k, h): (usize, &Complex64)| {
            let force: Complex64 = (0..points).map(|j| self.force[(k, j)] * pressure[j]).sum();
            self.crest[k] * h * (force - self.ground[k])
        };
        modal.iter().enumerate().map(coordinate).sum()
    }

    /// Crest displacement (m) at 0, dt, 2dt, …, `steps` dt under `motion`.
    ///
    /// `water` gives the reservoir's pressure per velocity at a list of s.
    pub fn crest_history(
        &self,
        motion: &GroundMotion,
        dt: f64,
        steps: usize,
        water: impl FnOnce(&[Complex64]) -> Vec<DMatrix<Complex64>>,
    ) -> Vec<f64> {
        // Half as long again as needed; the window reduces what wraps around by 1e-8.
        let samples = (3 * steps / 2).next_power_of_two();
        let window = samples as f64 * dt;
        let sigma = 1e8_f64.ln() / window;
        let step = 2.0 * std::f64::consts::PI / window;
        let s: Vec<Complex64> = (0..=samples / 2).map(|k| Complex64::new(sigma, k as f64 * step)).collect();
        let water = water(&s);
        let transform: Vec<Complex64> =
            s.iter().zip(&water).map(|(s, z)| self.response(*s, z) * ground_transform(motion, *s)).collect();
        let mut spectrum = vec![Complex64::default(); samples];
        for (k, u) in transform.iter().enumerate().take(samples / 2) {
            spectrum[k] = *u;
            if k > 0 {
                spectrum[samples - k] = u.conj();
            }
        }
        FftPlanner::new().plan_fft_inverse(samples).process(&mut spectrum);
        (0..=steps)
            .map(|i| (sigma * i as f64 * dt).exp() * step / (2.0 * std::f64::consts::PI) * spectrum[i].re)
            .collect()
    }
}

/// Laplace transform of a motion that is linear between its samples and falls to zero after the last.
fn ground_transform(motion: &GroundMotion, s: Complex64) -> Complex64 {
    let dt = motion.interval();
    let z = s * dt;
    let hat = 2.0 * (z.cosh() - 1.0) / (z * z) * dt;
    let first = (1.0 - (1.0 - (-z).exp()) / z) / s;
    let shift = (-z).exp();
    let mut factor = Complex64::from(1.0);
    let mut sum = motion.acceleration()[0] * first;
    for a in &motion.acceleration()[1..] {
        factor *= shift;
        sum += hat * factor * *a;
    }
    sum
}
