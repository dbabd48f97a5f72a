use std::borrow::Cow;

use super::{Acting, Load, LoadBasis};
use crate::Mesh;
use crate::contact::{ContactLaw, ContactStatus, Crack, JointState, Pressing};
use crate::mesh::CrackPath;
use crate::structure::Structure;
use crate::uplift::{JointWater, Uplift, UpliftRule, interpolate};

/// Pressure of the water in the joints; its amplitudes are the pressures at all contacts, 0 in cracks without uplift.
///
/// It presses both sides of a joint apart, normal to it in the unloaded position. Each contact takes it on the length for which
/// its springs stand, so that their stress is the effective one at every point.
#[derive(Debug)]
pub(crate) struct Joints {
    joints: Vec<Joint>,
    basis: LoadBasis,
}

/// The water in one crack.
#[derive(Clone, Debug)]
struct Joint {
    /// Its number from the base up.
    crack: usize,
    uplift: Uplift,
    water: JointWater,
    /// Its contacts from the upstream end on.
    contacts: Vec<Contact>,
}

#[derive(Clone, Copy, Debug)]
struct Contact {
    /// Its number among all contacts.
    index: usize,
    /// The part of a crack to which it belongs, and its number there.
    part: usize,
    local: usize,
    /// Distance from the upstream end along the crack, m.
    distance: f64,
    /// Length on which it takes the pressure, m.
    length: f64,
}

/// Lengths over which a joint is open from its upstream and from its downstream end on, m.
pub(crate) type Opened = [f64; 2];

impl Joints {
    /// The water in the cracks of a `structure`: `uplifts` has one entry per crack, from the base up; `water` has the levels (m) and
    /// specific weights (N/m³) upstream and downstream. `None` without uplift.
    pub fn new(
        structure: &Structure<impl ContactLaw>,
        uplifts: &[Option<Uplift>],
        water: ([f64; 2], [f64; 2]),
    ) -> Option<Self> {
        let mesh = &structure.mesh;
        let mut first = Vec::new();
        let mut count = 0;
        for crack in &structure.cracks {
            first.push(count);
            count += crack.contact_count();
        }
        let mut basis = LoadBasis { columns: count, entries: Vec::new() };
        let mut joints = Vec::new();
        for (index, uplift) in uplifts.iter().enumerate() {
            let (Some(uplift), Some(path)) = (uplift, CrackPath::of(mesh, index)) else { continue };
            let mut contacts = Vec::new();
            for &(part, offset) in &path.parts {
                let crack = &structure.cracks[part];
                for (local, pressing) in crack.pressing().enumerate() {
                    let Pressing { distance, length, nodes, forces } = pressing;
                    let (index, distance) = (first[part] + local, offset + distance);
                    contacts.push(Contact { index, part, local, distance, length });
                    let entries = nodes.into_iter().zip(forces).filter(|_| length > 0.0);
                    basis.entries.extend(entries.map(|(node, force)| (node, index, force)));
                }
            }
            contacts.sort_by(|a, b| a.distance.total_cmp(&b.distance));
            let water = water_in(&path, mesh, water);
            joints.push(Joint { crack: index, uplift: uplift.clone(), water, contacts });
        }
        (!joints.is_empty()).then_some(Self { joints, basis })
    }

    /// How far each joint is open in this state of the contacts.
    pub fn opened(&self, joints: &[Vec<JointState>]) -> Vec<Opened> {
        self.joints.iter().map(|joint| joint.opened(joints)).collect()
    }

    /// Pressure at all contacts while the joints are closed, at the `time` (s) of the table of factors, Pa.
    pub fn closed(&self, time: f64) -> Vec<f64> {
        self.at_rest(time, &vec![[0.0; 2]; self.joints.len()])
    }

    /// The crack (from the base up) and the length (m) of each joint with water.
    pub fn cracks(&self) -> impl ExactSizeIterator<Item = (usize, f64)> + '_ {
        self.joints.iter().map(|joint| (joint.crack, joint.water.length))
    }

    /// Force of the water in a `crack` on the block above, normal to it, with these pressures at all contacts (Pa), N/m.
    pub fn force(&self, crack: usize, pressures: &[f64]) -> f64 {
        let joints = self.joints.iter().filter(|joint| joint.crack == crack);
        let contacts = joints.flat_map(|joint| &joint.contacts);
        contacts.map(|contact| contact.length * pressures[contact.index]).sum()
    }

    /// The same in a state of rest in which the joints are `opened`.
    pub fn at_rest(&self, time: f64, opened: &[Opened]) -> Vec<f64> {
        self.pressures(|joint, index| {
            let line = joint.water.nodes(&joint.uplift, opened[index]);
            let factor = joint.uplift.factor_at(time);
            move |contact| factor * interpolate(&line, contact.distance)
        })
    }

    /// Pressure at all contacts where they are closed, at the `time` (s) of an earthquake, by the rule of each joint, Pa. `rest` is
    /// what was open before it, `opened` what is open now.
    pub fn during_shaking(&self, time: f64, rest: &[Opened], opened: &[Opened]) -> Vec<f64> {
        self.pressures(|joint, index| {
            let (rest, now) = (rest[index], opened[index]);
            let cracks = match joint.uplift.rule {
                UpliftRule::Unchanged | UpliftRule::ZeroWhereOpen => rest,
                // what was full of water at rest stays so
                UpliftRule::FullWhereOpen => [rest[0].max(now[0]), rest[1].max(now[1])],
            };
            let line = joint.water.nodes(&joint.uplift, cracks);
            let factor = joint.uplift.factor_at(time);
            move |contact| factor * interpolate(&line, contact.distance)
        })
    }

    /// Tells the contacts of joints that lose their pressure where they open how much that is: the smaller of the pressures at the
    /// ends of the communication step.
    pub fn relieve(&self, joints: &mut [Vec<JointState>], [start, end]: [&[f64]; 2]) {
        for contact in self.relieved().flat_map(|joint| &joint.contacts) {
            joints[contact.part][contact.local].relief = start[contact.index].min(end[contact.index]);
        }
    }

    /// Takes the pressure that open contacts have lost from `pressures` (Pa at all contacts).
    pub fn without_relief(
        &self,
        cracks: &[Crack<impl ContactLaw>],
        joints: &[Vec<JointState>],
        pressures: &mut [f64],
    ) {
        for contact in self.relieved().flat_map(|joint| &joint.contacts) {
            let state = &joints[contact.part][contact.local];
            let pressure = &mut pressures[contact.index];
            *pressure -= state.relief_at(state.gap, *pressure, cracks[contact.part].law());
        }
    }

    /// The joints that lose their pressure where they open.
    fn relieved(&self) -> impl Iterator<Item = &Joint> {
        self.joints.iter().filter(|joint| joint.uplift.rule == UpliftRule::ZeroWhereOpen)
    }

    fn pressures<P: Fn(&Contact) -> f64>(&self, of_joint: impl Fn(&Joint, usize) -> P) -> Vec<f64> {
        let mut pressures = vec![0.0; self.basis.columns];
        for (index, joint) in self.joints.iter().enumerate() {
            let pressure = of_joint(joint, index);
            joint.contacts.iter().for_each(|contact| pressures[contact.index] = pressure(contact));
        }
        pressures
    }
}

impl Joint {
    /// How far it is open from either end, with these states of all contacts: to where the gap between the last open and the
    /// first closed contact vanishes.
    fn opened(&self, joints: &[Vec<JointState>]) -> Opened {
        let length = self.water.length;
        let from = |contacts: &mut dyn Iterator<Item = &Contact>, end: f64| {
            let mut last: Option<(f64, f64)> = None;
            for contact in contacts {
                let (distance, state) =
                    ((contact.distance - end).abs(), &joints[contact.part][contact.local]);
                if matches!(state.status, ContactStatus::Open | ContactStatus::Lost) {
                    last = Some((distance, state.gap.max(0.0)));
                    continue;
                }
                let closed = state.penetration.max(0.0);
                let zero = |(at, gap): (f64, f64)| match state.bonded || gap == 0.0 {
                    true => at,
                    false => at + (distance - at) * gap / (gap + closed),
                };
                return last.map_or(0.0, zero);
            }
            length
        };
        [from(&mut self.contacts.iter(), 0.0), from(&mut self.contacts.iter().rev(), length)]
    }
}

impl Load for Joints {
    fn basis(&self) -> &LoadBasis {
        &self.basis
    }

    fn amplitudes<'a>(&'a self, acting: &'a Acting) -> Cow<'a, [f64]> {
        Cow::Borrowed(&acting.uplift)
    }

    /// None: modes contain every displacement of the nodes on cracks.
    fn at_rest(&self) -> Vec<Vec<f64>> {
        Vec::new()
    }
}

/// The water at the ends of a `crack` of this `mesh`, with the levels (m) and specific weights (N/m³) of the `water` upstream and
/// downstream; `None` of a crack that does not cut the mesh.
pub(crate) fn water_at(mesh: &Mesh, crack: usize, water: ([f64; 2], [f64; 2])) -> Option<JointWater> {
    Some(water_in(&CrackPath::of(mesh, crack)?, mesh, water))
}

/// The water at the ends of the crack with this `path`. No water enters an end that is not on a side of the dam.
fn water_in(path: &CrackPath, mesh: &Mesh, (levels, specific_weights): ([f64; 2], [f64; 2])) -> JointWater {
    let ends = path.ends.map(|node| mesh.nodes[node]);
    let sides = [&mesh.upstream, &mesh.downstream];
    let wet = |end: usize| sides[end].iter().any(|&node| mesh.nodes[node] == ends[end]);
    let levels = [0, 1].map(|end| if wet(end) { levels[end] } else { ends[end][1] });
    JointWater { ends, length: path.length, levels, specific_weights }
}
