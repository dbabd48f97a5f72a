//! `cofferdam points` and `cofferdam template`: the points are those of the units, the C compiles without a warning, nothing is
//! overwritten. `tests/python/test_template.py` simulates what is written.

use cofferdam_assembly::{Assembly, read_scene};
use cofferdam_scene::Side;
use cofferdam_unit::WetFace;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;
use whole_chain::scenario::{binary, root};

const CRACKED: &str = "koyna-coarse";
const RAMP: &str = "rigid-dam-ramp";
const OWN_POINTS: &str = "reservoir.interface_size=7.3";

fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn cofferdam(arguments: &[&str]) -> Output {
    Command::new(binary()).args(arguments).output().expect("cofferdam runs")
}

fn scene(case: &str) -> String {
    root().join("scenes").join(case).to_string_lossy().into_owned()
}

/// Standard output and error of a command that succeeds.
fn said(arguments: &[&str]) -> [String; 2] {
    let output = cofferdam(arguments);
    let texts = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).expect("text"));
    assert!(output.status.success(), "{arguments:?}: {}", texts[1]);
    texts
}

/// Exit status and message, on one line, of a command that is refused.
fn refused(arguments: &[&str]) -> (Option<i32>, String) {
    let output = cofferdam(arguments);
    let said = String::from_utf8_lossy(&output.stderr).replace('│', " ");
    (output.status.code(), said.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// The columns of a face, as its geometry gives them.
fn columns(face: &WetFace) -> [Vec<f64>; 5] {
    let (points, normals) = (face.points(), face.normals());
    let of = |pairs: &[[f64; 2]], axis: usize| pairs.iter().map(|pair| pair[axis]).collect::<Vec<f64>>();
    [of(points, 0), of(points, 1), of(&normals, 0), of(&normals, 1), face.tributary_lengths()]
}

/// The numbers of JSON after `key`, all their digits read.
fn numbers(json: &str, key: &str) -> Vec<f64> {
    let rest = json.split(key).nth(1).expect(key);
    let end = rest.find([']', '"', '}']).expect("an end");
    let fields = rest[..end].split(',').filter(|field| !field.is_empty());
    fields.map(|field| field.parse().expect("a number")).collect()
}

const NAMES: [&str; 5] = ["x", "y", "normal_x", "normal_y", "tributary_length"];

#[test]
fn the_points_are_those_of_the_unit_bit_for_bit() {
    let scene = scene(CRACKED);
    // Koyna's face is vertical; the last one has a kink, so that normals differ.
    let cases: [(&str, &[&str], &str); 4] = [
        ("reservoir", &[], "points of the dam, which the reservoir shares"),
        ("reservoir", &[OWN_POINTS], "points of the reservoir's own"),
        ("dam", &[OWN_POINTS], "points of the dam"),
        (
            "reservoir",
            &["dam.section.upstream=[[0,0],[2.5,31.5],[2.5,103]]", OWN_POINTS],
            "points of the reservoir's own",
        ),
    ];
    for (unit, set, told) in cases {
        let set: Vec<String> = set.iter().map(|text| (*text).to_owned()).collect();
        let loaded = match read_scene(scene.as_ref(), &set) {
            Ok(loaded) => loaded,
            Err(error) => panic!("{error:?}"),
        };
        let face = match unit {
            "dam" => Assembly::of(&loaded.scene).dam_face(Side::Upstream),
            _ => Assembly::of(&loaded.scene).water_face(Side::Upstream),
        };
        let face = face.expect("a face");
        let wanted = columns(&face);
        let options: Vec<&str> = set.iter().flat_map(|value| ["--set", value]).collect();
        let arguments = [&["points", &scene, "--unit", unit][..], &options].concat();
        let [text, note] = said(&arguments);
        assert!(note.contains(&format!("{} {told}", face.len())), "{note}");
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("index,x,y,normal_x,normal_y,tributary_length"));
        let rows: Vec<Vec<f64>> = lines
            .map(|line| line.split(',').map(|field| field.parse().expect("a number")).collect())
            .collect();
        assert_eq!(rows.len(), face.len());
        for (index, row) in rows.iter().enumerate() {
            let whole: Vec<f64> =
                std::iter::once(index as f64).chain(wanted.iter().map(|c| c[index])).collect();
            assert_eq!(*row, whole);
        }

        let [text, _] = said(&[&arguments[..], &["--format", "json"]].concat());
        for (name, column) in NAMES.iter().zip(&wanted) {
            assert_eq!(numbers(&text, &format!("\"{name}\":[")), *column, "{name}");
        }
        let scalars = ["depth", "density", "gravity", "communication_step"];
        let scalars = scalars.map(|name| numbers(&text, &format!("\"{name}\":"))[0]);
        let of_scene = &loaded.scene;
        let expected =
            [face.depth(), of_scene.reservoir.density, of_scene.gravity, of_scene.time.communication_step];
        assert_eq!(scalars, expected);
        let _: Value = serde_json::from_str(&text).expect("JSON");
    }
}

/// The compiler's word on a source, with all warnings as errors.
fn compile(source: &Path, standard: &str) {
    let mut compiler = Command::new("cc");
    compiler.args([standard, "-pedantic", "-Wall", "-Wextra", "-Werror", "-O2", "-c", "-o", "/dev/null"]);
    let output = compiler.arg(source).output().expect("a C compiler, cc");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_c_sources_compile_without_a_warning() {
    for (unit, name, case) in [("reservoir", "water", CRACKED), ("dam", "dam", CRACKED), ("dam", "dam", RAMP)]
    {
        let folder = folder();
        let own = folder.path().join("own");
        let own_text = own.to_string_lossy().into_owned();
        let [told, _] = said(&["template", "c", &own_text, "--scene", &scene(case), "--unit", unit]);
        assert!(told.contains("interface points; README.md"), "{told}");
        for standard in ["-std=c11", "-std=gnu17"] {
            compile(&own.join(name).with_extension("c"), standard);
        }
        let readme = std::fs::read_to_string(own.join("README.md")).expect("a README");
        assert!(!readme.contains('@'), "a word is left to replace: {readme}");
    }
}

#[test]
fn a_token_stands_for_face_and_water() {
    let token = |set: &[&str]| {
        let folder = folder();
        let own = folder.path().join("own");
        let options: Vec<&str> = set.iter().flat_map(|value| ["--set", value]).collect();
        let own_text = own.to_string_lossy().into_owned();
        said(&[&["template", "c", &own_text, "--scene", &scene(RAMP)][..], &options].concat());
        let header = std::fs::read_to_string(own.join("wet_face.h")).expect("a header");
        let line = header.lines().find(|line| line.starts_with("#define TOKEN")).expect("a token").to_owned();
        let quoted = line.split('"').nth(1).expect("quotes").to_owned();
        let xml = std::fs::read_to_string(own.join("fmu/modelDescription.xml")).expect("XML");
        assert!(xml.contains(&format!("instantiationToken=\"{quoted}\"")));
        quoted
    };
    let first = token(&[]);
    assert_eq!(first, token(&["time.duration=1"]), "the same face and water");
    for other in ["prescribed.panels=15", "reservoir.density=999", "prescribed.batter=1"] {
        assert_ne!(first, token(&[other]), "{other}");
    }
}

#[test]
fn nothing_is_overwritten_and_wrong_scenes_are_refused() {
    let folder = folder();
    let (own, file) = (folder.path().join("own"), folder.path().join("file"));
    std::fs::create_dir(&own).expect("a folder");
    std::fs::write(own.join("mine.c"), "mine").expect("a file");
    std::fs::write(&file, "mine").expect("a file");
    let [own_text, file_text, new] =
        [&own, &file, &folder.path().join("new")].map(|path| path.to_string_lossy().into_owned());
    let ramp = scene(RAMP);
    for language in ["c", "python"] {
        for taken in [&own_text, &file_text] {
            let (status, said) = refused(&["template", language, taken, "--scene", &ramp]);
            assert_eq!(status, Some(1));
            assert!(
                said.contains("is not an empty folder; choose another FOLDER, nothing is overwritten"),
                "{said}"
            );
        }
        let (status, said) = refused(&["template", language, "", "--scene", &ramp]);
        assert_eq!(status, Some(2), "{said}");
        let below_file = format!("{file_text}/new");
        let (status, said) = refused(&["template", language, &below_file, "--scene", &ramp]);
        assert_eq!(status, Some(1), "{said}");
        let wrong = ["--set", "reservoir.depth=-3"];
        let (status, said) = refused(&[&["template", language, &new, "--scene", &ramp][..], &wrong].concat());
        assert_eq!(status, Some(2));
        assert!(said.contains("`reservoir.depth` is -3"), "{said}");
    }
    let left: Vec<_> =
        std::fs::read_dir(&own).expect("a folder").flatten().map(|entry| entry.file_name()).collect();
    assert_eq!(left, ["mine.c"]);
    assert_eq!(std::fs::read_to_string(own.join("mine.c")).expect("mine"), "mine");
    assert!(!Path::new(&new).exists(), "a wrong scene leaves no folder");

    // An empty folder is as good as none.
    std::fs::create_dir(&new).expect("a folder");
    said(&["template", "python", &new, "--scene", &ramp]);

    // `points` says of a scene what `check` says of it.
    let wrong = ["--set", "prescribed.panels=0", "--set", "gravity=-1"];
    let told = ["points", "check"].map(|command| refused(&[&[command, &ramp][..], &wrong].concat()));
    assert_eq!(told[0], told[1]);
    assert_eq!(told[0].0, Some(2));
    assert!(told[0].1.contains("`prescribed.panels` is 0"), "{}", told[0].1);
    for arguments in [&["points", &ramp, "--format", "xml"][..], &["points", &ramp, "--unit", "water"]] {
        assert_eq!(refused(arguments).0, Some(2));
    }
}

#[test]
fn help_teaches() {
    let cases = [
        (&["points", "--help"][..], ["Examples:", "Exit status: 0", "interface_size"]),
        (&["template", "c", "--help"], ["Examples:", "Exit status: 0", "build.sh"]),
        (&["template", "python", "--help"], ["Example:", "Exit status: 0", "water.py"]),
    ];
    for (command, words) in cases {
        let [help, _] = said(command);
        for word in words {
            assert!(help.contains(word), "`{word}` is missing in:\n{help}");
        }
    }
}
