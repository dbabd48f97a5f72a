//! What an earthquake leaves: settlement and freeboard of the crest, tilt and bond of the joints; and how long the heel was in tension.

use super::{LastSecond, LoadedScene, REST, Table};
use cofferdam_scene::{CrackScene, Side};

impl Table<'_> {
    /// Whether the ground was at rest for long enough at the end that what is left can be read.
    pub(super) fn is_quiet(&self, loaded: &LoadedScene) -> bool {
        let end = self.time.last().copied().unwrap_or(0.0);
        loaded.ground_motion.rest_from().is_some_and(|rest| end + 1e-9 >= rest + REST)
    }

    /// Residual settlement of the crest, and the freeboard above the reservoir at rest that it leaves.
    pub(super) fn crest_after(&mut self, loaded: &LoadedScene) {
        let Some(settlement) = self.mean_at_end("dam.crest_displacement.y", loaded).map(|mean| -mean) else {
            return;
        };
        self.add("residual settlement of the crest", 1e3 * settlement, "mm", None);
        let scene = &loaded.scene;
        let section = scene.dam.as_ref().map(|dam| &dam.section);
        let crest = section.and_then(|section| section.upstream.last()).map(|[_, y]| *y);
        if let Some(crest) =
            crest.filter(|_| scene.water(Side::Upstream).is_some_and(|water| !water.is_empty()))
        {
            self.add("freeboard at the end", crest - scene.depth() - settlement, "m", None);
        }
    }

    /// Residual tilt of the block above a crack, and the bond that is left in it.
    pub(super) fn crack_after(
        &mut self,
        index: usize,
        crack: &CrackScene,
        cracks: &[CrackScene],
        loaded: &LoadedScene,
    ) {
        let of = |what: &str| super::of_crack(what, crack, cracks);
        if let Some(tilt) = self.mean_at_end(&format!("dam.crack_rotation.{index}"), loaded) {
            self.add(&of("residual rotation of the block above"), 1e3 * tilt, "mrad", None);
        }
        let bonded = self.histories.column(&format!("dam.crack_bonded_share.{index}")).unwrap_or(&[]);
        let (Some(first), Some(last)) = (bonded.first(), bonded.last()) else { return };
        if *first > 0.0 {
            self.add(&of("bonded share of the length at the end"), 1e2 * last, "%", None);
            let broke = bonded.iter().position(|share| share < first);
            if let Some(time) = broke.and_then(|row| self.time.get(row)) {
                self.add(&of("time of the first broken bond"), *time, "s", None);
            }
        }
    }

    /// How long the heel was in tension, in total and without a break.
    pub(super) fn heel_in_tension(&mut self) {
        let Some(stress) = self.histories.column("dam.major_principal_stress.0") else { return };
        let [total, longest] = above(self.time, stress, 0.0);
        self.add("time with tension at the heel, total", total, "s", None);
        self.add("time with tension at the heel, longest", longest, "s", None);
    }

    /// Mean of a column over the last second, if the ground is quiet then and the dam no longer moves.
    fn mean_at_end(&self, column: &str, loaded: &LoadedScene) -> Option<f64> {
        let last = LastSecond::of(self.histories, column).filter(|_| self.is_quiet(loaded))?;
        last.is_rest().then_some(last.sliding)
    }
}

/// How long `values` were above a `level`, in total and at the longest stretch, s. The value at the end of a step applies to the whole
/// step.
pub(crate) fn above(time: &[f64], values: &[f64], level: f64) -> [f64; 2] {
    let (mut total, mut longest, mut stretch) = (0.0, 0.0f64, 0.0);
    for (pair, value) in time.windows(2).zip(values.iter().skip(1)) {
        let step = pair[1] - pair[0];
        stretch = if *value > level { stretch + step } else { 0.0 };
        total += if *value > level { step } else { 0.0 };
        longest = longest.max(stretch);
    }
    [total, longest]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretches_above_a_level_are_summed_and_the_longest_is_found() {
        let time = [0.0, 1.0, 2.0, 4.0, 5.0, 6.0];
        assert_eq!(above(&time, &[9.0, 1.0, -1.0, 1.0, 1.0, 0.0], 0.0), [4.0, 3.0]);
        assert_eq!(above(&time, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.0), [0.0, 0.0]);
        assert_eq!(above(&[], &[], 0.0), [0.0, 0.0]);
    }
}
