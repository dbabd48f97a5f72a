use super::StartOfDam;
use crate::observer::water_field::{self, Water, WaterField};
use crate::units::{DAM, RESERVOIR, TAILWATER};
use crate::vtk::{self, Field, Grid};
use cofferdam_coupling::mapping::Mapping;
use cofferdam_coupling::observer::{Ending, Observer, ObserverError, Start};
use cofferdam_coupling::participant::{Participant, ParticipantError};
use cofferdam_coupling::scheme::{Graph, UnitId, WindowReport, interface_points};
use cofferdam_log::results_file::write_error;
use cofferdam_scene::SnapshotsScene;
use cofferdam_unit::WetFace;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Snapshots of the dam and its waters during a run: `snapshots.pvd` and a folder of `.vtu` files. The series is complete after each
/// snapshot. Names of fields end with their units, such as `displacement [m]`.
///
/// One is taken at every multiple of the interval between `from` and `until`, or else at the first end of a
/// communication step (of a window, where several steps are iterated together) after it. Parts: the *dam* (points:
/// `displacement` in m since time 0; triangles: `stress_xx`, `stress_yy`, `stress_xy`, tension positive, and the
/// principal stresses in Pa, including those at rest; in a dam with zones `zone`, counted from 1), its *contacts* (`opening` and
/// `slip` in m, normal and shear stress in Pa), each *wet face* (`displacement` along its normals; hydrodynamic pressure, that
/// the water answered, and hydrostatic pressure in Pa) and each *water* that is given ([`WaterField`]; both pressures). Points lie in the unloaded position.
pub struct Snapshots {
    folder: PathBuf,
    plan: SnapshotsScene,
    /// Number of the next multiple of the interval.
    next: u64,
    taken: Vec<(f64, Vec<(String, String)>)>,
    /// Where the fields of each wet face are: hydrodynamic pressure in the water's outputs, hydrostatic pressure in the dam's inputs,
    /// its displacement in the dam's outputs.
    ranges: [[Range<usize>; 3]; 2],
    /// Time and fields of the last accepted step.
    last: (f64, [[Vec<f64>; 3]; 2]),
    still: Option<Still>,
    waters: Vec<Water>,
}

/// The constant data.
struct Still {
    nodes: Vec<[f64; 2]>,
    triangles: Vec<Vec<usize>>,
    /// Zone of each triangle; empty without zones.
    zones: Vec<f64>,
    contacts: Vec<[f64; 2]>,
    faces: [Face; 2],
}

/// Points and normals of a wet face, and its pressure from that at the water's points.
struct Face {
    points: Vec<[f64; 2]>,
    normals: Vec<[f64; 2]>,
    mapping: Mapping,
}

/// The wet faces: name of the part, what the names of the dam's variables begin with, and the water's unit.
const FACES: [(&str, &str, UnitId); 2] =
    [("wet_face", "", RESERVOIR), ("tailwater_wet_face", "tailwater_", TAILWATER)];

const FOLDER: &str = "snapshots";
/// What a dam that is to be shown has.
const NEEDED: [&str; 10] = [
    "node_x",
    "node_y",
    "triangle_node_1",
    "triangle_node_2",
    "triangle_node_3",
    "node_displacement_x",
    "node_displacement_y",
    "stress_xx",
    "stress_yy",
    "stress_xy",
];
/// The parts of a picture.
const PARTS: [&str; 6] =
    ["dam", "contacts", FACES[0].0, FACES[1].0, water_field::PARTS[0], water_field::PARTS[1]];

/// The file of a part of a picture, in the run's folder.
fn file_name(part: &str, number: u64) -> String {
    format!("{FOLDER}/{part}-{number:06}.vtu")
}
/// Tolerance of a multiple, as a share of the interval, because sums of steps are rounded.
const ROUNDING: f64 = 1e-9;

impl Snapshots {
    /// Writes the snapshots of a scene's `plan` into `folder`, with the pressure inside `waters`.
    pub fn new(folder: &Path, plan: SnapshotsScene, waters: Vec<Box<dyn WaterField>>) -> Self {
        Self {
            folder: folder.to_owned(),
            plan,
            next: 0,
            taken: Vec::new(),
            ranges: Default::default(),
            last: Default::default(),
            still: None,
            waters: waters.into_iter().map(Water::new).collect(),
        }
    }

    /// Checks that the dam has what pictures need.
    ///
    /// **Errors**: [`ObserverError::NotTold`].
    pub fn check(start: &Start<'_>) -> Result<(), ObserverError> {
        let lacks = |name: &&&str| start.dam().readable.range(name).is_none();
        NEEDED.iter().find(lacks).map_or(Ok(()), |name| Err(start.not_told("snapshots", name)))
    }

    /// The parts of a snapshot and their names.
    fn parts(&mut self, graph: &mut Graph) -> Result<Vec<(&'static str, Grid)>, ParticipantError> {
        if self.still.is_none() {
            self.still = Some(Still::of(graph)?);
        }
        let dam = &mut graph[DAM];
        let Some(still) = &self.still else { return Ok(Vec::new()) };
        let stress = ["stress_xx", "stress_yy", "stress_xy"];
        let mut cell_data = Vec::new();
        for name in stress {
            cell_data.push(Field::scalar(&format!("{name} [Pa]"), dam.read(name)?));
        }
        let principal: Vec<[f64; 2]> = (0..still.triangles.len())
            .map(|i| {
                let [xx, yy, xy] = [0, 1, 2].map(|k: usize| cell_data[k].values[i]);
                let (mean, radius) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
                [mean + radius, mean - radius]
            })
            .collect();
        for (k, name) in
            ["major_principal_stress [Pa]", "minor_principal_stress [Pa]"].into_iter().enumerate()
        {
            cell_data.push(Field::scalar(name, principal.iter().map(|both| both[k]).collect()));
        }
        if !still.zones.is_empty() {
            cell_data.push(Field::scalar("zone", still.zones.clone()));
        }
        let displacement = pairs(dam, "node_displacement_x", "node_displacement_y")?;
        let concrete = Grid {
            points: still.nodes.clone(),
            cells: still.triangles.clone(),
            point_data: vec![Field::vector("displacement [m]", displacement.into_iter())],
            cell_data,
            field_data: Vec::new(),
        };
        let mut point_data = Vec::new();
        if !still.contacts.is_empty() {
            for (name, unit) in
                [("opening", "m"), ("slip", "m"), ("normal_stress", "Pa"), ("shear_stress", "Pa")]
            {
                let values = dam.read(&format!("contact_{name}"))?;
                point_data.push(Field::scalar(&format!("{name} [{unit}]"), values));
            }
        }
        let contacts = Grid {
            cells: (0..still.contacts.len()).map(|i| vec![i]).collect(),
            points: still.contacts.clone(),
            point_data,
            cell_data: Vec::new(),
            field_data: Vec::new(),
        };
        let mut parts = vec![(PARTS[0], concrete), (PARTS[1], contacts)];
        let (_, fields) = &self.last;
        for (((name, ..), face), fields) in FACES.into_iter().zip(&still.faces).zip(fields) {
            let [hydrodynamic, hydrostatic, displacement] = fields;
            let mut at_points = vec![0.0; face.points.len()];
            if !hydrodynamic.is_empty() {
                face.mapping.adjoint(hydrodynamic, &mut at_points);
            }
            let along = face.normals.iter().zip(displacement).map(|(n, u)| [n[0] * u, n[1] * u]);
            let grid = Grid {
                points: face.points.clone(),
                cells: (1..face.points.len()).map(|i| vec![i - 1, i]).collect(),
                point_data: vec![
                    Field::vector("displacement [m]", along),
                    Field::scalar("hydrodynamic_pressure [Pa]", at_points),
                    Field::scalar("hydrostatic_pressure [Pa]", hydrostatic.clone()),
                ],
                cell_data: Vec::new(),
                field_data: Vec::new(),
            };
            parts.push((name, grid));
        }
        parts.extend(self.waters.iter().map(|water| (water.part(), water.grid())));
        Ok(parts)
    }

    /// Number of the picture that is due at the end of the last window.
    fn due(&self) -> Option<u64> {
        due(&self.plan, self.last.0).filter(|number| *number >= self.next)
    }

    fn write(&self, name: &Path, text: &str) -> Result<(), ObserverError> {
        let path = self.folder.join(name);
        std::fs::write(&path, text).map_err(|cause| write_error(path, cause))
    }
}

impl Still {
    fn of(graph: &mut Graph) -> Result<Self, ParticipantError> {
        let mut mappings = FACES.map(|_| Mapping::identity());
        for (mapping, (_, prefix, _)) in mappings.iter_mut().zip(FACES) {
            let own = graph.interfaces().iter().find(|interface| interface.first.prefix == prefix).cloned();
            let Some(interface) = own else { continue };
            let faces = interface_points(graph, &interface)?.map(|points| points.map(WetFace::new));
            // Units whose points match need no wet faces; others are refused before a run.
            if let Some([Ok(dam), Ok(water)]) = &faces
                && let Ok(found) = Mapping::between(["dam", "water"], dam, water)
            {
                *mapping = found;
            }
        }
        let dam = &mut graph[DAM];
        let [first, second, third] = [1, 2, 3].map(|i| format!("triangle_node_{i}"));
        let corners = pairs(dam, &first, &second)?.into_iter().zip(dam.read(&third)?);
        let triangles = corners.map(|([a, b], c)| [a, b, c].map(|node| node as usize).to_vec()).collect();
        let has = |dam: &dyn Participant, name: &str| dam.description().readable.range(name).is_some();
        // an uncracked dam and one without water have none
        let of = |dam: &mut dyn Participant, x: &str, y: &str| {
            if has(dam, x) { pairs(dam, x, y) } else { Ok(Vec::new()) }
        };
        let face = |dam: &mut dyn Participant, prefix: &str, mapping: Mapping| {
            let [x, y] = ["x", "y"].map(|axis| format!("{prefix}interface_{axis}"));
            let [n_x, n_y] = ["x", "y"].map(|axis| format!("{prefix}interface_normal_{axis}"));
            Ok::<_, ParticipantError>(Face {
                points: of(dam, &x, &y)?,
                normals: of(dam, &n_x, &n_y)?,
                mapping,
            })
        };
        let [of_reservoir, of_tailwater] = mappings;
        let faces = [face(dam, FACES[0].1, of_reservoir)?, face(dam, FACES[1].1, of_tailwater)?];
        let zones = if has(dam, "triangle_zone") { dam.read("triangle_zone")? } else { Vec::new() };
        Ok(Self {
            zones: if zones.iter().any(|zone| *zone != 0.0) { zones } else { Vec::new() },
            nodes: pairs(dam, "node_x", "node_y")?,
            triangles,
            contacts: of(dam, "contact_x", "contact_y")?,
            faces,
        })
    }
}

pub(super) fn pairs(dam: &mut dyn Participant, x: &str, y: &str) -> Result<Vec<[f64; 2]>, ParticipantError> {
    Ok(dam.read(x)?.into_iter().zip(dam.read(y)?).map(|(x, y)| [x, y]).collect())
}

/// Number of the last multiple of `interval` up to `time`, both in s.
pub(super) fn multiples(interval: f64, time: f64) -> u64 {
    (time / interval + ROUNDING).floor() as u64
}

/// Number of the last multiple of the interval up to `time` (s), if a snapshot is due.
fn due(plan: &SnapshotsScene, time: f64) -> Option<u64> {
    let number = multiples(plan.interval, time);
    let (multiple, rounding) = (number as f64 * plan.interval, ROUNDING * plan.interval);
    let early = multiple < plan.from - rounding;
    let late = plan.until.is_some_and(|until| multiple > until + rounding);
    (!early && !late).then_some(number)
}

impl Observer for Snapshots {
    fn begin(&mut self, start: &Start<'_>) -> Result<(), ObserverError> {
        Self::check(start)?;
        let dam = start.dam();
        self.ranges = FACES.map(|(_, prefix, water)| {
            let of = |name: &str| format!("{prefix}{name}");
            let water = start.units.get(water.0);
            [
                water.and_then(|water| water.outputs.range("interface_pressure")),
                dam.inputs.range(&of("hydrostatic_pressure")),
                dam.outputs.range(&of("interface_displacement")),
            ]
            .map(Option::unwrap_or_default)
        });
        self.waters.iter_mut().for_each(|water| water.begin(&start.units));
        let path = self.folder.join(FOLDER);
        std::fs::create_dir_all(&path).map_err(|cause| write_error(path, cause))
    }

    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        if let Some(step) = report.steps.last()
            && let Some(dam) = report.accepted(DAM, step.step)
        {
            let mut fields = <[[Vec<f64>; 3]; 2]>::default();
            for ((fields, ranges), (.., water)) in fields.iter_mut().zip(self.ranges.clone()).zip(FACES) {
                let [hydrodynamic, hydrostatic, displacement] = ranges;
                let answered = report.accepted(water, step.step).map(|water| &water.outputs[hydrodynamic]);
                *fields =
                    [answered.unwrap_or_default(), &dam.inputs[hydrostatic], &dam.outputs[displacement]]
                        .map(<[f64]>::to_vec);
            }
            // to the picosecond, as in the histories
            self.last = ((step.end() * 1e12).round() / 1e12, fields);
        }
        self.waters.iter_mut().try_for_each(|water| water.follow(report))
    }

    /// What the folder holds of the pictures of that time.
    fn past(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        self.window(report)?;
        if let Some(number) = self.due().filter(|_| report.is_accepted()) {
            self.next = number + 1;
            let names = PARTS.iter().map(|part| ((*part).to_owned(), file_name(part, number)));
            let names: Vec<(String, String)> =
                names.filter(|(_, name)| self.folder.join(name).is_file()).collect();
            if !names.is_empty() {
                self.taken.push((self.last.0, names));
            }
        }
        Ok(())
    }

    fn inspect(&mut self, graph: &mut Graph) -> Result<(), ObserverError> {
        let Some(number) = self.due() else { return Ok(()) };
        self.next = number + 1;
        let mut parts = self.parts(graph)?;
        let mut names = Vec::new();
        for (part, grid) in &mut parts {
            if grid.points.is_empty() {
                continue;
            }
            let name = file_name(part, number);
            self.write(Path::new(&name), &grid.vtu())?;
            names.push(((*part).to_owned(), name));
        }
        self.taken.push((self.last.0, names));
        self.write(Path::new("snapshots.pvd"), &vtk::series(&self.taken))
    }

    fn end(&mut self, _ending: &Ending) -> Result<(), ObserverError> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Multiples taken at the ends of steps of 3 ms, whose sums round.
    fn taken(interval: f64, from: f64, until: Option<f64>) -> Vec<u64> {
        let plan = SnapshotsScene { interval, from, until, water: true };
        let mut found = Vec::new();
        for step in 0..=300 {
            let time = f64::from(step) * 3e-3;
            found.extend(due(&plan, time).filter(|number| found.last().is_none_or(|last| number > last)));
        }
        found
    }

    #[test]
    fn pictures_are_those_of_the_multiples_between_the_bounds() {
        assert_eq!(taken(0.3, 0.0, None), [0, 1, 2, 3]);
        assert_eq!(taken(0.3, 0.3, Some(0.6)), [1, 2], "bounds on multiples count");
        assert_eq!(taken(0.3, 0.1, Some(0.8)), [1, 2], "bounds between them make none");
        assert_eq!(taken(0.1, 0.15, Some(0.5)), [2, 3, 4, 5], "multiples between steps are taken after them");
        assert_eq!(taken(1e-3, 0.0, Some(0.01)), [0, 3, 6, 9], "no more than there are steps");
    }
}
