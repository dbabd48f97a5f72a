//! Values that not every unit has.

use cofferdam_coupling::participant::ParticipantError;

/// What a unit returned for a variable; nothing if it has no such variable.
///
/// **Errors**: all others of the unit.
pub fn known(read: Result<Vec<f64>, ParticipantError>) -> Result<Vec<f64>, ParticipantError> {
    match read {
        Err(ParticipantError::Missing { .. }) => Ok(Vec::new()),
        answered => answered,
    }
}
