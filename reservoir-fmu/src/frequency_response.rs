//! The symbol K(s) of a reservoir and the convolution weights that follow from it.
//!
//! Depends on `added_mass`, `boundary`, `convolution`, `fidelity`, `kernel` and `system`.

use crate::boundary::BoundaryMesh;
use crate::convolution::{ConvolutionQuadrature, Weights};
use crate::kernel::FreeSurface;
use crate::system::{BoundarySystem, Water};
use crate::{ReservoirError, ReservoirParameters, added_mass};
use nalgebra::DMatrix;
use num_complex::Complex64;
use rayon::prelude::*;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};

/// K(s): interface pressure (Pa) for a unit interface velocity (m/s) at complex frequencies.
///
/// **Shapes and units**: `s` in 1/s with positive real parts; one points × points matrix a
/// frequency. For water without memory it is `−s A`, A its added mass.
///
/// **Errors**: parameters out of range, [`ReservoirError::Frequency`], [`ReservoirError::Kernel`],
/// [`ReservoirError::FarEnd`], [`ReservoirError::Threads`].
pub fn frequency_response(
    parameters: &ReservoirParameters,
    s: &[Complex64],
    threads: NonZeroUsize,
) -> Result<Vec<DMatrix<Complex64>>, ReservoirError> {
    parameters.validate()?;
    if let Some(&frequency) = s.iter().find(|s| !(s.re > 0.0 && s.is_finite())) {
        return Err(ReservoirError::Frequency { frequency });
    }
    if !parameters.fidelity.has_memory() {
        let mass = added_mass(parameters)?;
        return Ok(s.iter().map(|&s| mass.map(|m| -s * m)).collect());
    }
    let system = boundary_system(parameters)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build()?;
    pool.install(|| s.par_iter().map(|&s| system.symbol(s)).collect())
}

/// The boundary element system of the parameters' water.
pub(crate) fn boundary_system(parameters: &ReservoirParameters) -> Result<BoundarySystem, ReservoirError> {
    let face = &parameters.wet_face;
    let mesh = BoundaryMesh::new(face, parameters.element_size, parameters.far_end_distance);
    // At s = 0 the bed is rigid whatever its admittance.
    let bed_admittance = if parameters.fidelity.has_memory() { parameters.bed_admittance() } else { 0.0 };
    let water = Water { density: parameters.density, sound_speed: parameters.sound_speed, bed_admittance };
    BoundarySystem::new(face, mesh, &FreeSurface { level: face.depth() }, water)
}

/// The convolution weights of compressible water, on the current rayon pool, and the number of
/// frequencies at which the system was solved for them.
pub(crate) fn convolution_weights(
    parameters: &ReservoirParameters,
) -> Result<(Weights, usize), ReservoirError> {
    let system = boundary_system(parameters)?;
    let solved = AtomicUsize::new(0);
    let symbol = |s| {
        solved.fetch_add(1, Ordering::Relaxed);
        system.symbol(s)
    };
    let weights = quadrature(parameters).weights(symbol, &parameters.branch_points())?;
    Ok((weights, solved.into_inner()))
}

/// The convolution quadrature over the parameters' horizon.
pub(crate) fn quadrature(parameters: &ReservoirParameters) -> ConvolutionQuadrature {
    let communication_step = parameters.communication_step;
    ConvolutionQuadrature { communication_step, steps: parameters.steps() }
}
