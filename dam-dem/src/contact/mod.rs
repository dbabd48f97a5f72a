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
mod law;
mod meeting;
mod mohr_coulomb;
mod parting;
mod search;
mod trials;

use serde::{Deserialize, Serialize};

pub use coulomb::Coulomb;
pub(crate) use crack::Pressing;
pub(crate) use crack::{ContactBatches, NodalFields};
pub use crack::{ContactStatus, Crack, CrackForces, JointState, Stencil};
pub use law::{ContactLaw, Response, Touch};
pub use meeting::Meeting;
pub(crate) use meeting::Outlines;
pub use mohr_coulomb::MohrCoulomb;
pub(crate) use parting::Parting;
pub(crate) use trials::Trials;

pub use crate::real::{Mask, Real};

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
