use nalgebra::{Cholesky, DVector};

use super::motion::ModalMotion;
use super::sides::Pressing;
use super::superposition::Superposition;
use crate::DamError;
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
        let norm = |forces: &DVector<f64>| forces.dot(&factors.solve(forces)).max(0.0).sqrt();
        let scale = norm(&DVector::from_column_slice(loads));
        let mut pressing = Pressing::at(&self.sides, &motion.coordinates);
        let (mut iterations, mut residual) = (0, 0.0);
        while iterations < MAX_ITERATIONS && residual <= RUNAWAY {
            pressing.press(&self.sides, motion, StiffnessDamping::default());
            let forces = DVector::from_fn(loads.len(), |i, _| {
                loads[i] + motion.contact_forces[i] - self.stiffness[i] * motion.coordinates[i]
            });
            residual = if scale > 0.0 { norm(&forces) / scale } else { 0.0 };
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
        Pressing::at(&self.sides, &motion.coordinates).press(&self.sides, motion, self.dashpots);
    }

    /// Central differences, with modal damping at the middle of the step:
    ///
    /// ```text
    /// (1 + c Δt/2) q̇ⁿ⁺½ = (1 − c Δt/2) q̇ⁿ⁻½ + Δt (fⁿ + f_contact(uⁿ, u̇ⁿ⁻½) − ω² qⁿ)
    /// qⁿ⁺¹ = qⁿ + Δt q̇ⁿ⁺½
    /// ```
    ///
    /// The first and the last kick are half a step long, so that coordinates and rates belong to the same
    /// instant. Mass damping between modes lags by half a step, as the dashpots of contacts do.
    pub(crate) fn advance(
        &self,
        steps: CentralDifference,
        motion: &mut ModalMotion,
        loads: &ModalLoadPath,
        work: &mut Work,
    ) {
        pulp::Arch::new().dispatch(Advance { model: self, steps, motion, loads, work });
    }
}

struct Advance<'a> {
    model: &'a Superposition,
    steps: CentralDifference,
    motion: &'a mut ModalMotion,
    loads: &'a ModalLoadPath,
    work: &'a mut Work,
}

impl pulp::NullaryFnOnce for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { model, steps: CentralDifference { time_step: dt, steps }, motion, loads, work } = self;
        let (start, end) = (&loads.start[..], &loads.end[..]);
        let mut pressing = Pressing::at(&model.sides, &motion.coordinates);
        let mut between = vec![0.0; model.damping_between.width()];
        model.damping_between.combine(&motion.rates, &mut between);
        let kick = Kick { before: 0.0, after: dt / 2.0, force: dt / 2.0 };
        kick.advance(model, motion, start, end, 0.0, &between);
        for step in 0..steps {
            let share = |n: f64| n / steps as f64;
            let middle = share(step as f64 + 0.5);
            let (mut input, mut damped) = (0.0, 0.0);
            let loads = start.iter().zip(end);
            let modes = motion.coordinates.iter_mut().zip(&motion.rates).zip(&model.damping).zip(loads);
            for (((q, rate), c), (start, end)) in modes {
                *q += dt * rate;
                input += rate * (start + middle * (end - start));
                damped += c * rate * rate;
            }
            model.damping_between.combine(&motion.rates, &mut between);
            damped += between.iter().zip(&motion.rates).map(|(force, rate)| force * rate).sum::<f64>();
            pressing.follow(&model.sides, &motion.coordinates, Some(dt));
            let losses = pressing.press(&model.sides, motion, model.dashpots);
            let kick = match step + 1 < steps {
                true => Kick { before: dt / 2.0, after: dt / 2.0, force: dt },
                false => Kick { before: dt / 2.0, after: 0.0, force: dt / 2.0 },
            };
            kick.advance(model, motion, start, end, share(step as f64 + 1.0), &between);
            work.input += dt * input;
            work.friction += losses.friction;
            work.damping += dt * (losses.damping_power + damped);
        }
    }
}

/// `(1 + c after) q̇ ← (1 − c before) q̇ + force f`.
struct Kick {
    before: f64,
    after: f64,
    force: f64,
}

impl Kick {
    #[inline(always)]
    fn advance(
        &self,
        model: &Superposition,
        motion: &mut ModalMotion,
        start: &[f64],
        end: &[f64],
        share: f64,
        between: &[f64],
    ) {
        let modes = motion.rates.iter_mut().zip(&motion.coordinates).zip(&motion.contact_forces);
        let modes = modes.zip(&model.stiffness).zip(&model.damping).zip(start.iter().zip(end));
        for (((((rate, q), contact), square), c), (start, end)) in modes {
            let force = start + share * (end - start) + contact - square * q;
            *rate = ((1.0 - c * self.before) * *rate + self.force * force) / (1.0 + c * self.after);
        }
        for (rate, between) in motion.rates.iter_mut().zip(between) {
            *rate -= self.force * between;
        }
    }
}
