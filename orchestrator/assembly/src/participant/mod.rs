//! Units that only scenes of dams need.

mod empty_reservoir;
mod foreign;
mod prescribed;
mod recorded;

pub use empty_reservoir::EmptyReservoir;
pub use foreign::{FaceError, Foreign, Place, SelfTest, check_sign, held_answer, self_test};
pub use prescribed::Prescribed;
pub use recorded::{Recorded, RecordedError, Recording};
