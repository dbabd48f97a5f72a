mod place;
mod position;
mod scalar;
mod side;
mod simd;
mod update;

use serde::{Deserialize, Serialize};

use super::parting::{self, Parting};
use super::{ContactLaw, Coulomb, Integration, MohrCoulomb};
use crate::{Mesh, Seam};
use place::{Place, weighted};
use side::{Contact, Side};
pub(crate) use simd::{ContactBatches, NodalFields};

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
    /// Pressure of the water in the crack that it loses where it opens, Pa; only within a communication step.
    #[serde(skip)]
    pub(crate) relief: f64,
}

/// Slope with which the pressure falls as a contact opens, over its normal stiffness k_n: the time step has a margin of at least
/// 4 in frequency, 16 in stiffness.
const STEEPNESS: f64 = 8.0;

/// Pressure that an open contact has lost with this `gap` (m), of the `most` (Pa) that it may lose. It falls over a gap of
/// `p/(8 k_n)`, some micrometres, so that no force jumps.
#[inline(always)]
fn relief(gap: f64, most: f64, law: &impl ContactLaw) -> f64 {
    (STEEPNESS * law.stiffness()[0] * gap.max(0.0)).min(most.max(0.0))
}

impl JointState {
    /// Pressure that it has lost with this `gap` (m), of the `most` (Pa) that it may lose ([`relief`]).
    pub(crate) fn relief_at(&self, gap: f64, most: f64, law: &impl ContactLaw) -> f64 {
        if self.status == ContactStatus::Open { relief(gap, most, law) } else { 0.0 }
    }

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

/// What a unit pressure in the crack does at one contact.
pub(crate) struct Pressing {
    /// Distance from the upstream end of its side, m.
    pub distance: f64,
    /// Length on which the pressure acts, m: that for which the contact stands.
    pub length: f64,
    /// The nodes as in [`Stencil`], and the force on each, m.
    pub nodes: [usize; 4],
    pub forces: [[f64; 2]; 4],
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

impl<L: ContactLaw> Crack<L> {
    /// Moment of the normal forces of the contacts about a point of the crack, from which the unloaded side begins at the distance
    /// `begin` (m).
    pub fn moment(&self, joints: &[JointState], begin: f64) -> f64 {
        let contacts = self.contacts.iter().zip(joints).zip(self.stresses(joints));
        let of_contact = |((contact, joint), [normal, _]): ((&Contact, &JointState), [f64; 2])| {
            contact.weight * joint.coverage * normal * (begin + contact.point.abscissa)
        };
        contacts.map(of_contact).sum()
    }

    /// Lengths on which the sides touch, and of the whole crack, m. A contact that slid partly over the end of the other side
    /// touches on what is left opposite it.
    pub fn touching(&self, joints: &[JointState]) -> [f64; 2] {
        let mut lengths = [0.0; 2];
        for (contact, joint) in self.contacts.iter().zip(joints) {
            let touches = matches!(joint.status, ContactStatus::Sticking | ContactStatus::Slipping);
            lengths[0] += if touches { contact.weight * joint.coverage } else { 0.0 };
            lengths[1] += contact.weight;
        }
        lengths
    }

    /// Lengths on which the contacts are bonded, and of the whole crack, m.
    pub fn bonded(&self, joints: &[JointState]) -> [f64; 2] {
        let mut lengths = [0.0; 2];
        for (contact, joint) in self.contacts.iter().zip(joints) {
            lengths[0] += if joint.bonded { contact.weight } else { 0.0 };
            lengths[1] += contact.weight;
        }
        lengths
    }

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
        let at_rest = |contact: &Contact| crack.place(contact, contact.after, |_| [0.0; 2]).at.slip;
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
                anchor: place.at.slip,
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
                relief: 0.0,
            }
        };
        self.contacts.iter().map(joint).collect()
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

    /// Energy of the springs, J/m.
    pub fn energy(&self, joints: &[JointState]) -> f64 {
        let energy = |(contact, joint): (&Contact, &JointState)| {
            contact.weight * joint.coverage * self.law.energy(joint.penetration, joint.stretch)
        };
        self.contacts.iter().zip(joints).map(energy).sum()
    }

    /// What a pressure that presses the sides apart does at each contact in the unloaded position.
    pub(crate) fn pressing(&self) -> impl Iterator<Item = Pressing> + '_ {
        self.contacts.iter().map(|contact| {
            let place = self.place(contact, contact.after, |_| [0.0; 2]);
            let length = contact.weight * place.coverage;
            Pressing {
                distance: contact.point.abscissa,
                length,
                nodes: place.nodes_of_both(),
                forces: place.shares().map(|share| place.at.normal.map(|n| length * share * n)),
            }
        })
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
            x * place.at.normal[0] + y * place.at.normal[1]
        };
        self.unloaded().map(|contact| gap(contact) < 0.0).collect()
    }

    /// The jumps of the sides with these velocities (m/s), if the `closed` contacts slip and the others are open, in the
    /// unloaded position.
    pub(crate) fn sliding(&self, velocity: &[[f64; 2]], closed: &[bool]) -> Parting {
        let mut parting = Parting::default();
        for ((contact, place), &closed) in self.unloaded().zip(closed) {
            let shares = [(place.at.tangent, 1.0), (place.at.normal, f64::from(u8::from(!closed)))];
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
            let entry = |p: usize, q: usize| length * entry(contact, place.at.normal, place.at.tangent, p, q);
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
