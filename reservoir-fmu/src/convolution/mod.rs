//! Discrete convolution of the interface velocity with the kernel p/v.
//!
//! `quadrature` makes the weights from the Laplace-domain symbol, `interpolation` spares
//! most of the frequencies, `partitioned` evaluates the sum in blocks. Depends on no other
//! part of the crate: any matrix symbol analytic for Re s > 0 will do.

mod interpolation;
mod partitioned;
mod quadrature;

pub(crate) use partitioned::{Convolution, History};
pub(crate) use quadrature::{ConvolutionQuadrature, Rule, Weights};
