//! Equilibrium of one joint by the gravity method: linear effective stress, no tension beyond the tensile
//! strength.

use crate::uplift::{JointWater, Uplift, UpliftRule, force, moment, relieved};

mod root;
#[cfg(test)]
mod tests;

/// Loads on the part above the joint without uplift, per metre of dam.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointLoad {
    /// Force V normal to the joint, N/m, positive if it compresses the joint.
    pub normal: f64,
    /// Force H along the joint, N/m, positive downstream.
    pub shear: f64,
    /// Moment M about the downstream end of the joint, N, positive if it presses the upstream end down: V
    /// times the distance of the resultant from the downstream end.
    pub moment: f64,
}

/// Strength of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Strength {
    /// Coefficient of friction μ.
    pub friction: f64,
    /// Cohesion c, Pa, where the joint is bonded and in compression.
    pub cohesion: f64,
    /// Tensile strength f_t, Pa, where the joint is bonded.
    pub tensile_strength: f64,
}

/// How the uplift depends on the opening. Arrays of lengths have that from the upstream end first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    /// A bonded joint under static loads: full water pressure where it opens.
    Static,
    /// During an earthquake.
    Seismic {
        /// Pressure where the joint is open; where it is closed, the pressure is as before.
        rule: UpliftRule,
        /// Lengths of the cracks before the earthquake, m.
        before: [f64; 2],
    },
    /// Static loads on a joint with cracks of these lengths (m), open or closed: full water pressure in all
    /// of them.
    Given([f64; 2]),
}

impl Mode {
    fn cracks(self) -> [f64; 2] {
        match self {
            Self::Static => [0.0; 2],
            Self::Seismic { before: cracks, .. } | Self::Given(cracks) => cracks,
        }
    }

    fn rule(self) -> UpliftRule {
        match self {
            Self::Seismic { rule, .. } => rule,
            Self::Static | Self::Given(_) => UpliftRule::FullWhereOpen,
        }
    }
}

/// An end of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The heel, or the upstream face.
    Upstream,
    /// The toe, or the downstream face.
    Downstream,
}

/// A joint with its loads.
#[derive(Clone, Copy, Debug)]
pub struct Joint<'a> {
    /// The joint and the water at its ends.
    pub water: &'a JointWater,
    /// Drains, profile and rule; the rule of [`Mode::Seismic`] takes precedence.
    pub uplift: &'a Uplift,
    /// Factor on the whole uplift, as [`Uplift::factor_at`] gives it; 1 without one.
    pub uplift_factor: f64,
    /// Loads without uplift.
    pub load: JointLoad,
    /// Strength of the joint.
    pub strength: Strength,
}

/// State of equilibrium of a joint. Arrays have the upstream value first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointState {
    /// Lengths without bond from the two ends, m: the given cracks, or where longer, the opening.
    pub cracks: [f64; 2],
    /// Lengths without contact from the two ends, m; at most one of them is positive.
    pub open: [f64; 2],
    /// Length in compression, m.
    pub compressed: f64,
    /// Length in compression and bonded, m, on which cohesion acts.
    pub bonded: f64,
    /// Uplift U, N/m.
    pub uplift: f64,
    /// Effective normal force N' = V − U, N/m.
    pub normal: f64,
    /// Distance of the resultant from the downstream end, m; `None` without compression.
    pub resultant: Option<f64>,
    /// Effective stress at the two ends of the contact, Pa, positive in compression: at the heel or the tip
    /// of the opening, and at the toe or the tip. `None` if the joint [`overturns`](Self::overturns).
    pub stresses: Option<[f64; 2]>,
    /// Factor of safety against sliding with the strength of the analysis; `None` if no force acts along the
    /// joint.
    pub sliding_factor: Option<f64>,
    length: f64,
    shear: f64,
}

impl JointState {
    /// Distance of the resultant from the downstream end as a share of the length of the joint.
    pub fn share(&self) -> Option<f64> {
        self.resultant.map(|distance| distance / self.length)
    }

    /// Zone of the joint in which the resultant lies; outside if there is no compression.
    pub fn zone(&self) -> ResultantZone {
        self.share().map_or(ResultantZone::Outside, resultant_zone)
    }

    /// The end from which the joint is open, if it is.
    pub fn opens_from(&self) -> Option<End> {
        match self.open {
            [upstream, _] if upstream > 0.0 => Some(End::Upstream),
            [_, downstream] if downstream > 0.0 => Some(End::Downstream),
            _ => None,
        }
    }

    /// Whether no part of the joint is bonded any more.
    pub fn is_cracked_through(&self) -> bool {
        self.cracks[0] + self.cracks[1] >= self.length
    }

    /// Whether no contact can balance the loads: the resultant lies outside the joint or the effective normal
    /// force is not compressive. The joint then counts as open, with the uplift of that state.
    pub fn overturns(&self) -> bool {
        self.stresses.is_none()
    }

    /// Factor of safety against sliding in this state with another friction and cohesion, such as the
    /// residual ones: (μ N' + c A_c)/|H|, with the bonded length in compression A_c. `None` if no force acts
    /// along the joint.
    pub fn sliding_factor_with(&self, friction: f64, cohesion: f64) -> Option<f64> {
        let resistance = friction * self.normal.max(0.0) + cohesion * self.bonded;
        (self.shear != 0.0).then(|| resistance / self.shear.abs())
    }
}

impl Joint<'_> {
    /// The state with the shortest opening whose effective stress, linear over the contact, has no tension at
    /// the tip, or none above the tensile strength where the joint is bonded there.
    ///
    /// ```text
    /// σ_tip = (6 M'/c − 2 N')/c,  N' = V − U,  M' = M − M_U about the other end,  c = L − opening
    /// ```
    ///
    /// The opening is found as a root and not by the fixed-point iteration of the guidelines, which cycles
    /// where the uplift falls fast as the joint opens ([`UpliftRule::ZeroWhereOpen`]).
    ///
    /// **Source**: USACE EM 1110-2-2200, 1995, chapters 3 and 4; FERC Engineering Guidelines, chapter III.
    pub fn state(&self, mode: Mode) -> JointState {
        let opening = self.opening(mode);
        let length = self.water.length;
        let open = opening.unwrap_or_else(|end| beside(end, length));
        let [normal, moment] = self.effective(mode, open);
        let cracks = [0, 1].map(|end| mode.cracks()[end].max(open[end]).min(length));
        let mut state = JointState {
            cracks,
            open,
            compressed: 0.0,
            bonded: 0.0,
            uplift: self.load.normal - normal,
            normal,
            resultant: (normal > 0.0).then(|| moment / normal),
            stresses: None,
            sliding_factor: None,
            length,
            shear: self.load.shear,
        };
        if opening.is_ok() {
            let contact = length - open[0] - open[1];
            let arm = moment - normal * open[1];
            let upstream = (6.0 * arm / contact - 2.0 * normal) / contact;
            let downstream = 2.0 * normal / contact - upstream;
            let tensile_share = |at: f64, other: f64| if at < 0.0 { -at / (other - at) } else { 0.0 };
            let start = open[0] + contact * tensile_share(upstream, downstream);
            let end = length - open[1] - contact * tensile_share(downstream, upstream);
            state.stresses = Some([upstream, downstream]);
            state.compressed = end - start;
            state.bonded = (end.min(length - cracks[1]) - start.max(cracks[0])).max(0.0);
        }
        state.sliding_factor = state.sliding_factor_with(self.strength.friction, self.strength.cohesion);
        state
    }

    /// Uplift pressure along the joint with the lengths `open` without contact, in the form of
    /// [`JointWater::nodes`].
    pub fn uplift_line(&self, mode: Mode, open: [f64; 2]) -> Vec<[f64; 2]> {
        let cracks = mode.cracks();
        let opened = [0, 1].map(|end| cracks[end].max(open[end]));
        let mut line = match mode.rule() {
            UpliftRule::Unchanged => self.water.nodes(self.uplift, cracks),
            UpliftRule::ZeroWhereOpen => {
                relieved(&self.water.nodes(self.uplift, cracks), self.water.length, open)
            }
            UpliftRule::FullWhereOpen => self.water.nodes(self.uplift, opened),
        };
        line.iter_mut().for_each(|point| point[1] *= self.uplift_factor);
        line
    }

    /// N' (N/m), and its moment M' about the downstream end (N).
    fn effective(&self, mode: Mode, open: [f64; 2]) -> [f64; 2] {
        let line = self.uplift_line(mode, open);
        [self.load.normal - force(&line), self.load.moment - moment(&line, self.water.length)]
    }

    /// Shortest lengths without contact, or the end from which the joint opens altogether.
    fn opening(&self, mode: Mode) -> Result<[f64; 2], End> {
        let [normal, moment] = self.effective(mode, [0.0; 2]);
        let about_upstream = normal * self.water.length - moment;
        let end = if about_upstream < moment { End::Downstream } else { End::Upstream };
        let breakpoints = self.breakpoints(mode, end);
        let reserve = |open: f64| self.reserve(mode, beside(end, open));
        let open = beside(end, root::smallest(reserve, &breakpoints).ok_or(end)?);
        if self.effective(mode, open)[0] > 0.0 { Ok(open) } else { Err(end) }
    }

    /// Reserve against tension above the strength with the lengths `open` without contact, N/m: the smaller
    /// of (σ + f_t) c²/L at the two ends of the contact c.
    fn reserve(&self, mode: Mode, open: [f64; 2]) -> f64 {
        let length = self.water.length;
        let [normal, moment] = self.effective(mode, open);
        let contact = length - open[0] - open[1];
        let arm = moment - normal * open[1];
        let [upstream, downstream] = mode.cracks();
        let at_end = |stress: f64, x: f64| {
            let is_bonded = upstream + downstream < length && (upstream..=length - downstream).contains(&x);
            let tensile_strength = if is_bonded { self.strength.tensile_strength } else { 0.0 };
            (stress + tensile_strength * contact * contact) / length
        };
        let upstream_reserve = at_end(6.0 * arm - 2.0 * normal * contact, open[0]);
        upstream_reserve.min(at_end(4.0 * normal * contact - 6.0 * arm, length - open[1]))
    }

    /// Openings from an `end` between which the reserve is smooth, from 0 to the length of the joint.
    fn breakpoints(&self, mode: Mode, end: End) -> Vec<f64> {
        let length = self.water.length;
        let nodes = self.water.nodes(self.uplift, mode.cracks());
        let distances = nodes.iter().map(|point| point[0]);
        match end {
            End::Upstream => distances.collect(),
            End::Downstream => distances.rev().map(|x| length - x).collect(),
        }
    }
}

/// A length at one end, none at the other.
fn beside(end: End, length: f64) -> [f64; 2] {
    match end {
        End::Upstream => [length, 0.0],
        End::Downstream => [0.0, length],
    }
}

/// Where in the joint the resultant lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ResultantZone {
    /// In the middle third: the whole joint is in compression.
    MiddleThird,
    /// In the middle half, outside the middle third.
    MiddleHalf,
    /// Within the joint, outside the middle half.
    Inside,
    /// Outside the joint.
    Outside,
}

impl ResultantZone {
    /// All zones, from the middle outwards.
    pub const ALL: [Self; 4] = [Self::MiddleThird, Self::MiddleHalf, Self::Inside, Self::Outside];

    /// The word in results.
    pub fn word(self) -> &'static str {
        match self {
            Self::MiddleThird => "middle-third",
            Self::MiddleHalf => "middle-half",
            Self::Inside => "inside",
            Self::Outside => "outside",
        }
    }

    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::MiddleThird => "in the middle third",
            Self::MiddleHalf => "in the middle half",
            Self::Inside => "inside the joint",
            Self::Outside => "outside the joint",
        }
    }
}

/// The zone of a distance from an end as a `share` of the length of the joint; boundaries belong to the inner
/// zone.
pub fn resultant_zone(share: f64) -> ResultantZone {
    let off_centre = (share - 0.5).abs();
    // shares computed from the state that just touches a boundary differ from it by rounding
    let within = |half: f64| off_centre <= half + 1e-12;
    match () {
        () if within(1.0 / 6.0) => ResultantZone::MiddleThird,
        () if within(0.25) => ResultantZone::MiddleHalf,
        () if within(0.5) => ResultantZone::Inside,
        () => ResultantZone::Outside,
    }
}
