use super::{CouplingError, Units};
use crate::mapping::Mapping;
use crate::participant::{Description, Participant, ParticipantError};
use interface::WetFace;
use std::ops::Range;

/// Places of the coupled variables in requests and answers.
pub(super) struct Channels {
    pub dam_pressure: Range<usize>,
    pub dam_hydrostatic: Range<usize>,
    pub dam_ground: Range<usize>,
    pub dam_displacement: Range<usize>,
    pub dam_acceleration: Range<usize>,
    /// Optional.
    pub dam_velocity: Option<Range<usize>>,
    pub dam_inputs: usize,
    pub reservoir_acceleration: Range<usize>,
    pub reservoir_ground: Range<usize>,
    pub reservoir_pressure: Range<usize>,
    pub reservoir_inputs: usize,
}

impl Channels {
    pub fn of(dam: &Description, reservoir: &Description) -> Result<Self, ParticipantError> {
        let range = |description: &Description, input: bool, variable: &str| {
            let layout = if input { &description.inputs } else { &description.outputs };
            layout.range(variable).ok_or_else(|| ParticipantError::Missing {
                participant: description.name.clone(),
                variable: variable.to_owned(),
            })
        };
        let points = |description: &Description, input: bool, variable: &str| {
            let found = range(description, input, variable)?.len();
            let (participant, variable) = (description.name.clone(), variable.to_owned());
            if found == 0 { Err(ParticipantError::Missing { participant, variable }) } else { Ok(found) }
        };
        let find = |description: &Description, input: bool, variable: &str, size: usize| {
            let range = range(description, input, variable)?;
            check_size(description, variable, size, range.len())?;
            Ok::<_, ParticipantError>(range)
        };
        let face = points(dam, true, "interface_pressure")?;
        let water = points(reservoir, true, "interface_acceleration")?;
        let velocity = dam.outputs.range("interface_velocity").filter(|range| range.len() == face);
        Ok(Self {
            dam_pressure: find(dam, true, "interface_pressure", face)?,
            dam_hydrostatic: find(dam, true, "hydrostatic_pressure", face)?,
            dam_ground: find(dam, true, "ground_acceleration", 2)?,
            dam_displacement: find(dam, false, "interface_displacement", face)?,
            dam_acceleration: find(dam, false, "interface_acceleration", face)?,
            dam_velocity: velocity,
            dam_inputs: dam.inputs.size(),
            reservoir_acceleration: find(reservoir, true, "interface_acceleration", water)?,
            reservoir_ground: find(reservoir, true, "ground_acceleration", 2)?,
            reservoir_pressure: find(reservoir, false, "interface_pressure", water)?,
            reservoir_inputs: reservoir.inputs.size(),
        })
    }

    /// A request to the dam: pressure and hydrostatic pressure (Pa), ground acceleration (m/s²).
    pub fn to_dam(&self, pressure: &[f64], hydrostatic: &[f64], ground: [f64; 2]) -> Vec<f64> {
        let mut inputs = vec![0.0; self.dam_inputs];
        inputs[self.dam_pressure.clone()].copy_from_slice(pressure);
        inputs[self.dam_hydrostatic.clone()].copy_from_slice(hydrostatic);
        inputs[self.dam_ground.clone()].copy_from_slice(&ground);
        inputs
    }

    /// A request to the reservoir: acceleration of the face and of the ground, m/s².
    pub fn to_reservoir(&self, acceleration: &[f64], ground: [f64; 2]) -> Vec<f64> {
        let mut inputs = vec![0.0; self.reservoir_inputs];
        inputs[self.reservoir_acceleration.clone()].copy_from_slice(acceleration);
        inputs[self.reservoir_ground.clone()].copy_from_slice(&ground);
        inputs
    }
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

/// Coordinates of the interface points of the dam and of the reservoir, m.
pub fn interface_points(units: &mut Units) -> Result<[Vec<[f64; 2]>; 2], ParticipantError> {
    let points = |unit: &mut dyn Participant| -> Result<Vec<[f64; 2]>, ParticipantError> {
        let (x, y) = (unit.read("interface_x")?, unit.read("interface_y")?);
        Ok(x.into_iter().zip(y).map(|(x, y)| [x, y]).collect())
    };
    Ok([points(&mut *units.dam)?, points(&mut *units.reservoir)?])
}

/// The mapping between the points. If the points are the same, they need not form wet faces.
pub(super) fn mapping(dam: &[[f64; 2]], reservoir: &[[f64; 2]]) -> Result<Mapping, CouplingError> {
    let differs = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]) > 1e-9;
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
