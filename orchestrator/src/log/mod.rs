//! The log: every request and every answer as protobuf messages in MCAP. Logs are written, read and compared here.

mod budget;
mod comparison;
mod decode;
mod entry;
mod error;
mod foxglove;
mod head;
mod overview;
mod past;
mod reader;
mod schema;
mod stream;
mod topic;
mod types;
mod worst;
mod writer;

pub use comparison::{Comparison, KeyDifference, compare};
pub use decode::{Mismatch, Wanted};
pub use entry::{Entry, LoggedEnd, LoggedExchange, LoggedIteration, LoggedStep};
pub use error::{LogError, LogReadError};
pub use head::{Head, LoggedGroundMotion, LoggedUnit};
pub use overview::Overview;
pub use past::{LastCheckpoint, Reports};
pub use reader::{Entries, Log, Traffic};
pub use schema::{Kind, MessageType, Value};
pub use worst::worst;
pub use writer::{LogWriter, Parent, Preamble};
