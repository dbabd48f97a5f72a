//! The log: every request and every answer as protobuf messages in MCAP. Logs are written, read and compared here.

mod accepted;
mod agreement;
mod common_variable;
mod comparison;
mod decode;
mod entry;
mod error;
mod foxglove;
mod head;
mod overview;
mod quantity;
mod reader;
mod schema;
mod stream;
mod topic;
mod types;
mod worst;
mod writer;

pub use accepted::{AcceptedStep, AcceptedSteps};
pub use agreement::{Agreement, End, Event, Measured};
pub use common_variable::{CommonVariable, Kind as VariableKind};
use comparison::settings;
pub use comparison::{Comparison, KeyDifference, compare};
pub use decode::{Mismatch, Wanted};
pub use entry::{Entry, LoggedEnd, LoggedExchange, LoggedStep};
pub use error::{LogError, LogReadError};
pub use head::{Head, LoggedGroundMotion, LoggedUnit};
pub use overview::Overview;
pub use quantity::{Quantity, UnknownQuantity};
pub use reader::{Entries, Log, Traffic};
pub use schema::{Kind, MessageType, Value};
pub use worst::worst;
pub use writer::{LogWriter, Preamble};
