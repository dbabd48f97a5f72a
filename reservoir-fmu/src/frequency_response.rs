//! The symbol K(s) of a reservoir and the convolution weights that follow from it.
//!
//! Depends on `added_mass`, `boundary`, `convolution`, `fidelity`, `kernel`, `outline` and `system`.

use crate::added_mass::whole_added_mass;
use crate::boundary::BoundaryMesh;
use crate::convolution::{ConvolutionQuadrature, Rule, Weights};
use crate::kernel::{FreeSpace, FreeSurface, HelmholtzKernel};
use crate::outline::Outline;
use crate::system::{BoundarySystem, Water};
use crate::{Method, ReservoirError, ReservoirParameters};
use nalgebra::DMatrix;
use num_complex::Complex64;
use rayon::prelude::*;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};

/// K(s): interface pressure (Pa) for a unit interface velocity (m/s), and for a unit velocity of the ground, at
/// complex frequencies.
///
/// **Shapes and units**: `s` in 1/s, not 0 and with real parts that are not negative; s = iω is the real frequency
/// ω. One points × (points + 2) matrix a frequency: a column an interface point, then the ground (the bed alone,
/// the face at rest) along x and along y. For water without memory it is `−s A`, A its added mass.
///
/// There are no irregular frequencies: what solves the integral equation and is no pressure in the water would
/// be an outgoing wave outside of it that vanishes on the boundary, of which there is none. A rigid bed deeper
/// before the dam than upstream can resonate below the cut-off; there, at s = iω and α = 1, the water itself has
/// no bounded answer.
///
/// **Errors**: parameters out of range, [`ReservoirError::Frequency`], [`ReservoirError::CutOff`],
/// [`ReservoirError::Kernel`], [`ReservoirError::FarEnd`], [`ReservoirError::Threads`].
pub fn frequency_response(
    parameters: &ReservoirParameters,
    s: &[Complex64],
    threads: NonZeroUsize,
) -> Result<Vec<DMatrix<Complex64>>, ReservoirError> {
    parameters.validate()?;
    let allowed = |s: &Complex64| s.re >= 0.0 && s.is_finite() && *s != Complex64::ZERO;
    if let Some(&frequency) = s.iter().find(|s| !allowed(s)) {
        return Err(ReservoirError::Frequency { frequency });
    }
    if !parameters.fidelity.has_memory() && !parameters.surface_waves {
        let mass = whole_added_mass(parameters)?;
        return Ok(s.iter().map(|&s| mass.map(|m| -s * m)).collect());
    }
    symbols(&boundary_system(parameters)?, s, threads)
}

/// K(s) of a system at all `s`, on `threads`.
pub(crate) fn symbols(
    system: &BoundarySystem,
    s: &[Complex64],
    threads: NonZeroUsize,
) -> Result<Vec<DMatrix<Complex64>>, ReservoirError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build()?;
    pool.install(|| s.par_iter().map(|&s| system.symbol(s)).collect())
}

/// The boundary element system of the parameters' water, for one frequency after the other.
///
/// **Errors**: those of the outline and the mesh, [`ReservoirError::FarEnd`].
pub fn boundary_system(parameters: &ReservoirParameters) -> Result<BoundarySystem, ReservoirError> {
    let face = &parameters.wet_face;
    let mesh = BoundaryMesh::new(&Outline::new(parameters)?, parameters);
    BoundarySystem::new(face, mesh, &*kernel(parameters), water(parameters))
}

/// The image about the surface, or none where the surface is meshed.
pub(crate) fn kernel(parameters: &ReservoirParameters) -> Box<dyn HelmholtzKernel> {
    if parameters.surface_waves {
        Box::new(FreeSpace)
    } else {
        Box::new(FreeSurface { level: parameters.wet_face.depth() })
    }
}

/// The water of the parameters; incompressible water has no sound, and a bed that is rigid whatever it is.
pub(crate) fn water(parameters: &ReservoirParameters) -> Water {
    let gravity = parameters.surface_waves.then_some(parameters.gravity);
    let density = parameters.density;
    if parameters.fidelity.has_memory() {
        let bed_admittance = parameters.bed_admittance();
        Water { density, sound_speed: parameters.sound_speed, bed_admittance, gravity }
    } else {
        Water { density, sound_speed: f64::INFINITY, bed_admittance: 0.0, gravity }
    }
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
    let rule = match parameters.method {
        Method::Bdf2 => Rule::Bdf2,
        Method::Trapezoid => Rule::Trapezoid,
        Method::Radau3 => Rule::Radau3,
        _ => Rule::Radau2,
    };
    ConvolutionQuadrature { rule, communication_step, steps: parameters.steps() }
}
