mod checks;

use super::channels::{Channels, check_size, interface_points, mapping};
use super::evaluation::{Iteration, ask};
use super::frozen::FrozenWatch;
use super::interface_work::{AtInterface, WorkAccount};
use super::{
    CouplingError, Exchange, InterfaceReport, Interval, Predictor, SchemeKind, Side, StepFailure, Units,
    WindowReport,
};
use crate::acceleration::Acceleration;
use crate::convergence::{ConvergenceMeasure, Guard, Hopeless, Residuals, norm};
use crate::mapping::Mapping;
use crate::participant::{Occasion, ParticipantError};
use interface::WetFace;
use std::time::Instant;

/// The scheme and its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The scheme.
    pub kind: SchemeKind,
    /// Largest number of iterations of a window by one acceleration; those that measure and check the units do not
    /// count.
    pub iteration_limit: u32,
    /// Whether the run continues with a window that reached the iteration limit or stagnated; it is reported as not
    /// converged.
    pub accept_unconverged: bool,
    /// Weight of acceleration against pressure in the parallel schemes, Pa/(m/s²).
    pub acceleration_scale: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            kind: SchemeKind::SerialImplicit,
            iteration_limit: 100,
            accept_unconverged: false,
            acceleration_scale: 1.0,
        }
    }
}

/// Takes communication steps with two units, by a [`SchemeKind`].
///
/// The unknowns x of a window are the pressures at the ends of its steps; for a parallel scheme also the
/// accelerations, multiplied by [`Settings::acceleration_scale`]. An iteration G takes every step of the window with
/// each unit; [`Acceleration`] moves x towards x = G(x). An iteration is one step of the dam per communication step,
/// including the confirming one.
///
/// **Call order**: [`initialise`](Self::initialise); then [`advance`](Self::advance), or
/// [`attempt`](Self::attempt) and, if its report is good, [`accept`](Self::accept); if not, another attempt at the
/// same time.
pub struct Scheme {
    settings: Settings,
    acceleration: Acceleration,
    /// The acceleration without history.
    fresh: Acceleration,
    predictor: Predictor,
    measure: ConvergenceMeasure,
    channels: Channels,
    mapping: Mapping,
    account: Option<WorkAccount>,
    hydrostatic: Vec<f64>,
    frozen: [FrozenWatch; 2],
    /// Number and length (s) of the steps that the acceleration has learnt from.
    shape: (usize, f64),
    /// Change of the residual by rounding, Pa.
    floor: Option<f64>,
    /// Largest norm of an accepted pressure, Pa.
    largest_pressure: f64,
    /// The units are inside a window that was not accepted.
    astray: bool,
    began: Instant,
}

/// Result of an iteration.
struct Answer {
    /// G(x).
    unknowns: Vec<f64>,
    displacement: Vec<f64>,
}

/// Ratios of step lengths between which an acceleration keeps its history.
const SIMILAR: std::ops::Range<f64> = 0.6..1.7;

impl Scheme {
    /// A scheme for `units`.
    ///
    /// **Errors**: a unit lacks a coupled variable; the interface points of the two differ; the mass of the water is
    /// both in the dam's mass matrix and exchanged, or neither; an implicit scheme with an iteration limit of 0.
    pub fn new(
        units: &mut Units,
        settings: Settings,
        acceleration: Acceleration,
        predictor: Predictor,
        measure: ConvergenceMeasure,
    ) -> Result<Self, CouplingError> {
        let channels = Channels::of(units.dam.description(), units.reservoir.description())?;
        let [dam, reservoir] = interface_points(units)?;
        let mapping = mapping(&dam, &reservoir)?;
        checks::added_mass(units, settings.kind)?;
        if settings.kind.is_implicit() && settings.iteration_limit == 0 {
            return Err(CouplingError::NoIteration);
        }
        // Units of another kind may have no wet face; their work is then unknown.
        let faces = WetFace::new(dam).ok().zip(WetFace::new(reservoir).ok());
        let faces = faces.filter(|_| channels.dam_velocity.is_some());
        Ok(Self {
            settings,
            fresh: acceleration.clone(),
            acceleration,
            predictor,
            measure,
            channels,
            mapping,
            account: faces.map(|(dam, reservoir)| WorkAccount::new(&dam, &reservoir)),
            hydrostatic: Vec::new(),
            frozen: Default::default(),
            shape: (0, 0.0),
            floor: None,
            largest_pressure: 0.0,
            astray: false,
            began: Instant::now(),
        })
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Initialises both units at `time` (s), the reservoir first, because its hydrostatic pressure loads the dam.
    ///
    /// **Errors**: a unit fails.
    pub fn initialise(
        &mut self,
        units: &mut Units,
        time: f64,
        ground_acceleration: [f64; 2],
    ) -> Result<WindowReport, StepFailure> {
        self.began = Instant::now();
        let start = Interval { step: 0, time, communication_step: 0.0, ground_acceleration };
        self.reported(units, &[start], 1, Self::initialise_into)
    }

    fn initialise_into(&mut self, units: &mut Units, report: &mut WindowReport) -> Result<(), CouplingError> {
        let Interval { time, ground_acceleration, .. } = report.steps[0];
        let occasion = Occasion::initialisation(time);
        let (points, water) = (self.channels.dam_pressure.len(), self.channels.reservoir_acceleration.len());
        let inputs = self.channels.to_reservoir(&vec![0.0; water], ground_acceleration);
        ask(&mut *units.reservoir, Side::Reservoir, occasion, inputs, self.began, &mut report.exchanges)?;
        let hydrostatic = units.reservoir.read("hydrostatic_pressure")?;
        check_size(units.reservoir.description(), "hydrostatic_pressure", water, hydrostatic.len())?;
        self.hydrostatic = vec![0.0; points];
        self.mapping.pressure_to_dam(&hydrostatic, &mut self.hydrostatic);
        let inputs = self.channels.to_dam(&vec![0.0; points], &self.hydrostatic, ground_acceleration);
        ask(&mut *units.dam, Side::Dam, occasion, inputs, self.began, &mut report.exchanges)?;
        report.exchanges.iter_mut().for_each(|e| e.accepted = true);
        report.converged = true;
        let lowest_pressure = self.hydrostatic.iter().copied().fold(f64::INFINITY, f64::min);
        report.interface.push(InterfaceReport { work: None, lowest_pressure, mapping_error: 0.0 });
        self.predictor.accept(0.0, &vec![0.0; self.unknowns()]);
        let now = self.at_interface(&report.exchanges[1], &report.exchanges[0]);
        if let (Some(account), Some(now)) = (&mut self.account, now) {
            account.begin(now, ground_acceleration);
        }
        Ok(())
    }

    /// Takes the steps of a window, repeated together until they converge, and continues from their end.
    ///
    /// **Errors**: as [`attempt`](Self::attempt).
    pub fn advance(&mut self, units: &mut Units, steps: &[Interval]) -> Result<WindowReport, StepFailure> {
        let mut report = self.attempt(units, steps, 1)?;
        self.accept(&mut report);
        Ok(report)
    }

    /// Takes the steps of a window, repeated together until they converge. It starts at the end of the last accepted
    /// window, also after other attempts.
    ///
    /// Where a quasi-Newton acceleration brings no convergence, others take over ([`Acceleration::fallback`]), from the
    /// iterate with the smallest residual.
    ///
    /// In the first window that needs more than one iteration, one iteration checks that the units return to their
    /// saved states, and another measures the rounding floor.
    ///
    /// **Errors**: a unit fails, the iteration limit is reached, or further iterations are useless; with the
    /// exchanges so far.
    pub fn attempt(
        &mut self,
        units: &mut Units,
        steps: &[Interval],
        attempt: u32,
    ) -> Result<WindowReport, StepFailure> {
        // The Jacobian depends on the number of unknowns and on the step length.
        let shape = (steps.len(), steps.first().map_or(0.0, |interval| interval.communication_step));
        if self.shape.0 != shape.0 || !SIMILAR.contains(&(shape.1 / self.shape.1)) {
            (self.acceleration, self.shape) = (self.fresh.clone(), shape);
        }
        self.reported(units, steps, attempt, Self::iterate)
    }

    /// Accepts the window that was attempted last.
    pub fn accept(&mut self, report: &mut WindowReport) {
        self.astray = false;
        let last = report.iterations();
        report.exchanges.iter_mut().for_each(|e| e.accepted = e.occasion.iteration == last);
        for side in [Side::Dam, Side::Reservoir] {
            self.frozen[side as usize].accept(side, report);
        }
        for interval in report.steps.clone() {
            let of = |side| report.accepted(side, interval.step);
            let (Some(dam), Some(reservoir)) = (of(Side::Dam), of(Side::Reservoir)) else { continue };
            let pressure = self.pressure(reservoir);
            self.largest_pressure = self.largest_pressure.max(norm(pressure.iter().copied()));
            let total = self.hydrostatic.iter().zip(&pressure).map(|(still, moving)| still + moving);
            let lowest_pressure = total.fold(f64::INFINITY, f64::min);
            let mapping_error = self.mapping.work_error(
                &reservoir.outputs[self.channels.reservoir_pressure.clone()],
                &dam.outputs[self.channels.dam_acceleration.clone()],
            );
            let unknowns = self.unknowns_of(dam, reservoir);
            self.predictor.accept(interval.communication_step, &unknowns);
            let now = self.at_interface(dam, reservoir);
            let work = self.account.as_mut().zip(now).map(|(account, now)| account.step(&interval, now));
            report.interface.push(InterfaceReport { work, lowest_pressure, mapping_error });
        }
    }

    /// Fills a report by `call` and adds times and messages of the units.
    fn reported(
        &mut self,
        units: &mut Units,
        steps: &[Interval],
        attempt: u32,
        call: impl FnOnce(&mut Self, &mut Units, &mut WindowReport) -> Result<(), CouplingError>,
    ) -> Result<WindowReport, StepFailure> {
        let mut report =
            WindowReport { steps: steps.to_vec(), attempt, relaxation: 1.0, ..WindowReport::default() };
        let before = [units.dam.busy(), units.reservoir.busy()];
        let result = call(self, units, &mut report);
        report.solver_time =
            [units.dam.busy().saturating_sub(before[0]), units.reservoir.busy().saturating_sub(before[1])];
        report.unit_time = if self.settings.kind.is_parallel() {
            report.solver_time.into_iter().max().unwrap_or_default()
        } else {
            report.solver_time.iter().sum()
        };
        report.messages = [units.dam.messages(), units.reservoir.messages()].concat();
        report.rounding_floor = self.floor;
        match result {
            Ok(()) => Ok(report),
            Err(error) => Err(StepFailure { report: Box::new(report), error }),
        }
    }

    fn iterate(&mut self, units: &mut Units, report: &mut WindowReport) -> Result<(), CouplingError> {
        let mut unknowns = self.guess(&report.steps);
        let mut previous: Option<Vec<f64>> = None;
        let mut guard = Guard::default();
        let mut first = None;
        // the iterate with the smallest residual
        let mut best: Option<(f64, Vec<f64>, Vec<f64>)> = None;
        // the scene's acceleration, without its past, where others took over
        let mut own: Option<Acceleration> = None;
        self.acceleration.begin_step();
        if std::mem::replace(&mut self.astray, true) {
            self.restore(units)?;
        } else {
            units.dam.save_state()?;
            units.reservoir.save_state()?;
        }
        let mut iteration = 0;
        let mut left = self.settings.iteration_limit;
        loop {
            iteration += 1;
            // A probe measures the Jacobian and is no iterate of this window.
            let probe = self.acceleration.measuring();
            let Answer { unknowns: answered, displacement } =
                self.evaluate(units, &unknowns, iteration, probe, report)?;
            if !self.settings.kind.is_implicit() {
                if self.settings.kind != SchemeKind::AddedMass {
                    report.residuals =
                        Some(self.residuals(&displacement, None, [&unknowns, &answered], None));
                }
                return self.finish(units, report, true);
            }
            let mut residual: Vec<f64> = answered.iter().zip(&unknowns).map(|(q, p)| q - p).collect();
            if !probe {
                left -= 1;
                let residuals =
                    self.residuals(&displacement, previous.as_deref(), [&unknowns, &answered], first);
                first.get_or_insert(residuals.pressure);
                report.residuals = Some(residuals);
                (report.relaxation, report.secants) =
                    (self.acceleration.relaxation(), self.acceleration.secants());
                if self.measure.converged(&residuals) {
                    // What took over served this window only.
                    if report.fallbacks > 1 {
                        self.acceleration = own.unwrap_or_else(|| self.fresh.clone());
                    }
                    return self.finish(units, report, true);
                }
                previous = Some(displacement);
                if best.as_ref().is_none_or(|(smallest, ..)| residuals.pressure < *smallest) {
                    best = Some((residuals.pressure, unknowns.clone(), residual.clone()));
                }
                let watched = match self.measure.unbounded(&answered) {
                    Some(why) => Err(why),
                    None => guard.observe(residuals.pressure, answered.len(), self.floor),
                };
                if watched.is_err() || left == 0 {
                    let own = own.get_or_insert_with(|| {
                        let mut acceleration = self.acceleration.clone();
                        acceleration.forget();
                        acceleration
                    });
                    let rounding = matches!(watched, Err(Hopeless::RoundingFloor { .. }));
                    let next = own.fallback(report.fallbacks as usize).filter(|_| !rounding);
                    let Some((acceleration, (_, from, of))) = next.zip(best.clone()) else {
                        if report.fallbacks > 0 {
                            self.acceleration = own.clone();
                        }
                        let diverges =
                            matches!(watched, Err(Hopeless::Diverging { .. } | Hopeless::Unbounded { .. }));
                        return match watched {
                            _ if self.settings.accept_unconverged && !diverges => {
                                self.finish(units, report, false)
                            }
                            Err(why) => Err(hopeless(report, iteration, why)),
                            Ok(()) => Err(self.not_converged(report, residuals)),
                        };
                    };
                    report.fallbacks += 1;
                    self.acceleration = acceleration;
                    self.acceleration.begin_step();
                    (unknowns, residual) = (from, of);
                    (guard, left) = (Guard::default(), self.settings.iteration_limit);
                }
            }
            let largest = unknowns.iter().chain(&self.hydrostatic).fold(0.0, |a: f64, b| a.max(b.abs()));
            if self.floor.is_none() && largest > 0.0 && norm(answered.iter().copied()) > 0.0 {
                iteration += 2;
                self.check_states(units, &unknowns, iteration - 1, report)?;
                let change = checks::FLOOR_PROBE * f64::EPSILON * largest;
                self.measure_floor(units, [&unknowns, &residual], change, iteration, report)?;
                self.acceleration.set_floor(self.floor.unwrap_or(0.0));
                self.fresh.set_floor(self.floor.unwrap_or(0.0));
            }
            self.acceleration.accelerate(&mut unknowns, &residual);
            self.restore(units)?;
        }
    }

    /// Accepts the last answer, unless a unit has frozen.
    fn finish(&self, units: &Units, report: &mut WindowReport, converged: bool) -> Result<(), CouplingError> {
        for (side, unit) in [(Side::Dam, &units.dam), (Side::Reservoir, &units.reservoir)] {
            if let Some(steps) = self.frozen[side as usize].frozen(side, report) {
                let (step, time) = (report.step(), report.time());
                let participant = unit.description().name.clone();
                return Err(CouplingError::Frozen { participant, step, time, steps });
            }
        }
        report.converged = converged;
        report.largest_pressure = self.largest_pressure;
        if self.settings.kind != SchemeKind::AddedMass
            && let [interval] = report.steps[..]
        {
            let last = report.iterations();
            let of = |side| report.exchanges.iter().rfind(|e| e.side == side && e.occasion.iteration == last);
            if let Some(reservoir) = of(Side::Reservoir) {
                let pressure = self.pressure(reservoir);
                report.largest_pressure = self.largest_pressure.max(norm(pressure.iter().copied()));
                // The unknowns in the history begin with the pressures, which alone are compared.
                report.interpolation_error =
                    self.predictor.interpolation_error(interval.communication_step, &pressure);
            }
        }
        Ok(())
    }

    fn restore(&self, units: &mut Units) -> Result<(), ParticipantError> {
        units.dam.restore_state()?;
        units.reservoir.restore_state()
    }

    /// Number of unknowns of a step.
    fn unknowns(&self) -> usize {
        let motion =
            if self.settings.kind.is_parallel() { self.channels.reservoir_acceleration.len() } else { 0 };
        self.channels.dam_pressure.len() + motion
    }

    /// The unknowns in an answer of both units.
    fn unknowns_of(&self, dam: &Exchange, reservoir: &Exchange) -> Vec<f64> {
        let mut unknowns = self.pressure(reservoir);
        if self.settings.kind.is_parallel() {
            let mut acceleration = vec![0.0; self.channels.reservoir_acceleration.len()];
            let moved = &dam.outputs[self.channels.dam_acceleration.clone()];
            self.mapping.motion_to_reservoir(moved, &mut acceleration);
            unknowns.extend(acceleration.iter().map(|a| self.settings.acceleration_scale * a));
        }
        unknowns
    }

    /// The pressure that the reservoir answered, at the dam's points.
    fn pressure(&self, reservoir: &Exchange) -> Vec<f64> {
        let mut pressure = vec![0.0; self.channels.dam_pressure.len()];
        let answered = &reservoir.outputs[self.channels.reservoir_pressure.clone()];
        self.mapping.pressure_to_dam(answered, &mut pressure);
        pressure
    }

    /// The first guess of a window's unknowns.
    fn guess(&self, steps: &[Interval]) -> Vec<f64> {
        let (size, start) = (self.unknowns(), steps.first().map_or(0.0, |interval| interval.time));
        let mut unknowns = vec![0.0; size * steps.len()];
        if self.settings.kind != SchemeKind::AddedMass {
            for (interval, values) in steps.iter().zip(unknowns.chunks_mut(size)) {
                let ahead =
                    if interval.time == start { interval.communication_step } else { interval.end() - start };
                self.predictor.predict(ahead, values);
            }
        }
        unknowns
    }

    /// One iteration: G(x).
    fn evaluate(
        &self,
        units: &mut Units,
        unknowns: &[f64],
        iteration: u32,
        probe: bool,
        report: &mut WindowReport,
    ) -> Result<Answer, CouplingError> {
        let this = Iteration {
            channels: &self.channels,
            mapping: &self.mapping,
            hydrostatic: &self.hydrostatic,
            began: self.began,
            steps: &report.steps,
            attempt: report.attempt,
            iteration,
            probe,
        };
        let (from, points) = (report.exchanges.len(), self.channels.dam_pressure.len());
        if self.settings.kind.is_parallel() {
            let steps = || unknowns.chunks(self.unknowns()).map(|step| step.split_at(points));
            let pressure: Vec<f64> = steps().flat_map(|(p, _)| p.iter().copied()).collect();
            let scale = self.settings.acceleration_scale;
            let acceleration: Vec<f64> = steps().flat_map(|(_, a)| a.iter().map(|a| a / scale)).collect();
            this.at_once(units, [&pressure, &acceleration], &mut report.exchanges)?;
        } else {
            this.one_after_the_other(units, unknowns, &mut report.exchanges)?;
        }
        let (dam, reservoir) = report.exchanges[from..].split_at(report.steps.len());
        let answered = dam.iter().zip(reservoir).flat_map(|(dam, water)| self.unknowns_of(dam, water));
        let answered: Vec<f64> = answered.collect();
        let moved = |e: &Exchange| e.outputs[self.channels.dam_displacement.clone()].to_vec();
        let displacement = dam.iter().flat_map(moved).collect();
        if (probe || !self.settings.kind.is_implicit())
            && let Some(why) = self.measure.unbounded(&answered)
        {
            return Err(hopeless(report, iteration, why));
        }
        Ok(Answer { unknowns: answered, displacement })
    }

    /// The residuals of an iteration, the larger of those of pressure and of acceleration where both are unknown.
    fn residuals(
        &self,
        displacement: &[f64],
        previous: Option<&[f64]>,
        [given, answered]: [&[f64]; 2],
        first: Option<f64>,
    ) -> Residuals {
        let points = self.channels.dam_pressure.len();
        let part = |values: &[f64], of_pressure: bool| -> Vec<f64> {
            let steps = values.chunks(self.unknowns()).map(|step| step.split_at(points));
            steps.flat_map(|(p, a)| if of_pressure { p } else { a }).copied().collect()
        };
        let of = |pressure| {
            let (given, answered) = (part(given, pressure), part(answered, pressure));
            self.measure.residuals(displacement, previous, [&given, &answered], first)
        };
        let pressure = of(true);
        if self.settings.kind.is_parallel() { pressure.or_larger(&of(false)) } else { pressure }
    }

    fn not_converged(&self, report: &WindowReport, residuals: Residuals) -> CouplingError {
        CouplingError::NotConverged {
            step: report.step(),
            time: report.time(),
            iterations: self.settings.iteration_limit,
            pressure: residuals.pressure,
            pressure_ratio: residuals.pressure_ratio,
            displacement: residuals.displacement,
            tolerance: self.measure.tolerance,
        }
    }

    /// The interface after exchanges with both units.
    fn at_interface(&self, dam: &Exchange, reservoir: &Exchange) -> Option<AtInterface> {
        let velocity = self.channels.dam_velocity.clone()?;
        let given = match self.settings.kind {
            // It is part of the dam's mass.
            SchemeKind::AddedMass => self.pressure(reservoir),
            _ => dam.inputs[self.channels.dam_pressure.clone()].to_vec(),
        };
        Some(AtInterface {
            given,
            answered: reservoir.outputs[self.channels.reservoir_pressure.clone()].to_vec(),
            told: reservoir.inputs[self.channels.reservoir_acceleration.clone()].to_vec(),
            displacement: dam.outputs[self.channels.dam_displacement.clone()].to_vec(),
            velocity: dam.outputs[velocity].to_vec(),
        })
    }
}

fn hopeless(report: &WindowReport, iteration: u32, why: Hopeless) -> CouplingError {
    CouplingError::Hopeless { step: report.step(), time: report.time(), iteration, why }
}
