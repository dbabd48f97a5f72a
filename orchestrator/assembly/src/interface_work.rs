//! Work at a wet face, step by step.

use crate::units::GROUND_ACCELERATION;
use cofferdam_coupling::participant::{Description, ParticipantError};
use cofferdam_coupling::scheme::{
    Account, Crossing, Graph, Interface, InterfaceWork, Interval, interface_points,
};
use cofferdam_coupling::signal::Signal;
use cofferdam_unit::{Fingerprint, WetFace, open, seal};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// The [`Account`] of a wet face.
pub struct WetFaceWork {
    account: WorkAccount,
    places: Places,
    fingerprint: Fingerprint,
}

/// Places in the answers of both units and in the request to the fluid.
struct Places {
    displacement: Range<usize>,
    velocity: Range<usize>,
    answered: Range<usize>,
    told: Range<usize>,
}

impl WetFaceWork {
    /// The account of `interface`; `None` if the units do not provide the variables for it, or
    /// their points form no wet face.
    ///
    /// **Errors**: a unit does not tell its points.
    pub fn new(graph: &mut Graph, interface: &Interface) -> Result<Option<Self>, ParticipantError> {
        let Some([dam, reservoir]) = interface_points(graph, interface)? else { return Ok(None) };
        let (Ok(dam), Ok(reservoir)) = (WetFace::new(dam), WetFace::new(reservoir)) else { return Ok(None) };
        let [structure, fluid] =
            [&interface.first, &interface.second].map(|port| graph[port.unit].description());
        let Some(places) = Places::of(interface, structure, fluid, dam.len()) else { return Ok(None) };
        let Ok(fingerprint) = Fingerprint::of("interface work", &(&dam, &reservoir)) else { return Ok(None) };
        let account = WorkAccount::new(&dam, &reservoir);
        Ok(Some(Self { account, places, fingerprint }))
    }
}

/// Acceleration (x, y) of the ground at `time` (s), m/s²; zero without a signal for it.
fn ground_at(signals: &[Signal], time: f64) -> [f64; 2] {
    let mut acceleration = [0.0; 2];
    for ground in signals.iter().filter(|signal| signal.input == GROUND_ACCELERATION) {
        ground.evaluate(time, &mut acceleration);
    }
    acceleration
}

impl Places {
    fn of(
        interface: &Interface,
        structure: &Description,
        fluid: &Description,
        points: usize,
    ) -> Option<Self> {
        let of_structure = |name: &str| structure.outputs.range(&interface.first.variable(name));
        let second = &interface.second;
        Some(Self {
            displacement: of_structure("interface_displacement")?,
            velocity: of_structure("interface_velocity").filter(|range| range.len() == points)?,
            answered: fluid.outputs.range(&second.variable("interface_pressure"))?,
            told: fluid.inputs.range(&second.variable("interface_acceleration"))?,
        })
    }

    fn at_interface(&self, Crossing { first, second, given, .. }: Crossing<'_>) -> AtInterface {
        AtInterface {
            given: given.to_vec(),
            displacement: first.outputs[self.displacement.clone()].to_vec(),
            velocity: first.outputs[self.velocity.clone()].to_vec(),
            answered: second.outputs[self.answered.clone()].to_vec(),
            told: second.inputs[self.told.clone()].to_vec(),
        }
    }
}

impl Account for WetFaceWork {
    fn begin(&mut self, now: Crossing<'_>) {
        let ground = ground_at(now.signals, now.first.occasion.time);
        self.account.begin(self.places.at_interface(now), ground);
    }

    fn step(&mut self, interval: &Interval, now: Crossing<'_>) -> InterfaceWork {
        let ground = ground_at(now.signals, interval.signal_time);
        self.account.step(interval.communication_step, self.places.at_interface(now), ground)
    }

    fn state(&self) -> Vec<u8> {
        // Numbers and lists of numbers always have a form as bytes.
        seal(self.fingerprint, &self.account).unwrap_or_default()
    }

    fn resume(&mut self, state: &[u8]) -> bool {
        match open(self.fingerprint, state) {
            Ok(account) => {
                self.account = account;
                true
            }
            Err(_) => false,
        }
    }
}

/// A wet face at the end of a step: one value a point of the dam's face, or of the reservoir's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct AtInterface {
    /// Pressure given to the dam, Pa.
    given: Vec<f64>,
    /// Displacement of the dam relative to the ground along the normals, m.
    displacement: Vec<f64>,
    /// Velocity of the dam relative to the ground along the normals, m/s.
    velocity: Vec<f64>,
    /// Pressure answered by the reservoir, Pa.
    answered: Vec<f64>,
    /// Mean acceleration over the step that the reservoir was given, m/s².
    told: Vec<f64>,
}

/// Computes the work at the interface step by step.
///
/// Over a step of length H, with the pressure linear in time on either side and M the mass matrix of each unit's own
/// panels (m):
///
/// ```text
/// W_dam   = Σ M (½(p₀ + p₁) Δu + (p₁ − p₀) H (v₁ − v₀)/12)       u with the cubic of its end values and velocities
/// W_water = Σ M H (p̃₀v₀ + p̃₁v₁)/3 + H (p̃₀v₁ + p̃₁v₀)/6           v linear, as the reservoir takes it
/// ```
///
/// Here p is the pressure given to the dam, with the dam's total motion; p̃ is the reservoir's answer, with the
/// velocity that the reservoir was given, v₁ = v₀ + H ā.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct WorkAccount {
    dam: Panels,
    reservoir: Panels,
    normals: Vec<[f64; 2]>,
    before: Option<AtInterface>,
    /// Velocity that the reservoir was given.
    told: Vec<f64>,
    /// Velocity and acceleration of the ground.
    ground: [[f64; 2]; 2],
}

/// Lower point and length of every panel.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Panels(Vec<(usize, f64)>);

impl Panels {
    fn of(face: &WetFace) -> Self {
        Self(face.panels().map(|panel| (panel.start, panel.length)).collect())
    }

    /// `Σ M_ij f(i, j)`.
    fn sum(&self, f: impl Fn(usize, usize) -> f64) -> f64 {
        let of = |&(start, length): &(usize, f64)| {
            let terms = [(0, 0, 3.0), (0, 1, 6.0), (1, 0, 6.0), (1, 1, 3.0)];
            terms.iter().map(|&(i, j, share)| length / share * f(start + i, start + j)).sum::<f64>()
        };
        self.0.iter().map(of).sum()
    }
}

impl WorkAccount {
    /// An account for the faces of the two units.
    fn new(dam: &WetFace, reservoir: &WetFace) -> Self {
        Self {
            dam: Panels::of(dam),
            normals: dam.normals(),
            told: vec![0.0; reservoir.len()],
            reservoir: Panels::of(reservoir),
            before: None,
            ground: [[0.0; 2]; 2],
        }
    }

    /// Begins at `now`, with the ground at rest under its acceleration (m/s²).
    fn begin(&mut self, now: AtInterface, ground_acceleration: [f64; 2]) {
        self.told.fill(0.0);
        (self.before, self.ground) = (Some(now), [[0.0; 2], ground_acceleration]);
    }

    /// The work of a step of length `h` (s) that ends at `now`, with the ground's acceleration `after` (m/s²) at its end.
    fn step(&mut self, h: f64, now: AtInterface, after: [f64; 2]) -> InterfaceWork {
        let [velocity, before] = self.ground;
        let moved = [0, 1].map(|d| h * velocity[d] + h * h * (2.0 * before[d] + after[d]) / 6.0);
        let faster = [0, 1].map(|d| velocity[d] + h * (before[d] + after[d]) / 2.0);
        let along = |vector: [f64; 2], i: usize| {
            let n = self.normals[i];
            vector[0] * n[0] + vector[1] * n[1]
        };
        let told: Vec<f64> = self.told.iter().zip(&now.told).map(|(v, a)| v + h * a).collect();
        let mut work = InterfaceWork::default();
        if let Some(then) = &self.before {
            work.on_first = self.dam.sum(|i, j| {
                let (p, q) = (then.given[i], now.given[i]);
                let displaced = now.displacement[j] - then.displacement[j] + along(moved, j);
                let v = [then.velocity[j] + along(velocity, j), now.velocity[j] + along(faster, j)];
                (p + q) / 2.0 * displaced + (q - p) * h * (v[1] - v[0]) / 12.0
            });
            work.by_second = self.reservoir.sum(|i, j| {
                let (p, q, v, w) = (then.answered[i], now.answered[i], self.told[j], told[j]);
                h * ((p * v + q * w) / 3.0 + (p * w + q * v) / 6.0)
            });
        }
        (self.before, self.told, self.ground) = (Some(now), told, [faster, after]);
        work
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A face of 10 m that moves with u = 1 − cos 3t under p = (2 + y) sin 3t, while the ground moves by its own.
    fn work(steps: u32, missed: f64) -> InterfaceWork {
        let h = 0.5 / f64::from(steps);
        let Ok(face) = WetFace::straight([0.0, 10.0], 4) else { unreachable!("ten metres, four panels") };
        let at = |t: f64| {
            let p = |y: f64| (2.0 + y) * (3.0 * t).sin();
            let given: Vec<f64> = face.points().iter().map(|point| p(point[1])).collect();
            AtInterface {
                answered: given.iter().map(|p| p + missed).collect(),
                given,
                displacement: vec![1.0 - (3.0 * t).cos() - 0.5 * t * t; 5],
                velocity: vec![3.0 * (3.0 * t).sin() - t; 5],
                told: vec![3.0 * ((3.0 * t).sin() - (3.0 * (t - h)).sin()) / h; 5],
            }
        };
        let mut account = WorkAccount::new(&face, &face);
        account.begin(at(0.0), [1.0, 7.0]);
        let mut sum = InterfaceWork::default();
        for step in 1..=steps {
            sum += account.step(h, at(h * f64::from(step)), [1.0, 7.0]);
        }
        sum
    }

    #[test]
    fn the_work_converges_to_its_integral_with_order_two_and_what_is_produced_too() {
        // ∫ (2 + y) dy · ∫ 3 sin² 3t dt
        let exact = 70.0 * 1.5 * (0.5 - 3f64.sin() / 6.0);
        let errors = [10, 20, 40].map(|steps| (work(steps, 0.0).on_first - exact).abs());
        let produced = [10, 20, 40].map(|steps| work(steps, 0.0).produced().abs());
        for series in [errors, produced] {
            for pair in series.windows(2) {
                let order = (pair[0] / pair[1]).log2();
                assert!((1.9..2.1).contains(&order), "{series:?}");
            }
        }
    }

    #[test]
    fn a_pressure_that_the_dam_does_not_get_is_lost() {
        let (exact, missed) = (work(40, 0.0), work(40, 2.0));
        // 2 Pa on 10 m, moved by 1 − cos 1.5
        let lost = missed.by_second - exact.by_second;
        assert!((lost - 20.0 * (1.0 - 1.5f64.cos())).abs() < 0.03, "{lost}");
        assert_eq!(missed.on_first, exact.on_first);
    }
}
