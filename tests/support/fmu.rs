//! FMUs packed by the binary, and their contents.

use crate::scenario::binary;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use zip::ZipArchive;

/// An element of an XML document.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Element {
    /// Name.
    pub name: String,
    /// Attributes by name, unescaped.
    pub attributes: BTreeMap<String, String>,
    /// Child elements, in order.
    pub children: Vec<Element>,
}

impl Element {
    /// The root of a document.
    pub fn read(text: &str) -> Self {
        let mut reader = Reader::from_str(text);
        let mut open = vec![Self::default()];
        loop {
            let ended = match reader.read_event().expect("well-formed XML") {
                Event::Start(start) => {
                    open.push(Self::of(&start));
                    false
                }
                Event::Empty(start) => {
                    open.push(Self::of(&start));
                    true
                }
                Event::End(_) => true,
                Event::Eof => break,
                _ => false,
            };
            if ended {
                let element = open.pop().expect("an open element");
                open.last_mut().expect("an element around it").children.push(element);
            }
        }
        open.remove(0).children.remove(0)
    }

    fn of(start: &BytesStart<'_>) -> Self {
        let pair = |attribute: quick_xml::events::attributes::Attribute<'_>| {
            let value = quick_xml::escape::unescape(&attribute.value).expect("escaped").into_owned();
            (attribute.key.as_ref().to_owned(), value)
        };
        let attributes = start.attributes().map(|a| pair(a.expect("an attribute"))).collect();
        Self { name: start.name().as_ref().to_owned(), attributes, children: Vec::new() }
    }

    /// The elements `name` in the only child element `parent`.
    pub fn list(&self, parent: &str, name: &str) -> Vec<&Self> {
        self.child(parent).children.iter().filter(|child| child.name == name).collect()
    }

    /// The only child element `name`.
    pub fn child(&self, name: &str) -> &Self {
        let found: Vec<&Self> = self.children.iter().filter(|child| child.name == name).collect();
        assert_eq!(found.len(), 1, "{name} in {}", self.name);
        found[0]
    }

    /// The attribute `name`, which must exist.
    pub fn get(&self, name: &str) -> &str {
        self.attributes.get(name).unwrap_or_else(|| panic!("no attribute {name} in {self:?}"))
    }

    /// The numbers in the attribute `start`.
    pub fn start(&self) -> Vec<f64> {
        self.get("start").split(' ').map(|value| value.parse().expect("a number")).collect()
    }
}

/// A file that begins like a shared library of this platform and has the marker of `unit`.
pub fn fake_library(folder: &Path, unit: &str) -> PathBuf {
    let mut bytes = std::fs::read(std::env::current_exe().expect("a test has a path")).expect("a program");
    bytes.truncate(20);
    // A shared object: `e_type` of ELF is 3.
    bytes[16] = 3;
    bytes.extend(format!("\0cofferdam unit: {unit}\0").bytes());
    let path = folder.join("fake.so");
    std::fs::write(&path, bytes).expect("a library is written");
    path
}

/// Runs `cofferdam export-fmu` on a scene, with a [`fake_library`], in `folder`.
pub fn export(folder: &Path, scene: &Path, unit: &str, more: &[&str]) -> Output {
    let mut command = Command::new(binary());
    command.current_dir(folder).arg("export-fmu").arg(scene).args(["--unit", unit, "--library"]);
    command.arg(fake_library(folder, unit)).args(more).output().expect("cofferdam runs")
}

/// An FMU.
pub struct Fmu(ZipArchive<Cursor<Vec<u8>>>);

impl Fmu {
    /// Opens `path`.
    pub fn open(path: &Path) -> Self {
        let bytes = std::fs::read(path).expect("an FMU");
        Self(ZipArchive::new(Cursor::new(bytes)).expect("an archive"))
    }

    /// Names of its files, in order.
    pub fn names(&self) -> Vec<String> {
        self.0.file_names().map(|name| name.expect("a name").into_owned()).collect()
    }

    /// The content of one of its files.
    pub fn bytes(&mut self, name: &str) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.0.by_name(name).expect("a file").read_to_end(&mut bytes).expect("readable");
        bytes
    }

    /// The text of one of its files.
    pub fn text(&mut self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).expect("text")
    }

    /// modelDescription.xml.
    pub fn description(&mut self) -> Element {
        Element::read(&self.text("modelDescription.xml"))
    }
}
