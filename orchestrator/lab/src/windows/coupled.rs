//! Coupling of dam and water window by window.

use crate::study::StudyError;
use cofferdam_analysis::context::threads;
use cofferdam_assembly::units::DAM;
use cofferdam_assembly::{Assembly, AssemblyError, ShortWindows};
use cofferdam_coupling::acceleration::{Acceleration, AccelerationKind};
use cofferdam_coupling::participant::{Occasion, Participant, ParticipantError};
use cofferdam_coupling::scheme::CouplingError;
use cofferdam_motion::GroundMotion;
use cofferdam_scene::{Scene, Side};
use nalgebra::DMatrix;
use std::ops::Range;

/// First relaxation factor.
const RELAXATION: f64 = 0.5;
const MOST_ITERATIONS: usize = 200;
/// Growth of the residual that counts as divergence.
const GROWTH: f64 = 1e6;

/// Result of a coupled run.
pub struct Coupled {
    /// Crest displacement and sliding at the first crack (m), from time 0 on; no sliding without a crack.
    pub histories: [Vec<f64>; 2],
    /// Number of iterations of every window.
    pub iterations: Vec<usize>,
    pub end: End,
}

/// End of a coupled run.
pub enum End {
    Reached,
    /// The iterations diverged in the window from this time (s) on.
    Diverged {
        time: f64,
        iteration: usize,
    },
    /// The iteration limit was reached.
    NotConverged {
        time: f64,
        residual: f64,
    },
}

impl std::fmt::Display for End {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Reached => f.write_str("at the end"),
            Self::Diverged { time, iteration } => {
                write!(f, "diverges in the window from {time:.3} s (iteration {iteration})")
            }
            Self::NotConverged { time, residual } => write!(
                f,
                "no convergence in the window from {time:.3} s ({MOST_ITERATIONS} iterations, residual {residual:.1e})"
            ),
        }
    }
}

/// The dam, and the positions of variables in its requests and responses.
struct Dam<'a> {
    unit: Box<dyn Participant>,
    motion: &'a GroundMotion,
    step: f64,
    /// A request, which already contains the hydrostatic pressure.
    inputs: Vec<f64>,
    outputs: Vec<f64>,
    pressure: Range<usize>,
    ground: Range<usize>,
    acceleration: Range<usize>,
    crest: Range<usize>,
    sliding: Option<Range<usize>>,
}

/// Response of the dam in a window: mean accelerations (points and ground × steps), crest and sliding after each step.
struct Moved {
    acceleration: DMatrix<f64>,
    histories: [Vec<f64>; 2],
}

/// Runs the scene's dam with `water`, window after window; an incomplete last window is left out.
pub fn run(scene: &Scene, motion: &GroundMotion, water: &ShortWindows) -> Result<Coupled, StudyError> {
    let failed = |cause: ParticipantError| StudyError::Run {
        what: format!("windows of {} steps", water.steps()),
        cause: Box::new(CouplingError::from(cause).into()),
    };
    let mut dam = Dam::new(scene, motion)?;
    dam.initialise().map_err(failed)?;
    let mut done = Coupled { histories: Default::default(), iterations: Vec::new(), end: End::Reached };
    dam.append_to(&mut done.histories);
    let mut relaxation = Acceleration::new(AccelerationKind::Aitken, RELAXATION, 1.0);
    let floor = 0.01 * scene.largest_hydrostatic_pressure();
    let windows = scene.steps() as usize / water.steps();
    for window in 0..windows {
        let first = window * water.steps();
        let time = first as f64 * dam.step;
        dam.unit.save_state().map_err(failed)?;
        relaxation.begin_step();
        let mut guess = DMatrix::zeros(dam.pressure.len(), water.steps());
        let (mut began, mut iteration) = (None, 0);
        let moved = loop {
            iteration += 1;
            let moved = match dam.take(first, &guess) {
                Ok(moved) => moved,
                // The guess is too large for the dam.
                Err(_) if iteration > 1 => {
                    done.end = End::Diverged { time, iteration };
                    return Ok(done);
                }
                Err(error) => return Err(failed(error)),
            };
            let answer = match water.pressure(&moved.acceleration) {
                Ok(answer) => answer,
                // The response of the dam is not finite.
                Err(_) if iteration > 1 => {
                    done.end = End::Diverged { time, iteration };
                    return Ok(done);
                }
                Err(error) => return Err(AssemblyError::from(error).into()),
            };
            let residual = &answer - &guess;
            let size = residual.norm();
            if size <= scene.coupling.tolerance.relative() * (answer.norm() + floor) {
                break moved;
            }
            if size.is_nan() || size > GROWTH * *began.get_or_insert(size) {
                done.end = End::Diverged { time, iteration };
                return Ok(done);
            }
            if iteration == MOST_ITERATIONS {
                let residual = size / (answer.norm() + floor);
                done.end = End::NotConverged { time, residual };
                return Ok(done);
            }
            relaxation.accelerate(guess.as_mut_slice(), residual.as_slice());
            dam.unit.restore_state().map_err(failed)?;
        };
        done.iterations.push(iteration);
        for (all, more) in done.histories.iter_mut().zip(moved.histories) {
            all.extend(more);
        }
    }
    Ok(done)
}

impl<'a> Dam<'a> {
    fn new(scene: &Scene, motion: &'a GroundMotion) -> Result<Self, StudyError> {
        let unit = Assembly::with(scene, threads(None)).unit(DAM)?;
        let description = unit.description();
        let missing = StudyError::Unfit { what: "the study needs a dam that is computed".to_owned() };
        let inputs = |name: &str| description.inputs.range(name);
        let outputs = |name: &str| description.outputs.range(name);
        let (Some(pressure), Some(hydrostatic), Some(ground), Some(acceleration), Some(crest)) = (
            inputs("interface_pressure"),
            inputs("hydrostatic_pressure"),
            inputs("ground_acceleration"),
            outputs("interface_acceleration"),
            outputs("crest_displacement"),
        ) else {
            return Err(missing);
        };
        let sliding = outputs("crack_sliding");
        let mut request = vec![0.0; description.inputs.size()];
        let answer = vec![0.0; description.outputs.size()];
        let (weight, depth) = (scene.reservoir.density * scene.gravity, scene.depth());
        for (p, point) in
            request[hydrostatic].iter_mut().zip(Assembly::of(scene).dam_face(Side::Upstream)?.points())
        {
            *p = weight * (depth - point[1]);
        }
        let step = scene.time.communication_step;
        Ok(Self {
            unit,
            motion,
            step,
            inputs: request,
            outputs: answer,
            pressure,
            ground,
            acceleration,
            crest,
            sliding,
        })
    }

    fn initialise(&mut self) -> Result<(), ParticipantError> {
        self.inputs[self.ground.clone()].copy_from_slice(&self.motion.at(0.0));
        self.unit.initialise(0.0, &self.inputs, &mut self.outputs)
    }

    /// The steps of the window whose first one is `first`, with `pressure` (points × steps) at their ends.
    fn take(&mut self, first: usize, pressure: &DMatrix<f64>) -> Result<Moved, ParticipantError> {
        let (points, steps) = pressure.shape();
        let mut acceleration = DMatrix::zeros(points + 2, steps);
        let mut histories = [Vec::new(), Vec::new()];
        for (n, pressure) in pressure.column_iter().enumerate() {
            let time = (first + n) as f64 * self.step;
            let [before, after] = [time, time + self.step].map(|t| self.motion.at(t));
            self.inputs[self.pressure.clone()].copy_from_slice(pressure.as_slice());
            self.inputs[self.ground.clone()].copy_from_slice(&after);
            let occasion = Occasion {
                step: (first + n + 1) as u64,
                iteration: 1,
                attempt: 1,
                time,
                communication_step: self.step,
            };
            self.unit.step(&occasion, &self.inputs, &mut self.outputs)?;
            let mut column = acceleration.column_mut(n);
            column.rows_mut(0, points).copy_from_slice(&self.outputs[self.acceleration.clone()]);
            for axis in 0..2 {
                column[points + axis] = 0.5 * (before[axis] + after[axis]);
            }
            self.append_to(&mut histories);
        }
        Ok(Moved { acceleration, histories })
    }

    /// Appends the current values of crest and first crack.
    fn append_to(&self, [crest, sliding]: &mut [Vec<f64>; 2]) {
        crest.push(self.outputs[self.crest.start]);
        sliding.extend(self.sliding.as_ref().map(|range| self.outputs[range.start]));
    }
}
