//! Runs of scenes and series of them: what `cofferdam run`, `resume`, `branch`, `ensemble`, `range`, `log bisect` and `plan` compute, for other
//! programs to call.
//!
//! Nothing here prints, reads arguments or ends the process. Lines for people go to a [`Reporter`](context::Reporter), results are
//! values and files, and each area has one error enum whose messages name the place and the remedy.
//!
//! | area | entry | result |
//! |---|---|---|
//! | a run, an interrupted one, a branch | [`run::prepare`], [`run::resume::prepare`], [`run::branch::prepare`] | [`run::RunOutcome`] and a folder |
//! | many runs | [`ensemble::run`] | a folder with tables and pictures |
//! | range of the results over models, numerics and motion | [`range::run`] | a folder with tables and pictures |
//! | numerics for an accuracy | [`accuracy::promise`] | [`accuracy::Promise`] |
//! | what is modelled, time and disk | [`plan::rows`], [`estimate::of`] | rows, numbers |
//! | when an outcome was certain | [`bisect::bisect`] | a row for each checkpoint |
//! | numbers of many runs | [`statistics`] | quantiles, bands, fragility |
//!
//! ```no_run
//! use cofferdam_analysis::context::Context;
//! use cofferdam_analysis::run::{Request, prepare};
//! use std::sync::atomic::AtomicBool;
//!
//! let request = Request { scene: "scenes/koyna-coarse".into(), ..Request::default() };
//! let run = prepare(&request, &Context::default())?;
//! let outcome = run.carry_out(&Context::default(), &AtomicBool::new(false), &mut [])?;
//! for quantity in outcome.summary.key_figures() {
//!     println!("{}: {} {}", quantity.name, quantity.value, quantity.unit);
//! }
//! # Ok::<(), cofferdam_analysis::run::RunError>(())
//! ```
//!
//! The median of the sliding of nine runs, with a 95 % interval that order statistics give:
//!
//! ```
//! use cofferdam_analysis::statistics::{median_interval, quantile};
//!
//! let sliding = [12.0, 14.0, 15.0, 17.0, 18.0, 21.0, 24.0, 30.0, 41.0]; // mm, ascending
//! assert_eq!(quantile(&sliding, 0.5), 18.0);
//! let [low, high] = median_interval(&sliding, sliding.len(), 0.95).expect("nine values are enough");
//! assert!(low < 18.0 && 18.0 < high);
//! ```

pub mod accuracy;
pub mod bisect;
pub mod closed_form;
pub mod context;
pub mod ensemble;
pub mod estimate;
pub mod flutter;
pub mod parallel;
pub mod parquet;
pub mod picture;
pub mod plan;
mod progress;
pub mod provenance;
pub mod range;
pub mod run;
mod spectra;
pub mod start;
pub mod statistics;
pub mod study;
pub mod table;
pub mod variables;
