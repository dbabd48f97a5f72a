//! The log: every request and every answer as protobuf messages in MCAP. Logs are written, read and compared here.

mod check;
mod chunk;
mod comparison;
mod decode;
mod entry;
mod error;
mod foxglove;
mod head;
mod index;
mod overview;
mod reader;
mod recovery;
mod schema;
mod seek;
mod source;
mod stream;
mod topic;
mod types;
mod worst;
mod writer;

pub use comparison::{Comparison, KeyDifference, compare};
pub use decode::{Mismatch, Wanted};
pub use entry::{Entry, LoggedDamage, LoggedEnd, LoggedExchange, LoggedStep};
pub use error::{LogError, LogReadError};
pub use head::{Head, LoggedGroundMotion, LoggedUnit};
pub use overview::Overview;
pub use reader::{Entries, Log, Traffic};
pub use recovery::{Recovery, RecoveryError, recover};
pub use schema::{Kind, MessageType, Value};
pub use worst::worst;
pub use writer::{LogWriter, Preamble};
