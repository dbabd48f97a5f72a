//! The state of rest before the earthquake.

use crate::integrator::Relaxed;
use crate::loads::Opened;
use crate::state::DamMotion;
use crate::{Dam, DamError, LimitEquilibrium};

/// Growth of the open length of a joint, as a share of its length, at which uplift and opening agree.
const AGREEMENT: f64 = 1e-7;
/// Largest number of states of rest that are computed until they agree.
const MOST_ROUNDS: usize = 200;

/// A state of rest.
pub(super) struct Rest {
    pub motion: DamMotion,
    /// How far each joint with water is open, m.
    pub opened: Vec<Opened>,
}

/// The water in a crack in the state of rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointAtRest {
    /// The crack, from the base up.
    pub crack: usize,
    /// Its length, m.
    pub length: f64,
    /// How far it is open from its upstream and from its downstream end on, m.
    pub opened: [f64; 2],
    /// Force of the water on the block above, N/m.
    pub uplift: f64,
}

impl Dam {
    /// The water in each crack that has uplift, in the state of rest; closed before initialisation.
    pub fn joints_at_rest(&self) -> Vec<JointAtRest> {
        let Some(joints) = &self.model.body().joints else { return Vec::new() };
        let opened = &self.state.opened_at_rest;
        let pressures = joints.at_rest(self.state.time, opened);
        let of_joint = |((crack, length), &opened): ((usize, f64), &Opened)| JointAtRest {
            crack,
            length,
            opened,
            uplift: joints.force(crack, &pressures),
        };
        joints.cracks().zip(opened).map(of_joint).collect()
    }

    /// The state of rest under the loads at a `time` (s), without the earthquake. The pressure in a joint and the length on which it is open follow
    /// from each other: both are found in turn, from closed joints on. What has opened once keeps the reservoir's pressure, also if
    /// the sides touch again under it, so that the lengths only grow, up to the smallest that no longer does.
    ///
    /// **Errors**: [`DamError::CannotStand`], [`DamError::UpliftOpens`], [`DamError::StaticNotConverged`],
    /// [`DamError::Singular`].
    pub(super) fn find_rest(&self, time: f64) -> Result<Rest, DamError> {
        let body = self.model.body();
        let mut acting = body.at_rest(time, self.state.hydrostatic_pressure.clone());
        if self.parameters.fidelity.is_cracked() {
            let cracks = LimitEquilibrium::of(self.structure(), &self.cracks, &body.forces(&acting));
            cracks.iter().try_for_each(LimitEquilibrium::check)?;
        }
        let mut opened = self.state.opened_at_rest.clone();
        for _ in 0..MOST_ROUNDS {
            let mut motion = self.state.motion.clone();
            let (method, rest) = match self.model.with(&mut motion)?.relax(&acting) {
                Err(DamError::StaticNotConverged { .. })
                    if opened.iter().flatten().any(|length| *length > 0.0) =>
                {
                    return Err(self.uplift_opens(&opened));
                }
                found => found?,
            };
            let Some(joints) = &body.joints else {
                tell(method, rest);
                return Ok(Rest { motion, opened });
            };
            let next = joints.opened(motion.joints());
            let growth = |((_, length), [before, after]): ((usize, f64), [&Opened; 2])| {
                (after[0] - before[0]).max(after[1] - before[1]) / length
            };
            let pairs = opened.iter().zip(&next).map(|(before, after)| [before, after]);
            let agree = joints.cracks().zip(pairs).map(growth).all(|growth| growth <= AGREEMENT);
            for (opened, next) in opened.iter_mut().zip(next) {
                *opened = [0, 1].map(|end| opened[end].max(next[end]));
            }
            if agree {
                tell(method, rest);
                return Ok(Rest { motion, opened });
            }
            acting.uplift = joints.at_rest(time, &opened);
        }
        Err(self.uplift_opens(&opened))
    }

    /// The error for the joint that is open over the largest share of its length.
    fn uplift_opens(&self, opened: &[Opened]) -> DamError {
        let joints = self.model.body().joints.iter().flat_map(|joints| joints.cracks());
        let shares = joints
            .zip(opened)
            .map(|((crack, length), [upstream, downstream])| (crack, (upstream + downstream) / length));
        let (crack, share) = shares.max_by(|(_, a), (_, b)| a.total_cmp(b)).unwrap_or_default();
        DamError::UpliftOpens { elevation: self.cracks[crack].line.elevation(), share }
    }

    /// Tells of the water in the joints of the state of rest.
    pub(super) fn tell_of_uplift(&self) {
        for JointAtRest { crack, length, opened: [upstream, _], uplift } in self.joints_at_rest() {
            let parameters = &self.cracks[crack];
            let rule = parameters.uplift.as_ref().map_or("", |uplift| uplift.rule.label());
            tracing::info!(
                "crack at {:.2} m: uplift of {uplift:.3e} N/m at rest, open over {upstream:.2} of {length:.2} m; during shaking: {rule}",
                parameters.line.elevation(),
            );
        }
    }
}

fn tell(method: &str, rest: Relaxed) {
    tracing::info!(
        "state of rest by {method}: {} iterations, residual over loads {:.1e}",
        rest.iterations,
        rest.residual
    );
}
