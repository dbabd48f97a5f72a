//! The symbol K(s) of a reservoir and the convolution weights that follow from it.
//!
//! Depends on `boundary`, `convolution`, `fidelity`, `kernel` and `system`.

use crate::boundary::BoundaryMesh;
use crate::convolution::{ConvolutionQuadrature, Weights};
use crate::fidelity::{added_mass, added_mass_weights};
use crate::kernel::FreeSurface;
use crate::system::{BoundarySystem, Water};
use crate::{Fidelity, ReservoirError, ReservoirParameters};
use nalgebra::DMatrix;
use num_complex::Complex64;
use rayon::prelude::*;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};

/// K(s): interface pressure (Pa) for a unit interface velocity (m/s) at complex frequencies.
///
/// **Shapes and units**: `s` in 1/s with positive real parts; one points × points matrix a
/// frequency. For Westergaard's added mass m it is `−s m`.
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
    if parameters.fidelity == Fidelity::Westergaard {
        let mass = nalgebra::DVector::from_vec(added_mass(&parameters.wet_face, parameters.density));
        let mass = DMatrix::from_diagonal(&mass);
        return Ok(s.iter().map(|&s| mass.map(|m| -s * m)).collect());
    }
    let system = boundary_system(parameters)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build()?;
    pool.install(|| s.par_iter().map(|&s| system.symbol(s)).collect())
}

fn boundary_system(parameters: &ReservoirParameters) -> Result<BoundarySystem, ReservoirError> {
    let face = &parameters.wet_face;
    let mesh = BoundaryMesh::new(face, parameters.element_size, parameters.far_end_distance);
    let water = Water {
        density: parameters.density,
        sound_speed: parameters.sound_speed,
        bed_admittance: parameters.bed_admittance(),
    };
    BoundarySystem::new(face, mesh, &FreeSurface { level: face.depth() }, water)
}

/// The convolution weights of the parameters' fidelity, on the current rayon pool, and the number of
/// frequencies at which the system was solved for them.
pub(crate) fn convolution_weights(
    parameters: &ReservoirParameters,
) -> Result<(Weights, usize), ReservoirError> {
    if parameters.fidelity == Fidelity::Westergaard {
        let mass = added_mass(&parameters.wet_face, parameters.density);
        return Ok((added_mass_weights(&mass, parameters.communication_step), 0));
    }
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
