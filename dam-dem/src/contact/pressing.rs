use pulp::NullaryFnOnce;

use super::{ContactLaw, Crack, JointState, Parting};
use crate::damping::StiffnessDamping;
use crate::energy::Losses;

/// The contacts of all `cracks`, to be computed with the widest registers: [`Crack::add_forces`] for each, and how its sides part if
/// there is a place for it. (Not by a closure, which would be compiled for any processor.)
pub(crate) struct PressedCracks<'a, L: ContactLaw> {
    pub cracks: &'a [Crack<L>],
    pub u: &'a [[f64; 2]],
    pub v: &'a [[f64; 2]],
    pub damping: StiffnessDamping,
    pub joints: &'a mut [Vec<JointState>],
    pub forces: &'a mut [[f64; 2]],
    pub partings: &'a mut [Parting],
}

impl<L: ContactLaw> NullaryFnOnce for PressedCracks<'_, L> {
    type Output = Losses;

    #[inline(always)]
    fn call(self) -> Losses {
        let Self { cracks, u, v, damping, joints, forces, partings } = self;
        let (mut losses, mut partings) = (Losses::default(), partings.iter_mut());
        for (crack, joints) in cracks.iter().zip(joints) {
            let lost = crack.add_forces_and_part(u, v, damping, joints, forces, partings.next());
            losses.friction += lost.friction;
            losses.damping_power += lost.damping_power;
        }
        losses
    }
}
