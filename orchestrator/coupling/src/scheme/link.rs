use super::{
    Account, CouplingError, Crossing, Direction, Exchange, Field, Graph, Interface, InterfaceWork, Interval,
    Port, UnitId,
};
use crate::mapping::Mapping;
use crate::participant::{Description, Participant, ParticipantError};
use crate::signal::Signal;
use cofferdam_unit::WetFace;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// An interface in use: places of its fields in requests and answers, and what is constant in a run.
pub(super) struct Link {
    pub interface: Interface,
    pub mapping: Mapping,
    pub account: Option<Box<dyn Account>>,
    /// Constant parts of the backward fields at the first unit's points; zero where there is none.
    pub constant: Vec<f64>,
    forward: Vec<Track>,
    backward: Vec<Track>,
    /// Place of the monitored output of the first unit.
    monitored: Option<Range<usize>>,
}

/// A field's places.
struct Track {
    /// In the answer of the unit that gives it.
    answer: Range<usize>,
    /// In the request to the unit that receives it.
    request: Range<usize>,
    /// Constant part: its variable of the second unit, and its place in the request to the first.
    constant: Option<(String, Range<usize>)>,
    weight: f64,
    relaxed: bool,
}

/// What a [`Link`] has learnt of the run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct LinkState {
    account: Option<Vec<u8>>,
    constant: Vec<f64>,
}

/// Template of the requests to a unit: its size, and the places of the external signals.
pub(super) struct RequestTemplate {
    size: usize,
    /// Number of a signal and the place of its values.
    signals: Vec<(usize, Range<usize>)>,
}

impl Link {
    /// The link at `interface`.
    ///
    /// **Errors**: a unit lacks a variable, or the points of the two cannot be mapped.
    pub fn new(graph: &mut Graph, interface: &Interface) -> Result<Self, CouplingError> {
        let mapping = match interface_points(graph, interface)? {
            Some([first, second]) => mapping(graph, interface, [&first, &second])?,
            None => Mapping::identity(),
        };
        let [first, second] =
            [&interface.first, &interface.second].map(|port| graph[port.unit].description());
        // Where fields are mapped, all have one value a point; elsewhere each has its own number of values.
        let sizes = interface.coordinates.is_some().then(|| sizes(interface, [first, second])).transpose()?;
        let track = |field: &Field| track(interface, field, [first, second], sizes);
        let of = |direction| {
            let fields = interface.fields.iter().filter(move |field| field.direction == direction);
            fields.map(track).collect::<Result<Vec<_>, ParticipantError>>()
        };
        let (forward, backward) = (of(Direction::Forward)?, of(Direction::Backward)?);
        let monitored = interface.monitored.as_ref().map(|name| {
            let name = interface.first.variable(name);
            place(first, false, &name, sizes.map(|[points, _]| points))
        });
        let values = backward.iter().map(|track| track.request.len()).sum();
        Ok(Self {
            mapping,
            account: None,
            constant: vec![0.0; values],
            forward,
            backward,
            monitored: monitored.transpose()?,
            interface: interface.clone(),
        })
    }

    /// What it has learnt of the run.
    pub fn state(&self) -> LinkState {
        LinkState {
            account: self.account.as_ref().map(|account| account.state()),
            constant: self.constant.clone(),
        }
    }

    /// Continues from `state`. An account whose state cannot be read has no past and is given up.
    pub fn resume(&mut self, state: &LinkState) {
        let past = state.account.as_deref();
        self.account.take_if(|account| !past.is_some_and(|past| account.resume(past)));
        self.constant.clone_from(&state.constant);
    }

    /// Unit of the first backward field, such as Pa.
    pub fn unit(&self, graph: &Graph) -> String {
        let port = &self.interface.first;
        let field = self.interface.fields.iter().find(|field| field.direction == Direction::Backward);
        let name = field.map_or_else(String::new, |field| port.variable(&field.input));
        let mut channels = graph[port.unit].description().inputs.channels();
        channels
            .find(|(channel, _)| channel.name == name)
            .map_or_else(String::new, |(channel, _)| channel.unit.clone())
    }

    /// The first unit.
    pub fn first(&self) -> UnitId {
        self.interface.first.unit
    }

    /// The second unit.
    pub fn second(&self) -> UnitId {
        self.interface.second.unit
    }

    /// Number of values that the first unit receives, and the second.
    pub fn received(&self) -> [usize; 2] {
        [&self.backward, &self.forward].map(|tracks| tracks.iter().map(|track| track.request.len()).sum())
    }

    /// For each value that the first unit receives, or the second: whether it is relaxed.
    pub fn relaxed(&self, direction: Direction) -> impl Iterator<Item = bool> {
        let tracks = if direction == Direction::Forward { &self.forward } else { &self.backward };
        tracks.iter().flat_map(|track| std::iter::repeat_n(track.relaxed, track.request.len()))
    }

    /// For each value that the second unit receives: its weight among the unknowns.
    pub fn weights(&self) -> impl Iterator<Item = f64> {
        self.forward.iter().flat_map(|track| std::iter::repeat_n(track.weight, track.request.len()))
    }

    /// Adds the backward fields and their constant parts to a request to the first unit.
    pub fn give_first(&self, values: &[f64], request: &mut [f64]) {
        let mut rest = 0..0;
        for track in &self.backward {
            rest = rest.end..rest.end + track.request.len();
            request[track.request.clone()].copy_from_slice(&values[rest.clone()]);
            if let Some((_, place)) = &track.constant {
                request[place.clone()].copy_from_slice(&self.constant[rest.clone()]);
            }
        }
    }

    /// Adds the forward fields to a request to the second unit.
    pub fn give_second(&self, values: &[f64], request: &mut [f64]) {
        let mut rest = values;
        for track in &self.forward {
            let (own, others) = rest.split_at(track.request.len());
            request[track.request.clone()].copy_from_slice(own);
            rest = others;
        }
    }

    /// The backward fields that the second unit answered, at the first unit's points.
    pub fn backward(&self, second: &Exchange) -> Vec<f64> {
        let mut values = vec![0.0; self.received()[0]];
        let mut rest = &mut values[..];
        for track in &self.backward {
            let (own, others) = rest.split_at_mut(track.request.len());
            self.mapping.adjoint(&second.outputs[track.answer.clone()], own);
            rest = others;
        }
        values
    }

    /// The forward fields that the first unit answered, at the second unit's points.
    pub fn forward(&self, first: &Exchange) -> Vec<f64> {
        let mut values = vec![0.0; self.received()[1]];
        let mut rest = &mut values[..];
        for track in &self.forward {
            let (own, others) = rest.split_at_mut(track.request.len());
            self.mapping.forward(&first.outputs[track.answer.clone()], own);
            rest = others;
        }
        values
    }

    /// Reads the constant parts of the backward fields from the second unit, which is initialised.
    ///
    /// **Errors**: the unit does not tell them, or tells another number.
    pub fn read_constant(&mut self, second: &mut dyn Participant) -> Result<(), ParticipantError> {
        let mut rest = &mut self.constant[..];
        for track in &self.backward {
            let (own, others) = rest.split_at_mut(track.request.len());
            if let Some((variable, _)) = &track.constant {
                let values = second.read(variable)?;
                check_size(second.description(), variable, track.answer.len(), values.len())?;
                self.mapping.adjoint(&values, own);
            }
            rest = others;
        }
        Ok(())
    }

    /// The monitored output of the first unit; empty if none is.
    pub fn monitored<'a>(&self, first: &'a Exchange) -> &'a [f64] {
        self.monitored.clone().map_or(&[], |place| &first.outputs[place])
    }

    /// [`Mapping::work_error`] of what both answered in the first field of each direction.
    pub fn mapping_error(&self, first: &Exchange, second: &Exchange) -> f64 {
        let (Some(forward), Some(backward)) = (self.forward.first(), self.backward.first()) else {
            return 0.0;
        };
        self.mapping
            .work_error(&second.outputs[backward.answer.clone()], &first.outputs[forward.answer.clone()])
    }

    /// Begins the account, if there is one; `one_way` if the first unit is given nothing.
    pub fn begin_account(&mut self, [first, second]: [&Exchange; 2], one_way: bool, signals: &[Signal]) {
        let given = self.given([first, second], one_way);
        if let Some(account) = &mut self.account {
            account.begin(Crossing { first, second, given: &given, signals });
        }
    }

    /// The work of a step, if there is an account.
    pub fn work(
        &mut self,
        interval: &Interval,
        [first, second]: [&Exchange; 2],
        one_way: bool,
        signals: &[Signal],
    ) -> Option<InterfaceWork> {
        let given = self.given([first, second], one_way);
        Some(self.account.as_mut()?.step(interval, Crossing { first, second, given: &given, signals }))
    }

    /// [`Crossing::given`].
    fn given(&self, [first, second]: [&Exchange; 2], one_way: bool) -> Vec<f64> {
        if one_way {
            return self.backward(second);
        }
        self.backward.iter().flat_map(|track| first.inputs[track.request.clone()].iter().copied()).collect()
    }
}

impl RequestTemplate {
    /// The template of requests to a unit that receives those of `signals` for which it has an input.
    pub fn new(description: &Description, signals: &[Signal]) -> Self {
        let place =
            |(number, signal): (usize, &Signal)| Some((number, description.inputs.range(&signal.input)?));
        let signals = signals.iter().enumerate().filter_map(place).collect();
        Self { size: description.inputs.size(), signals }
    }

    /// A request with the signals at `time` (s); its fields are zero.
    pub fn request(&self, signals: &[Signal], time: f64) -> Vec<f64> {
        let mut request = vec![0.0; self.size];
        for (number, place) in &self.signals {
            signals[*number].evaluate(time, &mut request[place.clone()]);
        }
        request
    }
}

fn range(description: &Description, input: bool, variable: &str) -> Result<Range<usize>, ParticipantError> {
    let layout = if input { &description.inputs } else { &description.outputs };
    layout.range(variable).ok_or_else(|| missing(description, variable))
}

fn missing(description: &Description, variable: &str) -> ParticipantError {
    ParticipantError::Missing { participant: description.name.clone(), variable: variable.to_owned() }
}

/// Number of points of both units: the sizes of the inputs of their first fields.
fn sizes(interface: &Interface, [first, second]: [&Description; 2]) -> Result<[usize; 2], ParticipantError> {
    let size = |direction, port: &Port, description: &Description| {
        let field = interface.fields.iter().find(|field| field.direction == direction);
        let variable = port.variable(field.map_or("", |field| &field.input));
        match range(description, true, &variable)?.len() {
            0 => Err(missing(description, &variable)),
            size => Ok(size),
        }
    };
    Ok([
        size(Direction::Backward, &interface.first, first)?,
        size(Direction::Forward, &interface.second, second)?,
    ])
}

/// The places of a field between units with these numbers of points, if it is mapped.
fn track(
    interface: &Interface,
    field: &Field,
    [first, second]: [&Description; 2],
    sizes: Option<[usize; 2]>,
) -> Result<Track, ParticipantError> {
    let points = |unit: usize| sizes.map(|sizes| sizes[unit]);
    let ends = [(&interface.first, first, points(0)), (&interface.second, second, points(1))];
    let [(from, giver, given), (to, receiver, received)] = match field.direction {
        Direction::Forward => ends,
        Direction::Backward => [ends[1], ends[0]],
    };
    let request = place(receiver, true, &to.variable(&field.input), received)?;
    let unmapped = Some(request.len());
    let constant = field.constant_part.as_ref().map(|name| {
        let place = place(receiver, true, &to.variable(name), received.or(unmapped))?;
        Ok::<_, ParticipantError>((from.variable(name), place))
    });
    Ok(Track {
        constant: constant.transpose()?,
        answer: place(giver, false, &from.variable(&field.output), given.or(unmapped))?,
        request,
        weight: field.weight,
        relaxed: field.relaxed,
    })
}

/// The place of a variable, which has this size, or any but 0.
fn place(
    description: &Description,
    input: bool,
    variable: &str,
    size: Option<usize>,
) -> Result<Range<usize>, ParticipantError> {
    let range = range(description, input, variable)?;
    if range.is_empty() {
        return Err(missing(description, variable));
    }
    check_size(description, variable, size.unwrap_or(range.len()), range.len())?;
    Ok(range)
}

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

/// Coordinates of the points of an interface's first unit and of its second, m; `None` if it has no coordinates.
pub fn interface_points(
    graph: &mut Graph,
    interface: &Interface,
) -> Result<Option<[Vec<[f64; 2]>; 2]>, ParticipantError> {
    let Some(names) = &interface.coordinates else { return Ok(None) };
    let [first, second] =
        [&interface.first, &interface.second].map(|port| points_of(&mut graph[port.unit], port, names));
    Ok(Some([first?, second?]))
}

fn points_of(
    unit: &mut dyn Participant,
    port: &Port,
    [x, y]: &[String; 2],
) -> Result<Vec<[f64; 2]>, ParticipantError> {
    let (x, y) = (unit.read(&port.variable(x))?, unit.read(&port.variable(y))?);
    Ok(x.into_iter().zip(y).map(|(x, y)| [x, y]).collect())
}

/// Checks that the points of the two units at `interface` can be mapped to each other, before there is a [`Graph`].
///
/// **Errors**: they lie elsewhere; a unit does not tell its own.
pub fn check_points(
    first: &mut dyn Participant,
    second: &mut dyn Participant,
    interface: &Interface,
) -> Result<(), CouplingError> {
    let Some(names) = &interface.coordinates else { return Ok(()) };
    let from = points_of(first, &interface.first, names)?;
    let to = points_of(second, &interface.second, names)?;
    let names = [first.description().name.clone(), second.description().name.clone()];
    mapping_between([&from, &to], names).map(drop)
}

fn mapping(graph: &Graph, interface: &Interface, points: [&[[f64; 2]]; 2]) -> Result<Mapping, CouplingError> {
    let names = [&interface.first, &interface.second].map(|port| graph[port.unit].description().name.clone());
    mapping_between(points, names)
}

/// The mapping between the points. If the points are the same, they need not form faces.
fn mapping_between([first, second]: [&[[f64; 2]]; 2], names: [String; 2]) -> Result<Mapping, CouplingError> {
    // A coordinate that is not a number is a difference, too.
    let same = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) <= 1e-9;
    let differs = |(a, b): (&[f64; 2], &[f64; 2])| !same(a, b);
    let beyond = [f64::NAN, f64::NAN];
    let index = first.iter().zip(second).position(differs);
    let index = index.or_else(|| (first.len() != second.len()).then(|| first.len().min(second.len())));
    let Some(index) = index else { return Ok(Mapping::identity()) };
    if let (Ok(from), Ok(to)) = (WetFace::new(first.to_vec()), WetFace::new(second.to_vec())) {
        let [from_name, to_name] = &names;
        return Ok(Mapping::between([from_name, to_name], &from, &to)?);
    }
    let [first, second] = [first, second].map(|points| *points.get(index).unwrap_or(&beyond));
    Err(CouplingError::Interface { index, units: names, first, second })
}
