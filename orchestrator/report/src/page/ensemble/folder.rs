//! The files of an ensemble.

use super::super::folder::ReportError;
use crate::EnsembleManifest;
use std::path::Path;

/// Files of an ensemble's folder.
#[derive(Clone, Debug)]
pub struct EnsembleFolder {
    /// `ensemble.toml`.
    pub manifest: EnsembleManifest,
    /// Text of `plan.toml`.
    pub plan: String,
    /// A row for each run.
    pub results: Table,
    /// Statistics of every quantity at every level.
    pub statistics: Table,
    /// The fragility curve of each limit.
    pub limits: Table,
    /// Runs that exceed each limit at each level.
    pub exceedance: Table,
    /// Shares of the variance.
    pub variance: Table,
    /// Comparison of methods; empty without `[numerics]`.
    pub methods: Table,
    /// Factors of the records to a target spectrum; empty without one.
    pub target: Table,
    /// Governing joint; empty with a single joint.
    pub joints: Table,
    /// Governing polarity; empty with a single polarity.
    pub polarities: Table,
    /// The incremental dynamic analysis, SVG.
    pub analysis: Option<String>,
    /// The fragility curves, SVG.
    pub fragility: Option<String>,
    /// The scaled spectra and their target, SVG.
    pub spectra: Option<String>,
}

/// A table of text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Headings.
    pub headings: Vec<String>,
    /// Rows, each as long as the headings.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Number of the column `name`.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.headings.iter().position(|heading| heading == name)
    }

    fn read(path: &Path) -> Result<Self, ReportError> {
        let failed =
            |cause: csv::Error| ReportError::Table { path: path.to_owned(), cause: cause.to_string() };
        let mut reader = csv::Reader::from_path(path).map_err(failed)?;
        let words = |row: &csv::StringRecord| row.iter().map(str::to_owned).collect();
        let headings = words(reader.headers().map_err(failed)?);
        let rows: Result<_, _> =
            reader.records().map(|row| row.map(|row| words(&row)).map_err(failed)).collect();
        Ok(Self { headings, rows: rows? })
    }
}

/// Remedy for a missing file.
const REMEDY: &str =
    "`cofferdam ensemble PLAN --output FOLDER` writes it; samples already in the folder are not run again";

impl EnsembleFolder {
    /// Whether `folder` is one of an ensemble, whether or not it has come to its end.
    pub fn is(folder: &Path) -> bool {
        folder.join("plan.toml").is_file() && folder.join("samples").is_dir()
    }

    /// Reads the folder.
    ///
    /// **Errors**: [`ReportError`]; a file that is missing is named with the remedy.
    pub fn read(folder: &Path) -> Result<Self, ReportError> {
        let path = |name: &str| {
            let path = folder.join(name);
            if path.is_file() { Ok(path) } else { Err(ReportError::Missing { path, remedy: REMEDY }) }
        };
        let table = |name: &str| Table::read(&path(name)?);
        let text = |name: &str| {
            let path = path(name)?;
            std::fs::read_to_string(&path)
                .map_err(|cause| ReportError::Table { path, cause: cause.to_string() })
        };
        // Optional files.
        let there = |name: &str| folder.join(name).is_file();
        let picture = |name: &str| if there(name) { text(name).map(Some) } else { Ok(None) };
        let further = |name: &str| if there(name) { table(name) } else { Ok(Table::default()) };
        Ok(Self {
            manifest: EnsembleManifest::read(&path("ensemble.toml")?)?,
            plan: text("plan.toml")?,
            results: table("results.csv")?,
            statistics: table("statistics.csv")?,
            limits: table("limits.csv")?,
            exceedance: table("exceedance.csv")?,
            variance: table("variance.csv")?,
            methods: further("methods.csv")?,
            target: further("target.csv")?,
            joints: further("joints.csv")?,
            polarities: further("polarities.csv")?,
            analysis: picture("ida.svg")?,
            fragility: picture("fragility.svg")?,
            spectra: picture("spectra.svg")?,
        })
    }
}
