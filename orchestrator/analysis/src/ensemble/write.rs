//! Writes tables, text and pictures of an ensemble that has been run.

use super::runs::Runs;
use super::sample::Kept;
use super::{Ensemble, EnsembleError, figure, joints, limits, manifest, methods, polarities, tables};
use crate::context::Context;
use crate::parquet;
use crate::table::Table;
use std::path::Path;

/// Writes everything of an ensemble whose plan has this text, and returns the text of `ensemble.md`.
///
/// **Errors**: a file that cannot be written.
pub fn all(
    ensemble: &Ensemble,
    kept: &[Kept],
    plan: &str,
    folder: &Path,
    context: &Context<'_>,
) -> Result<String, EnsembleError> {
    let runs = Runs::of(ensemble, kept);
    let save = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).map_err(|cause| EnsembleError::File { path, cause: cause.into() })
    };
    let save_table = |name: &str, table: &Table| save(name, &table.csv().map_err(EnsembleError::Format)?);
    let (results, text_columns) = runs.results();
    save_table("results.csv", &results)?;
    let target = folder.join("results.parquet");
    let text_columns: Vec<&str> = text_columns.iter().map(String::as_str).collect();
    parquet::write(&folder.join("results.csv"), &target, &text_columns)
        .map_err(|cause| EnsembleError::File { path: target, cause })?;
    let (statistics, short) = runs.statistics();
    save_table("statistics.csv", &statistics)?;
    let intensities = runs.intensities();
    let limits = runs.limits();
    save_table("fragility.csv", &tables::curves(&limits, &intensities, &ensemble.measure))?;
    save_table("limits.csv", &limits::fits(&limits, &runs))?;
    save_table("exceedance.csv", &limits::exceedance(&runs, &limits))?;
    let manifest = toml::to_string(&manifest::of(&runs, plan)?);
    save("ensemble.toml", &manifest.map_err(|cause| EnsembleError::Format(cause.into()))?)?;
    let (variance, shares) = runs.variance();
    save_table("variance.csv", &variance)?;
    let mut text = runs.opening();
    if let Some(scaled) = &ensemble.scaled {
        let (table, short) = scaled.tables(&ensemble.plan.records);
        text.push_str(&scaled.about());
        text.push_str(&short.markdown());
        text.push('\n');
        save_table("target.csv", &table)?;
        save("spectra.svg", &figure::spectra(scaled)?)?;
    }
    text.push_str(&short.markdown());
    if let Some(sentence) = runs.without_intervals() {
        text.push_str(&format!("\n{sentence}\n"));
    }
    if let Some((table, short)) = joints::governing(&runs) {
        text.push_str("\nGoverning joint.\n\n");
        text.push_str(&short.markdown());
        save_table("joints.csv", &table)?;
    }
    if let Some((table, short)) = polarities::governing(&runs) {
        text.push_str("\nGoverning polarity: larger magnitude (median of several runs).\n\n");
        text.push_str(&short.markdown());
        save_table("polarities.csv", &table)?;
    }
    if !limits.is_empty() {
        let [curves, levels] = limits::short(&limits, &runs);
        text.push_str(&format!(
            "\nProbability of exceeding a limit over {}: penalised probit fit; 95 % intervals by leaving out one record or pair at a time.\n\n{}",
            ensemble.measure,
            curves.markdown()
        ));
        text.push_str(&format!(
            "\nRuns that exceed a limit, with exact 95 % intervals of independent records or pairs.\n\n{}",
            levels.markdown()
        ));
        if let Some(advice) = limits::advice(&limits) {
            text.push_str(&format!("\n{advice}\n"));
        }
    }
    if let Some(shares) = shares {
        text.push_str(&format!(
            "\nSources of the variance at one level of shaking, %: main effects; the remainder is interaction.\n\n{}",
            shares.markdown()
        ));
    }
    if let Some(table) = methods::compare(&runs) {
        text.push_str(&format!(
            "\nComparison of methods: medians for the same motions, 90 % bootstrap intervals; p values with Holm's correction over all pairs of a quantity.\n\n{}",
            table.markdown()
        ));
        save_table("methods.csv", &table)?;
    }
    context.line(&text);
    save("ensemble.md", &text)?;
    if let Some(picture) = runs.analysis()? {
        save("ida.svg", &picture)?;
    }
    if !limits.is_empty() {
        save("fragility.svg", &figure::fragility(&ensemble.measure, &intensities, &limits)?)?;
    }
    Ok(text)
}
