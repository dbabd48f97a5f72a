use super::{ContactLaw, Response, Touch};

/// Coulomb friction with normal and shear springs and dashpots, without tension.
///
/// ```text
/// N = k_n g + clamp(β k_n ġ, ±k_n g)   where g > 0, else 0
/// e = clamp(e_trial, ±μN/k_s),  T = clamp(k_s e + β k_s ṡ, ±μN)
/// ```
///
/// with penetration g, stretch e and slip rate ṡ. Slip shortens the spring and never stretches
/// it, so that friction work is never negative; with N = 0 the stretch is reset.
///
/// The dashpot force never exceeds the spring force, so that forces grow from zero when a contact closes. The
/// state that a contact loses when it opens still changes by a jump. With a jump at closing, the motion of
/// the dam would not be a continuous function of the pressure on it, and the fixed-point iteration of the
/// coupling might not converge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coulomb {
    /// Friction coefficient μ.
    pub friction: f64,
    /// Normal stiffness k_n, Pa/m.
    pub normal_stiffness: f64,
    /// Shear stiffness k_s, Pa/m.
    pub shear_stiffness: f64,
}

impl ContactLaw for Coulomb {
    #[inline]
    fn respond(&self, touch: &Touch) -> Response {
        if touch.penetration <= 0.0 {
            return Response::NONE;
        }
        let spring = self.normal_stiffness * touch.penetration;
        let dashpot = touch.damping * self.normal_stiffness * touch.penetration_rate;
        let normal = spring + within(dashpot, spring);
        let limit = self.friction * normal;
        let trial = self.shear_stiffness * touch.stretch;
        let elastic = within(trial, limit);
        let damped = elastic + touch.damping * self.shear_stiffness * touch.slip_rate;
        let shear = within(damped, limit);
        Response {
            normal,
            shear,
            stretch: if elastic == trial { touch.stretch } else { elastic / self.shear_stiffness },
            slipping: elastic != trial,
            bonded: false,
            dashpots: [normal - spring, shear - elastic],
        }
    }

    fn stiffness(&self) -> [f64; 2] {
        [self.normal_stiffness, self.shear_stiffness]
    }

    fn unbonded(&self) -> Option<&Coulomb> {
        Some(self)
    }
}

/// `value`, limited to ± `limit`; NaN stays NaN. A comparison each, where `min` and `max`, which look for NaN and hide it, take five
/// instructions.
#[inline(always)]
pub(super) fn within(value: f64, limit: f64) -> f64 {
    let value = if value > limit { limit } else { value };
    if value < -limit { -limit } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: Coulomb = Coulomb { friction: 0.5, normal_stiffness: 10.0, shear_stiffness: 4.0 };

    #[test]
    fn sticks_below_the_limit_and_slips_at_it() {
        let touch = Touch {
            penetration: 1.0,
            penetration_rate: 0.0,
            stretch: 1.0,
            slip_rate: 0.0,
            damping: 0.1,
            bonded: false,
        };
        let stick = LAW.respond(&touch);
        assert_eq!((stick.normal, stick.shear, stick.slipping), (10.0, 4.0, false));
        let slip = LAW.respond(&Touch { stretch: -2.0, slip_rate: -3.0, ..touch });
        assert_eq!((slip.shear, slip.stretch, slip.slipping), (-5.0, -1.25, true));
        assert_eq!(slip.dashpots, [0.0; 2]);
    }

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
            assert_eq!(within(value, limit), expected, "{value} within ± {limit}");
        }
        assert!(within(f64::NAN, 1.0).is_nan());
        assert_eq!(within(f64::INFINITY, 2.0), 2.0);
    }

    /// NaN must not be hidden: after each step the dam reports where values are not finite.
    #[test]
    fn nan_passes_through() {
        let touch = Touch {
            penetration: f64::NAN,
            penetration_rate: f64::NAN,
            stretch: f64::NAN,
            slip_rate: 0.0,
            damping: 0.1,
            bonded: false,
        };
        assert!(LAW.respond(&touch).normal.is_nan());
    }

    #[test]
    fn leaving_fast_neither_pulls_nor_keeps_its_shear() {
        let touch = Touch {
            penetration: 0.1,
            penetration_rate: -9.0,
            stretch: 1.0,
            slip_rate: 1.0,
            damping: 0.1,
            bonded: false,
        };
        let response = LAW.respond(&touch);
        assert_eq!((response.normal, response.shear, response.stretch), (0.0, 0.0, 0.0));
        assert!(
            response.dashpots[0] * touch.penetration_rate + response.dashpots[1] * touch.slip_rate >= 0.0
        );
    }
}
