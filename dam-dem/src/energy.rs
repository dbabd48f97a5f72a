//! The ledger of energies, per metre of dam.

use serde::{Deserialize, Serialize};

/// Energy that damping and contacts took out of the motion in one evaluation of the forces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses {
    /// Friction work since the evaluation before, and the energy of contact springs that were lost with
    /// their contact (negative: found with it), J/m.
    pub friction: f64,
    /// Power of stiffness damping and dashpots, W/m: mean of their forces before and now times the velocity
    /// between.
    pub damping_power: f64,
}

/// Work since time 0, summed over every time step, J/m.
///
/// Forces F at time step n and velocities v at the half steps give
/// `Σ Fⁿ·(vⁿ⁻½ + vⁿ⁺½) Δt/2 = Σ ½(Fⁿ + Fⁿ⁺¹)·vⁿ⁺½ Δt`, the product that central differences keep: for
/// the input, for stiffness damping (in the elements, stress times strain rate) and for dashpots. Mass
/// damping counts as `Σ α m |vⁿ⁺½|² Δt`, friction as the mean shear force over the slip. None of them is
/// found from a balance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Work {
    /// Work of weight, water and ground inertia, that of added mass included.
    pub input: f64,
    /// Energy lost to friction, and with the springs of contacts that slid past an end.
    pub friction: f64,
    /// Energy lost to mass and stiffness damping, contact dashpots included: the work of their forces. What
    /// damping's memory holds for the moment counts as lost.
    pub damping: f64,
}

/// Energies stored at one instant, J/m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StoredEnergy {
    /// Kinetic, relative to the ground, that of added mass included.
    pub kinetic: f64,
    /// In the elements, from their strains.
    pub strain: f64,
    /// In the contact springs.
    pub contact: f64,
}

/// Work and stored energy since the state of rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyLedger {
    /// Work since time 0.
    pub work: Work,
    /// Stored at time 0.
    pub at_rest: StoredEnergy,
    /// Stored now.
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

    /// Input work minus everything that was stored or lost, J/m.
    ///
    /// Of order `(ω Δt)²/8` of the energy for undamped linear motion, where it stays bounded; it grows with
    /// any force that is not the gradient of its energy, any work counted wrongly, and instability.
    pub fn balance_error(&self) -> f64 {
        let gained = self.gained();
        let stored = gained.kinetic + gained.strain + gained.contact;
        self.work.input - (stored + self.work.friction + self.work.damping)
    }
}
