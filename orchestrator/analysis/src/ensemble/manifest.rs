//! The manifest of an ensemble: its inputs.

use super::runs::Runs;
use super::{Ensemble, EnsembleError};
use cofferdam_assembly::build_info::SOURCES;
use cofferdam_report::page::not_modelled;
use cofferdam_report::{Build, EnsembleManifest, EnsembleRecord, EnsembleVertical, VariedKey};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::Path;

/// The manifest of an ensemble whose plan has this text.
///
/// **Errors**: a scene cannot be read any more.
pub fn of(runs: &Runs<'_>, text: &str) -> Result<EnsembleManifest, EnsembleError> {
    let Ensemble { plan, samples, measure, .. } = runs.ensemble;
    let loaded = runs.ensemble.scene(0)?;
    let mut scene = loaded.scene.clone();
    let not_modelled = not_modelled(&scene);
    (scene.ground_motion.record, scene.ground_motion.vertical) = (None, None);
    let scene_text = toml::to_string(&scene).map_err(|cause| EnsembleError::Format(cause.into()))?;
    let mut records = Vec::new();
    for (number, record) in plan.records.iter().enumerate() {
        // Every record has a sample.
        let Some(index) = samples.iter().position(|sample| sample.record == number) else { continue };
        let of_scene = runs.ensemble.scene(index)?.scene.ground_motion;
        records.push(EnsembleRecord {
            name: record.name.clone(),
            file: name_of(&record.file),
            pair: record.pair.clone(),
            factor: record.factor,
            measure: samples[index].intensity / samples[index].scale,
            sha256: of_scene.record.and_then(|record| record.sha256).unwrap_or_default(),
            vertical: of_scene.vertical.map(|vertical| EnsembleVertical {
                file: vertical.file.map_or_else(String::new, |file| name_of(&file)),
                column: vertical.column,
                scale: vertical.scale,
                polarity: vertical.polarity,
                sha256: vertical.sha256.unwrap_or_default(),
            }),
        });
    }
    let varied = |keys: &BTreeMap<String, super::plan::Variation>| {
        keys.iter().map(|(key, by)| VariedKey { key: key.clone(), by: by.to_string() }).collect()
    };
    Ok(EnsembleManifest {
        title: plan.title.clone(),
        scene: scene.title.clone(),
        measure: measure.clone(),
        levels: plan.intensity.level_names(),
        added: super::limits::names(&runs.ensemble.added, &plan.intensity),
        independent: runs.independent(),
        polarities: plan.polarities.clone(),
        samples: plan.samples,
        seed: plan.seed,
        perturbation: plan.perturbation.map(|perturbation| (perturbation.count, perturbation.noise)),
        set: plan.set.clone(),
        shown: runs.shown().map(|(name, _)| name).collect(),
        not_modelled,
        warnings: runs.ensemble.warnings()?,
        plan_sha256: sha256(text),
        scene_sha256: sha256(&scene_text),
        sources: SOURCES.to_owned(),
        build: Build::here(),
        records,
        parameters: varied(&plan.parameters),
        numerics: varied(&plan.numerics),
    })
}

fn name_of(file: &Path) -> String {
    file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

fn sha256(text: &str) -> String {
    Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
}
