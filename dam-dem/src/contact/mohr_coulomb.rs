use super::{ContactLaw, Coulomb, Response, Touch};
use crate::real::{Mask, Real};

/// Mohr-Coulomb law of a joint with bond, residual friction and dilation.
///
/// While the joint is bonded,
///
/// ```text
/// N = k_n g ≥ −σ_t,   |T| ≤ c + μ max(N, 0)
/// ```
///
/// and it does not slip. If the tensile or the shear strength is exceeded, the bond breaks permanently, and
/// [`Coulomb`]'s law with the residual friction applies. A joint without cohesion and tensile strength has
/// its peak friction until it first slips or opens; if its residual friction is not below the peak, there is
/// no bond at all. While a closed joint slips, it rises by tan ψ times the slip in either direction, until
/// the accumulated slip reaches `dilation_slip`; the penetration g includes the rise.
///
/// **Source**: P.A. Cundall, R.D. Hart, *Numerical modelling of discontinua*, Engineering Computations 9
/// (1992), the Coulomb slip model with residual strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MohrCoulomb {
    /// Law after the bond has broken: residual friction, and the springs.
    pub residual: Coulomb,
    /// Friction coefficient μ of the bond.
    pub friction: f64,
    /// Cohesion c, Pa.
    pub cohesion: f64,
    /// Tensile strength σ_t, Pa.
    pub tensile_strength: f64,
    /// tan ψ.
    pub dilation: f64,
    /// Accumulated slip at which dilation ends, m.
    pub dilation_slip: f64,
}

impl MohrCoulomb {
    /// Shear strength under the stress `normal` (Pa, compression positive) of a joint that is or is not `bonded`, Pa.
    pub fn strength(&self, normal: f64, bonded: bool) -> f64 {
        if bonded { self.bond_strength(normal) } else { self.residual.friction * normal.max(0.0) }
    }

    #[inline(always)]
    fn bond_strength<N: Real>(&self, normal: N) -> N {
        normal.positive_part() * self.friction + self.cohesion
    }
}

impl ContactLaw for MohrCoulomb {
    #[inline(always)]
    fn respond<N: Real>(&self, touch: &Touch<N>) -> Response<N> {
        if !touch.bonded.any() {
            return self.residual.respond(touch);
        }
        let [normal_stiffness, shear_stiffness] = self.stiffness();
        let spring = touch.penetration * normal_stiffness;
        let elastic = touch.stretch * shear_stiffness;
        let strength = self.bond_strength(spring);
        let breaks =
            spring.less_than(spring.constant(-self.tensile_strength)) | strength.less_than(elastic.abs());
        let holds = touch.bonded & !breaks;
        if !holds.any() {
            return self.residual.respond(touch);
        }
        let dashpot = (touch.penetration_rate * (touch.damping * normal_stiffness)).within(spring.abs());
        let damped = elastic + touch.slip_rate * (touch.damping * shear_stiffness);
        let shear = damped.within(strength);
        let bond = Response {
            normal: spring + dashpot,
            shear,
            stretch: touch.stretch,
            slipping: spring.mask(false),
            bonded: holds,
            dashpots: [dashpot, shear - elastic],
        };
        if holds.all() {
            return bond;
        }
        let broken = self.residual.respond(touch);
        Response {
            normal: holds.select(bond.normal, broken.normal),
            shear: holds.select(bond.shear, broken.shear),
            stretch: holds.select(bond.stretch, broken.stretch),
            slipping: broken.slipping & !holds,
            bonded: holds,
            dashpots: [
                holds.select(bond.dashpots[0], broken.dashpots[0]),
                holds.select(bond.dashpots[1], broken.dashpots[1]),
            ],
        }
    }

    fn stiffness(&self) -> [f64; 2] {
        self.residual.stiffness()
    }

    fn is_bonded(&self) -> bool {
        self.cohesion > 0.0 || self.tensile_strength > 0.0 || self.residual.friction < self.friction
    }

    fn dilates(&self) -> bool {
        self.dilation != 0.0
    }

    fn dilation(&self, slipped: f64) -> f64 {
        self.dilation * slipped.min(self.dilation_slip)
    }
}
