//! The intact dam with its reservoir in the frequency domain: a solution on a path of its own.
//!
//! With s = σ + iω and the dam's modes Φ (mass-normalised, all of them),
//! `u = Φ h(s) Φᵀ (B p − M r a_g)`, `h_k = 1/(ω_k² + s(α + βω_k²) + s²)`,
//! `p = Z(s) (s Nᵀu + n·e a_g/s) + z(s) a_g/s`, solved for p on the wet face, for ground that accelerates by a_g along e;
//! z is the pressure per velocity of the bed alone. σ > 0 is the exponential window that makes the inverse transform free of
//! wrap-around and of resonance.

use cofferdam_dam::Dam;
use cofferdam_motion::{Component, GroundMotion};
use cofferdam_unit::WetFace;
use faer::Mat;
use nalgebra::DMatrix;
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
    /// n at the interface points.
    pub normals: Vec<[f64; 2]>,
    /// Inertia loads of unit ground accelerations along x and along y: M r, kg.
    pub ground_inertia: [Vec<f64>; 2],
    /// The crest's degrees of freedom along x and along y.
    pub crest: [usize; 2],
}

/// A dam by its modes.
pub struct ModalDam {
    squared_frequencies: Vec<f64>,
    rayleigh: [f64; 2],
    /// Φᵀ B, modes × points.
    force: DMatrix<f64>,
    /// Φᵀ N, modes × points.
    normal: DMatrix<f64>,
    normals: Vec<[f64; 2]>,
    /// Φᵀ M r, modes × directions of the ground.
    ground: DMatrix<f64>,
    /// Of the crest along x and along y.
    crest: [Vec<f64>; 2],
}

/// Crest displacement per ground acceleration of a dam with its water, at the frequencies of an inverse transform.
pub struct TransferFunction {
    dt: f64,
    steps: usize,
    /// σ + iω, from ω = 0 up to half the sampling frequency.
    frequencies: Vec<Complex64>,
    /// As by [`ModalDam::response`].
    responses: Vec<[[Complex64; 2]; 2]>,
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
        let inertia = matrices
            .ground_influence
            .each_ref()
            .map(|influence| matrices.mass.iter().zip(influence).map(|(m, r)| m * r).collect());
        Self {
            stiffness,
            mass: Mat::from_fn(count, count, |i, j| if i == j { matrices.mass[i] } else { 0.0 }),
            rayleigh: [matrices.damping.mass, matrices.damping.stiffness],
            pressure_force,
            normal,
            normals,
            ground_inertia: inertia,
            crest: matrices.crest,
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
        let ground = Mat::from_fn(n, 2, |i, direction| self.ground_inertia[direction][i]);
        ModalDam {
            squared_frequencies: (0..n).map(|k| eigen.S()[k]).collect(),
            rayleigh: self.rayleigh,
            force: project(&self.pressure_force),
            normal: project(&self.normal),
            normals: self.normals.clone(),
            ground: project(&ground),
            crest: self.crest.map(|dof| (0..n).map(|k| modes[(dof, k)]).collect()),
        }
    }
}

impl ModalDam {
    /// The lowest `count` natural frequencies, rad/s.
    pub fn frequencies(&self, count: usize) -> Vec<f64> {
        self.squared_frequencies[..count].iter().map(|w| w.sqrt()).collect()
    }

    /// Crest displacement along x and y (first index) per ground acceleration along x and y (second index) at `s`.
    ///
    /// `water` is the pressure at the points per velocity: points × (points + 2), as by
    /// [`cofferdam_reservoir::frequency_response`].
    pub fn response(&self, s: Complex64, water: &DMatrix<Complex64>) -> [[Complex64; 2]; 2] {
        let [alpha, beta] = self.rayleigh;
        let modal: Vec<Complex64> =
            self.squared_frequencies.iter().map(|w2| 1.0 / (w2 + s * (alpha + beta * w2) + s * s)).collect();
        let points = self.normals.len();
        // Normal displacement of the points by pressure at the points, and by the ground.
        let mut flexibility = DMatrix::<Complex64>::zeros(points, points);
        let mut by_ground = DMatrix::<Complex64>::zeros(points, 2);
        for (k, h) in modal.iter().enumerate() {
            for i in 0..points {
                let n = self.normal[(k, i)] * h;
                for direction in 0..2 {
                    by_ground[(i, direction)] -= n * self.ground[(k, direction)];
                }
                for j in 0..points {
                    flexibility[(i, j)] += n * self.force[(k, j)];
                }
            }
        }
        let (of_face, of_bed) = (water.columns(0, points), water.columns(points, 2));
        let normals = DMatrix::from_fn(points, 2, |i, direction| Complex64::from(self.normals[i][direction]));
        let system = DMatrix::<Complex64>::identity(points, points) - of_face * &flexibility * s;
        let right = of_face * (by_ground * s + normals / s) + of_bed / s;
        let pressure = system.lu().solve(&right).expect("the coupled system is regular");
        let mut response = [[Complex64::default(); 2]; 2];
        for (k, h) in modal.iter().enumerate() {
            for direction in 0..2 {
                let force: Complex64 =
                    (0..points).map(|j| self.force[(k, j)] * pressure[(j, direction)]).sum();
                let coordinate = h * (force - self.ground[(k, direction)]);
                for (row, crest) in response.iter_mut().zip(&self.crest) {
                    row[direction] += crest[k] * coordinate;
                }
            }
        }
        response
    }

    /// The response at what the histories at 0, dt, 2dt, …, `steps` dt need.
    ///
    /// `water` gives the reservoir's pressure per velocity at a list of s.
    pub fn transfer_function(
        &self,
        dt: f64,
        steps: usize,
        water: impl FnOnce(&[Complex64]) -> Vec<DMatrix<Complex64>>,
    ) -> TransferFunction {
        // Half as long again as needed; the window reduces what wraps around by 1e-8.
        let samples = (3 * steps / 2).next_power_of_two();
        let window = samples as f64 * dt;
        let sigma = 1e8_f64.ln() / window;
        let step = 2.0 * std::f64::consts::PI / window;
        let frequencies: Vec<Complex64> =
            (0..=samples / 2).map(|k| Complex64::new(sigma, k as f64 * step)).collect();
        let water = water(&frequencies);
        let responses = frequencies.iter().zip(&water).map(|(s, z)| self.response(*s, z)).collect();
        TransferFunction { dt, steps, frequencies, responses }
    }
}

impl TransferFunction {
    /// Crest displacement (m) along x and y at 0, dt, 2dt, …, `steps` dt under `motion`.
    pub fn crest_history(&self, motion: &GroundMotion) -> [Vec<f64>; 2] {
        let samples = 2 * (self.frequencies.len() - 1);
        let window = samples as f64 * self.dt;
        let mut spectra = [0, 1].map(|_| vec![Complex64::default(); samples]);
        for (k, (s, response)) in self.frequencies.iter().zip(&self.responses).enumerate().take(samples / 2) {
            let ground: Vec<Complex64> =
                motion.components().map(|component| ground_transform(component, *s)).collect();
            for (spectrum, row) in spectra.iter_mut().zip(response) {
                let u: Complex64 = row.iter().zip(&ground).map(|(u, a)| u * a).sum();
                spectrum[k] = u;
                if k > 0 {
                    spectrum[samples - k] = u.conj();
                }
            }
        }
        let sigma = self.frequencies[0].re;
        spectra.map(|mut spectrum| {
            FftPlanner::new().plan_fft_inverse(samples).process(&mut spectrum);
            (0..=self.steps).map(|i| (sigma * i as f64 * self.dt).exp() / window * spectrum[i].re).collect()
        })
    }
}

/// Laplace transform of a motion that is linear between its samples and falls to zero after the last.
fn ground_transform(motion: &Component, s: Complex64) -> Complex64 {
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
