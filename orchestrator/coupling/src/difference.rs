//! The first difference between two series of exchanges, bit for bit.

use crate::participant::{Layout, Occasion};
use std::fmt;

/// Request or answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// The request to a unit.
    Request,
    /// Its answer.
    Answer,
}

impl fmt::Display for Half {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if *self == Self::Request { "request" } else { "answer" })
    }
}

/// The first place where two series of exchanges differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Divergence {
    /// Name of the unit in the first series.
    pub unit: String,
    /// Its step.
    pub occasion: Occasion,
    /// Exchanges before, all identical.
    pub before: u64,
    /// What differs.
    pub what: Difference,
}

/// What differs between two exchanges.
#[derive(Clone, Debug, PartialEq)]
pub enum Difference {
    /// A value.
    Value {
        /// Request or answer.
        half: Half,
        /// Name of the variable.
        variable: String,
        /// Index of the value in an array, from 0; `None` for a scalar.
        index: Option<usize>,
        /// The two values.
        values: [f64; 2],
    },
    /// Only one unit gave an answer; the other failed.
    Answer {
        /// Whether it was the unit of the first series.
        first: bool,
    },
    /// The units exchange different variables or numbers of values.
    Layout {
        /// Request or answer.
        half: Half,
    },
    /// The next request was to another unit or for another step.
    Asked {
        /// Name of the unit in the second series.
        unit: String,
        /// Its step.
        occasion: Occasion,
    },
}

/// Units in the last place between two numbers: how many steps from one `f64` to the next lead from `a` to `b`;
/// `None` if one is NaN, which has no place in the order.
///
/// Numbers are ordered by [`f64::total_cmp`]: −0 and +0 are 1 apart, so that 0 means equal bits; infinity is 1 from
/// the largest finite number.
pub fn ulps(a: f64, b: f64) -> Option<u64> {
    // The bits of negative numbers increase away from zero.
    let ordered = |x: f64| {
        let bits = x.to_bits() as i64;
        if bits < 0 { !(bits & i64::MAX) } else { bits }
    };
    (!a.is_nan() && !b.is_nan()).then(|| ordered(a).abs_diff(ordered(b)))
}

impl Difference {
    /// The first value whose bits differ, by name and index in `layout`.
    pub fn of_values(half: Half, layout: &Layout, first: &[f64], second: &[f64]) -> Option<Self> {
        let position = first.iter().zip(second).position(|(a, b)| a.to_bits() != b.to_bits())?;
        let (channel, range) = layout.channels().find(|(_, range)| range.contains(&position))?;
        let index = channel.shape.is_array().then_some(position - range.start);
        let values = [first[position], second[position]];
        Some(Self::Value { half, variable: channel.name.clone(), index, values })
    }
}

impl Divergence {
    /// The divergence in words; `names` are those of the two series.
    pub fn report<'a>(&'a self, names: [&'a str; 2]) -> impl fmt::Display + 'a {
        Report { divergence: self, names }
    }
}

struct Report<'a> {
    divergence: &'a Divergence,
    names: [&'a str; 2],
}

impl fmt::Display for Report<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Divergence { unit, occasion, before, what } = self.divergence;
        let ([first, second], width) = (self.names, self.names[0].len().max(self.names[1].len()));
        write!(f, "{unit}: different {occasion}")?;
        if occasion.step > 0 {
            write!(f, ", attempt {}", occasion.attempt)?;
        }
        writeln!(f, ", after {before} identical exchanges")?;
        match what {
            Difference::Value { half, variable, index, values } => {
                write!(f, "  {half}, {variable}")?;
                index.map_or(Ok(()), |index| write!(f, "[{index}]"))?;
                writeln!(f)?;
                for (name, value) in self.names.iter().zip(values) {
                    write!(f, "    {name:<width$}  {value:?}")?;
                    if value.is_nan() {
                        write!(f, " ({:#018x})", value.to_bits())?;
                    }
                    writeln!(f)?;
                }
                match ulps(values[0], values[1]) {
                    Some(1) => f.write_str("    1 ulp apart"),
                    Some(ulps) => {
                        let relative = (values[1] - values[0]).abs() / values[0].abs();
                        write!(f, "    {ulps} ulps apart")?;
                        if relative.is_finite() { write!(f, ", {relative:.1e} of the first") } else { Ok(()) }
                    }
                    None => f.write_str("    not comparable"),
                }
            }
            Difference::Answer { first: true } => write!(f, "  {first} has an answer, {second} has none"),
            Difference::Answer { first: false } => write!(f, "  {first} has no answer, {second} has one"),
            Difference::Layout { half } => {
                write!(f, "  {half}s of the two hold other variables, or other numbers of values")
            }
            Difference::Asked { unit: other, occasion } => {
                write!(f, "  {first} asks the {unit} here, {second} asks the {other} {occasion}")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ulps_count_the_numbers_between() {
        let least = f64::from_bits(1);
        for (a, b, distance) in [
            (1.0, 1.0 + f64::EPSILON, 1),
            (1.0, 1.0 - f64::EPSILON, 2),
            (-1.0, -1.0 - f64::EPSILON, 1),
            (2.0, 1.0, 1 << 52),
            (0.0, -0.0, 1),
            (0.0, least, 1),
            (-0.0, -least, 1),
            (-least, least, 3),
            (f64::MAX, f64::INFINITY, 1),
            (f64::NEG_INFINITY, f64::INFINITY, 2 * (0x7ff << 52) + 1),
        ] {
            assert_eq!([ulps(a, b), ulps(b, a)], [Some(distance); 2], "{a:e} and {b:e}");
            assert_eq!([ulps(a, a), ulps(b, b)], [Some(0); 2]);
        }
        assert_eq!([ulps(f64::NAN, 1.0), ulps(f64::NAN, f64::NAN)], [None; 2]);
    }
}
