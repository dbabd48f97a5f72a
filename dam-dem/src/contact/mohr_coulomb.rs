use super::coulomb::within;
use super::{ContactLaw, Coulomb, Response, Touch};

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
        let pressed = normal.max(0.0);
        if bonded { self.cohesion + self.friction * pressed } else { self.residual.friction * pressed }
    }
}

impl ContactLaw for MohrCoulomb {
    #[inline]
    fn respond(&self, touch: &Touch) -> Response {
        if !touch.bonded {
            return self.residual.respond(touch);
        }
        let [normal_stiffness, shear_stiffness] = self.stiffness();
        let spring = normal_stiffness * touch.penetration;
        let elastic = shear_stiffness * touch.stretch;
        let strength = self.strength(spring, true);
        if spring < -self.tensile_strength || elastic.abs() > strength {
            return self.residual.respond(touch);
        }
        let dashpot = touch.damping * normal_stiffness * touch.penetration_rate;
        let dashpot = within(dashpot, spring.abs());
        let damped = elastic + touch.damping * shear_stiffness * touch.slip_rate;
        let shear = within(damped, strength);
        Response {
            normal: spring + dashpot,
            shear,
            stretch: touch.stretch,
            slipping: false,
            bonded: true,
            dashpots: [dashpot, shear - elastic],
        }
    }

    fn stiffness(&self) -> [f64; 2] {
        self.residual.stiffness()
    }

    fn unbonded(&self) -> Option<&Coulomb> {
        (self.dilation == 0.0).then_some(&self.residual)
    }

    fn is_bonded(&self) -> bool {
        self.cohesion > 0.0 || self.tensile_strength > 0.0 || self.residual.friction < self.friction
    }

    fn dilation(&self, slipped: f64) -> f64 {
        if self.dilation == 0.0 { 0.0 } else { self.dilation * slipped.min(self.dilation_slip) }
    }
}
