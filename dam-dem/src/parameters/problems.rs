//! What is wrong with the parameters of a dam, by the names of the parameters.

use super::{CrackLine, CrackParameters, DamParameters};
use crate::error::{DamError, Problem, require};
use crate::loads::{Constant, StaticLoad, water_at};
use crate::section::ELEVATION_TOLERANCE;
use crate::wet::Wet;
use crate::{Feature, GeometryError, Mesh};

/// Least height of a row of elements over their nominal size.
const THINNEST_ROW: f64 = 0.1;

/// Triangles of a square of the nominal size, and the most that a dam may have.
const ELEMENTS_A_SQUARE: f64 = 4.0;
const MOST_ELEMENTS: f64 = 1e6;

impl DamParameters {
    /// Checks the parameters, and that the section can be meshed.
    ///
    /// **Errors**: the first of [`problems`](Self::problems).
    pub fn check(&self) -> Result<(), DamError> {
        self.problems().into_iter().next().map_or(Ok(()), |problem| Err(problem.error))
    }

    /// Everything that is wrong with the parameters; of a section that rows of cells cannot fill, what meshing it shows too.
    pub fn problems(&self) -> Vec<Problem> {
        let mut found = Vec::new();
        for (name, value, holds, requirement) in [
            ("element_size", self.element_size, self.element_size > 0.0, "positive"),
            ("gravity", self.gravity, self.gravity >= 0.0, "zero or positive"),
            (
                "time_step_safety",
                self.time_step_safety,
                self.time_step_safety > 0.0 && self.time_step_safety <= 1.0,
                "above 0 and at most 1",
            ),
        ] {
            found.extend(
                require(holds, name, value, requirement).err().map(|error| Problem::of([name], error)),
            );
        }
        for (index, crack) in self.cracks.iter().enumerate() {
            found.extend(crack.problems(index));
        }
        found.extend(self.material.problems());
        for (index, zone) in self.zones.iter().enumerate() {
            found.extend(zone.problems(index, &self.material));
        }
        found.extend(self.damping.problems());
        found.extend(self.fidelity.check(self.cracks.len()).err().map(|error| match error {
            DamError::RigidWithoutCrack => Problem::of(["fidelity", "cracks"], error),
            error => Problem::of(["modes"], error),
        }));
        if !self.fidelity.level().has_elements() && self.damping.local() > 0.0 {
            found.push(Problem::of(["damping.model", "fidelity"], DamError::LocalDampingOfModes));
        }
        for (index, load) in self.static_loads.iter().enumerate() {
            found.extend(load.problem(index, &self.section));
        }
        let sound = |found: &[Problem]| {
            !found.iter().flat_map(|problem| &problem.keys).any(|key| key == "element_size")
        };
        if self.has_layers() {
            found.extend(self.levels());
        } else if sound(&found) {
            let of_mesh = self.of_mesh();
            let meshed = of_mesh.is_empty();
            found.extend(of_mesh);
            if meshed {
                found.extend(self.depths());
            }
        }
        let is_loaded =
            !self.static_loads.is_empty() || self.cracks.iter().any(|crack| crack.uplift.is_some());
        if found.is_empty() && is_loaded {
            found.extend(self.of_loads());
        }
        found
    }

    /// What is wrong with the places of loads in a section and cracks that are right.
    fn of_loads(&self) -> Vec<Problem> {
        let Ok(mesh) = self.mesh() else { return Vec::new() };
        let of_uplift = |(place, &index): (usize, &usize)| {
            let CrackParameters { uplift, line, .. } = &self.cracks[index];
            let water = water_at(&mesh, place, self.water_at_joints())?;
            let error = uplift.as_ref()?.check(&water, self.section.height()).err()?;
            let keys = vec![format!("cracks.{index}.uplift.{}", error.key())];
            Some(Problem { keys, error: DamError::Uplift { elevation: line.elevation(), error } })
        };
        let of_load = |(index, load): (usize, &StaticLoad)| {
            let error = Constant::new(load, &mesh, self.gravity).err()?;
            Some(Problem { keys: vec![format!("static_loads.{index}.{}", load.point_key())], error })
        };
        let order = self.cracks_from_the_base_up();
        let uplift = order.iter().enumerate().filter_map(of_uplift);
        uplift.chain(self.static_loads.iter().enumerate().filter_map(of_load)).collect()
    }

    /// What is wrong with the depths of the water.
    fn depths(&self) -> Vec<Problem> {
        let depths = [
            ("water_depth", self.water_depth, "section.upstream", &self.section.upstream),
            ("tailwater_depth", self.tailwater_depth, "section.downstream", &self.section.downstream),
        ];
        let problem = |(key, depth, section, side): (&str, f64, &str, &Vec<[f64; 2]>)| {
            let crest = side.last().map_or(0.0, |point| point[1]);
            let error = DamError::WaterDepth { depth, crest };
            (!(depth >= 0.0 && depth <= crest)).then(|| Problem::of([key, section], error))
        };
        depths.into_iter().filter_map(problem).collect()
    }

    /// What the mesh of a section without layers shows.
    fn of_mesh(&self) -> Vec<Problem> {
        let wet = |mesh: Mesh| {
            let faces = Wet::below(&mesh, self.water_levels())?.unwrap_or_default().faces;
            let missed = faces.iter().zip(self.water_levels()).find_map(|(face, depth)| {
                let reached = face.as_ref()?.depth();
                // beyond the crest the depth is refused
                (depth <= self.section.height()
                    && (depth - reached).abs() > ELEVATION_TOLERANCE * self.section.height())
                .then_some(DamError::NoPointAtLevel { depth, reached })
            });
            missed.map_or(Ok(()), Err)
        };
        match self.mesh().and_then(wet) {
            Ok(()) => Vec::new(),
            Err(DamError::GivenMesh(error)) => {
                let key = error
                    .crack()
                    .map_or_else(|| "mesh.file".to_owned(), |crack| format!("cracks.{crack}.name"));
                vec![Problem { keys: vec![key], error: error.into() }]
            }
            Err(DamError::Geometry(error)) => {
                let mut keys: Vec<String> =
                    error.features().into_iter().map(|feature| self.key_of(feature)).collect();
                if keys.is_empty() || matches!(error, GeometryError::TooManyCells { .. }) {
                    keys.push("element_size".to_owned());
                }
                vec![Problem { keys, error: error.into() }]
            }
            Err(error @ DamError::NoPointAtLevel { depth, .. }) => {
                let key = if depth == self.water_depth { "water_depth" } else { "tailwater_depth" };
                vec![Problem::of([key, "element_size"], error)]
            }
            Err(error) => vec![Problem::of(["section", "water_depth"], error)],
        }
    }

    /// The parameter of a part of the section.
    fn key_of(&self, feature: Feature) -> String {
        match feature {
            Feature::Base | Feature::Crest => "section".to_owned(),
            Feature::Upstream => "section.upstream".to_owned(),
            Feature::Downstream => "section.downstream".to_owned(),
            Feature::Gallery(index) => format!("section.galleries.{index}"),
            Feature::Zone(index) => format!("zones.{index}.polygon"),
            Feature::Crack(index) => {
                format!(
                    "cracks.{index}.{}",
                    self.cracks.get(index).map_or("polyline", |crack| crack.line.key())
                )
            }
        }
    }

    /// What is wrong with elevations and sizes within a section that is right.
    fn levels(&self) -> Vec<Problem> {
        const SECTION: &str = "section.upstream";
        let mut found = self.depths();
        let (crest, size) = (self.section.height(), self.element_size);
        let margin = ELEVATION_TOLERANCE * crest;
        for (index, crack) in self.cracks.iter().enumerate() {
            let CrackLine::Level(elevation) = crack.line else { continue };
            let key = format!("cracks.{index}.{}", crack.line.key());
            if !(elevation == 0.0 || elevation > margin && elevation < crest - margin) {
                found.push(Problem::of([&key, SECTION], DamError::CrackOutside { elevation, crest }));
            }
            let near = |crack: &CrackParameters| match crack.line {
                CrackLine::Level(other) if (other - elevation).abs() <= margin => Some(other),
                _ => None,
            };
            let others = self.cracks[..index].iter().enumerate();
            if let Some((at, other)) = others.filter_map(|(at, crack)| Some((at, near(crack)?))).next() {
                let error = DamError::DuplicateCrack { elevation, other };
                found.push(Problem::of([&key, &format!("cracks.{at}.elevation")], error));
            }
        }
        if size > crest {
            found.push(Problem::of(["element_size", SECTION], DamError::ElementTooLarge { size, crest }));
        }
        let elements = ELEMENTS_A_SQUARE * self.section.area() / (size * size);
        if elements > MOST_ELEMENTS {
            found.push(Problem::of(["element_size", "section"], DamError::TooManyElements { elements }));
        }
        found.extend(self.thin_rows());
        found
    }

    /// Rows end at vertices, cracks and water levels: two of these close together make flat elements whose
    /// time step is next to nothing.
    fn thin_rows(&self) -> Vec<Problem> {
        let mut levels: Vec<(f64, String)> =
            self.section.vertex_elevations().map(|y| (y, "section".to_owned())).collect();
        levels.push((self.water_depth, "water_depth".to_owned()));
        if self.tailwater_depth > 0.0 {
            levels.push((self.tailwater_depth, "tailwater_depth".to_owned()));
        }
        let cracks = self.cracks.iter().enumerate();
        levels.extend(
            cracks.map(|(index, crack)| (crack.line.elevation(), format!("cracks.{index}.elevation"))),
        );
        levels.sort_by(|a, b| a.0.total_cmp(&b.0));
        let same = ELEVATION_TOLERANCE * self.section.height();
        let least = THINNEST_ROW * self.element_size;
        let thin = levels.windows(2).filter(|pair| (same..least).contains(&(pair[1].0 - pair[0].0)));
        let problem = |pair: &[(f64, String)]| {
            let [(lower, below), (upper, above)] = [&pair[0], &pair[1]];
            let keys = if above == "section" { [below, above] } else { [above, below] };
            let error = DamError::ThinRow { lower: *lower, upper: *upper, least };
            Problem::of([keys[0], keys[1], "element_size"], error)
        };
        thin.map(problem).collect()
    }
}
