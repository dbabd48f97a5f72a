use super::Interval;
use interface::WetFace;
use serde::{Deserialize, Serialize};

/// Work at the interface in a window of communication steps, J per metre of dam.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InterfaceWork {
    /// Work on the dam of the pressure that it was given, with its actual motion.
    pub on_dam: f64,
    /// Work of the water with the pressure that it answered and the motion that it was given. The difference of the
    /// two is energy produced by the coupling, or lost if negative.
    pub by_water: f64,
}

/// The interface at the end of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfaceReport {
    /// Work in the step; `None` if the units do not provide the variables for it.
    pub work: Option<InterfaceWork>,
    /// Lowest pressure at the dam's points, hydrostatic and hydrodynamic, against the atmosphere's, Pa.
    pub lowest_pressure: f64,
    /// Relative difference of the work between the two faces because of the mapping:
    /// [`Mapping::work_error`](crate::mapping::Mapping::work_error).
    pub mapping_error: f64,
}

impl InterfaceWork {
    /// Energy produced at the interface, J/m.
    pub fn produced(&self) -> f64 {
        self.on_dam - self.by_water
    }
}

impl std::ops::AddAssign for InterfaceWork {
    fn add_assign(&mut self, other: Self) {
        self.on_dam += other.on_dam;
        self.by_water += other.by_water;
    }
}

/// The interface at the end of a step: one value a point of the dam's face, or of the reservoir's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct AtInterface {
    /// Pressure given to the dam, Pa.
    pub given: Vec<f64>,
    /// Displacement of the dam relative to the ground along the normals, m.
    pub displacement: Vec<f64>,
    /// Velocity of the dam relative to the ground along the normals, m/s.
    pub velocity: Vec<f64>,
    /// Pressure answered by the reservoir, Pa.
    pub answered: Vec<f64>,
    /// Mean acceleration over the step that the reservoir was given, m/s².
    pub told: Vec<f64>,
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
pub(super) struct WorkAccount {
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
    pub fn new(dam: &WetFace, reservoir: &WetFace) -> Self {
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
    pub fn begin(&mut self, now: AtInterface, ground_acceleration: [f64; 2]) {
        self.told.fill(0.0);
        (self.before, self.ground) = (Some(now), [[0.0; 2], ground_acceleration]);
    }

    /// The work of the step `interval` that ends at `now`.
    pub fn step(&mut self, interval: &Interval, now: AtInterface) -> InterfaceWork {
        let h = interval.communication_step;
        let [velocity, before] = self.ground;
        let after = interval.ground_acceleration;
        let moved = [0, 1].map(|d| h * velocity[d] + h * h * (2.0 * before[d] + after[d]) / 6.0);
        let faster = [0, 1].map(|d| velocity[d] + h * (before[d] + after[d]) / 2.0);
        let along = |vector: [f64; 2], i: usize| {
            let n = self.normals[i];
            vector[0] * n[0] + vector[1] * n[1]
        };
        let told: Vec<f64> = self.told.iter().zip(&now.told).map(|(v, a)| v + h * a).collect();
        let mut work = InterfaceWork::default();
        if let Some(then) = &self.before {
            work.on_dam = self.dam.sum(|i, j| {
                let (p, q) = (then.given[i], now.given[i]);
                let displaced = now.displacement[j] - then.displacement[j] + along(moved, j);
                let v = [then.velocity[j] + along(velocity, j), now.velocity[j] + along(faster, j)];
                (p + q) / 2.0 * displaced + (q - p) * h * (v[1] - v[0]) / 12.0
            });
            work.by_water = self.reservoir.sum(|i, j| {
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
            let time = h * f64::from(step - 1);
            let interval =
                Interval { step: step.into(), time, communication_step: h, ground_acceleration: [1.0, 7.0] };
            sum += account.step(&interval, at(time + h));
        }
        sum
    }

    #[test]
    fn the_work_converges_to_its_integral_with_order_two_and_what_is_produced_too() {
        // ∫ (2 + y) dy · ∫ 3 sin² 3t dt
        let exact = 70.0 * 1.5 * (0.5 - 3f64.sin() / 6.0);
        let errors = [10, 20, 40].map(|steps| (work(steps, 0.0).on_dam - exact).abs());
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
        let lost = missed.by_water - exact.by_water;
        assert!((lost - 20.0 * (1.0 - 1.5f64.cos())).abs() < 0.03, "{lost}");
        assert_eq!(missed.on_dam, exact.on_dam);
    }
}
