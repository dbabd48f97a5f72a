//! What is kept of stresses, displacements and contacts over time.

use serde::{Deserialize, Serialize};
use std::sync::Arc;

use crate::Mesh;
use crate::contact::{ContactStatus, Crack, JointState, MohrCoulomb};
use crate::recovery::principal;

/// Extremes over time, at the corners of cells as [`StressRecovery`](crate::StressRecovery) counts them and at the contacts, one
/// crack after another. It is a part of the state: what is sampled in a step that is repeated is forgotten.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Envelope {
    corners: Arc<Vec<AtCorner>>,
    contacts: Vec<AtContact>,
    /// Instants of which `corners` knows nothing yet.
    waiting: Vec<Arc<Instant>>,
}

/// The motion at the end of a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Instant {
    pub end: StepEnd,
    /// In the coordinates of the motion.
    pub coordinates: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct StepEnd {
    /// The end of the step, s.
    pub time: f64,
    /// Its length, s.
    pub step: f64,
}

/// Extremes at a corner of cells.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct AtCorner {
    /// Largest of the larger principal stress, Pa, and when it was, s.
    pub major: [f64; 2],
    /// Smallest of the smaller principal stress, Pa, and when it was, s.
    pub minor: [f64; 2],
    /// Least and most displacement along x, then along y, m.
    pub displacement: [[f64; 2]; 2],
    /// Largest length of the displacement, m.
    pub magnitude: f64,
    /// For how long the larger principal stress was above the tensile strength, s.
    pub overstressed: f64,
}

/// Extremes at a contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct AtContact {
    /// Largest gap, m.
    pub opening: f64,
    /// Least and most slip, positive downstream, m.
    pub slip: [f64; 2],
}

/// Stresses and displacements at the corners of cells at the ends of at most `N` steps.
pub(crate) struct Sample<'a, const N: usize> {
    pub ends: &'a [StepEnd],
    /// xx, yy, xy at each corner, Pa, at each of the ends.
    pub stresses: &'a [[[f64; N]; 3]],
    /// Since time 0, m.
    pub displacements: &'a [[[f64; N]; 2]],
    /// Tensile strengths at the corners, Pa.
    pub strengths: &'a [f64],
}

impl AtCorner {
    const NOTHING: Self = Self {
        major: [f64::NEG_INFINITY, 0.0],
        minor: [f64::INFINITY, 0.0],
        displacement: [[f64::INFINITY, f64::NEG_INFINITY]; 2],
        magnitude: 0.0,
        overstressed: 0.0,
    };

    /// The larger of the extremes of both.
    fn with(self, other: Self) -> Self {
        let axis = |d: usize| {
            let [[least, most], [low, high]] = [self.displacement[d], other.displacement[d]];
            [least.min(low), most.max(high)]
        };
        Self {
            major: if other.major[0] > self.major[0] { other.major } else { self.major },
            minor: if other.minor[0] < self.minor[0] { other.minor } else { self.minor },
            displacement: [axis(0), axis(1)],
            magnitude: self.magnitude.max(other.magnitude),
            overstressed: self.overstressed.max(other.overstressed),
        }
    }

    /// The mean of four, with the times of the first whose stress is the largest, or the smallest.
    fn mean(four: [Self; 4]) -> Self {
        let mean = |value: &dyn Fn(&Self) -> f64| four.iter().map(value).sum::<f64>() / 4.0;
        let all = four.into_iter().fold(Self::NOTHING, Self::with);
        Self {
            major: [mean(&|at| at.major[0]), all.major[1]],
            minor: [mean(&|at| at.minor[0]), all.minor[1]],
            displacement: [0, 1].map(|d| [0, 1].map(|end| mean(&|at| at.displacement[d][end]))),
            magnitude: mean(&|at| at.magnitude),
            overstressed: mean(&|at| at.overstressed),
        }
    }
}

impl Envelope {
    /// Before anything was sampled.
    pub fn new(corners: usize, contacts: usize) -> Self {
        let contact = AtContact { opening: 0.0, slip: [f64::INFINITY, f64::NEG_INFINITY] };
        Self {
            corners: Arc::new(vec![AtCorner::NOTHING; corners]),
            contacts: vec![contact; contacts],
            waiting: Vec::new(),
        }
    }

    /// Numbers of corners and contacts.
    pub fn shape(&self) -> [usize; 2] {
        [self.corners.len(), self.contacts.len()]
    }

    /// Extremes at the contacts.
    pub fn contacts(&self) -> &[AtContact] {
        &self.contacts
    }

    /// Instants that wait to be added.
    pub fn waiting(&self) -> impl ExactSizeIterator<Item = &Instant> + Clone {
        self.waiting.iter().map(Arc::as_ref)
    }

    /// Lets an instant wait.
    pub fn wait(&mut self, instant: Instant) {
        self.waiting.push(Arc::new(instant));
    }

    /// Adds a `sample` of the instants that wait.
    pub fn settle<const N: usize>(&mut self, sample: &Sample<'_, N>) {
        self.waiting.clear();
        self.add(sample);
    }

    /// Adds a `sample`.
    pub fn add<const N: usize>(&mut self, sample: &Sample<'_, N>) {
        let corners = Arc::make_mut(&mut self.corners);
        pulp::Arch::new().dispatch(Addition { corners, sample });
    }

    /// Adds what was at the contacts of `cracks`; one whose sides have left each other has neither gap nor slip.
    pub fn add_contacts(&mut self, cracks: &[Crack<MohrCoulomb>], joints: &[Vec<JointState>]) {
        let now =
            cracks.iter().zip(joints).flat_map(|(crack, joints)| joints.iter().zip(crack.slips(joints)));
        for (at, (joint, slip)) in self.contacts.iter_mut().zip(now) {
            if joint.status != ContactStatus::Lost {
                at.opening = at.opening.max(joint.gap);
                at.slip = [at.slip[0].min(slip), at.slip[1].max(slip)];
            }
        }
    }

    /// Extremes at the nodes of `mesh`, and the largest of the larger principal stress over the tensile strength, 0 for compression;
    /// `corners` are the nodes of the corners. A node between zones has the larger of its extremes in each; the centre of a cell has the
    /// mean of its corners, for there no stress is recovered.
    pub fn at_nodes(&self, mesh: &Mesh, corners: &[usize], strengths: &[f64]) -> Vec<(AtCorner, f64)> {
        let mut found = vec![(AtCorner::NOTHING, 0.0f64); mesh.nodes.len()];
        for ((&node, &at), strength) in corners.iter().zip(self.corners.iter()).zip(strengths) {
            let (all, ratio) = found[node];
            found[node] = (all.with(at), ratio.max(at.major[0] / strength));
        }
        for &[a, b, c, d, centre] in &mesh.cells {
            let four = [a, b, c, d].map(|node| found[node]);
            let ratio = four.iter().map(|(_, ratio)| ratio).sum::<f64>() / 4.0;
            found[centre] = (AtCorner::mean(four.map(|(at, _)| at)), ratio);
        }
        found
    }
}

struct Addition<'a, const N: usize> {
    corners: &'a mut [AtCorner],
    sample: &'a Sample<'a, N>,
}

impl<const N: usize> pulp::NullaryFnOnce for Addition<'_, N> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Sample { ends, stresses, displacements, strengths } = *self.sample;
        let now = stresses.iter().zip(displacements).zip(strengths);
        for (at, (([xx, yy, xy], [x, y]), strength)) in self.corners.iter_mut().zip(now) {
            let (mut major, mut minor, mut magnitude) = ([0.0; N], [0.0; N], [0.0; N]);
            for i in 0..N {
                [major[i], minor[i]] = principal([xx[i], yy[i], xy[i]]);
                magnitude[i] = (x[i] * x[i] + y[i] * y[i]).sqrt();
            }
            for (i, &StepEnd { time, step }) in ends.iter().enumerate().take(N) {
                if major[i] > at.major[0] {
                    at.major = [major[i], time];
                }
                if minor[i] < at.minor[0] {
                    at.minor = [minor[i], time];
                }
                for ([least, most], u) in at.displacement.iter_mut().zip([x[i], y[i]]) {
                    (*least, *most) = (least.min(u), most.max(u));
                }
                at.magnitude = at.magnitude.max(magnitude[i]);
                if major[i] > *strength {
                    at.overstressed += step;
                }
            }
        }
    }
}
