use nalgebra::{Cholesky, DVector};
use pulp::{Simd, WithSimd};

use super::motion::ModalMotion;
use super::product::{LANES, dot};
use super::sides::Pressing;
use super::superposition::Superposition;
use crate::DamError;
use crate::contact::{ContactBatches, JointState};
use crate::damping::StiffnessDamping;
use crate::energy::Work;
use crate::integrator::{CentralDifference, Relaxed};

/// Residual over the loads at which the state of rest has converged, in the energy norm.
const TOLERANCE: f64 = 1e-9;
/// Largest number of iterations to the state of rest.
const MAX_ITERATIONS: usize = 10_000;
/// Residual over the loads above which no state of rest exists: a block slides away or falls.
const RUNAWAY: f64 = 50.0;

/// Modal forces that vary linearly over a communication step.
pub(crate) struct ModalLoadPath {
    /// Forces at its start.
    pub start: Vec<f64>,
    /// Forces at its end.
    pub end: Vec<f64>,
}

impl Superposition {
    /// Static equilibrium under `loads` by a modified Newton iteration with the stiffness of all contacts closed and
    /// sticking. Contacts that open or slip only make the dam softer, so that no step overshoots.
    ///
    /// **Errors**: [`DamError::StaticNotConverged`].
    pub(crate) fn relax(&self, motion: &mut ModalMotion, loads: &[f64]) -> Result<Relaxed, DamError> {
        let factors =
            Cholesky::new(self.sides.closed_stiffness(&self.stiffness)).ok_or(DamError::Singular)?;
        let norm = |forces: &DVector<f64>| forces.dot(&factors.solve(forces)).abs().sqrt();
        let scale = norm(&DVector::from_column_slice(loads));
        let mut pressing = Pressing::at(&self.sides, &motion.coordinates);
        let (mut iterations, mut residual) = (0, 0.0);
        while iterations < MAX_ITERATIONS && residual <= RUNAWAY {
            pressing.press_once(&self.sides, motion, StiffnessDamping::default());
            let forces = DVector::from_fn(loads.len(), |i, _| {
                loads[i] + motion.contact_forces[i] - self.stiffness[i] * motion.coordinates[i]
            });
            residual = if scale == 0.0 { 0.0 } else { norm(&forces) / scale };
            if residual <= TOLERANCE {
                return Ok(Relaxed { iterations, residual });
            }
            let change = factors.solve(&forces);
            motion.coordinates.iter_mut().zip(&change).for_each(|(q, change)| *q += change);
            pressing.follow(&self.sides, &motion.coordinates, None);
            iterations += 1;
        }
        Err(DamError::StaticNotConverged { iterations, residual, tolerance: TOLERANCE })
    }

    /// Updates the contacts of `motion`.
    ///
    /// **Call order**: once, at the start, because each call takes one step of the dashpots' memory.
    pub(crate) fn press_contacts(&self, motion: &mut ModalMotion) {
        Pressing::at(&self.sides, &motion.coordinates).press_once(&self.sides, motion, self.dashpots);
    }

    /// Central differences, with modal damping at the middle of the step:
    ///
    /// ```text
    /// (1 + c Δt/2) q̇ⁿ⁺½ = (1 − c Δt/2) q̇ⁿ⁻½ + Δt (fⁿ + f_contact(uⁿ, u̇ⁿ⁻½) − ω² qⁿ)
    /// qⁿ⁺¹ = qⁿ + Δt q̇ⁿ⁺½
    /// ```
    ///
    /// The first and the last kick are half a step long, so that coordinates and rates belong to the same
    /// instant. Mass damping between modes, and what releases blocks from it, lag by half a step, as the dashpots of
    /// contacts do. Returns the impulse (N s/m) from which blocks were released.
    pub(crate) fn advance(
        &self,
        steps: CentralDifference,
        motion: &mut ModalMotion,
        loads: &ModalLoadPath,
        work: &mut Work,
    ) -> [f64; 2] {
        let (model, dashpots) = (self, self.dashpots);
        let advance = Advance { model, steps, dashpots, calm: false, motion, loads, work };
        pulp::Arch::new().dispatch(advance).expect("nothing ends it early")
    }

    /// The same with the few long `steps` of a calm communication step; none, and `motion` and `work` unchanged, if a contact
    /// does not stick in it, or if there are no contacts.
    pub(crate) fn advance_calmly(
        &self,
        steps: CentralDifference,
        motion: &mut ModalMotion,
        loads: &ModalLoadPath,
        work: &mut Work,
    ) -> Option<[f64; 2]> {
        let dashpots = self.calm.filter(|_| motion.joints.iter().flatten().all(JointState::is_calm))?;
        let (mut attempt, mut done) = (motion.clone(), *work);
        let impulse = pulp::Arch::new().dispatch(Advance {
            model: self,
            steps,
            dashpots,
            calm: true,
            motion: &mut attempt,
            loads,
            work: &mut done,
        })?;
        (*motion, *work) = (attempt, done);
        Some(impulse)
    }
}

struct Advance<'a> {
    model: &'a Superposition,
    steps: CentralDifference,
    dashpots: StiffnessDamping,
    /// Whether it ends once a contact does not stick.
    calm: bool,
    motion: &'a mut ModalMotion,
    loads: &'a ModalLoadPath,
    work: &'a mut Work,
}

impl WithSimd for Advance<'_> {
    type Output = Option<[f64; 2]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<[f64; 2]> {
        let Self { model, steps, dashpots, calm, motion, loads, work } = self;
        let CentralDifference { time_step: dt, steps } = steps;
        let (start, end) = (&loads.start[..], &loads.end[..]);
        let mut pressing = Pressing::at(&model.sides, &motion.coordinates);
        let mut between = vec![0.0; model.mode_count()];
        let mut release = model.release.start(dt);
        let (mut released, mut impulse) = (vec![0.0; model.sides.modes_width()], [0.0; 2]);
        let mut contacts = ContactBatches::new(&model.sides.cracks, &motion.joints);
        model.damping_between.combine(&motion.rates, &mut between);
        let kick = Kick { before: 0.0, after: dt / 2.0, force: dt / 2.0 };
        work.damping += kick.advance(model, motion, start, end, 0.0, &between);
        for step in 0..steps {
            let share = |n: f64| n / steps as f64;
            let middle = share(step as f64 + 0.5);
            let input = (1.0 - middle) * dot(start, &motion.rates) + middle * dot(end, &motion.rates);
            for (q, rate) in motion.coordinates.iter_mut().zip(&motion.rates) {
                *q += dt * rate;
            }
            model.damping_between.combine(&motion.rates, &mut between);
            pressing.follow(&model.sides, &motion.coordinates, Some(dt));
            // no crack parts in a calm step
            let partings: &mut [_] = if calm { &mut [] } else { &mut release.partings };
            let losses = pressing.press(simd, &model.sides, &mut contacts, motion, dashpots, partings);
            if calm && !contacts.are_calm(&motion.joints) {
                return None;
            }
            let spared =
                pressing.release(&model.sides, &model.release, &motion.rates, &mut release, &mut released);
            if let Some(sum) = spared {
                (0..2).for_each(|d| impulse[d] += dt * sum[d]);
                let forces = motion.contact_forces.iter_mut().zip(&released);
                forces.for_each(|(force, released)| *force += released);
            }
            let power = |rates: &[f64]| dot(&released[..rates.len()], rates);
            let before = spared.map(|_| power(&motion.rates));
            let kick = match step + 1 < steps {
                true => Kick { before: dt / 2.0, after: dt / 2.0, force: dt },
                false => Kick { before: dt / 2.0, after: 0.0, force: dt / 2.0 },
            };
            work.damping += kick.advance(model, motion, start, end, share(step as f64 + 1.0), &between);
            if let Some(before) = before {
                let after = power(&motion.rates);
                // after the last, half kick the rates are those of the middle
                let mean = if step + 1 < steps { (before + after) / 2.0 } else { after };
                work.damping -= dt * mean;
            }
            work.input += dt * input;
            work.input -= losses.relief;
            work.friction += losses.friction;
            work.damping += dt * losses.damping_power;
        }
        contacts.write(&mut motion.joints);
        Some(impulse)
    }
}

/// `(1 + c after) q̇ ← (1 − c before) q̇ + force (f − f_between)`.
struct Kick {
    before: f64,
    after: f64,
    force: f64,
}

impl Kick {
    /// Returns the work of damping: its impulse times the mean of the rates before and after.
    #[inline(always)]
    fn advance(
        &self,
        model: &Superposition,
        motion: &mut ModalMotion,
        start: &[f64],
        end: &[f64],
        share: f64,
        between: &[f64],
    ) -> f64 {
        let lists = Modes {
            coordinates: &motion.coordinates,
            contact_forces: &motion.contact_forces,
            stiffness: &model.stiffness,
            damping: &model.damping,
            start,
            end,
            between,
        };
        let (eights, rest) = motion.rates.as_chunks_mut::<LANES>();
        let mut work = [0.0; LANES];
        for (number, rates) in eights.iter_mut().enumerate() {
            let of_these = self.of_modes(rates, &lists, LANES * number, share);
            (0..LANES).for_each(|i| work[i] += of_these[i]);
        }
        let first = LANES * eights.len();
        let mut sum = work.iter().sum();
        for (number, rate) in rest.iter_mut().enumerate() {
            let [of_this] = self.of_modes(std::array::from_mut(rate), &lists, first + number, share);
            sum += of_this;
        }
        sum
    }

    /// The same for the modes from `first` on; the work of each.
    #[inline(always)]
    fn of_modes<const N: usize>(
        &self,
        rates: &mut [f64; N],
        lists: &Modes<'_>,
        first: usize,
        share: f64,
    ) -> [f64; N] {
        // All numbers are read before any is written: the lists could overlap, for all that the compiler knows.
        let from = |list: &[f64]| {
            let mut numbers = [0.0; N];
            numbers.copy_from_slice(&list[first..first + N]);
            numbers
        };
        let (q, contact) = (from(lists.coordinates), from(lists.contact_forces));
        let (square, c) = (from(lists.stiffness), from(lists.damping));
        let (start, end, between) = (from(lists.start), from(lists.end), from(lists.between));
        let (before, mut after, mut work) = (*rates, [0.0; N], [0.0; N]);
        for i in 0..N {
            let force = start[i] + share * (end[i] - start[i]) + contact[i] - square[i] * q[i] - between[i];
            after[i] =
                ((1.0 - c[i] * self.before) * before[i] + self.force * force) / (1.0 + c[i] * self.after);
            let impulse = c[i] * (self.before * before[i] + self.after * after[i]) + self.force * between[i];
            work[i] = impulse * (before[i] + after[i]) / 2.0;
        }
        *rates = after;
        work
    }
}

/// What acts on the modes, a number for each.
struct Modes<'a> {
    coordinates: &'a [f64],
    contact_forces: &'a [f64],
    stiffness: &'a [f64],
    damping: &'a [f64],
    start: &'a [f64],
    end: &'a [f64],
    between: &'a [f64],
}
