use crate::log::scene_of;
use crate::units::DAM;
use cofferdam_coupling::participant::{
    Channel, ChannelShape, Description, Layout, Occasion, Participant, ParticipantError,
};
use cofferdam_coupling::scheme::{SchemeKind, UnitId};
use cofferdam_log::{Entry, Log, LogReadError, LoggedExchange};
use cofferdam_unit::Role;
use cofferdam_unit::{Capabilities, Fingerprint, StateError, WetFace, open, seal};
use std::path::PathBuf;

/// A unit of a run of the past: it answers what it answered then, whatever it is asked now.
///
/// What a fluid answers is the pressure that was *given* to the structure in each accepted step, so that the same structure
/// moves as it did then, bit for bit: within the tolerance of that run the fluid had answered the same. A structure gives its
/// answers; its acceleration is that which was given to the fluid.
#[derive(Debug)]
pub struct Recorded {
    description: Description,
    face: WetFace,
    path: PathBuf,
    hydrostatic: Vec<f64>,
    /// Of each step from 1: start (s), length (s) and answer.
    steps: Vec<(f64, f64, Vec<f64>)>,
    /// The answer at initialisation.
    first: Vec<f64>,
}

/// Which unit of a log.
#[derive(Clone, Debug)]
pub struct Recording {
    /// The unit that is recorded.
    pub unit: UnitId,
    /// Its name.
    pub name: &'static str,
    /// Its kind.
    pub role: Role,
    /// What the names of the structure's variables at the interface begin with.
    pub prefix: &'static str,
    /// The structure's wet face at that time.
    pub face: WetFace,
}

/// Why a log cannot take the place of a unit.
#[derive(Debug, thiserror::Error)]
pub enum RecordedError {
    /// It cannot be read.
    #[error(transparent)]
    Log(#[from] LogReadError),
    /// The run had other units.
    #[error("{path}: that run had no unit called `{name}`", path = path.display())]
    NoUnit {
        /// The log.
        path: PathBuf,
        /// Name of the unit.
        name: String,
    },
    /// A unit that did not exchange what is needed.
    #[error("{path}: `{unit}` has no `{variable}` at the {expected} points of its wet face in that run", path = path.display())]
    NoVariable {
        /// The log.
        path: PathBuf,
        /// Name of the unit.
        unit: String,
        /// The variable.
        variable: String,
        /// Number of points.
        expected: usize,
    },
    /// The water was part of the dam.
    #[error(
        "{path}: in that run the water's mass was in the dam's mass matrix, and no pressure was given to the dam; repeat it with \
         --set coupling.scheme='\"serial-implicit\"'", path = path.display()
    )]
    InMass {
        /// The log.
        path: PathBuf,
    },
    /// The run was shorter.
    #[error("{path}: it ends at t = {end} s, and the run is to last {asked} s; set `time.duration` to {end} or less", path = path.display())]
    TooShort {
        /// The log.
        path: PathBuf,
        /// End of its last accepted step, s.
        end: f64,
        /// Duration of the run, s.
        asked: f64,
    },
    /// The run took other steps.
    #[error(
        "{path}: its step {step} goes from t = {start} s on for {length} s, where one of {asked} s from t = {time} s is to be taken; set \
         `time.communication_step` to that of the log", path = path.display()
    )]
    Steps {
        /// The log.
        path: PathBuf,
        /// Number of the step.
        step: u64,
        /// Its start in the log, s.
        start: f64,
        /// Its length in the log, s.
        length: f64,
        /// Length that is asked for, s.
        asked: f64,
        /// Start that is asked for, s.
        time: f64,
    },
    /// It cannot be hashed.
    #[error(transparent)]
    State(#[from] StateError),
}

impl Recorded {
    /// Reads what is needed of `log`, up to its end or where it is cut short.
    ///
    /// **Errors**: [`RecordedError`].
    pub fn read(log: &Log, recording: Recording) -> Result<Self, RecordedError> {
        let Recording { unit, name, role, prefix, face } = recording;
        let (path, head) = (log.path().to_owned(), log.head());
        if role == Role::Fluid && scene_of(log)?.scheme() == SchemeKind::OneWay {
            return Err(RecordedError::InMass { path });
        }
        let number = |wanted: &str| head.units.iter().position(|logged| logged.name == wanted).map(UnitId);
        let missing = |name: &str| RecordedError::NoUnit { path: path.clone(), name: name.to_owned() };
        let structure = DAM;
        let own = number(name).ok_or_else(|| missing(name))?;
        let dam = head.units.get(structure.0).ok_or_else(|| missing("dam"))?;
        let points = face.len();
        let find = |layout: &Layout, variable: String| {
            layout.range(&variable).filter(|range| range.len() == points).ok_or_else(|| {
                RecordedError::NoVariable {
                    path: path.clone(),
                    unit: dam.name.clone(),
                    variable,
                    expected: points,
                }
            })
        };
        let of_dam = |name: &str| format!("{prefix}{name}");
        let channel = |name: &str, shape, size| {
            let known = role.variables().iter().find(|variable| variable.name == name);
            Channel {
                name: name.to_owned(),
                value_reference: known.map_or(0, |variable| variable.value_reference),
                unit: known.map_or("", |variable| variable.unit).to_owned(),
                size,
                shape: known.map_or(shape, |variable| variable.shape.into()),
            }
        };
        let on_face = |name| channel(name, ChannelShape::WetFace, points);
        let ground = channel("ground_acceleration", ChannelShape::Plane, 2);
        let coordinates = [on_face("interface_x"), on_face("interface_y")];
        let (inputs, outputs, readable) = match role {
            Role::Fluid => (
                vec![on_face("interface_acceleration"), ground],
                Layout::new(vec![on_face("interface_pressure")]),
                coordinates.into_iter().chain([on_face("hydrostatic_pressure")]).collect(),
            ),
            Role::Structure => (
                vec![on_face("interface_pressure"), on_face("hydrostatic_pressure"), ground],
                // A log does not tell the kinds of its arrays.
                Layout::new(dam.outputs.channels().map(|(c, _)| channel(&c.name, c.shape, c.size)).collect()),
                coordinates.to_vec(),
            ),
        };
        let mut recorded = Self {
            description: Description {
                name: name.to_owned(),
                solver: format!(
                    "{} of {}: open loop, nothing is iterated",
                    head.units[own.0].solver,
                    path.display()
                ),
                fingerprint: Fingerprint::of(
                    "log",
                    &(&head.units[own.0].fingerprint, &head.scene_text, unit.0),
                )?,
                inputs: Layout::new(inputs),
                outputs,
                readable: Layout::new(readable),
                capabilities: Capabilities {
                    variable_communication_step: true,
                    directional_derivative: false,
                    saved_state: true,
                },
            },
            face,
            path: path.clone(),
            hydrostatic: vec![0.0; points],
            steps: Vec::new(),
            first: Vec::new(),
        };
        match role {
            Role::Fluid => {
                let pressure = find(&dam.inputs, of_dam("interface_pressure"))?;
                let hydrostatic = find(&dam.inputs, of_dam("hydrostatic_pressure"))?;
                each_accepted(log, |exchange| {
                    if exchange.unit == structure {
                        recorded.hydrostatic.copy_from_slice(&exchange.inputs[hydrostatic.clone()]);
                        recorded.add(&exchange.occasion, exchange.inputs[pressure.clone()].to_vec());
                    }
                })?;
            }
            Role::Structure => {
                find(&dam.inputs, of_dam("interface_pressure"))?;
                let acceleration = find(&dam.outputs, of_dam("interface_acceleration"))?;
                // Where the points are the same, what was given to the fluid; a parallel scheme gave its guess.
                let fluid = number("reservoir");
                let given = fluid.and_then(|id| head.units[id.0].inputs.range("interface_acceleration"));
                let given = given.filter(|range| range.len() == points);
                each_accepted(log, |exchange| {
                    if exchange.unit == structure {
                        recorded.add(&exchange.occasion, exchange.outputs.clone().unwrap_or_default());
                    } else if Some(exchange.unit) == fluid
                        && let Some(given) = &given
                        && let Some(index) = (exchange.occasion.step as usize).checked_sub(1)
                        && let Some((_, _, answer)) = recorded.steps.get_mut(index)
                    {
                        answer[acceleration.clone()].copy_from_slice(&exchange.inputs[given.clone()]);
                    }
                })?;
            }
        }
        Ok(recorded)
    }

    /// Checks that it continues until `end` (s), in steps of `length` (s) at the beginning.
    ///
    /// **Errors**: [`RecordedError::TooShort`], [`RecordedError::Steps`].
    pub fn reaches(&self, end: f64, length: f64) -> Result<(), RecordedError> {
        let path = || self.path.clone();
        if let Some((start, own, _)) = self.steps.first()
            && (own - length).abs() > 1e-9 * length
        {
            let (start, own) = (*start, *own);
            return Err(RecordedError::Steps {
                path: path(),
                step: 1,
                start,
                length: own,
                asked: length,
                time: start,
            });
        }
        let last = self.steps.last().map_or(0.0, |(start, length, _)| start + length);
        if last < end - 1e-6 * length {
            return Err(RecordedError::TooShort { path: path(), end: last, asked: end });
        }
        Ok(())
    }

    fn add(&mut self, occasion: &Occasion, answer: Vec<f64>) {
        match occasion.step {
            0 => self.first = answer,
            _ => self.steps.push((occasion.time, occasion.communication_step, answer)),
        }
    }

    fn answer(&self, occasion: &Occasion) -> Result<&[f64], RecordedError> {
        let Occasion { step, time, communication_step: asked, .. } = *occasion;
        let recorded = (step as usize).checked_sub(1).and_then(|index| self.steps.get(index));
        let Some((start, length, answer)) = recorded else {
            let end = self.steps.last().map_or(0.0, |(start, length, _)| start + length);
            return Err(RecordedError::TooShort { path: self.path.clone(), end, asked: occasion.end() });
        };
        let (start, length) = (*start, *length);
        if (start - time).abs() > 1e-9 * asked || (length - asked).abs() > 1e-9 * asked {
            return Err(RecordedError::Steps { path: self.path.clone(), step, start, length, asked, time });
        }
        Ok(answer)
    }
}

/// Gives every accepted exchange to `take`.
fn each_accepted(log: &Log, mut take: impl FnMut(&LoggedExchange)) -> Result<(), LogReadError> {
    for entry in log.entries()? {
        match entry? {
            Entry::Exchange(exchange) if exchange.accepted => take(&exchange),
            Entry::Damage(damage) => {
                return Err(LogReadError::Missing { path: log.path().to_owned(), damage });
            }
            _ => (),
        }
    }
    Ok(())
}

impl Participant for Recorded {
    fn description(&self) -> &Description {
        &self.description
    }

    fn is_open_loop(&self) -> bool {
        true
    }

    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        self.description.find_readable(variable)?;
        let coordinate = |axis: usize| self.face.points().iter().map(|p| p[axis]).collect();
        Ok(match variable {
            "interface_x" => coordinate(0),
            "interface_y" => coordinate(1),
            _ => self.hydrostatic.clone(),
        })
    }

    fn initialise(&mut self, _: f64, _: &[f64], outputs: &mut [f64]) -> Result<(), ParticipantError> {
        outputs.copy_from_slice(&self.first);
        Ok(())
    }

    fn step(
        &mut self,
        occasion: &Occasion,
        _inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        let answer = self.answer(occasion).map_err(|cause| ParticipantError::Unit {
            participant: self.description.name.clone(),
            cause: Box::new(cause),
        })?;
        outputs.copy_from_slice(answer);
        Ok(())
    }

    fn save_state(&mut self) -> Result<(), ParticipantError> {
        Ok(())
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        Ok(())
    }

    /// It answers by the number of the step: its place in the log is no more than which log it is.
    fn serialise(&mut self) -> Result<Option<Vec<u8>>, ParticipantError> {
        let sealed = seal(self.description.fingerprint, &());
        sealed.map(Some).map_err(|cause| self.description.no_state(cause))
    }

    fn deserialise(&mut self, state: &[u8]) -> Result<(), ParticipantError> {
        open(self.description.fingerprint, state).map_err(|cause| self.description.no_state(cause))
    }
}
