//! What the dam reports of itself in words.

use cofferdam_unit::number::plain;

use super::Dam;
use crate::contact::{ContactStatus, JointState};
use crate::{DamMotion, LimitingPart, PartKind};

impl Dam {
    /// The place of the highest frequency, as the rest of a sentence.
    pub(super) fn phrase_of(&self, part: &LimitingPart) -> String {
        let LimitingPart { place: [x, y], kind, .. } = *part;
        let what = match kind {
            PartKind::Element { block } => format!("an element of block {block}"),
            PartKind::Contact { crack } => {
                format!("a contact of the crack at {} m", plain(self.cracks[crack].line.elevation()))
            }
        };
        format!(", set by {what} at ({}, {}) m", plain(x), plain(y))
    }

    /// Tells, once, of a block in the current state that has left its crack.
    pub(super) fn tell_of_departure(&mut self) {
        if self.told_of_departure {
            return;
        }
        let time = self.state.time;
        let lost = |joints: &Vec<JointState>| {
            !joints.is_empty() && joints.iter().all(|joint| joint.status == ContactStatus::Lost)
        };
        match &self.state.motion {
            DamMotion::Nodes(motion) => {
                let Some(([x, y], on_ground)) = self.structure().meeting_place(motion) else { return };
                let what = if on_ground { "the ground" } else { "another one" };
                tracing::warn!(
                    "at t = {time} s a block meets {what} where no crack was; the point that does so lay at ({x}, {y}) m"
                );
            }
            DamMotion::Modes(motion) => {
                let Some(seam) = motion.joints.iter().position(lost) else { return };
                let elevation = self.cracks[self.structure().mesh.seams[seam].crack].line.elevation();
                tracing::warn!(
                    "at t = {time} s a block has left the crack at {elevation} m; modes know no contacts but those along cracks, so that \
                     it meets nothing any more: compute it with the fidelity \"dem\""
                );
            }
        }
        self.told_of_departure = true;
    }
}
