mod eights;

use serde::{Deserialize, Serialize};

use super::parting::{self, Parting};
use super::search::{Chain, find_segment};
use super::{ContactLaw, Coulomb, Integration, MohrCoulomb, Touch};
use crate::damping::StiffnessDamping;
use crate::energy::Losses;
use crate::{Mesh, Seam};
pub(crate) use eights::{Eights, Pressed};

/// Status of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ContactStatus {
    /// Closed or bonded, below the shear strength.
    Sticking,
    /// Closed, at the shear strength.
    Slipping,
    /// Gap between the sides.
    Open,
    /// Its whole part lies beyond the end of the other side.
    Lost,
}

/// State of one contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointState {
    /// Segment of the other side, from which the next search starts.
    pub segment: u32,
    /// Status.
    pub status: ContactStatus,
    /// Tangential position to which the shear spring is attached: the abscissa along the other side minus that of the
    /// contact's point along its own side, m.
    pub anchor: f64,
    /// Stretch of the shear spring, m.
    pub stretch: f64,
    /// Distance from the other side, m; negative for overlap; without the rise by dilation.
    pub gap: f64,
    /// Last penetration, including the rise by dilation up to then, m; negative in a bond under tension.
    pub penetration: f64,
    /// Share of the contact's length that lies opposite the other side.
    pub coverage: f64,
    /// Whether the bond is intact.
    pub bonded: bool,
    /// Accumulated slip in both directions while closed, m.
    pub slipped: f64,
    /// Normal and shear stress of the dashpots, Pa.
    pub dashpots: [f64; 2],
    /// Rates of penetration and slip while closed, with the memory of damping, m/s. They fade while the contact is open; 0
    /// for damping without memory, which does not need them.
    pub rates: [f64; 2],
    /// Time steps that the bond has lasted since its fuse was set, and may last; both only within a communication step.
    #[serde(skip)]
    pub(crate) lasted: u32,
    #[serde(skip)]
    pub(crate) fuse: Option<u32>,
}

impl JointState {
    /// Whether it sticks or is lost.
    pub(crate) fn is_calm(&self) -> bool {
        matches!(self.status, ContactStatus::Sticking | ContactStatus::Lost)
    }
}

/// A crack between two bodies: two chains of nodes, the contacts between them, and their law.
#[derive(Clone, Debug)]
pub struct Crack<L: ContactLaw = Coulomb> {
    law: L,
    /// Lower and upper side.
    sides: [Side; 2],
    /// Contacts of the points of the upper side, then of the lower side.
    contacts: Vec<Contact>,
    /// The slip of each in the unloaded position, m.
    slips_at_rest: Vec<f64>,
}

#[derive(Clone, Debug)]
struct Side {
    nodes: Vec<usize>,
    /// Unloaded positions, m.
    rest: Vec<[f64; 2]>,
    /// Tributary lengths of the nodes that their contacts stand for, m: half of them, or all if the other side is the ground.
    weights: Vec<f64>,
    /// Unloaded length of the chain up to each node, m.
    abscissas: Vec<f64>,
}

/// A contact of one side with the other.
#[derive(Clone, Copy, Debug)]
struct Contact {
    /// Its side: 0 for the lower, 1 for the upper side.
    side: usize,
    /// Its point.
    point: Point,
    /// Part of the side that it represents, from and to this abscissa, m.
    part: [f64; 2],
    /// Length for which it stands, m: half of this part, as the contacts of the other side have the other half; all of it
    /// if the other side is the ground.
    weight: f64,
    /// Segments of its side on which its part begins and ends. The first search along the other side starts
    /// from `after`.
    before: usize,
    after: usize,
}

impl Contact {
    /// Sign of its slip when the block above slides downstream.
    fn downstream(&self) -> f64 {
        if self.side == 1 { 1.0 } else { -1.0 }
    }

    /// How the motion of the upper side relative to the lower one follows from the nodes'.
    fn stencil(&self, place: &Place) -> parting::Stencil {
        parting::Stencil {
            nodes: place.nodes_of_both(),
            shares: place.shares().map(|share| self.downstream() * share),
            length: self.weight * place.coverage,
        }
    }
}

/// A point of a side.
#[derive(Clone, Copy, Debug)]
struct Point {
    /// The nodes before and after it; for a point at a node, this node twice.
    nodes: [usize; 2],
    /// Position between them, from 0 to 1.
    share: f64,
    /// Unloaded position, m.
    rest: [f64; 2],
    /// Unloaded length of the side up to it, m.
    abscissa: f64,
}

/// A point beside the other side, with its displacement, and the displacements of nodes.
struct Beside<'a, U> {
    other: &'a Side,
    rest: [f64; 2],
    own: [f64; 2],
    u: U,
}

impl<U: Fn(usize) -> [f64; 2]> Beside<'_, U> {
    /// From a node of the other side to the point, m; differences of unloaded positions and of displacements separately, so that no
    /// digits are lost.
    #[inline(always)]
    fn from(&self, node: usize) -> [f64; 2] {
        let (rest, moved) = (self.other.rest[node], (self.u)(self.other.nodes[node]));
        [self.rest[0] - rest[0] + (self.own[0] - moved[0]), self.rest[1] - rest[1] + (self.own[1] - moved[1])]
    }
}

impl<U: Fn(usize) -> [f64; 2]> Chain for Beside<'_, U> {
    #[inline(always)]
    fn project(&self, segment: usize) -> ([f64; 2], [f64; 2]) {
        #[cfg(test)]
        super::effort::spend(|effort| effort.segments += 1);
        let edge = self.other.edge(segment, &self.u);
        ([product(self.from(segment), edge), product(edge, edge)], edge)
    }
}

#[inline(always)]
fn product(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Spring of a closed contact in the unloaded position: `K = Σ weights ⊗ (k_n n nᵀ + k_s t tᵀ) ⊗ weights`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stencil {
    /// The two nodes next to the contact's point (or the same node twice), and the two nodes of the opposite segment.
    pub nodes: [usize; 4],
    /// Weights of these nodes in the relative displacement.
    pub weights: [f64; 4],
    /// `k_n n nᵀ + k_s t tᵀ` times the contact's length, N/m per metre of dam.
    pub stiffness: [[f64; 2]; 2],
}

/// Resultant forces across a crack, N/m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CrackForces {
    /// Normal force, positive in compression.
    pub normal: f64,
    /// Shear force on the block below, positive downstream.
    pub shear: f64,
    /// Sum of the shear strengths of the contacts.
    pub strength: f64,
}

impl Crack<MohrCoulomb> {
    /// Sums over the contacts of the forces normal and tangential to the sides, whatever the directions of these.
    pub fn forces(&self, joints: &[JointState]) -> CrackForces {
        let mut sum = CrackForces::default();
        for ((contact, joint), [normal, shear]) in self.contacts.iter().zip(joints).zip(self.stresses(joints))
        {
            let weight = contact.weight * joint.coverage;
            sum.normal += weight * normal;
            sum.shear += weight * shear;
            // for a bonded contact the strength depends on the spring force only, as in the law
            let pressing = if joint.bonded { normal - joint.dashpots[0] } else { normal };
            sum.strength += weight * self.law.strength(pressing, joint.bonded);
        }
        sum
    }
}

/// Current position of a contact.
struct Place {
    /// Its point.
    point: Point,
    /// Segment of the other side that it is opposite to.
    segment: usize,
    /// The segment's nodes.
    nodes: [usize; 2],
    position: f64,
    tangent: [f64; 2],
    normal: [f64; 2],
    gap: f64,
    slip: f64,
    /// The segment along which it slides: its nodes, its unloaded length (m), and this over the current one.
    /// `slip` is in unloaded lengths.
    slides_on: [usize; 2],
    at_rest: f64,
    shortening: f64,
    /// Share of the part of the contact that lies opposite the other side.
    coverage: f64,
}

impl Place {
    /// The nodes around its point, and those of the segment opposite.
    fn nodes_of_both(&self) -> [usize; 4] {
        let ([first, second], [third, fourth]) = (self.point.nodes, self.nodes);
        [first, second, third, fourth]
    }

    /// Their weights in the relative displacement.
    fn shares(&self) -> [f64; 4] {
        let (share, position) = (self.point.share, self.position);
        [1.0 - share, share, position - 1.0, -position]
    }
}

impl<L: ContactLaw> Crack<L> {
    /// The crack along a `seam` of `mesh`. `integration` determines the points of contact; the ground, which is rigid,
    /// has none of its own, so that those of the other side have their whole length.
    pub fn new(mesh: &Mesh, seam: &Seam, law: L, integration: Integration) -> Self {
        let sides_with_points: &[usize] = if mesh.is_ground(seam.below) { &[1] } else { &[1, 0] };
        let share = 1.0 / sides_with_points.len() as f64;
        let side = |nodes: &[usize]| {
            let rest: Vec<[f64; 2]> = nodes.iter().map(|&node| mesh.nodes[node]).collect();
            let mut abscissas = vec![0.0];
            for pair in rest.windows(2) {
                let ([x0, y0], [x1, y1]) = (pair[0], pair[1]);
                abscissas.push(abscissas[abscissas.len() - 1] + (x1 - x0).hypot(y1 - y0));
            }
            let weights = mesh.tributary_lengths(nodes).iter().map(|length| share * length).collect();
            Side { nodes: nodes.to_vec(), rest, weights, abscissas }
        };
        let sides = [side(&seam.lower), side(&seam.upper)];
        let points = sides_with_points.iter();
        let contacts = points.flat_map(|&side| sides[side].contacts(side, integration, share)).collect();
        let mut crack = Self { law, sides, contacts, slips_at_rest: Vec::new() };
        let at_rest = |contact: &Contact| crack.place(contact, contact.after, |_| [0.0; 2]).slip;
        crack.slips_at_rest = crack.contacts.iter().map(at_rest).collect();
        crack
    }

    /// The same crack, in which each node has the number `number(node)`.
    pub(crate) fn renumbered(&self, number: impl Fn(usize) -> usize) -> Self {
        let mut crack = self.clone();
        let sides = crack.sides.iter_mut().flat_map(|side| &mut side.nodes);
        let contacts = crack.contacts.iter_mut().flat_map(|contact| &mut contact.point.nodes);
        sides.chain(contacts).for_each(|node| *node = number(*node));
        crack
    }

    /// The law.
    pub fn law(&self) -> &L {
        &self.law
    }

    /// Nodes of the lower and of the upper side.
    pub fn sides(&self) -> [&[usize]; 2] {
        [&self.sides[0].nodes, &self.sides[1].nodes]
    }

    /// Tributary lengths of the nodes on the lower and on the upper side, m, each times the same share.
    pub fn weights(&self) -> [&[f64]; 2] {
        [&self.sides[0].weights, &self.sides[1].weights]
    }

    /// Contacts without load: those of the points of the upper side, then those of the lower side. Shear
    /// springs are attached at the unloaded positions of the points, also if the two sides begin at different
    /// places.
    pub fn joints_at_rest(&self) -> Vec<JointState> {
        let joint = |contact: &Contact| {
            let place = self.place(contact, contact.after, |_| [0.0; 2]);
            JointState {
                segment: place.segment as u32,
                status: ContactStatus::Sticking,
                anchor: place.slip,
                stretch: 0.0,
                gap: 0.0,
                penetration: 0.0,
                coverage: place.coverage,
                bonded: self.law.is_bonded(),
                slipped: 0.0,
                dashpots: [0.0; 2],
                rates: [0.0; 2],
                lasted: 0,
                fuse: None,
            }
        };
        self.contacts.iter().map(joint).collect()
    }

    /// Current position of a contact. Its point is moved along its part if the other side does not lie opposite.
    #[inline(always)]
    fn place(&self, contact: &Contact, start: usize, u: impl Fn(usize) -> [f64; 2]) -> Place {
        let place = self.opposite(contact.side, contact.point, start, &u);
        let [from, to] = contact.part;
        let other = &self.sides[1 - contact.side];
        let length = other.abscissas[other.abscissas.len() - 1];
        // if a side is tilted, the slip gives the position of its end only approximately
        let margin = TILT * (to - from);
        if from > margin - place.slip && to < length - place.slip - margin {
            return place;
        }
        self.near_an_end(contact, place, u)
    }

    /// Whether a lost contact is not to be found again: it lies deep beside the other side, or its block has turned over, so
    /// that both sides no longer run the same way.
    #[cold]
    #[inline(never)]
    fn has_fallen(&self, contact: &Contact, place: &Place, penetration: f64, u: &[[f64; 2]]) -> bool {
        let own = self.sides[contact.side].edge(contact.after, |node| u[node]);
        let along = own[0] * place.tangent[0] + own[1] * place.tangent[1];
        penetration > SHALLOW * contact.weight || along <= 0.0
    }

    /// From and to which abscissa the part of a contact lies opposite the other side, m.
    #[inline(always)]
    fn facing(&self, contact: &Contact, u: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
        let [from, to] = contact.part;
        let end = self.sides[1 - contact.side].nodes.len() - 1;
        [from.max(self.opposite_to(0, contact, &u)), to.min(self.opposite_to(end, contact, &u))]
    }

    /// The abscissa opposite a corner of the other side, on the segment before or after the contact's point, m.
    #[inline(always)]
    fn opposite_to(&self, corner: usize, contact: &Contact, u: impl Fn(usize) -> [f64; 2]) -> f64 {
        let (own, other) = (&self.sides[contact.side], &self.sides[1 - contact.side]);
        let foot = own.foot(contact.before, other, corner, &u);
        let middle = contact.point.abscissa;
        if foot <= middle { foot } else { own.foot(contact.after, other, corner, &u).max(middle) }
    }

    /// Whether the part of a contact lies wholly opposite the other side.
    fn is_whole(&self, contact: &Contact, u: &[[f64; 2]]) -> bool {
        let ([first, last], [from, to]) = (self.facing(contact, |node| u[node]), contact.part);
        last - first >= to - from
    }

    /// The same for a contact at the place `opposite` that may be near an end of the other side.
    #[inline(always)]
    fn near_an_end(&self, contact: &Contact, opposite: Place, u: impl Fn(usize) -> [f64; 2]) -> Place {
        let (own, other) = (&self.sides[contact.side], &self.sides[1 - contact.side]);
        let [from, to] = contact.part;
        let end = other.nodes.len() - 1;
        let [first, last] = self.facing(contact, &u);
        if last - first >= to - from {
            return opposite;
        }
        let coverage = (last - first).max(0.0) / (to - from);
        let abscissa = contact.point.abscissa.max(first).min(last);
        if coverage == 0.0 || abscissa == contact.point.abscissa {
            return Place { coverage, ..opposite };
        }
        let (segment, corner) =
            if abscissa < contact.point.abscissa { (contact.before, end) } else { (contact.after, 0) };
        // the other side's corner against this side, whose direction it slides along
        let point = own.point(segment, abscissa);
        let edge = own.edge(segment, &u);
        let length = (edge[0] * edge[0] + edge[1] * edge[1]).sqrt();
        let at_rest = own.abscissas[segment + 1] - own.abscissas[segment];
        let tangent = edge.map(|component| component / length);
        let normal = normal(contact.side, tangent);
        let ([rest, moved], [first, second]) =
            ([other.rest[corner], u(other.nodes[corner])], point.nodes.map(&u));
        let [x, y] = [0, 1]
            .map(|d| point.rest[d] - rest[d] + (first[d] + point.share * (second[d] - first[d]) - moved[d]));
        Place {
            point,
            segment: opposite.segment,
            nodes: [other.nodes[corner]; 2],
            position: 0.0,
            tangent,
            normal,
            gap: x * normal[0] + y * normal[1],
            slip: other.abscissas[corner] - abscissa,
            slides_on: point.nodes,
            at_rest,
            shortening: at_rest / length,
            coverage,
        }
    }

    /// Projection of a `point` of `side` onto the other side, or onto the line of its end segment.
    #[inline(always)]
    fn opposite(&self, side: usize, point: Point, start: usize, u: impl Fn(usize) -> [f64; 2]) -> Place {
        let other = &self.sides[1 - side];
        let [first, second] = point.nodes.map(&u);
        let own = [0, 1].map(|d| first[d] + point.share * (second[d] - first[d]));
        let beside = Beside { other, rest: point.rest, own, u: &u };
        let (segment, [along, square], edge) = find_segment(start, other.nodes.len() - 1, &beside);
        let inverse = 1.0 / square;
        let position = along * inverse;
        let scale = square.sqrt() * inverse;
        let tangent = [edge[0] * scale, edge[1] * scale];
        let normal = normal(side, tangent);
        let at_rest = other.abscissas[segment + 1] - other.abscissas[segment];
        let shortening = at_rest * scale;
        // relative to the nearer end, so that the result is exact for matching nodes
        let nearest = if position > 0.5 { segment + 1 } else { segment };
        let offset = beside.from(nearest);
        let along = product(offset, tangent) * scale;
        Place {
            point,
            segment,
            nodes: [other.nodes[segment], other.nodes[segment + 1]],
            position,
            tangent,
            normal,
            gap: product(offset, normal),
            slip: other.abscissas[nearest] - point.abscissa + along * at_rest,
            slides_on: [other.nodes[segment], other.nodes[segment + 1]],
            at_rest,
            shortening,
            coverage: 1.0,
        }
    }

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
        let (damping, none) = (damping.into(), Losses::default());
        self.press(&self.contacts, displacement, velocity, damping, joints, forces, None, none)
    }

    /// The same of some contacts, added to the `losses`; also adds them to the `parting` of the sides, if there is one.
    #[allow(clippy::too_many_arguments)] // the contacts of a crack and what [`Pressed`] holds, of this crack alone
    #[inline(always)]
    fn press(
        &self,
        contacts: &[Contact],
        displacement: &[[f64; 2]],
        velocity: &[[f64; 2]],
        damping: StiffnessDamping,
        joints: &mut [JointState],
        forces: &mut [[f64; 2]],
        mut parting: Option<&mut Parting>,
        mut losses: Losses,
    ) -> Losses {
        let StiffnessDamping { coefficient, memory } = damping;
        let [normal_stiffness, shear_stiffness] = self.law.stiffness();
        for (contact, joint) in contacts.iter().zip(joints) {
            let place = self.place(contact, joint.segment as usize, |node| displacement[node]);
            let [before, weight] = [joint.coverage, place.coverage].map(|share| contact.weight * share);
            let risen = self.law.dilation(joint.slipped);
            let penetration = risen - place.gap;
            let fell = joint.status == ContactStatus::Lost
                && self.has_fallen(contact, &place, penetration, displacement);
            if place.coverage == 0.0 || fell {
                losses.friction += before
                    * self.mean_energy(joint, joint.penetration * penetration, place.slip - joint.anchor);
                *joint = JointState {
                    segment: place.segment as u32,
                    status: ContactStatus::Lost,
                    anchor: place.slip,
                    stretch: 0.0,
                    gap: place.gap,
                    penetration: 0.0,
                    coverage: 0.0,
                    bonded: false,
                    slipped: joint.slipped,
                    dashpots: [0.0; 2],
                    rates: [0.0; 2],
                    lasted: joint.lasted,
                    fuse: joint.fuse,
                };
                continue;
            }
            let mut earlier = joint.penetration;
            if joint.status == ContactStatus::Lost {
                joint.anchor = place.slip;
                earlier = (risen - joint.gap).max(0.0);
            }
            let Point { nodes: own, share, .. } = place.point;
            let (nodes, shares) = (place.nodes_of_both(), place.shares());
            let relative = weighted(nodes, shares, velocity);
            let along = |axis: [f64; 2]| relative[0] * axis[0] + relative[1] * axis[1];
            let rates = [-along(place.normal), along(place.tangent)];
            let felt = [0, 1].map(|i| memory * joint.rates[i] + (1.0 - memory) * rates[i]);
            let earlier_penetration =
                if joint.status == ContactStatus::Lost { penetration } else { risen - joint.gap };
            let acting = if joint.bonded || coefficient == 0.0 || rates[0] == 0.0 {
                penetration
            } else {
                acting_penetration(penetration, penetration - earlier_penetration)
            };
            let response = self.law.respond(&Touch {
                penetration: acting,
                penetration_rate: felt[0],
                stretch: place.slip - joint.anchor,
                slip_rate: felt[1],
                damping: coefficient,
                bonded: joint.bonded && joint.fuse != Some(joint.lasted),
            });
            let closed = penetration > 0.0 || response.bonded;
            let slips = response.slipping || !closed;
            let anchor = if slips { place.slip - response.stretch } else { joint.anchor };
            let slip = anchor - joint.anchor;
            if slip != 0.0 {
                let mean_shear = shear_stiffness * (before * joint.stretch + weight * response.stretch) / 2.0;
                // the shear force does its work along the current length
                losses.friction += mean_shear * slip / place.shortening;
            }
            if weight != before {
                // springs appear and disappear with the part of the contact that they represent
                losses.friction +=
                    (before - weight) * self.mean_energy(joint, earlier * penetration, response.stretch);
            }
            if matches!(joint.status, ContactStatus::Sticking | ContactStatus::Slipping) {
                // dilation since the last evaluation has pressed the sides together
                let rise = risen - joint.gap - joint.penetration;
                let pressed = before * joint.penetration + weight * penetration.max(0.0);
                losses.friction -= normal_stiffness * pressed / 2.0 * rise;
            }
            if joint.bonded && !response.bonded && penetration < 0.0 {
                losses.friction += weight * self.mean_energy(joint, earlier * penetration, 0.0);
            }
            let mean = |i: usize| (before * joint.dashpots[i] + weight * response.dashpots[i]) / 2.0;
            losses.damping_power += mean(0) * rates[0] + mean(1) * rates[1];
            let restretched = response.stretch - joint.stretch;
            let bonded = response.bonded;
            let open = if bonded { 0.0 } else { share_below_zero(earlier_penetration, penetration) };
            let status = match (closed, response.slipping) {
                (false, _) => ContactStatus::Open,
                (true, true) => ContactStatus::Slipping,
                (true, false) => ContactStatus::Sticking,
            };
            *joint = JointState {
                segment: place.segment as u32,
                status,
                anchor,
                stretch: response.stretch,
                gap: place.gap,
                penetration: if closed { penetration } else { 0.0 },
                coverage: place.coverage,
                bonded,
                slipped: joint.slipped + (1.0 - open) * slip.abs(),
                dashpots: response.dashpots,
                rates: [0, 1]
                    .map(|i| if memory > 0.0 { felt[i] - open * (1.0 - memory) * rates[i] } else { 0.0 }),
                lasted: joint.lasted + u32::from(response.bonded && joint.fuse.is_some()),
                fuse: joint.fuse,
            };
            if let Some(parting) = &mut parting {
                // the jump is the motion of the upper side relative to the lower one, at the upper side
                let sign = contact.downstream();
                let depth = if contact.side == 1 { 0.0 } else { place.gap };
                let [first, second] = own.map(|node| displacement[node]);
                let at = [0, 1].map(|d| {
                    let own = place.point.rest[d] + first[d] + share * (second[d] - first[d]);
                    own - depth * place.normal[d]
                });
                let relative = relative.map(|component| sign * component);
                let stencil = contact.stencil(&place);
                let gap = if open > 0.0 { mean_below_zero(earlier_penetration, penetration) } else { 0.0 };
                let opened = parting::share_of_opening(gap, normal_stiffness);
                let slips = parting.share_of_slip(slip, restretched);
                let slips = opened + (1.0 - opened) * slips;
                parting.add(stencil, at, relative, [(place.tangent, slips), (place.normal, opened)]);
            }
            if !closed {
                continue;
            }
            let (n, t) = (place.normal, place.tangent);
            let force = [
                weight * (response.normal * n[0] - response.shear * t[0]),
                weight * (response.normal * n[1] - response.shear * t[1]),
            ];
            for (&node, share) in nodes.iter().zip(shares) {
                forces[node][0] += share * force[0];
                forces[node][1] += share * force[1];
            }
            if risen > 0.0 {
                // the rise separates the two shear forces; a couple on the segment balances their moment
                let force = weight * response.shear * risen * place.shortening / place.at_rest;
                let [first, last] = place.slides_on;
                for d in 0..2 {
                    forces[first][d] += force * n[d];
                    forces[last][d] -= force * n[d];
                }
            }
        }
        losses
    }

    /// The same of one contact, not by the widest registers; `crack` is the number of this crack.
    #[cold]
    #[inline(never)]
    fn press_alone(
        &self,
        crack: usize,
        contact: &Contact,
        joint: &mut JointState,
        pressed: &mut Pressed<'_>,
        losses: &mut Losses,
    ) {
        let Pressed { u, v, damping, forces, partings } = pressed;
        let (contacts, joints) = (std::slice::from_ref(contact), std::slice::from_mut(joint));
        *losses = self.press(contacts, u, v, *damping, joints, forces, partings.get_mut(crack), *losses);
    }

    /// Normal stress (compression positive) and shear stress on the block below (positive downstream) of each
    /// contact, dashpots included, Pa.
    pub fn stresses<'a>(&'a self, joints: &'a [JointState]) -> impl Iterator<Item = [f64; 2]> + 'a {
        let [normal, shear] = self.law.stiffness();
        self.contacts.iter().zip(joints).map(move |(contact, joint)| {
            let on_the_other = shear * joint.stretch + joint.dashpots[1];
            [normal * joint.penetration + joint.dashpots[0], contact.downstream() * on_the_other]
        })
    }

    /// Slip of the block above at each contact relative to the unloaded position, positive downstream, m.
    pub fn slips<'a>(&'a self, joints: &'a [JointState]) -> impl Iterator<Item = f64> + 'a {
        let contacts = self.contacts.iter().zip(joints).zip(&self.slips_at_rest);
        contacts.map(|((contact, joint), at_rest)| {
            contact.downstream() * (joint.anchor + joint.stretch - at_rest)
        })
    }

    /// Number of contacts.
    pub fn contact_count(&self) -> usize {
        self.contacts.len()
    }

    /// Unloaded positions of the contacts, m.
    pub fn places(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.contacts.iter().map(|contact| contact.point.rest)
    }

    /// `½ (k_n g₀ g₁ + k_s e₀ e₁)`, J/m²: what springs lose that act with the penetration g₀ and the stretch e₀ of
    /// `joint`, and no longer with g₁ and e₁ = `stretch` at the end of the time step. The work of the mean of the
    /// forces before and after, less the change of the stored energy, is exactly this. `penetrations` is g₀ g₁;
    /// springs of different sign do not act both.
    fn mean_energy(&self, joint: &JointState, penetrations: f64, stretch: f64) -> f64 {
        let [normal, shear] = self.law.stiffness();
        0.5 * (normal * penetrations.max(0.0) + shear * joint.stretch * stretch)
    }

    /// Energy of the springs, J/m.
    pub fn energy(&self, joints: &[JointState]) -> f64 {
        let energy = |(contact, joint): (&Contact, &JointState)| {
            contact.weight * joint.coverage * self.law.energy(joint.penetration, joint.stretch)
        };
        self.contacts.iter().zip(joints).map(energy).sum()
    }

    /// Springs of all contacts, closed, in the unloaded position.
    pub fn stencils(&self) -> impl Iterator<Item = Stencil> + '_ {
        let [normal, shear] = self.law.stiffness();
        self.linear(move |_, n, t, p, q| normal * n[p] * n[q] + shear * t[p] * t[q])
    }

    /// The same of the `closed` contacts while the block above slides in `direction` (1 for downstream, −1 for upstream):
    /// `k_n n nᵀ ∓ μ k_n t nᵀ` with the coefficient of `friction`, as shear is then μ times the normal stress.
    pub(crate) fn sliding_stencils(
        &self,
        direction: f64,
        friction: f64,
        closed: &[bool],
    ) -> impl Iterator<Item = Stencil> {
        let [normal, _] = self.law.stiffness();
        let all = self.linear(move |contact, n, t, p, q| {
            normal * (n[p] - direction * contact.downstream() * friction * t[p]) * n[q]
        });
        all.zip(closed).filter_map(|(stencil, &closed)| closed.then_some(stencil))
    }

    /// Whether each contact, in the unloaded position, is closed with these displacements (m).
    pub(crate) fn closed(&self, displacement: &[[f64; 2]]) -> Vec<bool> {
        let gap = |(_, place): (&Contact, Place)| {
            let [x, y] = weighted(place.nodes_of_both(), place.shares(), displacement);
            x * place.normal[0] + y * place.normal[1]
        };
        self.unloaded().map(|contact| gap(contact) < 0.0).collect()
    }

    /// The jumps of the sides with these velocities (m/s), if the `closed` contacts slip and the others are open, in the
    /// unloaded position.
    pub(crate) fn sliding(&self, velocity: &[[f64; 2]], closed: &[bool]) -> Parting {
        let mut parting = Parting::default();
        for ((contact, place), &closed) in self.unloaded().zip(closed) {
            let shares = [(place.tangent, 1.0), (place.normal, f64::from(u8::from(!closed)))];
            let stencil = contact.stencil(&place);
            let relative = weighted(stencil.nodes, stencil.shares, velocity);
            parting.add(stencil, place.point.rest, relative, shares);
        }
        parting
    }

    /// Linearised contacts with the stiffness `entry(contact, normal, tangent, row, column)` per length.
    fn linear(
        &self,
        entry: impl Fn(&Contact, [f64; 2], [f64; 2], usize, usize) -> f64,
    ) -> impl Iterator<Item = Stencil> {
        self.unloaded().map(move |(contact, place)| {
            let length = contact.weight * place.coverage;
            let entry = |p: usize, q: usize| length * entry(contact, place.normal, place.tangent, p, q);
            Stencil {
                nodes: place.nodes_of_both(),
                weights: place.shares(),
                stiffness: [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]],
            }
        })
    }

    /// The contacts that are covered in the unloaded position.
    fn unloaded(&self) -> impl Iterator<Item = (&Contact, Place)> {
        let places =
            self.contacts.iter().map(|contact| (contact, self.place(contact, contact.after, |_| [0.0; 2])));
        places.filter(|(_, place)| place.coverage > 0.0)
    }
}

/// `Σ share × value` of the nodes.
#[inline(always)]
fn weighted(nodes: [usize; 4], shares: [f64; 4], values: &[[f64; 2]]) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for (node, share) in nodes.into_iter().zip(shares) {
        (0..2).for_each(|d| sum[d] += share * values[node][d]);
    }
    sum
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
fn acting_penetration(penetration: f64, change: f64) -> f64 {
    let change = change.abs();
    if penetration > 0.0 && penetration < change {
        penetration * (1.0 + penetration / change) / 2.0
    } else {
        penetration
    }
}

/// Share of a step in which a value that goes from `first` to `last` linearly is negative.
fn share_below_zero(first: f64, last: f64) -> f64 {
    match (first < 0.0, last < 0.0) {
        (false, false) => 0.0,
        (true, true) => 1.0,
        (true, false) => first / (first - last),
        (false, true) => last / (last - first),
    }
}

/// Mean of how far a value that goes from `first` to `last` linearly is below zero; it counts as 0 where it is not.
fn mean_below_zero(first: f64, last: f64) -> f64 {
    share_below_zero(first, last) * (first.min(0.0) + last.min(0.0)) / -2.0
}

/// Largest error with which the slip gives the position of the other side's end, as a share of a contact's part:
/// 1 − cos θ for θ = 25°.
const TILT: f64 = 0.1;

/// Depth, as a share of its length, below which a lost contact is found again; deeper, its block has fallen beside the other one.
const SHALLOW: f64 = 0.01;

/// Normal to a direction downstream, out of the other side towards `side`.
fn normal(side: usize, [x, y]: [f64; 2]) -> [f64; 2] {
    if side == 1 { [-y, x] } else { [y, -x] }
}

impl Side {
    /// From the first to the second node of a segment, m.
    #[inline(always)]
    fn edge(&self, segment: usize, u: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
        let [(a, p), (b, q)] = [segment, segment + 1].map(|i| (self.rest[i], u(self.nodes[i])));
        [b[0] - a[0] + (q[0] - p[0]), b[1] - a[1] + (q[1] - p[1])]
    }

    /// The point at `abscissa` (m along the side) on a segment.
    fn point(&self, segment: usize, abscissa: f64) -> Point {
        let (from, to) = (self.abscissas[segment], self.abscissas[segment + 1]);
        let share = (abscissa - from) / (to - from);
        let ([x0, y0], [x1, y1]) = (self.rest[segment], self.rest[segment + 1]);
        Point {
            nodes: [self.nodes[segment], self.nodes[segment + 1]],
            share,
            rest: [x0 + share * (x1 - x0), y0 + share * (y1 - y0)],
            abscissa,
        }
    }

    /// Abscissa of the point on the line of a segment that is closest to node `end` of the `other` side, m.
    #[inline(always)]
    fn foot(&self, segment: usize, other: &Self, end: usize, u: impl Fn(usize) -> [f64; 2]) -> f64 {
        let edge = self.edge(segment, &u);
        let ([from, p], [to, q]) =
            ([self.rest[segment], u(self.nodes[segment])], [other.rest[end], u(other.nodes[end])]);
        let offset = [to[0] - from[0] + (q[0] - p[0]), to[1] - from[1] + (q[1] - p[1])];
        let along = (offset[0] * edge[0] + offset[1] * edge[1]) / (edge[0] * edge[0] + edge[1] * edge[1]);
        self.abscissas[segment] + along * (self.abscissas[segment + 1] - self.abscissas[segment])
    }

    /// The contacts of this side (0 for the lower, 1 for the upper side) with the other side.
    /// They stand for this `share` of its length.
    fn contacts(&self, side: usize, integration: Integration, share_of_length: f64) -> Vec<Contact> {
        let last = self.nodes.len() - 1;
        let middle = |segment: usize| (self.abscissas[segment] + self.abscissas[segment + 1]) / 2.0;
        let at_node = |i: usize| Contact {
            side,
            point: Point {
                nodes: [self.nodes[i]; 2],
                share: 0.0,
                rest: self.rest[i],
                abscissa: self.abscissas[i],
            },
            part: [
                if i > 0 { middle(i - 1) } else { 0.0 },
                if i < last { middle(i) } else { self.abscissas[last] },
            ],
            weight: self.weights[i],
            before: i.saturating_sub(1),
            after: i.min(last - 1),
        };
        let on_segment = |segment: usize, share: f64| {
            let (from, to) = (self.abscissas[segment], self.abscissas[segment + 1]);
            Contact {
                side,
                point: self.point(segment, from + share * (to - from)),
                part: if share < 0.5 { [from, middle(segment)] } else { [middle(segment), to] },
                weight: (to - from) / 2.0 * share_of_length,
                before: segment,
                after: segment,
            }
        };
        let points = [0.5 - 0.5 / 3f64.sqrt(), 0.5 + 0.5 / 3f64.sqrt()];
        match integration {
            Integration::Nodal => (0..self.nodes.len()).map(at_node).collect(),
            Integration::Gauss => {
                (0..last).flat_map(|segment| points.map(|share| on_segment(segment, share))).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::mean_below_zero;

    #[test]
    fn the_mean_width_of_a_gap_that_opens_or_closes_is_that_of_its_open_part() {
        for (first, last, mean) in [(2.0, 1.0, 0.0), (-1.0, -3.0, 2.0), (1.0, -1.0, 0.25), (-3.0, 1.0, 1.125)]
        {
            assert!((mean_below_zero(first, last) - mean).abs() < 1e-15, "from {first} to {last}");
        }
    }
}
