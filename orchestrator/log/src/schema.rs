//! Protobuf message types made at run time from the variables of a unit, so that viewers show the variables of any
//! unit by name.

use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};

/// Kind of a field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `uint64`
    Unsigned,
    /// `bool`
    Bool,
    /// `double`
    Double,
    /// `repeated double`, packed
    Doubles,
    /// `string`
    Text,
    /// `repeated bytes`
    ByteStrings,
    /// Repeated messages of a type that is declared inside the message's own.
    Messages(MessageType),
}

/// Value of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// `uint64`
    Unsigned(u64),
    /// `bool`
    Bool(bool),
    /// `double`
    Double(f64),
    /// `repeated double`
    Doubles(&'a [f64]),
    /// `string`
    Text(&'a str),
    /// Repeated messages, encoded; or byte strings.
    Messages(&'a [Vec<u8>]),
}

/// A protobuf message type; its fields are numbered from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MessageType {
    name: String,
    fields: Vec<(String, Kind)>,
}

const PACKAGE: &str = "cofferdam";

impl MessageType {
    /// The type `name` with `fields`.
    pub fn new(name: &str, fields: Vec<(String, Kind)>) -> Self {
        Self { name: name.to_owned(), fields }
    }

    /// A name that two fields have.
    pub fn repeated_field(&self) -> Option<String> {
        let names = self.fields.iter().enumerate();
        let mut repeated =
            names.filter(|(index, (name, _))| self.fields[..*index].iter().any(|(n, _)| n == name));
        repeated.next().map(|(_, (name, _))| name.clone())
    }

    /// Name with package, as in the schema of a log.
    pub fn full_name(&self) -> String {
        format!("{PACKAGE}.{}", self.name)
    }

    /// The encoded `FileDescriptorSet` that describes the type.
    pub fn descriptor_set(&self) -> Vec<u8> {
        let file = FileDescriptorProto {
            name: Some(format!("{PACKAGE}/{}.proto", self.name)),
            package: Some(PACKAGE.to_owned()),
            syntax: Some("proto3".to_owned()),
            message_type: vec![self.descriptor(&format!(".{PACKAGE}"))],
            ..Default::default()
        };
        prost::Message::encode_to_vec(&FileDescriptorSet { file: vec![file] })
    }

    /// The descriptor of the type inside `scope`, including those of nested messages.
    fn descriptor(&self, scope: &str) -> DescriptorProto {
        let scope = format!("{scope}.{}", self.name);
        let field = |(index, (name, kind)): (usize, &(String, Kind))| FieldDescriptorProto {
            name: Some(name.clone()),
            number: Some(index as i32 + 1),
            label: Some(match kind {
                Kind::Doubles | Kind::ByteStrings | Kind::Messages(_) => Label::Repeated,
                _ => Label::Optional,
            } as i32),
            r#type: Some(match kind {
                Kind::Unsigned => Type::Uint64,
                Kind::Bool => Type::Bool,
                Kind::Double | Kind::Doubles => Type::Double,
                Kind::Text => Type::String,
                Kind::ByteStrings => Type::Bytes,
                Kind::Messages(_) => Type::Message,
            } as i32),
            type_name: match kind {
                Kind::Messages(inner) => Some(format!("{scope}.{}", inner.name)),
                _ => None,
            },
            ..Default::default()
        };
        let mut nested: Vec<DescriptorProto> = Vec::new();
        for (_, kind) in &self.fields {
            if let Kind::Messages(inner) = kind
                && !nested.iter().any(|n| n.name() == inner.name)
            {
                nested.push(inner.descriptor(&scope));
            }
        }
        DescriptorProto {
            name: Some(self.name.clone()),
            field: self.fields.iter().enumerate().map(field).collect(),
            nested_type: nested,
            ..Default::default()
        }
    }

    /// A message with `values`, one for each field in order.
    pub fn encode<'a>(&self, values: impl IntoIterator<Item = Value<'a>>) -> Vec<u8> {
        // an exchange at 40 points
        let mut bytes = Vec::with_capacity(2048);
        let mut fields = self.fields.iter();
        for (index, value) in values.into_iter().enumerate() {
            let tag = index as u32 + 1;
            debug_assert!(fields.next().is_some_and(|f| value.fits(&f.1)), "field {tag} of {}", self.name);
            match value {
                Value::Unsigned(v) => prost::encoding::uint64::encode(tag, &v, &mut bytes),
                Value::Bool(v) => prost::encoding::bool::encode(tag, &v, &mut bytes),
                Value::Double(v) => prost::encoding::double::encode(tag, &v, &mut bytes),
                Value::Doubles(v) => prost::encoding::double::encode_packed(tag, v, &mut bytes),
                Value::Text(v) => prost::encoding::string::encode(tag, &v.to_owned(), &mut bytes),
                Value::Messages(v) => {
                    v.iter().for_each(|message| prost::encoding::bytes::encode(tag, message, &mut bytes));
                }
            }
        }
        debug_assert!(fields.next().is_none(), "values missing in {}", self.name);
        bytes
    }
}

impl Value<'_> {
    fn fits(&self, kind: &Kind) -> bool {
        matches!(
            (self, kind),
            (Self::Unsigned(_), Kind::Unsigned)
                | (Self::Bool(_), Kind::Bool)
                | (Self::Double(_), Kind::Double)
                | (Self::Doubles(_), Kind::Doubles)
                | (Self::Text(_), Kind::Text)
                | (Self::Messages(_), Kind::Messages(_) | Kind::ByteStrings)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_descriptor_names_the_fields_and_the_bytes_follow_it() -> Result<(), prost::DecodeError> {
        let fields = [("step", Kind::Unsigned), ("pressure", Kind::Doubles), ("unit", Kind::Text)];
        let kind = MessageType::new("Answer", fields.map(|(n, k)| (n.to_owned(), k)).to_vec());
        let set: FileDescriptorSet = prost::Message::decode(&*kind.descriptor_set())?;
        let message = &set.file[0].message_type[0];
        assert_eq!(message.field.iter().map(|f| f.name()).collect::<Vec<_>>(), ["step", "pressure", "unit"]);
        assert_eq!(kind.full_name(), "cofferdam.Answer");
        let bytes = kind.encode([Value::Unsigned(300), Value::Doubles(&[0.5]), Value::Text("dam")]);
        // From the protobuf encoding rules: varint 300; packed field 2 of 8 bytes; string field 3.
        let mut expected = vec![0x08, 0xac, 0x02, 0x12, 8];
        expected.extend_from_slice(&0.5f64.to_le_bytes());
        expected.extend_from_slice(&[0x1a, 3, b'd', b'a', b'm']);
        assert_eq!(bytes, expected);
        Ok(())
    }
}
