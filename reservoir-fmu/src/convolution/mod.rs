//! Discrete convolution of the interface velocity with the kernel p/v.
//!
//! `quadrature` makes the weights from the Laplace-domain symbol, `interpolation` reduces
//! the number of frequencies, `partitioned` evaluates the sum in blocks. The weights can be made from any
//! matrix symbol that is analytic for Re s > 0.

mod interpolation;
mod partitioned;
mod quadrature;

pub(crate) use partitioned::Convolution;
pub(crate) use quadrature::{ConvolutionQuadrature, Rule, Weights};
