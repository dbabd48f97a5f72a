//! The symbol K(s) of a reservoir and the convolution weights that follow from it.
//!
//! Depends on `added_mass`, `convolution` and `system`.

use crate::added_mass::whole_added_mass;
use crate::convolution::{ConvolutionQuadrature, Weights};
use crate::system::{BoundarySystem, boundary_system};
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
/// ω. One matrix of points × (points + 2) per frequency: one column per interface point, then the ground (only
/// the bed moves) along x and along y. For water without memory it is `−s A`, with its added mass A.
///
/// There are no irregular frequencies: a spurious solution of the integral equation would be an outgoing wave
/// outside the water that vanishes on the boundary, and there is no such wave. Over a rigid bed that is deeper
/// at the dam than upstream, the water can resonate below the cut-off; there, at s = iω and α = 1, the response
/// itself is unbounded.
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

/// Number of frequencies at which making a convolution usually solves the boundary elements; `None` for water that is made in
/// another way. Interpolation saves two thirds to four fifths of those of the quadrature, but none of the trapezoidal rule's.
pub fn usual_frequencies(parameters: &ReservoirParameters) -> Option<usize> {
    if !parameters.fidelity.has_memory() {
        return None;
    }
    let all = quadrature(parameters).frequencies();
    match parameters.method {
        Method::Automatic if parameters.may_be_fitted() => None,
        Method::Automatic | Method::Bdf2 | Method::Radau2 | Method::Radau3 => Some(all * 3 / 10),
        Method::Trapezoid => Some(all),
        Method::Recursive | Method::FiniteElements => None,
    }
}

/// The convolution quadrature over the parameters' horizon.
pub(crate) fn quadrature(parameters: &ReservoirParameters) -> ConvolutionQuadrature {
    let communication_step = parameters.communication_step;
    let (rule, steps) = (parameters.method.rule(), parameters.steps());
    ConvolutionQuadrature { rule, communication_step, steps }
}
