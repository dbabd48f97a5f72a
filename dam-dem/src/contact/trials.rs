use super::JointState;

/// What became of the bonds in the attempts at a communication step, and whether it was calm, so that each gets a definite
/// answer.
///
/// An iteration that repeats a step with other pressures may break a bond with one pressure and, with the pressure that follows
/// from this, not break it: then the step has no solution, and the iteration does not end. A bond that breaks in a time step,
/// then later or not at all, and then again in this time step and no later, therefore breaks there in all further attempts.
/// One that breaks once, as with a first guess or a probe, is left to the next attempts.
/// A step that is not calm, then calm, and then again not, is not for the same reason.
#[derive(Clone, Debug)]
pub(crate) struct Trials {
    /// Time and length of the communication step, s.
    step: [f64; 2],
    bonds: Vec<Trial>,
    /// That a contact does not stick.
    unrest: Trial,
}

#[derive(Clone, Debug, Default)]
struct Trial {
    /// Time step in which it broke in the last attempt; none if it held.
    last: Option<u32>,
    /// Time steps in which it broke earlier than in the attempt before.
    earlier: Vec<u32>,
    /// It breaks in this time step, if not earlier.
    settled: Option<u32>,
}

impl Trials {
    /// Before the first attempt at the communication step of this `length` (s) from `time` (s) on.
    pub fn new(time: f64, length: f64) -> Self {
        Self { step: [time, length], bonds: Vec::new(), unrest: Trial::default() }
    }

    /// Whether they are about the communication step of this `length` (s) from `time` (s) on.
    pub fn are_of(&self, time: f64, length: f64) -> bool {
        self.step == [time, length]
    }

    /// Start of the step, s.
    pub fn time(&self) -> f64 {
        self.step[0]
    }

    /// Whether no bond broke in them, and all were calm.
    pub fn are_uneventful(&self) -> bool {
        self.bonds.is_empty() && self.unrest.earlier.is_empty()
    }

    /// Whether the step may be calm.
    pub fn may_be_calm(&self) -> bool {
        self.unrest.settled.is_none()
    }

    /// Sets the fuses of the bonds of `joints`, which are at the start of the step.
    pub fn set_fuses(&self, joints: &mut [Vec<JointState>]) {
        for (index, joint) in joints.iter_mut().flatten().enumerate().filter(|(_, joint)| joint.bonded) {
            joint.fuse = self.bonds.get(index).and_then(|trial| trial.settled).or(Some(u32::MAX));
        }
    }

    /// Learns from an attempt that led from the joints `before` to those `after`, `calm` or not, and takes out their fuses.
    pub fn observe(&mut self, before: &[Vec<JointState>], after: &mut [Vec<JointState>], calm: bool) {
        self.unrest.observe((!calm).then_some(0));
        let bonded = before.iter().flatten().map(|joint| joint.bonded);
        if self.bonds.is_empty() && !bonded.clone().eq(after.iter().flatten().map(|joint| joint.bonded)) {
            self.bonds = vec![Trial::default(); bonded.clone().count()];
        }
        for (index, (joint, _)) in after.iter_mut().flatten().zip(bonded).enumerate().filter(|(_, (_, b))| *b)
        {
            if let Some(trial) = self.bonds.get_mut(index) {
                trial.observe((!joint.bonded).then_some(joint.lasted));
            }
            (joint.lasted, joint.fuse) = (0, None);
        }
    }
}

impl Trial {
    fn observe(&mut self, broke: Option<u32>) {
        if let Some(now) = broke.filter(|now| self.last.is_none_or(|last| *now < last)) {
            if self.earlier.contains(&now) {
                self.settled = Some(now);
            }
            self.earlier.push(now);
        }
        self.last = broke;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settled(attempts: &[Option<u32>]) -> Option<u32> {
        let mut trial = Trial::default();
        attempts.iter().for_each(|&broke| trial.observe(broke));
        trial.settled
    }

    #[test]
    fn only_a_bond_that_goes_to_and_fro_is_settled() {
        assert_eq!(settled(&[None, None]), None);
        // a first guess, or a probe, that breaks it
        assert_eq!(settled(&[Some(3), None, None]), None);
        // it converges, to a break or to none
        assert_eq!(settled(&[None, Some(5), Some(4), Some(4), Some(4)]), None);
        assert_eq!(settled(&[Some(3), Some(4), Some(5), Some(5)]), None);
        assert_eq!(settled(&[Some(5), Some(3), Some(5), Some(4), Some(5), Some(5)]), None);
        // it does not
        assert_eq!(settled(&[Some(3), None, Some(3)]), Some(3));
        assert_eq!(settled(&[None, Some(4), Some(5), Some(4)]), Some(4));
        assert_eq!(settled(&[Some(2), Some(6), Some(6), None, Some(6), None, Some(6)]), Some(6));
        // settled, it still breaks earlier
        assert_eq!(settled(&[Some(3), None, Some(3), Some(2), Some(3), Some(2)]), Some(2));
    }
}
