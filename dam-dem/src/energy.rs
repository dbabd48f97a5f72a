//! Energy balance, per metre of dam.

use serde::{Deserialize, Serialize};

/// Energy that damping and contacts dissipated, from one evaluation of the forces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses {
    /// Friction work since the previous evaluation, plus the spring energy of contacts that were lost (negative for
    /// contacts that were found again), J/m.
    pub friction: f64,
    /// Power of stiffness damping and dashpots, W/m: the mean of their previous and current forces times the velocity
    /// between the two evaluations.
    pub damping_power: f64,
    /// Work that the water in cracks no longer does since the previous evaluation, because it left what opened, J/m.
    pub relief: f64,
}

/// Work since time 0, summed over every time step, J/m.
///
/// Forces F at time step n and velocities v at the half steps give
/// `Σ Fⁿ·(vⁿ⁻½ + vⁿ⁺½) Δt/2 = Σ ½(Fⁿ + Fⁿ⁺¹)·vⁿ⁺½ Δt`, the work for which central differences conserve energy. This
/// formula is used for the input, for stiffness damping (in the elements, stress times strain rate) and for dashpots.
/// The work of mass damping is `Σ α m vⁿ⁻½·vⁿ Δt`, that of friction the mean shear force times the slip along the current
/// length of the other side, less the mean normal force times the rise by dilation. No term is computed from the balance of
/// the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Work {
    /// Work of weight, water and ground inertia, including the inertia of the added mass.
    pub input: f64,
    /// Energy lost to friction, and with the springs of contacts that slid past an end of the crack.
    pub friction: f64,
    /// Energy lost to mass and stiffness damping, including the dashpots of contacts: the work of their
    /// forces. The energy that the memory of damping stores temporarily counts as lost.
    pub damping: f64,
}

/// Energies stored at one instant, J/m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StoredEnergy {
    /// Kinetic energy relative to the ground, including that of the added mass.
    pub kinetic: f64,
    /// Strain energy of the elements.
    pub strain: f64,
    /// Energy of the contact springs.
    pub contact: f64,
}

/// Work and stored energy since the state of rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyLedger {
    /// Work since time 0.
    pub work: Work,
    /// Stored energy at time 0.
    pub at_rest: StoredEnergy,
    /// Current stored energy.
    pub now: StoredEnergy,
}

impl EnergyLedger {
    /// A ledger that starts with the energies stored at rest.
    pub fn starting(at_rest: StoredEnergy) -> Self {
        Self { work: Work::default(), at_rest, now: at_rest }
    }

    /// Stored energy since time 0, J/m.
    pub fn gained(&self) -> StoredEnergy {
        StoredEnergy {
            kinetic: self.now.kinetic - self.at_rest.kinetic,
            strain: self.now.strain - self.at_rest.strain,
            contact: self.now.contact - self.at_rest.contact,
        }
    }

    /// Input work minus stored and lost energy, J/m.
    ///
    /// For undamped linear motion it stays bounded, of the order of `(ω Δt)²/8` of the energy. It grows if a
    /// force is not the gradient of its energy, if a work is computed wrongly, or if the motion is unstable.
    pub fn balance_error(&self) -> f64 {
        let gained = self.gained();
        let stored = gained.kinetic + gained.strain + gained.contact;
        self.work.input - (stored + self.work.friction + self.work.damping)
    }
}

/// Monitors the energy balance over a run, and warns once: neither a run that continues from bytes nor a step that is repeated warns
/// again. It changes no result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct EnergyWatch {
    peak_kinetic: f64,
    /// Accepted states in a row whose error is too large.
    too_large: u32,
    /// Error of the first of them, J/m.
    first: f64,
    warned: bool,
}

/// Error of the energy balance, as a share of the peak kinetic energy, above which the dam warns.
const ENERGY_ALARM: f64 = 0.01;
/// Kinetic energy, as a share of the energy stored at rest, below which the balance error is only rounding.
const AT_REST: f64 = 1e-9;
/// Accepted states for which the error must stay too large: where motion begins, it is that of a few time steps, beside a kinetic energy
/// that is still growing.
const PATIENCE: u32 = 20;
/// Growth of the error since it became too large from which it is not that of a single event, such as an impact or water that leaves
/// a joint, but of a motion that gains energy.
const GROWTH: f64 = 2.0;

impl EnergyWatch {
    /// Returns to an earlier state, but for the warning, which was heard.
    pub(crate) fn restore(&mut self, earlier: Self) {
        *self = Self { warned: self.warned || earlier.warned, ..earlier };
    }

    /// Checks a ledger whose state has been accepted: its error over the peak kinetic energy, the first time that it stays too large
    /// and grows.
    pub(crate) fn look(&mut self, energy: &EnergyLedger) -> Option<f64> {
        self.peak_kinetic = self.peak_kinetic.max(energy.now.kinetic);
        let rest = energy.at_rest.strain + energy.at_rest.contact;
        let error = energy.balance_error().abs();
        let too_large = self.peak_kinetic > AT_REST * rest && error > ENERGY_ALARM * self.peak_kinetic;
        self.too_large = if too_large { self.too_large.saturating_add(1) } else { 0 };
        if self.too_large == 1 {
            self.first = error;
        }
        let alarm = !self.warned && self.too_large >= PATIENCE && error >= GROWTH * self.first;
        self.warned |= alarm;
        alarm.then(|| error / self.peak_kinetic)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ledger with 1 J/m of strain at rest, this kinetic energy, and an error of this share of it.
    fn ledger(kinetic: f64, error: f64) -> EnergyLedger {
        let at_rest = StoredEnergy { strain: 1.0, ..StoredEnergy::default() };
        let mut ledger = EnergyLedger::starting(at_rest);
        ledger.now.kinetic = kinetic;
        ledger.work.input = kinetic * (1.0 + error);
        ledger
    }

    #[test]
    fn an_error_that_grows_is_told_once_and_one_that_passes_or_stays_is_not() {
        let mut watch = EnergyWatch::default();
        let mut told = |kinetic, error, times: u32| {
            (0..times).filter_map(|_| watch.look(&ledger(kinetic, error))).collect::<Vec<_>>()
        };
        // Motion begins, and the error is a share of next to nothing.
        assert!(told(1e-12, 0.5, 100).is_empty() && told(1e-6, 0.05, PATIENCE - 1).is_empty());
        // 0.9 % of the peak, and of an earlier one.
        assert!(told(1e-3, 0.009, 100).is_empty() && told(1e-5, 0.9, 100).is_empty());
        // That of a single event stays.
        assert!(told(1e-3, 0.05, 100).is_empty() && told(1e-3, 0.09, 1).is_empty());
        let error = told(1e-3, 0.11, 1);
        assert!(error.len() == 1 && (error[0] - 0.11).abs() < 1e-9, "{error:?}");
        assert!(told(1e-3, 0.22, 100).is_empty(), "a second time");
        // A step that is begun again is not heard again.
        watch.restore(EnergyWatch::default());
        assert!((0..100).all(|_| watch.look(&ledger(1.0, 0.05)).is_none()));
    }
}
