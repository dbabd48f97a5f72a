//! Contact along cracks: points of each side against the segments of the other side.
//!
//! Every point of the upper side is in contact with the polyline of the lower side, weighted with half of its
//! tributary length; every point of the lower side is in contact with the upper side, weighted with the other
//! half. Neither side is preferred, and under a uniform pressure p a closed crack with matching sides closes
//! by exactly p/k_n.
//!
//! **Along the crack.** A contact represents a part of its side, and only the share of this part that lies
//! opposite the other side counts. Sides that end at different places are in contact over their common
//! length. Where a block slides out, the contact at its corner decreases until nothing of its part is left.
//! Then the contact is lost; it is found again when the block comes back on the same level. The energy of springs that are lost
//! in this way counts as lost to friction. What has slid off may meet another side or the ground ([`Meeting`]).
//!
//! **Known effects.** The points are the nodes, or two Gauss points in each segment ([`Integration`]). Nodes
//! lie at the corners: a rocking block turns about its true corner, where one spring with a quarter of a
//! segment as weight carries the whole force. The outermost Gauss points lie a fifth of a segment inside:
//! pressure along the crack is smoother, but a rocking block is less stable because its lever arm is shorter.
//! A pair of contact forces has a resulting moment of (force × penetration), because action and reaction act
//! on two surfaces and not at one point. Where dilation separates the sides, a couple on the segment takes the
//! moment (shear force × rise).

mod coulomb;
mod crack;
#[cfg(test)]
pub(crate) mod effort;
mod meeting;
mod mohr_coulomb;
mod parting;
mod search;
mod trials;

use serde::{Deserialize, Serialize};

pub use coulomb::Coulomb;
pub use crack::{ContactStatus, Crack, CrackForces, JointState, Stencil};
pub(crate) use crack::{Eights, Pressed};
pub use meeting::Meeting;
pub(crate) use meeting::Outlines;
pub use mohr_coulomb::MohrCoulomb;
pub(crate) use parting::Parting;
pub(crate) use trials::Trials;

/// Where along a crack the contacts are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Integration {
    /// At the nodes.
    #[default]
    Nodal,
    /// At two Gauss points of each segment.
    Gauss,
}

/// State of one contact, as input to a contact law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Overlap of the surfaces along the normal, including the rise by dilation, m; negative for a gap.
    pub penetration: f64,
    /// Rate of penetration that acts on the dashpot, with the memory of stiffness damping, m/s.
    pub penetration_rate: f64,
    /// Stretch of the shear spring if the contact does not slip in this step (trial value), m.
    pub stretch: f64,
    /// Tangential velocity of the point relative to the other side that acts on the dashpot, with the same
    /// memory, m/s.
    pub slip_rate: f64,
    /// Stiffness damping β of the dashpots `β k_n` and `β k_s`, s.
    pub damping: f64,
    /// Whether the contact is still bonded.
    pub bonded: bool,
}

/// Result of a contact law, per unit of length and metre of dam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// Normal stress, Pa, compression positive.
    pub normal: f64,
    /// Shear stress, Pa; on the point it acts against the slip.
    pub shear: f64,
    /// Stretch of the shear spring after slipping, m.
    pub stretch: f64,
    /// Whether the shear strength was reached.
    pub slipping: bool,
    /// Whether the contact remains bonded; a broken bond never recovers.
    pub bonded: bool,
    /// Normal and shear stresses of the dashpots, included in `normal` and `shear`, Pa.
    pub dashpots: [f64; 2],
}

impl Response {
    /// Response of an open contact.
    pub const NONE: Self =
        Self { normal: 0.0, shear: 0.0, stretch: 0.0, slipping: false, bonded: false, dashpots: [0.0; 2] };
}

/// Interface for contact laws.
///
/// **Call order**: [`respond`](Self::respond) once per contact and time step, unless Coulomb's law stands for it
/// ([`unbonded`](Self::unbonded)). A law has no state of its own:
/// the crack stores the stretch of the shear spring, the bond and the accumulated slip. **Required
/// guarantees**: no tension unless bonded (`normal ≥ 0`, and no stress at all if the penetration is not
/// positive); slip only reduces the stretch; dashpots never add energy with the rates in [`Touch`]. The
/// critical time step considers the [`stiffness`](Self::stiffness) and β only; a law with other dampers must
/// be run with shorter time steps.
///
/// `examples/lubricated_joint.rs` shows a user-defined law.
pub trait ContactLaw: Clone + Send + Sync {
    /// Stresses of one contact.
    fn respond(&self, touch: &Touch) -> Response;

    /// Normal and shear stiffness of a closed, sticking contact, Pa/m.
    fn stiffness(&self) -> [f64; 2];

    /// Whether contacts are bonded initially.
    fn is_bonded(&self) -> bool {
        false
    }

    /// Distance by which dilation has separated the sides after an accumulated slip of `slipped` (m), m.
    fn dilation(&self, _slipped: f64) -> f64 {
        0.0
    }

    /// Coulomb's law, if contacts without a bond follow it, with this [`stiffness`](Self::stiffness), and do not dilate: they are then
    /// computed by it, eight at a time.
    fn unbonded(&self) -> Option<&Coulomb> {
        None
    }

    /// Energy of the springs, J/m², for a penetration (negative in a bond under tension) and a stretch, m.
    fn energy(&self, penetration: f64, stretch: f64) -> f64 {
        let [normal, shear] = self.stiffness();
        0.5 * (normal * penetration * penetration + shear * stretch * stretch)
    }
}
