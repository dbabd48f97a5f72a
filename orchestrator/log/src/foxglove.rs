//! `foxglove.Log`: messages of units, in the type that viewers show in their log panels.

use cofferdam_coupling::participant::{Level, Message};
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{
    DescriptorProto, EnumDescriptorProto, EnumValueDescriptorProto, FieldDescriptorProto,
    FileDescriptorProto, FileDescriptorSet, Timestamp,
};

/// Name of the message type.
pub const LOG: &str = "foxglove.Log";

const LEVELS: [&str; 6] = ["UNKNOWN", "DEBUG", "INFO", "WARNING", "ERROR", "FATAL"];
/// Name of the type of its timestamp.
pub const TIMESTAMP: &str = "google.protobuf.Timestamp";

/// A message as it is written; the fields `step` and `iteration` are additions to Foxglove's type.
#[derive(Clone, PartialEq, prost::Message)]
struct Log {
    #[prost(message, optional, tag = "1")]
    timestamp: Option<Timestamp>,
    #[prost(int32, tag = "2")]
    level: i32,
    #[prost(string, tag = "3")]
    message: String,
    #[prost(string, tag = "4")]
    name: String,
    #[prost(string, tag = "5")]
    file: String,
    #[prost(fixed32, tag = "6")]
    line: u32,
    #[prost(uint64, tag = "16")]
    step: u64,
    #[prost(uint64, tag = "17")]
    iteration: u64,
}

/// The message, at simulated time.
pub fn encode(message: &Message) -> Vec<u8> {
    let whole = message.time.floor();
    let nanos = ((message.time - whole) * 1e9).round() as i32;
    let timestamp = Timestamp { seconds: whole as i64, nanos: nanos.min(999_999_999) };
    prost::Message::encode_to_vec(&Log {
        timestamp: Some(timestamp),
        level: match message.level {
            Level::Debug => 1,
            Level::Information => 2,
            Level::Warning => 3,
            Level::Error => 4,
        },
        message: message.text.clone(),
        name: message.unit.clone(),
        file: message.source.clone(),
        line: 0,
        step: message.step,
        iteration: u64::from(message.iteration),
    })
}

/// The level of a number in a log.
pub fn level(number: u64) -> Level {
    match number {
        0 | 1 => Level::Debug,
        2 => Level::Information,
        3 => Level::Warning,
        _ => Level::Error,
    }
}

/// The encoded `FileDescriptorSet` of [`LOG`] and of the timestamp in it.
pub fn descriptor_set() -> Vec<u8> {
    let field = |name: &str, number: i32, kind: Type, of: Option<&str>| FieldDescriptorProto {
        name: Some(name.to_owned()),
        number: Some(number),
        label: Some(Label::Optional as i32),
        r#type: Some(kind as i32),
        type_name: of.map(|name| format!(".{name}")),
        ..Default::default()
    };
    let message = |name: &str, field: Vec<FieldDescriptorProto>| DescriptorProto {
        name: Some(name.to_owned()),
        field,
        ..Default::default()
    };
    let file = |name: &str, package: &str, message: DescriptorProto| FileDescriptorProto {
        name: Some(name.to_owned()),
        package: Some(package.to_owned()),
        syntax: Some("proto3".to_owned()),
        message_type: vec![message],
        ..Default::default()
    };
    let level = |(number, name): (i32, &str)| EnumValueDescriptorProto {
        name: Some(name.to_owned()),
        number: Some(number),
        options: None,
    };
    let levels = EnumDescriptorProto {
        name: Some("Level".to_owned()),
        value: (0..).zip(LEVELS).map(level).collect(),
        ..Default::default()
    };
    let seconds = vec![field("seconds", 1, Type::Int64, None), field("nanos", 2, Type::Int32, None)];
    let log = vec![
        field("timestamp", 1, Type::Message, Some(TIMESTAMP)),
        field("level", 2, Type::Enum, Some("foxglove.Log.Level")),
        field("message", 3, Type::String, None),
        field("name", 4, Type::String, None),
        field("file", 5, Type::String, None),
        field("line", 6, Type::Fixed32, None),
        field("step", 16, Type::Uint64, None),
        field("iteration", 17, Type::Uint64, None),
    ];
    let timestamp = "google/protobuf/timestamp.proto";
    let log = DescriptorProto { enum_type: vec![levels], ..message("Log", log) };
    let set = FileDescriptorSet {
        file: vec![
            file(timestamp, "google.protobuf", message("Timestamp", seconds)),
            FileDescriptorProto {
                dependency: vec![timestamp.to_owned()],
                ..file("foxglove/Log.proto", "foxglove", log)
            },
        ],
    };
    prost::Message::encode_to_vec(&set)
}
