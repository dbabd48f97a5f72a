use super::interface_work::{AtInterface, WorkAccount};
use super::{CouplingError, Exchange, Graph, Interface, Port, UnitId};
use crate::mapping::Mapping;
use crate::participant::{Description, Participant, ParticipantError};
use interface::WetFace;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// An interface in use: places of its variables in requests and answers, and what is constant in a run.
pub(super) struct Link {
    pub interface: Interface,
    pub mapping: Mapping,
    /// `None` if the units do not provide the variables for it.
    pub account: Option<WorkAccount>,
    /// Hydrostatic pressure at the structure's points, Pa.
    pub hydrostatic: Vec<f64>,
    /// At the structure.
    pressure: Range<usize>,
    hydrostatic_pressure: Range<usize>,
    displacement: Range<usize>,
    motion: Range<usize>,
    velocity: Option<Range<usize>>,
    /// At the fluid.
    acceleration: Range<usize>,
    answer: Range<usize>,
}

/// What a [`Link`] has learnt of the run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct LinkState {
    account: Option<WorkAccount>,
    hydrostatic: Vec<f64>,
}

/// A request to a unit before its interfaces are known: its size, and the place of the ground's acceleration.
pub(super) struct Blank {
    size: usize,
    ground: Range<usize>,
}

impl Link {
    /// The link at `interface`.
    ///
    /// **Errors**: a unit lacks a coupled variable, or the points of the two differ.
    pub fn new(graph: &mut Graph, interface: &Interface) -> Result<Self, CouplingError> {
        let [dam, reservoir] = interface_points(graph, interface)?;
        let (structure, fluid) = (&interface.structure, &interface.fluid);
        let [a, b] = [structure, fluid].map(|port| graph[port.unit].description());
        let face = points(a, &structure.variable("interface_pressure"))?;
        let water = points(b, &fluid.variable("interface_acceleration"))?;
        let of = |input, name: &str| place(a, input, &structure.variable(name), face);
        let velocity = a.outputs.range(&structure.variable("interface_velocity"));
        let velocity = velocity.filter(|range| range.len() == face);
        // Units of another kind may have no wet face; their work is then unknown.
        let faces = WetFace::new(dam.clone()).ok().zip(WetFace::new(reservoir.clone()).ok());
        let faces = faces.filter(|_| velocity.is_some());
        Ok(Self {
            mapping: mapping(&dam, &reservoir)?,
            account: faces.map(|(dam, reservoir)| WorkAccount::new(&dam, &reservoir)),
            hydrostatic: vec![0.0; face],
            pressure: of(true, "interface_pressure")?,
            hydrostatic_pressure: of(true, "hydrostatic_pressure")?,
            displacement: of(false, "interface_displacement")?,
            motion: of(false, "interface_acceleration")?,
            velocity,
            acceleration: place(b, true, &fluid.variable("interface_acceleration"), water)?,
            answer: place(b, false, &fluid.variable("interface_pressure"), water)?,
            interface: interface.clone(),
        })
    }

    /// What it has learnt of the run.
    pub fn state(&self) -> LinkState {
        LinkState { account: self.account.clone(), hydrostatic: self.hydrostatic.clone() }
    }

    /// Goes on from `state`.
    pub fn resume(&mut self, state: &LinkState) {
        self.account.clone_from(&state.account);
        self.hydrostatic.clone_from(&state.hydrostatic);
    }

    /// The structure.
    pub fn structure(&self) -> UnitId {
        self.interface.structure.unit
    }

    /// The fluid.
    pub fn fluid(&self) -> UnitId {
        self.interface.fluid.unit
    }

    /// Number of points of the structure's face and of the fluid's.
    pub fn points(&self) -> [usize; 2] {
        [self.pressure.len(), self.acceleration.len()]
    }

    /// Adds pressure (Pa) to a request to the structure.
    pub fn load(&self, pressure: &[f64], request: &mut [f64]) {
        request[self.pressure.clone()].copy_from_slice(pressure);
        request[self.hydrostatic_pressure.clone()].copy_from_slice(&self.hydrostatic);
    }

    /// Adds the face's acceleration (m/s²) to a request to the fluid.
    pub fn drive(&self, acceleration: &[f64], request: &mut [f64]) {
        request[self.acceleration.clone()].copy_from_slice(acceleration);
    }

    /// The pressure that the fluid answered, at the structure's points.
    pub fn pressure(&self, fluid: &Exchange) -> Vec<f64> {
        let mut pressure = vec![0.0; self.pressure.len()];
        self.mapping.pressure_to_dam(&fluid.outputs[self.answer.clone()], &mut pressure);
        pressure
    }

    /// The acceleration that the structure answered, at the fluid's points.
    pub fn acceleration(&self, structure: &Exchange) -> Vec<f64> {
        let mut acceleration = vec![0.0; self.acceleration.len()];
        self.mapping.motion_to_reservoir(&structure.outputs[self.motion.clone()], &mut acceleration);
        acceleration
    }

    /// The displacement that the structure answered.
    pub fn displacement<'a>(&self, structure: &'a Exchange) -> &'a [f64] {
        &structure.outputs[self.displacement.clone()]
    }

    /// [`Mapping::work_error`] of what both answered.
    pub fn mapping_error(&self, structure: &Exchange, fluid: &Exchange) -> f64 {
        self.mapping.work_error(&fluid.outputs[self.answer.clone()], &structure.outputs[self.motion.clone()])
    }

    /// The interface after exchanges with both units; the pressure is that `given` to the structure, or the answer, if it is
    /// in the structure's mass.
    pub fn at_interface(&self, structure: &Exchange, fluid: &Exchange, in_mass: bool) -> Option<AtInterface> {
        let velocity = self.velocity.clone()?;
        let given = match in_mass {
            true => self.pressure(fluid),
            false => structure.inputs[self.pressure.clone()].to_vec(),
        };
        Some(AtInterface {
            given,
            answered: fluid.outputs[self.answer.clone()].to_vec(),
            told: fluid.inputs[self.acceleration.clone()].to_vec(),
            displacement: self.displacement(structure).to_vec(),
            velocity: structure.outputs[velocity].to_vec(),
        })
    }
}

impl Blank {
    /// The blank request to a unit.
    ///
    /// **Errors**: it has no input for the ground's acceleration.
    pub fn of(description: &Description) -> Result<Self, ParticipantError> {
        let ground = place(description, true, "ground_acceleration", 2)?;
        Ok(Self { size: description.inputs.size(), ground })
    }

    /// A request with the ground's acceleration, m/s².
    pub fn request(&self, ground: [f64; 2]) -> Vec<f64> {
        let mut request = vec![0.0; self.size];
        request[self.ground.clone()].copy_from_slice(&ground);
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

/// Number of points of the input `variable`.
fn points(description: &Description, variable: &str) -> Result<usize, ParticipantError> {
    match range(description, true, variable)?.len() {
        0 => Err(missing(description, variable)),
        points => Ok(points),
    }
}

fn place(
    description: &Description,
    input: bool,
    variable: &str,
    size: usize,
) -> Result<Range<usize>, ParticipantError> {
    let range = range(description, input, variable)?;
    check_size(description, variable, size, range.len())?;
    Ok(range)
}

/// Checks the number of values of a coupled variable.
pub(super) fn check_size(
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

/// Coordinates of the points of an interface's structure and of its fluid, m.
pub fn interface_points(
    graph: &mut Graph,
    interface: &Interface,
) -> Result<[Vec<[f64; 2]>; 2], ParticipantError> {
    let [structure, fluid] =
        [&interface.structure, &interface.fluid].map(|port| points_of(&mut graph[port.unit], port));
    Ok([structure?, fluid?])
}

fn points_of(unit: &mut dyn Participant, port: &Port) -> Result<Vec<[f64; 2]>, ParticipantError> {
    let (x, y) = (unit.read(&port.variable("interface_x"))?, unit.read(&port.variable("interface_y"))?);
    Ok(x.into_iter().zip(y).map(|(x, y)| [x, y]).collect())
}

/// Checks that the points of the two units at `interface` can be mapped to each other, before there is a [`Graph`].
///
/// **Errors**: they lie elsewhere; a unit does not tell its own.
pub fn check_points(
    structure: &mut dyn Participant,
    fluid: &mut dyn Participant,
    interface: &Interface,
) -> Result<(), CouplingError> {
    let dam = points_of(structure, &interface.structure)?;
    mapping(&dam, &points_of(fluid, &interface.fluid)?).map(drop)
}

/// The mapping between the points. If the points are the same, they need not form wet faces.
fn mapping(dam: &[[f64; 2]], reservoir: &[[f64; 2]]) -> Result<Mapping, CouplingError> {
    // No number is a difference, too.
    let same = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) <= 1e-9;
    let differs = |(a, b): (&[f64; 2], &[f64; 2])| !same(a, b);
    let beyond = [f64::NAN, f64::NAN];
    let index = dam.iter().zip(reservoir).position(differs);
    let index = index.or_else(|| (dam.len() != reservoir.len()).then(|| dam.len().min(reservoir.len())));
    let Some(index) = index else { return Ok(Mapping::identity()) };
    if let (Ok(dam), Ok(reservoir)) = (WetFace::new(dam.to_vec()), WetFace::new(reservoir.to_vec())) {
        return Ok(Mapping::new(&dam, &reservoir)?);
    }
    let [dam_x, dam_y] = *dam.get(index).unwrap_or(&beyond);
    let [reservoir_x, reservoir_y] = *reservoir.get(index).unwrap_or(&beyond);
    Err(CouplingError::Interface { index, dam_x, dam_y, reservoir_x, reservoir_y })
}
