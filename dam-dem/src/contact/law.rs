use crate::lanes::LANES;
use crate::real::{Mask, Real};

/// State of one contact, or of one in each lane of `N`, as input to a contact law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch<N: Real = f64> {
    /// Overlap of the surfaces along the normal, including the rise by dilation, m; negative for a gap.
    pub penetration: N,
    /// Rate of penetration that acts on the dashpot, with the memory of stiffness damping, m/s.
    pub penetration_rate: N,
    /// Stretch of the shear spring if the contact does not slip in this step (trial value), m.
    pub stretch: N,
    /// Tangential velocity of the point relative to the other side that acts on the dashpot, with the same
    /// memory, m/s.
    pub slip_rate: N,
    /// Stiffness damping β of the dashpots `β k_n` and `β k_s`, s.
    pub damping: f64,
    /// Whether the contact is still bonded.
    pub bonded: N::Mask,
}

impl<N: Real> Touch<N> {
    /// Evaluates a law that is written for one contact, lane by lane.
    ///
    /// For laws that branch, or that need functions [`Real`] does not have. A law in terms of [`Real`] is faster.
    #[inline(always)]
    pub fn each(&self, respond: impl Fn(&Touch) -> Response) -> Response<N> {
        let zero = self.penetration.constant(0.0);
        let one = zero.constant(1.0);
        let [penetration, penetration_rate, stretch, slip_rate, bonded] = [
            self.penetration,
            self.penetration_rate,
            self.stretch,
            self.slip_rate,
            self.bonded.select(one, zero),
        ]
        .map(Real::to_lanes);
        let mut lanes = [[0.0; LANES]; 7];
        for lane in 0..N::LANES {
            let response = respond(&Touch {
                penetration: penetration[lane],
                penetration_rate: penetration_rate[lane],
                stretch: stretch[lane],
                slip_rate: slip_rate[lane],
                damping: self.damping,
                bonded: bonded[lane] != 0.0,
            });
            let [slipping, bonded] = [response.slipping, response.bonded].map(|is| f64::from(u8::from(is)));
            let [normal, shear] = response.dashpots;
            let numbers =
                [response.normal, response.shear, response.stretch, slipping, bonded, normal, shear];
            lanes.iter_mut().zip(numbers).for_each(|(to, number)| to[lane] = number);
        }
        let [normal, shear, stretch, slipping, bonded, dashpot, shear_dashpot] =
            lanes.map(|lanes| zero.with_lanes(lanes));
        Response {
            normal,
            shear,
            stretch,
            slipping: zero.less_than(slipping),
            bonded: zero.less_than(bonded),
            dashpots: [dashpot, shear_dashpot],
        }
    }
}

/// Result of a contact law, per unit of length and metre of dam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response<N: Real = f64> {
    /// Normal stress, Pa, compression positive.
    pub normal: N,
    /// Shear stress, Pa; on the point it acts against the slip.
    pub shear: N,
    /// Stretch of the shear spring after slipping, m.
    pub stretch: N,
    /// Whether the shear strength was reached.
    pub slipping: N::Mask,
    /// Whether the contact remains bonded; a broken bond never recovers.
    pub bonded: N::Mask,
    /// Normal and shear stresses of the dashpots, included in `normal` and `shear`, Pa.
    pub dashpots: [N; 2],
}

impl<N: Real> Response<N> {
    /// Response of an open contact; `like` any number of the [`Touch`].
    #[inline(always)]
    pub fn none(like: N) -> Self {
        let (zero, no) = (like.constant(0.0), like.mask(false));
        Self { normal: zero, shear: zero, stretch: zero, slipping: no, bonded: no, dashpots: [zero; 2] }
    }
}

/// Interface for contact laws.
///
/// **Call order**: [`respond`](Self::respond) once per contact and time step, for one contact or for several at once (one in each
/// lane of `N`). A law has no state of its own: the crack stores the stretch of the shear spring, the bond and the accumulated
/// slip. **Required guarantees**: no tension unless bonded (`normal ≥ 0`, and no stress at all if the penetration is not
/// positive); slip only reduces the stretch; dashpots never add energy with the rates in [`Touch`]; the same bits in every
/// lane, as the operations of [`Real`] and [`Touch::each`] give them. The critical time step considers the
/// [`stiffness`](Self::stiffness) and β only; a law with other dampers must be run with shorter time steps.
///
/// `examples/lubricated_joint.rs` shows a user-defined law.
pub trait ContactLaw: Clone + Send + Sync {
    /// Stresses of contacts. Formulas are written in terms of [`Real`], or for one contact within [`Touch::each`].
    ///
    /// Implementations should be `#[inline(always)]`, so that they are compiled for the registers of the caller.
    fn respond<N: Real>(&self, touch: &Touch<N>) -> Response<N>;

    /// Normal and shear stiffness of a closed, sticking contact, Pa/m.
    fn stiffness(&self) -> [f64; 2];

    /// Whether contacts are bonded initially.
    fn is_bonded(&self) -> bool {
        false
    }

    /// Whether slip separates the sides. If not, [`dilation`](Self::dilation) has no effect.
    fn dilates(&self) -> bool {
        false
    }

    /// Distance by which dilation has separated the sides after an accumulated slip of `slipped` (m), m.
    fn dilation(&self, _slipped: f64) -> f64 {
        0.0
    }

    /// Energy of the springs, J/m², for a penetration (negative in a bond under tension) and a stretch, m.
    fn energy(&self, penetration: f64, stretch: f64) -> f64 {
        let [normal, shear] = self.stiffness();
        0.5 * (normal * penetration * penetration + shear * stretch * stretch)
    }
}

#[cfg(test)]
mod tests {
    use pulp::{Arch, Simd, WithSimd};

    use super::*;
    use crate::contact::{Coulomb, MohrCoulomb};
    use crate::lanes::{Lanes, Register};

    /// Responses of eight contacts in registers: in terms of [`Real`], and lane by lane.
    struct InRegisters<'a> {
        law: &'a MohrCoulomb,
        touches: [Touch; LANES],
    }

    impl WithSimd for InRegisters<'_> {
        type Output = Vec<[[u64; 7]; 2]>;

        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let lanes = |number: fn(&Touch) -> f64| {
                let mut lanes = Lanes::default();
                self.touches.iter().enumerate().for_each(|(lane, touch)| lanes[lane] = number(touch));
                lanes
            };
            let mut responses = Vec::new();
            for register in 0..Lanes::registers::<S>() {
                let load = |number: fn(&Touch) -> f64| lanes(number).load(simd, register);
                let touch = Touch {
                    penetration: load(|touch| touch.penetration),
                    penetration_rate: load(|touch| touch.penetration_rate),
                    stretch: load(|touch| touch.stretch),
                    slip_rate: load(|touch| touch.slip_rate),
                    damping: self.touches[0].damping,
                    bonded: load(|touch| f64::from(u8::from(!touch.bonded)))
                        .less_than(Register::splat(simd, 0.5)),
                };
                let both = [self.law.respond(&touch), touch.each(|touch| self.law.respond(touch))].map(bits);
                responses.extend((0..S::F64_LANES).map(|lane| [both[0][lane], both[1][lane]]));
            }
            responses
        }
    }

    /// Bits of all numbers of a response, for each lane.
    fn bits<N: Real>(response: Response<N>) -> [[u64; 7]; LANES] {
        let Response { normal, shear, stretch, slipping, bonded, dashpots } = response;
        let (zero, one) = (normal.constant(0.0), normal.constant(1.0));
        let [slipping, bonded] = [slipping, bonded].map(|mask| mask.select(one, zero));
        let numbers =
            [normal, shear, stretch, slipping, bonded, dashpots[0], dashpots[1]].map(Real::to_lanes);
        std::array::from_fn(|lane| numbers.map(|lanes| lanes[lane].to_bits()))
    }

    #[test]
    fn responses_have_the_same_bits_in_every_lane() {
        let residual = Coulomb { friction: 0.5, normal_stiffness: 10.0, shear_stiffness: 4.0 };
        let law = MohrCoulomb {
            residual,
            friction: 0.7,
            cohesion: 1.0,
            tensile_strength: 0.5,
            dilation: 0.0,
            dilation_slip: f64::INFINITY,
        };
        let mut seed = 1u32;
        let mut random = move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed) / f64::from(u32::MAX) - 0.5
        };
        for _ in 0..500 {
            let touches = [(); LANES].map(|()| Touch {
                penetration: if random() < -0.4 { 0.0 } else { random() },
                penetration_rate: 20.0 * random(),
                stretch: 2.0 * random(),
                slip_rate: 20.0 * random(),
                damping: 0.1,
                bonded: random() < 0.0,
            });
            let alone = touches.map(|touch| bits(law.respond(&touch))[0]);
            let expected: Vec<_> = alone.into_iter().map(|bits| [bits; 2]).collect();
            assert_eq!(Arch::new().dispatch(InRegisters { law: &law, touches }), expected);
            assert_eq!(InRegisters { law: &law, touches }.with_simd(pulp::Scalar::new()), expected);
        }
    }
}
