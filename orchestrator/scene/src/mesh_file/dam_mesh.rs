//! The sides and cracks of a dam among the named curves of a mesh.

use super::error::MeshFileError;
use super::msh::MeshFile;
use cofferdam_dam::GivenMesh;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

/// Change of direction, rad, below which a point of a line is none of its vertices.
const STRAIGHT: f64 = 1e-6;

/// A mesh whose curves are chains of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DamMesh {
    /// Points, m.
    pub points: Vec<[f64; 2]>,
    /// Corners of triangles.
    pub triangles: Vec<[usize; 3]>,
    /// Corners of quadrilaterals.
    pub quadrilaterals: Vec<[usize; 4]>,
    /// From the heel to the crest.
    pub upstream: Vec<usize>,
    /// From the toe to the crest.
    pub downstream: Vec<usize>,
    /// From the heel to the toe.
    pub base: Vec<usize>,
    /// Chains along each crack, from upstream to downstream or, if it is vertical, from bottom to top.
    pub cracks: Vec<Vec<Vec<usize>>>,
}

impl From<DamMesh> for GivenMesh {
    fn from(mesh: DamMesh) -> Self {
        let DamMesh { points, triangles, quadrilaterals, upstream, downstream, base, cracks } = mesh;
        Self { points, triangles, quadrilaterals, upstream, downstream, base, cracks }
    }
}

impl DamMesh {
    /// The mesh of a dam with cracks of these names, in their order. `path` is what errors name.
    ///
    /// The physical curves `upstream`, `downstream` and `base` are its sides; `crest` may be one, too, and says nothing.
    ///
    /// **Errors**: [`MeshFileError`], of curves.
    pub fn new(path: &Path, file: MeshFile, cracks: &[Option<String>]) -> Result<Self, MeshFileError> {
        let MeshFile { points, triangles, quadrilaterals, curves } = file;
        let known = |name: &&String| {
            ["upstream", "downstream", "base", "crest"].contains(&name.as_str())
                || cracks.iter().any(|crack| crack.as_ref() == Some(*name))
        };
        if let Some(name) = curves.keys().find(|name| !known(name)) {
            let cracks = listed(cracks.iter().flatten());
            return Err(MeshFileError::UnknownCurve { path: path.to_owned(), name: name.clone(), cracks });
        }
        let named = Named { path, points: &points, curves: &curves };
        let [upstream, downstream] = ["upstream", "downstream"].map(|name| named.side(name, 1));
        let (upstream, downstream, base) = (upstream?, downstream?, named.side("base", 0)?);
        let mut chains = Vec::with_capacity(cracks.len());
        for (index, name) in cracks.iter().enumerate() {
            let nameless = || MeshFileError::NamelessCrack { path: path.to_owned(), index };
            chains.push(named.crack(name.as_ref().ok_or_else(nameless)?)?);
        }
        Ok(Self { points, triangles, quadrilaterals, upstream, downstream, base, cracks: chains })
    }

    /// Vertices of a chain of points, m.
    pub fn vertices(&self, chain: &[usize]) -> Vec<[f64; 2]> {
        let points: Vec<[f64; 2]> = chain.iter().map(|&i| self.points[i].map(rounded)).collect();
        let mut kept: Vec<[f64; 2]> = points.first().copied().into_iter().collect();
        for pair in points.windows(2).skip(1) {
            let last = kept[kept.len() - 1];
            let [[ax, ay], [bx, by]] = [
                [pair[0][0] - last[0], pair[0][1] - last[1]],
                [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]],
            ];
            let (sine, cosine) = (ax * by - ay * bx, ax * bx + ay * by);
            if sine.atan2(cosine).abs() > STRAIGHT {
                kept.push(pair[0]);
            }
        }
        kept.extend(points.last().filter(|_| points.len() > 1));
        kept
    }

    /// Vertices of all chains of a crack, m.
    pub fn polyline(&self, crack: usize) -> Vec<[f64; 2]> {
        self.cracks[crack].iter().flat_map(|chain| self.vertices(chain)).collect()
    }

    /// Outlines of the galleries: rings of sides of one cell only that do not pass the base.
    pub fn galleries(&self) -> Vec<Vec<[f64; 2]>> {
        let mut count: HashMap<[usize; 2], usize> = HashMap::new();
        let rings = self.triangles.iter().map(<[usize; 3]>::as_slice);
        for corners in rings.chain(self.quadrilaterals.iter().map(<[usize; 4]>::as_slice)) {
            for (k, &a) in corners.iter().enumerate() {
                let b = corners[(k + 1) % corners.len()];
                *count.entry([a.min(b), a.max(b)]).or_default() += 1;
            }
        }
        let outer = count.into_iter().filter(|(_, count)| *count == 1).map(|(side, _)| side);
        let mut neighbours = neighbours(outer);
        let mut found = Vec::new();
        while let Some((&start, _)) = neighbours.first_key_value() {
            let (mut ring, mut at) = (vec![start], start);
            while let Some(next) = neighbours
                .remove(&at)
                .and_then(|next| next.into_iter().find(|point| neighbours.contains_key(point)))
            {
                ring.push(next);
                at = next;
            }
            if ring.len() > 2 && !self.base.iter().any(|point| ring.contains(point)) {
                found.push(self.vertices(&ring));
            }
        }
        found
    }

    /// Side of a square of the mean area of cells, m; a triangle counts as three cells, and so a quadrilateral among triangles as four.
    pub fn element_size(&self) -> f64 {
        let area = |corners: &[usize]| -> f64 {
            let p = |k: usize| self.points[corners[k % corners.len()]];
            let twice: f64 = (0..corners.len()).map(|k| p(k)[0] * p(k + 1)[1] - p(k + 1)[0] * p(k)[1]).sum();
            0.5 * twice.abs()
        };
        let triangles: f64 = self.triangles.iter().map(|corners| area(corners)).sum();
        let quadrilaterals: f64 = self.quadrilaterals.iter().map(|corners| area(corners)).sum();
        let parts = if self.triangles.is_empty() { 1 } else { 4 };
        let cells = 3 * self.triangles.len() + parts * self.quadrilaterals.len();
        rounded(((triangles + quadrilaterals) / cells as f64).sqrt())
    }
}

/// Without what binary numbers add to decimal ones.
fn rounded(x: f64) -> f64 {
    (x * 1e9).round() / 1e9 + 0.0
}

fn listed<'a>(names: impl Iterator<Item = &'a String>) -> String {
    let names: Vec<String> = names.map(|name| format!("\"{name}\"")).collect();
    if names.is_empty() {
        "which has none with a name".to_owned()
    } else {
        format!("which are {}", names.join(", "))
    }
}

/// The points beside each point.
fn neighbours(segments: impl Iterator<Item = [usize; 2]>) -> BTreeMap<usize, BTreeSet<usize>> {
    let mut found: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for [a, b] in segments.filter(|[a, b]| a != b) {
        found.entry(a).or_default().insert(b);
        found.entry(b).or_default().insert(a);
    }
    found
}

struct Named<'a> {
    path: &'a Path,
    points: &'a [[f64; 2]],
    curves: &'a BTreeMap<String, Vec<[usize; 2]>>,
}

impl Named<'_> {
    fn wrong(&self, name: &str, how: &'static str, at: usize, remedy: &'static str) -> MeshFileError {
        let (path, name) = (self.path.to_owned(), name.to_owned());
        MeshFileError::Curve { path, name, how, point: self.points[at], remedy }
    }

    /// The chains of a curve, each from the end of the lower index.
    fn chains(&self, name: &str, what: &'static str) -> Result<Vec<Vec<usize>>, MeshFileError> {
        let Some(segments) = self.curves.get(name) else {
            let found = match self.curves.is_empty() {
                true => "no physical curve with a name at all".to_owned(),
                false => listed(self.curves.keys()).replacen("which are ", "", 1),
            };
            return Err(MeshFileError::NoCurve {
                path: self.path.to_owned(),
                name: name.to_owned(),
                what,
                found,
            });
        };
        let mut beside = neighbours(segments.iter().copied());
        if let Some((&fork, _)) = beside.iter().find(|(_, points)| points.len() > 2) {
            return Err(self.wrong(name, "forks", fork, "give its branches names of their own"));
        }
        let ends: Vec<usize> =
            beside.iter().filter(|(_, points)| points.len() == 1).map(|(at, _)| *at).collect();
        let mut chains = Vec::new();
        for end in ends {
            let (mut chain, mut at) = (vec![end], end);
            while let Some(next) =
                beside.remove(&at).and_then(|points| points.into_iter().find(|p| beside.contains_key(p)))
            {
                chain.push(next);
                at = next;
            }
            if chain.len() > 1 {
                chains.push(chain);
            }
        }
        match beside.keys().next() {
            Some(&at) => Err(self.wrong(
                name,
                "closes",
                at,
                "leave a part of it out, or give parts names of their own",
            )),
            None => Ok(chains),
        }
    }

    /// A side of the section, in the ascending direction of an `axis`.
    fn side(&self, name: &str, axis: usize) -> Result<Vec<usize>, MeshFileError> {
        let mut chains = self.chains(name, "that side of the section")?;
        if let [_, second, ..] = &chains[..] {
            return Err(self.wrong(name, "has a gap", second[0], "name all curves of that side so"));
        }
        let mut chain = chains.pop().unwrap_or_default();
        if let [first, .., last] = chain[..]
            && self.points[first][axis] > self.points[last][axis]
        {
            chain.reverse();
        }
        Ok(chain)
    }

    /// The chains of a crack.
    fn crack(&self, name: &str) -> Result<Vec<Vec<usize>>, MeshFileError> {
        let mut chains = self.chains(name, "that crack")?;
        for chain in &mut chains {
            let [[x0, y0], [x1, y1]] = [chain[0], chain[chain.len() - 1]].map(|i| self.points[i]);
            let slight = 1e-9 * (x1 - x0).hypot(y1 - y0);
            if x1 - x0 < -slight || (x1 - x0 <= slight && y0 > y1) {
                chain.reverse();
            }
        }
        let start = |chain: &Vec<usize>| self.points[chain[0]];
        chains.sort_by(|a, b| start(a)[0].total_cmp(&start(b)[0]).then(start(a)[1].total_cmp(&start(b)[1])));
        Ok(chains)
    }
}
