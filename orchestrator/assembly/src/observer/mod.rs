//! What watches the run of a dam: histories, limits, rest, pictures.

mod histories;
mod limits;
mod outline;
mod progress;
mod rest;
mod snapshots;
mod water_field;

pub use histories::{Histories, HistoriesError, HistoriesWriter};
pub use limits::Limits;
pub use outline::OutlineWriter;
pub use progress::Progress;
pub use rest::{AVERAGED, LastSecond, Rest, SLID_AWAY, SLIDES_AWAY, STILL_MOVES, STILL_SLIDES};
pub use snapshots::Snapshots;
pub use water_field::WaterField;

use crate::units::DAM;
use cofferdam_coupling::observer::{ObserverError, Start};
use cofferdam_coupling::participant::Description;
use std::ops::Range;

/// What observers of a dam ask of the start of a run.
trait StartOfDam {
    /// The dam.
    fn dam(&self) -> &Description;

    /// Place of the output `variable` of the dam, which the scene's `key` needs.
    ///
    /// **Errors**: [`ObserverError::NotTold`].
    fn output(&self, key: &'static str, variable: &str) -> Result<Range<usize>, ObserverError> {
        self.dam().outputs.range(variable).ok_or_else(|| self.not_told(key, variable))
    }

    fn not_told(&self, key: &'static str, variable: &str) -> ObserverError {
        ObserverError::NotTold { key, variable: variable.to_owned(), unit: self.dam().name.clone() }
    }
}

impl StartOfDam for Start<'_> {
    fn dam(&self) -> &Description {
        &self.units[DAM.0]
    }
}
