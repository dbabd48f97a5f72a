//! The variables that two layouts have in common.

use cofferdam_coupling::difference::{Difference, Half};
use cofferdam_coupling::participant::Layout;
use std::ops::Range;

/// The variables that two layouts have in common, in the order of the first.
#[derive(Clone, Debug)]
pub struct Alignment {
    /// Variables of the same name whose size or unit differs.
    pub unlike: Vec<String>,
    /// Variables that only the first layout has, and only the second.
    pub lonely: [Vec<String>; 2],
    /// The common variables, one after another.
    layout: Layout,
    /// Their places in both layouts.
    places: Vec<[Range<usize>; 2]>,
}

impl Alignment {
    /// Of two layouts.
    pub fn of(first: &Layout, second: &Layout) -> Self {
        let (mut unlike, mut channels, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for (channel, place) in first.channels() {
            match second.channels().find(|(other, _)| other.name == channel.name) {
                Some((other, there)) if (other.size, &other.unit) == (channel.size, &channel.unit) => {
                    channels.push(channel.clone());
                    places.push([place, there]);
                }
                Some(_) => unlike.push(channel.name.clone()),
                None => {}
            }
        }
        let lonely = |layout: &Layout, other: &Layout| {
            let names = layout.channels().map(|(channel, _)| channel.name.clone());
            names.filter(|name| other.range(name).is_none()).collect()
        };
        let lonely = [lonely(first, second), lonely(second, first)];
        Self { unlike, lonely, layout: Layout::new(channels), places }
    }

    /// Whether nothing but additional variables keeps the two apart, and there is something to compare.
    pub fn fits(&self) -> bool {
        self.unlike.is_empty() && (!self.places.is_empty() || self.lonely.iter().all(Vec::is_empty))
    }

    /// The first common value whose bits differ.
    pub fn difference(&self, half: Half, first: &[f64], second: &[f64]) -> Option<Difference> {
        let gathered = |values: &[f64], side: usize| -> Vec<f64> {
            let places = self.places.iter().map(|places| places[side].clone());
            places.flat_map(|place| values.get(place).unwrap_or_default()).copied().collect()
        };
        let equal = |[a, b]: &[Range<usize>; 2]| {
            let [a, b] = [first.get(a.clone()), second.get(b.clone())].map(Option::unwrap_or_default);
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
        };
        if self.places.iter().all(equal) {
            return None;
        }
        Difference::of_values(half, &self.layout, &gathered(first, 0), &gathered(second, 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cofferdam_coupling::participant::Channel;

    fn layout(channels: &[(&str, &str, usize)]) -> Layout {
        Layout::new(channels.iter().map(|(name, unit, size)| Channel::new(name, unit, *size)).collect())
    }

    #[test]
    fn common_variables_are_compared_wherever_they_lie() {
        let first = layout(&[("flow", "m3/s", 1), ("level", "m", 2), ("old", "1", 1)]);
        let second = layout(&[("new", "1", 1), ("level", "m", 2), ("flow", "m3/s", 1)]);
        let alignment = Alignment::of(&first, &second);
        assert!(alignment.fits());
        assert_eq!(alignment.lonely, [vec!["old".to_owned()], vec!["new".to_owned()]]);
        let values = [[1.0, 2.0, 3.0, 4.0], [9.0, 2.0, 3.0, 1.0]];
        assert_eq!(alignment.difference(Half::Answer, &values[0], &values[1]), None);
        let other = [9.0, 2.0, 3.5, 1.0];
        let difference = alignment.difference(Half::Answer, &values[0], &other);
        let (half, variable, index) = (Half::Answer, "level".to_owned(), Some(1));
        assert_eq!(difference, Some(Difference::Value { half, variable, index, values: [3.0, 3.5] }));
    }

    #[test]
    fn another_size_or_unit_does_not_fit() {
        let level = layout(&[("level", "m", 2)]);
        for (channels, unlike) in [
            (&[("level", "m", 3)][..], &["level"][..]),
            (&[("level", "mm", 2)], &["level"]),
            (&[("flow", "m3/s", 1)], &[]),
        ] {
            let alignment = Alignment::of(&level, &layout(channels));
            assert!(!alignment.fits());
            assert_eq!(alignment.unlike, unlike);
        }
        assert!(Alignment::of(&layout(&[]), &layout(&[])).fits(), "nothing on either side");
    }
}
