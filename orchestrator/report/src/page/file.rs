//! Writes pages, each completely or not at all.

use super::ensemble::{self, EnsembleData, EnsembleFolder};
use super::{ReportData, ReportError, RunFolder, html, pair};
use crate::{Manifest, RangeError, RangeRecord, section};
use cofferdam_assembly::observer::Histories;
use cofferdam_log::LogReadError;
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

/// Name of the page in the folder of a run.
const NAME: &str = "report.html";

/// Reason why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// The folder of a run or an ensemble.
    #[error(transparent)]
    Run(#[from] ReportError),
    /// The log of a run.
    #[error(transparent)]
    Log(#[from] LogReadError),
    /// The range of the run's scene.
    #[error(transparent)]
    Range(#[from] RangeError),
    /// A range for a page that has no place for it.
    #[error("--range {}: {} is the folder of an ensemble; give that of a run", range.display(), folder.display())]
    RangeOfEnsemble {
        /// The folder of the range.
        range: PathBuf,
        /// The folder of the ensemble.
        folder: PathBuf,
    },
    /// A run that is compared with itself.
    #[error("{} is given twice; give the folders of two runs", path.display())]
    Twice {
        /// The folder.
        path: PathBuf,
    },
    /// A page that cannot be written.
    #[error("{}: {cause}; {}", path.display(), remedy(cause))]
    Write {
        /// The page.
        path: PathBuf,
        /// The cause.
        cause: Error,
    },
}

fn remedy(cause: &Error) -> &'static str {
    match cause.kind() {
        ErrorKind::NotFound => "create the folder first, or choose another --output",
        ErrorKind::FileTooLarge => "raise the limit of file sizes (`ulimit -f`)",
        _ => "free some space or choose another --output",
    }
}

/// Writes the page of the run or the ensemble in `folder` to `output`, by default `report.html` there, and returns its path. The page of a
/// run has the range of its scene in the folder `range`, if one is given.
///
/// **Errors**: [`PageError`].
pub fn write_folder(
    folder: &Path,
    output: Option<&Path>,
    range: Option<&Path>,
) -> Result<PathBuf, PageError> {
    let path = output.map_or_else(|| folder.join(NAME), Path::to_owned);
    if !EnsembleFolder::is(folder) {
        write(RunFolder::read(folder)?, range, &path)?;
    } else if let Some(range) = range {
        return Err(PageError::RangeOfEnsemble { range: range.to_owned(), folder: folder.to_owned() });
    } else {
        save(&ensemble::html(&EnsembleData::of(&EnsembleFolder::read(folder)?)), &path)?;
    }
    Ok(path)
}

/// Writes the page that compares the runs in two folders, the first as the reference, to `output`, by default `report-OTHER.html` in
/// the first, and returns its path.
///
/// **Errors**: [`PageError`].
pub fn write_pair(folder: &Path, other: &Path, output: Option<&Path>) -> Result<PathBuf, PageError> {
    let runs = [RunFolder::read(folder)?, RunFolder::read(other)?];
    let whole = [folder, other].map(|path| path.canonicalize().unwrap_or_else(|_| path.to_owned()));
    if whole[0] == whole[1] {
        return Err(PageError::Twice { path: other.to_owned() });
    }
    let names = whole.map(|path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned());
    let path = output.map_or_else(|| folder.join(format!("report-{}.html", names[1])), Path::to_owned);
    let [a, b] = &runs;
    save(&pair::html(&pair::PairData::of([a, b], names)?), &path)?;
    Ok(path)
}

/// Writes the page of an ensemble into its `folder`.
///
/// **Errors**: [`PageError`].
pub fn write_ensemble(folder: &Path) -> Result<(), PageError> {
    save(&ensemble::html(&EnsembleData::of(&EnsembleFolder::read(folder)?)), &folder.join(NAME))
}

/// Writes the page of a run that has just ended in `folder`.
///
/// **Errors**: [`PageError`]; there is nothing to show of a run without a step, which is none.
pub fn write_run(folder: &Path, manifest: &Manifest, histories: &Histories) -> Result<(), PageError> {
    match RunFolder::of(manifest.clone(), histories.clone(), &folder.join("log.mcap")) {
        Err(ReportError::NoStep { .. }) => Ok(()),
        run => write(run?, None, &folder.join(NAME)),
    }
}

fn write(run: RunFolder, range: Option<&Path>, path: &Path) -> Result<(), PageError> {
    let range = range.map(|range| RangeRecord::of_scene(range, &run.loaded.scene)).transpose()?;
    // A mesh that can no longer be made leaves the picture out, not the page.
    let picture = section::figure(&run.loaded.scene).ok();
    let data = ReportData::of(&run, picture)?;
    let data = match &range {
        Some(range) => data.with_range(range),
        None => data,
    };
    save(&html(&data), path)
}

/// Writes a page whole or not at all.
fn save(text: &str, path: &Path) -> Result<(), PageError> {
    let mut draft = path.as_os_str().to_owned();
    draft.push(".part");
    std::fs::write(&draft, text).and_then(|()| std::fs::rename(&draft, path)).map_err(|cause| {
        // The error of writing is reported, not one of removing.
        let _ = std::fs::remove_file(&draft);
        PageError::Write { path: path.to_owned(), cause }
    })
}
