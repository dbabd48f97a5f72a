use crate::real::{Mask, Real};

/// The contacts of a crack that slip or are open, and the rigid motion that their jumps give to what lies above.
///
/// The jump d of a contact is the part of its relative velocity v that no spring follows: `d = s t (t·v) + o n (n·v)` with
/// the shares to which it slipped, `s = o + (1 − o)` [`share_of_slip`], and was open, `o =` [`share_of_opening`], in
/// the last time step. (Shares, because otherwise a contact that
/// slips or opens a time step earlier or later would change the motion by a jump, and the iteration of the coupling
/// might not converge.) With the lengths w of the contacts and their
/// positions r relative to their centre, the rigid motion is the least-squares fit of all d:
///
/// ```text
/// t = Σ w d / Σ w,   θ̇ = Σ w (r × d) / Σ w |r|²
/// ```
///
/// It is exact for a block that slides or rocks without deformation and whose gaps are wide enough to count wholly, 0 for a closed
/// crack, and linear in the velocities. Rigid motions are (velocity of the origin (m/s), rotation (rad/s)); forces dual to them are (force (N/m),
/// moment about the origin (N)).
#[derive(Clone, Debug, Default)]
pub(crate) struct Parting {
    contacts: Vec<Jump>,
    /// `Σ w`, `Σ w x`, `Σ w |x|²` over all contacts.
    length: f64,
    first: [f64; 2],
    second: f64,
    /// Time since the evaluation before, s.
    time_step: f64,
}

/// Speed of slip (m/s) below which a contact counts as sticking, gradually: the damping of a contact that slips to and
/// fro is then a continuous function of its motion.
const STANDSTILL: f64 = 1e-3;

/// Pressure (Pa) that closes the narrowest gap which counts wholly. As long as the stresses that release a rocking block from mass damping
/// are smaller, they change with a gap no faster than those of its contact.
const CLOSING: f64 = 1e5;

/// The share o of a contact whose gap was this wide on average since the evaluation before (m; 0 while it was closed), and of this
/// stiffness (Pa/m): `gap k_n/p₀`, 1 at most.
#[inline(always)]
pub(super) fn share_of_opening<N: Real>(gap: N, normal_stiffness: f64) -> N {
    let (share, one) = (gap * normal_stiffness / CLOSING, gap.constant(1.0));
    one.less_than(share).select(one, share)
}

/// The share of a contact that slipped by `slip` and whose spring stretched by `stretched` since the evaluation
/// before, which is a `time_step` (s) ago, m: `slip²/(slip² + stretched² + (v₀ Δt)²)`.
#[inline(always)]
pub(super) fn share_of_slip<N: Real>(slip: N, stretched: N, time_step: f64) -> N {
    let (zero, still) = (slip.constant(0.0), STANDSTILL * time_step);
    let whole = slip * slip + stretched * stretched + still * still;
    zero.less_than(whole).select(slip * slip / whole, zero)
}

/// Two directions, each with the share of a velocity along it that counts.
type Shares = [([f64; 2], f64); 2];

/// A contact that slips or is open.
#[derive(Clone, Copy, Debug)]
struct Jump {
    stencil: Stencil,
    place: [f64; 2],
    /// d, m/s.
    rate: [f64; 2],
    shares: Shares,
}

/// A contact: how its relative displacement follows from those of four nodes, and its length, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stencil {
    pub nodes: [usize; 4],
    pub shares: [f64; 4],
    pub length: f64,
}

impl Parting {
    /// For evaluations that are a `time_step` (s) apart.
    pub fn every(time_step: f64) -> Self {
        Self { time_step, ..Self::default() }
    }

    /// Time since the evaluation before, s.
    pub(super) fn time_step(&self) -> f64 {
        self.time_step
    }

    /// Forgets all contacts.
    pub fn clear(&mut self) {
        self.contacts.clear();
        (self.length, self.first, self.second) = (0.0, [0.0; 2], 0.0);
    }

    /// Adds a contact at `place` (m) with the `relative` velocity (m/s), of which these `shares` jump.
    pub(super) fn add(&mut self, stencil: Stencil, place: [f64; 2], relative: [f64; 2], shares: Shares) {
        let length = stencil.length;
        self.length += length;
        (0..2).for_each(|d| self.first[d] += length * place[d]);
        self.second += length * (place[0] * place[0] + place[1] * place[1]);
        if shares.iter().any(|(_, share)| *share > 0.0) {
            self.contacts.push(Jump { stencil, place, rate: projected(relative, shares), shares });
        }
    }

    /// Whether no contact slips or is open.
    pub fn is_closed(&self) -> bool {
        self.contacts.is_empty()
    }

    /// Centre of the contacts (m), and `Σ w |r|²` about it (m³).
    fn moments(&self) -> ([f64; 2], f64) {
        let centre = self.first.map(|first| first / self.length);
        (centre, self.second - self.length * (centre[0] * centre[0] + centre[1] * centre[1]))
    }

    /// The rigid motion of the jumps.
    pub fn rate(&self) -> [f64; 3] {
        if self.is_closed() {
            return [0.0; 3];
        }
        let ([x, y], inertia) = self.moments();
        let (mut translation, mut turning) = ([0.0; 2], 0.0);
        for Jump { stencil, place, rate, .. } in &self.contacts {
            (0..2).for_each(|d| translation[d] += stencil.length * rate[d] / self.length);
            turning += stencil.length * ((place[0] - x) * rate[1] - (place[1] - y) * rate[0]);
        }
        let rotation = if inertia > 0.0 { turning / inertia } else { 0.0 };
        [translation[0] + rotation * y, translation[1] - rotation * x, rotation]
    }

    /// Adds the nodal forces (N/m) whose power is that of `force` on the [`rate`](Self::rate).
    pub fn add_dual(&self, force: [f64; 3], forces: &mut [[f64; 2]]) {
        let ([x, y], inertia) = self.moments();
        let [fx, fy, moment] = force;
        let moment = moment - (x * fy - y * fx);
        let turning = if inertia > 0.0 { moment / inertia } else { 0.0 };
        for Jump { stencil, place, shares, .. } in &self.contacts {
            let stress =
                [fx / self.length - turning * (place[1] - y), fy / self.length + turning * (place[0] - x)];
            let force = projected(stress, *shares).map(|stress| stencil.length * stress);
            for (&node, share) in stencil.nodes.iter().zip(stencil.shares) {
                (0..2).for_each(|d| forces[node][d] += share * force[d]);
            }
        }
    }
}

/// The `shares` of a vector.
fn projected(vector: [f64; 2], shares: Shares) -> [f64; 2] {
    let [first, second] = shares.map(|([x, y], share)| {
        let along = share * (vector[0] * x + vector[1] * y);
        [along * x, along * y]
    });
    [first[0] + second[0], first[1] + second[1]]
}

#[cfg(test)]
mod tests {
    use super::share_of_opening;

    #[test]
    fn a_gap_counts_gradually_and_then_wholly() {
        // 0.1 MPa close 1 µm.
        for (gap, share) in [(0.0, 0.0), (2.5e-7, 0.25), (1e-6, 1.0), (0.1, 1.0)] {
            assert!((share_of_opening(gap, 1e11) - share).abs() < 1e-15, "{gap} m");
        }
    }
}
