//! Dams on meshes from files of Gmsh.

use cofferdam_assembly::{Assembly, read_scene};
use cofferdam_dam::{CrackLine, DamParameters, GivenMesh, Mesh};
use cofferdam_scene::mesh_file::{DamMesh, MeshFile, MeshFileError};
use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use whole_chain::fmu::export;
use whole_chain::koyna;
use whole_chain::scenario::{Scenario, binary, root};
use whole_chain::scene_text::Desk;

const CASE: &str = "koyna-gmsh";

/// A file of version 4.1: each curve an entity of its own.
fn msh(nodes: &[[f64; 2]], polygons: &[Vec<usize>], curves: &[(&str, Vec<usize>)]) -> String {
    let mut text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n".to_owned();
    let mut line = |words: String| writeln!(text, "{words}").expect("a text");
    line(curves.len().to_string());
    for (k, (name, _)) in curves.iter().enumerate() {
        line(format!("1 {} \"{name}\"", k + 1));
    }
    line(format!("$EndPhysicalNames\n$Entities\n0 {} 1 0", curves.len()));
    for k in 1..=curves.len() {
        line(format!("{k} 0 0 0 1 1 0 1 {k} 0"));
    }
    line("1 0 0 0 1 1 0 0 0\n$EndEntities\n$Nodes".to_owned());
    line(format!("1 {0} 1 {0}\n2 1 0 {0}", nodes.len()));
    (1..=nodes.len()).for_each(|tag| line(tag.to_string()));
    nodes.iter().for_each(|[x, y]| line(format!("{x} {y} 0")));
    line("$EndNodes\n$Elements".to_owned());
    line(format!("{} 0 1 1", curves.len() + polygons.len()));
    for (k, (_, chain)) in curves.iter().enumerate() {
        line(format!("1 {} 1 {}", k + 1, chain.len() - 1));
        chain.windows(2).for_each(|pair| line(format!("1 {} {}", pair[0] + 1, pair[1] + 1)));
    }
    for corners in polygons {
        line(format!("2 1 {} 1", corners.len() - 1));
        let tags: Vec<String> = corners.iter().map(|node| (node + 1).to_string()).collect();
        line(format!("1 {}", tags.join(" ")));
    }
    line("$EndElements".to_owned());
    text
}

/// The own mesh of the cracked dam as a file in triangles, or as the quadrilaterals that it has.
fn own_mesh(element_size: f64, triangles: bool) -> (Mesh, String) {
    let mesh = koyna::dam(element_size, true).mesh().expect("a mesh");
    let lower: HashMap<usize, usize> = mesh.doubled_nodes().map(|(lower, upper)| (upper, lower)).collect();
    let (mut index, mut nodes) = (HashMap::new(), Vec::new());
    let mut of = |node: usize| {
        let node = *lower.get(&node).unwrap_or(&node);
        *index.entry(node).or_insert_with(|| {
            nodes.push(mesh.nodes[node]);
            nodes.len() - 1
        })
    };
    let mut polygons = Vec::new();
    for &[a, b, c, d, _] in &mesh.cells {
        let [a, b, c, d] = [a, b, c, d].map(&mut of);
        match triangles {
            true => polygons.extend([vec![a, b, c], vec![a, c, d]]),
            false => polygons.push(vec![a, b, c, d]),
        }
    }
    let mut chain = |nodes: &[usize]| {
        let mut chain: Vec<usize> = nodes.iter().map(|&node| of(node)).collect();
        chain.dedup();
        chain
    };
    let curves = [
        ("upstream", chain(&mesh.upstream)),
        ("downstream", chain(&mesh.downstream)),
        ("base", chain(&mesh.base)),
        ("neck", chain(&mesh.seams[0].upper)),
    ];
    let text = msh(&nodes, &polygons, &curves);
    (mesh, text)
}

/// The cracked dam on the mesh of a text.
fn dam_on(text: &str) -> DamParameters {
    let file = MeshFile::parse(Path::new("a.msh"), text).expect("a mesh");
    let mesh = DamMesh::new(Path::new("a.msh"), file, &[Some("neck".to_owned())]).expect("a dam");
    let mut parameters = koyna::dam(mesh.element_size(), true);
    parameters.cracks[0].line = CrackLine::Polyline(mesh.polyline(0));
    let DamMesh { points, triangles, quadrilaterals, upstream, downstream, base, cracks } = mesh;
    parameters.given_mesh =
        Some(GivenMesh { points, triangles, quadrilaterals, upstream, downstream, base, cracks });
    parameters
}

fn mass(parameters: &DamParameters) -> f64 {
    let dam = cofferdam_dam::Dam::new(parameters.clone()).expect("a dam");
    dam.structure().mass.iter().sum()
}

/// The own mesh, written as quadrilaterals and read again, is the same dam.
#[test]
fn the_own_mesh_comes_back_from_a_file() {
    let (own, text) = own_mesh(5.0, false);
    let given = dam_on(&text);
    let found = given.mesh().expect("a mesh");
    assert_eq!((found.cells.len(), found.nodes.len()), (own.cells.len(), own.nodes.len()));
    assert_eq!(found.blocks.len(), own.blocks.len());
    let places = |mesh: &Mesh| {
        let mut places: Vec<[i64; 2]> =
            mesh.nodes.iter().map(|p| p.map(|x| (x * 1e9).round() as i64)).collect();
        places.sort_unstable();
        places
    };
    assert_eq!(places(&found), places(&own));
    let parameters = koyna::dam(5.0, true);
    assert_eq!(given.wet_face().expect("a face"), parameters.wet_face().expect("a face"));
    assert!((mass(&given) / mass(&parameters) - 1.0).abs() < 1e-13);
    let [a, b] = [&given, &parameters].map(|dam| dam.natural_modes(4).expect("modes").frequencies);
    for (a, b) in a.iter().zip(&b) {
        assert!((a / b - 1.0).abs() < 1e-8, "{a} and {b}");
    }
}

/// The same in triangles: three cells each, so that frequencies differ by discretisation, and the mass does not.
#[test]
fn triangles_are_the_same_dam() {
    let (_, text) = own_mesh(5.0, true);
    let (given, own) = (dam_on(&text), koyna::dam(5.0, true));
    assert!((mass(&given) / mass(&own) - 1.0).abs() < 1e-12);
    let [fine, coarse] = [&given, &own].map(|dam| dam.natural_modes(4).expect("modes").frequencies);
    println!("{fine:?} against {coarse:?}");
    for (fine, coarse) in fine.iter().zip(&coarse) {
        // six cells for one: softer, and by less than the coarse mesh errs
        assert!((0.97..1.0).contains(&(fine / coarse)), "{fine} and {coarse}");
    }
}

/// A file that Gmsh 4.15 has written.
#[test]
fn a_file_of_gmsh_is_read() {
    let loaded = read_scene(&root().join("scenes").join(CASE), &[]).expect("a scene");
    let dam = loaded.scene.dam.as_ref().expect("a dam");
    assert_eq!(dam.section.upstream, [[0.0, 0.0], [0.0, 103.0]]);
    assert_eq!(dam.section.downstream, [[70.0, 0.0], [19.25, 66.5], [14.8, 103.0]]);
    let crack = dam.cracks[0].polyline.as_deref().expect("a polyline");
    assert_eq!(crack, [[0.0, 64.0], [8.0, 64.0], [11.0, 66.5], [19.25, 66.5]]);
    let mesh = Assembly::of(&loaded.scene).dam_mesh().expect("a mesh").expect("a mesh");
    assert_eq!(mesh.blocks.len(), 2);
    let area: f64 = mesh
        .triangles()
        .map(|corners| {
            let [a, b, c] = corners.map(|i| mesh.nodes[i]);
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
        })
        .sum();
    let exact = 66.5 * (70.0 + 19.25) / 2.0 + 36.5 * (19.25 + 14.8) / 2.0;
    assert!((area - exact).abs() < 1e-9, "{area}, {exact}");
    // Chopra and Chakrabarti (1973), as in tests/bad_input.rs
    let published =
        [18.86, 49.97, 68.16, 98.27].map(|omega: f64| omega * (31.0 / 31.027 * 2643.0 / 2640.0_f64).sqrt());
    let modes = Assembly::of(&loaded.scene).natural_modes(4).expect("modes").expect("modes");
    println!("{:?} against {published:?}", modes.frequencies);
    for (found, published) in modes.frequencies.iter().zip(published) {
        assert!((found / published - 1.0).abs() < 0.025, "{found} against {published}");
    }
}

/// The manifest and the log have the mesh: neither a run of the manifest nor a replay nor an FMU needs the file.
#[test]
fn a_run_keeps_its_mesh() {
    let mut scenario = Scenario::shipped(CASE);
    scenario.set("time.duration", 0.1).set("reservoir.fidelity", "westergaard");
    let file = scenario.folder().join("koyna.msh");
    // with the ends of lines of another system
    let original =
        std::fs::read_to_string(root().join("scenes").join(CASE).join("koyna.msh")).expect("a file");
    let original = original.replace('\n', "\r\n");
    std::fs::write(&file, &original).expect("written");
    scenario.run();
    let said = |arguments: &[&str]| {
        let output = Command::new(binary()).args(arguments).current_dir(scenario.folder()).output();
        let output = output.expect("cofferdam runs");
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
        said
    };
    std::fs::remove_file(&file).expect("removed");
    said(&["run", "run/manifest.toml", "--quiet", "--output", "again"]);
    let histories =
        |run: &str| std::fs::read(scenario.folder().join(run).join("histories.csv")).expect("histories");
    assert_eq!(histories("run"), histories("again"));
    let replayed = said(&["replay", "run", "--quiet"]);
    assert!(replayed.contains("dam: ") && replayed.contains("identical"), "{replayed}");
    let manifest = std::fs::read_to_string(scenario.folder().join("run/manifest.toml")).expect("a manifest");
    let table: toml::Table = manifest.parse().expect("TOML");
    let text = table["scene"]["dam"]["mesh"]["text"].as_str().expect("a text");
    assert_eq!(text, original);
    // another text is refused
    let other = manifest.replacen("19.25 66.5 0", "19.26 66.5 0", 1);
    std::fs::write(scenario.folder().join("other.toml"), other).expect("written");
    let error = read_scene(&scenario.folder().join("other.toml"), &[]).expect_err("another mesh");
    assert!(error.problems.iter().any(|p| p.to_string().contains("SHA-256")), "{error:?}");
    // a file on the command line takes its place
    let error = read_scene(&scenario.folder().join("run"), &["dam.mesh.file=no.msh".to_owned()]);
    assert!(error.expect_err("there is none").problems[0].to_string().contains("no.msh"));
    let packed =
        export(scenario.folder(), &scenario.folder().join("run/manifest.toml"), "dam", &["-o", "x.fmu"]);
    assert!(packed.status.success(), "{}", String::from_utf8_lossy(&packed.stderr));
}

/// What is given beside a mesh, and what does not fit it, is refused with its place.
#[test]
fn scenes_and_meshes_that_do_not_fit_are_refused() {
    let desk = Desk::default();
    let folder = root().join("scenes").join(CASE);
    let [scene, mesh] =
        ["scene.toml", "koyna.msh"].map(|name| std::fs::read_to_string(folder.join(name)).expect("a file"));
    let second = "[[dam.cracks]]\nname = \"neck\"";
    let cases: &[(&str, &str, &str, &str, &str)] = &[
        (
            "uplift = \"none\"",
            "element_size = 4.0\nuplift = \"none\"",
            "",
            "",
            "`dam.element_size` follows from the file",
        ),
        (
            "[dam.material]",
            "[dam.section]\nupstream = [[0.0, 0.0], [0.0, 90.0]]\ndownstream = [[70.0, 0.0], [14.8, 90.0]]\n\n[dam.material]",
            "",
            "",
            "`dam.section` follows from the file",
        ),
        (
            second,
            "[[dam.cracks]]\nelevation = 60.0\nname = \"neck\"",
            "",
            "",
            "`dam.cracks.0.elevation` follows",
        ),
        (second, "[[dam.cracks]]", "", "", "\"neck\" is neither a side"),
        ("\"neck\"", "\"nick\"", "", "", "the physical curve \"neck\" is neither a side"),
        ("koyna.msh", "nowhere.msh", "", "", "nowhere.msh: No such file"),
        ("depth = 91.75", "depth = 90.0", "", "", "put a point at the water level"),
        ("", "", "1 3 \"upstream\"", "1 3 \"left\"", "the physical curve \"left\" is neither"),
        (
            "",
            "",
            "1 2 \"downstream\"",
            "2 2 \"downstream\"",
            "it has no physical curve \"downstream\", but \"base\"",
        ),
        ("", "", "4.1 0 8", "4.1 1 8", "it is binary; MSH 4.1 and 2.2 in ASCII are read"),
        ("", "", "4.1 0 8", "3.0 0 8", "its version is 3.0"),
        ("", "", "$MeshFormat", "$Format", "$MeshFormat"),
    ];
    for (number, (old, new, before, after, expected)) in cases.iter().enumerate() {
        let text = if old.is_empty() { scene.clone() } else { scene.replacen(old, new, 1) };
        let changed = if before.is_empty() { mesh.clone() } else { mesh.replacen(before, after, 1) };
        assert!(old.is_empty() || text != scene, "{number}");
        assert!(before.is_empty() || changed != mesh, "{number}");
        std::fs::write(desk.file("koyna.msh"), changed).expect("written");
        let error = desk.read(text, &[]).expect_err("it does not fit");
        let said = desk.shown(&error).split_whitespace().collect::<Vec<_>>().join(" ");
        let flat: String = said.split(" │ ").collect::<Vec<_>>().join(" ");
        println!("{number}: {flat}");
        let problems: Vec<String> = error.problems.iter().map(ToString::to_string).collect();
        assert!(problems.iter().any(|problem| problem.contains(expected)), "{number}: {problems:?}");
        assert!(problems.iter().all(|problem| !problem.contains("is missing in")), "{number}: {problems:?}");
    }
}

/// Errors of the format name the line.
#[test]
fn files_that_are_damaged_are_refused_at_their_line() {
    // a square of two triangles, version 2.2
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 1 \"upstream\"\n1 2 \"downstream\"\n1 3 \"base\"\n\
                $EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n5 1 1 0\n4 0 1 0\n$EndNodes\n$Elements\n6\n1 15 2 0 1 1\n\
                2 1 2 1 1 1 4\n3 1 2 2 2 2 5\n4 1 2 3 3 1 2\n5 2 2 9 1 1 2 5\n6 2 2 9 1 1 5 4\n$EndElements\n";
    let parse = |text: &str| MeshFile::parse(Path::new("a.msh"), text);
    let file = parse(text).expect("a mesh");
    assert_eq!((file.points.len(), &file.triangles), (4, &vec![[0, 1, 2], [0, 2, 3]]));
    let mesh = DamMesh::new(Path::new("a.msh"), file, &[]).expect("a dam");
    assert_eq!((mesh.upstream, mesh.downstream, mesh.base), (vec![0, 3], vec![1, 2], vec![0, 1]));
    type Expected = fn(&MeshFileError) -> bool;
    let cases: &[(&str, &str, Expected)] = &[
        ("5 1 1 0", "5 1 1 0.5", |e| {
            matches!(e, MeshFileError::OutOfPlane { line: 14, node: 5, z: 0.5, .. })
        }),
        ("5 1 1 0", "5 1 1 nan", |e| matches!(e, MeshFileError::OutOfPlane { line: 14, node: 5, .. })),
        ("5 1 1 0", "5 1 one 0", |e| matches!(e, MeshFileError::Line { line: 14, .. })),
        ("5 1 1 0", "4 1 1 0", |e| matches!(e, MeshFileError::TwoNodes { line: 15, node: 4, .. })),
        ("5 2 2 9 1 1 2 5", "5 2 2 9 1 1 2 7", |e| {
            matches!(e, MeshFileError::NoNode { line: 23, node: 7, .. })
        }),
        ("5 2 2 9 1 1 2 5", "5 9 2 9 1 1 2 5 1 2 5", |e| {
            matches!(e, MeshFileError::Element { line: 23, element: 5, kind: 9, .. })
                && e.to_string().contains("ElementOrder")
        }),
        ("5 2 2 9 1 1 2 5", "5 4 2 9 1 1 2 5 4", |e| {
            matches!(e, MeshFileError::Element { kind: 4, .. }) && e.to_string().contains("plane")
        }),
        ("5 2 2 9 1 1 2 5", "5 2 2 9 1 1 2", |e| matches!(e, MeshFileError::Line { line: 23, .. })),
        ("5 2 2 9 1 1 2 5", "5 2 18446744073709551615 9 1 1 2", |e| {
            matches!(e, MeshFileError::Line { line: 23, .. })
        }),
        ("$Nodes\n4", "$Nodes\n18446744073709551615", |e| matches!(e, MeshFileError::Line { .. })),
        ("$Elements\n6", "$Elements\n999999999999", |e| matches!(e, MeshFileError::Line { .. })),
        ("5 2 2 9 1 1 2 5\n6 2 2 9 1 1 5 4\n", "5 15 2 0 1 1\n6 15 2 0 1 1\n", |e| {
            matches!(e, MeshFileError::Missing { .. })
        }),
    ];
    for (number, (old, new, expected)) in cases.iter().enumerate() {
        let changed = text.replacen(old, new, 1);
        assert_ne!(changed, text, "{number}");
        let error = parse(&changed).expect_err("it is damaged");
        println!("{number}: {error}");
        assert!(expected(&error), "{number}: {error:?}");
    }
}
