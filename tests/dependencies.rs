//! Who may depend on whom, kept by reading the sources.

use std::path::Path;
use whole_chain::scenario::root;

/// A rule: in files whose path starts with `within`, but with none of `except`, `word` must not stand.
struct Rule {
    within: &'static str,
    except: &'static [&'static str],
    words: &'static [&'static str],
    why: &'static str,
}

const RULES: &[Rule] = &[
    Rule {
        within: "reservoir-fmu/src",
        except: &[],
        words: &[
            "std::fs",
            "std::time",
            "std::thread",
            "std::net",
            "std::env",
            "println!",
            "dam_dem",
            "orchestrator",
        ],
        why: "solvers use mathematics, serde and the contract only, and speak through tracing",
    },
    Rule {
        within: "dam-dem/src",
        except: &[],
        words: &[
            "std::fs",
            "std::time",
            "std::thread",
            "std::net",
            "std::env",
            "println!",
            "reservoir::",
            "orchestrator",
        ],
        why: "solvers use mathematics, serde and the contract only, and speak through tracing",
    },
    Rule {
        within: "reservoir-fmu/src",
        except: &["reservoir-fmu/src/reservoir.rs", "reservoir-fmu/src/lib.rs"],
        words: &["CoSimulation"],
        why: "beneath reservoir.rs nothing knows that coupling exists",
    },
    Rule {
        within: "dam-dem/src",
        except: &["dam-dem/src/dam.rs", "dam-dem/src/lib.rs"],
        words: &["CoSimulation"],
        why: "beneath dam.rs nothing knows that coupling exists",
    },
    Rule {
        within: "reservoir-fmu/src",
        except: &["reservoir-fmu/src/reservoir.rs"],
        words: &["tracing"],
        why: "a unit speaks in reservoir.rs alone",
    },
    Rule {
        within: "dam-dem/src",
        except: &["dam-dem/src/dam.rs"],
        words: &["tracing"],
        why: "a unit speaks in dam.rs alone",
    },
    Rule {
        within: "orchestrator/src",
        except: &[
            "orchestrator/src/registry.rs",
            "orchestrator/src/packing/",
            "orchestrator/src/cli/reservoir/",
            "orchestrator/src/cli/study/resolution.rs",
        ],
        words: &["dam_dem", "reservoir::{", "reservoir::Re", "reservoir::F", "reservoir::a"],
        why: "only the registry of built-in units, their packing, the water's own command and its study know the solvers",
    },
    Rule {
        within: "orchestrator/src",
        except: &["orchestrator/src/log/"],
        words: &["mcap::", "prost"],
        why: "MCAP is the log's business",
    },
    Rule {
        within: "orchestrator/src",
        except: &["orchestrator/src/transport/"],
        words: &["iceoryx2"],
        why: "iceoryx2 is the transport's business",
    },
    Rule {
        within: "orchestrator/src",
        except: &["orchestrator/src/fmu/"],
        words: &["zip::", "ZipWriter", "ZipArchive"],
        why: "archives are the business of FMUs",
    },
    Rule {
        within: "",
        except: &["interface/src/export/"],
        words: &["no_mangle", "extern \"C\""],
        why: "C symbols are exported through interface::export",
    },
    Rule {
        within: "reservoir-fmu/src/analytical",
        except: &[],
        words: &["use crate::", "use super::super"],
        why: "closed forms call no solver code",
    },
    Rule {
        within: "dam-dem/src/analytical",
        except: &[],
        words: &["use crate::", "use super::super"],
        why: "closed forms call no solver code",
    },
    Rule {
        within: "orchestrator/src/scheme",
        except: &[],
        words: &["println!", "tracing", "crate::log", "crate::observer"],
        why: "schemes return a report, they never log",
    },
    Rule {
        within: "orchestrator/src/acceleration",
        except: &[],
        words: &["println!", "tracing", "crate::log", "crate::observer"],
        why: "accelerations never log",
    },
];

/// Which rules the text of a file breaks.
fn broken(path: &str, text: &str) -> Vec<String> {
    let applies =
        |rule: &&Rule| path.starts_with(rule.within) && !rule.except.iter().any(|e| path.starts_with(e));
    let production = text.split("#[cfg(test)]").next().unwrap_or("");
    let code: Vec<&str> = production.lines().map(|l| l.split("//").next().unwrap_or("")).collect();
    let found = |rule: &Rule| {
        let words = rule.words.iter().filter(|word| code.iter().any(|line| line.contains(**word)));
        words.map(|word| format!("{path}: `{word}`, but {}", rule.why)).collect::<Vec<_>>()
    };
    RULES.iter().filter(applies).flat_map(found).collect()
}

fn sources(folder: &Path, found: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn every_source_keeps_the_rules() {
    let mut files = Vec::new();
    let units = ["reservoir-fmu/src", "reservoir-fmu/fmu/src", "dam-dem/src", "dam-dem/fmu/src"];
    for package in units.into_iter().chain(["interface/src", "orchestrator/src"]) {
        sources(&root().join(package), &mut files);
    }
    assert!(files.len() > 40, "{} sources found", files.len());
    let mut problems = Vec::new();
    for file in files {
        let text = std::fs::read_to_string(&file).expect("a source");
        let path =
            file.strip_prefix(root()).expect("inside the project").to_string_lossy().replace('\\', "/");
        problems.extend(broken(&path, &text));
    }
    assert!(problems.is_empty(), "{problems:#?}");
}

#[test]
fn manifests_keep_the_rules() {
    let forbidden = [
        ("interface", vec!["reservoir", "dam_dem", "orchestrator"]),
        ("reservoir-fmu", vec!["dam_dem", "orchestrator", "mcap", "iceoryx2"]),
        ("dam-dem", vec!["reservoir", "orchestrator", "mcap", "iceoryx2"]),
    ];
    for (package, names) in forbidden {
        let text = std::fs::read_to_string(root().join(package).join("Cargo.toml")).expect("a manifest");
        let manifest: toml::Table = text.parse().expect("a manifest is TOML");
        for table in ["dependencies", "dev-dependencies", "build-dependencies"] {
            let Some(toml::Value::Table(table)) = manifest.get(table) else { continue };
            for name in &names {
                assert!(!table.contains_key(*name), "{package} depends on {name}");
            }
        }
    }
}

#[test]
fn a_broken_rule_is_noticed() {
    assert_eq!(broken("orchestrator/src/scheme/mod.rs", "use dam_dem::Dam;").len(), 1);
    assert_eq!(broken("dam-dem/src/mesh.rs", "impl CoSimulation for Mesh {}").len(), 1);
    assert_eq!(broken("dam-dem/src/mesh.rs", "let t = std::time::Instant::now();").len(), 1);
    assert_eq!(broken("orchestrator/src/simulation.rs", "mcap::Writer").len(), 1);
    assert_eq!(broken("orchestrator/src/packing/mod.rs", "use zip::ZipWriter;").len(), 2);
    assert!(broken("orchestrator/src/registry.rs", "use dam_dem::Dam;").is_empty());
    assert!(broken("dam-dem/src/mesh.rs", "// CoSimulation lives elsewhere").is_empty());
}
