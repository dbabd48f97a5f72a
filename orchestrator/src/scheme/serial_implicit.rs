use super::{CouplingError, Exchange, Predictor, Side, StepFailure, StepReport, Units};
use crate::acceleration::Acceleration;
use crate::convergence::{ConvergenceMeasure, Guard};
use crate::participant::{Description, Occasion, Participant, ParticipantError, check_finite};
use std::ops::Range;
use std::time::{Duration, Instant};

/// Gauss–Seidel: in every iteration the dam steps with the guessed pressure, the reservoir
/// with the dam's acceleration, and the answer's difference from the guess moves the guess.
///
/// An iteration is one step of each unit; the confirming one counts.
pub struct SerialImplicit {
    acceleration: Acceleration,
    predictor: Predictor,
    measure: ConvergenceMeasure,
    iteration_limit: u32,
    channels: Channels,
    hydrostatic_pressure: Vec<f64>,
    began: Instant,
}

/// Where the coupled variables lie in requests and answers.
struct Channels {
    dam_pressure: Range<usize>,
    dam_hydrostatic: Range<usize>,
    dam_ground: Range<usize>,
    dam_displacement: Range<usize>,
    dam_acceleration: Range<usize>,
    reservoir_acceleration: Range<usize>,
    reservoir_ground: Range<usize>,
    reservoir_pressure: Range<usize>,
}

impl Channels {
    fn of(dam: &Description, reservoir: &Description) -> Result<Self, ParticipantError> {
        let range = |description: &Description, input: bool, variable: &str| {
            let layout = if input { &description.inputs } else { &description.outputs };
            layout.range(variable).ok_or_else(|| ParticipantError::Missing {
                participant: description.name.clone(),
                variable: variable.to_owned(),
            })
        };
        let points = range(dam, true, "interface_pressure")?.len();
        if points == 0 {
            let (participant, variable) = (dam.name.clone(), "interface_pressure".to_owned());
            return Err(ParticipantError::Missing { participant, variable });
        }
        let find = |description: &Description, input: bool, variable: &str, size: usize| {
            let range = range(description, input, variable)?;
            check_size(description, variable, size, range.len())?;
            Ok::<_, ParticipantError>(range)
        };
        Ok(Self {
            dam_pressure: find(dam, true, "interface_pressure", points)?,
            dam_hydrostatic: find(dam, true, "hydrostatic_pressure", points)?,
            dam_ground: find(dam, true, "ground_acceleration", 2)?,
            dam_displacement: find(dam, false, "interface_displacement", points)?,
            dam_acceleration: find(dam, false, "interface_acceleration", points)?,
            reservoir_acceleration: find(reservoir, true, "interface_acceleration", points)?,
            reservoir_ground: find(reservoir, true, "ground_acceleration", 2)?,
            reservoir_pressure: find(reservoir, false, "interface_pressure", points)?,
        })
    }
}

/// Checks the number of values of a coupled variable.
fn check_size(
    description: &Description,
    variable: &str,
    expected: usize,
    found: usize,
) -> Result<(), ParticipantError> {
    if expected == found {
        return Ok(());
    }
    let (participant, variable) = (description.name.clone(), variable.to_owned());
    Err(ParticipantError::Size { participant, variable, expected, found })
}

impl SerialImplicit {
    /// A scheme for `units`.
    ///
    /// **Errors**: a unit lacks a coupled variable; the interface points of the two differ.
    pub fn new(
        units: &mut Units,
        acceleration: Acceleration,
        predictor: Predictor,
        measure: ConvergenceMeasure,
        iteration_limit: u32,
    ) -> Result<Self, CouplingError> {
        let channels = Channels::of(units.dam.description(), units.reservoir.description())?;
        let coordinates = |unit: &mut dyn Participant| -> Result<Vec<[f64; 2]>, ParticipantError> {
            let (x, y) = (unit.fixed("interface_x")?, unit.fixed("interface_y")?);
            Ok(x.into_iter().zip(y).map(|(x, y)| [x, y]).collect())
        };
        let (dam, reservoir) = (coordinates(&mut *units.dam)?, coordinates(&mut *units.reservoir)?);
        let differs = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]) > 1e-9;
        let beyond = [f64::NAN, f64::NAN];
        let index = dam.iter().zip(&reservoir).position(differs);
        let index = index.or_else(|| (dam.len() != reservoir.len()).then(|| dam.len().min(reservoir.len())));
        if let Some(index) = index {
            let [dam_x, dam_y] = *dam.get(index).unwrap_or(&beyond);
            let [reservoir_x, reservoir_y] = *reservoir.get(index).unwrap_or(&beyond);
            return Err(CouplingError::Interface { index, dam_x, dam_y, reservoir_x, reservoir_y });
        }
        Ok(Self {
            acceleration,
            predictor,
            measure,
            iteration_limit,
            channels,
            hydrostatic_pressure: Vec::new(),
            began: Instant::now(),
        })
    }

    /// Initialises both units at `time` (s): the reservoir first, whose hydrostatic pressure loads the dam.
    pub fn initialise(
        &mut self,
        units: &mut Units,
        time: f64,
        ground_acceleration: [f64; 2],
    ) -> Result<StepReport, StepFailure> {
        self.began = Instant::now();
        let report = empty_report(0, time, 0.0, ground_acceleration);
        self.reported(units, report, Self::initialise_into)
    }

    fn initialise_into(&mut self, units: &mut Units, report: &mut StepReport) -> Result<(), CouplingError> {
        let occasion = report.occasion(0);
        let mut inputs = vec![0.0; units.reservoir.description().inputs.size()];
        inputs[self.channels.reservoir_ground.clone()].copy_from_slice(&report.ground_acceleration);
        self.exchange(&mut *units.reservoir, Side::Reservoir, occasion, inputs, report)?;
        self.hydrostatic_pressure = units.reservoir.fixed("hydrostatic_pressure")?;
        let (points, found) = (self.channels.dam_pressure.len(), self.hydrostatic_pressure.len());
        check_size(units.reservoir.description(), "hydrostatic_pressure", points, found)?;
        let pressure = vec![0.0; points];
        let inputs = self.dam_inputs(&*units.dam, &pressure, report.ground_acceleration);
        self.exchange(&mut *units.dam, Side::Dam, occasion, inputs, report)?;
        report.exchanges.iter_mut().for_each(|e| e.accepted = true);
        self.predictor.accept(&pressure);
        Ok(())
    }

    /// Takes step number `step` from `time` (s), repeated until it converges.
    ///
    /// **Errors**: a unit fails, or the iterations run out; either comes with the exchanges so far.
    pub fn advance(
        &mut self,
        units: &mut Units,
        step: u64,
        time: f64,
        communication_step: f64,
        ground_acceleration: [f64; 2],
    ) -> Result<StepReport, StepFailure> {
        let report = empty_report(step, time, communication_step, ground_acceleration);
        self.reported(units, report, Self::iterate)
    }

    /// Fills `report` by `call`, and adds what the units themselves have to report.
    fn reported(
        &mut self,
        units: &mut Units,
        mut report: StepReport,
        call: impl FnOnce(&mut Self, &mut Units, &mut StepReport) -> Result<(), CouplingError>,
    ) -> Result<StepReport, StepFailure> {
        let before = [units.dam.busy(), units.reservoir.busy()];
        let result = call(self, units, &mut report);
        report.solver_time =
            [units.dam.busy().saturating_sub(before[0]), units.reservoir.busy().saturating_sub(before[1])];
        report.messages = [units.dam.messages(), units.reservoir.messages()].concat();
        match result {
            Ok(()) => Ok(report),
            Err(error) => Err(StepFailure { report: Box::new(report), error }),
        }
    }

    fn iterate(&mut self, units: &mut Units, report: &mut StepReport) -> Result<(), CouplingError> {
        let ground = report.ground_acceleration;
        let mut pressure = vec![0.0; self.hydrostatic_pressure.len()];
        let mut previous_displacement: Option<Vec<f64>> = None;
        let mut guard = Guard::default();
        let mut first = None;
        self.predictor.predict(&mut pressure);
        self.acceleration.begin_step();
        units.dam.save_state()?;
        units.reservoir.save_state()?;
        let mut iteration = 0;
        let mut left = self.iteration_limit;
        while left > 0 {
            iteration += 1;
            // A probe answers for the Jacobian, not for this step.
            let probe = self.acceleration.measuring();
            left -= u32::from(!probe);
            if iteration > 1 {
                units.dam.restore_state()?;
                units.reservoir.restore_state()?;
            }
            let inputs = self.dam_inputs(&*units.dam, &pressure, ground);
            let occasion = report.occasion(iteration);
            let dam = self.exchange(&mut *units.dam, Side::Dam, occasion, inputs, report)?;
            let moved = &report.exchanges[dam].outputs;
            let displacement = moved[self.channels.dam_displacement.clone()].to_vec();
            let mut inputs = vec![0.0; units.reservoir.description().inputs.size()];
            inputs[self.channels.reservoir_acceleration.clone()]
                .copy_from_slice(&moved[self.channels.dam_acceleration.clone()]);
            inputs[self.channels.reservoir_ground.clone()].copy_from_slice(&ground);
            let water = self.exchange(&mut *units.reservoir, Side::Reservoir, occasion, inputs, report)?;

            let answered = &report.exchanges[water].outputs[self.channels.reservoir_pressure.clone()];
            let residuals = self.measure.residuals(
                &displacement,
                previous_displacement.as_deref(),
                [&pressure, answered],
                first,
            );
            first.get_or_insert(residuals.pressure);
            report.residuals = Some(residuals);
            report.relaxation = self.acceleration.relaxation();
            let hopeless = |why| {
                let (step, time) = (report.step, report.time);
                CouplingError::Hopeless { step, time, iteration, why }
            };
            if let Some(why) = self.measure.unbounded(answered) {
                return Err(hopeless(why));
            }
            if !probe && self.measure.converged(&residuals) {
                self.predictor.accept(answered);
                report.exchanges[dam].accepted = true;
                report.exchanges[water].accepted = true;
                return Ok(());
            }
            if !probe && let Err(why) = guard.observe(residuals.pressure, answered.len()) {
                return Err(hopeless(why));
            }
            let residual: Vec<f64> = answered.iter().zip(&pressure).map(|(q, p)| q - p).collect();
            self.acceleration.accelerate(&mut pressure, &residual);
            if !probe {
                previous_displacement = Some(displacement);
            }
        }
        let residuals = report.residuals.unwrap_or(self.measure.residuals(&[], None, [&[], &[]], None));
        Err(CouplingError::NotConverged {
            step: report.step,
            time: report.time,
            iterations: iteration,
            pressure: residuals.pressure,
            pressure_ratio: residuals.pressure_ratio,
            displacement: residuals.displacement,
            tolerance: self.measure.tolerance,
        })
    }

    fn dam_inputs(&self, dam: &dyn Participant, pressure: &[f64], ground_acceleration: [f64; 2]) -> Vec<f64> {
        let mut inputs = vec![0.0; dam.description().inputs.size()];
        inputs[self.channels.dam_pressure.clone()].copy_from_slice(pressure);
        inputs[self.channels.dam_hydrostatic.clone()].copy_from_slice(&self.hydrostatic_pressure);
        inputs[self.channels.dam_ground.clone()].copy_from_slice(&ground_acceleration);
        inputs
    }

    /// Initialises a unit (step 0) or lets it step, and adds the exchange to the report; returns its index there.
    fn exchange(
        &self,
        unit: &mut dyn Participant,
        side: Side,
        occasion: Occasion,
        inputs: Vec<f64>,
        report: &mut StepReport,
    ) -> Result<usize, CouplingError> {
        let mut outputs = vec![0.0; unit.description().outputs.size()];
        let sent = self.began.elapsed();
        let result = match occasion.step {
            0 => unit.initialise(occasion.time, &inputs, &mut outputs),
            _ => unit.step(&occasion, &inputs, &mut outputs),
        };
        let answered = self.began.elapsed();
        let result = result.and_then(|()| {
            check_finite(unit.description(), &outputs, occasion.time + occasion.communication_step)
        });
        // What a unit that failed left there is no answer; one that is not finite is.
        if result.as_ref().is_err_and(|e| !matches!(e, ParticipantError::NonFinite { .. })) {
            outputs.clear();
        }
        let iteration = occasion.iteration;
        report.exchanges.push(Exchange { side, iteration, accepted: false, inputs, outputs, sent, answered });
        match result {
            Ok(()) => Ok(report.exchanges.len() - 1),
            Err(cause @ ParticipantError::NonFinite { .. })
                if iteration > 1 && !self.acceleration.measuring() =>
            {
                let Occasion { step, time, .. } = occasion;
                Err(CouplingError::BlewUp { step, time, iteration, cause })
            }
            Err(error) => Err(error.into()),
        }
    }
}

fn empty_report(step: u64, time: f64, communication_step: f64, ground_acceleration: [f64; 2]) -> StepReport {
    StepReport {
        step,
        attempt: 1,
        time,
        communication_step,
        ground_acceleration,
        exchanges: Vec::new(),
        residuals: None,
        relaxation: 1.0,
        solver_time: [Duration::ZERO; 2],
        messages: Vec::new(),
    }
}
