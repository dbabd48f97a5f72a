//! Elements of XML.

use super::FmuError;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};
use std::io;

/// Text that grows by elements.
pub type Xml = Writer<Vec<u8>>;

/// A document: `content` after the XML declaration.
pub fn document(content: impl FnOnce(&mut Xml) -> io::Result<()>) -> Result<String, FmuError> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    let written = xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)));
    written.and_then(|()| content(&mut xml)).map_err(FmuError::Xml)?;
    Ok(text(xml).map_err(FmuError::Xml)? + "\n")
}

fn text(xml: Xml) -> io::Result<String> {
    String::from_utf8(xml.into_inner()).map_err(io::Error::other)
}

/// An element around others.
pub fn section(
    xml: &mut Xml,
    name: &str,
    content: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    xml.create_element(name).write_inner_content(content).map(drop)
}

/// An element without content.
pub fn empty(xml: &mut Xml, name: &str, attributes: &[(&str, &str)]) -> io::Result<()> {
    xml.create_element(name).with_attributes(attributes.iter().copied()).write_empty().map(drop)
}

/// An element around an element without content, on one line.
pub fn around(
    xml: &mut Xml,
    outer: (&str, &[(&str, &str)]),
    inner: (&str, &[(&str, &str)]),
) -> io::Result<()> {
    let mut line = Writer::new(Vec::new());
    empty(&mut line, inner.0, inner.1)?;
    let content = text(line)?;
    let element = xml.create_element(outer.0).with_attributes(outer.1.iter().copied());
    element.write_text_content(BytesText::from_escaped(content)).map(drop)
}
