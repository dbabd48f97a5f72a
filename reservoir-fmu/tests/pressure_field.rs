//! Pressure inside the water, stepped in time, against closed forms and against boundary elements.

use crate::rectangular;

use cofferdam_reservoir::{
    Complex64, Fidelity, PressureField, ReservoirError, ReservoirParameters, field_response,
};
use cofferdam_unit::WetFace;
use rectangular::{DENSITY, DEPTH, SOUND_SPEED, THREADS};
use std::f64::consts::PI;

const CUT_OFF: f64 = PI * SOUND_SPEED / (2.0 * DEPTH);
/// Decay of the transforms, 1/s, and the time after which it leaves less than 1e-5.
const DECAY: f64 = 0.15 * CUT_OFF;
const DURATION: f64 = 12.0 / DECAY;

/// What moves: the face along its normals, or face and ground along x or y.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Moves {
    Face,
    Ground([f64; 2]),
}

impl Moves {
    /// Velocities of the face's points and of the ground, over that of the motion.
    fn inputs(self, face: &WetFace) -> (Vec<f64>, [f64; 2]) {
        match self {
            Self::Face => (vec![1.0; face.len()], [0.0; 2]),
            Self::Ground(along) => {
                let normals = face.normals().into_iter();
                (normals.map(|n| n[0] * along[0] + n[1] * along[1]).collect(), along)
            }
        }
    }
}

/// Pressure (Pa) at every node for a unit velocity (m/s) at each s (1/s): the quotient of the Laplace transforms of the field and
/// of a velocity `e^{−(t − 5w)²/w²}`, both by the trapezoidal rule.
fn responses(
    parameters: &ReservoirParameters,
    moves: Moves,
    s: &[Complex64],
) -> Result<(PressureField, Vec<Vec<Complex64>>), ReservoirError> {
    let mut field = PressureField::new(parameters)?;
    let step = parameters.communication_step;
    let (face, ground) = moves.inputs(&parameters.wet_face);
    let width = 0.7 / CUT_OFF;
    let instant = |n: usize| n as f64 * step / width - 5.0;
    let velocity = |n: usize| (-instant(n).powi(2)).exp();
    let acceleration = |n: usize| -2.0 * instant(n) * velocity(n) / width;
    let mut transforms = vec![vec![Complex64::ZERO; field.nodes().len()]; s.len()];
    let mut of_velocity = vec![Complex64::ZERO; s.len()];
    for n in 1..=(DURATION / step) as usize {
        let mean = (velocity(n) - velocity(n - 1)) / step;
        // The ground's acceleration is linear in a step: its mean is that of both ends.
        let ends = [n - 1, n].map(|n| ground.map(|g| g * acceleration(n)));
        let face: Vec<f64> = face.iter().map(|v| v * mean).collect();
        field.advance(&face, ends, step)?;
        let pressure = field.pressure();
        for (k, s) in s.iter().enumerate() {
            let factor = (-s * (n as f64 * step)).exp();
            of_velocity[k] += factor * velocity(n);
            transforms[k].iter_mut().zip(&pressure).for_each(|(sum, p)| *sum += factor * p);
        }
    }
    let divided = |(transform, v): (Vec<Complex64>, &Complex64)| transform.iter().map(|p| p / v).collect();
    Ok((field, transforms.into_iter().zip(&of_velocity).map(divided).collect()))
}

/// Largest difference over the largest value.
fn difference(found: &[Complex64], exact: &[Complex64]) -> f64 {
    let largest = |values: &mut dyn Iterator<Item = Complex64>| values.map(|p| p.norm()).fold(0.0, f64::max);
    largest(&mut found.iter().zip(exact).map(|(a, b)| a - b)) / largest(&mut exact.iter().copied())
}

fn channel(alpha: f64, elements: f64, step: f64, depths: f64) -> ReservoirParameters {
    ReservoirParameters {
        element_size: DEPTH / elements,
        corner_element_size: Some(DEPTH / elements / 16.0),
        far_end_distance: depths * DEPTH,
        ..rectangular::parameters(alpha, 32, step, 1.0)
    }
}

/// Pressure in a channel over a rigid bed, before a face that moves by v: `−ρ s v Σ_m 2(−1)^m/(λ_m h κ_m) cos(λ_m y) e^{κ_m x}`.
fn modal_series(s: Complex64, [x, y]: [f64; 2]) -> Complex64 {
    let mode = |m: u32| {
        let lambda = f64::from(2 * m + 1) * PI / (2.0 * DEPTH);
        let kappa = (lambda * lambda + (s / SOUND_SPEED).powi(2)).sqrt();
        let sign = if m.is_multiple_of(2) { 2.0 } else { -2.0 };
        sign / (lambda * DEPTH) / kappa * (lambda * y).cos() * (kappa * x).exp()
    };
    -DENSITY * s * (0..400).map(mode).sum::<Complex64>()
}

/// Largest error of the field in a channel over a rigid bed, over the frequencies, before a uniformly moving face.
fn error_in_channel(parameters: &ReservoirParameters, s: &[Complex64]) -> Result<f64, ReservoirError> {
    let (field, found) = responses(parameters, Moves::Face, s)?;
    let exact = |s: &Complex64| field.nodes().iter().map(|node| modal_series(*s, *node)).collect::<Vec<_>>();
    Ok(s.iter().zip(&found).map(|(s, found)| difference(found, &exact(s))).fold(0.0, f64::max))
}

/// Below, at and above the first cut-off frequency: second order, that of the steps, which follow the elements. A far end at a quarter of the
/// depth is as good as one at three depths.
#[test]
fn a_channel_against_its_modal_series() -> Result<(), ReservoirError> {
    let s = [0.3, 1.0, 1.7, 2.3].map(|ratio| Complex64::new(DECAY, ratio * CUT_OFF));
    for depths in [0.25, 3.0] {
        let at = |(elements, step)| error_in_channel(&channel(1.0, elements, step, depths), &s);
        let [coarse, usual, fine] = [at((4.0, 0.01))?, at((8.0, 0.005))?, at((16.0, 0.0025))?];
        let order = (coarse / fine).log2() / 2.0;
        println!(
            "end at {depths} h: off by {coarse:.1e} with h/4, {usual:.1e} with h/8, {fine:.1e} with h/16, order {order:.1}"
        );
        assert!(order > 1.7 && usual < 5e-3);
    }
    Ok(())
}

/// A bed that rises towards a battered face, from a rigid to an absorbing bed, with gravity waves, and incompressible: against boundary
/// elements, in the water and beside its far end, for a moving face and a ground that moves along x or y.
#[test]
fn rising_ground_against_boundary_elements() -> Result<(), ReservoirError> {
    let s = [0.4, 1.6].map(|ratio| Complex64::new(DECAY, ratio * CUT_OFF));
    let moves = [Moves::Face, Moves::Ground([1.0, 0.0]), Moves::Ground([0.0, 1.0])];
    for (alpha, surface_waves) in [(1.0, false), (0.5, false), (0.0, false), (0.5, true)] {
        let mut waters = Vec::new();
        for (elements, step) in [(8.0, 0.005), (16.0, 0.0025)] {
            let water = ReservoirParameters {
                wet_face: WetFace::straight([0.15 * DEPTH, DEPTH], 24).map_err(|_| ReservoirError::Mesh)?,
                bed: vec![[-0.2 * DEPTH, 0.0], [-0.6 * DEPTH, -0.25 * DEPTH]],
                surface_waves,
                ..channel(alpha, elements, step, 0.5)
            };
            // Nodes inside, where the formula of boundary elements holds: not within an element of the boundary.
            let nodes = PressureField::new(&water)?.nodes().to_vec();
            let inside: Vec<usize> =
                (0..nodes.len()).filter(|i| i % 7 == 0 && is_inside(nodes[*i])).collect();
            let points: Vec<[f64; 2]> = inside.iter().map(|i| nodes[*i]).collect();
            waters.push((water, inside, points));
        }
        // The same boundary elements for the points of both.
        let fine = ReservoirParameters {
            element_size: DEPTH / 24.0,
            corner_element_size: Some(DEPTH / 2400.0),
            ..waters[0].0.clone()
        };
        let points: Vec<[f64; 2]> = waters.iter().flat_map(|(_, _, points)| points.clone()).collect();
        let exact =
            s.iter().map(|s| field_response(&fine, *s, &points, THREADS)).collect::<Result<Vec<_>, _>>()?;
        let (mut errors, mut first) = (Vec::new(), 0);
        for (water, inside, points) in &waters {
            let mut off: f64 = 0.0;
            for moves in moves {
                let (_, found) = responses(water, moves, &s)?;
                let (face, ground) = moves.inputs(&water.wet_face);
                let inputs: Vec<f64> = face.iter().chain(&ground).copied().collect();
                for (exact, found) in exact.iter().zip(&found) {
                    let exact = exact.rows(first, points.len());
                    let exact: Vec<Complex64> = exact
                        .row_iter()
                        .map(|row| row.iter().zip(&inputs).map(|(k, v)| k * v).sum())
                        .collect();
                    let found: Vec<Complex64> = inside.iter().map(|i| found[*i]).collect();
                    off = off.max(difference(&found, &exact));
                }
            }
            errors.push(off);
            first += points.len();
        }
        println!(
            "α = {alpha}, waves {surface_waves}: off by {:.1e} with h/8, {:.1e} with h/16",
            errors[0], errors[1]
        );
        assert!(errors[1] < 3e-3 && errors[0] < 1e-2);
    }
    Ok(())
}

/// Whether a point of the rising ground's water is at least h/12 from its boundary; the far end does not count.
fn is_inside([x, y]: [f64; 2]) -> bool {
    let bed = if x > -0.2 * DEPTH { 0.0 } else { (x / DEPTH + 0.2).max(-0.4) * 0.625 * DEPTH };
    let margin = DEPTH / 12.0;
    y > bed + 1.2 * margin && y < DEPTH - margin && x < 0.15 * y - margin && x > -1.05 * DEPTH
}

/// Incompressible water answers a held acceleration with the modal series of c → ∞, and a ground that rises with ρ a (h − y).
#[test]
fn incompressible_water_answers_at_once() -> Result<(), ReservoirError> {
    let water = ReservoirParameters { fidelity: Fidelity::Incompressible, ..channel(0.5, 16.0, 0.01, 1.0) };
    let points = water.wet_face.len();
    let mut field = PressureField::new(&water)?;
    for _ in 0..2 {
        field.advance(&vec![1.0; points], [[0.0; 2]; 2], 0.01)?;
    }
    let nodes = field.nodes();
    let real = |values: Vec<f64>| values.into_iter().map(Complex64::from).collect::<Vec<_>>();
    // With s → 0 the series over s is that of a unit acceleration.
    let s = Complex64::from(1e-6);
    let exact: Vec<Complex64> = nodes.iter().map(|node| modal_series(s, *node) / s).collect();
    let off = difference(&real(field.pressure()), &exact);
    let mut field = PressureField::new(&water)?;
    field.advance(&vec![0.0; points], [[0.0; 2], [0.0, 1.0]], 0.01)?;
    let lifted: Vec<Complex64> =
        nodes.iter().map(|node| Complex64::from(DENSITY * (DEPTH - node[1]))).collect();
    let off_lifted = difference(&real(field.pressure()), &lifted);
    println!("incompressible: off by {off:.1e}, lifted {off_lifted:.1e}");
    assert!(off < 2e-3 && off_lifted < 1e-10);
    Ok(())
}

/// A constant acceleration for ten minutes gives the static pressure, on average over a period of the first mode, which dies like t^{-1/2} over
/// a rigid bed. Nothing drifts.
#[test]
fn a_load_held_for_ten_minutes() -> Result<(), ReservoirError> {
    for alpha in [1.0, 0.8] {
        let water = channel(alpha, 4.0, 0.02, 1.0);
        let points = water.wet_face.len();
        let still = ReservoirParameters {
            fidelity: Fidelity::Incompressible,
            far_end_distance: 3.0 * DEPTH,
            ..water.clone()
        };
        let mut still = PressureField::new(&still)?;
        for _ in 0..2 {
            still.advance(&vec![1.0; points], [[0.0; 2]; 2], 0.02)?;
        }
        let mut field = PressureField::new(&water)?;
        let heel = |field: &PressureField| field.pressure()[0];
        let (period, step) = (4.0 * DEPTH / SOUND_SPEED, 0.02);
        let samples = (period / step) as usize;
        let mut held = Vec::new();
        for minute in 1..=10 {
            let mut mean = 0.0;
            for n in 1..=3000 {
                field.advance(&vec![1.0; points], [[0.0; 2]; 2], step)?;
                mean += if n + samples > 3000 { heel(&field) / samples as f64 } else { 0.0 };
            }
            held.push(mean / heel(&still) - 1.0);
            println!(
                "α = {alpha}, after {minute} min: off the static pressure at the heel by {:.1e}",
                held[minute - 1]
            );
        }
        assert!(held.iter().all(|off| off.abs() < 1e-3));
    }
    Ok(())
}

/// Noise at every point and of the ground, in steps of three lengths, for any bed: afterwards the water comes to rest.
#[test]
fn noise_does_not_grow() -> Result<(), ReservoirError> {
    for (alpha, surface_waves) in [(1.0, false), (0.999, false), (0.9, false), (0.0, false), (1.0, true)] {
        let water = ReservoirParameters { surface_waves, ..channel(alpha, 4.0, 0.01, 0.5) };
        let mut field = PressureField::new(&water)?;
        let mut seed = 1u64;
        let mut noise = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let largest =
            |field: &PressureField| field.pressure().iter().fold(0.0, |most: f64, p| most.max(p.abs()));
        // A rigid bed that moves upwards sets all of the channel in motion, for ever.
        let upwards = if alpha < 0.99 { 1.0 } else { 0.0 };
        let (mut driven, mut after, mut ground): (f64, f64, _) = (0.0, 0.0, [0.0; 2]);
        let (mut given, mut length) = (vec![0.0; water.wet_face.len()], 0.0);
        for step in 0..6000 {
            let step_length = [0.01, 0.0037, 0.023][step % 3];
            let begin = ground;
            let face: Vec<f64> = match step {
                0..2000 => given.iter().map(|_| noise()).collect(),
                // Brought to rest.
                2000 => given.iter().map(|v| -v / step_length).collect(),
                _ => vec![0.0; given.len()],
            };
            ground = if step < 1999 { [noise(), upwards * noise()] } else { [0.0; 2] };
            field.advance(&face, [begin, ground], step_length)?;
            given.iter_mut().zip(&face).for_each(|(v, a)| *v += step_length * a);
            length += step_length;
            if step < 2000 {
                driven = driven.max(largest(&field));
            } else if step >= 5000 {
                after = after.max(largest(&field));
            }
        }
        println!(
            "α = {alpha}, waves {surface_waves}: {driven:.0} Pa driven, {after:.1} Pa 40 s after, at {length:.0} s"
        );
        assert!(after < if alpha < 0.99 { 1e-3 } else { 0.3 } * driven);
    }
    Ok(())
}

/// Water of 5 m in short and in long steps, and of 300 m: the channel is fitted for steps that its elements ask for, where the
/// communication step is too long for that.
#[test]
fn every_depth_bed_and_step_has_a_field() -> Result<(), ReservoirError> {
    for alpha in [0.9975, 0.98, 0.0] {
        for (depth, communication_step) in [(5.0, 0.001), (5.0, 0.01), (300.0, 0.01)] {
            let face = WetFace::straight([0.1 * depth, depth], 12).map_err(|_| ReservoirError::Mesh)?;
            let water = ReservoirParameters {
                wave_reflection_coefficient: alpha,
                communication_step,
                ..ReservoirParameters::before(face)
            };
            let begun = std::time::Instant::now();
            let field = PressureField::new(&PressureField::usual_mesh(&water));
            println!(
                "{alpha} {depth} {communication_step}: {} {:?}",
                begun.elapsed().as_secs_f64(),
                field.as_ref().err()
            );
            let Ok(mut field) = field else { continue };
            for _ in 0..20 {
                field.advance(&[-1.0; 13], [[0.0; 2]; 2], communication_step)?;
            }
            // A face that moves into the water presses, by no more than ρ c v.
            let (highest, velocity) =
                (field.pressure().into_iter().fold(0.0, f64::max), 20.0 * communication_step);
            let most = 1000.0 * 1440.0 * velocity;
            assert!(
                highest > 100.0 && highest < 1.5 * most,
                "{depth} m, α = {alpha}: {highest} Pa of {most}"
            );
        }
    }
    Ok(())
}
