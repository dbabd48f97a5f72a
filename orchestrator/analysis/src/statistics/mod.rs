//! Statistics of series of runs: quantiles, how sure a median is, exceedances of limits and fragility curves, whether two methods agree, what the variance
//! comes from.

#[cfg(test)]
mod coverage;
mod equivalence;
mod evidence;
mod exact;
mod exceedance;
mod fragility;
mod jackknife;
mod latin_hypercube;
mod proposal;
mod quantiles;
mod rank_share;
mod variance;

pub use equivalence::{Ratio, holm, ratio_of_medians};
pub use evidence::{Curve, Evidence, LEAST_CLUSTERS, LEAST_LEVELS, LEAST_MIXED, Missing};
pub use exact::{clopper_pearson, clustered, trials_for_width};
pub use exceedance::{Exceedance, Outcome, exceedance, exceedances, have_common_levels, median_bracket};
pub use fragility::Lognormal;
pub use jackknife::Fitted;
pub use latin_hypercube::{choice, latin_hypercube, uncorrelated_latin_hypercube};
pub use proposal::{Proposal, WIDTH, is_apart, propose};
pub use quantiles::{median_interval, quantile};
pub use rank_share::{RankShare, Settings, rank_share, ranks};
pub use variance::main_effect;
