//! The context that a caller passes to every computation of this crate.

use cofferdam_assembly::Making;
use cofferdam_assembly::cache::Cache;
use cofferdam_scene::SceneWarning;
use std::num::NonZeroUsize;
use std::path::Path;

/// Where lines for people go. This crate prints nothing itself.
///
/// Methods are called in the order of events, in the thread of the caller or, in ensembles, by one worker at a time or another.
pub trait Reporter: Sync {
    /// A line, or several, about what is done and found.
    fn line(&self, text: &str);

    /// A line about what is doubtful, or is left out.
    fn warning(&self, text: &str);

    /// Doubtful choices of a scene, with their places in its file; by default each as a [`warning`](Self::warning).
    fn scene_warnings(&self, warnings: &[SceneWarning]) {
        for warning in warnings {
            self.warning(&warning.to_string());
        }
    }
}

/// Discards everything.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Reporter for Silent {
    fn line(&self, _: &str) {}

    fn warning(&self, _: &str) {}
}

/// The cache of prepared operators, the program that hosts units, and where lines go.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// Prepared operators of the water; without one they are prepared each time.
    pub cache: Option<&'a Cache>,
    /// The command whose `unit NAME` serves a built-in unit over shared memory; by default the program of this process.
    pub program: Option<&'a Path>,
    /// Where lines for people go.
    pub reporter: &'a dyn Reporter,
}

impl Default for Context<'_> {
    /// Without cache and silent.
    fn default() -> Self {
        Self { cache: None, program: None, reporter: &Silent }
    }
}

impl<'a> Context<'a> {
    /// Making units on these threads.
    pub fn making(&self, threads: NonZeroUsize) -> Making<'a> {
        Making { threads, cache: self.cache }
    }

    /// Reports a line.
    pub(crate) fn line(&self, text: impl AsRef<str>) {
        self.reporter.line(text.as_ref());
    }

    /// Reports a warning.
    pub(crate) fn warning(&self, text: impl AsRef<str>) {
        self.reporter.warning(text.as_ref());
    }
}

/// The requested number of threads, or one per core.
pub fn threads(requested: Option<u16>) -> NonZeroUsize {
    let requested = requested.and_then(|n| NonZeroUsize::new(n.into()));
    requested.or(std::thread::available_parallelism().ok()).unwrap_or(NonZeroUsize::MIN)
}
