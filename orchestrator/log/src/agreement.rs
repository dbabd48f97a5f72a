//! How far apart the accepted values of two runs are, and where they part.

use super::common_variable::{CommonVariable, Kind, common_variables};
use super::{AcceptedStep, AcceptedSteps, KeyDifference, Log, LogReadError, settings};
use std::cmp::Ordering;

/// How far two runs agree.
///
/// Compared are the accepted values at ends of steps that both runs have, whatever their steps and iterations were.
/// The difference of a variable at such an end is max |aᵢ − bᵢ| over its values i, relative to the largest |aᵢ|, |bᵢ|
/// over i and all compared ends. What is left over of larger terms is measured by those: `energy_balance_error` by
/// `input_work`. What a unit was asked counts where no unit answers such a variable. Outputs that jump (numbers of contacts, places of extremes) are not measured.
#[derive(Debug)]
pub struct Agreement {
    /// Differences of the settings.
    pub settings: Vec<KeyDifference>,
    /// What is in one log only, in words.
    pub apart: Vec<String>,
    /// Accepted steps of each log that were read, initialisation included.
    pub steps: [u64; 2],
    /// The ends of steps that were compared.
    pub ends: Vec<End>,
    /// The variables that are measured.
    pub variables: Vec<Measured>,
    /// Where discrete events differ for the first time.
    pub events: Events,
    /// How both logs end; `None` if the end was not reached.
    pub endings: [Option<String>; 2],
    /// Why a log could not be read further.
    pub error: Option<LogReadError>,
}

/// An end of a step that both runs have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct End {
    /// Number of the step in each log.
    pub steps: [u64; 2],
    /// The end, s.
    pub time: f64,
}

/// A variable and its differences.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The variable.
    pub variable: CommonVariable,
    /// Largest magnitude in the run, by which differences are measured; 0 if all values are 0.
    pub scale: f64,
    /// Largest difference at each compared end, and at which value of an array.
    pub differences: Vec<(f64, usize)>,
}

/// The first place where a discrete event of two runs differs.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// What differs, such as `dam.crack_slipping[0]`.
    pub what: String,
    /// What it is in each log.
    pub values: [String; 2],
    /// The compared end.
    pub end: usize,
}

/// Variables that are what is left over of larger ones, and the ones by which they are measured.
const REMAINDERS: [(&str, &str); 1] = [("energy_balance_error", "input_work")];

/// Times and lengths that differ by less than this share of a step are the same.
pub const ROUNDING: f64 = 1e-6;

impl Measured {
    /// The difference at a compared end, over the scale.
    pub fn relative(&self, end: usize) -> f64 {
        match self.differences[end].0 {
            0.0 => 0.0,
            difference => difference / self.scale,
        }
    }

    /// The compared end of the largest difference.
    pub fn worst(&self) -> usize {
        let larger = |best: usize, end: usize| {
            if self.differences[end].0 > self.differences[best].0 { end } else { best }
        };
        (0..self.differences.len()).fold(0, larger)
    }

    fn measure(&mut self, steps: [&AcceptedStep; 2]) {
        let [a, b] = [0, 1].map(|log| self.variable.values(log, &steps[log].exchanges));
        let mut largest = (0.0, 0);
        for (index, (a, b)) in a.iter().zip(b).enumerate() {
            self.scale = self.scale.max(a.abs()).max(b.abs());
            let difference = if a.to_bits() == b.to_bits() { 0.0 } else { (a - b).abs() };
            let difference = if difference.is_nan() { f64::INFINITY } else { difference };
            if difference > largest.0 {
                largest = (difference, index);
            }
        }
        self.differences.push(largest);
    }
}

impl Agreement {
    /// Compares two logs to the end of the shorter one, or to where one is cut short or damaged.
    ///
    /// **Errors**: a log can no longer be opened.
    pub fn of(logs: [&Log; 2]) -> Result<Self, LogReadError> {
        let (common, apart) = common_variables(logs.map(Log::head));
        let (gradual, other): (Vec<_>, Vec<_>) = common.into_iter().partition(|v| v.kind == Kind::Gradual);
        let contacts: Vec<_> = other.into_iter().filter(|v| v.kind == Kind::Contacts).collect();
        let measured = |variable| Measured { variable, scale: 0.0, differences: Vec::new() };
        let mut agreement = Self {
            settings: settings(logs),
            apart,
            steps: [0, 0],
            ends: Vec::new(),
            variables: gradual.into_iter().map(measured).collect(),
            events: Events::default(),
            endings: [None, None],
            error: None,
        };
        let mut steps = [AcceptedSteps::of(logs[0])?, AcceptedSteps::of(logs[1])?];
        if let Err(error) = agreement.walk(&mut steps, &contacts) {
            agreement.error = Some(error);
        }
        agreement.endings = steps.map(|steps| steps.ending().map(str::to_owned));
        agreement.measure_remainders();
        Ok(agreement)
    }

    fn walk(
        &mut self,
        steps: &mut [AcceptedSteps; 2],
        contacts: &[CommonVariable],
    ) -> Result<(), LogReadError> {
        let [first, second] = steps;
        let mut next = [first.next().transpose()?, second.next().transpose()?];
        while let [Some(a), Some(b)] = &next {
            let ends = [a, b].map(|step| step.step.occasion.end());
            let lengths = [a, b].map(|step| step.step.occasion.communication_step);
            let together = (ends[0] - ends[1]).abs() <= ROUNDING * lengths[0].min(lengths[1]);
            let order = if together { Ordering::Equal } else { ends[0].total_cmp(&ends[1]) };
            if order.is_eq() {
                let end = self.ends.len();
                self.ends.push(End { steps: [a, b].map(|s| s.step.occasion.step), time: ends[0] });
                self.variables.iter_mut().for_each(|measured| measured.measure([a, b]));
                self.events.compare(end, [a, b], contacts);
            }
            if order.is_le() {
                self.steps[0] += 1;
                next[0] = first.next().transpose()?;
            }
            if order.is_ge() {
                self.steps[1] += 1;
                next[1] = second.next().transpose()?;
            }
        }
        // To the end, so that it is known how many steps each has.
        for (log, (steps, next)) in steps.iter_mut().zip(next).enumerate() {
            self.steps[log] += u64::from(next.is_some());
            for step in steps {
                step?;
                self.steps[log] += 1;
            }
        }
        Ok(())
    }

    fn measure_remainders(&mut self) {
        for (remainder, whole) in REMAINDERS {
            let scales: Vec<_> = self.variables.iter().map(|m| (m.variable.name.clone(), m.scale)).collect();
            for measured in &mut self.variables {
                let Some((unit, name)) = measured.variable.name.split_once('.') else { continue };
                let whole = scales.iter().find(|(name, _)| *name == format!("{unit}.{whole}"));
                if let Some((_, scale)) = whole.filter(|_| name == remainder) {
                    measured.scale = measured.scale.max(*scale);
                }
            }
        }
    }

    /// The variable with the largest relative difference at a compared end, and this difference.
    pub fn largest(&self, end: usize) -> Option<(&Measured, f64)> {
        let relative = self.variables.iter().map(|measured| (measured, measured.relative(end)));
        relative.max_by(|(_, a), (_, b)| a.total_cmp(b))
    }

    /// The first compared end at which the relative difference of a variable exceeds `tolerance`.
    pub fn first_beyond(&self, tolerance: f64) -> Option<usize> {
        (0..self.ends.len()).find(|end| self.largest(*end).is_some_and(|(_, relative)| relative > tolerance))
    }

    /// The compared ends at which the largest relative difference so far enters another power of ten.
    pub fn decades(&self) -> Vec<usize> {
        let mut highest = f64::NEG_INFINITY;
        let enters = |end: &usize| {
            let decade = self.largest(*end).map_or(0.0, |(_, relative)| relative).log10().floor();
            let enters = decade > highest;
            highest = highest.max(decade);
            enters
        };
        (0..self.ends.len()).filter(enters).collect()
    }
}

/// The first difference of each kind of discrete event.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Events {
    /// Lengths of steps that end together.
    pub length: Option<Event>,
    /// Number of iterations, or whether they converged.
    pub iterations: Option<Event>,
    /// Numbers of sticking, slipping, open contacts of a crack.
    pub contacts: Option<Event>,
}

impl Events {
    fn compare(&mut self, end: usize, steps: [&AcceptedStep; 2], contacts: &[CommonVariable]) {
        let Self { length, iterations, contacts: states } = self;
        let [a, b] = steps.map(|step| &step.step);
        if length.is_none() {
            let [a, b] = [a, b].map(|step| step.occasion.communication_step);
            *length = ((a - b).abs() > ROUNDING * a.min(b)).then(|| Event {
                what: "length of the step".to_owned(),
                values: [a, b].map(|length| format!("{length} s")),
                end,
            });
        }
        if iterations.is_none() {
            let of = [a, b].map(|step| (step.occasion.iteration, step.converged));
            *iterations = (of[0] != of[1]).then(|| Event {
                what: "iterations".to_owned(),
                values: of.map(|(count, converged)| {
                    format!("{count}{}", if converged { "" } else { ", NOT CONVERGED" })
                }),
                end,
            });
        }
        if states.is_none() {
            *states = contacts.iter().find_map(|variable| {
                let [a, b] = [0, 1].map(|log| variable.values(log, &steps[log].exchanges));
                let crack = a.iter().zip(b).position(|(a, b)| a != b)?;
                let values = [a[crack], b[crack]].map(|count| format!("{count}"));
                Some(Event { what: format!("{}[{crack}]", variable.name), values, end })
            });
        }
    }
}
