use cofferdam_coupling::participant::{
    AccelerationMeaning, Channel, Description, Layout, Level, Message, Occasion, Participant,
    ParticipantError, check_finite,
};
use cofferdam_coupling::scheme::Exchange;
use cofferdam_coupling::simulation::UnitTest;
use cofferdam_unit::Role;
use cofferdam_unit::{EndAcceleration, StateError, WetFace, open, seal};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Duration;

/// A unit of another program, with what the contract asks for and it lacks.
///
/// It need not know the ground, the hydrostatic pressure nor where the points are: these are told in its place, and what it
/// has no input for is not sent to it. Where it takes accelerations to mean the value at the end of a step, they are converted:
/// by [`EndAcceleration`] before a fluid, and to the mean `(a(t) + a(t + H)) / 2` behind a structure.
pub struct Foreign {
    inner: Box<dyn Participant>,
    description: Description,
    /// For each input of the inner unit in turn, its place in a request.
    places: Vec<Range<usize>>,
    /// A request as the inner unit gets it.
    request: Vec<f64>,
    told: BTreeMap<&'static str, Vec<f64>>,
    converted: Option<Converted>,
    messages: Vec<Message>,
}

/// Share of the pressure at the base from which two hydrostatic pressures are not the same.
const WEIGHTS_APART: f64 = 1e-3;

/// Where a unit stands, and what it takes its input to mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Its kind.
    pub role: Role,
    /// The wet face of the scene, which is its own if it does not say otherwise.
    pub face: WetFace,
    /// Specific weight ρ g of the scene's water, N/m³.
    pub specific_weight: f64,
    /// What its accelerations mean.
    pub acceleration: AccelerationMeaning,
}

/// Why a unit of another program does not fit the wet face.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FaceError {
    /// A unit with other points than the scene, that does not say where they are.
    #[error(
        "its interface has {found} points, that of the scene {expected}, and it does not tell where its own are \
         (`interface_x`, `interface_y`); take those of `cofferdam points`"
    )]
    Points {
        /// Number of its points.
        found: usize,
        /// Number of points of the scene.
        expected: usize,
    },
    /// A unit whose normals are others than those of its points.
    #[error(
        "its normal at point {index} is ({:.3}, {:.3}), but out of the water and into the dam is ({:.3}, {:.3}); \
         turn its normals", found[0], found[1], expected[0], expected[1]
    )]
    Normal {
        /// Index of the point, from 0.
        index: usize,
        /// Its normal.
        found: [f64; 2],
        /// The normal of its points.
        expected: [f64; 2],
    },
    /// A unit of the other sign.
    #[error(
        "when {asked}, it answers with {change:e} {unit}, where that must be above 0; n points out of the water \
         into the dam, accelerations are along n, and pressure is positive in compression: turn the sign"
    )]
    Sign {
        /// What it was asked.
        asked: &'static str,
        /// Its answer, integrated along the face.
        change: f64,
        /// Of what, and the unit.
        unit: &'static str,
    },
}

impl FaceError {
    /// The error of the unit that this describes.
    fn of(self, unit: &Description) -> ParticipantError {
        ParticipantError::Unit { participant: unit.name.clone(), cause: Box::new(self) }
    }
}

/// The acceleration of a unit that takes it to be that at the end of a step, in a request or an answer.
struct Converted {
    place: Range<usize>,
    now: Past,
    saved: Past,
}

#[derive(Clone, Serialize, Deserialize)]
enum Past {
    Fluid(EndAcceleration),
    /// Acceleration at the start of the step.
    Structure(Vec<f64>),
}

impl Past {
    /// Whether `other` is of the same kind and size.
    fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Fluid(here), Self::Fluid(there)) => there.is_of(here.mean.len()),
            (Self::Structure(here), Self::Structure(there)) => here.len() == there.len(),
            _ => false,
        }
    }
}

impl Foreign {
    /// `inner` at `place`.
    ///
    /// **Errors**: it lacks a variable of the interface, or has other points than it says, normals into the water among
    /// them.
    pub fn new(inner: Box<dyn Participant>, place: &Place) -> Result<Self, ParticipantError> {
        let theirs = inner.description().clone();
        let mut foreign = Self {
            places: Vec::new(),
            request: vec![0.0; theirs.inputs.size()],
            told: BTreeMap::new(),
            converted: None,
            messages: Vec::new(),
            description: theirs,
            inner,
        };
        let points = foreign.points(place)?;
        let coordinate = |axis: usize| points.iter().map(|point| point[axis]).collect::<Vec<_>>();
        let known = |name: &str| foreign.description.readable.range(name).is_some();
        let mut told = BTreeMap::from([("interface_x", coordinate(0)), ("interface_y", coordinate(1))]);
        let mut own_water = false;
        if place.role == Role::Fluid {
            let depth = points.iter().fold(0.0, |depth: f64, point| depth.max(point[1]));
            let pressure = points.iter().map(|point| place.specific_weight * (depth - point[1])).collect();
            own_water = known("hydrostatic_pressure");
            told.insert("hydrostatic_pressure", pressure);
        }
        let of_scene = told.get("hydrostatic_pressure").cloned().unwrap_or_default();
        told.retain(|name, _| !known(name));
        if own_water {
            foreign.compare_weight(&of_scene)?;
        }
        foreign.told = told;
        foreign.complete(place.role, points.len());
        if place.acceleration == AccelerationMeaning::End {
            foreign.convert(place.role, points.len())?;
        }
        Ok(foreign)
    }

    /// The points of the unit: its own, or those of the scene.
    fn points(&mut self, place: &Place) -> Result<Vec<[f64; 2]>, ParticipantError> {
        let role = place.role;
        let (inputs, outputs) = role.needed();
        let mut size = None;
        for (layout, names) in [(&self.description.inputs, inputs), (&self.description.outputs, outputs)] {
            for name in names {
                let range = layout.range(name).ok_or_else(|| self.description.missing(name))?;
                let expected = *size.get_or_insert(range.len());
                if expected != range.len() {
                    return Err(self.size_of(name, expected, range.len()));
                }
            }
        }
        let size = size.unwrap_or(0);
        let coordinates = ["interface_x", "interface_y"];
        if coordinates.iter().any(|name| self.description.readable.range(name).is_none()) {
            if size != place.face.len() {
                let refused = FaceError::Points { found: size, expected: place.face.len() };
                return Err(refused.of(&self.description));
            }
            return Ok(place.face.points().to_vec());
        }
        let mut read = |name: &str| -> Result<Vec<f64>, ParticipantError> {
            let values = self.inner.read(name)?;
            match values.len() == size {
                true => Ok(values),
                false => Err(self.size_of(name, size, values.len())),
            }
        };
        let [x, y] = [read(coordinates[0])?, read(coordinates[1])?];
        let points: Vec<[f64; 2]> = x.into_iter().zip(y).map(|(x, y)| [x, y]).collect();
        let normals = ["interface_normal_x", "interface_normal_y"];
        if normals.iter().all(|name| self.description.readable.range(name).is_some())
            && let Ok(face) = WetFace::new(points.clone())
        {
            let [x, y] = [self.inner.read(normals[0])?, self.inner.read(normals[1])?];
            for (index, (expected, found)) in face.normals().iter().zip(x.iter().zip(&y)).enumerate() {
                let found = [*found.0, *found.1];
                // cos 20°: programs differ in what they call the normal at a kink.
                if expected[0] * found[0] + expected[1] * found[1] < 0.94 {
                    let refused = FaceError::Normal { index, found, expected: *expected };
                    return Err(refused.of(&self.description));
                }
            }
        }
        Ok(points)
    }

    /// Says so if its water has another weight than the scene's.
    fn compare_weight(&mut self, of_scene: &[f64]) -> Result<(), ParticipantError> {
        let own = self.inner.read("hydrostatic_pressure")?;
        let largest = of_scene.iter().copied().fold(0.0, f64::max);
        let apart = own.iter().zip(of_scene).map(|(own, scene)| (own - scene).abs()).fold(0.0, f64::max);
        if apart > WEIGHTS_APART * largest {
            let (found, unit) = (own.iter().copied().fold(0.0, f64::max), self.description.name.clone());
            self.messages.push(Message {
                unit,
                level: Level::Warning,
                step: 0,
                iteration: 0,
                time: 0.0,
                source: "hydrostatic pressure".to_owned(),
                text: format!(
                    "its own hydrostatic pressure is used, at most {found:e} Pa, where that of the scene's depth and density is \
                     {largest:e} Pa"
                ),
            });
        }
        Ok(())
    }

    fn size_of(&self, variable: &str, expected: usize, found: usize) -> ParticipantError {
        let (participant, variable) = (self.description.name.clone(), variable.to_owned());
        ParticipantError::Size { participant, variable, expected, found }
    }

    /// Adds the inputs that every unit of the contract has, and what is told in its place.
    fn complete(&mut self, role: Role, points: usize) {
        let theirs: Vec<Channel> =
            self.description.inputs.channels().map(|(channel, _)| channel.clone()).collect();
        let mut channels = theirs.clone();
        let of_contract = role.variables();
        let channel = |name: &str, size: usize| {
            let variable = of_contract.iter().find(|v| v.name == name)?;
            Some(Channel {
                name: name.to_owned(),
                value_reference: variable.value_reference,
                unit: variable.unit.to_owned(),
                size,
                shape: variable.shape.into(),
            })
        };
        let wanted = [("hydrostatic_pressure", points), ("ground_acceleration", 2)];
        for (name, size) in wanted.into_iter().skip(usize::from(role == Role::Fluid)) {
            if self.description.inputs.range(name).is_none() {
                channels.extend(channel(name, size));
            }
        }
        self.description.inputs = Layout::new(channels);
        let inputs = &self.description.inputs;
        self.places = theirs.iter().filter_map(|channel| inputs.range(&channel.name)).collect();
        let told = self.told.iter().filter_map(|(name, values)| channel(name, values.len()));
        // Under the contract's value references, by which another process asks: theirs may be those of what is told.
        let of_theirs =
            |theirs: &Channel| channel(&theirs.name, theirs.size).unwrap_or_else(|| theirs.clone());
        let readable = self.description.readable.channels().map(|(theirs, _)| of_theirs(theirs));
        self.description.readable = Layout::new(readable.chain(told).collect());
    }

    fn convert(&mut self, role: Role, points: usize) -> Result<(), ParticipantError> {
        let name = "interface_acceleration";
        let (place, now) = match role {
            Role::Fluid => {
                (self.description.inputs.range(name), Past::Fluid(EndAcceleration::at_rest(points)))
            }
            Role::Structure => (self.description.outputs.range(name), Past::Structure(vec![0.0; points])),
        };
        let place = place.ok_or_else(|| self.description.missing(name))?;
        self.converted = Some(Converted { place, saved: now.clone(), now });
        Ok(())
    }

    /// The request as the inner unit gets it.
    fn ask(&mut self, inputs: &[f64], length: f64) {
        let mut at = 0;
        for place in &self.places {
            self.request[at..at + place.len()].copy_from_slice(&inputs[place.clone()]);
            if let Some(Converted { place: mean, now: Past::Fluid(past), .. }) = &mut self.converted
                && mean == place
                && length > 0.0
            {
                past.step(&inputs[mean.clone()], length);
                self.request[at..at + place.len()].copy_from_slice(&past.at_end);
            }
            at += place.len();
        }
    }

    /// The answer as this program takes it.
    fn answer(&mut self, outputs: &mut [f64], length: f64) {
        let Some(Converted { place, now: Past::Structure(before), .. }) = &mut self.converted else { return };
        let at_end = outputs[place.clone()].to_vec();
        if length > 0.0 {
            let means = before.iter().zip(&at_end).map(|(before, end)| 0.5 * (before + end));
            outputs[place.clone()]
                .iter_mut()
                .zip(means)
                .for_each(|(acceleration, mean)| *acceleration = mean);
        }
        *before = at_end;
    }
}

impl Participant for Foreign {
    fn description(&self) -> &Description {
        &self.description
    }

    fn read(&mut self, variable: &str) -> Result<Vec<f64>, ParticipantError> {
        match self.told.get(variable) {
            Some(values) => Ok(values.clone()),
            None => self.inner.read(variable),
        }
    }

    fn initialise(
        &mut self,
        start_time: f64,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        self.ask(inputs, 0.0);
        self.inner.initialise(start_time, &self.request, outputs)?;
        self.answer(outputs, 0.0);
        Ok(())
    }

    fn step(
        &mut self,
        occasion: &Occasion,
        inputs: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), ParticipantError> {
        self.ask(inputs, occasion.communication_step);
        self.inner.step(occasion, &self.request, outputs)?;
        self.answer(outputs, occasion.communication_step);
        check_finite(&self.description, outputs, occasion.end())
    }

    fn save_state(&mut self) -> Result<(), ParticipantError> {
        if let Some(converted) = &mut self.converted {
            converted.saved = converted.now.clone();
        }
        self.inner.save_state()
    }

    fn restore_state(&mut self) -> Result<(), ParticipantError> {
        if let Some(converted) = &mut self.converted {
            converted.now = converted.saved.clone();
        }
        self.inner.restore_state()
    }

    fn serialise(&mut self) -> Result<Option<Vec<u8>>, ParticipantError> {
        let Some(inner) = self.inner.serialise()? else { return Ok(None) };
        let past = self.converted.as_ref().map(|converted| &converted.now);
        seal(self.description.fingerprint, &(past, inner))
            .map(Some)
            .map_err(|cause| self.description.no_state(cause))
    }

    fn deserialise(&mut self, state: &[u8]) -> Result<(), ParticipantError> {
        let read = open(self.description.fingerprint, state);
        let (past, inner): (Option<Past>, Vec<u8>) =
            read.map_err(|cause| self.description.no_state(cause))?;
        let fits = match (&self.converted, &past) {
            (None, None) => true,
            (Some(converted), Some(past)) => converted.now.is_like(past),
            _ => false,
        };
        if !fits {
            return Err(self.description.no_state(StateError::NotAState { length: state.len() }));
        }
        if let (Some(converted), Some(past)) = (&mut self.converted, past) {
            converted.now = past;
        }
        self.inner.deserialise(&inner)
    }

    fn busy(&self) -> Duration {
        self.inner.busy()
    }

    fn messages(&mut self) -> Vec<Message> {
        let mut messages = std::mem::take(&mut self.messages);
        messages.extend(self.inner.messages());
        messages
    }
}

/// Tests whether a unit returns to its saved state, that is, whether the same step gives the same bits. Afterwards it is where it
/// was; one that cannot save its state has taken a step.
///
/// The step is that of `occasion`, with `request` but for a `pressure` (Pa) that is small beside what the dam carries.
///
/// Returns what the face's motion into the water by 1 m/s² more, or the pressure, changes of the answer, integrated along the face, for
/// [`check_sign`].
///
/// **Errors**: [`ParticipantError::NotRepeated`], and those of the unit.
pub fn self_test(
    unit: &mut dyn Participant,
    role: Role,
    request: &[f64],
    pressure: f64,
    occasion: &Occasion,
) -> Result<f64, ParticipantError> {
    let description = unit.description().clone();
    let Driven { driven, answered, load } = Driven::of(&description, role, pressure)?;
    let repeats = description.capabilities.saved_state;
    if repeats {
        unit.save_state()?;
    }
    let mut changed = request.to_vec();
    let mut step = |load: f64| -> Result<Vec<f64>, ParticipantError> {
        let mut answer = vec![0.0; description.outputs.size()];
        for (changed, request) in changed[driven.clone()].iter_mut().zip(&request[driven.clone()]) {
            *changed = request + load;
        }
        unit.step(occasion, &changed, &mut answer)?;
        if repeats {
            unit.restore_state()?;
        }
        Ok(answer)
    };
    // From the state itself, then twice from what was restored.
    let loaded = step(load)?;
    let still = if repeats { step(0.0)? } else { vec![0.0; description.outputs.size()] };
    let again = if repeats { step(load)? } else { loaded.clone() };
    if let Some(place) = loaded.iter().zip(&again).position(|(a, b)| a.to_bits() != b.to_bits()) {
        let (variable, index) = description.outputs.locate(place).unwrap_or(("?", place));
        return Err(ParticipantError::NotRepeated {
            participant: description.name.clone(),
            variable: variable.to_owned(),
            index,
            first: loaded[place],
            second: again[place],
        });
    }
    let changes: Vec<f64> = answered.map(|place| loaded[place] - still[place]).collect();
    along_face(unit, &changes)
}

/// What a unit answers, integrated along the face, at the end of `steps` over which the load of [`self_test`] is held: from the second step on
/// an acceleration that is extrapolated from means has its value at the end, too.
///
/// **Errors**: those of the unit.
pub fn held_answer(
    unit: &mut dyn Participant,
    role: Role,
    request: &[f64],
    pressure: f64,
    steps: &[Occasion],
) -> Result<f64, ParticipantError> {
    let description = unit.description().clone();
    let Driven { driven, answered, load } = Driven::of(&description, role, pressure)?;
    let mut held = request.to_vec();
    held[driven].iter_mut().for_each(|value| *value += load);
    let mut answer = vec![0.0; description.outputs.size()];
    for occasion in steps {
        unit.step(occasion, &held, &mut answer)?;
    }
    along_face(unit, &answer[answered])
}

/// The test of a unit of another program in the course of a run: it returns to its saved state, and at rest its answer has the
/// right sign.
#[derive(Clone, Copy, Debug)]
pub struct SelfTest {
    role: Role,
    pressure: f64,
}

impl SelfTest {
    /// The test of a unit of this `role` by a `pressure`, Pa.
    pub fn new(role: Role, pressure: f64) -> Self {
        Self { role, pressure }
    }
}

impl UnitTest for SelfTest {
    fn test(
        &self,
        unit: &mut dyn Participant,
        exchange: &Exchange,
        occasion: &Occasion,
        initially: bool,
    ) -> Result<(), ParticipantError> {
        let change = self_test(unit, self.role, &exchange.inputs, self.pressure, occasion)?;
        // A block that slides and rocks may answer a push in any way.
        if initially { check_sign(unit, self.role, change) } else { Ok(()) }
    }
}

/// How a unit is driven by a test, and where it answers.
struct Driven {
    driven: Range<usize>,
    answered: Range<usize>,
    load: f64,
}

impl Driven {
    fn of(description: &Description, role: Role, pressure: f64) -> Result<Self, ParticipantError> {
        let range = |layout: &Layout, name: &str| layout.range(name).ok_or_else(|| description.missing(name));
        let (driven, answered, load) = match role {
            Role::Fluid => ("interface_acceleration", "interface_pressure", -1.0),
            Role::Structure => ("interface_pressure", "interface_acceleration", pressure),
        };
        let (driven, answered) =
            (range(&description.inputs, driven)?, range(&description.outputs, answered)?);
        Ok(Self { driven, answered, load })
    }
}

/// Integral along the face of one value a point.
fn along_face(unit: &mut dyn Participant, values: &[f64]) -> Result<f64, ParticipantError> {
    let [x, y] = [unit.read("interface_x")?, unit.read("interface_y")?];
    let face = WetFace::new(x.into_iter().zip(y).map(|(x, y)| [x, y]).collect());
    let lengths = face.map_or_else(|_| vec![1.0; values.len()], |face| face.tributary_lengths());
    Ok(values.iter().zip(lengths).map(|(value, length)| length * value).sum())
}

/// Checks the sign of what [`self_test`] found of a unit at rest: a face that moves into the water must press, a pressure must push
/// the face into the dam. 0 is right for a unit that answers only after the step that it is asked for.
///
/// **Errors**: [`FaceError::Sign`].
pub fn check_sign(unit: &dyn Participant, role: Role, change: f64) -> Result<(), ParticipantError> {
    if change >= 0.0 {
        return Ok(());
    }
    let (asked, of) = match role {
        Role::Fluid => ("its face moves into the water by 1 m/s²", "N/m of force on the dam"),
        Role::Structure => ("the water presses", "m²/s² of acceleration into the dam"),
    };
    Err(FaceError::Sign { asked, change, unit: of }.of(unit.description()))
}
