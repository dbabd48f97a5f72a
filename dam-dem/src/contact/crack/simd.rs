use pulp::{Simd, WithSimd};

use super::super::parting::{self, Parting};
use super::position::{MovedPoint, Position, Segment};
use super::side::Contact;
use super::update::{Jump, Moved, State};
use super::{ContactLaw, ContactStatus, Crack, JointState};
use crate::damping::StiffnessDamping;
use crate::energy::Losses;
use crate::lanes::{LANES, Lanes, Register};

/// The contacts of all cracks, up to [`LANES`] at a time: made from the states at the start of a communication step, which take in those
/// at its end.
///
/// The numbers of the contacts of a batch lie side by side, so that registers hold them without gathering. Every operation is the one that
/// [`Crack::add_forces`] does, from the same source, with the same bits. Some contacts are computed one by one: those whose part does not
/// lie wholly opposite the other side, all contacts of cracks with few contacts, with a bond that holds, with dilation or with water that
/// leaves what opens, and each contact when it comes to another segment. These cracks come last, which changes the order of sums where they share nodes with others.
pub(crate) struct ContactBatches {
    batches: Vec<Batch>,
    /// Cracks whose contacts are computed one by one.
    one_by_one: Vec<usize>,
}

/// Number of contacts from which batches of a crack save time: of fewer, too many lie at ends.
const MANY: usize = 2 * LANES;

/// Motion of the nodes, and what acts on them.
pub(crate) struct NodalFields<'a> {
    /// Displacement, m.
    pub u: &'a [[f64; 2]],
    /// Velocity, m/s.
    pub v: &'a [[f64; 2]],
    /// Of the dashpots.
    pub damping: StiffnessDamping,
    /// Forces are added here, N/m.
    pub forces: &'a mut [[f64; 2]],
    /// How the sides of each crack part; empty if that is not needed.
    pub partings: &'a mut [Parting],
}

/// Up to [`LANES`] contacts of a crack; lanes without one repeat the first.
#[derive(Default)]
struct Batch {
    crack: usize,
    /// Number of each contact in the crack.
    contacts: [usize; LANES],
    /// Number of lanes with a contact.
    count: usize,
    /// The nodes around its point, and those of the segment opposite.
    nodes: [[u32; LANES]; 4],
    point: Points,
    opposite: Segments,
    state: State<Lanes>,
    /// 1 where it is closed, and where it is closed and slips.
    closed: Lanes,
    slipping: Lanes,
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
}

/// The segments opposite, unloaded, m.
#[derive(Default)]
struct Segments {
    /// 1 where one follows towards the side's start, and its end.
    follows: [Lanes; 2],
    segment: Segment<Lanes>,
    /// Abscissas of its nodes less that of the point.
    abscissas: [Lanes; 2],
    /// Its length.
    at_rest: Lanes,
    /// Length of its side.
    length: Lanes,
}

/// Where the contacts are.
#[derive(Default)]
struct Places {
    at: Position<Lanes>,
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
    jump: Jump<Lanes>,
}

impl ContactBatches {
    /// The contacts of `cracks` with the states `joints`.
    pub fn new<L: ContactLaw>(cracks: &[Crack<L>], joints: &[Vec<JointState>]) -> Self {
        let is_usual = |crack: usize| {
            joints[crack].len() >= MANY
                && !cracks[crack].law.dilates()
                && !joints[crack].iter().any(|joint| joint.bonded || joint.relief > 0.0)
        };
        let (usual, one_by_one): (Vec<usize>, Vec<usize>) =
            (0..cracks.len()).partition(|&crack| is_usual(crack));
        let of_crack = |&crack: &usize| {
            let starts = (0..joints[crack].len()).step_by(LANES);
            starts.map(move |first| Batch::new(first, crack, &cracks[crack], &joints[crack]))
        };
        Self { batches: usual.iter().flat_map(of_crack).collect(), one_by_one }
    }

    /// As [`add_forces`](Self::add_forces), with the widest registers.
    pub fn add_forces_widely<L: ContactLaw>(
        &mut self,
        cracks: &[Crack<L>],
        joints: &mut [Vec<JointState>],
        fields: NodalFields<'_>,
    ) -> Losses {
        pulp::Arch::new().dispatch(AddForces { batches: self, cracks, joints, fields })
    }

    /// Adds the contact forces and updates the contacts, as [`Crack::add_forces`] does. Of `joints` only those of contacts that are
    /// computed one by one are up to date until [`write`](Self::write), except that all always tell whether a contact is lost.
    #[inline(always)]
    pub fn add_forces<S: Simd, L: ContactLaw>(
        &mut self,
        simd: S,
        cracks: &[Crack<L>],
        joints: &mut [Vec<JointState>],
        mut fields: NodalFields<'_>,
    ) -> Losses {
        let mut losses = Losses::default();
        fields.partings.iter_mut().for_each(Parting::clear);
        for batch in &mut self.batches {
            let crack = batch.crack;
            batch.add_forces(simd, &cracks[crack], &mut joints[crack], &mut fields, &mut losses);
        }
        for &index in &self.one_by_one {
            losses = cracks[index].add_forces_one_by_one(index, &mut joints[index], &mut fields, losses);
        }
        losses
    }

    /// Whether all contacts stick or are lost.
    pub fn are_calm(&self, joints: &[Vec<JointState>]) -> bool {
        let calm = |batch: &Batch| {
            batch.contacts().all(|(lane, index)| match batch.alone[lane] == 0.0 {
                true => batch.closed[lane] != 0.0 && batch.slipping[lane] == 0.0,
                false => joints[batch.crack][index].is_calm(),
            })
        };
        self.batches.iter().all(calm)
            && self.one_by_one.iter().all(|&crack| joints[crack].iter().all(JointState::is_calm))
    }

    /// Brings `joints` up to date.
    pub fn write(&self, joints: &mut [Vec<JointState>]) {
        for batch in &self.batches {
            let usual = batch.contacts().filter(|(lane, _)| batch.alone[*lane] == 0.0);
            usual.for_each(|(lane, index)| batch.write(lane, &mut joints[batch.crack][index]));
        }
    }
}

/// [`ContactBatches::add_forces`], to be computed with the widest registers.
struct AddForces<'a, L: ContactLaw> {
    batches: &'a mut ContactBatches,
    cracks: &'a [Crack<L>],
    joints: &'a mut [Vec<JointState>],
    fields: NodalFields<'a>,
}

impl<L: ContactLaw> WithSimd for AddForces<'_, L> {
    type Output = Losses;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Losses {
        let Self { batches, cracks, joints, fields } = self;
        batches.add_forces(simd, cracks, joints, fields)
    }
}

/// Whether a contact is to be computed alone: its part does not lie wholly opposite the other side.
fn is_alone(joint: &JointState) -> bool {
    joint.coverage < 1.0
}

impl Batch {
    /// The contacts of a crack from the `first` on.
    fn new<L: ContactLaw>(first: usize, index: usize, crack: &Crack<L>, joints: &[JointState]) -> Self {
        let count = LANES.min(joints.len() - first);
        let contacts = std::array::from_fn(|lane| first + if lane < count { lane } else { 0 });
        let mut batch = Self { crack: index, contacts, count, ..Self::default() };
        for (lane, index) in contacts.into_iter().enumerate() {
            let contact = &crack.contacts[index];
            let point = &mut batch.point;
            point.downstream[lane] = contact.downstream();
            point.share[lane] = contact.point.share;
            point.weight[lane] = contact.weight;
            for d in 0..2 {
                point.rest[d][lane] = contact.point.rest[d];
                point.part[d][lane] = contact.part[d];
                batch.nodes[d][lane] = contact.point.nodes[d] as u32;
            }
            batch.read(lane, contact, crack, &joints[index]);
        }
        batch
    }

    /// The lanes with a contact, and its number in the crack.
    #[inline(always)]
    fn contacts(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        self.contacts.into_iter().take(self.count).enumerate()
    }

    /// Takes in the state of a contact and the segment opposite.
    fn read<L: ContactLaw>(&mut self, lane: usize, contact: &Contact, crack: &Crack<L>, joint: &JointState) {
        self.alone[lane] = f64::from(u8::from(is_alone(joint)));
        let other = &crack.sides[1 - contact.side];
        let count = other.nodes.len() - 1;
        let segment = (joint.segment as usize).min(count - 1);
        let opposite = &mut self.opposite;
        opposite.follows[0][lane] = f64::from(u8::from(segment > 0));
        opposite.follows[1][lane] = f64::from(u8::from(segment + 1 < count));
        opposite.at_rest[lane] = other.abscissas[segment + 1] - other.abscissas[segment];
        opposite.length[lane] = other.length();
        let Segment { offsets, edge } = other.segment(segment, contact.point.rest);
        for (end, node) in [segment, segment + 1].into_iter().enumerate() {
            self.nodes[2 + end][lane] = other.nodes[node] as u32;
            opposite.abscissas[end][lane] = other.abscissas[node] - contact.point.abscissa;
            set_pair(&mut opposite.segment.offsets[end], lane, offsets[end]);
        }
        set_pair(&mut opposite.segment.edge, lane, edge);
        self.closed[lane] = f64::from(u8::from(joint.is_closed()));
        self.slipping[lane] = f64::from(u8::from(joint.status == ContactStatus::Slipping));
        let State { anchor, stretch, gap, slipped, dashpots, rates } = joint.state();
        let states = &mut self.state;
        states.anchor[lane] = anchor;
        states.stretch[lane] = stretch;
        states.gap[lane] = gap;
        states.slipped[lane] = slipped;
        set_pair(&mut states.dashpots, lane, dashpots);
        set_pair(&mut states.rates, lane, rates);
    }

    /// Brings the state of a contact that is not alone up to date.
    fn write(&self, lane: usize, joint: &mut JointState) {
        let State { anchor, stretch, gap, slipped, dashpots, rates } = &self.state;
        let state = State {
            anchor: anchor[lane],
            stretch: stretch[lane],
            gap: gap[lane],
            slipped: slipped[lane],
            dashpots: pair(dashpots, lane),
            rates: pair(rates, lane),
        };
        let (closed, slipping) = (self.closed[lane] != 0.0, self.slipping[lane] != 0.0);
        joint.set_state(state, closed, slipping, 0.0 - gap[lane]);
    }

    /// As [`ContactBatches::add_forces`]; `joints` are those of the `crack`.
    #[inline(always)]
    fn add_forces<S: Simd, L: ContactLaw>(
        &mut self,
        simd: S,
        crack: &Crack<L>,
        joints: &mut [JointState],
        fields: &mut NodalFields<'_>,
        losses: &mut Losses,
    ) {
        #[cfg(test)]
        super::super::effort::spend(|effort| {
            effort.segments += self.contacts().filter(|(lane, _)| self.alone[*lane] == 0.0).count();
        });
        let mut places = Places::default();
        let displacements = gather(&self.nodes, fields.u);
        for register in 0..Lanes::registers::<S>() {
            self.find(At { simd, register }, &displacements, &mut places);
        }
        for (lane, index) in self.contacts() {
            let (walks, ends) = (places.walks[lane] != 0.0, places.ends[lane] != 0.0);
            if self.alone[lane] != 0.0 || !(walks || ends) {
                continue;
            }
            if walks || !crack.is_whole(&crack.contacts[index], fields.u) {
                self.write(lane, &mut joints[index]);
                self.alone[lane] = 1.0;
            }
        }
        let mut responses = Responses::default();
        let time_step = fields.partings.first().map(Parting::time_step);
        let velocities = gather(&self.nodes, fields.v);
        for register in 0..Lanes::registers::<S>() {
            let at = At { simd, register };
            self.update(at, &crack.law, &places, &velocities, fields.damping, time_step, &mut responses);
        }
        for (lane, index) in self.contacts() {
            if self.alone[lane] != 0.0 {
                let (joint, contact) = (&mut joints[index], &crack.contacts[index]);
                crack.add_force_of_one(contact, self.crack, joint, fields, losses);
                if !is_alone(joint) {
                    self.read(lane, contact, crack, joint);
                }
                continue;
            }
            if self.closed[lane] != 0.0 {
                let force = pair(&responses.force, lane);
                for (nodes, shares) in self.nodes.iter().zip(&responses.shares) {
                    let (to, share) = (&mut fields.forces[nodes[lane] as usize], shares[lane]);
                    to[0] += share * force[0];
                    to[1] += share * force[1];
                }
            }
            losses.friction += responses.friction[lane];
            losses.damping_power += responses.damping_power[lane];
            if let Some(parting) = fields.partings.get_mut(self.crack) {
                let downstream = self.point.downstream[lane];
                let (mut nodes, mut shares) = ([0; 4], [0.0; 4]);
                for k in 0..4 {
                    nodes[k] = self.nodes[k][lane] as usize;
                    shares[k] = downstream * responses.shares[k][lane];
                }
                let stencil = parting::Stencil { nodes, shares, length: self.point.weight[lane] };
                let Jump { place, relative, slips, opened } = &responses.jump;
                let shares = [
                    (pair(&places.at.tangent, lane), slips[lane]),
                    (pair(&places.at.normal, lane), opened[lane]),
                ];
                parting.add(stencil, pair(place, lane), pair(relative, lane), shares);
            }
        }
    }

    /// Finds where the contacts are, given the displacements of their nodes.
    #[inline(always)]
    fn find<S: Simd>(&self, at: At<S>, displacements: &[[Lanes; 2]; 4], places: &mut Places) {
        let (zero, one) = (at.number(0.0), at.number(1.0));
        let [first, second, before, after] = displacements;
        let Points { downstream, share, rest, part, .. } = &self.point;
        let Segments { follows, segment, abscissas, at_rest, length } = &self.opposite;
        let point = MovedPoint::new(at.both(rest), at.one(share), [at.both(first), at.both(second)]);
        let segment = Segment {
            offsets: [at.both(&segment.offsets[0]), at.both(&segment.offsets[1])],
            edge: at.both(&segment.edge),
        };
        let moved = segment.moved(point.displacement(), [at.both(before), at.both(after)]);
        let projection = moved.projection();
        let [back, forth] = at.both(follows);
        let walks = (projection.is_before() & zero.less_than(back))
            | (projection.is_behind() & zero.less_than(forth));
        let abscissas = at.both(abscissas);
        let position = Position::new(at.one(downstream), &moved, projection, abscissas, at.one(at_rest));
        let inside = position.is_inside(at.both(part), at.one(length));
        at.store(walks.select(one, zero), &mut places.walks);
        at.store(inside.select(zero, one), &mut places.ends);
        at.store_position(position, &mut places.at);
        at.store_both(point.position(), &mut places.point);
    }

    /// Updates the states of the contacts that are not alone, given the velocities of their nodes.
    #[allow(clippy::too_many_arguments)] // of one loop, a function so that it is compiled for the widest registers
    #[inline(always)]
    fn update<S: Simd, L: ContactLaw>(
        &mut self,
        at: At<S>,
        law: &L,
        places: &Places,
        [first, second, before, after]: &[[Lanes; 2]; 4],
        damping: StiffnessDamping,
        time_step: Option<f64>,
        responses: &mut Responses,
    ) {
        let (zero, one) = (at.number(0.0), at.number(1.0));
        let moved = Moved {
            downstream: at.one(&self.point.downstream),
            share: at.one(&self.point.share),
            weight: at.one(&self.point.weight),
            point: at.both(&places.point),
            at: at.position(&places.at),
            velocities: [at.both(first), at.both(second), at.both(before), at.both(after)],
        };
        let (update, jump) = moved.update(law, damping, &at.state(&self.state), None, time_step);
        at.store_state(update.state, &mut self.state);
        at.store(update.closed.select(one, zero), &mut self.closed);
        at.store(update.slipping.select(one, zero), &mut self.slipping);
        for (share, to) in update.shares.into_iter().zip(&mut responses.shares) {
            at.store(share, to);
        }
        at.store_both(update.force, &mut responses.force);
        at.store(update.friction, &mut responses.friction);
        at.store(update.damping_power, &mut responses.damping_power);
        if let Some(jump) = jump {
            at.store_both(jump.place, &mut responses.jump.place);
            at.store_both(jump.relative, &mut responses.jump.relative);
            at.store(jump.slips, &mut responses.jump.slips);
            at.store(jump.opened, &mut responses.jump.opened);
        }
    }
}

/// One of the registers that hold the numbers of a batch. (Methods instead of closures, whose code would not be for the widest
/// registers.)
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
    fn position(self, from: &Position<Lanes>) -> Position<Register<S>> {
        Position {
            position: self.one(&from.position),
            tangent: self.both(&from.tangent),
            normal: self.both(&from.normal),
            gap: self.one(&from.gap),
            slip: self.one(&from.slip),
            shortening: self.one(&from.shortening),
        }
    }

    #[inline(always)]
    fn state(self, from: &State<Lanes>) -> State<Register<S>> {
        State {
            anchor: self.one(&from.anchor),
            stretch: self.one(&from.stretch),
            gap: self.one(&from.gap),
            slipped: self.one(&from.slipped),
            dashpots: self.both(&from.dashpots),
            rates: self.both(&from.rates),
        }
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

    #[inline(always)]
    fn store_position(self, from: Position<Register<S>>, to: &mut Position<Lanes>) {
        self.store(from.position, &mut to.position);
        self.store_both(from.tangent, &mut to.tangent);
        self.store_both(from.normal, &mut to.normal);
        self.store(from.gap, &mut to.gap);
        self.store(from.slip, &mut to.slip);
        self.store(from.shortening, &mut to.shortening);
    }

    #[inline(always)]
    fn store_state(self, from: State<Register<S>>, to: &mut State<Lanes>) {
        self.store(from.anchor, &mut to.anchor);
        self.store(from.stretch, &mut to.stretch);
        self.store(from.gap, &mut to.gap);
        self.store(from.slipped, &mut to.slipped);
        self.store_both(from.dashpots, &mut to.dashpots);
        self.store_both(from.rates, &mut to.rates);
    }
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

fn set_pair(lanes: &mut [Lanes; 2], lane: usize, [x, y]: [f64; 2]) {
    lanes[0][lane] = x;
    lanes[1][lane] = y;
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
    fn batched_contacts_equal_single_contacts_bit_for_bit() {
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
            // made again for each communication step, as in a run
            let mut batches = [&wide, &narrow].map(|joints| ContactBatches::new(cracks, joints));
            bonds_held += batches[0].one_by_one.len();
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
                    let (forces, partings) = (&mut expected[..], &mut parted[..]);
                    let mut fields = NodalFields { u: &u, v: &v, damping, forces, partings };
                    lost = crack.add_forces_one_by_one(index, joints, &mut fields, lost);
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
                for (batches, (joints, is_wide)) in
                    batches.iter_mut().zip([(&mut wide, true), (&mut narrow, false)])
                {
                    let (mut forces, mut partings) = none();
                    let fields =
                        NodalFields { u: &u, v: &v, damping, forces: &mut forces, partings: &mut partings };
                    let call = AddForces { batches: &mut *batches, cracks, joints: &mut *joints, fields };
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
                    assert_eq!(
                        batches.are_calm(joints),
                        one_by_one.iter().flatten().all(JointState::is_calm)
                    );
                    // cracks with bonds come last
                    for (a, b) in
                        [(losses.friction, lost.friction), (losses.damping_power, lost.damping_power)]
                    {
                        assert!((a - b).abs() <= 1e-13 * (a.abs() + 1e3), "{a} and {b}");
                    }
                    let mut now = joints.clone();
                    batches.write(&mut now);
                    assert_eq!(now, one_by_one);
                }
            }
            for (batches, joints) in batches.iter().zip([&mut wide, &mut narrow]) {
                batches.write(joints);
                // with the signs of zeros
                assert_eq!(format!("{joints:?}"), format!("{one_by_one:?}"));
                for (batch, (lane, index)) in
                    batches.batches.iter().flat_map(|batch| batch.contacts().map(move |at| (batch, at)))
                {
                    assert_eq!(
                        batch.alone[lane] != 0.0,
                        is_alone(&joints[batch.crack][index]),
                        "it came back"
                    );
                }
            }
        }
        println!("segments, slips, opened, closed, lost, found: {seen:?}; bonds held in {bonds_held} steps");
        assert!(seen.iter().all(|&count| count > 100) && (20..300).contains(&bonds_held));
    }
}
