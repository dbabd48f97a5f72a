//! The envelopes of stresses and motion over a run, and their files.

use super::{Quantity, Subject};
use cofferdam_assembly::vtk::{self, Field, Grid};
use cofferdam_coupling::participant::{Participant, ParticipantError};
use std::io::Error;
use std::path::Path;

/// Extremes over a run at the nodes of the dam and at the contacts of its cracks, as the dam kept them: at the end of initialisation and
/// of every accepted communication step.
#[derive(Clone, Debug, PartialEq)]
pub struct Envelopes {
    /// Points: nodes in the unloaded position. Fields: the variables of the dam that begin with `envelope_`, in SI units.
    pub dam: Grid,
    /// One point a contact; none without cracks.
    pub cracks: Grid,
}

/// Name of the fields' unit-less part, of the dam's variable, and the unit.
const AT_NODES: [(&str, &str, &str); 11] = [
    ("major_principal_stress_max", "envelope_major_principal_stress", "Pa"),
    ("major_principal_stress_max_time", "envelope_major_principal_stress_time", "s"),
    ("minor_principal_stress_min", "envelope_minor_principal_stress", "Pa"),
    ("minor_principal_stress_min_time", "envelope_minor_principal_stress_time", "s"),
    ("displacement_x_min", "envelope_displacement_x_least", "m"),
    ("displacement_x_max", "envelope_displacement_x_most", "m"),
    ("displacement_y_min", "envelope_displacement_y_least", "m"),
    ("displacement_y_max", "envelope_displacement_y_most", "m"),
    ("displacement_magnitude_max", "envelope_displacement_magnitude", "m"),
    ("overstress_duration", "envelope_overstress_duration", "s"),
    ("demand_capacity_ratio_max", "envelope_demand_capacity_ratio", "1"),
];
const AT_CONTACTS: [(&str, &str, &str); 3] = [
    ("opening_max", "envelope_contact_opening", "m"),
    ("slip_min", "envelope_contact_slip_least", "m"),
    ("slip_max", "envelope_contact_slip_most", "m"),
];

/// Names in files that are looked for.
pub(crate) const MAJOR: &str = "major_principal_stress_max [Pa]";
const DURATION: &str = "overstress_duration [s]";
pub(crate) const RATIO: &str = "demand_capacity_ratio_max [1]";
/// Names of the quantities of overstress that a criterion limits.
pub(crate) const SHARE_OVER: &str = "overstressed share of the section";
pub(crate) const LARGEST_RATIO: &str = "largest demand-capacity ratio";
pub(crate) const LONGEST_OVER: &str = "longest time above the tensile strength";
/// The time up to which they reach, in the file of the dam.
pub(crate) const END: &str = "time [s]";

/// The file that names the others, and those, in the folder of a run.
const INDEX: &str = "envelopes.vtm";
const DAM: &str = "envelopes-dam.vtu";
const CRACKS: &str = "envelopes-cracks.vtu";

impl Envelopes {
    /// Those of `dam` up to `time` (s), the end of the last accepted step; none if it keeps none, or stands elsewhere: within a step
    /// that was not accepted.
    ///
    /// **Errors**: the dam cannot be read.
    pub fn read(dam: &mut dyn Participant, time: f64) -> Result<Option<Self>, ParticipantError> {
        let has = |dam: &dyn Participant, name: &str| dam.description().readable.range(name).is_some();
        if !has(dam, "envelope_end") {
            return Ok(None);
        }
        let end = dam.read("envelope_end")?.first().copied().unwrap_or(f64::NAN);
        let is_near = (end - time).abs() <= NEAR * time.abs().max(1.0);
        if !is_near {
            return Ok(None);
        }
        let fields = |dam: &mut dyn Participant, of: &[(&str, &str, &str)]| {
            let there = of.iter().filter(|(_, variable, _)| has(dam, variable)).collect::<Vec<_>>();
            there
                .into_iter()
                .map(|(name, variable, unit)| {
                    Ok(Field::scalar(&format!("{name} [{unit}]"), dam.read(variable)?))
                })
                .collect::<Result<Vec<_>, ParticipantError>>()
        };
        let points =
            |dam: &mut dyn Participant, x: &str, y: &str| -> Result<Vec<[f64; 2]>, ParticipantError> {
                if !has(dam, x) {
                    return Ok(Vec::new());
                }
                Ok(dam.read(x)?.into_iter().zip(dam.read(y)?).map(|(x, y)| [x, y]).collect())
            };
        let mut corners = Vec::new();
        for corner in 1..=3 {
            corners.push(dam.read(&format!("triangle_node_{corner}"))?);
        }
        let triangle = |i: usize| corners.iter().map(|nodes| nodes[i] as usize).collect();
        let concrete = Grid {
            points: points(dam, "node_x", "node_y")?,
            cells: (0..corners[0].len()).map(triangle).collect(),
            point_data: fields(dam, &AT_NODES)?,
            cell_data: Vec::new(),
            field_data: vec![(END.to_owned(), vec![time])],
        };
        let contacts = points(dam, "contact_x", "contact_y")?;
        let cracks = Grid {
            cells: (0..contacts.len()).map(|contact| vec![contact]).collect(),
            points: contacts,
            point_data: fields(dam, &AT_CONTACTS)?,
            cell_data: Vec::new(),
            field_data: vec![(END.to_owned(), vec![time])],
        };
        Ok(Some(Self { dam: concrete, cracks }))
    }

    /// Writes `envelopes.vtm` and the parts that it names into `folder`, for ParaView.
    ///
    /// **Errors**: a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        let mut parts = Vec::new();
        for (name, file, grid) in [("dam", DAM, &self.dam), ("cracks", CRACKS, &self.cracks)] {
            if !grid.points.is_empty() {
                std::fs::write(folder.join(file), grid.vtu())?;
                parts.push((name, file));
            }
        }
        std::fs::write(folder.join(INDEX), vtk::blocks(&parts))
    }

    /// Takes the files of an earlier part of the run out of `folder`, if there are any.
    ///
    /// **Errors**: they cannot be removed.
    pub fn remove(folder: &Path) -> Result<(), Error> {
        for file in [INDEX, DAM, CRACKS].map(|file| folder.join(file)) {
            if file.exists() {
                std::fs::remove_file(file)?;
            }
        }
        Ok(())
    }

    /// The dam's part in the folder of a run; none if there is none, or it is damaged.
    pub fn of_folder(folder: &Path) -> Option<Grid> {
        let grid = Grid::of_vtu(&std::fs::read_to_string(folder.join(DAM)).ok()?)?;
        grid.point_field(MAJOR).is_some().then_some(grid)
    }

    /// What they say about the section as a whole; nothing without a tensile strength.
    pub fn quantities(&self) -> Vec<Quantity> {
        overstress(&self.dam)
    }
}

/// Difference between the time of the dam and of the run that rounding explains.
const NEAR: f64 = 1e-6;

/// Overstress of the section: its area where the largest principal stress was above the tensile strength at some time, the largest ratio
/// of both, and the longest time above. The ratio is linear in each triangle; none without a tensile strength.
pub(crate) fn overstress(dam: &Grid) -> Vec<Quantity> {
    let (Some(ratio), Some(duration)) = (dam.point_field(RATIO), dam.point_field(DURATION)) else {
        return Vec::new();
    };
    let (mut over, mut whole) = (0.0, 0.0);
    for cell in &dam.cells {
        let &[a, b, c] = &cell[..] else { continue };
        let [p, q, r] = [a, b, c].map(|node| dam.points[node]);
        let area = 0.5 * ((q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1])).abs();
        whole += area;
        over += area * share_above([a, b, c].map(|node| ratio[node]), 1.0);
    }
    let largest = |values: &[f64]| (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b]));
    let quantity = |name: &str, value: f64, unit: &'static str, node: Option<usize>| Quantity {
        name: name.to_owned(),
        subject: Subject::Stresses,
        value,
        unit: unit.into(),
        // a centimetre, of a field on elements of metres; what occurs nowhere has no place
        place: node.filter(|_| value > 0.0).map(|node| dam.points[node].map(|x| (x * 1e2).round() / 1e2)),
        ..Quantity::default()
    };
    let at = |values: &[f64], name: &str, unit: &'static str| {
        largest(values).map(|node| quantity(name, values[node], unit, Some(node)))
    };
    let mut all = vec![
        quantity("overstressed area of the section", over, "m²", None),
        quantity(SHARE_OVER, 100.0 * over / whole, "%", None),
    ];
    all.extend(at(ratio, LARGEST_RATIO, "1"));
    all.extend(at(duration, LONGEST_OVER, "s"));
    all
}

/// Share of a triangle in which a linear function with these `values` at its corners is above `level`.
pub(crate) fn share_above(values: [f64; 3], level: f64) -> f64 {
    let mut above = values.map(|value| value - level);
    above.sort_by(f64::total_cmp);
    match above {
        [low, ..] if low > 0.0 => 1.0,
        [.., high] if high <= 0.0 => 0.0,
        [low, middle, high] if middle <= 0.0 => high * high / ((high - low) * (high - middle)),
        [low, middle, high] => 1.0 - low * low / ((low - middle) * (low - high)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_those_of_the_cut_triangle() {
        for (values, share) in [
            ([1.0, 2.0, 3.0], 1.0),
            ([-1.0, -2.0, 0.0], 0.0),
            // Half of two sides: a quarter of the area.
            ([1.0, -1.0, -1.0], 0.25),
            ([-1.0, 1.0, 1.0], 0.75),
            ([0.0, 1.0, -1.0], 0.5),
            ([3.0, -1.0, 0.0], 0.75),
        ] {
            assert!((share_above(values, 0.0) - share).abs() < 1e-15, "{values:?}");
        }
    }

    #[test]
    fn overstress_is_that_of_a_field_that_is_linear_over_the_section() {
        // A square of 2 m whose ratio grows from 0 to 2 upwards: its upper half is overstressed.
        let points = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let dam = Grid {
            cells: vec![vec![0, 1, 2], vec![0, 2, 3]],
            point_data: vec![
                Field::scalar(MAJOR, vec![0.0; 4]),
                Field::scalar(RATIO, points.iter().map(|p: &[f64; 2]| p[1]).collect()),
                Field::scalar(DURATION, vec![0.0, 0.0, 0.25, 0.125]),
            ],
            points,
            ..Grid::default()
        };
        let found = overstress(&dam);
        let values: Vec<f64> = found.iter().map(|quantity| quantity.value).collect();
        assert_eq!(values, [2.0, 50.0, 2.0, 0.25]);
        assert_eq!(found[3].place, Some([2.0, 2.0]));
        let without = Grid { point_data: dam.point_data[..1].to_vec(), ..dam };
        assert!(overstress(&without).is_empty());
    }
}
