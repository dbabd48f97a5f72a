//! Other conditions at the far end.
//!
//! Depends on `condition`, `frequency_response`, `system` and `whole_record`.

use crate::condition::FarEndCondition;
use crate::frequency_response::symbols;
use crate::system::boundary_system;
use crate::{ReservoirError, ReservoirParameters, whole_record};
use nalgebra::DMatrix;
use num_complex::Complex64;
use std::num::NonZeroUsize;

/// [`frequency_response`](crate::frequency_response()) of compressible water under any condition at the far end, which
/// lies at the parameters' `far_end_distance`.
///
/// [`FarEndCondition::LeftOut`] is that of the paper, which relies on outgoing fundamental solutions instead of a far end.
/// They suffice for a field outside a closed boundary; here the boundary is open where the waves leave.
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
