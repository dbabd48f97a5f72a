//! The boundary element system: velocity of face and ground in, pressure out.
//!
//! Depends on `boundary`, `channel_motion`, `condition`, `cut_off`, `kernel`, `operator`, `outline`, `projection`,
//! `radiation` and `water`.

use crate::boundary::BoundaryMesh;
use crate::channel_motion::plane_wave;
use crate::condition::{BoundaryCondition, FarEndCondition};
use crate::cut_off::check_cut_off;
use crate::kernel::{FreeSpace, FreeSurface, HelmholtzKernel};
use crate::operator::{LayerOperators, Layers};
use crate::outline::Outline;
use crate::projection::InterfaceProjection;
use crate::radiation::Radiation;
use crate::water::Water;
use crate::{ReservoirError, ReservoirParameters};
use cofferdam_unit::WetFace;
use faer::{Mat, linalg::solvers::Solve};
use nalgebra::DMatrix;
use num_complex::Complex64;

/// Boundary integral equation at the nodes, and pressure at the interface points.
///
/// With the single and double layer, S and D:
///
/// ```text
/// ½ P + D P + q s S_bed P + (s²/g) S_surface P + S_far T (P − p₁) = −ρ s (S_face E v + S_bed n·v_g)
/// p = Q P
/// ```
///
/// E and Q are the L² projections of piecewise linear interface velocity onto the face's elements and of the
/// elements' pressure onto the points' hat functions: `vᵀMp` is the power `∫ (E v) P ds`. p₁ is the channel's
/// plane wave under vertical motion of the ground, v_g; the far end does not radiate it. At s = 0, with
/// accelerations instead of s v, this is the equation of incompressible water.
pub struct BoundarySystem {
    mesh: BoundaryMesh,
    layers: LayerOperators,
    radiation: Radiation,
    interface: InterfaceProjection,
    water: Water,
    /// Elevations of the channel's surface and bed, m.
    channel: [f64; 2],
    far_end: FarEndCondition,
}

/// Pressure and its normal derivative at the nodes, divided by ρ s (at s = 0 by ρ); columns as in
/// [`BoundarySystem::symbol`].
pub(crate) struct BoundaryValues {
    pub pressure: Mat<Complex64>,
    pub slope: Mat<Complex64>,
}

impl BoundarySystem {
    /// Prepares everything that does not depend on the frequency.
    ///
    /// Without gravity waves `kernel` must vanish at the water level, the highest point of the face; with them the
    /// mesh must include the surface.
    ///
    /// **Errors**: [`ReservoirError::InterfaceMass`], [`ReservoirError::FarEnd`].
    pub fn new(
        face: &WetFace,
        mesh: BoundaryMesh,
        kernel: &dyn HelmholtzKernel,
        water: Water,
    ) -> Result<Self, ReservoirError> {
        let far = &mesh.elements()[mesh.elements_of(BoundaryCondition::Radiation)];
        let bottom = far.last().map_or(0.0, |element| element.end[1]);
        let interface = InterfaceProjection::new(face, &mesh)?;
        let mut points = mesh.nodes();
        points.extend(&interface.samples);
        Ok(Self {
            layers: LayerOperators::new(&mesh, kernel, &points),
            radiation: Radiation::new(&mesh, water)?,
            interface,
            channel: [face.depth(), bottom],
            water,
            mesh,
            far_end: FarEndCondition::Outgoing,
        })
    }

    /// The same water with another condition at the far end.
    pub(crate) fn ending(self, far_end: FarEndCondition) -> Self {
        Self { far_end, ..self }
    }

    /// K(s): interface pressure (Pa) for a unit interface velocity (m/s), then for a unit velocity of the ground
    /// (bed) along x and along y: points × (points + 2).
    ///
    /// The square part is `½ (K + M⁻¹ Kᵀ M)`, with K from collocation: it satisfies reciprocity to rounding.
    ///
    /// **Errors**: [`ReservoirError::Frequency`], [`ReservoirError::CutOff`], [`ReservoirError::Kernel`],
    /// [`ReservoirError::FarEnd`].
    pub fn symbol(&self, s: Complex64) -> Result<DMatrix<Complex64>, ReservoirError> {
        if !(s.re >= 0.0 && s.is_finite() && s != Complex64::ZERO) {
            return Err(ReservoirError::Frequency { frequency: s });
        }
        self.at_points(s, self.water.density * s)
    }

    /// A of incompressible water, `p = −A a`: interface pressure (Pa) for a unit interface acceleration
    /// (m/s²) into the water, then for that of the ground along −x and −y: points × (points + 2). It follows from
    /// Laplace's equation and is the limit s → 0 of `−K(s)/s`.
    ///
    /// **Errors**: [`ReservoirError::FarEnd`].
    pub fn added_mass(&self) -> Result<DMatrix<f64>, ReservoirError> {
        Ok(self.at_points(Complex64::ZERO, (-self.water.density).into())?.map(|z| z.re))
    }

    /// `factor` times the pressures at the points, divided by ρ s.
    fn at_points(&self, s: Complex64, factor: Complex64) -> Result<DMatrix<Complex64>, ReservoirError> {
        let (pressure, _) = self.solve(s)?;
        let wet = self.mesh.part(BoundaryCondition::WetFace);
        let samples = self.interface.samples.len();
        let sampled = pressure.as_ref().subrows(pressure.nrows() - samples, samples);
        let projected = self.interface.to_points.as_ref().subcols(0, wet.len())
            * pressure.as_ref().subrows(wet.start, wet.len())
            + self.interface.to_points.as_ref().subcols(wet.len(), samples) * sampled;
        let points = projected.nrows();
        let reciprocal = self.interface.reciprocal_part(projected.as_ref().subcols(0, points));
        let response = DMatrix::from_fn(points, points + 2, |i, j| {
            factor * if j < points { reciprocal[(i, j)] } else { projected[(i, j)] }
        });
        let finite = response.iter().all(|p| p.is_finite());
        if finite { Ok(response) } else { Err(ReservoirError::NonFiniteResponse { frequency: s }) }
    }

    /// Pressure divided by ρ s at the nodes, then at the interface's samples; and T.
    fn solve(&self, s: Complex64) -> Result<(Mat<Complex64>, Mat<Complex64>), ReservoirError> {
        check_cut_off(&self.water, s, self.channel[0] - self.channel[1])?;
        let kernel = |source| ReservoirError::Kernel { frequency: s, source };
        let Layers { single, double: mut matrix } =
            self.layers.assemble(s / self.water.sound_speed).map_err(kernel)?;
        let far = self.mesh.part(BoundaryCondition::Radiation);
        let map = match self.far_end {
            FarEndCondition::Outgoing => self.radiation.dirichlet_to_neumann(s)?,
            _ => Mat::zeros(far.len(), far.len()),
        };
        let radiated = single.as_ref().subcols(far.start, far.len()) * &map;
        let forcing = self.forcing(&single, &radiated, s);
        let nodes = matrix.ncols();
        if self.far_end == FarEndCondition::LeftOut {
            matrix.subcols_mut(far.start, far.len()).fill(Complex64::ZERO);
        }
        for node in 0..nodes {
            matrix[(node, node)] += 0.5;
        }
        if self.far_end == FarEndCondition::NoPressure {
            // At the far end the unknown is the normal derivative.
            matrix.subcols_mut(far.start, far.len()).copy_from(-single.subcols(far.start, far.len()));
        }
        for (offset, column) in far.enumerate() {
            for row in 0..matrix.nrows() {
                matrix[(row, column)] += radiated[(row, offset)];
            }
        }
        for (part, admittance) in self.admittances(s) {
            for column in self.mesh.part(part) {
                for row in 0..matrix.nrows() {
                    matrix[(row, column)] += admittance * single[(row, column)];
                }
            }
        }
        let at_nodes =
            matrix.as_ref().subrows(0, nodes).partial_piv_lu().solve(forcing.as_ref().subrows(0, nodes));
        // Samples lie inside straight elements, where the free term is ½ as well.
        let samples = self.interface.samples.len();
        let known = matrix.as_ref().subrows(nodes, samples) * &at_nodes;
        let pressure = Mat::from_fn(nodes + samples, forcing.ncols(), |row, column| {
            if row < nodes {
                at_nodes[(row, column)]
            } else {
                2.0 * (forcing[(row, column)] - known[(row - nodes, column)])
            }
        });
        Ok((pressure, map))
    }

    /// Parts of the boundary with `∂p/∂n = −β p` where they are at rest, and β (1/m).
    fn admittances(&self, s: Complex64) -> Vec<(BoundaryCondition, Complex64)> {
        let mut admittances = Vec::new();
        if self.water.bed_admittance > 0.0 {
            admittances.push((BoundaryCondition::AbsorbingBed, self.water.bed_admittance * s));
        }
        admittances.extend(self.water.gravity.map(|g| (BoundaryCondition::SurfaceWaves, s * s / g)));
        admittances
    }

    /// The right-hand sides divided by ρ s: face, ground along x, ground along y.
    fn forcing(&self, single: &Mat<Complex64>, radiated: &Mat<Complex64>, s: Complex64) -> Mat<Complex64> {
        let wet = self.mesh.part(BoundaryCondition::WetFace);
        let (faces, points) = (&self.interface.to_nodes, self.interface.to_nodes.ncols());
        let of_face = single.as_ref().subcols(wet.start, wet.len()) * faces;
        let ground = self.ground_normals();
        let plane = self.plane_wave_at_far_end(s);
        let bed = self.mesh.part(BoundaryCondition::AbsorbingBed);
        Mat::from_fn(single.nrows(), points + 2, |row, column| {
            if column < points {
                return -of_face[(row, column)];
            }
            let axis = column - points;
            let moved: Complex64 =
                bed.clone().zip(&ground).map(|(node, normal)| single[(row, node)] * normal[axis]).sum();
            let waves: Complex64 = plane.iter().enumerate().map(|(node, p)| radiated[(row, node)] * p).sum();
            if axis == 1 { waves - moved } else { -moved }
        })
    }

    /// Normals at the bed's nodes.
    fn ground_normals(&self) -> Vec<[f64; 2]> {
        let elements = &self.mesh.elements()[self.mesh.elements_of(BoundaryCondition::AbsorbingBed)];
        elements.iter().flat_map(|e| self.mesh.order().nodes().iter().map(|_| e.normal())).collect()
    }

    /// `p₁/(ρ s v)` (m) at the far end's nodes.
    fn plane_wave_at_far_end(&self, s: Complex64) -> Vec<Complex64> {
        let [surface, bottom] = self.channel;
        let nodes = self.mesh.nodes();
        let far = &nodes[self.mesh.part(BoundaryCondition::Radiation)];
        far.iter().map(|node| plane_wave(&self.water, s, surface - bottom, surface - node[1])).collect()
    }

    /// Pressure and its normal derivative at all nodes, divided by ρ s (at s = 0 by ρ).
    pub(crate) fn boundary_values(&self, s: Complex64) -> Result<BoundaryValues, ReservoirError> {
        let (solved, map) = self.solve(s)?;
        let pressure = solved.as_ref().subrows(0, self.mesh.nodes().len()).to_owned();
        let mut slope = Mat::zeros(pressure.nrows(), pressure.ncols());
        let points = pressure.ncols() - 2;
        for (offset, node) in self.mesh.part(BoundaryCondition::WetFace).enumerate() {
            for column in 0..points {
                slope[(node, column)] = -self.interface.to_nodes[(offset, column)];
            }
        }
        for (node, normal) in self.mesh.part(BoundaryCondition::AbsorbingBed).zip(self.ground_normals()) {
            slope[(node, points)] = (-normal[0]).into();
            slope[(node, points + 1)] = (-normal[1]).into();
        }
        for (part, admittance) in self.admittances(s) {
            for node in self.mesh.part(part) {
                for column in 0..points + 2 {
                    slope[(node, column)] -= admittance * pressure[(node, column)];
                }
            }
        }
        let far = self.mesh.part(BoundaryCondition::Radiation);
        let mut outgoing = pressure.as_ref().subrows(far.start, far.len()).to_owned();
        for (node, plane) in self.plane_wave_at_far_end(s).into_iter().enumerate() {
            outgoing[(node, points + 1)] -= plane;
        }
        let let_out = map * outgoing;
        for (offset, node) in far.enumerate() {
            for column in 0..points + 2 {
                slope[(node, column)] = -let_out[(offset, column)];
            }
        }
        Ok(BoundaryValues { pressure, slope })
    }

    /// The mesh.
    pub(crate) fn mesh(&self) -> &BoundaryMesh {
        &self.mesh
    }
}

/// The boundary element system of the parameters' water, which is then solved at each frequency.
///
/// **Errors**: those of the outline and the mesh, [`ReservoirError::FarEnd`].
pub fn boundary_system(parameters: &ReservoirParameters) -> Result<BoundarySystem, ReservoirError> {
    let face = &parameters.wet_face;
    let mesh = BoundaryMesh::new(&Outline::new(parameters)?, parameters);
    BoundarySystem::new(face, mesh, &*kernel(parameters), Water::of(parameters))
}

/// The kernel with an image about the surface, or without one where the surface is meshed.
pub(crate) fn kernel(parameters: &ReservoirParameters) -> Box<dyn HelmholtzKernel> {
    if parameters.surface_waves {
        Box::new(FreeSpace)
    } else {
        Box::new(FreeSurface { level: parameters.wet_face.depth() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Elements so short that the operators are no longer finite are an error, not NaN.
    #[test]
    fn a_response_that_is_not_finite_is_an_error() -> Result<(), Box<dyn std::error::Error>> {
        let parameters = ReservoirParameters {
            corner_element_size: Some(0.05),
            ..ReservoirParameters::before(WetFace::straight([0.0, 180.0], 16)?)
        };
        let system = boundary_system(&parameters)?;
        let symbol = system.symbol(Complex64::new(0.0, 0.5));
        assert!(matches!(symbol, Err(ReservoirError::NonFiniteResponse { .. })));
        assert!(matches!(system.added_mass(), Err(ReservoirError::NonFiniteResponse { .. })));
        Ok(())
    }
}
