//! The manifest of an ensemble: its inputs.

use super::runs::Runs;
use super::{Ensemble, EnsembleError};
use cofferdam_assembly::build_info::SOURCES;
use cofferdam_report::page::not_modelled;
use cofferdam_report::{Build, EnsembleManifest, EnsembleRecord, VariedKey};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;

/// The manifest of an ensemble whose plan has this text.
///
/// **Errors**: a scene cannot be read any more.
pub fn of(runs: &Runs<'_>, text: &str) -> Result<EnsembleManifest, EnsembleError> {
    let Ensemble { plan, samples, measure, .. } = runs.ensemble;
    let loaded = runs.ensemble.scene(0)?;
    let mut scene = loaded.scene.clone();
    scene.ground_motion.record = None;
    let scene_text = toml::to_string(&scene).map_err(|cause| EnsembleError::Format(cause.into()))?;
    let mut records = Vec::new();
    for (number, record) in plan.records.iter().enumerate() {
        // Every record has a sample.
        let Some(index) = samples.iter().position(|sample| sample.record == number) else { continue };
        let of_scene = runs.ensemble.scene(index)?.scene.ground_motion.record;
        records.push(EnsembleRecord {
            name: record.name.clone(),
            file: record
                .file
                .file_name()
                .map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
            pair: record.pair.clone(),
            factor: record.factor,
            measure: samples[index].intensity / samples[index].scale,
            sha256: of_scene.and_then(|record| record.sha256).unwrap_or_default(),
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
        polarities: plan.polarities.clone(),
        samples: plan.samples,
        seed: plan.seed,
        perturbation: plan.perturbation.map(|perturbation| (perturbation.count, perturbation.noise)),
        set: plan.set.clone(),
        shown: runs.shown().map(|(name, _)| name).collect(),
        not_modelled: not_modelled(&scene),
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

fn sha256(text: &str) -> String {
    Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
}
