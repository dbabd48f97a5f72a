//! The log of a co-simulation: every request and every answer as protobuf messages in MCAP, written, read, compared and replayed.
//!
//! A [`LogWriter`] observes a run and writes on a thread of its own. A [`Log`] reads complete, cut and damaged files as typed
//! [`Entries`], bit for bit; [`replay`] repeats its requests with new units; [`compare`] finds the first bit in which two logs
//! differ, and [`Agreement`] how far they agree within a tolerance. A log can be read while its run writes it.
//! `docs/reference/log.md` describes the format.
//!
//! ```
//! use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
//! use cofferdam_coupling::convergence::{ConvergenceMeasure, Measure, Scales};
//! use cofferdam_coupling::participant::FunctionUnit;
//! use cofferdam_coupling::scheme::{
//!     Direction, Field, Graph, Interface, Port, Predictor, Scheme, Settings, UnitId,
//! };
//! use cofferdam_coupling::{simulation::Simulation, stepping::Stepping};
//! use cofferdam_log::{Entry, Log, LogWriter, Preamble};
//!
//! // A pump whose flow falls with the pressure, and a pipe whose pressure rises with the flow: q = 2 − p, p = q/2.
//! let pump = FunctionUnit::new("pump", &[("pressure", "Pa")], &[("flow", "m3/s")], 0.0, |_, _, u, y| y[0] = 2.0 - u[0])?;
//! let pipe = FunctionUnit::new("pipe", &[("flow", "m3/s")], &[("pressure", "Pa")], 0.0, |_, _, u, y| y[0] = u[0] / 2.0)?;
//! let fields = vec![
//!     Field::new(Direction::Forward, "flow", "flow"),
//!     Field::new(Direction::Backward, "pressure", "pressure"),
//! ];
//! let interface = Interface::new(Port::of(UnitId(0)), Port::of(UnitId(1)), fields);
//! let mut graph = Graph::new(vec![Box::new(pump), Box::new(pipe)], vec![interface])?;
//! // Converged when the pressures given and returned differ by less than 1e-9 of the pressure; a typical one is 1 Pa.
//! let scales = Scales { typical: 1.0, ..Scales::default() };
//! let measure = ConvergenceMeasure::new(&[Measure::Relative], 1e-9, scales);
//! let acceleration = Acceleration::new(AccelerationKind::Aitken, 0.5, 1.0);
//! let scheme = Scheme::new(&mut graph, Settings::default(), acceleration, Predictor::new(0), measure, Vec::new())?;
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("log.mcap");
//! let mut log = LogWriter::create(&path, &Preamble::default())?;
//! let mut simulation = Simulation::new(graph, scheme, Stepping::equal(1.0, 3));
//! let (_, failure) = simulation.run(&mut [&mut log], &false.into());
//! assert!(failure.is_none(), "{failure:?}");
//!
//! for entry in Log::open(&path)?.entries()? {
//!     if let Entry::Exchange(exchange) = entry? && exchange.accepted && exchange.occasion.step > 0 {
//!         let flow_or_pressure = exchange.outputs.unwrap_or_default()[0];
//!         assert!((flow_or_pressure - [4.0 / 3.0, 2.0 / 3.0][exchange.unit.0]).abs() < 1e-6);
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod accepted;
mod agreement;
mod alignment;
pub mod background;
mod budget;
mod check;
mod chunk;
mod common_variable;
mod comparison;
mod content;
mod decode;
mod entry;
mod error;
mod foxglove;
mod head;
mod index;
mod overview;
mod past;
mod quantity;
mod reader;
mod recovery;
pub mod replay;
pub mod results_file;
mod schema;
mod seek;
mod shapes;
mod source;
mod stream;
mod topic;
mod types;
mod worst;
mod writer;

pub use accepted::{AcceptedStep, AcceptedSteps};
pub use agreement::ROUNDING;
pub use agreement::{Agreement, End, Event, Events, Measured};
pub use common_variable::{CommonVariable, Kind as VariableKind};
pub use comparison::{Comparison, KeyDifference, compare, equal_keys, settings};
pub use content::{Content, LoggedExchanges};
pub use decode::{Mismatch, Wanted};
pub use entry::{Entry, LoggedDamage, LoggedEnd, LoggedExchange, LoggedIteration, LoggedStep};
pub use error::{LogError, LogReadError};
pub use head::{Head, LoggedUnit};
pub use overview::Overview;
pub use past::{Extent, LastCheckpoint, Reports};
pub use quantity::{Quantity, UnknownQuantity};
pub use reader::{Entries, Log, Traffic};
pub use recovery::{Recovery, RecoveryError, recover};
pub use schema::{Kind, MessageType, Value};
pub use shapes::shaped_outputs;
pub use worst::worst;
pub use writer::{LogWriter, Parent, Preamble};
