//! Quadrature rules on [−1, 1] for boundary elements.
//!
//! Depends on nothing else in the crate.

mod gauss;
mod log_singular;
mod near_singular;

pub(crate) use gauss::{gauss_legendre, legendre};
pub(crate) use near_singular::element_rule;

/// A quadrature point ξ in [−1, 1] and its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct QuadraturePoint {
    pub position: f64,
    pub weight: f64,
}
