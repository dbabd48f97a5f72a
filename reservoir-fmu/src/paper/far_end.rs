//! Water that ends at a distance.
//!
//! Depends on `condition`, `frequency_response` and `whole_record`.

use crate::condition::FarEndCondition;
use crate::frequency_response::{boundary_system, symbols};
use crate::{ReservoirError, ReservoirParameters, whole_record};
use nalgebra::DMatrix;
use num_complex::Complex64;
use std::num::NonZeroUsize;

/// [`frequency_response`](crate::frequency_response()) of compressible water under any condition at the far end, which
/// stands at the parameters' `far_end_distance`.
///
/// [`FarEndCondition::LeftOut`] is the paper's: fundamental solutions that go out are to make the end superfluous. They
/// do for a field outside of a closed boundary; here the boundary is open where the waves go.
///
/// **Errors**: those of [`frequency_response`](crate::frequency_response()).
pub fn response_before(
    far_end: FarEndCondition,
    parameters: &ReservoirParameters,
    s: &[Complex64],
    threads: NonZeroUsize,
) -> Result<Vec<DMatrix<Complex64>>, ReservoirError> {
    parameters.validate()?;
    symbols(&boundary_system(parameters)?.ending(far_end), s, threads)
}

/// [`pressure_of_record`](crate::pressure_of_record) under any condition at the far end.
///
/// **Errors**: those of [`pressure_of_record`](crate::pressure_of_record).
pub fn pressure_before(
    far_end: FarEndCondition,
    parameters: &ReservoirParameters,
    acceleration: &DMatrix<f64>,
    threads: NonZeroUsize,
) -> Result<DMatrix<f64>, ReservoirError> {
    whole_record::pressure_before(far_end, parameters, acceleration, threads)
}
