use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Number of cells, or of contacts, that are evaluated together.
pub(crate) const LANES: usize = 8;

/// A real number, or one real number in each lane of a SIMD register.
///
/// Formulas that are generic over this trait stand once and are computed for one contact (`f64`) or for as many contacts as
/// a register holds. Operations act on each lane separately, follow IEEE 754 and are never fused: results have the same bits for
/// every number of lanes. Instead of `if`, a formula uses comparisons and [`Mask::select`].
///
/// ```
/// use cofferdam_dam::contact::{Mask, Real};
///
/// /// `√x` where x is positive, else 0.
/// fn root<N: Real>(x: N) -> N {
///     let zero = x.constant(0.0);
///     zero.less_than(x).select(x.sqrt(), zero)
/// }
/// assert_eq!([root(4.0), root(-4.0)], [2.0, 0.0]);
/// ```
///
/// The trait is sealed.
pub trait Real:
    sealed::Sealed
    + Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + Neg<Output = Self>
{
    /// Result of a comparison.
    type Mask: Mask<Self>;

    /// `value` in every lane.
    fn constant(self, value: f64) -> Self;

    /// `value` in every lane, as a mask.
    fn mask(self, value: bool) -> Self::Mask;

    /// Absolute value.
    fn abs(self) -> Self;

    /// Square root.
    fn sqrt(self) -> Self;

    /// `self < other`.
    fn less_than(self, other: Self) -> Self::Mask;

    /// `self ≤ other`.
    fn at_most(self, other: Self) -> Self::Mask;

    /// `self = other`.
    fn equals(self, other: Self) -> Self::Mask;

    /// `self` where it is positive, else 0; 0 for NaN.
    #[inline(always)]
    fn positive_part(self) -> Self {
        let zero = self.constant(0.0);
        zero.less_than(self).select(self, zero)
    }

    /// `self` where it is negative, else 0; 0 for NaN.
    #[inline(always)]
    fn negative_part(self) -> Self {
        let zero = self.constant(0.0);
        self.less_than(zero).select(self, zero)
    }

    /// `self`, limited to ± `limit`. NaN stays NaN.
    #[inline(always)]
    fn within(self, limit: Self) -> Self {
        // a comparison each, where `min` and `max`, which look for NaN and hide it, take five instructions
        let value = limit.less_than(self).select(limit, self);
        let lowest = -limit;
        value.less_than(lowest).select(lowest, value)
    }

    /// Number of lanes.
    #[doc(hidden)]
    const LANES: usize;

    /// The numbers in the lanes, and 0 beyond.
    #[doc(hidden)]
    fn to_lanes(self) -> [f64; LANES];

    /// A number like this one with these numbers in the lanes.
    #[doc(hidden)]
    fn with_lanes(self, lanes: [f64; LANES]) -> Self;
}

/// One truth value for each lane of a [`Real`].
pub trait Mask<N>:
    sealed::Sealed + Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// `yes` where the mask is true, `no` elsewhere. Both are computed for all lanes.
    fn select(self, yes: N, no: N) -> N;

    /// Whether the mask is true in any lane.
    fn any(self) -> bool;

    /// Whether the mask is true in all lanes.
    #[inline(always)]
    fn all(self) -> bool {
        !(!self).any()
    }
}

pub(crate) mod sealed {
    pub trait Sealed {}
}

impl sealed::Sealed for f64 {}
impl sealed::Sealed for bool {}

impl Real for f64 {
    type Mask = bool;
    const LANES: usize = 1;

    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn mask(self, value: bool) -> bool {
        value
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn less_than(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> bool {
        self <= other
    }

    #[inline(always)]
    fn equals(self, other: Self) -> bool {
        self == other
    }

    #[inline(always)]
    fn to_lanes(self) -> [f64; LANES] {
        let mut lanes = [0.0; LANES];
        lanes[0] = self;
        lanes
    }

    #[inline(always)]
    fn with_lanes(self, lanes: [f64; LANES]) -> Self {
        lanes[0]
    }
}

impl Mask<f64> for bool {
    #[inline(always)]
    fn select(self, yes: f64, no: f64) -> f64 {
        if self { yes } else { no }
    }

    #[inline(always)]
    fn any(self) -> bool {
        self
    }
}

#[cfg(test)]
mod tests {
    use super::Real;

    #[test]
    fn limits_hold_and_nan_stays_nan() {
        for (value, limit, expected) in [
            (0.5, 1.0, 0.5),
            (2.0, 1.0, 1.0),
            (-2.0, 1.0, -1.0),
            (1.0, 1.0, 1.0),
            (-1.0, 1.0, -1.0),
            (3.0, 0.0, 0.0),
        ] {
            assert_eq!(value.within(limit), expected, "{value} within ± {limit}");
        }
        assert!(f64::NAN.within(1.0).is_nan());
        assert_eq!(f64::INFINITY.within(2.0), 2.0);
    }
}
