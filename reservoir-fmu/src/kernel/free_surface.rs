use super::{HelmholtzKernel, Source};

/// A source minus its image about a horizontal surface: `G = 0` on `y = level`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeSurface {
    /// Elevation of the surface, m.
    pub level: f64,
}

impl HelmholtzKernel for FreeSurface {
    fn sources(&self, point: [f64; 2]) -> Vec<Source> {
        let image = [point[0], 2.0 * self.level - point[1]];
        vec![Source { point, strength: 1.0 }, Source { point: image, strength: -1.0 }]
    }
}
