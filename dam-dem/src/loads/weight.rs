use std::borrow::Cow;

use super::{Acting, Load, LoadBasis};

/// The weight `m g` of each node; its amplitude is 1.
#[derive(Debug)]
pub(crate) struct Weight(LoadBasis);

impl Weight {
    /// That of nodes with this `mass` (kg/m) under `gravity` (m/s²).
    pub fn new(mass: &[f64], gravity: f64) -> Self {
        let entries = mass.iter().enumerate().map(|(node, m)| (node, 0, [0.0, m * -gravity])).collect();
        Self(LoadBasis { columns: 1, entries })
    }
}

impl Load for Weight {
    fn basis(&self) -> &LoadBasis {
        &self.0
    }

    fn amplitudes<'a>(&'a self, _: &'a Acting) -> Cow<'a, [f64]> {
        Cow::Borrowed(&[1.0])
    }

    fn at_rest(&self) -> Vec<Vec<f64>> {
        vec![vec![1.0]]
    }
}
