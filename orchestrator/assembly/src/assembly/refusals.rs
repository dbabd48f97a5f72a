//! Objections of the built-in units to a scene, at the keys of the scene.

use super::Assembly;
use cofferdam_dam::DamError;
use cofferdam_reservoir::ReservoirError;
use cofferdam_scene::{DamScene, LoadedScene, Refusal, Scene, SceneError, Side, UnitChecks};
use std::path::Path;

/// Reads the scene at `path` as [`LoadedScene::read`] does; the built-in units are asked whether they can be made.
///
/// **Errors**: every problem of the scene at once.
pub fn read_scene(path: &Path, overrides: &[String]) -> Result<LoadedScene, SceneError> {
    LoadedScene::read(path, overrides, &UnitChecks { dam: refused_by_dam, reservoir: refused_by_reservoir })
}

/// What the dam says against a scene.
fn refused_by_dam(scene: &Scene) -> Vec<Refusal> {
    // A crack that is nowhere is reported elsewhere.
    let placed = |dam: &&DamScene| dam.cracks.iter().all(|crack| crack.line().is_some());
    let assembly = Assembly::of(scene);
    let Some(Ok(parameters)) = scene.dam.as_ref().filter(placed).map(|dam| assembly.dry_dam(dam)) else {
        return Vec::new();
    };
    let radians = scene.dam.as_ref().is_some_and(|dam| dam.damping.radians_per_second.is_some());
    let frequencies = if radians { "radians_per_second" } else { "multiples_of_first" };
    let key = |path: &String| match path.as_str() {
        "water_depth" => "reservoir.depth".to_owned(),
        "tailwater_depth" => "tailwater.depth".to_owned(),
        "gravity" => path.clone(),
        path if path.starts_with("static_loads.") => of_load(scene, path),
        "damping.frequencies" => format!("dam.damping.{frequencies}"),
        _ => format!("dam.{path}"),
    };
    let problems = parameters.problems().into_iter();
    let cracks = scene.dam.iter().flat_map(|dam| &dam.cracks);
    let names: Vec<Option<String>> =
        cracks.map(|crack| crack.name.as_ref().map(|_| crack.phrase())).collect();
    let message = |error: DamError| match error {
        DamError::Geometry(error) => error.with_names(&names),
        error => error.to_string(),
    };
    let mut refusals: Vec<Refusal> = problems
        .map(|problem| Refusal {
            keys: problem.keys.iter().map(key).collect(),
            message: message(problem.error),
        })
        .collect();
    if refusals.is_empty() {
        let falls = assembly.limit_equilibria().unwrap_or_default().into_iter().filter_map(|equilibrium| {
            let error = equilibrium.check().err()?;
            let index = parameters.cracks_from_the_base_up()[equilibrium.crack];
            let keys = vec![format!("dam.cracks.{index}.friction_coefficient"), "reservoir.depth".to_owned()];
            Some(Refusal { keys, message: error.to_string() })
        });
        refusals.extend(falls);
    }
    refusals
}

/// The key of the scene for a `path` such as `static_loads.0.depth`.
fn of_load(scene: &Scene, path: &str) -> String {
    let mut parts = path.splitn(3, '.').skip(1);
    let index = parts.next().and_then(|index| index.parse::<usize>().ok());
    let load = index.and_then(|index| scene.static_loads().into_iter().nth(index));
    match (load, parts.next()) {
        (Some((key, _)), Some(name)) => format!("{key}.{name}"),
        _ => "loads".to_owned(),
    }
}

/// What the reservoir and the tailwater say against a scene, before its dam, which has nothing to say.
fn refused_by_reservoir(scene: &Scene) -> Vec<Refusal> {
    Side::BOTH.into_iter().flat_map(|side| refused_by_water(scene, side)).collect()
}

fn refused_by_water(scene: &Scene, side: Side) -> Vec<Refusal> {
    let Some(water) = scene.water(side).filter(|water| water.solver().is_some()) else {
        return Vec::new();
    };
    let parameters = match Assembly::of(scene).water_parameters(side) {
        Ok(parameters) => parameters,
        Err(error) => {
            return vec![Refusal { keys: vec![side.key("depth")], message: error.to_string() }];
        }
    };
    let refusal = |(parameter, error): (&str, ReservoirError)| {
        let key = match parameter {
            "communication_step" => "time.communication_step".to_owned(),
            "horizon" => "time.duration".to_owned(),
            "gravity" => parameter.to_owned(),
            // Where the scene does not give it, it follows from the panels or from the dam's elements.
            "element_size" if water.element_size.is_none() => match water.interface_size {
                Some(_) => side.key("interface_size"),
                None if scene.dam.is_some() => "dam.element_size".to_owned(),
                None => "prescribed.panels".to_owned(),
            },
            _ => side.key(parameter),
        };
        Refusal { keys: vec![key], message: error.to_string().replace("`horizon`", "`time.duration`") }
    };
    parameters.problem().map(refusal).into_iter().collect()
}
