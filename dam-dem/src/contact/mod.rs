//! Contact along cracks: points of either side against the segments of the other.
//!
//! Every point of the upper side meets the lower side's polyline with half of the length that it stands for as weight,
//! and every point of the lower side meets the upper one with the other half, so neither side is preferred and a closed
//! crack in its position of rest closes by exactly p/k_n.
//!
//! **Along the crack.** A contact stands for a part of its side, and as much of that part as lies opposite the other
//! side counts: sides that end in different places meet over their common length, and where a block slides out the
//! contact at its corner fades until nothing of its part is left. Then it is lost, and found again when the block comes
//! back. The energy of the springs that fade is counted as lost to friction.
//!
//! **Known effects.** The points are the nodes, or two Gauss points a segment ([`Integration`]). Nodes lie at the corners:
//! a rocking block turns about its true corner, where all of the force is gathered as in one spring of a quarter of a
//! segment. The outermost Gauss points lie a fifth of a segment inside: pressure along the crack is smoother, and a
//! rocking block is less stable by that much. The moment that a pair of forces leaves is (force × penetration), because
//! action and reaction act on the two surfaces and not in one point.

mod coulomb;
mod crack;
mod mohr_coulomb;
mod search;

use serde::{Deserialize, Serialize};

pub use coulomb::Coulomb;
pub use crack::{ContactStatus, Crack, CrackForces, JointState, Stencil};
pub use mohr_coulomb::MohrCoulomb;

/// Where along a crack the contacts are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Integration {
    /// At the nodes.
    #[default]
    Nodal,
    /// At two Gauss points of each segment.
    Gauss,
}

/// What a contact law sees of one contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Overlap of the surfaces along the normal, what dilation adds included, m; negative where there is a gap.
    pub penetration: f64,
    /// Its rate, m/s, as the dashpot feels it: with the memory of stiffness damping.
    pub penetration_rate: f64,
    /// Stretch of the shear spring if nothing slips now, m.
    pub stretch: f64,
    /// Tangential velocity of the point against the other side, m/s, felt in the same way.
    pub slip_rate: f64,
    /// Stiffness damping β of the dashpots `β k_n` and `β k_s`, s.
    pub damping: f64,
    /// Whether the contact is still bonded.
    pub bonded: bool,
}

/// What a contact law answers, per unit of length (and metre of dam).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// Normal stress, Pa, compression positive.
    pub normal: f64,
    /// Shear stress, Pa; it acts on the point against the slip.
    pub shear: f64,
    /// Stretch of the shear spring after slipping, m.
    pub stretch: f64,
    /// The shear strength was reached.
    pub slipping: bool,
    /// Whether the contact stays bonded; a bond that broke is never made again.
    pub bonded: bool,
    /// Normal and shear stresses of the dashpots, contained in those above, Pa.
    pub dashpots: [f64; 2],
}

impl Response {
    /// That of a gap.
    pub const NONE: Self =
        Self { normal: 0.0, shear: 0.0, stretch: 0.0, slipping: false, bonded: false, dashpots: [0.0; 2] };
}

/// The door for other contact laws.
///
/// **Call order**: [`respond`](Self::respond) once per contact and time step. A law has no memory of
/// its own: the stretch of the shear spring, whether it is bonded and how far it slipped are kept for it. **Guarantees
/// expected**: no tension unless bonded (`normal ≥ 0`, and nothing at all where the penetration is not positive), a
/// stretch that only shrinks by slipping, dashpots that never feed energy in against the rates in [`Touch`]. The critical
/// time step knows the [`stiffness`](Self::stiffness) and β; a law with dampers of its own must be run with
/// shorter ones.
///
/// `examples/lubricated_joint.rs` walks through a law of one's own.
pub trait ContactLaw: Clone + Send + Sync {
    /// Stresses of one contact.
    fn respond(&self, touch: &Touch) -> Response;

    /// Normal and shear stiffness of a closed, sticking contact, Pa/m.
    fn stiffness(&self) -> [f64; 2];

    /// Whether contacts are bonded at first.
    fn is_bonded(&self) -> bool {
        false
    }

    /// By how much the sides rise on each other after slip of `slipped` (m) in all, m.
    fn dilation(&self, _slipped: f64) -> f64 {
        0.0
    }

    /// Energy in the springs, J/m², at a penetration (negative in a bond under tension) and a stretch (m).
    fn energy(&self, penetration: f64, stretch: f64) -> f64 {
        let [normal, shear] = self.stiffness();
        0.5 * (normal * penetration * penetration + shear * stretch * stretch)
    }
}
