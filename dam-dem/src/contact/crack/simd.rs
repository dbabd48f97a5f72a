use pulp::{Simd, WithSimd};

use super::super::parting::{self, CLOSING, Parting, STANDSTILL};
use super::super::search::MARGIN;
use super::{Contact, ContactLaw, ContactStatus, Crack, JointState, TILT};
use crate::damping::StiffnessDamping;
use crate::energy::Losses;
use crate::lanes::{LANES, Lanes, Register};

/// The contacts of all cracks, [`LANES`] at a time: made of the states at the start of a communication step, which take in those at its
/// end.
///
/// Numbers of eight contacts lie side by side, so that registers hold them without gathering, and every operation is the one that
/// [`Crack::press`] does, with the same bits. Contacts are computed there one by one whose part does not lie wholly opposite the
/// other side, all of cracks with few contacts, with a bond that holds, with dilation or with a law of their own, and each when it
/// comes to another segment. These cracks come last, which changes the order of sums where they share nodes with others.
pub(crate) struct Eights {
    eights: Vec<Eight>,
    /// Cracks whose contacts are computed one by one.
    others: Vec<usize>,
}

/// Number of contacts from which those of a crack are worth it: of fewer, too many lie at ends.
const MANY: usize = 2 * LANES;

/// Motion of the nodes, and what acts on them.
pub(crate) struct Pressed<'a> {
    /// Displacement, m.
    pub u: &'a [[f64; 2]],
    /// Velocity, m/s.
    pub v: &'a [[f64; 2]],
    /// Of the dashpots.
    pub damping: StiffnessDamping,
    /// Forces are added here, N/m.
    pub forces: &'a mut [[f64; 2]],
    /// How the sides of each crack part; empty if that is not asked for.
    pub partings: &'a mut [Parting],
}

/// Up to eight contacts; lanes without one repeat the first.
#[derive(Default)]
struct Eight {
    /// Crack and number there of each.
    contacts: [(usize, usize); LANES],
    /// Number of lanes with a contact.
    count: usize,
    /// The nodes around its point, and those of the segment opposite.
    nodes: [[u32; LANES]; 4],
    point: Points,
    segment: Segments,
    law: Laws,
    state: States,
    /// 1 where a contact is computed one by one: its state is then that of [`JointState`] alone.
    alone: Lanes,
}

/// The contacts' points, m.
#[derive(Default)]
struct Points {
    /// 1 on the upper side, −1 on the lower one.
    downstream: Lanes,
    share: Lanes,
    rest: [Lanes; 2],
    part: [Lanes; 2],
    weight: Lanes,
    /// Length of the other side.
    length: Lanes,
}

/// The segments opposite, unloaded, m.
#[derive(Default)]
struct Segments {
    /// 1 where one follows towards the side's start, and its end.
    follows: [Lanes; 2],
    /// From its nodes to the contact's point.
    apart: [[Lanes; 2]; 2],
    /// From its first to its second node.
    edge: [Lanes; 2],
    /// Abscissas of its nodes less that of the point.
    abscissas: [Lanes; 2],
    /// Its length.
    at_rest: Lanes,
}

/// [`Coulomb`](crate::contact::Coulomb), of each.
#[derive(Default)]
struct Laws {
    friction: Lanes,
    stiffness: [Lanes; 2],
}

/// [`JointState`], of each.
#[derive(Default)]
struct States {
    anchor: Lanes,
    stretch: Lanes,
    gap: Lanes,
    slipped: Lanes,
    dashpots: [Lanes; 2],
    rates: [Lanes; 2],
    /// 1 where it is closed, and where it is closed and slips.
    closed: Lanes,
    slipping: Lanes,
}

/// Where the contacts are, as in [`Place`](super::Place).
#[derive(Default)]
struct Places {
    position: Lanes,
    tangent: [Lanes; 2],
    normal: [Lanes; 2],
    gap: Lanes,
    slip: Lanes,
    shortening: Lanes,
    /// The point, m.
    point: [Lanes; 2],
    /// 1 where another segment may lie opposite, and where an end of the other side may.
    walks: Lanes,
    ends: Lanes,
}

/// What follows for the contacts that are not alone: forces in N/m, friction in J/m, power in W/m.
#[derive(Default)]
struct Responses {
    shares: [Lanes; 4],
    force: [Lanes; 2],
    friction: Lanes,
    damping_power: Lanes,
    /// For the [`Parting`]: place (m) and relative velocity (m/s) of the upper side, shares that slip and that open.
    place: [Lanes; 2],
    relative: [Lanes; 2],
    slips: Lanes,
    opened: Lanes,
}

impl Eights {
    /// The contacts of `cracks` with the states `joints`.
    pub fn of<L: ContactLaw>(cracks: &[Crack<L>], joints: &[Vec<JointState>]) -> Self {
        let is_usual = |crack: usize| {
            joints[crack].len() >= MANY
                && cracks[crack].law.unbonded().is_some()
                && !joints[crack].iter().any(|joint| joint.bonded)
        };
        let (usual, others): (Vec<usize>, Vec<usize>) = (0..cracks.len()).partition(|&crack| is_usual(crack));
        let contacts: Vec<(usize, usize)> =
            usual.iter().flat_map(|&crack| (0..joints[crack].len()).map(move |i| (crack, i))).collect();
        let eights = contacts.chunks(LANES).map(|contacts| Eight::of(contacts, cracks, joints)).collect();
        Self { eights, others }
    }

    /// As [`press`](Self::press), by the widest registers.
    pub fn press_widely<L: ContactLaw>(
        &mut self,
        cracks: &[Crack<L>],
        joints: &mut [Vec<JointState>],
        pressed: Pressed<'_>,
    ) -> Losses {
        pulp::Arch::new().dispatch(Press { eights: self, cracks, joints, pressed })
    }

    /// Adds the contact forces and updates the contacts, as [`Crack::add_forces`] does. Of `joints` only those of contacts that are
    /// computed one by one are up to date until [`write`](Self::write); whether a contact is lost they always tell.
    #[inline(always)]
    pub fn press<S: Simd, L: ContactLaw>(
        &mut self,
        simd: S,
        cracks: &[Crack<L>],
        joints: &mut [Vec<JointState>],
        mut pressed: Pressed<'_>,
    ) -> Losses {
        let mut losses = Losses::default();
        pressed.partings.iter_mut().for_each(Parting::clear);
        for eight in &mut self.eights {
            eight.press(simd, cracks, joints, &mut pressed, &mut losses);
        }
        let Pressed { u, v, damping, forces, partings } = pressed;
        for &index in &self.others {
            let (crack, joints, parting) = (&cracks[index], &mut joints[index], partings.get_mut(index));
            losses = crack.press(&crack.contacts, u, v, damping, joints, forces, parting, losses);
        }
        losses
    }

    /// Whether all contacts stick or are lost.
    pub fn are_calm(&self, joints: &[Vec<JointState>]) -> bool {
        let calm = |eight: &Eight| {
            eight.contacts().all(|(lane, (crack, index))| match eight.alone[lane] == 0.0 {
                true => eight.state.closed[lane] != 0.0 && eight.state.slipping[lane] == 0.0,
                false => joints[crack][index].is_calm(),
            })
        };
        self.eights.iter().all(calm)
            && self.others.iter().all(|&crack| joints[crack].iter().all(JointState::is_calm))
    }

    /// Brings `joints` up to date.
    pub fn write(&self, joints: &mut [Vec<JointState>]) {
        for eight in &self.eights {
            let usual = eight.contacts().filter(|(lane, _)| eight.alone[*lane] == 0.0);
            usual.for_each(|(lane, (crack, index))| eight.write(lane, &mut joints[crack][index]));
        }
    }
}

/// [`Eights::press`], to be computed with the widest registers.
struct Press<'a, L: ContactLaw> {
    eights: &'a mut Eights,
    cracks: &'a [Crack<L>],
    joints: &'a mut [Vec<JointState>],
    pressed: Pressed<'a>,
}

impl<L: ContactLaw> WithSimd for Press<'_, L> {
    type Output = Losses;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Losses {
        let Self { eights, cracks, joints, pressed } = self;
        eights.press(simd, cracks, joints, pressed)
    }
}

/// Whether a contact is to be computed alone: its part does not lie wholly opposite the other side.
fn is_alone(joint: &JointState) -> bool {
    joint.coverage < 1.0
}

impl Eight {
    fn of<L: ContactLaw>(
        contacts: &[(usize, usize)],
        cracks: &[Crack<L>],
        joints: &[Vec<JointState>],
    ) -> Self {
        let count = contacts.len();
        let contacts = std::array::from_fn(|lane| contacts[if lane < count { lane } else { 0 }]);
        let mut eight = Self { contacts, count, ..Self::default() };
        for (lane, (crack, index)) in contacts.into_iter().enumerate() {
            let (joint, crack) = (&joints[crack][index], &cracks[crack]);
            let contact = &crack.contacts[index];
            let other = &crack.sides[1 - contact.side];
            let point = &mut eight.point;
            point.downstream[lane] = contact.downstream();
            point.share[lane] = contact.point.share;
            point.weight[lane] = contact.weight;
            point.length[lane] = other.abscissas[other.abscissas.len() - 1];
            for d in 0..2 {
                point.rest[d][lane] = contact.point.rest[d];
                point.part[d][lane] = contact.part[d];
                eight.nodes[d][lane] = contact.point.nodes[d] as u32;
            }
            if let Some(law) = crack.law.unbonded() {
                eight.law.friction[lane] = law.friction;
                eight.law.stiffness[0][lane] = law.normal_stiffness;
                eight.law.stiffness[1][lane] = law.shear_stiffness;
            }
            eight.read(lane, contact, crack, joint);
        }
        eight
    }

    /// The lanes with a contact, its crack and its number there.
    #[inline(always)]
    fn contacts(&self) -> impl Iterator<Item = (usize, (usize, usize))> + use<> {
        self.contacts.into_iter().take(self.count).enumerate()
    }

    /// Takes in the state of a contact and the segment opposite.
    fn read<L: ContactLaw>(&mut self, lane: usize, contact: &Contact, crack: &Crack<L>, joint: &JointState) {
        self.alone[lane] = f64::from(u8::from(is_alone(joint)));
        let other = &crack.sides[1 - contact.side];
        let count = other.nodes.len() - 1;
        let segment = (joint.segment as usize).min(count - 1);
        let opposite = &mut self.segment;
        opposite.follows[0][lane] = f64::from(u8::from(segment > 0));
        opposite.follows[1][lane] = f64::from(u8::from(segment + 1 < count));
        opposite.at_rest[lane] = other.abscissas[segment + 1] - other.abscissas[segment];
        for (end, node) in [segment, segment + 1].into_iter().enumerate() {
            self.nodes[2 + end][lane] = other.nodes[node] as u32;
            opposite.abscissas[end][lane] = other.abscissas[node] - contact.point.abscissa;
            for d in 0..2 {
                opposite.apart[end][d][lane] = contact.point.rest[d] - other.rest[node][d];
            }
        }
        for d in 0..2 {
            opposite.edge[d][lane] = other.rest[segment + 1][d] - other.rest[segment][d];
        }
        let states = &mut self.state;
        let closed = matches!(joint.status, ContactStatus::Sticking | ContactStatus::Slipping);
        states.closed[lane] = f64::from(u8::from(closed));
        states.slipping[lane] = f64::from(u8::from(joint.status == ContactStatus::Slipping));
        states.anchor[lane] = joint.anchor;
        states.stretch[lane] = joint.stretch;
        states.gap[lane] = joint.gap;
        states.slipped[lane] = joint.slipped;
        for i in 0..2 {
            states.dashpots[i][lane] = joint.dashpots[i];
            states.rates[i][lane] = joint.rates[i];
        }
    }

    /// Brings the state of a contact that is not alone up to date.
    fn write(&self, lane: usize, joint: &mut JointState) {
        let states = &self.state;
        let (closed, slipping) = (states.closed[lane] != 0.0, states.slipping[lane] != 0.0);
        joint.status = match (closed, slipping) {
            (false, _) => ContactStatus::Open,
            (true, true) => ContactStatus::Slipping,
            (true, false) => ContactStatus::Sticking,
        };
        joint.anchor = states.anchor[lane];
        joint.stretch = states.stretch[lane];
        joint.gap = states.gap[lane];
        joint.penetration = if closed { 0.0 - states.gap[lane] } else { 0.0 };
        joint.slipped = states.slipped[lane];
        joint.dashpots = [0, 1].map(|i| states.dashpots[i][lane]);
        joint.rates = [0, 1].map(|i| states.rates[i][lane]);
    }

    /// As [`Eights::press`].
    #[inline(always)]
    fn press<S: Simd, L: ContactLaw>(
        &mut self,
        simd: S,
        cracks: &[Crack<L>],
        joints: &mut [Vec<JointState>],
        pressed: &mut Pressed<'_>,
        losses: &mut Losses,
    ) {
        #[cfg(test)]
        super::super::effort::spend(|effort| {
            effort.segments += self.contacts().filter(|(lane, _)| self.alone[*lane] == 0.0).count();
        });
        let mut places = Places::default();
        let of_nodes = gather(&self.nodes, pressed.u);
        for register in 0..Lanes::registers::<S>() {
            self.find(At { simd, register }, &of_nodes, &mut places);
        }
        for (lane, (crack, index)) in self.contacts() {
            let (walks, ends) = (places.walks[lane] != 0.0, places.ends[lane] != 0.0);
            if self.alone[lane] != 0.0 || !(walks || ends) {
                continue;
            }
            let contact = &cracks[crack].contacts[index];
            if walks || !cracks[crack].is_whole(contact, pressed.u) {
                self.write(lane, &mut joints[crack][index]);
                self.alone[lane] = 1.0;
            }
        }
        let mut responses = Responses::default();
        let time_step = pressed.partings.first().map(Parting::time_step);
        let velocities = gather(&self.nodes, pressed.v);
        for register in 0..Lanes::registers::<S>() {
            let at = At { simd, register };
            self.respond(at, &places, &velocities, pressed.damping, time_step, &mut responses);
        }
        for (lane, (crack, index)) in self.contacts() {
            if self.alone[lane] != 0.0 {
                let (joint, contact) = (&mut joints[crack][index], &cracks[crack].contacts[index]);
                cracks[crack].press_alone(crack, contact, joint, pressed, losses);
                if !is_alone(joint) {
                    self.read(lane, contact, &cracks[crack], joint);
                }
                continue;
            }
            if self.state.closed[lane] != 0.0 {
                let force = pair(&responses.force, lane);
                for (nodes, shares) in self.nodes.iter().zip(&responses.shares) {
                    let (to, share) = (&mut pressed.forces[nodes[lane] as usize], shares[lane]);
                    to[0] += share * force[0];
                    to[1] += share * force[1];
                }
            }
            losses.friction += responses.friction[lane];
            losses.damping_power += responses.damping_power[lane];
            if let Some(parting) = pressed.partings.get_mut(crack) {
                let downstream = self.point.downstream[lane];
                let (mut nodes, mut shares) = ([0; 4], [0.0; 4]);
                for k in 0..4 {
                    nodes[k] = self.nodes[k][lane] as usize;
                    shares[k] = downstream * responses.shares[k][lane];
                }
                let stencil = parting::Stencil { nodes, shares, length: self.point.weight[lane] };
                let shares = [
                    (pair(&places.tangent, lane), responses.slips[lane]),
                    (pair(&places.normal, lane), responses.opened[lane]),
                ];
                parting.add(stencil, pair(&responses.place, lane), pair(&responses.relative, lane), shares);
            }
        }
    }

    /// Finds where the contacts are, given the displacements of their nodes.
    #[inline(always)]
    fn find<S: Simd>(&self, at: At<S>, displacements: &[[Lanes; 2]; 4], places: &mut Places) {
        let (zero, one) = (at.number(0.0), at.number(1.0));
        let [first, second, before, after] = displacements;
        let (first, second, before, after) =
            (at.both(first), at.both(second), at.both(before), at.both(after));
        let Points { downstream, share, part, length, rest, .. } = &self.point;
        let Segments { follows, apart, edge, abscissas, at_rest } = &self.segment;
        let (share, at_rest, rest) = (at.one(share), at.one(at_rest), at.both(rest));
        let turned = times(share, minus(second, first));
        let moved = plus(first, turned);
        let from_before = plus(at.both(&apart[0]), minus(moved, before));
        let from_after = plus(at.both(&apart[1]), minus(moved, after));
        let edge = plus(at.both(edge), minus(after, before));
        let along = product(from_before, edge);
        let square = product(edge, edge);
        let back = along.less_than(zero) & along.less_than(at.number(-MARGIN) * square);
        let forth = square.less_than(along) & (at.number(1.0 + MARGIN) * square).less_than(along);
        let [follows_back, follows_forth] = at.both(follows);
        let walks = (back & zero.less_than(follows_back)) | (forth & zero.less_than(follows_forth));
        let inverse = one / square;
        let position = along * inverse;
        let scale = square.sqrt() * inverse;
        let tangent = times(scale, edge);
        // out of the other side, to the left of it on the upper side
        let downstream = at.one(downstream);
        let normal = [downstream * -tangent[1], downstream * tangent[0]];
        let nearer = at.number(0.5).less_than(position);
        let offset =
            [nearer.select(from_after[0], from_before[0]), nearer.select(from_after[1], from_before[1])];
        let nearest = nearer.select(at.one(&abscissas[1]), at.one(&abscissas[0]));
        let slip = nearest + product(offset, tangent) * scale * at_rest;
        let [begin, end] = at.both(part);
        let margin = at.number(TILT) * (end - begin);
        let inside = (margin - slip).less_than(begin) & end.less_than(at.one(length) - slip - margin);
        at.store(position, &mut places.position);
        at.store(product(offset, normal), &mut places.gap);
        at.store(slip, &mut places.slip);
        at.store(at_rest * scale, &mut places.shortening);
        at.store(walks.select(one, zero), &mut places.walks);
        at.store(inside.select(zero, one), &mut places.ends);
        at.store_both(tangent, &mut places.tangent);
        at.store_both(normal, &mut places.normal);
        at.store_both(plus(plus(rest, first), turned), &mut places.point);
    }

    /// Updates the states of the contacts that are not alone, given the velocities of their nodes.
    #[inline(always)]
    fn respond<S: Simd>(
        &mut self,
        at: At<S>,
        places: &Places,
        velocities: &[[Lanes; 2]; 4],
        StiffnessDamping { coefficient, memory }: StiffnessDamping,
        time_step: Option<f64>,
        responses: &mut Responses,
    ) {
        let (zero, one, two) = (at.number(0.0), at.number(1.0), at.number(2.0));
        let states = &mut self.state;
        let (share, position) = (at.one(&self.point.share), at.one(&places.position));
        let shares = [one - share, share, position - one, -position];
        let mut relative = [zero; 2];
        for (share, velocity) in shares.into_iter().zip(velocities) {
            relative = plus(relative, times(share, at.both(velocity)));
        }
        let (normal, tangent) = (at.both(&places.normal), at.both(&places.tangent));
        let rates = [-product(relative, normal), product(relative, tangent)];
        let keeps = at.number(1.0 - memory);
        let felt = plus(times(at.number(memory), at.both(&states.rates)), times(keeps, rates));
        let gap = at.one(&places.gap);
        let (penetration, earlier) = (zero - gap, zero - at.one(&states.gap));
        let closed = zero.less_than(penetration);
        // as `acting_penetration`
        let change = (penetration - earlier).abs();
        let partly = closed & penetration.less_than(change);
        let acting = if coefficient == 0.0 || !partly.any() {
            penetration
        } else {
            let part = penetration * (one + penetration / change) / two;
            rates[0].equals(zero).select(penetration, partly.select(part, penetration))
        };
        // as `Coulomb`
        let none = acting.at_most(zero);
        let [normal_stiffness, shear_stiffness] = at.both(&self.law.stiffness);
        let damping = at.number(coefficient);
        let spring = normal_stiffness * acting;
        let pressure = spring + within(damping * normal_stiffness * felt[0], spring);
        let limit = at.one(&self.law.friction) * pressure;
        let (anchor, slip) = (at.one(&states.anchor), at.one(&places.slip));
        let stretched = slip - anchor;
        let trial = shear_stiffness * stretched;
        let elastic = within(trial, limit);
        let shear = within(elastic + damping * shear_stiffness * felt[1], limit);
        let slipping = none.select(zero, elastic.equals(trial).select(zero, one));
        let slips = zero.less_than(slipping);
        let stretch =
            if slips.any() { slips.select(elastic / shear_stiffness, stretched) } else { stretched };
        let stretch = none.select(zero, stretch);
        let dashpots = [none.select(zero, pressure - spring), none.select(zero, shear - elastic)];
        let (pressure, shear) = (none.select(zero, pressure), none.select(zero, shear));

        let free = slip - stretch;
        let next = closed.select(slips.select(free, anchor), free);
        let slid = next - anchor;
        let far = slid.abs();
        let weight = at.one(&self.point.weight);
        let before = at.one(&states.stretch);
        let slides = zero.less_than(far).any();
        let friction = if slides {
            let mean_shear = shear_stiffness * (weight * before + weight * stretch) / two;
            slid.equals(zero).select(zero, mean_shear * slid / at.one(&places.shortening))
        } else {
            zero
        };
        let [before_n, before_t] = times(weight, at.both(&states.dashpots));
        let damping_power = (before_n + weight * dashpots[0]) / two * rates[0]
            + (before_t + weight * dashpots[1]) / two * rates[1];
        // as `share_below_zero`
        let (was_open, is_open) = (earlier.less_than(zero), penetration.less_than(zero));
        let opens = (was_open | is_open).any();
        let open = if opens {
            let closing = is_open.select(one, earlier / (earlier - penetration));
            let opening = is_open.select(penetration / (penetration - earlier), zero);
            was_open.select(closing, opening)
        } else {
            zero
        };
        at.store(next, &mut states.anchor);
        at.store(stretch, &mut states.stretch);
        at.store(gap, &mut states.gap);
        at.store(at.one(&states.slipped) + (one - open) * far, &mut states.slipped);
        at.store(closed.select(one, zero), &mut states.closed);
        at.store(slipping, &mut states.slipping);
        at.store_both(dashpots, &mut states.dashpots);
        let kept = if memory > 0.0 { minus(felt, times(open * keeps, rates)) } else { [zero, zero] };
        at.store_both(kept, &mut states.rates);
        let force = times(weight, minus(times(pressure, normal), times(shear, tangent)));
        at.store_both(force, &mut responses.force);
        for (share, to) in shares.into_iter().zip(&mut responses.shares) {
            at.store(share, to);
        }
        at.store(friction, &mut responses.friction);
        at.store(damping_power, &mut responses.damping_power);
        let Some(time_step) = time_step else { return };
        let downstream = at.one(&self.point.downstream);
        let depth = downstream.less_than(zero).select(gap, zero);
        at.store_both(minus(at.both(&places.point), times(depth, normal)), &mut responses.place);
        at.store_both(times(downstream, relative), &mut responses.relative);
        // as `mean_below_zero` and `share_of_opening`
        let opened = if opens {
            let below = earlier.less_than(zero).select(earlier, zero) + is_open.select(penetration, zero);
            let gap = zero.less_than(open).select(open * below / at.number(-2.0), zero);
            let share = gap * normal_stiffness / at.number(CLOSING);
            one.less_than(share).select(one, share)
        } else {
            zero
        };
        // as `Parting::share_of_slip`
        let slipped = if slides {
            let restretched = stretch - before;
            let still = STANDSTILL * time_step;
            let whole = slid * slid + restretched * restretched + at.number(still * still);
            zero.less_than(whole).select(slid * slid / whole, zero)
        } else {
            zero
        };
        at.store(opened + (one - opened) * slipped, &mut responses.slips);
        at.store(opened, &mut responses.opened);
    }
}

/// One of the registers that hold the numbers of eight contacts. (Methods in the place of closures, whose code would not be for the
/// widest registers.)
#[derive(Clone, Copy)]
struct At<S: Simd> {
    simd: S,
    register: usize,
}

impl<S: Simd> At<S> {
    #[inline(always)]
    fn number(self, value: f64) -> Register<S> {
        Register::splat(self.simd, value)
    }

    #[inline(always)]
    fn one(self, lanes: &Lanes) -> Register<S> {
        lanes.load(self.simd, self.register)
    }

    #[inline(always)]
    fn both(self, [x, y]: &[Lanes; 2]) -> [Register<S>; 2] {
        [self.one(x), self.one(y)]
    }

    #[inline(always)]
    fn store(self, value: Register<S>, lanes: &mut Lanes) {
        lanes.store(self.register, value);
    }

    #[inline(always)]
    fn store_both(self, [x, y]: [Register<S>; 2], lanes: &mut [Lanes; 2]) {
        self.store(x, &mut lanes[0]);
        self.store(y, &mut lanes[1]);
    }
}

#[inline(always)]
fn plus<S: Simd>(a: [Register<S>; 2], b: [Register<S>; 2]) -> [Register<S>; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline(always)]
fn minus<S: Simd>(a: [Register<S>; 2], b: [Register<S>; 2]) -> [Register<S>; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

#[inline(always)]
fn times<S: Simd>(a: Register<S>, b: [Register<S>; 2]) -> [Register<S>; 2] {
    [a * b[0], a * b[1]]
}

/// The numbers of `field` at the nodes.
#[inline(always)]
fn gather(nodes: &[[u32; LANES]; 4], field: &[[f64; 2]]) -> [[Lanes; 2]; 4] {
    let mut gathered = [[Lanes::default(); 2]; 4];
    for (to, nodes) in gathered.iter_mut().zip(nodes) {
        for (lane, &node) in nodes.iter().enumerate() {
            let [x, y] = field[node as usize];
            to[0][lane] = x;
            to[1][lane] = y;
        }
    }
    gathered
}

#[inline(always)]
fn pair(lanes: &[Lanes; 2], lane: usize) -> [f64; 2] {
    [lanes[0][lane], lanes[1][lane]]
}

#[inline(always)]
fn product<S: Simd>(a: [Register<S>; 2], b: [Register<S>; 2]) -> Register<S> {
    a[0] * b[0] + a[1] * b[1]
}

/// As [`within`](super::super::coulomb::within).
#[inline(always)]
fn within<S: Simd>(value: Register<S>, limit: Register<S>) -> Register<S> {
    let value = limit.less_than(value).select(limit, value);
    let least = -limit;
    value.less_than(least).select(least, value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{Coulomb, Integration, MohrCoulomb};
    use crate::structure::Structure;
    use crate::{Kinematics, Material, Mesh, Plane, Section};

    /// Four blocks on one another. Of the cracks between them one has contacts at nodes, one at Gauss points, and the uppermost is bonded.
    fn stack() -> Structure<MohrCoulomb> {
        let rows = [vec![0.0, 1.0], vec![1.0, 2.0, 3.0], vec![3.0, 4.0], vec![4.0, 5.0]];
        let mesh = Mesh::mapped(&Section::rectangle(6.0, 5.0), &rows, 7);
        let material = Material {
            young_modulus: 1e9,
            poisson_ratio: 0.2,
            density: 2400.0,
            plane: Plane::Stress,
            tensile_strength: None,
        };
        let law = MohrCoulomb {
            residual: Coulomb { friction: 0.5, normal_stiffness: 1e9, shear_stiffness: 0.4e9 },
            friction: 0.5,
            cohesion: 0.0,
            tensile_strength: 0.0,
            dilation: 0.0,
            dilation_slip: f64::INFINITY,
        };
        let bonded = MohrCoulomb { cohesion: 2e6, tensile_strength: 1e6, ..law };
        let laws = [(law, Integration::Nodal), (law, Integration::Gauss), (bonded, Integration::Nodal)];
        Structure::new(mesh, &material, Kinematics::Corotational, laws, &[])
    }

    /// Blocks slide over one another and off, press, rock and part, and bonds break: with registers of any width, contacts, forces and
    /// rigid motions have the bits that they have one by one; losses are sums of the same terms.
    #[test]
    fn contacts_have_the_bits_of_each_alone() {
        let structure = stack();
        let (cracks, blocks) = (&structure.cracks[..], &structure.mesh.blocks);
        let mut seed = 5u32;
        let mut random = move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed) / f64::from(u32::MAX) - 0.5
        };
        let nodes = structure.mesh.nodes.len();
        let mut one_by_one = structure.at_rest().joints;
        let (mut wide, mut narrow) = (one_by_one.clone(), one_by_one.clone());
        let (mut seen, mut bonds_held) = ([0usize; 6], 0);
        let mut u = vec![[0.0; 2]; nodes];
        for attempt in 0..400 {
            // made anew for each communication step, as in a run
            let mut eights = [&wide, &narrow].map(|joints| Eights::of(cracks, joints));
            bonds_held += eights[0].others.len();
            let damping = [(1e-3, 0.4), (1e-3, 0.0), (0.0, 0.0)][attempt % 3];
            let damping = StiffnessDamping { coefficient: damping.0, memory: damping.1 };
            let parts = attempt % 4 != 3;
            for step in 0..10 {
                let time = (10 * attempt + step) as f64 / 4000.0;
                let before = u.clone();
                for (index, block) in blocks.iter().enumerate() {
                    // the uppermost block moves with the one below while its bonds are to hold
                    let index = if attempt < 40 { index.min(2) } else { index } as f64;
                    let far = index * (9.0 * time).sin() * if attempt % 40 < 20 { 3.5 } else { 0.02 };
                    let (up, turn) = (1e-4 * (90.0 * time).sin(), 2e-5 * (70.0 * time).cos());
                    for node in block.nodes.clone() {
                        let [x, y] = structure.mesh.nodes[node];
                        u[node] = [
                            far - index * turn * y + 2e-5 * random(),
                            index * (up + turn * (x - 3.0)) + 2e-5 * random(),
                        ];
                    }
                }
                let v: Vec<[f64; 2]> =
                    u.iter().zip(&before).map(|(u, w)| [0, 1].map(|d| (u[d] - w[d]) / 1e-3)).collect();
                let none = || {
                    let parting = Parting::every(1e-3);
                    (vec![[0.0; 2]; nodes], if parts { vec![parting; cracks.len()] } else { Vec::new() })
                };
                let (mut expected, mut parted) = none();
                let (mut lost, earlier) = (Losses::default(), one_by_one.clone());
                for (index, (crack, joints)) in cracks.iter().zip(&mut one_by_one).enumerate() {
                    let (contacts, parting) = (&crack.contacts, parted.get_mut(index));
                    lost = crack.press(contacts, &u, &v, damping, joints, &mut expected, parting, lost);
                }
                for (was, is) in earlier.iter().flatten().zip(one_by_one.iter().flatten()) {
                    let events = [
                        was.segment != is.segment,
                        is.status == ContactStatus::Slipping,
                        is.status == ContactStatus::Open && was.status != ContactStatus::Open,
                        was.status == ContactStatus::Open && is.status != ContactStatus::Open,
                        is.status == ContactStatus::Lost && was.status != ContactStatus::Lost,
                        was.status == ContactStatus::Lost && is.status != ContactStatus::Lost,
                    ];
                    seen.iter_mut().zip(events).for_each(|(count, event)| *count += usize::from(event));
                }
                for (eights, (joints, is_wide)) in
                    eights.iter_mut().zip([(&mut wide, true), (&mut narrow, false)])
                {
                    let (mut forces, mut partings) = none();
                    let pressed =
                        Pressed { u: &u, v: &v, damping, forces: &mut forces, partings: &mut partings };
                    let call = Press { eights: &mut *eights, cracks, joints: &mut *joints, pressed };
                    let losses = match is_wide {
                        true => pulp::Arch::new().dispatch(call),
                        false => call.with_simd(pulp::Scalar::new()),
                    };
                    let bits = |forces: &[[f64; 2]]| -> Vec<u64> {
                        forces.as_flattened().iter().map(|force| force.to_bits()).collect()
                    };
                    assert_eq!(bits(&forces), bits(&expected), "{time}");
                    let rates = |partings: &[Parting]| partings.iter().map(Parting::rate).collect::<Vec<_>>();
                    assert_eq!(rates(&partings), rates(&parted));
                    assert_eq!(eights.are_calm(joints), one_by_one.iter().flatten().all(JointState::is_calm));
                    // cracks with bonds come last
                    for (a, b) in
                        [(losses.friction, lost.friction), (losses.damping_power, lost.damping_power)]
                    {
                        assert!((a - b).abs() <= 1e-13 * (a.abs() + 1e3), "{a} and {b}");
                    }
                    let mut now = joints.clone();
                    eights.write(&mut now);
                    assert_eq!(now, one_by_one);
                }
            }
            for (eights, joints) in eights.iter().zip([&mut wide, &mut narrow]) {
                eights.write(joints);
                // with the signs of zeros
                assert_eq!(format!("{joints:?}"), format!("{one_by_one:?}"));
                for (eight, (lane, (crack, index))) in
                    eights.eights.iter().flat_map(|eight| eight.contacts().map(move |at| (eight, at)))
                {
                    assert_eq!(eight.alone[lane] != 0.0, is_alone(&joints[crack][index]), "it came back");
                }
            }
        }
        println!("segments, slips, opened, closed, lost, found: {seen:?}; bonds held in {bonds_held} steps");
        assert!(seen.iter().all(|&count| count > 100) && (20..300).contains(&bonds_held));
    }
}
