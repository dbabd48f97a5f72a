use pulp::{Arch, Simd, WithSimd};

use crate::DampingCoefficients;
use crate::contact::{ContactBatches, ContactLaw};
use crate::element::CrossedCells;
use crate::energy::Work;
use crate::loads::LoadPath;
use crate::structure::{Motion, Structure};

/// Central differences in velocity form (kick, drift, kick):
///
/// ```text
/// vⁿ⁺½ = vⁿ + Δt/2 aⁿ
/// uⁿ⁺¹ = uⁿ + Δt vⁿ⁺½
/// aⁿ⁺¹ = M⁻¹ (F(tⁿ⁺¹) − F_int(uⁿ⁺¹) − C vⁿ⁺½)
/// vⁿ⁺¹ = vⁿ⁺½ + Δt/2 aⁿ⁺¹
/// ```
///
/// M is the lumped mass, plus the dense [`AddedMass`](crate::AddedMass) of the wet nodes if there is one.
///
/// The scheme is of second order for the elastic part. Damping forces lag by half a step, those of stiffness
/// damping also by its memory ([`StiffnessDamping`](crate::StiffnessDamping)). This keeps the scheme explicit
/// and only changes the limit of stability ([`CriticalTimeStep`](crate::CriticalTimeStep)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentralDifference {
    /// Δt, s.
    pub time_step: f64,
    /// Number of time steps.
    pub steps: usize,
}

impl CentralDifference {
    /// The smallest number of equal time steps, none longer than `limit` (s), that cover `duration` (s).
    pub fn covering(duration: f64, limit: f64) -> Self {
        let steps = (duration / limit).ceil().max(1.0);
        Self { time_step: duration / steps, steps: steps as usize }
    }

    /// Advances `motion` of a `structure` with `damping` under `loads`, which vary linearly over all steps;
    /// adds the work done to `work`. The acceleration of `motion` must be that at the start. Returns the impulse
    /// (N s/m) that mass damping did not take from blocks because they slid or rocked.
    pub fn advance(
        &self,
        structure: &Structure<impl ContactLaw>,
        damping: impl Into<DampingCoefficients>,
        motion: &mut Motion,
        loads: &LoadPath,
        work: &mut Work,
    ) -> [f64; 2] {
        let damping = damping.into();
        structure.cells.among_threads(|| self.take_steps(structure, damping, motion, loads, work))
    }

    fn take_steps(
        &self,
        structure: &Structure<impl ContactLaw>,
        damping: DampingCoefficients,
        motion: &mut Motion,
        loads: &LoadPath,
        work: &mut Work,
    ) -> [f64; 2] {
        let dt = self.time_step;
        let alpha = damping.rayleigh.mass;
        let mut forces = vec![[0.0; 2]; motion.displacement.len()];
        let mut release = structure.release(damping, dt);
        let mut released = if release.partings.is_empty() { Vec::new() } else { forces.clone() };
        let mut impulse = [0.0; 2];
        structure.find_meetings(motion, dt * self.steps as f64);
        let mut contacts = ContactBatches::new(&structure.cracks, &motion.joints);
        kick(motion, dt / 2.0);
        for step in 0..self.steps {
            let share = |n: f64| n / self.steps as f64;
            let (middle, end) = (share(step as f64 + 0.5), share(step as f64 + 1.0));
            let input = Nodes::of(motion, &mut forces, loads, structure)
                .sum(&structure.cells, &|n| Arch::new().dispatch(Drift { nodes: n, step: dt, middle, end }));
            let losses = structure.add_forces_with(
                &mut contacts,
                motion,
                damping.stiffness(),
                &mut forces,
                &mut release.partings,
            );
            let spared = structure.released(&mut release, alpha, motion, &mut released);
            if let Some(sum) = spared {
                (0..2).for_each(|d| impulse[d] += dt * sum[d]);
                let flat = forces.as_flattened_mut().iter_mut().zip(released.as_flattened());
                flat.for_each(|(force, released)| *force += released);
            }
            // before the water takes its share: of what drives both
            let locally = damp_locally(structure, damping.local, &motion.velocity, &mut forces);
            if let Some(water) = &structure.added_mass {
                water.take_share(&mut forces, &motion.velocity, &structure.mass, alpha);
            }
            let advance = if step + 1 < self.steps { dt } else { dt / 2.0 };
            let damped = Nodes::of(motion, &mut forces, loads, structure).sum(&structure.cells, &|n| {
                Arch::new().dispatch(Kick { nodes: n, advance, step: dt, mass_damping: alpha })
            });
            work.input += dt * input - losses.relief;
            work.friction += losses.friction;
            work.damping += dt * (losses.damping_power + alpha * damped);
            if damping.local != 0.0 {
                work.damping += dt * power(&locally, motion, advance - dt / 2.0);
            }
            if spared.is_some() {
                work.damping -= dt * power(&released, motion, advance - dt / 2.0);
            }
        }
        contacts.write(&mut motion.joints);
        impulse
    }
}

/// Number of nodes that are moved side by side. Of these, all numbers are read before any is written: the compiler need not
/// know then that the fields are disjoint.
const LANES: usize = 4;

/// Moves nodes over a time `step` (s) and sets their forces to the loads at `end`; the result is the power of the loads in
/// the `middle` of the step.
struct Drift<'a> {
    nodes: Nodes<'a>,
    step: f64,
    middle: f64,
    end: f64,
}

impl WithSimd for Drift<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let [many, rest] = self.nodes.in_lanes();
        Drift { nodes: many, ..self }.move_by::<LANES>() + Drift { nodes: rest, ..self }.move_by::<1>()
    }
}

impl Drift<'_> {
    /// Moves groups of N nodes.
    #[inline(always)]
    fn move_by<const N: usize>(self) -> f64 {
        let Self { nodes, step, middle, end } = self;
        let mut power = [[0.0; 2]; N];
        let (u, v) = (nodes.displacement.as_chunks_mut::<N>().0, nodes.velocity.as_chunks::<N>().0);
        let (start, change) = (nodes.start.as_chunks::<N>().0, nodes.change.as_chunks::<N>().0);
        let f = nodes.forces.as_chunks_mut::<N>().0;
        for ((((u, v), f), start), change) in u.iter_mut().zip(v).zip(f).zip(start).zip(change) {
            let (mut place, v, start, change) = (*u, *v, *start, *change);
            let mut load = [[0.0; 2]; N];
            for i in 0..N {
                for d in 0..2 {
                    place[i][d] += step * v[i][d];
                    power[i][d] += v[i][d] * (start[i][d] + middle * change[i][d]);
                    load[i][d] = start[i][d] + end * change[i][d];
                }
            }
            (*u, *f) = (place, load);
        }
        power.as_flattened().iter().sum()
    }
}

/// Accelerates nodes over the time `advance` (s) by their forces and mass damping; the result is `Σ m vⁿ⁻½·vⁿ`, with the
/// velocity vⁿ after half of a `step` (s).
struct Kick<'a> {
    nodes: Nodes<'a>,
    advance: f64,
    step: f64,
    mass_damping: f64,
}

impl WithSimd for Kick<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let [many, rest] = self.nodes.in_lanes();
        Kick { nodes: many, ..self }.move_by::<LANES>() + Kick { nodes: rest, ..self }.move_by::<1>()
    }
}

impl Kick<'_> {
    /// Accelerates groups of N nodes.
    #[inline(always)]
    fn move_by<const N: usize>(self) -> f64 {
        let Self { nodes, advance, step, mass_damping } = self;
        let half = step / 2.0;
        let mut sum = [[0.0; 2]; N];
        let (a, v) = (nodes.acceleration.as_chunks_mut::<N>().0, nodes.velocity.as_chunks_mut::<N>().0);
        let (mass, inverse) = (nodes.mass.as_chunks::<N>().0, nodes.inverse_mass.as_chunks::<N>().0);
        let f = nodes.forces.as_chunks::<N>().0;
        for ((((a, v), f), mass), inverse) in a.iter_mut().zip(v).zip(f).zip(mass).zip(inverse) {
            let (mut velocity, f, mass, inverse) = (*v, *f, *mass, *inverse);
            let mut acceleration = [[0.0; 2]; N];
            for i in 0..N {
                for d in 0..2 {
                    let v = velocity[i][d];
                    acceleration[i][d] = f[i][d] * inverse[i] - mass_damping * v;
                    sum[i][d] += mass[i] * v * (v + half * acceleration[i][d]);
                    velocity[i][d] = v + advance * acceleration[i][d];
                }
            }
            (*a, *v) = (acceleration, velocity);
        }
        sum.as_flattened().iter().sum()
    }
}

/// Data of consecutive nodes.
struct Nodes<'a> {
    displacement: &'a mut [[f64; 2]],
    velocity: &'a mut [[f64; 2]],
    acceleration: &'a mut [[f64; 2]],
    forces: &'a mut [[f64; 2]],
    start: &'a [[f64; 2]],
    change: &'a [[f64; 2]],
    mass: &'a [f64],
    inverse_mass: &'a [f64],
}

impl<'a> Nodes<'a> {
    fn of(
        motion: &'a mut Motion,
        forces: &'a mut [[f64; 2]],
        loads: &'a LoadPath,
        structure: &'a Structure<impl ContactLaw>,
    ) -> Self {
        Self {
            displacement: &mut motion.displacement,
            velocity: &mut motion.velocity,
            acceleration: &mut motion.acceleration,
            forces,
            start: &loads.start,
            change: &loads.change,
            mass: &structure.mass,
            inverse_mass: &structure.inverse_mass,
        }
    }

    /// Whole groups of [`LANES`] nodes, and the rest.
    #[inline(always)]
    fn in_lanes(self) -> [Self; 2] {
        let whole = self.mass.len() / LANES * LANES;
        self.split_at(whole)
    }

    #[inline(always)]
    fn split_at(self, middle: usize) -> [Self; 2] {
        let (u, v) = (self.displacement.split_at_mut(middle), self.velocity.split_at_mut(middle));
        let (a, f) = (self.acceleration.split_at_mut(middle), self.forces.split_at_mut(middle));
        let (start, change) = (self.start.split_at(middle), self.change.split_at(middle));
        let (mass, inverse) = (self.mass.split_at(middle), self.inverse_mass.split_at(middle));
        let first = Nodes {
            displacement: u.0,
            velocity: v.0,
            acceleration: a.0,
            forces: f.0,
            start: start.0,
            change: change.0,
            mass: mass.0,
            inverse_mass: inverse.0,
        };
        let second = Nodes {
            displacement: u.1,
            velocity: v.1,
            acceleration: a.1,
            forces: f.1,
            start: start.1,
            change: change.1,
            mass: mass.1,
            inverse_mass: inverse.1,
        };
        [first, second]
    }

    /// The sum of `of` over parts of the nodes, computed on the threads of `cells`.
    fn sum(self, cells: &CrossedCells, of: &(impl Fn(Nodes<'_>) -> f64 + Sync)) -> f64 {
        fn over(
            nodes: Nodes<'_>,
            parts: usize,
            cells: &CrossedCells,
            of: &(impl Fn(Nodes<'_>) -> f64 + Sync),
        ) -> f64 {
            if parts < 2 {
                return of(nodes);
            }
            let middle = nodes.mass.len() / 2;
            let [first, second] = nodes.split_at(middle);
            let half = |nodes| move || over(nodes, parts / 2, cells, of);
            let [first, second] = cells.both(half(first), half(second));
            first + second
        }
        over(self, cells.part_count(), cells, of)
    }
}

/// Power (W/m) of `forces` (N/m) with the velocities of a time `after` (s) ago.
fn power(forces: &[[f64; 2]], motion: &Motion, after: f64) -> f64 {
    let mut sums = [[0.0; 2]; LANES];
    let (f, rest_f) = forces.as_chunks::<LANES>();
    let (v, rest_v) = motion.velocity.as_chunks::<LANES>();
    let (a, rest_a) = motion.acceleration.as_chunks::<LANES>();
    let mut add = |f: &[[f64; 2]], v: &[[f64; 2]], a: &[[f64; 2]]| {
        for (((sum, f), v), a) in sums.iter_mut().zip(f).zip(v).zip(a) {
            (0..2).for_each(|d| sum[d] += f[d] * (v[d] - after * a[d]));
        }
    };
    f.iter().zip(v).zip(a).for_each(|((f, v), a)| add(f, v, a));
    add(rest_f, rest_v, rest_a);
    sums.as_flattened().iter().sum()
}

fn kick(motion: &mut Motion, duration: f64) {
    for (v, a) in motion.velocity.iter_mut().zip(&motion.acceleration) {
        v[0] += duration * a[0];
        v[1] += duration * a[1];
    }
}

/// Velocity below which the sign of local damping changes smoothly, m/s. With a jump, the motion of the dam
/// would not be a continuous function of the pressure on it.
const STANDSTILL: f64 = 1e-3;

/// Subtracts local damping `κ |F| v/√(v² + v₀²)` from `forces` (N/m); returns it, nothing without a coefficient.
fn damp_locally(
    structure: &Structure<impl ContactLaw>,
    coefficient: f64,
    velocity: &[[f64; 2]],
    forces: &mut [[f64; 2]],
) -> Vec<[f64; 2]> {
    if coefficient == 0.0 {
        return Vec::new();
    }
    let mut damping = vec![[0.0; 2]; forces.len()];
    let nodes = forces.iter_mut().zip(velocity).zip(&mut damping).zip(&structure.inverse_mass);
    for (((force, v), damping), _) in nodes.filter(|(_, inverse)| **inverse > 0.0) {
        for d in 0..2 {
            damping[d] = coefficient * force[d].abs() * v[d] / v[d].hypot(STANDSTILL);
            force[d] -= damping[d];
        }
    }
    damping
}
