//! Gmsh's MSH format, versions 4.1 and 2.2 in ASCII.
//!
//! **Source**: Gmsh's reference manual, sections "MSH file format" and "MSH file format version 2 (Legacy)".

use super::error::MeshFileError;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::str::{FromStr, Lines};

/// Largest |z| of a node, as a share of the largest coordinate.
const FLAT: f64 = 1e-9;

/// Most physical curves that a curve may be part of; the sides and cracks of a dam share few.
const MOST_GROUPS: usize = 16;

/// What a file holds of a plane mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    /// Nodes, m.
    pub points: Vec<[f64; 2]>,
    /// Triangles of first order, as the file has them.
    pub triangles: Vec<[usize; 3]>,
    /// Quadrilaterals of first order.
    pub quadrilaterals: Vec<[usize; 4]>,
    /// The segments of each physical curve, by its name.
    pub curves: BTreeMap<String, Vec<[usize; 2]>>,
}

impl MeshFile {
    /// Reads the `text` of the file at `path`, which only errors name. What a header claims of counts asks for no memory.
    ///
    /// **Errors**: [`MeshFileError`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, MeshFileError> {
        let mut reader = Reader { path, lines: text.lines(), number: 0, line: "" };
        let mut draft = Draft::default();
        let mut version = None;
        while let Some(line) = reader.next() {
            let Some(section) = line.trim().strip_prefix('$') else { continue };
            let legacy = match (section, version) {
                ("MeshFormat", _) => {
                    version = Some(reader.version()?);
                    continue;
                }
                ("PhysicalNames", _) => {
                    draft.names(&mut reader)?;
                    continue;
                }
                ("Entities" | "Nodes" | "Elements", None) => {
                    return Err(reader.missing("$MeshFormat before its nodes"));
                }
                (_, Some(legacy)) => legacy,
                _ => continue,
            };
            match (section, legacy) {
                ("Entities", false) => draft.entities(&mut reader)?,
                ("Nodes", false) => draft.nodes(&mut reader)?,
                ("Elements", false) => draft.elements(&mut reader)?,
                ("Nodes", true) => draft.legacy_nodes(&mut reader)?,
                ("Elements", true) => draft.legacy_elements(&mut reader)?,
                _ => (),
            }
        }
        match version {
            None => Err(MeshFileError::Format {
                path: path.to_owned(),
                found: "it has no $MeshFormat".to_owned(),
            }),
            Some(_) => draft.finish(&reader),
        }
    }
}

struct Reader<'a> {
    path: &'a Path,
    lines: Lines<'a>,
    /// Number of the line that was read last, from 1, and the line.
    number: usize,
    line: &'a str,
}

impl<'a> Reader<'a> {
    fn next(&mut self) -> Option<&'a str> {
        self.line = self.lines.next()?;
        self.number += 1;
        Some(self.line)
    }

    /// The next line, which must be there.
    fn expect(&mut self, missing: &'static str) -> Result<&'a str, MeshFileError> {
        match self.next() {
            Some(line) => Ok(line),
            None => Err(self.missing(missing)),
        }
    }

    fn missing(&self, missing: &'static str) -> MeshFileError {
        MeshFileError::Missing { path: self.path.to_owned(), missing }
    }

    fn wrong(&self, expected: &'static str) -> MeshFileError {
        let text: String = self.line.chars().take(60).collect();
        MeshFileError::Line { path: self.path.to_owned(), line: self.number, text, expected }
    }

    /// All numbers of the current line.
    fn numbers<T: FromStr>(&self, expected: &'static str) -> Result<Vec<T>, MeshFileError> {
        let numbers = self.line.split_whitespace().map(|word| word.parse().ok());
        numbers.collect::<Option<Vec<T>>>().ok_or_else(|| self.wrong(expected))
    }

    /// The next line of at least `N` whole numbers: the first ones, and all.
    fn whole<const N: usize>(
        &mut self,
        expected: &'static str,
    ) -> Result<([u64; N], Vec<u64>), MeshFileError> {
        self.expect(expected)?;
        let all: Vec<u64> = self.numbers(expected)?;
        let first = all.first_chunk::<N>().copied().ok_or_else(|| self.wrong(expected))?;
        Ok((first, all))
    }

    /// Whether the file is of version 2.2.
    fn version(&mut self) -> Result<bool, MeshFileError> {
        let line = self.expect("its version")?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let format = |found: String| MeshFileError::Format { path: self.path.to_owned(), found };
        match words[..] {
            [version, "0", _] => match version {
                "4.1" => Ok(false),
                "2.2" | "2.1" | "2" => Ok(true),
                _ => Err(format(format!("its version is {}", version.chars().take(20).collect::<String>()))),
            },
            [_, "1", _] => Err(format("it is binary".to_owned())),
            _ => Err(self.wrong("a version, 0 for ASCII and a size")),
        }
    }

    fn node(&self, [x, y, z]: [f64; 3], tag: u64) -> Result<[f64; 3], MeshFileError> {
        // Written so that not-a-number is refused.
        if [x, y, z].iter().all(|x| x.abs() < f64::MAX) {
            return Ok([x, y, z]);
        }
        Err(MeshFileError::OutOfPlane { path: self.path.to_owned(), line: self.number, node: tag, z })
    }
}

/// What was read so far.
#[derive(Default)]
struct Draft {
    /// Names of physical curves by their tags.
    names: HashMap<u64, String>,
    /// Tags of the physical curves that a curve belongs to.
    physical: HashMap<u64, Vec<u64>>,
    /// Node and line of each tag.
    tags: HashMap<u64, usize>,
    /// Tag, line and coordinates.
    nodes: Vec<(u64, usize, [f64; 3])>,
    /// Segments with the tags of their physical curves, and polygons, by tags of nodes; each with its line.
    segments: Vec<(Vec<u64>, [u64; 2], usize)>,
    polygons: Vec<(Vec<u64>, usize)>,
}

impl Draft {
    fn names(&mut self, reader: &mut Reader<'_>) -> Result<(), MeshFileError> {
        const EXPECTED: &str = "a dimension, a tag and a \"name\"";
        let ([count], _) = reader.whole("a number of physical names")?;
        for _ in 0..count {
            let line = reader.expect("all its physical names")?;
            let (numbers, name) = line.split_once('"').ok_or_else(|| reader.wrong(EXPECTED))?;
            let name = name.trim_end().strip_suffix('"').ok_or_else(|| reader.wrong(EXPECTED))?;
            let numbers: Option<Vec<u64>> =
                numbers.split_whitespace().map(|word| word.parse().ok()).collect();
            match numbers.as_deref() {
                Some([1, tag]) => drop(self.names.insert(*tag, name.to_owned())),
                Some([_, _]) => (),
                _ => return Err(reader.wrong(EXPECTED)),
            }
        }
        Ok(())
    }

    fn entities(&mut self, reader: &mut Reader<'_>) -> Result<(), MeshFileError> {
        const EXPECTED: &str = "a curve: tag, six bounds, number of physical tags (16 at most), these";
        let ([points, curves], _) = reader.whole("numbers of points, curves, surfaces and volumes")?;
        for _ in 0..points {
            reader.expect("all its points")?;
        }
        for _ in 0..curves {
            reader.expect("all its curves")?;
            let numbers: Vec<f64> = reader.numbers(EXPECTED)?;
            let count = numbers.get(7).copied().unwrap_or(-1.0);
            let (Some(&tag), true) = (numbers.first(), count >= 0.0) else {
                return Err(reader.wrong(EXPECTED));
            };
            let physical = numbers.get(8..8 + (count as usize).min(numbers.len()));
            let physical =
                physical.filter(|tags| tags.len() <= MOST_GROUPS).ok_or_else(|| reader.wrong(EXPECTED))?;
            // a negative tag is one of a reversed curve
            self.physical.insert(tag as u64, physical.iter().map(|tag| tag.abs() as u64).collect());
        }
        Ok(())
    }

    fn add_node(&mut self, reader: &Reader<'_>, tag: u64, at: [f64; 3]) -> Result<(), MeshFileError> {
        let at = reader.node(at, tag)?;
        if self.tags.insert(tag, self.nodes.len()).is_some() {
            let (path, line) = (reader.path.to_owned(), reader.number);
            return Err(MeshFileError::TwoNodes { path, line, node: tag });
        }
        self.nodes.push((tag, reader.number, at));
        Ok(())
    }

    fn nodes(&mut self, reader: &mut Reader<'_>) -> Result<(), MeshFileError> {
        let ([blocks], _) = reader.whole("numbers of blocks and of nodes, and two tags")?;
        for _ in 0..blocks {
            let ([_, _, _, count], _) = reader.whole("dimension, tag, 0 or 1 and a number of nodes")?;
            let mut tags = Vec::new();
            for _ in 0..count {
                let ([tag], _) = reader.whole("a node's tag")?;
                tags.push(tag);
            }
            for tag in tags {
                reader.expect("the coordinates of all nodes")?;
                // behind them may be places on the curve
                let numbers: Vec<f64> = reader.numbers("three coordinates")?;
                let at =
                    numbers.first_chunk::<3>().copied().ok_or_else(|| reader.wrong("three coordinates"))?;
                self.add_node(reader, tag, at)?;
            }
        }
        Ok(())
    }

    fn legacy_nodes(&mut self, reader: &mut Reader<'_>) -> Result<(), MeshFileError> {
        const EXPECTED: &str = "a node's tag and three coordinates";
        let ([count], _) = reader.whole("a number of nodes")?;
        for _ in 0..count {
            reader.expect("all its nodes")?;
            let numbers: Vec<f64> = reader.numbers(EXPECTED)?;
            let [tag, x, y, z] = numbers.first_chunk::<4>().copied().ok_or_else(|| reader.wrong(EXPECTED))?;
            self.add_node(reader, tag as u64, [x, y, z])?;
        }
        Ok(())
    }

    fn elements(&mut self, reader: &mut Reader<'_>) -> Result<(), MeshFileError> {
        let ([blocks], _) = reader.whole("numbers of blocks and of elements, and two tags")?;
        for _ in 0..blocks {
            let ([_, entity, kind, count], _) =
                reader.whole("dimension, tag, type and a number of elements")?;
            let physical = self.physical.get(&entity).cloned().unwrap_or_default();
            for _ in 0..count {
                let ([element], all) = reader.whole("an element's tag and its nodes")?;
                self.add_element(reader, (element, kind), &physical, &all[1..])?;
            }
        }
        Ok(())
    }

    fn legacy_elements(&mut self, reader: &mut Reader<'_>) -> Result<(), MeshFileError> {
        const EXPECTED: &str = "an element's tag, type, number of tags, these and its nodes";
        let ([count], _) = reader.whole("a number of elements")?;
        for _ in 0..count {
            let ([element, kind, tags], all) = reader.whole(EXPECTED)?;
            let nodes = usize::try_from(tags).ok().and_then(|tags| all.get(tags.checked_add(3)?..));
            let nodes = nodes.ok_or_else(|| reader.wrong(EXPECTED))?;
            let physical: Vec<u64> = if tags > 0 { all[3..4].to_vec() } else { Vec::new() };
            self.add_element(reader, (element, kind), &physical, nodes)?;
        }
        Ok(())
    }

    fn add_element(
        &mut self,
        reader: &Reader<'_>,
        (element, kind): (u64, u64),
        physical: &[u64],
        nodes: &[u64],
    ) -> Result<(), MeshFileError> {
        let line = reader.number;
        let what = match (kind, nodes) {
            (15, _) => return Ok(()),
            (1, &[a, b]) => {
                self.segments.push((physical.to_vec(), [a, b], line));
                return Ok(());
            }
            (2, &[_, _, _]) | (3, &[_, _, _, _]) => {
                self.polygons.push((nodes.to_vec(), line));
                return Ok(());
            }
            (1..=3, _) => return Err(reader.wrong("an element with as many nodes as its type has")),
            (8 | 9 | 10 | 16 | 20..=28, _) => {
                "of second or higher order; the dam has elements of first order: set `Mesh.ElementOrder = 1`"
            }
            (4..=7 | 11..=14 | 17..=19, _) => {
                "of a volume; a section is plane: mesh surfaces alone, with `gmsh -2`"
            }
            _ => "which is not read; triangles (2), quadrilaterals (3) and lines (1) are",
        };
        Err(MeshFileError::Element { path: reader.path.to_owned(), line, element, kind, what })
    }

    fn finish(self, reader: &Reader<'_>) -> Result<MeshFile, MeshFileError> {
        let path = || reader.path.to_owned();
        if self.polygons.is_empty() {
            return Err(reader.missing(
                "triangles or quadrilaterals; mesh its surfaces, which must be physical ones if any curve is",
            ));
        }
        let far = self.nodes.iter().flat_map(|node| node.2).fold(0.0, |far: f64, x| far.max(x.abs()));
        if let Some(&(node, line, [_, _, z])) =
            self.nodes.iter().find(|(_, _, [_, _, z])| z.abs() > FLAT * far)
        {
            return Err(MeshFileError::OutOfPlane { path: path(), line, node, z });
        }
        let index = |node: &u64, line: usize| {
            self.tags.get(node).copied().ok_or_else(|| MeshFileError::NoNode {
                path: path(),
                line,
                node: *node,
            })
        };
        let points = self.nodes.iter().map(|(_, _, [x, y, _])| [*x, *y]).collect();
        let mut mesh = MeshFile { points, ..MeshFile::default() };
        for (nodes, line) in &self.polygons {
            let corners = nodes.iter().map(|node| index(node, *line)).collect::<Result<Vec<_>, _>>()?;
            match corners[..] {
                [a, b, c] => mesh.triangles.push([a, b, c]),
                [a, b, c, d] => mesh.quadrilaterals.push([a, b, c, d]),
                _ => (),
            }
        }
        for (physical, [a, b], line) in &self.segments {
            let segment = [index(a, *line)?, index(b, *line)?];
            // curves without a name are no business of the dam
            for name in physical.iter().filter_map(|tag| self.names.get(tag)) {
                mesh.curves.entry(name.clone()).or_default().push(segment);
            }
        }
        Ok(mesh)
    }
}
