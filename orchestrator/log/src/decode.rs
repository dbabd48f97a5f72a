//! Reads messages by the schema in the file: fields are found by name, not by number.

use prost::DecodeError;
use prost::encoding::{self, DecodeContext};
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FileDescriptorSet};

/// Type in which a field is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// A whole number, or an enumeration; a negative one counts as 0.
    Unsigned,
    /// A Boolean.
    Bool,
    /// One number.
    Double,
    /// Numbers.
    Doubles,
    /// A text.
    Text,
    /// Messages, still encoded, or byte strings; one or several.
    Messages,
}

/// Why messages of a type cannot be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Mismatch {
    /// The schema is no set of protobuf descriptors.
    #[error("its schema is no protobuf file descriptor set")]
    Schema,
    /// The type is not among those that the schema describes.
    #[error("its schema does not describe the message `{0}`")]
    Type(String),
    /// A field that is needed is not there.
    #[error("its message `{message}` has no field `{field}`")]
    Missing {
        /// Name of the message type.
        message: String,
        /// Name of the field.
        field: String,
    },
    /// A field is of another type.
    #[error("the field `{field}` of its message `{message}` is {found:?}, not {wanted:?}")]
    Kind {
        /// Name of the message type.
        message: String,
        /// Name of the field.
        field: String,
        /// Its type in the schema.
        found: Type,
        /// The type in which it is read.
        wanted: Wanted,
    },
    /// A message whose bytes do not follow the schema.
    #[error("a message is damaged: {0}")]
    Bytes(#[from] DecodeError),
    /// The number of values differs from the unit's layout.
    #[error("`{variable}` has {found} values, the unit's layout says {expected}")]
    Length {
        /// Name of the variable.
        variable: String,
        /// Number of values in the layout.
        expected: usize,
        /// Number of values in the message.
        found: usize,
    },
    /// A list that no writer makes so long.
    #[error("a list of messages in it has more than {MOST_MESSAGES}")]
    TooMany,
    /// An invalid value.
    #[error("`{field}` is `{value}`, which is not valid here")]
    Value {
        /// Name of the field.
        field: &'static str,
        /// Its value.
        value: String,
    },
}

/// Longest list of messages in a message: each takes many times its bytes.
const MOST_MESSAGES: usize = 4096;

/// A message type of a file.
pub struct Schema(DescriptorProto);

/// Reads the wanted fields of messages of one type; others are skipped.
pub struct Decoder {
    fields: Vec<Field>,
    values: Vec<Value>,
}

struct Field {
    number: u32,
    slot: usize,
    read: Type,
}

#[derive(Clone, Debug)]
enum Value {
    Unsigned(u64),
    Bool(bool),
    Doubles(Vec<f64>),
    Text(String),
    Messages(Vec<Vec<u8>>),
}

impl Schema {
    /// The type `name` (with its package) of an encoded `FileDescriptorSet`.
    pub fn find(name: &str, set: &[u8]) -> Result<Self, Mismatch> {
        let set: FileDescriptorSet = prost::Message::decode(set).map_err(|_| Mismatch::Schema)?;
        let full = |package: &str, message: &DescriptorProto| match package {
            "" => message.name().to_owned(),
            _ => format!("{package}.{}", message.name()),
        };
        let types = set.file.into_iter().flat_map(|f| {
            let package = f.package().to_owned();
            f.message_type.into_iter().map(move |message| (full(&package, &message), message))
        });
        let found = types.into_iter().find(|(full, _)| full == name);
        found.map(|(_, message)| Self(message)).ok_or_else(|| Mismatch::Type(name.to_owned()))
    }

    /// The message type `name` that is declared inside this one.
    pub fn nested(&self, name: &str) -> Result<Self, Mismatch> {
        let found = self.0.nested_type.iter().find(|message| message.name() == name);
        found.map(|message| Self(message.clone())).ok_or_else(|| Mismatch::Type(name.to_owned()))
    }

    /// Whether messages have the field `name`.
    pub fn has(&self, name: &str) -> bool {
        self.0.field.iter().any(|field| field.name() == name)
    }

    /// A decoder of the fields `wanted`; their values are then read by their places in this list.
    ///
    /// **Errors**: a field is missing or cannot be read in this type.
    pub fn decoder<'a>(
        &self,
        wanted: impl IntoIterator<Item = (&'a str, Wanted)>,
    ) -> Result<Decoder, Mismatch> {
        let mut decoder = Decoder { fields: Vec::new(), values: Vec::new() };
        for (name, wanted) in wanted {
            self.add(name, wanted, &mut decoder)?;
        }
        Ok(decoder)
    }

    /// The same, with further fields that messages of earlier versions do not have; they have protobuf's default values there.
    pub fn decoder_with<'a>(
        &self,
        wanted: impl IntoIterator<Item = (&'a str, Wanted)>,
        perhaps: impl IntoIterator<Item = (&'a str, Wanted)>,
    ) -> Result<Decoder, Mismatch> {
        let mut decoder = self.decoder(wanted)?;
        for (name, wanted) in perhaps {
            if self.has(name) {
                self.add(name, wanted, &mut decoder)?;
            } else {
                decoder.values.push(Value::of(wanted));
            }
        }
        Ok(decoder)
    }

    /// Adds a field to those that a decoder reads.
    fn add(&self, name: &str, wanted: Wanted, decoder: &mut Decoder) -> Result<(), Mismatch> {
        let message = || self.0.name().to_owned();
        let field = self.0.field.iter().find(|f| f.name() == name);
        let field = field.ok_or_else(|| Mismatch::Missing { message: message(), field: name.to_owned() })?;
        let (found, repeated) = (field.r#type(), field.label() == Label::Repeated);
        let fits = match wanted {
            Wanted::Unsigned => {
                !repeated
                    && matches!(found, Type::Uint64 | Type::Uint32 | Type::Int64 | Type::Int32 | Type::Enum)
            }
            Wanted::Bool => !repeated && found == Type::Bool,
            Wanted::Double => !repeated && found == Type::Double,
            Wanted::Doubles => repeated && found == Type::Double,
            Wanted::Text => !repeated && found == Type::String,
            Wanted::Messages => matches!(found, Type::Message | Type::Bytes),
        };
        if !fits {
            return Err(Mismatch::Kind { message: message(), field: name.to_owned(), found, wanted });
        }
        let (number, slot) = (field.number().unsigned_abs(), decoder.values.len());
        decoder.fields.push(Field { number, slot, read: found });
        decoder.values.push(Value::of(wanted));
        Ok(())
    }
}

impl Value {
    /// Protobuf's default of a field that is read as `wanted`.
    fn of(wanted: Wanted) -> Self {
        match wanted {
            Wanted::Unsigned => Self::Unsigned(0),
            Wanted::Bool => Self::Bool(false),
            Wanted::Double => Self::Doubles(vec![0.0]),
            Wanted::Doubles => Self::Doubles(Vec::new()),
            Wanted::Text => Self::Text(String::new()),
            Wanted::Messages => Self::Messages(Vec::new()),
        }
    }
}

impl Decoder {
    /// Reads a message; a missing field has the default value of protobuf.
    pub fn read(&mut self, mut bytes: &[u8]) -> Result<(), Mismatch> {
        for field in &self.fields {
            match &mut self.values[field.slot] {
                Value::Unsigned(value) => *value = 0,
                Value::Bool(value) => *value = false,
                Value::Doubles(values) => values.clear(),
                Value::Text(text) => text.clear(),
                Value::Messages(messages) => messages.clear(),
            }
        }
        while !bytes.is_empty() {
            let (number, wire) = encoding::decode_key(&mut bytes)?;
            let context = DecodeContext::default();
            let Some(Field { slot, read, .. }) = self.fields.iter().find(|f| f.number == number) else {
                encoding::skip_field(wire, number, &mut bytes, context)?;
                continue;
            };
            match &mut self.values[*slot] {
                Value::Unsigned(value) if matches!(read, Type::Enum | Type::Int32 | Type::Int64) => {
                    let mut number = 0;
                    encoding::int64::merge(wire, &mut number, &mut bytes, context)?;
                    *value = number.try_into().unwrap_or(0);
                }
                Value::Unsigned(value) => encoding::uint64::merge(wire, value, &mut bytes, context)?,
                Value::Bool(value) => encoding::bool::merge(wire, value, &mut bytes, context)?,
                Value::Doubles(values) => {
                    encoding::double::merge_repeated(wire, values, &mut bytes, context)?;
                }
                Value::Text(text) => encoding::string::merge(wire, text, &mut bytes, context)?,
                Value::Messages(messages) if messages.len() >= MOST_MESSAGES => {
                    return Err(Mismatch::TooMany);
                }
                Value::Messages(messages) => {
                    let mut message = Vec::new();
                    encoding::bytes::merge(wire, &mut message, &mut bytes, context)?;
                    messages.push(message);
                }
            }
        }
        Ok(())
    }

    /// The whole number at `place` in the list.
    pub fn unsigned(&self, place: usize) -> u64 {
        if let Value::Unsigned(value) = self.values[place] { value } else { 0 }
    }

    /// The Boolean at `place`.
    pub fn bool(&self, place: usize) -> bool {
        matches!(self.values[place], Value::Bool(true))
    }

    /// The number at `place`.
    pub fn double(&self, place: usize) -> f64 {
        self.doubles(place).last().copied().unwrap_or(0.0)
    }

    /// The numbers at `place`.
    pub fn doubles(&self, place: usize) -> &[f64] {
        if let Value::Doubles(values) = &self.values[place] { values } else { &[] }
    }

    /// The text at `place`.
    pub fn text(&self, place: usize) -> String {
        if let Value::Text(text) = &self.values[place] { text.clone() } else { String::new() }
    }

    /// The messages at `place`.
    pub fn messages(&self, place: usize) -> &[Vec<u8>] {
        if let Value::Messages(messages) = &self.values[place] { messages } else { &[] }
    }
}

#[cfg(test)]
mod tests {
    use super::super::schema::{Kind, MessageType, Value as Written};
    use super::*;

    fn written(fields: &[(&str, Kind)], values: &[Written<'_>]) -> (Schema, Vec<u8>) {
        let fields = fields.iter().map(|(n, k)| ((*n).to_owned(), k.clone())).collect();
        let kind = MessageType::new("Thing", fields);
        let schema = Schema::find("cofferdam.Thing", &kind.descriptor_set()).ok();
        (schema.unwrap_or(Schema(DescriptorProto::default())), kind.encode(values.iter().copied()))
    }

    #[test]
    fn fields_are_found_by_name_and_numbers_keep_their_bits() -> Result<(), Mismatch> {
        let odd = [f64::from_bits(0x7ff0_0000_0000_0001), -0.0, f64::from_bits(1), f64::NEG_INFINITY];
        let fields =
            [("new", Kind::Text), ("a", Kind::Doubles), ("step", Kind::Unsigned), ("b", Kind::Double)];
        let values =
            [Written::Text("?"), Written::Doubles(&odd), Written::Unsigned(1 << 63), Written::Double(odd[0])];
        let (schema, bytes) = written(&fields, &values);
        let wanted = [("b", Wanted::Double), ("step", Wanted::Unsigned), ("a", Wanted::Doubles)];
        let mut decoder = schema.decoder(wanted)?;
        for _ in 0..2 {
            decoder.read(&bytes)?;
            assert_eq!(decoder.double(0).to_bits(), odd[0].to_bits());
            assert_eq!(decoder.unsigned(1), 1 << 63);
            assert_eq!(
                decoder.doubles(2).iter().map(|v| v.to_bits()).collect::<Vec<_>>(),
                odd.map(f64::to_bits)
            );
        }
        Ok(())
    }

    #[test]
    fn what_is_missing_or_of_another_kind_is_named() {
        let (schema, bytes) = written(&[("a", Kind::Double)], &[Written::Double(1.0)]);
        let missing = schema.decoder([("step", Wanted::Unsigned)]).err().map(|e| e.to_string());
        assert_eq!(missing.as_deref(), Some("its message `Thing` has no field `step`"));
        let kind = schema.decoder([("a", Wanted::Text)]).err().map(|e| e.to_string());
        assert_eq!(kind.as_deref(), Some("the field `a` of its message `Thing` is Double, not Text"));
        for end in 1..bytes.len() {
            let read = schema.decoder([("a", Wanted::Double)]).and_then(|mut d| d.read(&bytes[..end]));
            assert!(matches!(read, Err(Mismatch::Bytes(_))), "{end} bytes");
        }
        assert!(matches!(Schema::find("cofferdam.Thing", &[1, 2, 3]), Err(Mismatch::Schema)));
    }
}
