use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign, Mul, Sub};

/// One value for each of the four triangles of a cell; the compiler turns it into SIMD registers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Lanes(pub(super) [f64; 4]);

impl Lanes {
    /// The same value in all lanes.
    #[inline(always)]
    pub fn splat(value: f64) -> Self {
        Self([value; 4])
    }

    /// Lane k takes the value of lane k + 1, the last that of the first.
    #[inline(always)]
    pub fn next(self) -> Self {
        let [a, b, c, d] = self.0;
        Self([b, c, d, a])
    }

    /// Lane k takes the value of lane k − 1, the first that of the last.
    #[inline(always)]
    pub fn previous(self) -> Self {
        let [a, b, c, d] = self.0;
        Self([d, a, b, c])
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        let [a, b, c, d] = self.0;
        Self([a.sqrt(), b.sqrt(), c.sqrt(), d.sqrt()])
    }

    #[inline(always)]
    pub fn reciprocal(self) -> Self {
        let [a, b, c, d] = self.0;
        Self([1.0 / a, 1.0 / b, 1.0 / c, 1.0 / d])
    }

    #[inline(always)]
    pub fn sum(self) -> f64 {
        let [a, b, c, d] = self.0;
        (a + c) + (b + d)
    }
}

macro_rules! elementwise {
    ($($trait:ident $method:ident $op:tt),*) => {$(
        impl $trait for Lanes {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let (a, b) = (self.0, other.0);
                Self([a[0] $op b[0], a[1] $op b[1], a[2] $op b[2], a[3] $op b[3]])
            }
        }
    )*};
}

elementwise!(Add add +, Sub sub -, Mul mul *);

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
