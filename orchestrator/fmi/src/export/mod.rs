//! FMUs of the units by FMI 2.0 or 3.0: everything but the library is generated from the unit's variables and parameters.
//!
//! An FMU holds one unit of one scene: the sizes of all arrays are fixed. This module knows units only through
//! [`cofferdam_unit::Packable`] and the variables of the contract; it knows no solver. The same functions write the contract
//! itself ([`contract`]), in which structural parameters stand for the sizes.
//!
//! ```text
//! modelDescription.xml                      model_description, fmi2: attributes, variables, dependencies; definitions: units, types
//! terminalsAndIcons/terminalsAndIcons.xml   terminals: the wet face as one terminal (FMI 3.0)
//! binaries/<platform>/<unit>.so             library: built together with the program, of both versions
//! resources/unit.toml                       cofferdam_unit::export::Contents, which the library reads
//! resources/prepared.bin                    what is prepared from these, if the unit prepares anything
//! resources/scene.toml, resources/mesh/     for the reader; the library does not use them
//! documentation/index.html, licenses/       documentation
//! ```

mod definitions;
mod documentation;
mod error;
mod fmi2;
mod library;
mod model_description;
mod scalars;
pub mod ssp;
mod terminals;
mod variables;
mod xml;

pub use error::FmuError;
pub use library::{Library, Version};
pub use model_description::{Description, Times};
pub use scalars::crack_names;

use scalars::Scalar;
pub use variables::{Bounds, SizedVariable};

use cofferdam_unit::export::{Contents, FILE, PREPARED};
use cofferdam_unit::{Packable, Shape};
use std::io::{Cursor, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// The unit's part of its documentation, as HTML. `{step}`, `{end}`, `{points}`, `{step_length}`, `{get_state}` and
/// `{set_state}` are replaced.
pub struct Page {
    /// What the unit computes.
    pub about: &'static str,
    /// Signs, units and the order of calls.
    pub usage: &'static str,
    /// How to simulate it with FMPy.
    pub example: &'static str,
    /// What FMPy's users must know.
    pub notes: &'static str,
}

/// Everything from which an FMU of a unit is made.
pub struct Package<U: Packable> {
    /// The contents from which the library makes the unit.
    pub contents: Contents<U::Parameters>,
    /// What [`Packable::prepare`] gave for their parameters.
    pub prepared: Option<Vec<u8>>,
    /// Title of the scene.
    pub title: String,
    /// The scene with all defaults, as TOML.
    pub scene: String,
    /// The unit's part of documentation/index.html.
    pub page: Page,
    /// Length H of the scene's communication steps, s.
    pub communication_step: f64,
    /// Number of communication steps of the scene.
    pub steps: u64,
    /// Files of the mesh: name and text.
    pub mesh: Vec<(&'static str, String)>,
    /// The unit's library.
    pub library: Library,
    /// Bounds of parameters.
    pub bounds: Bounds,
    /// Version of FMI.
    pub version: Version,
    /// Whether the variables are scalars in FMI 3.0 too: nobody exchanges fields with this unit.
    pub as_scalars: bool,
    /// [`crack_names`] of the scene.
    pub cracks: Vec<String>,
}

impl<U: Packable> Package<U> {
    /// Writes the FMU to `path`, replacing a file of that name, and returns its size in bytes. The same package gives the
    /// same bytes.
    ///
    /// **Errors**: contents or a file that cannot be written. No incomplete file is left behind.
    pub fn write(&self, path: &Path) -> Result<u64, FmuError> {
        write_file(path, &self.bytes()?)
    }

    /// The FMU. The same package gives the same bytes.
    ///
    /// **Errors**: contents that cannot be written.
    pub fn bytes(&self) -> Result<Vec<u8>, FmuError> {
        archive(&self.entries()?).map_err(FmuError::Archive)
    }

    /// Simulated time of the scene, s, rounded to 1e-9 s to remove the rounding of binary numbers.
    pub fn end(&self) -> f64 {
        (self.steps as f64 * self.communication_step * 1e9).round() / 1e9
    }

    /// Number of points of the wet face.
    pub fn interface_points(&self) -> usize {
        let found = U::VARIABLES.iter().find(|v| v.shape == Shape::InterfacePoints);
        found.map_or(0, |variable| U::size_for(&self.contents.parameters, variable))
    }

    /// The XML files.
    fn xml(
        &self,
        variables: &[SizedVariable],
        scalars: Option<&[Scalar<'_>]>,
    ) -> Result<Vec<(&'static str, String)>, FmuError> {
        let (token, text) = (self.contents.token::<U>()?, format!("{}: {}", U::DESCRIPTION, self.title));
        let description = Description {
            name: U::NAME,
            release: Some((env!("CARGO_PKG_VERSION"), env!("CARGO_PKG_LICENSE"))),
            token: &token,
            text: &text,
            capabilities: U::capabilities_for(&self.contents.parameters),
            variables,
            scene: Some(Times { communication_step: self.communication_step, end: self.end() }),
        };
        let name = "modelDescription.xml";
        match (self.version, scalars) {
            (Version::Fmi2, Some(scalars)) => Ok(vec![(name, fmi2::write(&description, scalars)?)]),
            (_, Some(_)) => Ok(vec![(name, model_description::write(&description, scalars)?)]),
            (_, None) => described(&description),
        }
    }

    /// Name and content of the files in the FMU.
    fn entries(&self) -> Result<Vec<(String, Vec<u8>)>, FmuError> {
        let variables = variables::of::<U>(&self.contents, self.bounds)?;
        let scalars = scalars::of(&variables, &self.cracks);
        let scalars = (self.version == Version::Fmi2 || self.as_scalars).then_some(&scalars[..]);
        let text = |name: &str, text: String| (name.to_owned(), text.into_bytes());
        let mut entries: Vec<_> =
            self.xml(&variables, scalars)?.into_iter().map(|(name, xml)| text(name, xml)).collect();
        entries.push((self.library.entry(U::NAME, self.version), self.library.bytes().to_vec()));
        entries.push(text(&format!("resources/{FILE}"), self.contents.to_toml()?));
        entries.extend(self.prepared.clone().map(|bytes| (format!("resources/{PREPARED}"), bytes)));
        entries.push(text("resources/scene.toml", self.scene.clone()));
        for (name, content) in &self.mesh {
            entries.push(text(&format!("resources/mesh/{name}"), content.clone()));
        }
        entries.push(text("documentation/index.html", documentation::page(self, &variables, scalars)));
        entries.push(text("documentation/licenses/license.txt", documentation::licences()));
        Ok(entries)
    }
}

/// The XML files of an FMU: path in it, and text.
///
/// **Errors**: [`FmuError::Xml`].
pub fn described(unit: &Description<'_>) -> Result<Vec<(&'static str, String)>, FmuError> {
    let mut files = vec![("modelDescription.xml", model_description::write(unit, None)?)];
    let terminals = terminals::write(unit.variables)?;
    files.extend(terminals.map(|terminals| ("terminalsAndIcons/terminalsAndIcons.xml", terminals)));
    Ok(files)
}

/// The contract of a unit as modelDescription.xml: all variables of [`Packable::VARIABLES`], with structural parameters for
/// the sizes that depend on the scene, and the capabilities of a unit with these `parameters`.
///
/// **Errors**: [`FmuError::Xml`].
pub fn contract<U: Packable>(parameters: &U::Parameters, bounds: Bounds) -> Result<String, FmuError> {
    let (token, variables) = (format!("cofferdam-{}-1", U::NAME), variables::of_contract::<U>(bounds));
    let description = Description {
        name: U::NAME,
        release: None,
        token: &token,
        text: U::DESCRIPTION,
        capabilities: U::capabilities_for(parameters),
        variables: &variables,
        scene: None,
    };
    model_description::write(&description, None)
}

/// Checks a target before any work is done for it.
///
/// **Errors**: a file that exists, unless `overwrite`; something that is not a regular file (a link is not one); a folder
/// that does not exist.
pub fn check_target(path: &Path, overwrite: bool) -> Result<(), FmuError> {
    let path_owned = || path.to_owned();
    let ends_as_folder = path.as_os_str().to_string_lossy().ends_with(std::path::is_separator);
    if path.is_dir() || path.file_name().is_none() || ends_as_folder {
        return Err(FmuError::TargetIsFolder { path: path_owned() });
    }
    match path.symlink_metadata() {
        Ok(there) if !there.is_file() => return Err(FmuError::NotAFile { path: path_owned() }),
        Ok(_) if !overwrite => return Err(FmuError::Exists { path: path_owned() }),
        _ => {}
    }
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(FmuError::NoFolder { folder: folder.to_owned() })
        }
        _ => Ok(()),
    }
}

/// Writes a file, replacing one of that name, and returns its size in bytes. No incomplete file is left behind.
fn write_file(path: &Path, bytes: &[u8]) -> Result<u64, FmuError> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.part", std::process::id()));
    let draft = path.with_file_name(name);
    let written = std::fs::write(&draft, bytes).and_then(|()| std::fs::rename(&draft, path));
    if let Err(cause) = written {
        // The error of writing is reported, not that of removing the draft.
        let _ = std::fs::remove_file(&draft);
        return Err(FmuError::Write { path: path.to_owned(), cause });
    }
    Ok(bytes.len() as u64)
}

fn archive(entries: &[(String, Vec<u8>)]) -> std::io::Result<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    // With the time of the clock no two archives would be equal.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::DEFAULT);
    for (name, content) in entries {
        let mode = if name.starts_with("binaries/") { 0o755 } else { 0o644 };
        archive.start_file(name, options.unix_permissions(mode))?;
        archive.write_all(content)?;
    }
    Ok(archive.finish()?.into_inner())
}
