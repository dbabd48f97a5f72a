use crate::projection::consistent_mass;
use cofferdam_unit::WetFace;
use nalgebra::DMatrix;
use num_complex::Complex64;

/// Coordinates of the wet face in which the work of pressure on velocity is a scalar product.
///
/// With the face's consistent mass `M = L Lᵀ`, `∫ N_i N_j ds` of the hat functions along the panels,
///
/// ```text
/// v̂ = Lᵀ v,  p̂ = −Lᵀ p/(ρc),  ∫ p v ds = −ρc p̂ᵀ v̂,
/// ```
///
/// a plane wave has the impedance 1, and a passive one a positive Hermitian part. Velocities of the ground
/// are multiplied by √h.
pub(crate) struct Coordinates {
    upper: DMatrix<f64>,
    inverse: DMatrix<f64>,
    impedance: f64,
    ground: f64,
}

impl Coordinates {
    /// The coordinates of `face` in water of impedance ρc (Pa s/m); none if its panels are too unequal for a
    /// factorisation.
    pub fn new(face: &WetFace, impedance: f64) -> Option<Self> {
        let lower = consistent_mass(face).cholesky()?.l();
        let inverse = lower.transpose().try_inverse()?;
        Some(Self { upper: lower.transpose(), inverse, impedance, ground: face.depth().sqrt() })
    }

    /// Ĝ of K, the pressure per velocity: points × (points + 2).
    pub fn normalised(&self, k: &DMatrix<Complex64>) -> DMatrix<Complex64> {
        let left = self.upper.map(|x| Complex64::from(-x / self.impedance));
        left * k * self.right(&self.inverse, 1.0 / self.ground).map(Complex64::from)
    }

    /// The left and right factors that turn Ĝ into K.
    pub fn restoring(&self) -> (DMatrix<f64>, DMatrix<f64>) {
        (&self.inverse * -self.impedance, self.right(&self.upper, self.ground))
    }

    /// `L⁻¹`: integrals with the hat functions to v̂ or p̂.
    pub fn of_integrals(&self) -> DMatrix<f64> {
        self.inverse.transpose()
    }

    /// Factor for the ground's columns of K, divided by −ρc.
    pub fn ground_scale(&self) -> f64 {
        1.0 / self.ground
    }

    fn right(&self, face: &DMatrix<f64>, ground: f64) -> DMatrix<f64> {
        let points = face.nrows();
        DMatrix::from_fn(points + 2, points + 2, |i, j| match (i < points, j < points) {
            (true, true) => face[(i, j)],
            (false, false) if i == j => ground,
            _ => 0.0,
        })
    }
}
