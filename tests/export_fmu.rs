//! `cofferdam export-fmu`: what is packed, and the messages when packing is refused.

use cofferdam_dam::{Dam, Mesh};
use cofferdam_reservoir::Reservoir;
use cofferdam_unit::export::Contents;
use cofferdam_unit::{CoSimulation, Packable, variables};
use std::num::NonZeroUsize;
use std::path::Path;
use tempfile::TempDir;
use whole_chain::fmu::{Fmu, export};
use whole_chain::scenario::{binary, root};

const SCENE: &str = "koyna-coarse";
const COARSE: [&str; 2] = ["--set", "dam.element_size=10"];

fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Packs a unit of the coarse main scene as `x.fmu`.
fn pack(folder: &Path, unit: &str, more: &[&str]) -> Fmu {
    let arguments = [&COARSE, &["-o", "x.fmu"][..], more].concat();
    let output = export(folder, &root().join("scenes").join(SCENE), unit, &arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Fmu::open(&folder.join("x.fmu"))
}

/// The contents of an FMU, read in the same way as the library reads them.
fn contents<U: Packable>(fmu: &mut Fmu, folder: &Path) -> Contents<U::Parameters> {
    std::fs::write(folder.join("unit.toml"), fmu.bytes("resources/unit.toml")).expect("written");
    Contents::read(folder).expect("contents")
}

/// Exit status and message, on one line, of a packing that fails.
fn refused(folder: &Path, scene: &str, unit: &str, more: &[&str]) -> (Option<i32>, String) {
    let output = export(folder, &root().join("scenes").join(scene), unit, more);
    let said = String::from_utf8_lossy(&output.stderr).replace('│', " ");
    let left: Vec<_> =
        std::fs::read_dir(folder).expect("a folder").flatten().map(|e| e.file_name()).collect();
    let known = |name: &&std::ffi::OsString| {
        let name = name.to_string_lossy();
        *name == *"fake.so" || name.ends_with(".fmu") || name.ends_with(".toml")
    };
    assert_eq!(left.iter().filter(|name| !known(name)).count(), 0, "left: {left:?}");
    (output.status.code(), said.split_whitespace().collect::<Vec<_>>().join(" "))
}

#[test]
fn an_fmu_contains_all_its_files() {
    let folder = folder();
    let mut dam = pack(folder.path(), "dam", &[]);
    let library_name = "binaries/x86_64-linux/dam.so";
    let dam_names = [
        "modelDescription.xml".to_owned(),
        "terminalsAndIcons/terminalsAndIcons.xml".to_owned(),
        library_name.to_owned(),
        "resources/unit.toml".to_owned(),
        "resources/scene.toml".to_owned(),
        "resources/mesh/nodes.csv".to_owned(),
        "resources/mesh/triangles.csv".to_owned(),
        "documentation/index.html".to_owned(),
        "documentation/licenses/license.txt".to_owned(),
    ];
    assert_eq!(dam.names(), dam_names);
    let library = std::fs::read(folder.path().join("fake.so")).expect("the library");
    assert_eq!(dam.bytes(library_name), library);
    let licences = dam.text("documentation/licenses/license.txt");
    assert!(licences.contains("MIT License") && licences.contains("Apache License"), "{licences}");

    let dam_contents = contents::<Dam>(&mut dam, folder.path());
    let token = dam_contents.token::<Dam>().expect("a token");
    assert_eq!(dam.description().get("instantiationToken"), token);
    let page = dam.text("documentation/index.html");
    let words =
        ["Cracked Koyna dam", "<code>crack_sliding</code>", "0.0025 s", "density</code></td><td>52</td>"];
    for word in words.into_iter().chain(["2640.0", "fmi3SetFMUState", "output_interval"]) {
        assert!(page.contains(word), "`{word}` is missing in the page");
    }
    let replaced = ["{step}", "{end}", "{points}", "{about}", "{example}", "{variables}", "{title}"];
    assert!(replaced.iter().all(|name| !page.contains(name)));

    let mut reservoir = pack(folder.path(), "reservoir", &["--force"]);
    assert!(reservoir.names().contains(&"resources/mesh/boundary.csv".to_owned()));
    let added = pack(folder.path(), "reservoir", &["--force", "--set", "reservoir.fidelity=\"westergaard\""]);
    assert!(!added.names().iter().any(|name| name.starts_with("resources/mesh")));
    // No path of this machine is in the scene.
    let scene: toml::Table = reservoir.text("resources/scene.toml").parse().expect("TOML");
    let record = scene["ground_motion"]["record"]["file"].as_str();
    assert_eq!(record, Some("northridge-1994-canyon-country-270.csv"));
    assert_eq!(scene["dam"]["element_size"].as_float(), Some(10.0));
}

#[test]
fn the_dam_starts_under_the_water_of_the_reservoir_bit_for_bit() {
    let folder = folder();
    let mut dam =
        pack(folder.path(), "dam", &["--set", "gravity=9.80665", "--set", "reservoir.density=1001.3"]);
    let described = dam.description();
    let dam = contents::<Dam>(&mut dam, folder.path());
    let more = ["--force", "--set", "gravity=9.80665", "--set", "reservoir.density=1001.3"];
    let fidelity = ["--set", "reservoir.fidelity=\"westergaard\""];
    let mut packed = pack(folder.path(), "reservoir", &[&more[..], &fidelity].concat());
    let Contents { start, parameters, .. } = contents::<Reservoir>(&mut packed, folder.path());
    assert!(start.is_empty());
    let reservoir = Reservoir::from_parameters(parameters, NonZeroUsize::MIN).expect("a reservoir");
    let variable = &variables::reservoir::HYDROSTATIC_PRESSURE;
    let mut pressure = vec![0.0; reservoir.size(variable)];
    reservoir.get(variable.value_reference, &mut pressure).expect("a value");
    assert!(pressure[0] > 9e5, "{}", pressure[0]);
    assert_eq!(dam.start["hydrostatic_pressure"], pressure);
    let variables = described.list("ModelVariables", "Float64");
    let written =
        variables.into_iter().find(|v| v.get("name") == "hydrostatic_pressure").expect("a variable");
    assert_eq!(written.start(), pressure);
}

/// A tailwater is a reservoir, in the library and in the FMU: only its parameters say where it is.
#[test]
fn a_dam_between_two_waters_starts_under_both() {
    let folder = folder();
    let scene = root().join("scenes/koyna-tailwater");
    let of = |unit: &str, library: &str, output: &str| {
        let mut command = std::process::Command::new(binary());
        command.current_dir(folder.path()).arg("export-fmu").arg(&scene).args(["--unit", unit, "-o", output]);
        command.args(COARSE).args(["--set", "tailwater.fidelity=\"westergaard\"", "--library"]);
        command.arg(whole_chain::fmu::fake_library(folder.path(), library));
        let done = command.output().expect("cofferdam runs");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        Fmu::open(&folder.path().join(output))
    };
    let dam = contents::<Dam>(&mut of("dam", "dam", "dam.fmu"), folder.path());
    let tailwater = contents::<Reservoir>(&mut of("tailwater", "reservoir", "water.fmu"), folder.path());
    let tailwater = Reservoir::from_parameters(tailwater.parameters, NonZeroUsize::MIN).expect("a tailwater");
    assert_eq!(tailwater.name(), "tailwater");
    let variable = &variables::reservoir::HYDROSTATIC_PRESSURE;
    let mut pressure = vec![0.0; tailwater.size(variable)];
    tailwater.get(variable.value_reference, &mut pressure).expect("a value");
    assert_eq!(dam.start["tailwater_hydrostatic_pressure"], pressure);
    assert!((pressure[0] - 1000.0 * 9.81 * 30.0).abs() < 1.0, "{}", pressure[0]);
    assert!(dam.start["hydrostatic_pressure"].len() > pressure.len());
    let (status, said) = refused(folder.path(), SCENE, "tailwater", &[]);
    assert_eq!(status, Some(1));
    assert!(said.contains("no tailwater to pack"), "{said}");
}

#[test]
fn the_mesh_is_the_one_that_is_computed() {
    let folder = folder();
    let mut fmu = pack(folder.path(), "dam", &[]);
    let parameters = contents::<Dam>(&mut fmu, folder.path()).parameters;
    let Mesh { nodes, cells, .. } = parameters.mesh().expect("a mesh");
    let table = |text: String| -> Vec<Vec<f64>> {
        let row = |line: &str| line.split(',').map(|value| value.parse().expect("a number")).collect();
        text.lines().skip(1).map(row).collect()
    };
    let written: Vec<[f64; 2]> =
        table(fmu.text("resources/mesh/nodes.csv")).iter().map(|row| [row[0], row[1]]).collect();
    assert_eq!(written, nodes);
    let triangles = table(fmu.text("resources/mesh/triangles.csv"));
    assert_eq!(triangles.len(), 4 * cells.len());
    let area: f64 = triangles
        .iter()
        .map(|row| {
            let [a, b, c] = [0, 1, 2].map(|corner| nodes[row[corner] as usize]);
            let double = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            assert!(double > 0.0, "counter-clockwise");
            // The block number is that of the triangle's side of the crack.
            assert_eq!(row[3], f64::from(u8::from((a[1] + b[1] + c[1]) / 3.0 > 66.5)));
            double / 2.0
        })
        .sum();
    assert!((area / parameters.section.area() - 1.0).abs() < 1e-12);

    let mut fmu = pack(folder.path(), "reservoir", &["--force"]);
    let boundary = fmu.text("resources/mesh/boundary.csv");
    let length = |part: &str| -> f64 {
        let rows = boundary.lines().filter(|line| line.ends_with(part));
        let ends = rows
            .map(|line| line.split(',').take(4).map(|v| v.parse().expect("a number")).collect::<Vec<f64>>());
        ends.map(|x| (x[2] - x[0]).hypot(x[3] - x[1])).sum()
    };
    for (part, expected) in [("far_end", 91.75), ("bed", 91.75 / 2.0), ("wet_face", 91.75)] {
        assert!((length(part) / expected - 1.0).abs() < 1e-12, "{part}");
    }
}

#[test]
fn the_reservoir_may_have_panels_of_its_own() {
    let folder = folder();
    // 66.5 m up to the crack, 25.25 m from there.
    for (size, panels, element_size) in [("20", [4, 2], 91.75 / 16.0), ("3", [23, 9], 3.0)] {
        let set = format!("reservoir.interface_size={size}");
        let mut fmu = pack(folder.path(), "reservoir", &["--force", "--set", &set]);
        let parameters = contents::<Reservoir>(&mut fmu, folder.path()).parameters;
        let points = parameters.wet_face.points();
        assert_eq!(points.len(), panels[0] + panels[1] + 2);
        assert_eq!([points[panels[0]], points[panels[0] + 1]], [[0.0, 66.5]; 2]);
        assert_eq!(points[points.len() - 1], [0.0, 91.75]);
        assert_eq!(parameters.element_size, element_size);
    }
    let mut dam = pack(folder.path(), "dam", &["--force", "--set", "reservoir.interface_size=20"]);
    assert_eq!(contents::<Dam>(&mut dam, folder.path()).start["hydrostatic_pressure"].len(), 12);
}

#[test]
fn the_same_scene_gives_the_same_bytes() {
    let folder = folder();
    pack(folder.path(), "dam", &[]);
    let first = std::fs::read(folder.path().join("x.fmu")).expect("an FMU");
    pack(folder.path(), "dam", &["--force"]);
    assert!(first == std::fs::read(folder.path().join("x.fmu")).expect("an FMU"));
    pack(folder.path(), "dam", &["--force", "--set", "dam.material.density=2641"]);
    assert!(first != std::fs::read(folder.path().join("x.fmu")).expect("an FMU"));
}

#[test]
fn it_says_what_was_packed() {
    let folder = folder();
    let output = export(folder.path(), &root().join("scenes").join(SCENE), "reservoir", &COARSE);
    let said = String::from_utf8_lossy(&output.stdout);
    let size = std::fs::metadata(folder.path().join("koyna-coarse-reservoir.fmu")).expect("an FMU").len();
    let size = format!("{} kB", size.div_ceil(1000));
    for word in ["koyna-coarse-reservoir.fmu: ", &size, "12 interface points", "0.0025 s", "index.html"] {
        assert!(said.contains(word), "`{word}` is missing in:\n{said}");
    }
}

/// A dam that is coupled must not have the water in its mass too, whatever the scene's own scheme does.
#[test]
fn the_water_is_in_the_dams_mass_only_if_asked() {
    let folder = folder();
    let set = ["--set", "reservoir.fidelity=westergaard"];
    let mut dry = pack(folder.path(), "dam", &set);
    let dry = contents::<Dam>(&mut dry, folder.path()).parameters;
    assert_eq!(dry.added_mass, None);
    let mut with_water = pack(folder.path(), "dam", &[&set[..], &["--force", "--added-mass"]].concat());
    let with_water = contents::<Dam>(&mut with_water, folder.path()).parameters;
    assert!(with_water.added_mass.is_some());
    let described = |name: &str, more: &[&str]| {
        let more = [&COARSE[..], &["--force"], more].concat();
        let output = export(folder.path(), &root().join("scenes").join(SCENE), name, &more);
        assert!(output.status.success());
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    assert!(described("dam", &[]).contains("(added_mass_included = 0): couple it with a reservoir"));
    assert!(described("dam", &["--added-mass"]).contains("simulate it without a reservoir"));
    assert!(described("reservoir", &[]).contains("whose added_mass_included is 0"));
    std::fs::remove_dir_all(folder.path()).and_then(|()| std::fs::create_dir(folder.path())).expect("empty");
    let (status, said) = refused(folder.path(), SCENE, "reservoir", &["--added-mass"]);
    assert_eq!(status, Some(2));
    assert!(said.contains("--added-mass is for the dam's FMU"), "{said}");
}

#[test]
fn an_existing_file_is_overwritten_only_with_force() {
    let folder = folder();
    let path = folder.path().join("x.fmu");
    std::fs::write(&path, "mine").expect("written");
    let (status, said) = refused(folder.path(), SCENE, "dam", &["-o", "x.fmu"]);
    assert!(said.contains("x.fmu exists; choose another --output, or overwrite it with --force"), "{said}");
    assert_eq!((status, std::fs::read(&path).expect("a file")), (Some(1), b"mine".to_vec()));
    pack(folder.path(), "dam", &["--force"]);
    assert!(std::fs::read(&path).expect("an FMU").starts_with(b"PK"));
}

#[test]
fn only_regular_files_are_replaced() {
    let folder = folder();
    let link = folder.path().join("x.fmu");
    std::os::unix::fs::symlink("elsewhere", &link).expect("a link");
    for more in [&["-o", "x.fmu"][..], &["-o", "x.fmu", "--force"]] {
        let (status, said) = refused(folder.path(), SCENE, "dam", more);
        assert!(said.contains("x.fmu is not a regular file and is not overwritten"), "{said}");
        assert_eq!((status, link.is_symlink()), (Some(1), true));
    }
}

#[test]
fn what_cannot_be_packed_is_refused_with_a_remedy() {
    let folder = folder();
    let refused = |scene: &str, unit: &str, more: &[&str]| refused(folder.path(), scene, unit, more);
    let (status, said) = refused(SCENE, "dam", &["-o", "none/x.fmu"]);
    assert_eq!(status, Some(1));
    assert!(said.contains("the folder none does not exist; make it first"), "{said}");
    for folder in [".", "none/"] {
        let (status, said) = refused(SCENE, "dam", &["-o", folder]);
        assert_eq!(status, Some(1));
        assert!(said.contains("give --output the name of the FMU"), "{said}");
    }
    let (status, said) = refused(SCENE, "water", &[]);
    assert_eq!(status, Some(2));
    assert!(said.contains("[possible values: dam, reservoir, tailwater, coupled]"), "{said}");
    let (status, said) = refused("rigid-dam-ramp", "dam", &[]);
    assert_eq!(status, Some(1));
    assert!(said.contains("--unit reservoir") && said.contains("give the scene a [dam]"), "{said}");
    let past = ["--set", "dam.fidelity=log", "--set", "dam.log={file=\"scene.toml\"}"];
    let (status, said) = refused(SCENE, "dam", &past);
    assert_eq!(status, Some(1));
    assert!(said.contains("the scene's dam is another program's or a run's of the past"), "{said}");
    let (status, said) = refused(SCENE, "dam", &["--set", "dam.material.density=-1"]);
    assert_eq!(status, Some(2));
    assert!(said.contains("dam.material.density=-1"), "{said}");
    // A mistake that is found only when the dam is made.
    let stiff =
        ["dam.cracks.0.normal_stiffness=1e15", "dam.element_size=2.0", "time.communication_step=0.01"];
    let (status, said) = refused(SCENE, "dam", &stiff.map(|value| ["--set", value]).concat());
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("lower the joint stiffness"), "{said}");
}

#[test]
fn a_file_that_is_not_the_library_is_refused() {
    let folder = folder();
    let said = |library: &Path| {
        let mut command = std::process::Command::new(binary());
        command.current_dir(folder.path()).arg("export-fmu").arg(root().join("scenes/rigid-dam-ramp"));
        command.args(["--unit", "reservoir", "-o", "x.fmu", "--library"]).arg(library);
        let output = command.output().expect("cofferdam runs");
        assert_eq!(output.status.code(), Some(1));
        assert!(!folder.path().join("x.fmu").exists());
        let said = String::from_utf8_lossy(&output.stderr).replace('│', " ");
        said.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let missing = said(Path::new("none.so"));
    assert!(missing.contains("none.so") && missing.contains("with --library"), "{missing}");
    let other = said(&root().join("Cargo.toml"));
    assert!(other.contains("is not a shared library for") && other.contains("with --library"), "{other}");
    for library in [whole_chain::fmu::fake_library(folder.path(), "dam"), binary().to_owned()] {
        let other = said(&library);
        assert!(other.contains("is not the library of the unit `reservoir`; leave out --library"), "{other}");
    }
}

#[test]
fn a_doubtful_scene_is_packed_with_its_warnings() {
    let folder = folder();
    let output =
        export(folder.path(), &root().join("scenes").join(SCENE), "dam", &["--set", "dam.element_size=25"]);
    assert!(output.status.success());
    let said = String::from_utf8_lossy(&output.stderr).replace('│', " ");
    assert!(
        said.split_whitespace().collect::<Vec<_>>().join(" ").contains("`dam.element_size` is 25 m"),
        "{said}"
    );
}

#[test]
fn help_teaches() {
    let help = std::process::Command::new(binary()).args(["export-fmu", "--help"]).output().expect("help");
    let help = String::from_utf8_lossy(&help.stdout).into_owned();
    for word in ["FMI 3.0", "Exit status", "Examples", "--force", "--library", "documentation/index.html"] {
        assert!(help.contains(word), "`{word}` is missing in:\n{help}");
    }
}
