//! Contact along cracks: nodes of either side against the segments of the other.
//!
//! Every node of the upper side meets the lower side's polyline with half of its tributary
//! length as weight, and every node of the lower side meets the upper one with the other half, so
//! neither side is preferred and a closed crack in its position of rest closes by exactly p/k_n.
//!
//! **Known effects of nodal contacts.** A node that slides past the end of the other side loses its
//! contact: at first slip (more than [`OVERHANG`] of a segment) the corner that leaves drops its
//! half weight, a quarter of a segment's length, and neighbours take over its force. The moment
//! that a pair of forces leaves is (force × penetration), because action and reaction act on the two
//! surfaces and not in one point.

mod coulomb;
mod crack;
mod search;

pub use coulomb::Coulomb;
pub use crack::{ContactStatus, Crack, JointState, Stencil};

/// A node keeps its contact this far beyond the end of the other side, as a share of the end segment's
/// length: elastic shear must not open a corner.
pub const OVERHANG: f64 = 1e-3;

/// What a contact law sees of one contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Overlap of the surfaces along the normal, m; negative where there is a gap.
    pub penetration: f64,
    /// Its rate, m/s, as the dashpot feels it: with the memory of stiffness damping.
    pub penetration_rate: f64,
    /// Stretch of the shear spring if nothing slips now, m.
    pub stretch: f64,
    /// Tangential velocity of the node against the other side, m/s, felt in the same way.
    pub slip_rate: f64,
    /// Stiffness damping β of the dashpots `β k_n` and `β k_s`, s.
    pub damping: f64,
}

/// What a contact law answers, per unit of length (and metre of dam).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// Normal stress, Pa, compression positive.
    pub normal: f64,
    /// Shear stress, Pa; it acts on the node against the slip.
    pub shear: f64,
    /// Stretch of the shear spring after slipping, m.
    pub stretch: f64,
    /// The friction limit was reached.
    pub slipping: bool,
    /// Normal and shear stresses of the dashpots, contained in those above, Pa.
    pub dashpots: [f64; 2],
}

/// The door for other contact laws.
///
/// **Call order**: [`respond`](Self::respond) once per contact and time step. A law has no memory of
/// its own: the stretch of the shear spring is kept for it. **Guarantees expected**: no tension
/// (`normal ≥ 0`, and nothing at all where the penetration is not positive), a stretch that only
/// shrinks by slipping, dashpots that never feed energy in against the rates in [`Touch`]. The critical
/// time step knows the [`stiffness`](Self::stiffness) and β; a law with dampers of its own must be run with
/// shorter ones.
///
/// `examples/lubricated_joint.rs` walks through a law of one's own.
pub trait ContactLaw: Clone + Send + Sync {
    /// Stresses of one contact.
    fn respond(&self, touch: &Touch) -> Response;

    /// Normal and shear stiffness of a closed, sticking contact, Pa/m.
    fn stiffness(&self) -> [f64; 2];

    /// Energy in the springs, J/m², at a penetration and a stretch (m).
    fn energy(&self, penetration: f64, stretch: f64) -> f64 {
        let [normal, shear] = self.stiffness();
        let closure = penetration.max(0.0);
        0.5 * (normal * closure * closure + shear * stretch * stretch)
    }
}
