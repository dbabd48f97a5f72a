//! What a time step makes of contacts: forces, next states and losses, for one contact (`N = f64`) or for several at once.

use super::super::{ContactLaw, Touch, parting};
use super::position::{Position, minus, plus, product, times};
use crate::damping::StiffnessDamping;
use crate::real::{Mask, Real};

/// Numbers of a [`JointState`](super::JointState) that every contact has.
#[derive(Clone, Copy, Default)]
pub(super) struct State<N = f64> {
    pub anchor: N,
    pub stretch: N,
    pub gap: N,
    pub slipped: N,
    pub dashpots: [N; 2],
    pub rates: [N; 2],
}

/// A contact in the current position.
pub(super) struct Moved<N> {
    /// 1 for a point of the upper side, −1 for one of the lower side.
    pub downstream: N,
    /// Position of its point between the nodes next to it, from 0 to 1.
    pub share: N,
    /// Length for which it stands, m.
    pub weight: N,
    /// Position of its point, m.
    pub point: [N; 2],
    /// Position relative to the other side.
    pub at: Position<N>,
    /// Velocities of the nodes next to its point and of those of the segment opposite, m/s.
    pub velocities: [[N; 2]; 4],
}

/// What only some contacts have: those that are or were not wholly opposite the other side, are bonded, or dilate.
pub(super) struct Special<N: Real> {
    /// Length for which the contact stood before, m.
    pub weight: N,
    /// Rise by dilation, m.
    pub risen: N,
    /// Penetration that the state holds, m.
    pub penetration: N,
    /// Whether it was closed.
    pub closed: N::Mask,
    /// Whether it was lost, and is found again.
    pub lost: N::Mask,
    /// Whether it was bonded, and whether it may remain so.
    pub bonded: N::Mask,
    pub may_hold: N::Mask,
}

/// What the time step makes of a [`Moved`] contact.
pub(super) struct Update<N: Real> {
    pub state: State<N>,
    /// Penetration, including the rise by dilation, m.
    pub penetration: N,
    pub closed: N::Mask,
    pub slipping: N::Mask,
    pub bonded: N::Mask,
    /// Weights of the four nodes in the relative displacement.
    pub shares: [N; 4],
    /// Force on the point, N/m; without meaning unless the contact is closed.
    pub force: [N; 2],
    /// Shear stress, Pa.
    pub shear: N,
    /// Friction by slip, J/m, and what else counts as friction of a [`Special`] contact.
    pub friction: N,
    pub special_friction: [N; 3],
    /// Power of the dashpots, W/m.
    pub damping_power: N,
}

/// What a [`Parting`](parting::Parting) needs of a contact.
#[derive(Clone, Copy, Default)]
pub(super) struct Jump<N = f64> {
    /// Place (m) and velocity (m/s) of the upper side, the latter relative to the lower one.
    pub place: [N; 2],
    pub relative: [N; 2],
    /// Shares that slip and that open.
    pub slips: N,
    pub opened: N,
}

impl<N: Real> Moved<N> {
    /// Forces and next state of a contact with this `state`, and its part in the motion of cracks if evaluations a `time_step` (s)
    /// apart are to tell it. Without `special` the contact lies wholly opposite the other side, has no bond and does not dilate.
    #[inline(always)]
    pub fn update<L: ContactLaw>(
        &self,
        law: &L,
        StiffnessDamping { coefficient, memory }: StiffnessDamping,
        state: &State<N>,
        special: Option<&Special<N>>,
        time_step: Option<f64>,
    ) -> (Update<N>, Option<Jump<N>>) {
        let zero = self.weight.constant(0.0);
        let one = self.weight.constant(1.0);
        let [normal_stiffness, shear_stiffness] = law.stiffness();
        let Position { position, tangent, normal, gap, slip, shortening } = self.at;
        let shares = [one - self.share, self.share, position - one, -position];
        let mut relative = [zero; 2];
        for (share, velocity) in shares.into_iter().zip(self.velocities) {
            relative = plus(relative, times(share, velocity));
        }
        let rates = [-product(relative, normal), product(relative, tangent)];
        let fresh = times(zero.constant(1.0 - memory), rates);
        let felt = plus(times(zero.constant(memory), state.rates), fresh);
        let (penetration, earlier) = match special {
            None => (zero - gap, zero - state.gap),
            Some(Special { risen, lost, .. }) => {
                let penetration = *risen - gap;
                (penetration, lost.select(penetration, *risen - state.gap))
            }
        };
        let pressing = if coefficient == 0.0 {
            penetration
        } else {
            let acting = acting_penetration(penetration, penetration - earlier);
            let acting = rates[0].equals(zero).select(penetration, acting);
            match special {
                None => acting,
                Some(Special { bonded, .. }) => bonded.select(penetration, acting),
            }
        };
        let response = law.respond(&Touch {
            penetration: pressing,
            penetration_rate: felt[0],
            stretch: slip - state.anchor,
            slip_rate: felt[1],
            damping: coefficient,
            bonded: match special {
                None => zero.mask(false),
                Some(Special { may_hold, .. }) => *may_hold,
            },
        });
        let (stretch, dashpots) = (response.stretch, response.dashpots);
        let pressed = zero.less_than(penetration);
        let bonded = match special {
            None => zero.mask(false),
            Some(_) => response.bonded,
        };
        let closed = pressed | bonded;
        let anchor = (response.slipping | !closed).select(slip - stretch, state.anchor);
        let slid = anchor - state.anchor;
        let slides = !slid.equals(zero);
        let any_slides = slides.any();
        let before = match special {
            None => self.weight,
            Some(Special { weight, .. }) => *weight,
        };
        let friction = if any_slides {
            let mean_shear = (before * state.stretch + self.weight * stretch) * shear_stiffness / 2.0;
            // the shear force does its work along the current length
            slides.select(mean_shear * slid / shortening, zero)
        } else {
            zero
        };
        let special_friction = match special {
            None => [zero; 3],
            Some(special) => {
                let stiffness = [normal_stiffness, shear_stiffness];
                special.friction(stiffness, state, [penetration, stretch, gap, self.weight], bonded)
            }
        };
        let [normal_before, shear_before] = times(before, state.dashpots);
        let damping_power = (normal_before + self.weight * dashpots[0]) / 2.0 * rates[0]
            + (shear_before + self.weight * dashpots[1]) / 2.0 * rates[1];
        let open = bonded.select(zero, share_below_zero(earlier, penetration));
        let state_after = State {
            anchor,
            stretch,
            gap,
            slipped: state.slipped + (one - open) * slid.abs(),
            dashpots,
            rates: if memory > 0.0 { minus(felt, times(open * (1.0 - memory), rates)) } else { [zero; 2] },
        };
        let force = minus(times(response.normal, normal), times(response.shear, tangent));
        // (a `match`, as a closure would not be compiled for the widest registers)
        let jump = match time_step {
            None => None,
            Some(time_step) => {
                // the jump is the motion of the upper side relative to the lower one, at the upper side
                let depth = self.downstream.less_than(zero).select(gap, zero);
                let is_open = zero.less_than(open);
                let opened = if is_open.any() {
                    let gap = is_open.select(mean_below_zero(open, earlier, penetration), zero);
                    parting::share_of_opening(gap, normal_stiffness)
                } else {
                    zero
                };
                let slips = if any_slides {
                    let share = parting::share_of_slip(slid, stretch - state.stretch, time_step);
                    slides.select(share, zero)
                } else {
                    zero
                };
                Some(Jump {
                    place: minus(self.point, times(depth, normal)),
                    relative: times(self.downstream, relative),
                    slips: opened + (one - opened) * slips,
                    opened,
                })
            }
        };
        let update = Update {
            state: state_after,
            penetration,
            closed,
            slipping: response.slipping,
            bonded,
            shares,
            force: times(self.weight, force),
            shear: response.shear,
            friction,
            special_friction,
            damping_power,
        };
        (update, jump)
    }
}

impl<N: Real> Special<N> {
    /// What counts as friction besides slip, J/m: springs that appear and disappear with the part of the contact that they represent,
    /// the work of dilation against pressure, and the springs of a bond that breaks under tension.
    #[inline(always)]
    fn friction(
        &self,
        stiffness: [f64; 2],
        state: &State<N>,
        [penetration, stretch, gap, weight]: [N; 4],
        bonded: N::Mask,
    ) -> [N; 3] {
        let zero = gap.constant(0.0);
        let before = self.weight;
        let changes = !weight.equals(before);
        let parts = if changes.any() {
            let earlier = self.lost.select((self.risen - state.gap).positive_part(), self.penetration);
            let energy = mean_energy(stiffness, earlier * penetration, state.stretch, stretch);
            changes.select((before - weight) * energy, zero)
        } else {
            zero
        };
        let dilation = if self.closed.any() {
            // dilation since the last evaluation has pressed the sides together
            let rise = self.risen - state.gap - self.penetration;
            let pressed = before * self.penetration + weight * penetration.positive_part();
            self.closed.select(-(pressed * stiffness[0] / 2.0 * rise), zero)
        } else {
            zero
        };
        let breaks = self.bonded & !bonded & penetration.less_than(zero);
        let bond = if breaks.any() {
            let energy = mean_energy(stiffness, self.penetration * penetration, state.stretch, zero);
            breaks.select(weight * energy, zero)
        } else {
            zero
        };
        [parts, dilation, bond]
    }
}

/// `½ (k_n g₀ g₁ + k_s e₀ e₁)`, J/m²: what springs lose that act with the penetration g₀ and the stretch e₀ before, and no longer with g₁
/// and e₁ at the end of the time step. The work of the mean of the forces before and after, less the change of the stored energy, is
/// exactly this. `penetrations` is g₀ g₁; springs of different sign do not act both.
#[inline(always)]
pub(super) fn mean_energy<N: Real>(
    [normal, shear]: [f64; 2],
    penetrations: N,
    stretch_before: N,
    stretch: N,
) -> N {
    (penetrations.positive_part() * normal + stretch_before * shear * stretch) * 0.5
}

/// The penetration whose spring force does the work of the spring, if it changes by `change` (m) in every time step:
///
/// ```text
/// g (1 + g/|Δg|)/2   where 0 < g < |Δg|, else g
/// ```
///
/// In central differences the force of each instant acts over half of the step before and half of the step after it. A contact that
/// closes in the step before, or opens in the step after, acts over a part of it only: with the whole force the step would do
/// `k g (|Δg| − g)/2` more than the energy of its spring, taken from the motion where the contact closes and given to it where it opens.
/// Without dashpots both are equal, and this force, which depends on a speed, would do harm.
#[inline(always)]
fn acting_penetration<N: Real>(penetration: N, change: N) -> N {
    let (zero, change) = (penetration.constant(0.0), change.abs());
    let partly = zero.less_than(penetration) & penetration.less_than(change);
    if partly.any() {
        let one = zero.constant(1.0);
        partly.select(penetration * (one + penetration / change) / 2.0, penetration)
    } else {
        penetration
    }
}

/// Share of a step in which a value that goes from `first` to `last` linearly is negative.
#[inline(always)]
fn share_below_zero<N: Real>(first: N, last: N) -> N {
    let zero = first.constant(0.0);
    let (before, after) = (first.less_than(zero), last.less_than(zero));
    let either = before | after;
    if !either.any() {
        return zero;
    }
    let (negative, other) = (before.select(first, last), before.select(last, first));
    let share = either.select(negative / (negative - other), zero);
    (before & after).select(zero.constant(1.0), share)
}

/// Mean of how far a value that goes from `first` to `last` linearly is below zero, which it is for this `share` of the step; it counts
/// as 0 where it is not.
#[inline(always)]
fn mean_below_zero<N: Real>(share: N, first: N, last: N) -> N {
    share * (first.negative_part() + last.negative_part()) / -2.0
}

#[cfg(test)]
mod tests {
    use super::{mean_below_zero, share_below_zero};

    #[test]
    fn the_mean_width_of_a_gap_that_opens_or_closes_is_that_of_its_open_part() {
        for (first, last, mean) in [(2.0, 1.0, 0.0), (-1.0, -3.0, 2.0), (1.0, -1.0, 0.25), (-3.0, 1.0, 1.125)]
        {
            let computed: f64 = mean_below_zero(share_below_zero(first, last), first, last);
            assert!((computed - mean).abs() < 1e-15, "from {first} to {last}");
        }
    }
}
