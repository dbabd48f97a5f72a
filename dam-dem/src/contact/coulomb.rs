use super::{ContactLaw, Response, Touch};
use crate::real::{Mask, Real};

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
    #[inline(always)]
    fn respond<N: Real>(&self, touch: &Touch<N>) -> Response<N> {
        let zero = touch.penetration.constant(0.0);
        let open = touch.penetration.at_most(zero);
        if open.all() {
            return Response::none(zero);
        }
        let [normal_stiffness, shear_stiffness] = self.stiffness();
        let spring = touch.penetration * normal_stiffness;
        let dashpot = touch.penetration_rate * (touch.damping * normal_stiffness);
        let normal = spring + dashpot.within(spring);
        let limit = normal * self.friction;
        let trial = touch.stretch * shear_stiffness;
        let elastic = trial.within(limit);
        let shear = (elastic + touch.slip_rate * (touch.damping * shear_stiffness)).within(limit);
        let slipping = !(elastic.equals(trial) | open);
        let stretch = match slipping.any() {
            true => slipping.select(elastic / shear_stiffness, touch.stretch),
            false => touch.stretch,
        };
        Response {
            normal: open.select(zero, normal),
            shear: open.select(zero, shear),
            stretch: open.select(zero, stretch),
            slipping,
            bonded: zero.mask(false),
            dashpots: [open.select(zero, normal - spring), open.select(zero, shear - elastic)],
        }
    }

    fn stiffness(&self) -> [f64; 2] {
        [self.normal_stiffness, self.shear_stiffness]
    }
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
