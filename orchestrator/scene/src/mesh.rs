//! `[dam.mesh]`: a mesh from a file, and what follows from it in other tables.

use super::Invalid;
use super::document::{Content, Entries, Node, Place};
use crate::mesh_file::{DamMesh, MeshFile, MeshFileError};
use cofferdam_motion::text_file;
use cofferdam_unit::sha256;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use toml::Value;

/// A mesh from a file, in place of the program's own. Section, `element_size` and the lines of the cracks follow from it and are not
/// given: the sides of the section are its physical curves `upstream`, `downstream` and `base`, a crack is the one with the crack's `name`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshScene {
    /// File of the mesh, relative to the scene's folder: Gmsh's MSH 4.1 or 2.2 in ASCII, in m, the heel at the origin, triangles and
    /// quadrilaterals of first order.
    pub file: PathBuf,
    /// SHA-256 of the file, in hexadecimal digits. It is recorded in the manifest of a run; a file with a different hash is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "the file's"))]
    pub sha256: Option<String>,
    /// Contents of the file, written to the manifest and the log of a run, so that they do not depend on the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("otherwise" = "the file's"))]
    pub text: Option<String>,
}

impl MeshScene {
    /// The mesh of a dam with cracks of these names.
    ///
    /// **Errors**: [`MeshFileError`].
    pub fn mesh(&self, cracks: &[Option<String>]) -> Result<DamMesh, MeshFileError> {
        let text = self.text.as_deref().unwrap_or_default();
        DamMesh::new(&self.file, MeshFile::parse(&self.file, text)?, cracks)
    }
}

/// Reads the mesh that a scene names, from `folder`, and puts what follows from it where it belongs; what was given there is
/// refused, unless it is the same. Returns what is wrong.
pub fn complete(tree: &mut Node, folder: &Path) -> Vec<(Place, Invalid)> {
    let Some(mesh) = at(tree, &["dam", "mesh"]) else { return Vec::new() };
    let text_at = |key: &str| match at(mesh, &[key]).map(|node| &node.content) {
        Some(Content::Scalar(Value::String(text))) => Some(text.clone()),
        _ => None,
    };
    // the shape of the table is judged elsewhere
    let (Some(file), place) = (text_at("file"), mesh.place.clone()) else {
        stand_in(tree, &mesh.place.clone());
        return Vec::new();
    };
    let place = at(mesh, &["file"]).map_or(place, |node| node.place.clone());
    // a file that is named on the command line takes the place of what a manifest holds of another
    let kept = |key: &str| at(mesh, &[key]).is_none_or(|node| node.place.text >= place.text);
    let [text, wanted] = ["text", "sha256"].map(|key| text_at(key).filter(|_| kept(key)));
    let found = read(folder, &file, text, wanted);
    let found = found.and_then(|scene| Ok((scene.mesh(&names(tree))?, scene)));
    match found {
        Ok((mesh, scene)) => fill(tree, &mesh, &scene, &place),
        Err(error) => {
            stand_in(tree, &place);
            vec![(place, Invalid::Mesh(error))]
        }
    }
}

fn read(
    folder: &Path,
    file: &str,
    text: Option<String>,
    wanted: Option<String>,
) -> Result<MeshScene, MeshFileError> {
    let path = folder.join(file);
    let text = match text {
        Some(text) => text,
        None => text_file::read(&path).map_err(|cause| MeshFileError::Read { path: path.clone(), cause })?,
    };
    let found = sha256(&text);
    match wanted {
        Some(wanted) if !wanted.eq_ignore_ascii_case(&found) => Err(MeshFileError::Another { path, found }),
        _ => Ok(MeshScene { file: file.into(), sha256: Some(found), text: Some(text) }),
    }
}

/// The names of the cracks.
fn names(tree: &Node) -> Vec<Option<String>> {
    let Some(Content::Array(cracks)) = at(tree, &["dam", "cracks"]).map(|node| &node.content) else {
        return Vec::new();
    };
    let name = |crack: &Node| match at(crack, &["name"]).map(|node| &node.content) {
        Some(Content::Scalar(Value::String(name))) => Some(name.clone()),
        _ => None,
    };
    cracks.iter().map(name).collect()
}

/// Marks what would follow from the mesh as unreadable, so that nothing is said about it.
fn stand_in(tree: &mut Node, place: &Place) {
    let unreadable = || Node { content: Content::Unreadable, place: place.clone() };
    let Some(dam) = entries(tree, "dam") else { return };
    for key in ["section", "element_size"] {
        dam.entry(key.to_owned()).or_insert_with(|| (place.clone(), unreadable()));
    }
    if let Some((_, Node { content: Content::Array(cracks), .. })) = dam.get_mut("cracks") {
        for crack in cracks {
            if let Content::Table(crack) = &mut crack.content {
                crack.entry("polyline".to_owned()).or_insert_with(|| (place.clone(), unreadable()));
            }
        }
    }
}

fn fill(tree: &mut Node, mesh: &DamMesh, scene: &MeshScene, place: &Place) -> Vec<(Place, Invalid)> {
    let mut wrong = Vec::new();
    let points = |points: Vec<[f64; 2]>| {
        Value::Array(points.into_iter().map(|p| Value::Array(p.map(Value::Float).to_vec())).collect())
    };
    let mut section = toml::Table::new();
    section.insert("upstream".to_owned(), points(mesh.vertices(&mesh.upstream)));
    section.insert("downstream".to_owned(), points(mesh.vertices(&mesh.downstream)));
    let galleries = mesh.galleries();
    if !galleries.is_empty() {
        section.insert("galleries".to_owned(), Value::Array(galleries.into_iter().map(points).collect()));
    }
    let Some(dam) = entries(tree, "dam") else { return wrong };
    let size = Value::Float(mesh.element_size());
    put(dam, "element_size", "dam.element_size", size, place, &mut wrong);
    put(dam, "section", "dam.section", Value::Table(section), place, &mut wrong);
    if let Some((_, Node { content: Content::Array(cracks), .. })) = dam.get_mut("cracks") {
        for (index, crack) in cracks.iter_mut().enumerate() {
            let Content::Table(crack) = &mut crack.content else { continue };
            for key in ["elevation", "element_size"] {
                if let Some((_, node)) = crack.remove(key) {
                    let key = format!("dam.cracks.{index}.{key}");
                    wrong.push((node.place, Invalid::ReplacedByMesh { key }));
                }
            }
            let key = format!("dam.cracks.{index}.polyline");
            put(crack, "polyline", &key, points(mesh.polyline(index)), place, &mut wrong);
        }
    }
    if let Some((_, Node { content: Content::Table(own), .. })) = dam.get_mut("mesh") {
        for (key, text) in [("sha256", &scene.sha256), ("text", &scene.text)] {
            let Some(text) = text else { continue };
            own.insert(key.to_owned(), (place.clone(), node(&text.as_str().into(), place)));
        }
    }
    wrong
}

/// Puts `value` at `name`; another one that was given there is wrong.
fn put(
    entries: &mut Entries,
    name: &str,
    key: &str,
    value: Value,
    place: &Place,
    wrong: &mut Vec<(Place, Invalid)>,
) {
    if let Some((_, given)) = entries.get(name)
        && !same(given, &value)
    {
        wrong.push((given.place.clone(), Invalid::ReplacedByMesh { key: key.to_owned() }));
    }
    entries.insert(name.to_owned(), (place.clone(), node(&value, place)));
}

fn at<'a>(node: &'a Node, path: &[&str]) -> Option<&'a Node> {
    let mut node = node;
    for name in path {
        let Content::Table(entries) = &node.content else { return None };
        node = &entries.get(*name)?.1;
    }
    Some(node)
}

fn entries<'a>(node: &'a mut Node, name: &str) -> Option<&'a mut Entries> {
    let Content::Table(entries) = &mut node.content else { return None };
    match &mut entries.get_mut(name)?.1.content {
        Content::Table(entries) => Some(entries),
        _ => None,
    }
}

fn node(value: &Value, place: &Place) -> Node {
    let content = match value {
        Value::Table(table) => {
            let entry =
                |(name, value): (&String, &Value)| (name.clone(), (place.clone(), node(value, place)));
            Content::Table(table.iter().map(entry).collect())
        }
        Value::Array(values) => Content::Array(values.iter().map(|value| node(value, place)).collect()),
        other => Content::Scalar(other.clone()),
    };
    Node { content, place: place.clone() }
}

/// Whether a node says the same as a value.
fn same(node: &Node, value: &Value) -> bool {
    match (&node.content, value) {
        (Content::Table(entries), Value::Table(table)) => {
            entries.len() == table.len()
                && table
                    .iter()
                    .all(|(name, value)| entries.get(name).is_some_and(|(_, node)| same(node, value)))
        }
        (Content::Array(nodes), Value::Array(values)) => {
            nodes.len() == values.len() && nodes.iter().zip(values).all(|(node, value)| same(node, value))
        }
        (Content::Scalar(Value::Integer(given)), Value::Float(value)) => *given as f64 == *value,
        (Content::Scalar(given), value) => given == value,
        // said already
        (Content::Unreadable, _) => true,
        _ => false,
    }
}
