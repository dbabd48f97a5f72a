//! The log: every request and every answer, as protobuf messages in MCAP.

mod schema;
mod writer;

pub use schema::{Kind, MessageType, Value};
pub use writer::{LogError, LogWriter, Preamble};
