//! A shipped scene as its text, changed by hand, and what is said about it.

use crate::scenario::root;
use cofferdam_scene::{LoadedScene, SceneError};
use miette::{
    Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report,
};
use std::path::PathBuf;
use std::sync::Arc;
use tempfile::TempDir;

/// The text of a shipped scene.
pub fn shipped(case: &str) -> String {
    std::fs::read_to_string(root().join("scenes").join(case).join("scene.toml")).expect("a shipped scene")
}

/// A folder like `scenes/`, in which a scene can be written again and again.
pub struct Desk(TempDir);

impl Default for Desk {
    fn default() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let copies = folder.path().join("records");
        std::fs::create_dir(&copies).expect("a folder");
        std::fs::create_dir(folder.path().join("case")).expect("a folder");
        let record = "northridge-1994-canyon-country-270.csv";
        std::fs::copy(root().join("scenes/records").join(record), copies.join(record)).expect("the record");
        Self(folder)
    }
}

impl Desk {
    /// Path of a file in the scene's folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.0.path().join("case").join(name)
    }

    /// Reads a scene of this text.
    pub fn read(&self, text: impl AsRef<[u8]>, set: &[&str]) -> Result<LoadedScene, SceneError> {
        std::fs::write(self.file("scene.toml"), text).expect("the scene is written");
        let set: Vec<String> = set.iter().map(|text| (*text).to_owned()).collect();
        cofferdam_assembly::read_scene(&self.file("scene.toml"), &set)
    }

    /// What a terminal of 100 columns shows, paths without this folder.
    pub fn shown(&self, diagnostic: &dyn Diagnostic) -> String {
        let hidden = |text: String| text.replace(&format!("{}/", self.0.path().display()), "");
        let mut shown = MietteDiagnostic::new(hidden(diagnostic.to_string()));
        shown.severity = diagnostic.severity();
        shown.labels = diagnostic.labels().map(Iterator::collect::<Vec<LabeledSpan>>);
        let mut report = Report::new(shown);
        // The whole source is asked for by way of any span.
        let whole = diagnostic.source_code().zip(diagnostic.labels().and_then(|mut labels| labels.next()));
        if let Some((source, label)) = whole {
            let read =
                source.read_span(label.inner(), usize::MAX, usize::MAX).expect("a place in the source");
            let text = String::from_utf8_lossy(read.data()).into_owned();
            let name = hidden(read.name().unwrap_or("").to_owned());
            report = report.with_source_code(NamedSource::new(name, Arc::new(text)));
        }
        let mut text = String::new();
        let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor());
        let handler = handler.with_width(100).with_links(false);
        handler.render_report(&mut text, report.as_ref()).expect("a report");
        let lines: Vec<&str> = text.lines().map(str::trim_end).collect();
        lines.join("\n") + "\n"
    }
}
