//! Values that not every unit has.

use cofferdam_coupling::participant::ParticipantError;

/// The values that a unit returned for a variable; empty if it has no such variable.
///
/// **Errors**: all others of the unit.
pub fn known(read: Result<Vec<f64>, ParticipantError>) -> Result<Vec<f64>, ParticipantError> {
    match read {
        Err(ParticipantError::Missing { .. }) => Ok(Vec::new()),
        answered => answered,
    }
}
