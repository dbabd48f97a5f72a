//! Checks the dependencies between crates and modules by reading the sources.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use whole_chain::scenario::root;

/// A rule: in files whose path starts with `within`, but with none of `except`, none of `words` may occur.
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
            "orchestrator/src/registry/water_field.rs",
            "orchestrator/src/packing/",
            "orchestrator/src/cli/reservoir/",
            "orchestrator/src/cli/study/resolution.rs",
        ],
        words: &["dam_dem", "reservoir::{", "reservoir::Re", "reservoir::P", "reservoir::F", "reservoir::a"],
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
        except: &["orchestrator/src/cli/parquet.rs"],
        words: &["parquet::basic", "parquet::data_type", "parquet::file"],
        why: "Parquet is written in one place",
    },
    Rule {
        within: "orchestrator/src",
        except: &["orchestrator/src/transport/"],
        words: &["iceoryx2"],
        why: "iceoryx2 is the transport's business",
    },
    Rule {
        within: "orchestrator/src",
        except: &["orchestrator/src/fmu/", "orchestrator/src/participant/fmu/"],
        words: &["zip::", "ZipWriter", "ZipArchive"],
        why: "archives are the business of FMUs",
    },
    Rule {
        within: "orchestrator/src",
        except: &["orchestrator/src/participant/fmu/"],
        words: &["fmi_rs"],
        why: "FMUs are imported in one place",
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
        words: &["println!", "tracing", "cofferdam_log", "cofferdam_coupling::observer"],
        why: "schemes return a report, they never log",
    },
    Rule {
        within: "orchestrator/src/acceleration",
        except: &[],
        words: &["println!", "tracing", "cofferdam_log", "cofferdam_coupling::observer"],
        why: "accelerations never log",
    },
];

/// The rules that the text of a file breaks.
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
        let path = file.strip_prefix(root()).expect("inside the project").to_string_lossy().into_owned();
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

/// Circles that stay: the crate, the modules, and why.
const EXCEPTIONS: &[(&str, &str, &str)] = &[(
    "reservoir-fmu",
    "the crate: boundary, outline, parameters",
    "parameters are checked by the outline and the mesh that they give",
)];

/// A path in a source, such as `cofferdam_coupling::scheme::Side`, by its segments.
type Names = Vec<String>;

/// A module: the paths that its source names, and the names that it imports.
#[derive(Default)]
struct Module {
    paths: Vec<Names>,
    imports: BTreeMap<String, Names>,
}

/// The modules of a crate by their paths; the crate itself has the empty path.
struct Modules(BTreeMap<Names, Module>);

impl Modules {
    /// Reads the sources: pairs of a file's path below `src` and its text.
    fn read<'a>(sources: impl IntoIterator<Item = (&'a str, &'a str)>) -> Self {
        let mut modules = BTreeMap::<Names, Module>::new();
        for (file, text) in sources {
            let mut path: Names = file.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
            path.pop_if(|last| ["mod", "lib", "main"].contains(&last.as_str()));
            let module = modules.entry(path.clone()).or_default();
            let tokens = tokens(&without_tests(text));
            let mut at = 0;
            while at < tokens.len() {
                let import = tokens[at] == "use";
                let start = at + usize::from(import);
                at += 1;
                let rooted = ["crate", "super", "self"]
                    .contains(&tokens[start.min(tokens.len() - 1)].as_str())
                    && tokens.get(start + 1).is_some_and(|next| next == "::");
                if import || rooted && (start == 0 || tokens[start - 1] != "::") {
                    let mut leaves = Vec::new();
                    at = start;
                    tree(&tokens, &mut at, &[], &mut leaves);
                    for (name, leaf) in leaves {
                        let absolute = absolute(&path, leaf);
                        if import {
                            module.imports.insert(name, absolute.clone());
                        }
                        module.paths.push(absolute);
                    }
                }
            }
        }
        Self(modules)
    }

    /// The module that holds what `path` names, behind imports.
    fn resolve(&self, path: &[String], depth: usize) -> Names {
        let mut here = Names::new();
        for (index, name) in path.iter().enumerate() {
            let mut child = here.clone();
            child.push(name.clone());
            if self.0.contains_key(&child) {
                here = child;
                continue;
            }
            if let Some(import) = self.0.get(&here).and_then(|module| module.imports.get(name))
                && depth < 8
            {
                let behind: Names = import.iter().chain(&path[index + 1..]).cloned().collect();
                return self.resolve(&behind, depth + 1);
            }
            break;
        }
        here
    }

    /// Every set of siblings that use each other, directly or over others, such as `log: reader, topic`.
    fn circles(&self) -> Vec<String> {
        let mut uses = BTreeMap::<&[String], BTreeSet<(&str, String)>>::new();
        for (user, module) in &self.0 {
            for path in &module.paths {
                let used = self.resolve(path, 0);
                let shared = user.iter().zip(&used).take_while(|(a, b)| a == b).count();
                if let (Some(from), Some(to)) = (user.get(shared), used.get(shared)) {
                    uses.entry(&user[..shared]).or_default().insert((from, to.clone()));
                }
            }
        }
        let mut circles = Vec::new();
        for (parent, uses) in uses {
            let reached = |start: &str| {
                let mut reached = BTreeSet::new();
                let mut open = vec![start.to_owned()];
                while let Some(from) = open.pop() {
                    for (_, to) in uses.iter().filter(|(user, _)| *user == from) {
                        if reached.insert(to.clone()) {
                            open.push(to.clone());
                        }
                    }
                }
                reached
            };
            let users: BTreeSet<&str> = uses.iter().map(|(from, _)| *from).collect();
            let reach: BTreeMap<&str, BTreeSet<String>> = users.iter().map(|u| (*u, reached(u))).collect();
            let mut found = BTreeSet::new();
            for user in reach.iter().filter(|(user, reached)| reached.contains(**user)).map(|(user, _)| user)
            {
                let circle = reach
                    .iter()
                    .filter(|(other, back)| reach[user].contains(**other) && back.contains(*user));
                found.insert(circle.map(|(name, _)| *name).collect::<Vec<_>>().join(", "));
            }
            let parent = if parent.is_empty() { "the crate".to_owned() } else { parent.join("::") };
            circles.extend(found.into_iter().map(|circle| format!("{parent}: {circle}")));
        }
        circles
    }
}

/// A source without comments and without what only tests compile.
fn without_tests(text: &str) -> String {
    let code: Vec<&str> = text.lines().map(|line| line.split("//").next().unwrap_or("")).collect();
    let mut code = code.join("\n");
    while let Some(start) = ["#[cfg(test)]", "#[cfg(all(test"].iter().filter_map(|mark| code.find(mark)).min()
    {
        let mut depth = 0;
        let end = code[start..].char_indices().find(|(_, c)| {
            depth += i32::from(*c == '{') - i32::from(*c == '}');
            depth == 0 && matches!(c, '}' | ';')
        });
        code.replace_range(start..end.map_or(code.len(), |(length, _)| start + length + 1), "");
    }
    code
}

/// Words, `::` and single signs.
fn tokens(code: &str) -> Vec<String> {
    let mut tokens = Vec::<String>::new();
    let mut word = false;
    for c in code.chars() {
        let inside = c.is_alphanumeric() || c == '_';
        match tokens.last_mut() {
            Some(last) if word && inside => last.push(c),
            Some(last) if c == ':' && last == ":" => last.push(c),
            _ if c.is_whitespace() => {}
            _ => tokens.push(c.to_string()),
        }
        word = inside;
    }
    tokens
}

/// The leaves of a tree of imports that begins at `at`: the name that each has here, and its path.
fn tree(tokens: &[String], at: &mut usize, before: &[String], leaves: &mut Vec<(String, Names)>) {
    let mut path = before.to_vec();
    loop {
        match tokens.get(*at).map(String::as_str) {
            Some("{") => {
                *at += 1;
                while tokens.get(*at).is_some_and(|token| token != "}") {
                    tree(tokens, at, &path, leaves);
                    *at += usize::from(tokens.get(*at).is_some_and(|token| token == ","));
                }
                *at += 1;
                return;
            }
            Some("self") if !before.is_empty() => {}
            Some(name) => path.push(name.to_owned()),
            None => return,
        }
        *at += 1;
        if tokens.get(*at).is_none_or(|token| token != "::") {
            break;
        }
        *at += 1;
    }
    let mut name = path.last().cloned().unwrap_or_default();
    if tokens.get(*at).is_some_and(|token| token == "as") {
        name = tokens.get(*at + 1).cloned().unwrap_or_default();
        *at += 2;
    }
    leaves.push((name, path));
}

/// A path as seen from the crate, of one in the source of `module`; one of another crate begins with its name.
fn absolute(module: &[String], path: Names) -> Names {
    let mut whole =
        if path.first().is_some_and(|first| first == "crate") { Vec::new() } else { module.to_vec() };
    for segment in path.into_iter() {
        match segment.as_str() {
            "crate" | "self" => {}
            "super" => drop(whole.pop()),
            _ => whole.push(segment),
        }
    }
    whole
}

/// The circles of a crate: of its rooms, and of the modules within each of them.
fn circles_of(package: &str) -> Vec<String> {
    let folder = root().join(package).join("src");
    let mut files = Vec::new();
    sources(&folder, &mut files);
    let texts: Vec<(String, String)> = files
        .iter()
        .map(|file| {
            let name = file.strip_prefix(&folder).expect("inside the crate").to_string_lossy().into_owned();
            (name, std::fs::read_to_string(file).expect("a source"))
        })
        .collect();
    Modules::read(texts.iter().map(|(file, text)| (file.as_str(), text.as_str()))).circles()
}

#[test]
fn no_modules_use_each_other() {
    let packages = ["interface", "reservoir-fmu", "dam-dem", "orchestrator"];
    let found = packages.iter().flat_map(|package| {
        circles_of(package).into_iter().map(move |circle| ((*package).to_owned(), circle))
    });
    let excepted =
        EXCEPTIONS.iter().map(|(package, circle, _)| ((*package).to_owned(), (*circle).to_owned()));
    let (found, excepted): (BTreeSet<_>, BTreeSet<_>) = (found.collect(), excepted.collect());
    let problems: Vec<_> = found.difference(&excepted).collect();
    assert!(problems.is_empty(), "modules that use each other, directly or over others: {problems:#?}");
    let stale: Vec<_> = excepted.difference(&found).collect();
    assert!(stale.is_empty(), "exceptions that are needed no longer: {stale:#?}");
}

#[test]
fn a_circle_is_noticed() {
    let circles = |sources: &[(&str, &str)]| Modules::read(sources.iter().copied()).circles();
    let shared = ("lib.rs", "pub mod a; pub mod b; pub mod c;");
    let one_way = [shared, ("a.rs", "use crate::b::{self, B};"), ("b.rs", "pub struct B;")];
    assert!(circles(&one_way).is_empty());
    let back = [shared, one_way[1], ("b/mod.rs", "fn f() { crate::a::g() }")];
    assert_eq!(circles(&back), ["the crate: a, b"]);
    let over_another = [shared, one_way[1], ("b.rs", "use super::{c::d};"), ("c.rs", "use crate::a;")];
    assert_eq!(circles(&over_another), ["the crate: a, b, c"]);
    // Behind a name that the parent imports.
    let siblings = [
        ("room/mod.rs", "mod x; mod y; pub use x::X; pub(crate) use y::{Y as Z};"),
        ("room/x.rs", "use super::Z;"),
        ("room/y.rs", "mod inner;"),
        ("room/y/inner.rs", "use super::super::X;"),
    ];
    assert_eq!(circles(&siblings), ["room: x, y"]);
    let of_tests =
        [shared, one_way[1], ("b.rs", "#[cfg(test)] mod tests { use crate::a::A; } // crate::a::A")];
    assert!(circles(&of_tests).is_empty());
}
