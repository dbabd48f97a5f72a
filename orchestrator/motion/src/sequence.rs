//! Shocks one after the other: a main shock and its aftershocks as one motion.

use super::{Component, GroundMotion};
use cofferdam_unit::number::plain;
use std::ops::Range;

/// Largest number of samples of a joined component.
const MOST_SAMPLES: usize = 10_000_000;
/// Largest number of parts of one interval between samples.
const MOST_PARTS: usize = 100;
/// Relative difference of intervals that counts as rounding of printed times.
const ROUNDING: f64 = 1e-4;

/// Why shocks cannot be joined.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SequenceError {
    /// Intervals without a common part.
    #[error(
        "the records have samples {} s and {} s apart, of which no common interval divides each into at most {MOST_PARTS} parts; \
         resample one of them", plain(*first), plain(*other)
    )]
    Intervals {
        /// An interval, s.
        first: f64,
        /// The one that does not fit, s.
        other: f64,
    },
    /// More samples than are handled.
    #[error(
        "records and rests have {samples} samples, {} s apart (limit {MOST_SAMPLES}); shorten `rest`, crop the records, or resample \
         them to longer intervals", plain(*interval)
    )]
    TooLong {
        /// Number of samples of all of it.
        samples: usize,
        /// Their common interval, s.
        interval: f64,
    },
}

impl GroundMotion {
    /// This motion and then the `aftershocks`, each after its rest (s) of still ground.
    ///
    /// A shock falls to zero within one interval after its last sample, stays zero for the rest, and the next shock rises from zero to
    /// its first sample within one interval of its own, the longer one of its components. It begins when the rest ends. The rest is
    /// rounded up to whole intervals. Motions with equal intervals keep their samples. Otherwise all components get the longest
    /// interval that divides each of them, and the values in between are those of the straight lines between the samples: the motion
    /// is the same, and no sample is lost. Intervals are compared to 1e-4, as printed times are rounded. A component that a shock
    /// does not have is zero.
    ///
    /// ```
    /// use cofferdam_motion::GroundMotion;
    ///
    /// let of = |interval, samples| GroundMotion::of_samples("r.csv", interval, samples);
    /// let motion = of(0.5, vec![1.0, 2.0]).followed_by(&[(1.0, of(0.25, vec![-4.0]))])?;
    /// // 1 s of rest from 1 s on, when the first record has fallen to zero
    /// assert_eq!(motion.acceleration(), [1.0, 1.5, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -4.0]);
    /// assert_eq!((motion.interval(), motion.begins()), (0.25, vec![0.0, 2.0]));
    /// # Ok::<(), cofferdam_motion::SequenceError>(())
    /// ```
    ///
    /// **Errors**: [`SequenceError`].
    pub fn followed_by(self, aftershocks: &[(f64, Self)]) -> Result<Self, SequenceError> {
        if aftershocks.is_empty() {
            return Ok(self);
        }
        let all =
            || std::iter::once((0.0, &self)).chain(aftershocks.iter().map(|(rest, shock)| (*rest, shock)));
        let intervals: Vec<f64> =
            all().flat_map(|(_, shock)| shock.components().map(Component::interval)).collect();
        let interval = common_interval(&intervals)?;
        let parts = |component: &Component| (component.interval() / interval).round() as usize;
        let (mut begins, mut tracks, mut sources) =
            (Vec::new(), [Vec::new(), Vec::new()], [const { Vec::new() }; 2]);
        let mut still = 0;
        for (number, (rest, shock)) in all().enumerate() {
            let mut first = 0;
            if number > 0 {
                let begin = still + (rest / interval - 1e-6).ceil().max(0.0) as usize;
                begins.push(begin as f64 * interval);
                first = begin + shock.components().map(parts).max().unwrap_or(1);
            }
            let end = |component: &Component| first + component.acceleration().len() * parts(component);
            still = shock.components().map(end).max().unwrap_or(first);
            if still > MOST_SAMPLES {
                return Err(SequenceError::TooLong { samples: still, interval });
            }
            for (axis, component) in
                [Some(&shock.horizontal), shock.vertical.as_ref()].into_iter().enumerate()
            {
                if let Some(component) = component {
                    append(&mut tracks[axis], component.acceleration(), first, parts(component));
                }
                let source = component.map_or("none", Component::source);
                sources[axis].push(match number {
                    0 => source.to_owned(),
                    _ => format!("then {source} after {} s", plain(rest)),
                });
            }
        }
        let has_vertical = all().any(|(_, shock)| shock.vertical.is_some());
        let [horizontal, vertical] = tracks;
        let joined =
            |samples, axis: usize| Component::of_samples(&sources[axis].join(", "), interval, samples);
        Ok(Self {
            horizontal: Component { file: self.horizontal.file.clone(), ..joined(horizontal, 0) },
            vertical: has_vertical.then(|| joined(vertical, 1)),
            aftershocks: begins,
        })
    }

    /// The same, in which shocks after the first begin at these times, s.
    #[must_use]
    pub fn with_aftershocks(self, aftershocks: Vec<f64>) -> Self {
        Self { aftershocks, ..self }
    }

    /// Times at which the shocks after the first begin, s.
    pub fn aftershocks(&self) -> &[f64] {
        &self.aftershocks
    }

    /// Times at which the shocks begin, s; the first is 0.
    pub fn begins(&self) -> Vec<f64> {
        std::iter::once(0.0).chain(self.aftershocks.iter().copied()).collect()
    }

    /// Each shock by itself, in time from its begin, without the zeros after it; a motion without aftershocks as it is.
    pub fn shocks(&self) -> Vec<Self> {
        if self.aftershocks.is_empty() {
            return vec![self.clone()];
        }
        let part = |component: &Component, range: Range<usize>| {
            let mut samples = component.acceleration()[range].to_vec();
            while samples.last() == Some(&0.0) {
                samples.pop();
            }
            Component::of_samples(component.source(), component.interval(), samples)
        };
        let horizontal = self.ranges(&self.horizontal).into_iter().map(|range| part(&self.horizontal, range));
        let mut shocks: Vec<Self> = horizontal.map(Self::from).collect();
        if let Some(vertical) = &self.vertical {
            for (shock, range) in shocks.iter_mut().zip(self.ranges(vertical)) {
                let own = part(vertical, range);
                shock.vertical = (!own.acceleration().is_empty()).then_some(own);
            }
        }
        for shock in shocks.iter_mut().filter(|shock| shock.horizontal.acceleration.is_empty()) {
            shock.horizontal.acceleration.push(0.0);
        }
        shocks
    }

    /// The samples of each shock in a component, from its begin to that of the next.
    pub(super) fn ranges(&self, component: &Component) -> Vec<Range<usize>> {
        let count = component.acceleration().len();
        let mut last = 0;
        let mut place = |begin: &f64| {
            last = ((begin / component.interval()).round() as usize).clamp(last, count);
            last
        };
        let ends: Vec<usize> = self.aftershocks.iter().map(&mut place).chain([count]).collect();
        let begins: Vec<usize> = std::iter::once(0).chain(ends.iter().copied()).collect();
        begins.into_iter().zip(ends).map(|(begin, end)| begin..end).collect()
    }
}

/// The samples of a shock, the first at index `first`, with so many `parts` from one to the next; it rises from zero unless it is the first.
fn append(track: &mut Vec<f64>, samples: &[f64], first: usize, parts: usize) {
    let line = |from: f64, to: f64| (1..parts).map(move |k| from + k as f64 / parts as f64 * (to - from));
    if first > 0 {
        track.resize(first + 1 - parts, 0.0);
        track.extend(line(0.0, samples.first().copied().unwrap_or(0.0)));
    }
    for (index, sample) in samples.iter().enumerate() {
        track.push(*sample);
        track.extend(line(*sample, samples.get(index + 1).copied().unwrap_or(0.0)));
    }
}

/// The longest interval that divides each of these, s.
fn common_interval(intervals: &[f64]) -> Result<f64, SequenceError> {
    let near = |ratio: f64| (ratio - ratio.round()).abs() <= ROUNDING * ratio && ratio.round() >= 1.0;
    let first = intervals.first().copied().unwrap_or(1.0);
    let mut common = first;
    for &other in intervals {
        let parts = (1..=MOST_PARTS).find(|parts| near(other / common * *parts as f64));
        let parts = parts.ok_or(SequenceError::Intervals { first, other })?;
        common /= parts as f64;
    }
    let parts = |interval: f64| (interval / common).round();
    if let Some(other) = intervals.iter().find(|interval| parts(**interval) > MOST_PARTS as f64) {
        let [shortest, longest] = [f64::min, f64::max].map(|of| intervals.iter().copied().fold(*other, of));
        return Err(SequenceError::Intervals { first: shortest, other: longest });
    }
    // without rounding where one of them is the common one
    Ok(intervals.iter().copied().find(|interval| parts(*interval) == 1.0).unwrap_or(common))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(interval: f64, samples: &[f64]) -> GroundMotion {
        GroundMotion::of_samples("r", interval, samples.to_vec())
    }

    #[test]
    fn equal_intervals_keep_the_samples_with_zeros_between() -> Result<(), SequenceError> {
        let (first, second) = (motion(0.1, &[0.3, -0.7, 0.2]), motion(0.1, &[0.0, 0.9]));
        let joined = first.clone().followed_by(&[(0.2, second.clone()), (0.0, second.clone())])?;
        let zero = 0.0;
        assert_eq!(
            joined.acceleration(),
            // fall, rest, and again; without a rest there is one zero
            [0.3, -0.7, 0.2, zero, zero, zero, 0.0, 0.9, zero, 0.0, 0.9]
        );
        assert_eq!(joined.begins(), [0.0, 5.0 * 0.1, 8.0 * 0.1]);
        assert_eq!(joined.source(), "r, then r after 0.2 s, then r after 0 s");
        // until the second shock begins, it is the first to the bit
        for n in 0..=500 {
            let time = 1e-3 * f64::from(n);
            assert_eq!(joined.at(time), first.at(time), "at {time}");
        }
        // begins that no motion has, as a damaged log may tell
        for begins in [vec![1.0, 0.2], vec![f64::NAN, 1e300, -1.0]] {
            assert!(joined.clone().with_aftershocks(begins).shocks().len() > 2);
        }
        // a rest that is no whole number of intervals is rounded up
        let longer = first.clone().followed_by(&[(0.21, second.clone())])?;
        assert_eq!(longer.begins()[1], 6.0 * 0.1);
        assert_eq!(first.clone().followed_by(&[])?, first);
        let shocks = joined.shocks();
        assert_eq!(shocks.len(), 3);
        assert_eq!(shocks[0].acceleration(), first.acceleration());
        assert_eq!(shocks[1].acceleration(), [0.0, 0.0, 0.9]);
        Ok(())
    }

    #[test]
    fn different_intervals_give_the_same_straight_lines() -> Result<(), SequenceError> {
        // 0.02 = 2 · 0.01, a common part of 0.01 and 0.0078125 is 0.0003125, of 0.01 and 0.004 it is 0.002
        for (intervals, common) in [
            ([0.02, 0.01], 0.01),
            ([0.01, 0.02], 0.01),
            ([0.01, 0.0078125], 0.0003125),
            ([0.01, 0.004], 0.002),
        ] {
            let samples = [0.5, -1.0, 2.0, 0.25];
            let [first, second] = intervals.map(|interval| motion(interval, &samples));
            let joined = first.clone().followed_by(&[(0.1, second.clone())])?;
            assert!((joined.interval() / common - 1.0).abs() < 1e-12, "{intervals:?}: {}", joined.interval());
            let begin = joined.begins()[1];
            let still = 4.0 * intervals[0] + 0.1;
            assert!((begin - still).abs() < common, "{begin} {still}");
            for n in 0..2000 {
                let time = 1e-4 * f64::from(n);
                let later = begin + intervals[1] + time;
                let error =
                    [joined.at(time)[0] - first.at(time)[0], joined.at(later)[0] - second.at(time)[0]];
                if time < begin {
                    assert!(error[0].abs() < 1e-9, "{intervals:?}: off by {error:?} at {time}");
                }
                assert!(error[1].abs() < 1e-9, "{intervals:?}: off by {error:?} at {time} of the second");
            }
            // every sample is there
            assert_eq!((joined.peak().0, joined.shocks()[1].peak().0), (2.0, 2.0));
            let [a, b] = [first.arias_intensity().0, joined.shocks()[0].arias_intensity().0];
            assert!(a > 0.0 && b > 0.0);
        }
        Ok(())
    }

    #[test]
    fn components_stay_together_and_missing_ones_are_zero() -> Result<(), SequenceError> {
        let up = |interval, samples: &[f64]| Some(Component::of_samples("up", interval, samples.to_vec()));
        let both = motion(0.2, &[1.0, 2.0]).with_vertical(up(0.1, &[3.0, 4.0, 5.0, 6.0, 7.0]));
        let level = motion(0.2, &[8.0]);
        let joined = both.clone().followed_by(&[(0.1, level.clone()), (0.0, both.clone())])?;
        // the vertical component ends last, at 0.5 s; the horizontal one falls from 0.2 s to 0.4 s
        let begins = joined.begins();
        assert!((begins[1] - 0.6).abs() < 1e-12 && (begins[2] - 1.0).abs() < 1e-12, "{begins:?}");
        let vertical = joined.vertical().expect("a component").acceleration();
        assert_eq!(&vertical[..5], [3.0, 4.0, 5.0, 6.0, 7.0]);
        assert!(vertical[5..12].iter().all(|a| *a == 0.0), "{vertical:?}");
        assert_eq!(&vertical[12..], [3.0, 4.0, 5.0, 6.0, 7.0]);
        assert_eq!(
            &joined.acceleration()[..13],
            [1.0, 1.5, 2.0, 1.0, 0.0, 0.0, 0.0, 4.0, 8.0, 4.0, 0.0, 0.5, 1.0]
        );
        let shocks = joined.shocks();
        assert_eq!(
            shocks.iter().map(|shock| shock.vertical().is_some()).collect::<Vec<_>>(),
            [true, false, true]
        );
        let reversed = level.followed_by(&[(0.0, both)])?;
        assert!(reversed.vertical().is_some_and(|vertical| vertical.acceleration()[..2] == [0.0, 0.0]));
        Ok(())
    }

    #[test]
    fn intervals_without_a_common_part_and_endless_rests_are_refused() {
        let of = |intervals: [f64; 2], rest| {
            let [first, second] = intervals.map(|interval| motion(interval, &[1.0, 2.0]));
            first.followed_by(&[(rest, second)])
        };
        assert!(matches!(of([0.9, 0.001], 1.0), Err(SequenceError::Intervals { .. })));
        assert!(matches!(of([0.001, 0.9], 1.0), Err(SequenceError::Intervals { .. })));
        assert!(matches!(of([0.01, 0.01], 1e6), Err(SequenceError::TooLong { samples: 100_000_005, .. })));
        // rounding of printed times is no other interval
        assert_eq!(of([0.01, 0.0100001], 1.0).map(|motion| motion.interval()), Ok(0.01));
    }
}
