//! What manifests cannot say of the dependencies between crates and modules, by reading the sources; and who may depend on
//! whom, by reading the manifests.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use toml::{Table, Value};
use whole_chain::scenario::root;

/// A rule: in files whose path starts with `within`, but with none of `except`, none of `words` may occur.
struct Rule {
    within: &'static [&'static str],
    except: &'static [&'static str],
    words: &'static [&'static str],
    why: &'static str,
}

const RULES: &[Rule] = &[
    Rule {
        within: &["reservoir-fmu/src", "dam-dem/src"],
        except: &[],
        words: &["std::fs", "std::time", "std::thread", "std::net", "std::env", "println!"],
        why: "solvers use mathematics, serde and the contract only, and speak through tracing",
    },
    Rule {
        within: &["reservoir-fmu/src", "dam-dem/src"],
        except: &["reservoir-fmu/src/reservoir.rs", "dam-dem/src/dam.rs", "dam-dem/src/dam/"],
        words: &["CoSimulation", "tracing"],
        why: "beneath the unit nothing knows that coupling exists, nor speaks",
    },
    Rule {
        within: &["reservoir-fmu/src/analytical", "dam-dem/src/analytical"],
        except: &[],
        words: &["use crate::", "use super::super"],
        why: "closed forms call no solver code",
    },
    Rule {
        within: &[""],
        // The importer calls functions of FMI 2.0, and gives them one to call back: it exports none.
        except: &["interface/src/export/", "orchestrator/fmi/src/import/fmi2_library.rs"],
        words: &["no_mangle", "extern \"C\""],
        why: "C symbols are exported through cofferdam_unit::export",
    },
    Rule {
        within: &["orchestrator/coupling/src"],
        // For units in whatever process; nothing else of the coupling uses it.
        except: &["orchestrator/coupling/src/temporary.rs"],
        words: &["std::fs", "println!", "tracing"],
        why: "the coupling returns reports and calls observers, it never logs",
    },
    Rule {
        within: &["orchestrator/coupling/src/scheme", "orchestrator/coupling/src/acceleration"],
        except: &[],
        words: &["crate::observer"],
        why: "schemes return a report, and accelerations a guess",
    },
    Rule {
        within: &["orchestrator/assembly/src"],
        except: &[
            "orchestrator/assembly/src/lib.rs",
            "orchestrator/assembly/src/assembly.rs",
            "orchestrator/assembly/src/assembly/",
            "orchestrator/assembly/src/packing/",
        ],
        words: &[
            "cofferdam_dam::",
            "cofferdam_reservoir::{",
            "cofferdam_reservoir::R",
            "cofferdam_reservoir::P",
            "cofferdam_reservoir::F",
            "cofferdam_reservoir::a",
        ],
        why: "only the assembly of built-in units and their packing know the solvers",
    },
];

/// Words that the code of the coupling does not use, in names nor in texts: it does not know what the units are.
const OF_DAMS: &[&str] = &["dam", "dams", "reservoir", "reservoirs", "water", "waters", "hydrostatic"];

/// The rules that the text of a file breaks.
fn broken(path: &str, text: &str) -> Vec<String> {
    let begins = |prefixes: &[&str]| prefixes.iter().any(|prefix| path.starts_with(prefix));
    let code = without_tests(text);
    let applies = |rule: &&Rule| begins(rule.within) && !begins(rule.except);
    let found = |rule: &Rule| {
        let words = rule.words.iter().filter(|word| code.contains(**word));
        words.map(|word| format!("{path}: `{word}`, but {}", rule.why)).collect::<Vec<_>>()
    };
    let mut problems: Vec<_> = RULES.iter().filter(applies).flat_map(found).collect();
    if path.starts_with("orchestrator/coupling/src") {
        let why = "the coupling does not know what the units are";
        problems.extend(words_of_dams(&code).into_iter().map(|word| format!("{path}: `{word}`, but {why}")));
    }
    problems
}

/// Those of [`OF_DAMS`] in code, also as parts of names such as `DamUnit` and `wet_dam`, and names of variables of a dam.
fn words_of_dams(code: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for name in code.split(|c: char| !c.is_alphanumeric() && c != '_') {
        if name.contains("interface_pressure") {
            found.insert(name.to_owned());
        }
        let mut word = String::new();
        for c in name.chars().chain(['_']) {
            // A capital begins a word, unless all are capitals.
            if c == '_' || c.is_uppercase() && word.chars().any(char::is_lowercase) {
                if OF_DAMS.contains(&word.to_lowercase().as_str()) {
                    found.insert(word.to_lowercase());
                }
                word.clear();
            }
            if c != '_' {
                word.push(c);
            }
        }
    }
    found
}

/// The sources in a folder, without those of tests.
fn sources(folder: &Path, found: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let of_tests = path.file_stem().is_some_and(|name| name == "tests");
        if path.is_dir() && !of_tests {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") && !of_tests {
            found.push(path);
        }
    }
}

/// The manifest in a folder of the workspace.
fn manifest(folder: &str) -> Table {
    let text = std::fs::read_to_string(root().join(folder).join("Cargo.toml")).expect("a manifest");
    text.parse().expect("a manifest is TOML")
}

/// The folders of all crates but the tests.
fn crates() -> Vec<String> {
    let members = manifest("")["workspace"]["members"].as_array().expect("members").clone();
    let members = members.iter().map(|member| member.as_str().expect("a folder").to_owned());
    members.filter(|folder| folder != "tests").collect()
}

#[test]
fn every_source_keeps_the_rules() {
    let mut files = Vec::new();
    crates().iter().for_each(|folder| sources(&root().join(folder).join("src"), &mut files));
    assert!(files.len() > 200, "{} sources found", files.len());
    let mut problems = Vec::new();
    for file in files {
        let text = std::fs::read_to_string(&file).expect("a source");
        let path = file.strip_prefix(root()).expect("inside the project").to_string_lossy().into_owned();
        problems.extend(broken(&path, &text));
    }
    assert!(problems.is_empty(), "{problems:#?}");
}

/// A package, the packages of the workspace that it may depend on, and those that only its own tests, benches and examples may.
type Allowed = (&'static str, &'static [&'static str], &'static [&'static str]);

#[rustfmt::skip]
const ALLOWED: &[Allowed] = &[
    ("cofferdam-unit", &[], &[]),
    ("cofferdam-reservoir", &["cofferdam-unit"], &[]),
    ("cofferdam-dam", &["cofferdam-unit"], &[]),
    ("cofferdam-reservoir-fmu", &["cofferdam-unit", "cofferdam-reservoir"], &[]),
    ("cofferdam-dam-fmu", &["cofferdam-unit", "cofferdam-dam"], &[]),
    ("cofferdam-coupling", &["cofferdam-unit"], &["cofferdam-log"]),
    ("cofferdam-shared-memory", &["cofferdam-unit", "cofferdam-coupling"], &["cofferdam-log"]),
    ("cofferdam-log", &["cofferdam-unit", "cofferdam-coupling"], &[]),
    ("cofferdam-fmi", &["cofferdam-unit", "cofferdam-coupling"], &["cofferdam-reservoir"]),
    ("cofferdam-motion", &["cofferdam-unit"], &[]),
    ("cofferdam-scene", &[
        "cofferdam-unit", "cofferdam-reservoir", "cofferdam-dam", "cofferdam-coupling", "cofferdam-log",
        "cofferdam-motion",
    ], &[]),
    ("cofferdam-assembly", &[
        "cofferdam-unit", "cofferdam-reservoir", "cofferdam-dam", "cofferdam-coupling",
        "cofferdam-shared-memory", "cofferdam-log", "cofferdam-fmi", "cofferdam-motion", "cofferdam-scene",
    ], &[]),
    ("cofferdam-coupled-fmu", &["cofferdam-unit", "cofferdam-assembly"], &[]),
    ("cofferdam-report", &[
        "cofferdam-unit", "cofferdam-coupling", "cofferdam-log", "cofferdam-motion", "cofferdam-scene",
        "cofferdam-assembly",
    ], &[]),
    ("cofferdam-analysis", &[
        "cofferdam-unit", "cofferdam-reservoir", "cofferdam-coupling", "cofferdam-shared-memory",
        "cofferdam-log", "cofferdam-fmi", "cofferdam-motion", "cofferdam-scene", "cofferdam-assembly",
        "cofferdam-report",
    ], &[]),
    ("cofferdam", &[
        "cofferdam-unit", "cofferdam-reservoir", "cofferdam-reservoir-fmu", "cofferdam-dam-fmu",
        "cofferdam-coupled-fmu", "cofferdam-coupling", "cofferdam-shared-memory", "cofferdam-log", "cofferdam-fmi", "cofferdam-motion",
        "cofferdam-scene", "cofferdam-assembly", "cofferdam-report", "cofferdam-analysis",
    ], &[]),
    ("cofferdam-lab", &[
        "cofferdam-unit", "cofferdam-reservoir", "cofferdam-coupling", "cofferdam-log", "cofferdam-motion",
        "cofferdam-scene", "cofferdam-assembly", "cofferdam-report", "cofferdam-analysis",
    ], &[]),
];

/// Libraries of which a single crate knows, and which one.
const OF_ONE_CRATE: &[(&str, &str)] = &[
    ("mcap", "cofferdam-log"),
    ("iceoryx2", "cofferdam-shared-memory"),
    ("fmi-rs", "cofferdam-fmi"),
    ("zip", "cofferdam-fmi"),
    ("parquet", "cofferdam-analysis"),
];

/// The name of the package of a manifest.
fn name(manifest: &Table) -> &str {
    manifest["package"]["name"].as_str().expect("a name")
}

/// The names in tables of dependencies of a manifest, of targets too.
fn dependencies<'a>(manifest: &'a Table, kinds: &[&str]) -> BTreeSet<&'a str> {
    let targets = manifest.get("target").and_then(Value::as_table).into_iter().flat_map(Table::values);
    let tables = targets.filter_map(Value::as_table).chain([manifest]);
    let of_kinds = tables.flat_map(|table| kinds.iter().filter_map(|kind| table.get(*kind)?.as_table()));
    of_kinds.flat_map(|table| table.keys().map(String::as_str)).collect()
}

/// What is wrong with the dependencies of all packages but the tests.
fn broken_manifests(manifests: &[Table]) -> Vec<String> {
    let own: BTreeSet<&str> = manifests.iter().map(name).collect();
    let mut problems = Vec::new();
    for manifest in manifests {
        let package = name(manifest);
        let Some((_, may, tests_may)) = ALLOWED.iter().find(|(allowed, ..)| *allowed == package) else {
            problems.push(format!("{package}: nothing says what it may depend on"));
            continue;
        };
        let used = dependencies(manifest, &["dependencies", "build-dependencies"]);
        let used_in_tests = dependencies(manifest, &["dev-dependencies"]);
        let refused = used.iter().filter(|used| own.contains(**used) && !may.contains(*used));
        let of_tests = used_in_tests
            .iter()
            .filter(|used| own.contains(**used) && !may.contains(*used) && !tests_may.contains(*used));
        problems.extend(refused.chain(of_tests).map(|used| format!("{package} depends on {used}")));
    }
    for (library, of) in OF_ONE_CRATE {
        let users =
            manifests.iter().filter(|manifest| dependencies(manifest, &["dependencies"]).contains(library));
        let users: Vec<&str> = users.map(name).collect();
        if users != [*of] {
            problems.push(format!("{library} is used by {users:?}, which should be {of}"));
        }
    }
    problems
}

#[test]
fn manifests_keep_the_rules() {
    let manifests: Vec<Table> = crates().iter().map(|folder| manifest(folder)).collect();
    let problems = broken_manifests(&manifests);
    assert!(problems.is_empty(), "{problems:#?}");
    let names: BTreeSet<&str> = manifests.iter().map(name).collect();
    let gone: Vec<_> =
        ALLOWED.iter().map(|(package, ..)| package).filter(|name| !names.contains(**name)).collect();
    assert!(gone.is_empty(), "packages that are no more: {gone:?}");
}

#[test]
fn a_broken_rule_is_noticed() {
    let problems = |path: &str, text: &str| broken(path, text).len();
    assert_eq!(problems("dam-dem/src/mesh.rs", "impl CoSimulation for Mesh {}"), 1);
    assert_eq!(problems("dam-dem/src/dam/output.rs", "impl CoSimulation for Dam {}"), 0);
    assert_eq!(problems("dam-dem/src/mesh.rs", "let t = std::time::Instant::now();"), 1);
    assert_eq!(problems("dam-dem/src/mesh.rs", "// CoSimulation lives elsewhere"), 0);
    assert_eq!(problems("reservoir-fmu/src/outline.rs", "tracing::warn!(); println!();"), 2);
    assert_eq!(
        problems("reservoir-fmu/src/outline.rs", "#[cfg(test)] mod tests { fn f() { println!() } }"),
        0
    );
    assert_eq!(problems("reservoir-fmu/src/analytical/chopra.rs", "use crate::Reservoir;"), 1);
    assert_eq!(problems("dam-dem/fmu/src/lib.rs", "#[unsafe(no_mangle)] extern \"C\" fn f() {}"), 2);
    assert_eq!(problems("orchestrator/coupling/src/scheme/mod.rs", "use crate::observer::Start;"), 1);
    assert_eq!(problems("orchestrator/coupling/src/stepping.rs", "use crate::observer::Start;"), 0);
    assert_eq!(problems("orchestrator/coupling/src/acceleration/aitken.rs", "println!()"), 1);
    assert_eq!(problems("orchestrator/assembly/src/vtk.rs", "use cofferdam_dam::Dam;"), 1);
    assert_eq!(problems("orchestrator/assembly/src/assembly/dam.rs", "use cofferdam_dam::Dam;"), 0);
    let coupling = |text| problems("orchestrator/coupling/src/simulation.rs", text);
    for text in [
        "struct DamUnit;",
        "const THE_DAM: u8 = 0;",
        "fn of_water() {}",
        "\"the reservoir: {x}\"",
        "HydrostaticPart",
    ] {
        assert_eq!(coupling(text), 1, "{text}");
    }
    assert_eq!(coupling("\"tailwater_interface_pressure\""), 1);
    assert_eq!(coupling("let damping = damage(\"cofferdam\"); // of a dam in water"), 0);
    assert_eq!(problems("orchestrator/assembly/src/units.rs", "const DAM: UnitId = UnitId(0);"), 0);
}

#[test]
fn a_broken_manifest_is_noticed() {
    let sound = || -> Vec<Table> { crates().iter().map(|folder| manifest(folder)).collect() };
    let with = |package: &str, kind: &str, dependency: &str| {
        let mut manifests = sound();
        let changed = manifests.iter_mut().find(|manifest| name(manifest) == package).expect("a package");
        let table = changed.entry(kind).or_insert_with(|| Table::new().into());
        table.as_table_mut().expect("a table").insert(dependency.to_owned(), "1".into());
        broken_manifests(&manifests)
    };
    let depends = |package: &str, dependency: &str| vec![format!("{package} depends on {dependency}")];
    for (package, dependency) in [
        ("cofferdam-unit", "cofferdam-coupling"),
        ("cofferdam-coupling", "cofferdam-log"),
        ("cofferdam-log", "cofferdam-scene"),
        ("cofferdam-motion", "cofferdam-coupling"),
        ("cofferdam-report", "cofferdam-reservoir"),
        ("cofferdam-dam", "cofferdam-reservoir"),
    ] {
        assert_eq!(with(package, "dependencies", dependency), depends(package, dependency));
    }
    assert_eq!(
        with("cofferdam-dam", "dev-dependencies", "cofferdam-reservoir"),
        depends("cofferdam-dam", "cofferdam-reservoir")
    );
    assert_eq!(
        with("cofferdam-reservoir", "build-dependencies", "cofferdam-dam"),
        depends("cofferdam-reservoir", "cofferdam-dam")
    );
    assert!(with("cofferdam-coupling", "dev-dependencies", "cofferdam-log").is_empty());
    assert_eq!(with("cofferdam-report", "dependencies", "mcap").len(), 1);
    assert_eq!(with("cofferdam-assembly", "dependencies", "zip").len(), 1);
    assert_eq!(with("cofferdam-log", "dependencies", "parquet").len(), 1);
    let mut manifests = sound();
    manifests.push("package = { name = \"new\" }".parse().expect("TOML"));
    assert_eq!(broken_manifests(&manifests), ["new: nothing says what it may depend on"]);
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
    let crates = crates();
    let found = crates
        .iter()
        .flat_map(|package| circles_of(package).into_iter().map(move |circle| (package.clone(), circle)));
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
