//! Statistics of series of runs: quantiles, how sure a median is, fragility curves, what the variance comes from.

mod bootstrap;
mod fragility;
mod latin_hypercube;
mod quantiles;
mod variance;

pub use bootstrap::{Band, band};
pub use fragility::{Fragility, Lognormal, NoFit, Outcome, fit};
pub use latin_hypercube::latin_hypercube;
pub use quantiles::{median_interval, quantile};
pub use variance::main_effect;
