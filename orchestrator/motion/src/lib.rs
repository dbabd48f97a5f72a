//! Ground motions: records and ramps, their spectra and intensities, and factors that fit them to a target spectrum.
//!
//! A record is a list of equally spaced accelerations, linear in between. Files are CSV or PEER AT2, in g, m/s² or cm/s²; whatever
//! is read becomes m/s². The response spectrum is exact for accelerations that are constant over each interval.
//!
//! ```
//! use cofferdam_motion::GroundMotion;
//!
//! // A sine of 1 m/s² and 2 Hz for 20 s: an oscillator of 0.5 s and 5 % amplifies it by 1/(2ξ) = 10.
//! let sine = (0..2000).map(|i| (std::f64::consts::TAU * 2.0 * 0.01 * f64::from(i)).sin()).collect();
//! let motion = GroundMotion::of_samples("sine", 0.01, sine);
//! let resonance = motion.response_spectrum(&[0.5], 0.05)[0];
//! assert!((resonance - 10.0).abs() < 0.1, "{resonance}");
//! assert!((motion.peak().0.abs() - 1.0).abs() < 2e-3);
//! ```

mod baseline;
mod component;
mod header;
mod intensity;
mod noise;
mod record;
mod response_spectrum;
mod sequence;
mod spectrum;
mod target_spectrum;
pub mod text_file;
mod units;

pub use component::{Component, Excerpt, RecordFile};
pub use record::{Record, RecordError, STRONGEST};
pub use response_spectrum::response_spectrum;
pub use sequence::SequenceError;
pub use target_spectrum::{SpectralFit, TargetError, TargetSpectrum, compared_periods};
pub use units::{STANDARD_GRAVITY, Units};

use std::path::Path;

/// Acceleration of the ground: horizontal and, where there is one, vertical.
///
/// What has one value is that of the horizontal component: peak, samples, spectra, intensities.
///
/// ```
/// use cofferdam_motion::{Component, GroundMotion};
///
/// let motion = GroundMotion::of_samples("x", 0.5, vec![0.0, 2.0]);
/// assert_eq!(motion.at(0.25), [1.0, 0.0]);
/// let motion = motion.with_vertical(Some(Component::of_samples("y", 0.25, vec![0.0, 3.0, 6.0])));
/// assert_eq!((motion.at(0.25), motion.peak().0), ([1.0, 3.0], 2.0));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct GroundMotion {
    horizontal: Component,
    vertical: Option<Component>,
    /// Times at which the shocks after the first begin, s.
    aftershocks: Vec<f64>,
}

impl From<Component> for GroundMotion {
    /// Horizontal motion alone.
    fn from(horizontal: Component) -> Self {
        Self { horizontal, vertical: None, aftershocks: Vec::new() }
    }
}

impl GroundMotion {
    /// Horizontal motion by a record from its file, whose accelerations are in `units`, else in what its header says, else in g, cropped
    /// to `start`–`end` (s, both within the record), times `factor`.
    pub fn from_record(
        path: &Path,
        units: Option<Units>,
        start: f64,
        end: f64,
        factor: f64,
    ) -> Result<Self, RecordError> {
        let excerpt = Excerpt { units, start, end, factor, ..Excerpt::whole(path) };
        Component::from_record(&excerpt).map(Self::from)
    }

    /// A horizontal ramp from 0 to `acceleration` (m/s²) over `rise` (s), then held.
    pub fn ramp(acceleration: f64, rise: f64) -> Self {
        Component::ramp(acceleration, rise).into()
    }

    /// Horizontal motion by equally spaced samples (m/s²), `interval` (s) apart, zero afterwards.
    pub fn of_samples(source: &str, interval: f64, acceleration: Vec<f64>) -> Self {
        Component::of_samples(source, interval, acceleration).into()
    }

    /// The same with this vertical component.
    #[must_use]
    pub fn with_vertical(self, vertical: Option<Component>) -> Self {
        Self { vertical, ..self }
    }

    /// The horizontal component, positive downstream.
    pub fn horizontal(&self) -> &Component {
        &self.horizontal
    }

    /// The vertical component, positive upwards.
    pub fn vertical(&self) -> Option<&Component> {
        self.vertical.as_ref()
    }

    /// The components, the horizontal one first.
    pub fn components(&self) -> impl Iterator<Item = &Component> {
        std::iter::once(&self.horizontal).chain(&self.vertical)
    }

    /// The same with every sample after `time` (s) moved by what `change` (m/s²) gives for the magnitude of its component's peak (m/s²).
    pub fn moved_after(&self, time: f64, mut change: impl FnMut(f64) -> f64) -> Self {
        let horizontal = self.horizontal.moved_after(time, &mut change);
        let vertical = self.vertical.as_ref().map(|vertical| vertical.moved_after(time, &mut change));
        Self { horizontal, vertical, aftershocks: self.aftershocks.clone() }
    }

    /// The same, its last horizontal sample held from there on.
    pub fn held(self) -> Self {
        Self { horizontal: self.horizontal.held(), ..self }
    }

    /// Whether the last horizontal sample is held.
    pub fn is_held(&self) -> bool {
        self.horizontal.is_held()
    }

    /// Where the horizontal component came from.
    pub fn source(&self) -> &str {
        self.horizontal.source()
    }

    /// The file of a horizontal record, the first of a sequence.
    pub fn file(&self) -> Option<&RecordFile> {
        self.horizontal.file()
    }

    /// Time between two horizontal samples, s.
    pub fn interval(&self) -> f64 {
        self.horizontal.interval()
    }

    /// The horizontal samples, m/s².
    pub fn acceleration(&self) -> &[f64] {
        self.horizontal.acceleration()
    }

    /// The horizontal sample that is farthest from zero, m/s², and its time, s.
    pub fn peak(&self) -> (f64, f64) {
        self.horizontal.peak()
    }

    /// Magnitude of the largest peak of a component, m/s².
    pub fn largest(&self) -> f64 {
        self.components().map(Component::largest).fold(0.0, f64::max)
    }

    /// Time of the last sample of any component, s.
    pub fn duration(&self) -> f64 {
        self.components().map(Component::duration).fold(0.0, f64::max)
    }

    /// Time from which on the ground does not accelerate, s; `None` if it never ends.
    pub fn rest_from(&self) -> Option<f64> {
        self.components().try_fold(0.0, |rest: f64, component| Some(rest.max(component.rest_from()?)))
    }

    /// Acceleration (x, y) at `time` (s), m/s²; after a record it falls to zero within one interval.
    pub fn at(&self, time: f64) -> [f64; 2] {
        [self.horizontal.at(time), self.vertical.as_ref().map_or(0.0, |vertical| vertical.at(time))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn acceleration_is_linear_between_samples_and_ends_at_zero() {
        let motion = GroundMotion::of_samples("", 0.5, vec![1.0, 3.0, -2.0]);
        for (time, value) in [(0.0, 1.0), (0.25, 2.0), (1.0, -2.0), (1.25, -1.0), (1.5, 0.0), (9.0, 0.0)] {
            assert_eq!(motion.at(time), [value, 0.0], "at {time}");
        }
        assert_eq!(motion.rest_from(), Some(1.5));
        let ramp = GroundMotion::ramp(-2.0, 0.1);
        assert_eq!(ramp.rest_from(), None);
        assert_eq!([ramp.at(0.05)[0], ramp.at(0.1)[0], ramp.at(5.0)[0]], [-1.0, -2.0, -2.0]);
    }

    #[test]
    fn components_have_their_own_clocks_and_end_apart() {
        let horizontal = GroundMotion::of_samples("x", 0.5, vec![1.0, 3.0, -2.0]);
        let vertical = Component::of_samples("y", 0.25, vec![0.0, 4.0, 8.0]);
        let both = horizontal.clone().with_vertical(Some(vertical.clone()));
        for (time, value) in [(0.0, [1.0, 0.0]), (0.25, [2.0, 4.0]), (0.625, [1.75, 4.0]), (1.0, [-2.0, 0.0])]
        {
            assert_eq!(both.at(time), value, "at {time}");
        }
        // The horizontal component ends later, and what has one value is its own.
        assert_eq!((both.rest_from(), both.duration()), (Some(1.5), 1.0));
        assert_eq!((both.peak(), both.largest()), ((3.0, 0.5), 8.0));
        assert_eq!(
            (both.drift(), both.arias_intensity()),
            (horizontal.drift(), horizontal.arias_intensity())
        );
        let longer = horizontal.clone().with_vertical(Some(Component::of_samples("y", 0.5, vec![1.0; 9])));
        assert_eq!((longer.rest_from(), longer.duration()), (Some(4.5), 4.0));
        let held = horizontal.clone().with_vertical(Some(vertical.held()));
        assert_eq!((held.rest_from(), held.at(99.0)), (None, [0.0, 8.0]));
        let moved = both.moved_after(0.3, |peak| peak);
        assert_eq!((moved.at(0.5), moved.at(1.0), moved.at(0.25)), ([6.0, 16.0], [1.0, 0.0], [3.5, 4.0]));
        // Perturbed alike: the horizontal samples do not depend on the vertical ones, and these are not the same noise.
        let noisy = [&both, &horizontal].map(|motion| motion.with_noise(0.1, 7));
        assert_eq!(noisy[0].horizontal(), noisy[1].horizontal());
        assert_ne!(noisy[0].vertical(), both.vertical());
    }

    #[test]
    fn a_record_may_have_several_columns() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("r.csv");
        std::fs::write(&path, "time_s,x [g],y [cm/s2]\n0,0.1,10\n0.01,0.2,20\n0.02,0.3,30\n0.03,0.4,40\n")?;
        let of = |column, start, follows| {
            let excerpt = Excerpt { column, start, follows, ..Excerpt::whole(&path) };
            Component::from_record(&excerpt)
        };
        let x = of(Some(1), 0.0, false)?;
        assert!(
            (x.acceleration()[3] - 0.4 * STANDARD_GRAVITY).abs() < 1e-12 && x.source() == "r.csv, column 1"
        );
        // Its header has a unit for each column.
        let y = of(Some(2), 0.01, true)?;
        assert!((y.acceleration()[0] - 0.2).abs() < 1e-12 && y.acceleration().len() == 3, "{y:?}");
        assert!(matches!(of(None, 0.0, false), Err(RecordError::Columns { columns: 2, line: 2, .. })));
        assert!(matches!(of(Some(3), 0.0, false), Err(RecordError::Column { column: 3, columns: 2, .. })));
        assert!(matches!(of(Some(2), 0.015, true), Err(RecordError::Clock { .. })));
        assert!(of(Some(2), 0.015, false).is_ok());
        let at2 = folder.path().join("r.at2");
        std::fs::write(&at2, "PEER\nevent\nunits of g\nNPTS=   3, DT=  .0200 SEC\n .1 .2 .3\n")?;
        let series = Component::from_record(&Excerpt { column: Some(1), ..Excerpt::whole(&at2) });
        assert!(matches!(series, Err(RecordError::NoColumns { .. })), "{series:?}");
        Ok(())
    }

    #[test]
    fn the_same_motion_in_three_units_is_the_same() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("r.csv");
        for (units, sample) in [
            (Units::Gravity, 0.2),
            (Units::Metres, 0.2 * STANDARD_GRAVITY),
            (Units::Centimetres, 20.0 * STANDARD_GRAVITY),
        ] {
            std::fs::write(&path, format!("0,0\n0.01,{sample}\n0.02,0\n"))?;
            let motion = GroundMotion::from_record(&path, Some(units), 0.0, f64::INFINITY, -1.5)?;
            assert!((motion.acceleration()[1] + 0.3 * STANDARD_GRAVITY).abs() < 1e-15, "{units}");
        }
        // 200 m/s² are no 200 g.
        std::fs::write(&path, "0,0\n0.01,200\n")?;
        assert!(GroundMotion::from_record(&path, Some(Units::Metres), 0.0, f64::INFINITY, 1.0).is_ok());
        let refused = GroundMotion::from_record(&path, None, 0.0, f64::INFINITY, 1.0);
        assert!(matches!(refused, Err(RecordError::TooStrong { units: Units::Gravity, .. })), "{refused:?}");
        Ok(())
    }
}
