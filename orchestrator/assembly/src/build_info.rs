//! What this program was built from, and where it runs.

use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::sync::OnceLock;

/// Hash of the sources of the solvers, by which prepared operators are made.
pub const SOLVERS: &str = env!("COFFERDAM_SOLVERS");
/// Hash of all sources, by which results are made.
pub const SOURCES: &str = env!("COFFERDAM_SOURCES");

/// Git commit of the program, once it has said it.
static COMMIT: OnceLock<&str> = OnceLock::new();

/// Sets the git commit that logs, manifests and pages name, "unknown" until then. Only a program's own build knows it: a
/// library that did would be compiled again after each commit.
pub fn set_commit(commit: &'static str) {
    // The first call counts.
    let _ = COMMIT.set(commit);
}

/// The program and the machine it runs on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Build {
    /// Version of the program.
    pub version: Cow<'static, str>,
    /// Git commit of the program.
    pub commit: Cow<'static, str>,
    /// Optimised or not.
    pub profile: Cow<'static, str>,
    /// Processor.
    pub processor: String,
    /// What the processor offers beyond its architecture of what numerical libraries choose their code by.
    pub features: String,
    /// Cores that the program may use.
    pub cores: usize,
    /// Operating system and architecture.
    pub system: String,
}

impl Build {
    /// This program on this machine.
    pub fn here() -> Self {
        let cpu_info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = cpu_info.lines().find_map(|l| l.strip_prefix("model name")?.split_once(": "));
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            commit: COMMIT.get().copied().unwrap_or("unknown").into(),
            profile: if cfg!(debug_assertions) { "debug" } else { "release" }.into(),
            processor: model.map_or_else(|| "unknown".to_owned(), |(_, name)| name.to_owned()),
            features: features(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        }
    }
}

/// The features of the processor that numerical libraries choose their code by.
pub fn features() -> String {
    #[cfg(target_arch = "x86_64")]
    {
        let found = [
            ("sse4.1", std::arch::is_x86_feature_detected!("sse4.1")),
            ("avx", std::arch::is_x86_feature_detected!("avx")),
            ("avx2", std::arch::is_x86_feature_detected!("avx2")),
            ("fma", std::arch::is_x86_feature_detected!("fma")),
            ("avx512f", std::arch::is_x86_feature_detected!("avx512f")),
        ];
        let names = found.iter().filter(|(_, there)| *there).map(|(name, _)| *name);
        names.collect::<Vec<_>>().join(" ")
    }
    #[cfg(not(target_arch = "x86_64"))]
    String::new()
}
