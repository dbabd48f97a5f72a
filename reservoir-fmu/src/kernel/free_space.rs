use super::{HelmholtzKernel, Source};

/// The source alone: `G = K₀(kr)/2π`, for a boundary that is meshed all around.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeSpace;

impl HelmholtzKernel for FreeSpace {
    fn sources(&self, point: [f64; 2]) -> Vec<Source> {
        vec![Source { point, strength: 1.0 }]
    }
}
