//! Statistics of series of runs: quantiles, how sure a median is, fragility curves, whether two methods agree, what the variance
//! comes from.

mod bootstrap;
mod equivalence;
mod fragility;
mod latin_hypercube;
mod quantiles;
mod rank_share;
mod variance;

pub use bootstrap::{Band, band};
pub use equivalence::{Ratio, holm, ratio_of_medians};
pub use fragility::{Fragility, Lognormal, NoFit, Outcome, fit};
pub use latin_hypercube::{choice, latin_hypercube, uncorrelated_latin_hypercube};
pub use quantiles::{median_interval, quantile};
pub use rank_share::{RankShare, Settings, rank_share, ranks};
pub use variance::main_effect;
