//! What `check` draws and writes: the section of a scene, natural frequencies and modes of its dam.

use cofferdam_dam::Dam;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use quick_xml::{Reader, events::BytesStart, events::Event};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;
use std::process::Command;
use whole_chain::koyna::{CREST, DEPTH, NECK, dam, width};
use whole_chain::scenario::{Scenario, binary, root};

const CRACKED: &str = "scenes/koyna-coarse";

/// Exit status, standard output and standard error on a line.
fn check(arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(binary());
    let output = command.arg("check").args(arguments).current_dir(root()).output().expect("cofferdam runs");
    let complaint = String::from_utf8_lossy(&output.stderr);
    // as miette wraps it
    let complaint: Vec<&str> = complaint.split([' ', '\n', '│']).filter(|word| !word.is_empty()).collect();
    (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned(), complaint.join(" "))
}

/// A shape of a picture: attributes, and the class of the group it is in.
struct Shape {
    name: String,
    within: String,
    attributes: BTreeMap<String, String>,
}

impl Shape {
    fn of(start: &BytesStart<'_>, within: &str) -> Self {
        let pairs = start.attributes().map(|attribute| {
            let attribute = attribute.expect("attributes are well formed");
            let value = String::from_utf8(attribute.value.as_ref().as_bytes().to_vec()).expect("UTF-8");
            (String::from_utf8(attribute.key.as_ref().as_bytes().to_vec()).expect("UTF-8"), value)
        });
        let name = String::from_utf8(start.name().as_ref().as_bytes().to_vec()).expect("UTF-8");
        Self { name, within: within.to_owned(), attributes: pairs.collect() }
    }

    fn get(&self, key: &str) -> &str {
        self.attributes.get(key).map_or("", String::as_str)
    }

    fn number(&self, key: &str) -> f64 {
        self.get(key).parse().unwrap_or_else(|_| panic!("{} {key} = {:?}", self.name, self.get(key)))
    }

    fn points(&self) -> Vec<[f64; 2]> {
        let pairs = self.get("points").split(' ').map(|pair| {
            let (x, y) = pair.split_once(',').expect("x,y");
            [x, y].map(|number| number.parse().expect("a number"))
        });
        pairs.collect()
    }
}

/// The shapes of a picture, and all its texts, titles included.
struct Picture {
    shapes: Vec<Shape>,
    texts: Vec<String>,
}

impl Picture {
    fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).expect("a picture");
        let mut reader = Reader::from_str(&text);
        let (mut shapes, mut texts, mut groups) = (Vec::new(), Vec::new(), Vec::<String>::new());
        let mut words = String::new();
        loop {
            let event = reader.read_event().expect("well-formed XML");
            let within = groups.iter().rev().find(|class| !class.is_empty()).cloned().unwrap_or_default();
            match event {
                Event::Start(start) => {
                    let shape = Shape::of(&start, &within);
                    groups.push(shape.get("class").to_owned());
                    shapes.push(shape);
                    words.clear();
                }
                Event::Empty(start) => shapes.push(Shape::of(&start, &within)),
                Event::Text(content) => words += &content,
                Event::GeneralRef(entity) => {
                    words += match &*entity {
                        "amp" => "&",
                        "lt" => "<",
                        "gt" => ">",
                        "apos" => "'",
                        other => panic!("entity {other}"),
                    }
                }
                Event::End(_) => {
                    groups.pop();
                    texts.extend(Some(words.trim().to_owned()).filter(|text| !text.is_empty()));
                    words.clear();
                }
                Event::Eof => return Self { shapes, texts },
                _ => {}
            }
        }
    }

    fn of_class(&self, class: &str) -> Vec<&Shape> {
        self.shapes.iter().filter(|shape| shape.get("class") == class).collect()
    }

    fn lines_of_cracks(&self) -> Vec<&Shape> {
        self.shapes.iter().filter(|shape| shape.within == "crack" && shape.name == "polyline").collect()
    }

    fn says(&self, text: &str) -> bool {
        self.texts.iter().any(|own| own == text)
    }

    /// Of the elements, m².
    fn areas(&self) -> Vec<f64> {
        let corners = |triangle: &str| {
            let numbers = triangle.split(['L', ' ', 'Z']).filter_map(|number| number.parse().ok());
            let [x0, y0, x1, y1, x2, y2] = numbers.collect::<Vec<f64>>()[..] else { panic!("{triangle}") };
            ((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)) / 2.0
        };
        let mesh = self.of_class("mesh")[0].get("d");
        mesh.split('M').filter(|text| !text.is_empty()).map(corners).collect()
    }

    /// Pixels a metre, x and y, and the pixel of the heel.
    fn scale(&self) -> [[f64; 2]; 2] {
        let section = self.shapes.iter().find(|shape| shape.get("id") == "section").expect("a section");
        let numbers = section.get("transform").split(['(', ')', ' ']).filter_map(|word| word.parse().ok());
        let [x, y, a, b] = numbers.collect::<Vec<f64>>()[..] else { panic!("no transform") };
        [[a, -b], [x, y]]
    }
}

/// Area of the section, m².
fn area() -> f64 {
    (70.0 + width(NECK)) / 2.0 * NECK + (width(NECK) + 14.8) / 2.0 * (CREST - NECK)
}

/// The main scene: what is drawn lies where the scene says, at one scale, within the picture.
#[test]
fn the_section_is_drawn_to_scale() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("koyna.svg");
    let (status, said, complaint) = check(&[CRACKED, "--picture", path.to_str().expect("UTF-8")]);
    assert_eq!(status, Some(0), "{complaint}");
    assert!(said.lines().last().is_some_and(|line| line.starts_with("  wrote ")), "{said}");
    let picture = Picture::read(&path);
    let [scale, heel] = picture.scale();
    assert_eq!(scale[0], scale[1]);
    // frame and picture hold the whole dam
    let frame = picture.of_class("frame")[0];
    let [left, top, wide, high] = ["x", "y", "width", "height"].map(|key| frame.number(key));
    for [x, y] in [[0.0, 0.0], [70.0, 0.0], [0.0, CREST]] {
        let [at, up] = [heel[0] + scale[0] * x, heel[1] - scale[1] * y];
        assert!(left < at && at < left + wide && top < up && up < top + high, "{x} {y}");
    }
    let svg = &picture.shapes[0];
    let view: Vec<f64> = svg.get("viewBox").split(' ').map(|n| n.parse().expect("a number")).collect();
    assert_eq!(view[2] / view[3], svg.number("width") / svg.number("height"));
    assert!(left + wide < view[2] && top + high < view[3]);

    let lines = picture.lines_of_cracks();
    assert_eq!(lines.len(), 1);
    let crack = lines[0].points();
    assert_eq!([crack[0], crack[crack.len() - 1]], [[0.0, NECK], [width(NECK), NECK]]);
    for text in ["66.5 m", "crack: 66.5 m", "water up to 91.75 m", "concrete: 560 elements of about 5 m"] {
        assert!(picture.says(text), "{text} is not among {:?}", picture.texts);
    }
    let water = picture.of_class("water");
    assert_eq!(water.len(), 1, "no tailwater");
    let over = |axis: usize| {
        water[0].points().iter().fold([f64::MAX, f64::MIN], |[a, b], p| [a.min(p[axis]), b.max(p[axis])])
    };
    assert_eq!((over(0)[1], over(1)), (0.0, [0.0, DEPTH]));
    let wet = picture.of_class("wet-point");
    let face = dam(5.0, true).wet_face().expect("a face").expect("water");
    let found: Vec<[f64; 2]> = wet.iter().map(|dot| [dot.number("cx"), dot.number("cy")]).collect();
    assert_eq!(found.len(), face.len());
    for (dot, point) in found.iter().zip(face.points()) {
        assert!((dot[0] - point[0]).abs() < 1e-4 && (dot[1] - point[1]).abs() < 1e-4, "{dot:?} {point:?}");
    }
    // every element, and their area is that of the section
    let areas = picture.areas();
    assert_eq!(areas.len(), 560);
    assert!((areas.iter().sum::<f64>() / area() - 1.0).abs() < 1e-4);
}

/// Several cracks with names that XML must escape, points of the water's own, a bed that rises, a tailwater.
#[test]
fn everything_of_a_section_is_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("all.SVG");
    let joint = "friction_coefficient = 1.2, normal_stiffness = 1e11, shear_stiffness = 5e10";
    let cracks = format!(
        "dam.cracks=[{{elevation = 66.5, name = \"neck & <old>\", {joint}}}, {{elevation = 0, name = \"base\", {joint}}}, \
         {{elevation = 30, {joint}}}]"
    );
    let mut arguments = vec!["scenes/koyna-tailwater", "--picture", path.to_str().expect("UTF-8")];
    let sets = [&cracks, "reservoir.bed=[[-20.0, 10.0], [-400.0, 20.0]]", "reservoir.interface_size=12"];
    sets.iter().for_each(|set| arguments.extend(["--set", set]));
    let (status, _, complaint) = check(&arguments);
    assert_eq!(status, Some(0), "{complaint}");
    let picture = Picture::read(&path);
    let lines = picture.lines_of_cracks();
    let elevations: Vec<f64> = lines.iter().map(|line| line.points()[0][1]).collect();
    assert_eq!(elevations, [0.0, 30.0, 66.5]);
    let joint = lines[0].points();
    assert_eq!([joint[0][0], joint[joint.len() - 1][0]], [0.0, 70.0], "the joint ends at heel and toe");
    let groups = picture.of_class("crack");
    let colours: std::collections::BTreeSet<&str> = groups.iter().map(|group| group.get("stroke")).collect();
    assert_eq!(colours.len(), 3, "each crack has a colour");
    for text in ["neck & <old>", "crack: neck & <old>", "base", "30 m"] {
        assert!(picture.says(text), "{text} is not among {:?}", picture.texts);
    }
    let waters = picture.of_class("water");
    assert_eq!(waters.iter().map(|water| water.get("id")).collect::<Vec<_>>(), ["reservoir", "tailwater"]);
    assert!(waters[0].points().contains(&[-20.0, 10.0]), "the bed rises");
    assert!(waters[1].points().iter().all(|[x, y]| *y <= 30.0 && *x >= 47.0), "{:?}", waters[1].points());
    assert!(!picture.of_class("own-point").is_empty());
}

/// Elements leave a gallery out, and a crack that it cuts is drawn in two parts of one colour.
#[test]
fn a_gallery_stays_empty() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("gallery.svg");
    let gallery = "dam.section.galleries=[[[6.0, 62.0], [10.0, 62.0], [10.0, 70.0], [6.0, 70.0]]]";
    let (status, _, complaint) =
        check(&[CRACKED, "--set", gallery, "--picture", path.to_str().expect("UTF-8")]);
    assert_eq!(status, Some(0), "{complaint}");
    let picture = Picture::read(&path);
    assert!((picture.areas().iter().sum::<f64>() / (area() - 32.0) - 1.0).abs() < 1e-4);
    let parts: Vec<[f64; 2]> = picture
        .lines_of_cracks()
        .iter()
        .map(|line| {
            let points = line.points();
            [points[0][0], points[points.len() - 1][0]]
        })
        .collect();
    assert_eq!(
        (parts.as_slice(), picture.of_class("crack").len()),
        ([[0.0, 6.0], [10.0, width(NECK)]].as_slice(), 1)
    );
}

/// Zones are drawn with their areas and names, and are a field of the modes and of snapshots, of the same areas.
#[test]
fn zones_are_drawn_and_written() {
    const FACING: f64 = 5.0;
    const CORE: f64 = 400.0;
    let zones = format!(
        "dam.zones=[{{name=\"facing\", polygon=[[-1, -1], [{FACING}, -1], [{FACING}, 104], [-1, 104]], young_modulus=18e9}}, \
         {{name=\"core\", polygon=[[15, 10], [35, 10], [35, 30], [15, 30]], density=2900}}]"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let (picture, modes) = (folder.path().join("zones.svg"), folder.path().join("modes"));
    let paths = [&picture, &modes].map(|path| path.to_str().expect("UTF-8"));
    let (status, _, complaint) =
        check(&[CRACKED, "--set", &zones, "--picture", paths[0], "--modes", paths[1]]);
    assert_eq!(status, Some(0), "{complaint}");
    let picture = Picture::read(&picture);
    let drawn: Vec<f64> = picture.of_class("zone").iter().map(|zone| area_of(zone.get("d"))).collect();
    let exact = [FACING * CREST, CORE];
    assert!(drawn.iter().zip(exact).all(|(drawn, exact)| (drawn / exact - 1.0).abs() < 1e-4), "{drawn:?}");
    assert!(["facing", "core"].iter().all(|name| picture.says(name)));

    let mut scenario = Scenario::shipped("koyna-coarse");
    scenario.set("time.duration", 0.01);
    let mut run = scenario.command("run");
    run.args(["--set", &zones, "--set", "snapshots.interval=0.01"]);
    let done = run.output().expect("cofferdam runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let snapshot = scenario.folder().join("run/snapshots/dam-000000.vtu");
    for file in [modes.join("modes.vtu"), snapshot] {
        let found = arrays(&file);
        let place = |node: f64| {
            let at = 3 * node as usize;
            [found["points"][at], found["points"][at + 1]]
        };
        let mut areas = [0.0; 3];
        for (corners, zone) in found["connectivity"].as_chunks::<3>().0.iter().zip(&found["zone"]) {
            let [a, b, c] = corners.map(place);
            areas[*zone as usize] += ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])) / 2.0;
        }
        let whole = area();
        for (found, exact) in areas.into_iter().zip([whole - exact[0] - exact[1], exact[0], exact[1]]) {
            assert!((found / exact - 1.0).abs() < 1e-9, "{areas:?}");
        }
    }
}

/// The area of the closed polygons of a path, `M` and `L`, m².
fn area_of(path: &str) -> f64 {
    let polygons = path.split('Z').filter(|polygon| !polygon.is_empty()).map(|polygon| {
        let points = polygon.trim_start_matches('M').split('L').map(|point| {
            let (x, y) = point.split_once(' ').expect("x y");
            [x, y].map(|number| number.parse::<f64>().expect("a number"))
        });
        let points: Vec<[f64; 2]> = points.collect();
        let next = points.iter().cycle().skip(1);
        points.iter().zip(next).map(|(a, b)| (a[0] * b[1] - b[0] * a[1]) / 2.0).sum::<f64>()
    });
    polygons.sum()
}

#[test]
fn a_dam_without_a_mesh_is_drawn_without_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ramp.svg");
    let (status, _, complaint) =
        check(&["scenes/rigid-dam-ramp", "--picture", path.to_str().expect("UTF-8")]);
    assert_eq!(status, Some(0), "{complaint}");
    let picture = Picture::read(&path);
    assert!(picture.of_class("mesh").is_empty() && picture.says("prescribed dam: wet face only"));
    assert_eq!(picture.of_class("wet-point").len(), 17);

    let mut scenario = Scenario::quick(0.3);
    scenario.set("reservoir.fidelity", "compressible").run();
    let recorded: toml::Table = "file = \"run\"".parse().expect("TOML");
    scenario.set("dam.fidelity", "log").set("dam.log", recorded);
    let scene = scenario.write();
    let [scene, path] = [scene.to_str(), path.to_str()].map(|path| path.expect("UTF-8"));
    let (status, said, complaint) = check(&[scene, "--picture", path]);
    assert_eq!(status, Some(0), "{complaint}");
    assert!(!said.contains("full"), "the mass of another dam is not known: {said}");
    let picture = Picture::read(Path::new(path));
    assert!(picture.of_class("mesh").is_empty() && picture.lines_of_cracks().is_empty());
    assert!(picture.says("dam of another program, without its mesh"), "{:?}", picture.texts);
    assert_eq!(picture.of_class("outline")[0].points().len(), 5);
}

#[test]
fn files_that_cannot_be_are_refused_with_a_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    std::fs::write(at("file"), "x").expect("written");
    let intact = "scenes/koyna-intact";
    for (arguments, status, words) in [
        (vec![CRACKED, intact, "--picture", &at("a.svg")], 2, ["there are 2 scenes", "one scene"]),
        (vec![CRACKED, intact, "--modes", &at("a")], 2, ["there are 2 scenes", "one scene"]),
        (vec![intact, "--picture", "scene.toml"], 2, ["--picture scene.toml", "ends in .svg"]),
        (vec![intact, "--picture", &at("nowhere/a.svg")], 1, ["nowhere/a.svg", "create the folder first"]),
        (vec![intact, "--modes", &at("file")], 1, ["file cannot be written", "choose another name"]),
        (vec!["scenes/rigid-dam-ramp", "--modes", &at("a")], 2, ["has no modes", "leave the option out"]),
    ] {
        let (found, said, complaint) = check(&arguments);
        assert_eq!(found, Some(status), "{arguments:?}: {complaint}");
        assert!(words.iter().all(|word| complaint.contains(word)), "{arguments:?}: {complaint}");
        assert!(!said.contains("wrote"), "{said}");
    }
    let left: Vec<_> = std::fs::read_dir(folder.path()).expect("a folder").collect();
    assert_eq!(left.len(), 1, "nothing is left behind: {left:?}");
}

/// Mass of incompressible water before a vertical face by its modes, for motions N_i of the points that are linear along the panels:
/// `ρ Σ 2/(h λ) ∫ cos(λy) N_i dy ∫ cos(λy) N_j dy`, kg/m; 200 modes leave out 1e-5 of it.
fn still_water(heights: &[f64]) -> DMatrix<f64> {
    let points = heights.len();
    let mut mass = DMatrix::<f64>::zeros(points, points);
    for m in 0..200 {
        let lambda = f64::from(2 * m + 1) * PI / (2.0 * DEPTH);
        let mut integrals = DVector::<f64>::zeros(points);
        for (start, pair) in heights.windows(2).enumerate() {
            let length = pair[1] - pair[0];
            for k in 0..200 {
                let along = (f64::from(k) + 0.5) / 200.0;
                let part = (lambda * (pair[0] + along * length)).cos() * length / 200.0;
                integrals[start] += (1.0 - along) * part;
                integrals[start + 1] += along * part;
            }
        }
        mass.ger(1000.0 * 2.0 / (DEPTH * lambda), &integrals, &integrals, 1.0);
    }
    mass
}

/// The lowest natural frequencies, rad/s, from the dense matrices of the dam and the water's series.
fn independent() -> Result<Vec<f64>, Box<dyn std::error::Error>> {
    let dam = Dam::new(dam(5.0, false))?;
    let face = dam.wet_face().ok_or("a wet face")?;
    let heights: Vec<f64> = face.points().iter().map(|point| point[1]).collect();
    let matrices = dam.system_matrices();
    let (size, points) = (matrices.mass.len(), heights.len());
    let mut stiffness = DMatrix::<f64>::zeros(size, size);
    let mut motion = DMatrix::<f64>::zeros(points, size);
    matrices.interface_motion.iter().for_each(|&(point, dof, value)| motion[(point, dof)] += value);
    matrices.stiffness.iter().for_each(|&(row, column, value)| stiffness[(row, column)] += value);
    let water = motion.transpose() * still_water(&heights) * motion;
    let mass = DMatrix::from_diagonal(&DVector::from_vec(matrices.mass)) + water;
    // 1/ω² of K⁻¹ (M + X)
    let lower = stiffness.cholesky().ok_or("a stiffness is positive")?.unpack();
    let half = lower.solve_lower_triangular(&mass).ok_or("it is regular")?;
    let whole = lower.solve_lower_triangular(&half.transpose()).ok_or("it is regular")?;
    let mut found: Vec<f64> = SymmetricEigen::new((&whole + whole.transpose()) / 2.0)
        .eigenvalues
        .iter()
        .map(|v| v.powf(-0.5))
        .collect();
    found.sort_by(f64::total_cmp);
    Ok(found)
}

/// The arrays of a `.vtu` file by name.
fn arrays(path: &Path) -> BTreeMap<String, Vec<f64>> {
    let text = std::fs::read_to_string(path).expect("modes");
    let mut reader = Reader::from_str(&text);
    let (mut found, mut name) = (BTreeMap::new(), None);
    loop {
        match reader.read_event().expect("well-formed XML") {
            Event::Start(start) => {
                name = Some(Shape::of(&start, "").get("Name").to_owned()).filter(|name| !name.is_empty());
            }
            Event::Text(content) => {
                if let Some(name) = name.take() {
                    let numbers = content.split_whitespace().map(|n| n.parse().expect("a number"));
                    found.insert(name, numbers.collect());
                }
            }
            Event::Eof => return found,
            _ => {}
        }
    }
}

/// Frequencies with the water agree with an independent water before the same dam, where those without it differ by a tenth;
/// those that are printed are those of the shapes. The series leaves out 1e-5
/// of the water's mass, a fifth of the whole; the water's elements may be off by 1e-3 of it.
#[test]
fn frequencies_and_shapes_in_the_water() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let (status, said, complaint) =
        check(&[CRACKED, "--modes", folder.path().join("a/b").to_str().ok_or("UTF-8")?]);
    assert_eq!(status, Some(0), "{complaint}");
    let printed = |start: &str| -> Vec<f64> {
        let line = said.lines().find_map(|line| line.strip_prefix(start)).expect("a line");
        let numbers = line.strip_suffix(" rad/s").expect("a unit").split(", ");
        numbers.map(|number| number.parse().expect("a number")).collect()
    };
    let empty = printed("  natural frequencies of the dam, intact and empty: ");
    let full = printed("  full, incompressible water: ");
    let independent = independent()?;
    println!("empty {empty:?}, full {full:?}, independent {:.3?}", &independent[..4]);
    assert!(full.iter().zip(&empty).all(|(full, empty)| full < empty));
    assert!(full[0] < 0.95 * empty[0]);
    let arrays = arrays(&folder.path().join("a/b/modes.vtu"));
    for (full, independent) in arrays["natural_frequency_full [rad/s]"].iter().zip(&independent) {
        println!("  off by {:+.1e}", full / independent - 1.0);
        assert!((full / independent - 1.0).abs() < 1e-4);
    }
    let points = &arrays["points"];
    for (water, printed) in [("empty", &empty), ("full", &full)] {
        let frequencies = &arrays[&format!("natural_frequency_{water} [rad/s]")];
        assert!(frequencies.iter().zip(printed).all(|(a, b)| (a - b).abs() < 0.006), "{frequencies:?}");
        for mode in 1..=4 {
            let shape = &arrays[&format!("mode_{mode}_{water}")];
            assert_eq!(shape.len(), points.len());
            let still = points.chunks(3).zip(shape.chunks(3)).filter(|(point, _)| point[1] == 0.0);
            assert!(still.into_iter().all(|(_, moved)| moved == [0.0; 3]), "the base does not move");
            assert!(shape.iter().any(|value| *value > 0.0));
        }
    }
    assert_ne!(arrays["mode_1_empty"], arrays["mode_1_full"]);
    let (_, said, _) = check(&[CRACKED, "--set", "reservoir.fidelity=none"]);
    assert!(said.contains("intact and empty") && !said.contains("full,"), "{said}");
    let (_, said, _) = check(&[CRACKED, "--set", "reservoir.fidelity=westergaard"]);
    assert!(said.contains("  full, with Westergaard's added mass: "), "{said}");
    Ok(())
}
