use pulp::Simd;
use pulp::bytemuck::Zeroable;
use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Index, IndexMut, Mul, Neg, Not, Sub};

pub(crate) use crate::real::LANES;
use crate::real::{Mask, Real, sealed};

/// One value for each cell or contact of a batch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(align(64))]
pub struct Lanes([f64; LANES]);

impl Lanes {
    /// Sum over all, always in the same order.
    pub(crate) fn sum(&self) -> f64 {
        self.0.iter().sum()
    }

    /// Number of registers that hold one value for each.
    #[inline(always)]
    pub(crate) fn registers<S: Simd>() -> usize {
        LANES / S::F64_LANES
    }

    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, simd: S, register: usize) -> Register<S> {
        Register { simd, value: S::as_simd_f64s(&self.0).0[register] }
    }

    #[inline(always)]
    pub(crate) fn store<S: Simd>(&mut self, register: usize, from: Register<S>) {
        S::as_mut_simd_f64s(&mut self.0).0[register] = from.value;
    }
}

impl Index<usize> for Lanes {
    type Output = f64;

    #[inline(always)]
    fn index(&self, lane: usize) -> &f64 {
        &self.0[lane]
    }
}

impl IndexMut<usize> for Lanes {
    #[inline(always)]
    fn index_mut(&mut self, lane: usize) -> &mut f64 {
        &mut self.0[lane]
    }
}

/// As many values as a processor register holds. All operations follow IEEE 754 and are never fused, so that
/// results do not depend on the width of the register.
#[derive(Clone, Copy)]
pub(crate) struct Register<S: Simd> {
    simd: S,
    value: S::f64s,
}

impl<S: Simd> Register<S> {
    /// The same value for all.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Self { simd, value: simd.splat_f64s(value) }
    }

    /// The same value for all, in a register like this one.
    #[inline(always)]
    pub fn splat_like(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { value: self.simd.abs_f64s(self.value), ..self }
    }

    /// `yes` where this value is negative, `no` elsewhere.
    #[inline(always)]
    pub fn where_negative(self, yes: Self, no: Self) -> Self {
        self.less_than(self.splat_like(0.0)).select(yes, no)
    }

    #[inline(always)]
    pub fn less_than(self, other: Self) -> RegisterMask<S> {
        RegisterMask { simd: self.simd, value: self.simd.less_than_f64s(self.value, other.value) }
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self { value: self.simd.sqrt_f64s(self.value), ..self }
    }
}

/// What holds for which values of a [`Register`].
#[derive(Clone, Copy)]
pub(crate) struct RegisterMask<S: Simd> {
    simd: S,
    value: S::m64s,
}

impl<S: Simd> RegisterMask<S> {
    /// `yes` where it holds, `no` elsewhere.
    #[inline(always)]
    pub fn select(self, yes: Register<S>, no: Register<S>) -> Register<S> {
        Register { simd: self.simd, value: self.simd.select_f64s(self.value, yes.value, no.value) }
    }

    /// Whether it holds for any value.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.simd.first_true_m64s(self.value) < S::F64_LANES
    }
}

impl<S: Simd> BitAnd for RegisterMask<S> {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self { value: self.simd.and_m64s(self.value, other.value), ..self }
    }
}

impl<S: Simd> BitOr for RegisterMask<S> {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self { value: self.simd.or_m64s(self.value, other.value), ..self }
    }
}

impl<S: Simd> Not for RegisterMask<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self { value: self.simd.not_m64s(self.value), ..self }
    }
}

macro_rules! operators {
    ($($trait:ident $method:ident $call:ident),*) => {$(
        impl<S: Simd> $trait for Register<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { value: self.simd.$call(self.value, other.value), ..self }
            }
        }

        impl<S: Simd> $trait<f64> for Register<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.$method(self.splat_like(other))
            }
        }
    )*};
}

operators!(Add add add_f64s, Sub sub sub_f64s, Mul mul mul_f64s, Div div div_f64s);

impl<S: Simd> Neg for Register<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { value: self.simd.neg_f64s(self.value), ..self }
    }
}

impl<S: Simd> AddAssign for Register<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Simd> sealed::Sealed for Register<S> {}
impl<S: Simd> sealed::Sealed for RegisterMask<S> {}

impl<S: Simd> Real for Register<S> {
    type Mask = RegisterMask<S>;
    const LANES: usize = S::F64_LANES;

    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        self.splat_like(value)
    }

    #[inline(always)]
    fn mask(self, value: bool) -> RegisterMask<S> {
        let none = RegisterMask { simd: self.simd, value: S::m64s::zeroed() };
        if value { !none } else { none }
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn less_than(self, other: Self) -> RegisterMask<S> {
        self.less_than(other)
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> RegisterMask<S> {
        RegisterMask { simd: self.simd, value: self.simd.less_than_or_equal_f64s(self.value, other.value) }
    }

    #[inline(always)]
    fn equals(self, other: Self) -> RegisterMask<S> {
        RegisterMask { simd: self.simd, value: self.simd.equal_f64s(self.value, other.value) }
    }

    #[inline(always)]
    fn to_lanes(self) -> [f64; LANES] {
        let mut lanes = Lanes::default();
        lanes.store(0, self);
        lanes.0
    }

    #[inline(always)]
    fn with_lanes(self, lanes: [f64; LANES]) -> Self {
        Lanes(lanes).load(self.simd, 0)
    }
}

impl<S: Simd> Mask<Register<S>> for RegisterMask<S> {
    #[inline(always)]
    fn select(self, yes: Register<S>, no: Register<S>) -> Register<S> {
        self.select(yes, no)
    }

    #[inline(always)]
    fn any(self) -> bool {
        self.any()
    }
}
