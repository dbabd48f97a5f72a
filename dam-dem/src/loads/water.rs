use std::borrow::Cow;
use std::ops::Range;

use super::{Acting, Load, LoadBasis};
use crate::wet::Wet;

/// The pressure on the wet faces, hydrostatic pressure included.
#[derive(Debug)]
pub(crate) struct Water(pub Wet);

impl Load for Water {
    fn basis(&self) -> &LoadBasis {
        &self.0.load.0
    }

    fn amplitudes<'a>(&'a self, acting: &'a Acting) -> Cow<'a, [f64]> {
        Cow::Borrowed(&acting.pressure)
    }

    /// Hydrostatic and uniform pressure on each face.
    fn at_rest(&self) -> Vec<Vec<f64>> {
        let wet = &self.0;
        let faces = wet.ranges().into_iter().enumerate().filter(|(_, points)| !points.is_empty());
        let of_face = |(side, points): (usize, Range<usize>)| {
            let uniform = (0..wet.len()).map(|i| f64::from(u8::from(points.contains(&i))));
            [wet.depths(side), uniform.collect()]
        };
        faces.flat_map(of_face).collect()
    }
}
