use serde::{Deserialize, Serialize};

use super::search::find_segment;
use super::{ContactLaw, Coulomb, OVERHANG, Touch};
use crate::Mesh;
use crate::damping::StiffnessDamping;
use crate::energy::Losses;

/// Where a contact stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ContactStatus {
    /// Closed, below the friction limit.
    Sticking,
    /// Closed, at the friction limit.
    Slipping,
    /// A gap.
    Open,
    /// Past the end of the other side.
    Lost,
}

/// Memory of one contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointState {
    /// Segment of the other side, where the next search starts.
    pub segment: u32,
    /// Where it stands.
    pub status: ContactStatus,
    /// Tangential position that the shear spring holds on to, along the other side less the node's along its own, m.
    pub anchor: f64,
    /// Stretch of the shear spring, m.
    pub stretch: f64,
    /// Distance of the node from the other side, m; negative is penetration.
    pub gap: f64,
    /// Normal and shear stress of the dashpots, Pa.
    pub dashpots: [f64; 2],
    /// Rates of penetration and slip that the dashpots feel, with damping's memory, m/s; 0 where open, and
    /// without memory, which needs none.
    pub rates: [f64; 2],
}

/// A crack: two chains of nodes, and the law between them.
#[derive(Clone, Debug)]
pub struct Crack<L: ContactLaw = Coulomb> {
    law: L,
    /// Below and above.
    sides: [Side; 2],
}

#[derive(Clone, Debug)]
struct Side {
    nodes: Vec<usize>,
    /// Half of the tributary lengths, m.
    weights: Vec<f64>,
    /// Length of the chain up to each node, unloaded, m.
    abscissas: Vec<f64>,
}

/// Spring of a closed contact in the position of rest: `K = Σ weights ⊗ (k_n n nᵀ + k_s t tᵀ) ⊗ weights`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stencil {
    /// The node and the two nodes of its segment.
    pub nodes: [usize; 3],
    /// Their weights in the relative displacement: 1, −N₁, −N₂.
    pub weights: [f64; 3],
    /// `k_n n nᵀ + k_s t tᵀ` times the contact's length, N/m per metre of dam.
    pub stiffness: [[f64; 2]; 2],
}

/// A node's place on a segment of the other side.
struct Place {
    segment: usize,
    position: f64,
    tangent: [f64; 2],
    normal: [f64; 2],
    gap: f64,
    slip: f64,
}

impl Place {
    /// Whether the node has slid past the end of the other side.
    fn is_beyond_the_end(&self) -> bool {
        self.position < -OVERHANG || self.position > 1.0 + OVERHANG
    }
}

impl<L: ContactLaw> Crack<L> {
    /// The crack between two chains of nodes, each from upstream to downstream.
    pub fn new(mesh: &Mesh, below: &[usize], above: &[usize], law: L) -> Self {
        let side = |nodes: &[usize]| {
            let mut abscissas = vec![0.0];
            for pair in nodes.windows(2) {
                let ([x0, y0], [x1, y1]) = (mesh.nodes[pair[0]], mesh.nodes[pair[1]]);
                abscissas.push(abscissas[abscissas.len() - 1] + (x1 - x0).hypot(y1 - y0));
            }
            let weights = mesh.tributary_lengths(nodes).iter().map(|length| length / 2.0).collect();
            Side { nodes: nodes.to_vec(), weights, abscissas }
        };
        Self { law, sides: [side(below), side(above)] }
    }

    /// The same crack with each of its nodes called `number(node)`.
    pub(crate) fn renumbered(&self, number: impl Fn(usize) -> usize) -> Self {
        let mut crack = self.clone();
        crack.sides.iter_mut().flat_map(|side| &mut side.nodes).for_each(|node| *node = number(*node));
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

    /// Tributary lengths of the nodes of the lower and of the upper side, m, halved.
    pub fn half_lengths(&self) -> [&[f64]; 2] {
        [&self.sides[0].weights, &self.sides[1].weights]
    }

    /// Contacts without load: those of the upper side's nodes, then those of the lower side's. Shear springs hold on to
    /// where the nodes are at `rest` (m), wherever the other side begins.
    pub fn joints_at_rest(&self, rest: &[[f64; 2]]) -> Vec<JointState> {
        let still = vec![[0.0; 2]; rest.len()];
        self.contacts()
            .map(|(slave, i, _)| {
                let place = self.place(slave, i, i, rest, &still);
                JointState {
                    segment: place.segment as u32,
                    status: ContactStatus::Sticking,
                    anchor: place.slip,
                    stretch: 0.0,
                    gap: 0.0,
                    dashpots: [0.0; 2],
                    rates: [0.0; 2],
                }
            })
            .collect()
    }

    /// Index of the slave side, of its node, and contact weight of every contact.
    fn contacts(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        [1, 0].into_iter().flat_map(|slave| {
            self.sides[slave].weights.iter().enumerate().map(move |(i, &weight)| (slave, i, weight))
        })
    }

    fn place(&self, slave: usize, index: usize, start: usize, rest: &[[f64; 2]], u: &[[f64; 2]]) -> Place {
        let (own, other) = (&self.sides[slave], &self.sides[1 - slave]);
        let node = own.nodes[index];
        let between = |a: usize, b: usize| {
            [rest[b][0] - rest[a][0] + (u[b][0] - u[a][0]), rest[b][1] - rest[a][1] + (u[b][1] - u[a][1])]
        };
        let project = |segment: usize| {
            let edge = between(other.nodes[segment], other.nodes[segment + 1]);
            let offset = between(other.nodes[segment], node);
            (offset[0] * edge[0] + offset[1] * edge[1]) / (edge[0] * edge[0] + edge[1] * edge[1])
        };
        let (segment, position) = find_segment(start, other.nodes.len() - 1, project);
        let [first, second] = [other.nodes[segment], other.nodes[segment + 1]];
        let edge = between(first, second);
        let length = (edge[0] * edge[0] + edge[1] * edge[1]).sqrt();
        let tangent = [edge[0] / length, edge[1] / length];
        let side = if slave == 1 { 1.0 } else { -1.0 };
        let normal = [-side * tangent[1], side * tangent[0]];
        let at_rest = other.abscissas[segment + 1] - other.abscissas[segment];
        // from the nearer end, where matching nodes meet: no digits are lost there
        let nearest = if position > 0.5 { segment + 1 } else { segment };
        let offset = between(other.nodes[nearest], node);
        let along = (offset[0] * tangent[0] + offset[1] * tangent[1]) / length;
        Place {
            segment,
            position,
            tangent,
            normal,
            gap: offset[0] * normal[0] + offset[1] * normal[1],
            slip: other.abscissas[nearest] - own.abscissas[index] + along * at_rest,
        }
    }

    /// Adds the contact forces to `forces` and brings `joints` up to date.
    ///
    /// **Shapes and units**: `rest`, `displacement` (m), `velocity` (m/s) and `forces` (N/m) hold one pair
    /// a node, `joints` one state a contact; `damping` is β (s), with its memory or without. A contact that closes remembers nothing:
    /// its dashpots take hold over the memory's time, where the whole of them at once would throw it back.
    pub fn add_forces(
        &self,
        rest: &[[f64; 2]],
        displacement: &[[f64; 2]],
        velocity: &[[f64; 2]],
        damping: impl Into<StiffnessDamping>,
        joints: &mut [JointState],
        forces: &mut [[f64; 2]],
    ) -> Losses {
        let StiffnessDamping { coefficient, memory } = damping.into();
        let mut losses = Losses::default();
        let shear_stiffness = self.law.stiffness()[1];
        for ((slave, index, weight), joint) in self.contacts().zip(joints) {
            let other = &self.sides[1 - slave];
            let place = self.place(slave, index, joint.segment as usize, rest, displacement);
            joint.segment = place.segment as u32;
            if place.is_beyond_the_end() {
                if joint.status != ContactStatus::Lost {
                    losses.friction += weight * self.law.energy(-joint.gap, joint.stretch);
                }
                *joint = JointState {
                    status: ContactStatus::Lost,
                    anchor: place.slip,
                    stretch: 0.0,
                    gap: place.gap,
                    dashpots: [0.0; 2],
                    rates: [0.0; 2],
                    ..*joint
                };
                continue;
            }
            if joint.status == ContactStatus::Lost {
                joint.anchor = place.slip;
                losses.friction -= weight * self.law.energy(-place.gap, 0.0);
            }
            let [node, first, second] =
                [self.sides[slave].nodes[index], other.nodes[place.segment], other.nodes[place.segment + 1]];
            let shares = [1.0 - place.position, place.position];
            let relative_in = |d: usize| {
                velocity[node][d] - shares[0] * velocity[first][d] - shares[1] * velocity[second][d]
            };
            let relative = [relative_in(0), relative_in(1)];
            let along = |axis: [f64; 2]| relative[0] * axis[0] + relative[1] * axis[1];
            let rates = [-along(place.normal), along(place.tangent)];
            let felt = [0, 1].map(|i| memory * joint.rates[i] + (1.0 - memory) * rates[i]);
            let response = self.law.respond(&Touch {
                penetration: -place.gap,
                penetration_rate: felt[0],
                stretch: place.slip - joint.anchor,
                slip_rate: felt[1],
                damping: coefficient,
            });
            let anchor = if response.slipping || place.gap >= 0.0 {
                place.slip - response.stretch
            } else {
                joint.anchor
            };
            let mean_shear = shear_stiffness * (joint.stretch + response.stretch) / 2.0;
            losses.friction += weight * mean_shear * (anchor - joint.anchor);
            let mean = |i: usize| (joint.dashpots[i] + response.dashpots[i]) / 2.0;
            losses.damping_power += weight * (mean(0) * rates[0] + mean(1) * rates[1]);
            let status = match (place.gap < 0.0, response.slipping) {
                (false, _) => ContactStatus::Open,
                (true, true) => ContactStatus::Slipping,
                (true, false) => ContactStatus::Sticking,
            };
            *joint = JointState {
                segment: joint.segment,
                status,
                anchor,
                stretch: response.stretch,
                gap: place.gap,
                dashpots: response.dashpots,
                rates: if place.gap < 0.0 && memory > 0.0 { felt } else { [0.0; 2] },
            };
            let (n, t) = (place.normal, place.tangent);
            let force = [
                weight * (response.normal * n[0] - response.shear * t[0]),
                weight * (response.normal * n[1] - response.shear * t[1]),
            ];
            for (node, share) in [(node, 1.0), (first, -shares[0]), (second, -shares[1])] {
                forces[node][0] += share * force[0];
                forces[node][1] += share * force[1];
            }
        }
        losses
    }

    /// Energy in the springs, J/m.
    pub fn energy(&self, joints: &[JointState]) -> f64 {
        self.contacts()
            .zip(joints)
            .filter(|(_, joint)| joint.status != ContactStatus::Lost)
            .map(|((_, _, weight), joint)| weight * self.law.energy(-joint.gap, joint.stretch))
            .sum()
    }

    /// Springs of all contacts, closed, in the position of rest.
    pub fn stencils<'a>(&'a self, rest: &'a [[f64; 2]]) -> impl Iterator<Item = Stencil> + 'a {
        let still = vec![[0.0; 2]; rest.len()];
        let [normal, shear] = self.law.stiffness();
        self.contacts().filter_map(move |(slave, index, weight)| {
            let other = &self.sides[1 - slave];
            let place = self.place(slave, index, index, rest, &still);
            if place.is_beyond_the_end() {
                return None;
            }
            let Place { segment, position, normal: n, tangent: t, .. } = place;
            let entry = |p: usize, q: usize| weight * (normal * n[p] * n[q] + shear * t[p] * t[q]);
            Some(Stencil {
                nodes: [self.sides[slave].nodes[index], other.nodes[segment], other.nodes[segment + 1]],
                weights: [1.0, position - 1.0, -position],
                stiffness: [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]],
            })
        })
    }
}
