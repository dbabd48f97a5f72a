use super::place::Place;
use super::position::MovedPoint;
use super::side::Contact;
use super::simd::NodalFields;
use super::update::{Moved, Special, State, Update, mean_energy};
use super::{ContactLaw, ContactStatus, Crack, JointState, relief};
use crate::damping::StiffnessDamping;
use crate::energy::Losses;

impl<L: ContactLaw> Crack<L> {
    /// Adds the contact forces to `forces` and updates `joints`.
    ///
    /// **Shapes and units**: `displacement` (m), `velocity` (m/s) and `forces` (N/m) hold one pair for each
    /// node, `joints` one state for each contact; `damping` is β (s), with or without memory. The memory takes in
    /// rates for the share of a time step in which the contact was closed: so the dashpot forces of a contact that
    /// closes grow over the time of the memory (with the full force at once it would rebound), and a contact that
    /// opens for a moment has the forces of one that nearly does.
    pub fn add_forces(
        &self,
        displacement: &[[f64; 2]],
        velocity: &[[f64; 2]],
        damping: impl Into<StiffnessDamping>,
        joints: &mut [JointState],
        forces: &mut [[f64; 2]],
    ) -> Losses {
        let mut fields =
            NodalFields { u: displacement, v: velocity, damping: damping.into(), forces, partings: &mut [] };
        self.add_forces_one_by_one(0, joints, &mut fields, Losses::default())
    }

    /// Adds the forces of all contacts, one after the other, to those of `fields`, and what they lose to `losses`. `crack` is the number
    /// of this crack.
    #[inline(always)]
    pub(super) fn add_forces_one_by_one(
        &self,
        crack: usize,
        joints: &mut [JointState],
        fields: &mut NodalFields<'_>,
        losses: Losses,
    ) -> Losses {
        self.add_forces_of(&self.contacts, crack, joints, fields, losses)
    }

    /// The same of one contact. (Not compiled for the widest registers.)
    #[cold]
    #[inline(never)]
    pub(super) fn add_force_of_one(
        &self,
        contact: &Contact,
        crack: usize,
        joint: &mut JointState,
        fields: &mut NodalFields<'_>,
        losses: &mut Losses,
    ) {
        let (contacts, joints) = (std::slice::from_ref(contact), std::slice::from_mut(joint));
        *losses = self.add_forces_of(contacts, crack, joints, fields, *losses);
    }

    /// The same of some contacts.
    #[inline(always)]
    fn add_forces_of(
        &self,
        contacts: &[Contact],
        crack: usize,
        joints: &mut [JointState],
        fields: &mut NodalFields<'_>,
        mut losses: Losses,
    ) -> Losses {
        let NodalFields { u, v, damping, forces, partings } = fields;
        let (u, v, forces) = (*u, *v, &mut **forces);
        let mut parting = partings.get_mut(crack);
        let dilates = self.law.dilates();
        for (contact, joint) in contacts.iter().zip(joints) {
            let place = self.place(contact, joint.segment as usize, |node| u[node]);
            let risen = if dilates { self.law.dilation(joint.slipped) } else { 0.0 };
            let lost = joint.status == ContactStatus::Lost;
            let fell = lost && self.has_fallen(contact, &place, risen - place.at.gap, u);
            if place.coverage == 0.0 || fell {
                losses.friction += self.lose(contact, &place, risen, joint);
                continue;
            }
            let special = Special {
                weight: contact.weight * joint.coverage,
                risen,
                penetration: joint.penetration,
                closed: joint.is_closed(),
                lost,
                bonded: joint.bonded,
                may_hold: joint.bonded && joint.fuse != Some(joint.lasted),
            };
            let nodes = place.nodes_of_both();
            let displacements = place.point.nodes.map(|node| u[node]);
            let moved = Moved {
                downstream: contact.downstream(),
                share: place.point.share,
                weight: contact.weight * place.coverage,
                point: MovedPoint::new(place.point.rest, place.point.share, displacements).position(),
                at: place.at,
                velocities: nodes.map(|node| v[node]),
            };
            let state = State { anchor: if lost { place.at.slip } else { joint.anchor }, ..joint.state() };
            let time_step = parting.as_ref().map(|parting| parting.time_step());
            let last = joint.gap - risen;
            let (update, jump) = moved.update(&self.law, *damping, &state, Some(&special), time_step);
            joint.set(&place, &update);
            losses.friction += update.friction;
            update.special_friction.into_iter().for_each(|friction| losses.friction += friction);
            losses.damping_power += update.damping_power;
            if let (Some(parting), Some(jump)) = (&mut parting, jump) {
                let shares = [(place.at.tangent, jump.slips), (place.at.normal, jump.opened)];
                parting.add(contact.stencil(&place), jump.place, jump.relative, shares);
            }
            if joint.relief > 0.0 && !update.closed {
                // the force that the pressure no longer exerts on the open contact, and the work that it no longer does
                let gap = place.at.gap - risen;
                let [before, now] = [last, gap].map(|gap| relief(gap, joint.relief, &self.law));
                let before = if special.closed { 0.0 } else { before };
                losses.relief += moved.weight * (before + now) / 2.0 * (gap.max(0.0) - last.max(0.0));
                let force = place.at.normal.map(|n| -moved.weight * now * n);
                for (&node, share) in nodes.iter().zip(update.shares).filter(|_| now > 0.0) {
                    forces[node][0] += share * force[0];
                    forces[node][1] += share * force[1];
                }
            }
            if !update.closed {
                continue;
            }
            for (&node, share) in nodes.iter().zip(update.shares) {
                forces[node][0] += share * update.force[0];
                forces[node][1] += share * update.force[1];
            }
            if risen > 0.0 {
                // the rise separates the two shear forces; a couple on the segment balances their moment
                let force = moved.weight * update.shear * risen * place.at.shortening / place.at_rest;
                let ([first, last], n) = (place.slides_on, place.at.normal);
                for d in 0..2 {
                    forces[first][d] += force * n[d];
                    forces[last][d] -= force * n[d];
                }
            }
        }
        losses
    }

    /// Sets the state of a contact that lies beyond the end of the other side; returns the energy that is lost with its springs, J/m.
    fn lose(&self, contact: &Contact, place: &Place, risen: f64, joint: &mut JointState) -> f64 {
        let (penetration, stretch) = (risen - place.at.gap, place.at.slip - joint.anchor);
        let energy =
            mean_energy(self.law.stiffness(), joint.penetration * penetration, joint.stretch, stretch);
        let weight = contact.weight * joint.coverage;
        *joint = JointState {
            segment: place.segment as u32,
            status: ContactStatus::Lost,
            anchor: place.at.slip,
            stretch: 0.0,
            gap: place.at.gap,
            penetration: 0.0,
            coverage: 0.0,
            bonded: false,
            slipped: joint.slipped,
            dashpots: [0.0; 2],
            rates: [0.0; 2],
            lasted: joint.lasted,
            fuse: joint.fuse,
            relief: joint.relief,
        };
        weight * energy
    }
}

impl JointState {
    /// Whether it is closed or bonded.
    pub(super) fn is_closed(&self) -> bool {
        matches!(self.status, ContactStatus::Sticking | ContactStatus::Slipping)
    }

    pub(super) fn state(&self) -> State {
        let JointState { anchor, stretch, gap, slipped, dashpots, rates, .. } = *self;
        State { anchor, stretch, gap, slipped, dashpots, rates }
    }

    pub(super) fn set_state(&mut self, state: State, closed: bool, slipping: bool, penetration: f64) {
        let State { anchor, stretch, gap, slipped, dashpots, rates } = state;
        let status = match (closed, slipping) {
            (false, _) => ContactStatus::Open,
            (true, true) => ContactStatus::Slipping,
            (true, false) => ContactStatus::Sticking,
        };
        let penetration = if closed { penetration } else { 0.0 };
        *self = Self { status, anchor, stretch, gap, penetration, slipped, dashpots, rates, ..*self };
    }

    #[inline(always)]
    fn set(&mut self, place: &Place, update: &Update<f64>) {
        self.set_state(update.state, update.closed, update.slipping, update.penetration);
        self.segment = place.segment as u32;
        self.coverage = place.coverage;
        self.bonded = update.bonded;
        self.lasted += u32::from(update.bonded && self.fuse.is_some());
    }
}
