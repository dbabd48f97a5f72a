//! Contacts where no crack was: blocks that slide off or topple meet other sides of other blocks, or the ground.
//!
//! A point of contact is a node on the outline of a block; it meets an edge of another block's outline, or the ground beside the
//! dam, the line y = 0. Points of both blocks meet edges of the other, each with half of its tributary length; the ground, which
//! is rigid, has no points, so that the others have their whole length.
//!
//! **Search**, once a communication step: sweep over the boxes of the bodies along their longer extent, then nodes in the overlap of two boxes against the
//! edges there. What cannot come together within the step is left out, so that the cost is that of the blocks that are near each
//! other. A node that a crack holds against a body ([`Guard`]) does not meet another side of this body; once it has slid
//! off its crack, it does.
//!
//! **Corners.** Of the edges that a node could enter by, it meets the one from which it is farthest outside, and it keeps this
//! edge and its normal while it lies opposite. Beyond an end of the edge it continues to the next one, from which it is hardly
//! inside: the springs are left behind, and the energy of those counts as lost to friction. So two corners that touch never lock:
//! neither pushes the other along the face that it has slid past.
//!
//! **Law**: that of the crack with the smallest normal stiffness, without its bond.

use serde::{Deserialize, Serialize};
use std::collections::{HashMap, HashSet};
use std::ops::Range;

use super::{ContactLaw, ContactStatus, Crack, Integration, JointState, Touch};
use crate::Mesh;
use crate::damping::StiffnessDamping;
use crate::energy::Losses;

/// State of a contact where no crack was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Meeting {
    /// Index of its point.
    point: u32,
    /// The edge that it meets; none for the ground.
    edge: Option<u32>,
    /// Position along the outline to which the shear spring is attached, m.
    anchor: f64,
    /// Stretch of the shear spring, m.
    stretch: f64,
    /// Overlap, m; 0 while open.
    penetration: f64,
    /// Normal and shear stress of the dashpots, Pa.
    dashpots: [f64; 2],
    /// Rates of penetration and slip with the memory of damping, m/s.
    rates: [f64; 2],
}

/// The outlines of the blocks, and the law by which they meet.
#[derive(Clone, Debug)]
pub(crate) struct Outlines<L> {
    law: L,
    points: Vec<Point>,
    edges: Vec<Edge>,
    bodies: Vec<Body>,
}

#[derive(Clone, Debug)]
struct Point {
    node: usize,
    rest: [f64; 2],
    /// Half of the lengths of the edges around it, m.
    length: f64,
    guards: Vec<Guard>,
}

/// A crack that holds a node against a body, as long as one of these contacts is not lost.
#[derive(Clone, Debug)]
struct Guard {
    body: usize,
    seam: usize,
    contacts: Range<usize>,
}

/// An edge of an outline, with the block on its left.
#[derive(Clone, Debug)]
struct Edge {
    nodes: [usize; 2],
    rest: [[f64; 2]; 2],
    length: f64,
    /// Position of its first node along the outline, m.
    abscissa: f64,
    /// The edges before and after it.
    neighbours: [usize; 2],
}

#[derive(Clone, Debug)]
struct Body {
    points: Range<usize>,
    edges: Range<usize>,
    /// Whether the ground holds none of its nodes.
    is_free: bool,
}

/// Distance within which blocks may come together in a communication step, beside what their speed allows, m.
const SKIN: f64 = 1e-3;

impl<L: ContactLaw> Outlines<L> {
    /// The outlines of the blocks of `mesh`; none if there is no crack.
    pub fn of(
        mesh: &Mesh,
        cracks: &[Crack<L>],
        integrations: &[Integration],
        is_held: impl Fn(usize) -> bool,
    ) -> Option<Self> {
        let softest =
            cracks.iter().map(Crack::law).min_by(|a, b| a.stiffness()[0].total_cmp(&b.stiffness()[0]))?;
        let mut outlines =
            Self { law: softest.clone(), points: Vec::new(), edges: Vec::new(), bodies: Vec::new() };
        let mut guards = guards(mesh, integrations);
        for block in &mesh.blocks {
            let (first_point, first_edge) = (outlines.points.len(), outlines.edges.len());
            let next = mesh.outline(block);
            let mut starts: Vec<usize> = next.keys().copied().collect();
            starts.sort_unstable();
            let mut places = HashMap::new();
            for start in starts {
                let (mut node, mut abscissa) = (start, 0.0);
                let first_of_loop = outlines.edges.len();
                while !places.contains_key(&node) {
                    let Some(&end) = next.get(&node) else { break };
                    let index = outlines.edges.len();
                    places.insert(node, index);
                    let rest = [node, end].map(|node| mesh.nodes[node]);
                    let length = mesh.length(&[node, end]);
                    let neighbours = [index.wrapping_sub(1), index + 1];
                    outlines.edges.push(Edge { nodes: [node, end], rest, length, abscissa, neighbours });
                    abscissa += length;
                    node = end;
                }
                let last = outlines.edges.len();
                if last > first_of_loop {
                    outlines.edges[first_of_loop].neighbours[0] = last - 1;
                    outlines.edges[last - 1].neighbours[1] = first_of_loop;
                }
            }
            for index in first_edge..outlines.edges.len() {
                let edge = &outlines.edges[index];
                let length = (edge.length + outlines.edges[edge.neighbours[0]].length) / 2.0;
                let node = edge.nodes[0];
                let guards = guards.remove(&node).unwrap_or_default();
                outlines.points.push(Point { node, rest: mesh.nodes[node], length, guards });
            }
            outlines.bodies.push(Body {
                points: first_point..outlines.points.len(),
                edges: first_edge..outlines.edges.len(),
                is_free: !block.nodes.clone().any(&is_held),
            });
        }
        Some(outlines)
    }

    /// Finds what may meet within the next `duration` (s), and forgets what has parted.
    pub fn search(
        &self,
        u: &[[f64; 2]],
        v: &[[f64; 2]],
        joints: &[Vec<JointState>],
        duration: f64,
        meetings: &mut Vec<Meeting>,
    ) {
        let speeds = self.points.iter().map(|point| v[point.node]).map(|[x, y]| x.hypot(y));
        // both may move, and be accelerated
        let reach = SKIN + 4.0 * speeds.fold(0.0, f64::max) * duration;
        if !reach.is_finite() {
            return;
        }
        let search = Search { outlines: self, u, joints, reach };
        meetings.retain(|meeting| {
            let point = &self.points[meeting.point as usize];
            !self.is_held(point, meeting.edge, joints)
                && (meeting.penetration > 0.0 || self.place(meeting, u).gap.abs() <= reach)
        });
        let of = |meeting: &Meeting| (meeting.point, self.body_met(meeting.edge));
        let known: HashSet<(u32, usize)> = meetings.iter().map(of).collect();
        meetings.extend(search.all().into_iter().filter(|meeting| !known.contains(&of(meeting))));
    }

    /// Adds the contact forces to `forces` (N/m) and updates the meetings.
    pub fn add_forces(
        &self,
        u: &[[f64; 2]],
        v: &[[f64; 2]],
        damping: StiffnessDamping,
        joints: &[Vec<JointState>],
        meetings: &mut [Meeting],
        forces: &mut [[f64; 2]],
    ) -> Losses {
        let mut losses = Losses::default();
        let [normal_stiffness, shear_stiffness] = self.law.stiffness();
        let StiffnessDamping { coefficient, memory } = damping;
        for meeting in meetings {
            let point = &self.points[meeting.point as usize];
            let weight = self.weight(meeting);
            let left = self.place(meeting, u);
            let held = self.is_held(point, meeting.edge, joints);
            let next = if held { None } else { self.beyond(meeting, &left, u) };
            if held || next.is_some() {
                // its springs act no longer
                let pressed = (meeting.penetration * -left.gap).max(0.0);
                let stretched = meeting.stretch * (left.along - meeting.anchor);
                losses.friction += weight * 0.5 * (normal_stiffness * pressed + shear_stiffness * stretched);
                *meeting =
                    Meeting { edge: next.or(meeting.edge), ..Meeting::open(meeting.point, meeting.edge) };
                if held {
                    continue;
                }
                meeting.anchor = self.place(meeting, u).along;
            }
            let place = if next.is_some() { self.place(meeting, u) } else { left };
            let relative = place.relative(point.node, v);
            let rates = [-dot(relative, place.normal), dot(relative, place.tangent)];
            let felt = [0, 1].map(|i| memory * meeting.rates[i] + (1.0 - memory) * rates[i]);
            let response = self.law.respond(&Touch {
                penetration: -place.gap,
                penetration_rate: felt[0],
                stretch: place.along - meeting.anchor,
                slip_rate: felt[1],
                damping: coefficient,
                bonded: false,
            });
            let closed = place.gap < 0.0;
            let slips = response.slipping || !closed;
            let anchor = if slips { place.along - response.stretch } else { meeting.anchor };
            let mean_shear = shear_stiffness * (meeting.stretch + response.stretch) / 2.0;
            // the anchor is in unloaded lengths; the shear force does its work along the current one
            losses.friction += weight * mean_shear * (anchor - meeting.anchor) / place.shortening;
            let mean = |i: usize| (meeting.dashpots[i] + response.dashpots[i]) / 2.0;
            losses.damping_power += weight * (mean(0) * rates[0] + mean(1) * rates[1]);
            *meeting = Meeting {
                point: meeting.point,
                edge: meeting.edge,
                anchor,
                stretch: response.stretch,
                penetration: if closed { -place.gap } else { 0.0 },
                dashpots: response.dashpots,
                rates: if closed { felt } else { [0.0; 2] },
            };
            if closed {
                let (n, t) = (place.normal, place.tangent);
                let force = [0, 1].map(|d| weight * (response.normal * n[d] - response.shear * t[d]));
                (0..2).for_each(|d| forces[point.node][d] += force[d]);
                for (node, share) in place.nodes() {
                    (0..2).for_each(|d| forces[node][d] -= share * force[d]);
                }
            }
        }
        losses
    }

    /// Whether points and edges of all meetings exist.
    pub fn know(&self, meetings: &[Meeting]) -> bool {
        let exists = |index: u32, count: usize| (index as usize) < count;
        meetings.iter().all(|meeting| {
            exists(meeting.point, self.points.len())
                && meeting.edge.is_none_or(|edge| exists(edge, self.edges.len()))
        })
    }

    /// Energy of the springs, J/m.
    pub fn energy(&self, meetings: &[Meeting]) -> f64 {
        let energy =
            |meeting: &Meeting| self.weight(meeting) * self.law.energy(meeting.penetration, meeting.stretch);
        meetings.iter().map(energy).sum()
    }

    /// Unloaded place of the point of a closed meeting (m), if there is one, and whether it is with the ground.
    pub fn first_closed(&self, meetings: &[Meeting]) -> Option<([f64; 2], bool)> {
        let closed = meetings.iter().find(|meeting| meeting.penetration > 0.0)?;
        Some((self.points[closed.point as usize].rest, closed.edge.is_none()))
    }

    fn weight(&self, meeting: &Meeting) -> f64 {
        let length = self.points[meeting.point as usize].length;
        if meeting.edge.is_some() { length / 2.0 } else { length }
    }

    /// Whether a crack holds a point against the body of an edge, or against the ground.
    fn is_held(&self, point: &Point, edge: Option<u32>, joints: &[Vec<JointState>]) -> bool {
        point.is_held_against(self.body_met(edge), joints)
    }

    /// The body of an edge, or the ground.
    fn body_met(&self, edge: Option<u32>) -> usize {
        let of = |edge: u32| self.bodies.partition_point(|body| body.edges.end <= edge as usize);
        edge.map_or(self.bodies.len(), of)
    }

    /// A new meeting whose shear spring is attached where it is.
    fn started(&self, meeting: Meeting, u: &[[f64; 2]]) -> Meeting {
        Meeting { anchor: self.place(&meeting, u).along, ..meeting }
    }

    /// Where a meeting is.
    #[inline]
    fn place(&self, meeting: &Meeting, u: &[[f64; 2]]) -> Place {
        #[cfg(test)]
        super::effort::spend(|effort| effort.edges += 1);
        let point = &self.points[meeting.point as usize];
        let Some(edge) = meeting.edge.map(|edge| &self.edges[edge as usize]) else {
            let [x, y] = [0, 1].map(|d| point.rest[d] + u[point.node][d]);
            return Place {
                edge: None,
                position: 0.0,
                length: 1.0,
                along: x,
                shortening: 1.0,
                gap: y,
                tangent: [1.0, 0.0],
                normal: [0.0, 1.0],
            };
        };
        let [a, b] = edge.nodes;
        // differences of unloaded positions and of displacements separately, so that no digits are lost
        let side = [0, 1].map(|d| edge.rest[1][d] - edge.rest[0][d] + (u[b][d] - u[a][d]));
        let from = [0, 1].map(|d| point.rest[d] - edge.rest[0][d] + (u[point.node][d] - u[a][d]));
        let length = dot(side, side).sqrt();
        let tangent = side.map(|x| x / length);
        // the block lies on the left
        let normal = [tangent[1], -tangent[0]];
        let position = dot(from, tangent) / length;
        Place {
            edge: Some(edge.nodes),
            position,
            length,
            along: edge.abscissa + position * edge.length,
            shortening: edge.length / length,
            gap: dot(from, normal),
            tangent,
            normal,
        }
    }

    /// The next edge, if the meeting's point lies beyond an end of its edge and, but for a corner, opposite the next one.
    fn beyond(&self, meeting: &Meeting, place: &Place, u: &[[f64; 2]]) -> Option<u32> {
        let edge = &self.edges[meeting.edge? as usize];
        let next = match place.position {
            position if position < 0.0 => edge.neighbours[0],
            position if position > 1.0 => edge.neighbours[1],
            _ => return None,
        };
        let there = self.place(&Meeting::open(meeting.point, Some(next as u32)), u);
        // outside a corner, between the normals of both edges, it stays where it was
        let opposite = if place.position < 0.0 { there.position <= 1.0 } else { there.position >= 0.0 };
        (opposite || place.gap < 0.0).then_some(next as u32)
    }
}

/// A search for what may meet within `reach` (m).
struct Search<'a, L> {
    outlines: &'a Outlines<L>,
    u: &'a [[f64; 2]],
    joints: &'a [Vec<JointState>],
    reach: f64,
}

/// Lowest and highest coordinates, m.
type Extent = [[f64; 2]; 2];

impl<L: ContactLaw> Search<'_, L> {
    fn all(&self) -> Vec<Meeting> {
        let mut found = Vec::new();
        let mut boxes: Vec<(usize, Extent)> =
            self.outlines.bodies.iter().map(|body| self.extent(body)).enumerate().collect();
        for (body, [lowest, _]) in &boxes {
            if self.outlines.bodies[*body].is_free && lowest[1] <= 0.0 {
                self.meet_ground(*body, &mut found);
            }
        }
        // along the longer side of all boxes, and then across it
        let side = |d: usize| {
            let ends = |end: usize| boxes.iter().map(move |(_, extent)| extent[end][d]);
            ends(1).fold(f64::NEG_INFINITY, f64::max) - ends(0).fold(f64::INFINITY, f64::min)
        };
        let [along, across] = if side(1) > side(0) { [1, 0] } else { [0, 1] };
        boxes.sort_by(|a, b| a.1[0][along].total_cmp(&b.1[0][along]));
        for (index, (first, [low, high])) in boxes.iter().enumerate() {
            let near = boxes[index + 1..].iter().take_while(|(_, other)| other[0][along] <= high[along]);
            let meets = |other: &Extent| {
                #[cfg(test)]
                super::effort::spend(|effort| effort.boxes += 1);
                other[0][across] <= high[across] && other[1][across] >= low[across]
            };
            for (second, other) in near.filter(|(_, other)| meets(other)) {
                let overlap =
                    [[0, 1].map(|d| low[d].max(other[0][d])), [0, 1].map(|d| high[d].min(other[1][d]))];
                for [points, edges] in [[*first, *second], [*second, *first]] {
                    self.meet(points, edges, overlap, &mut found);
                }
            }
        }
        found
    }

    fn at(&self, point: &Point) -> [f64; 2] {
        [0, 1].map(|d| point.rest[d] + self.u[point.node][d])
    }

    /// The box around the points of a body, wider by the reach.
    fn extent(&self, body: &Body) -> Extent {
        let mut extent = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for point in &self.outlines.points[body.points.clone()] {
            let at = self.at(point);
            for d in 0..2 {
                extent[0][d] = extent[0][d].min(at[d] - self.reach);
                extent[1][d] = extent[1][d].max(at[d] + self.reach);
            }
        }
        extent
    }

    fn meet_ground(&self, body: usize, found: &mut Vec<Meeting>) {
        for index in self.outlines.bodies[body].points.clone() {
            let point = &self.outlines.points[index];
            let near = self.at(point)[1].abs() <= self.reach;
            if near && !self.outlines.is_held(point, None, self.joints) {
                found.push(self.outlines.started(Meeting::open(index as u32, None), self.u));
            }
        }
    }

    /// Lets points of one body meet edges of another within the box `overlap`.
    fn meet(&self, points: usize, edges: usize, overlap: Extent, found: &mut Vec<Meeting>) {
        for index in self.outlines.bodies[points].points.clone() {
            let point = &self.outlines.points[index];
            let at = self.at(point);
            let inside = (0..2).all(|d| (overlap[0][d]..=overlap[1][d]).contains(&at[d]));
            if !inside || point.is_held_against(edges, self.joints) {
                continue;
            }
            let near = self.outlines.bodies[edges].edges.clone().filter_map(|edge| {
                let meeting = Meeting::open(index as u32, Some(edge as u32));
                let place = self.outlines.place(&meeting, self.u);
                let margin = self.reach / place.length;
                let opposite = (-margin..=1.0 + margin).contains(&place.position);
                (opposite && place.gap.abs() <= self.reach).then_some((place.gap, meeting))
            });
            if let Some((_, meeting)) = near.max_by(|a, b| a.0.total_cmp(&b.0)) {
                found.push(self.outlines.started(meeting, self.u));
            }
        }
    }
}

impl Meeting {
    /// Without force.
    pub(crate) fn open(point: u32, edge: Option<u32>) -> Self {
        Self { point, edge, anchor: 0.0, stretch: 0.0, penetration: 0.0, dashpots: [0.0; 2], rates: [0.0; 2] }
    }
}

impl Point {
    fn is_held_against(&self, body: usize, joints: &[Vec<JointState>]) -> bool {
        self.guards.iter().filter(|guard| guard.body == body).any(|guard| guard.holds(joints))
    }
}

impl Guard {
    fn holds(&self, joints: &[Vec<JointState>]) -> bool {
        let contacts = joints.get(self.seam).and_then(|joints| joints.get(self.contacts.clone()));
        contacts.is_some_and(|contacts| contacts.iter().any(|joint| joint.status != ContactStatus::Lost))
    }
}

/// Current position of a meeting.
struct Place {
    /// The edge's nodes; none for the ground.
    edge: Option<[usize; 2]>,
    /// Along the edge, from 0 to 1.
    position: f64,
    length: f64,
    /// Position along the outline, in unloaded lengths, m.
    along: f64,
    /// Unloaded length of the edge over its current one.
    shortening: f64,
    gap: f64,
    tangent: [f64; 2],
    normal: [f64; 2],
}

impl Place {
    /// The nodes of the edge with their shares.
    #[inline(always)]
    fn nodes(&self) -> impl Iterator<Item = (usize, f64)> {
        let shares = [1.0 - self.position, self.position];
        self.edge.into_iter().flat_map(move |nodes| nodes.into_iter().zip(shares))
    }

    /// Velocity of `node` relative to the edge.
    #[inline(always)]
    fn relative(&self, node: usize, v: &[[f64; 2]]) -> [f64; 2] {
        let mut relative = v[node];
        for (other, share) in self.nodes() {
            (0..2).for_each(|d| relative[d] -= share * v[other][d]);
        }
        relative
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// What holds the nodes on cracks: for each of them the other body and the contacts around the node.
fn guards(mesh: &Mesh, integrations: &[Integration]) -> HashMap<usize, Vec<Guard>> {
    let mut guards: HashMap<usize, Vec<Guard>> = HashMap::new();
    for (seam, (part, integration)) in mesh.seams.iter().zip(integrations).enumerate() {
        let mut first = 0;
        let lower = if mesh.is_ground(part.below) { &[] } else { &part.lower[..] };
        for (side, body) in [(&part.upper[..], part.below), (lower, part.above)] {
            let count = match integration {
                Integration::Nodal => side.len(),
                Integration::Gauss => 2 * side.len().saturating_sub(1),
            };
            for (index, &node) in side.iter().enumerate() {
                let around = match integration {
                    Integration::Nodal => index..index + 1,
                    Integration::Gauss => (2 * index).saturating_sub(2)..(2 * index + 2).min(count),
                };
                let contacts = first + around.start..first + around.end;
                guards.entry(node).or_default().push(Guard { body, seam, contacts });
            }
            first += count;
        }
    }
    guards
}
