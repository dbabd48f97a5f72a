use super::{HelmholtzKernel, Source};

/// A source without images, `G = K₀(kr)/2π`; the whole boundary must be meshed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeSpace;

impl HelmholtzKernel for FreeSpace {
    fn sources(&self, point: [f64; 2]) -> Vec<Source> {
        vec![Source { point, strength: 1.0 }]
    }
}
