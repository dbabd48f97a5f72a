//! Statistics of series of runs: quantiles, how sure a median is, fragility curves, whether two methods agree, what the variance
//! comes from, few dear runs beside many cheap ones.

mod bootstrap;
mod control_variate;
mod equivalence;
mod fragility;
mod latin_hypercube;
mod quantiles;
mod variance;

pub use bootstrap::{Band, band};
pub use control_variate::{
    Control, Declined, LEAST_CLUSTERS, Motion, Spread, control, predicted_saving, saving,
};
pub use equivalence::{Ratio, holm, ratio_of_medians};
pub use fragility::{Fragility, Lognormal, NoFit, Outcome, fit};
pub use latin_hypercube::latin_hypercube;
pub use quantiles::{median_interval, quantile};
pub use variance::main_effect;
