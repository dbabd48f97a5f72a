//! The iteration of a window: guess, evaluate, judge, correct.

use super::{Answer, Scheme, checks};
use crate::acceleration::Acceleration;
use crate::convergence::{Guard, IterationFailure, IterationInfo, Residuals, norm};
use crate::scheme::evaluation::Iteration;
use crate::scheme::{
    CouplingError, Exchange, Graph, IterationReport, Purpose, SchemeKind, UnitId, WindowReport, WorstPoint,
};

impl Scheme {
    pub(super) fn iterate(
        &mut self,
        graph: &mut Graph,
        report: &mut WindowReport,
    ) -> Result<(), CouplingError> {
        let mut unknowns = self.guess(&report.steps);
        let mut previous: Option<Vec<f64>> = None;
        let mut guard = Guard::default();
        let mut first = None;
        // the iterate with the smallest residual
        let mut best: Option<(f64, Vec<f64>, Vec<f64>)> = None;
        // the chosen acceleration, without its past, where others took over
        let mut own: Option<Acceleration> = None;
        self.memory.acceleration.begin_step();
        if std::mem::replace(&mut self.astray, true) {
            self.restore(graph)?;
        } else {
            graph.units_mut().try_for_each(|unit| unit.save_state())?;
        }
        let mut iteration = 0;
        let mut left = self.settings.iteration_limit;
        loop {
            iteration += 1;
            // A probe measures the Jacobian and is no iterate of this window.
            let probe = self.memory.acceleration.measuring();
            let purpose = if probe { Purpose::Jacobian } else { Purpose::Solution };
            let Answer { unknowns: answered, monitored } =
                self.evaluate(graph, &unknowns, iteration, purpose, report)?;
            if !self.settings.kind.is_implicit() {
                if self.settings.kind != SchemeKind::OneWay && !self.open_loop {
                    let residuals = self.residuals(report, &monitored, None, [&unknowns, &answered], None);
                    self.compared(report, residuals, [&unknowns, &answered]);
                }
                return self.finish(graph, report, true, "not repeated: the scheme is explicit");
            }
            let mut residual: Vec<f64> = answered.iter().zip(&unknowns).map(|(q, p)| q - p).collect();
            if !probe {
                left -= 1;
                let (before, both) = (previous.as_deref(), [&unknowns[..], &answered]);
                let residuals = self.residuals(report, &monitored, before, both, first);
                first.get_or_insert(residuals.norm);
                self.compared(report, residuals, [&unknowns, &answered]);
                if self.measure.converged(&residuals) {
                    // What took over served this window only.
                    if report.fallbacks > 1 {
                        self.memory.acceleration = own.unwrap_or_else(|| self.memory.fresh.clone());
                    }
                    return self.finish(graph, report, true, "converged");
                }
                previous = Some(monitored);
                if best.as_ref().is_none_or(|(smallest, ..)| residuals.norm < *smallest) {
                    best = Some((residuals.norm, unknowns.clone(), residual.clone()));
                }
                let watched = match self.measure.unbounded(&answered) {
                    Some(why) => Err(why),
                    None => guard.observe(residuals.norm, answered.len(), self.memory.floor),
                };
                if watched.is_err() || left == 0 {
                    let own = own.get_or_insert_with(|| {
                        let mut acceleration = self.memory.acceleration.clone();
                        acceleration.forget();
                        acceleration
                    });
                    let rounding = matches!(watched, Err(IterationFailure::RoundingFloor { .. }));
                    let next = own.fallback(report.fallbacks as usize).filter(|_| !rounding);
                    let Some((acceleration, (_, from, of))) = next.zip(best.clone()) else {
                        if report.fallbacks > 0 {
                            self.memory.acceleration = own.clone();
                        }
                        let diverges = matches!(
                            watched,
                            Err(IterationFailure::Diverging { .. } | IterationFailure::Unbounded { .. })
                        );
                        return match watched {
                            _ if self.settings.accept_unconverged && !diverges => {
                                let why = match watched {
                                    Err(why) => why.in_unit(&self.unit),
                                    Ok(()) => "reached the iteration limit".to_owned(),
                                };
                                self.finish(graph, report, false, &format!("accepted unconverged: {why}"))
                            }
                            Err(why) => Err(self.futile(report, iteration, why)),
                            Ok(()) => Err(self.not_converged(report, residuals)),
                        };
                    };
                    report.fallbacks += 1;
                    self.memory.acceleration = acceleration;
                    self.memory.acceleration.begin_step();
                    (unknowns, residual) = (from, of);
                    (guard, left) = (Guard::default(), self.settings.iteration_limit);
                }
            }
            let constant = self.links.iter().flat_map(|link| &link.constant);
            let largest = unknowns.iter().chain(constant).fold(0.0, |a: f64, b| a.max(b.abs()));
            if self.memory.floor.is_none() && largest > 0.0 && norm(answered.iter().copied()) > 0.0 {
                iteration += 2;
                self.check_states(graph, &unknowns, iteration - 1, report)?;
                let change = checks::FLOOR_PROBE * f64::EPSILON * largest;
                self.measure_floor(graph, [&unknowns, &residual], change, iteration, report)?;
                self.memory.acceleration.set_floor(self.memory.floor.unwrap_or(0.0));
                self.memory.fresh.set_floor(self.memory.floor.unwrap_or(0.0));
            }
            self.accelerate(&mut unknowns, &residual);
            self.restore(graph)?;
        }
    }

    /// Accepts the last answer, unless a unit has frozen.
    pub(super) fn finish(
        &self,
        graph: &Graph,
        report: &mut WindowReport,
        converged: bool,
        outcome: &str,
    ) -> Result<(), CouplingError> {
        for id in &self.order {
            if let Some(steps) = self.memory.frozen[id.0].frozen(*id, report) {
                let (step, time) = (report.step(), report.time());
                let participant = graph[*id].description().name.clone();
                return Err(CouplingError::Frozen { participant, step, time, steps });
            }
        }
        report.converged = converged;
        outcome.clone_into(&mut report.outcome);
        report.largest = self.memory.largest;
        if self.settings.kind != SchemeKind::OneWay && report.steps.len() == 1 {
            let last = report.iterations();
            let of =
                |id| report.exchanges.iter().rfind(|e| e.unit == UnitId(id) && e.occasion.iteration == last);
            if let Some(answers) = (0..self.templates.len()).map(of).collect::<Option<Vec<_>>>() {
                let backward = self.backward(&answers);
                report.largest = self.memory.largest.max(norm(backward.iter().copied()));
                report.interpolation_error = self.interpolation_error(report, &backward);
            }
        }
        Ok(())
    }

    /// Error of values that are linear within the step, of a window of one step that ends with `unknowns`.
    pub(super) fn interpolation_error(&self, report: &WindowReport, unknowns: &[f64]) -> Option<f64> {
        let [interval] = report.steps[..] else { return None };
        // The unknowns begin with the backward fields, which alone are compared.
        let backward = &unknowns[..self.backward_values()];
        self.memory.predictor.interpolation_error(interval.communication_step, backward)
    }

    /// One iteration: G(x).
    pub(super) fn evaluate(
        &self,
        graph: &mut Graph,
        unknowns: &[f64],
        iteration: u32,
        purpose: Purpose,
        report: &mut WindowReport,
    ) -> Result<Answer, CouplingError> {
        let probe = purpose != Purpose::Solution;
        let correction = self.memory.acceleration.correction();
        let (residuals, worst) = (None, None);
        report.iterates.push(IterationReport { iteration, purpose, correction, residuals, worst });
        let this = Iteration {
            links: &self.links,
            templates: &self.templates,
            signals: &self.signals,
            order: &self.order,
            began: self.began,
            steps: &report.steps,
            attempt: report.attempt,
            iteration,
            probe,
        };
        let from = report.exchanges.len();
        let given = self.given(unknowns);
        if self.settings.kind.is_parallel() {
            this.at_once(graph, &given, &mut report.exchanges)?;
        } else {
            this.one_after_the_other(graph, given.backward, &mut report.exchanges)?;
        }
        let (mut answered, mut monitored) = (Vec::with_capacity(unknowns.len()), Vec::new());
        for index in 0..report.steps.len() {
            let of = |id| report.exchanges[from..].iter().filter(move |e| e.unit == UnitId(id)).nth(index);
            let answers: Vec<&Exchange> = (0..self.templates.len()).filter_map(of).collect();
            answered.extend(self.unknowns_of(&answers));
            for link in &self.links {
                monitored.extend_from_slice(link.monitored(answers[link.first().0]));
            }
        }
        if (probe || !self.settings.kind.is_implicit())
            && let Some(why) = self.measure.unbounded(&answered)
        {
            return Err(self.futile(report, iteration, why));
        }
        Ok(Answer { unknowns: answered, monitored })
    }

    /// The residuals of an iteration, the larger of those of backward and of forward fields where both are unknown.
    pub(super) fn residuals(
        &self,
        report: &WindowReport,
        monitored: &[f64],
        previous: Option<&[f64]>,
        [given, answered]: [&[f64]; 2],
        first: Option<f64>,
    ) -> Residuals {
        let size = self.backward_values();
        let part = |values: &[f64], backward: bool| -> Vec<f64> {
            let steps = values.chunks(self.unknowns()).map(|step| step.split_at(size));
            steps.flat_map(|(p, a)| if backward { p } else { a }).copied().collect()
        };
        let step_error = self.interpolation_error(report, answered);
        let known = IterationInfo { first, step_error, largest: self.memory.largest };
        let of = |backward| {
            let (given, answered) = (part(given, backward), part(answered, backward));
            self.measure.residuals(monitored, previous, [&given, &answered], known)
        };
        let backward = of(true);
        if self.settings.kind.is_parallel() { backward.or_larger(&of(false)) } else { backward }
    }

    /// Adds to the last iteration how far its answer is from its guess, and where it is farthest.
    pub(super) fn compared(
        &self,
        report: &mut WindowReport,
        residuals: Residuals,
        [given, answered]: [&[f64]; 2],
    ) {
        let farther = |best: Option<(f64, usize)>, place: usize| {
            let far = (answered[place] - given[place]).abs();
            if best.is_none_or(|(farthest, _)| far > farthest) { Some((far, place)) } else { best }
        };
        let (size, compared) = (self.unknowns(), self.backward_values());
        let places = (0..given.len()).filter(|place| place % size < compared);
        let worst = places.fold(None, farther).map(|(_, place)| {
            let (mut interface, mut point) = (0, place % size);
            while point >= self.links[interface].received()[0] {
                point -= self.links[interface].received()[0];
                interface += 1;
            }
            let step = report.step() + (place / size) as u64;
            WorstPoint { step, interface, point, given: given[place], answered: answered[place] }
        });
        if let Some(iterate) = report.iterates.last_mut() {
            (iterate.residuals, iterate.worst) = (Some(residuals), worst);
        }
    }

    pub(super) fn not_converged(&self, report: &WindowReport, residuals: Residuals) -> CouplingError {
        CouplingError::NotConverged {
            step: report.step(),
            time: report.time(),
            iterations: self.settings.iteration_limit,
            residual: residuals.norm,
            unit: self.unit.clone(),
            relative_ratio: residuals.relative_ratio,
            change: residuals.change,
            tolerance: self.measure.tolerance,
        }
    }

    pub(super) fn futile(
        &self,
        report: &WindowReport,
        iteration: u32,
        why: IterationFailure,
    ) -> CouplingError {
        CouplingError::Futile {
            step: report.step(),
            time: report.time(),
            iteration,
            why,
            unit: self.unit.clone(),
        }
    }
}
