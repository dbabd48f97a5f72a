//! Calls of a unit over shared memory: the header of a request and the layout of its values.

use crate::transport::{Command, Header, PROTOCOL_VERSION};
use cofferdam_coupling::participant::{Description, Occasion};
use cofferdam_unit::sha256;
use std::fmt::Write;

/// The header of a request of `run` for `command` on `occasion`.
pub fn request(run: u64, command: Command, occasion: &Occasion) -> Header {
    let Occasion { step, iteration, attempt, time, communication_step } = *occasion;
    Header {
        protocol_version: PROTOCOL_VERSION,
        command: command as u32,
        run,
        step,
        iteration,
        attempt,
        time,
        communication_step,
        ..Header::default()
    }
}

/// The occasion of a request.
pub fn occasion(header: &Header) -> Occasion {
    let Header { step, iteration, attempt, time, communication_step, .. } = *header;
    Occasion { step, iteration, attempt, time, communication_step }
}

/// Hash of how requests and answers of a unit are laid out: SHA-256, in hexadecimal digits, of one line
/// `header NAME TYPE OFFSET` a field of the header and one line `input NAME REFERENCE SIZE` or
/// `output NAME REFERENCE SIZE` a variable, each ended by a line feed.
pub fn layout_hash(description: &Description) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    for (name, kind, offset) in Header::FIELDS {
        let _ = writeln!(text, "header {name} {kind} {offset}");
    }
    for (what, layout) in [("input", &description.inputs), ("output", &description.outputs)] {
        for (channel, range) in layout.channels() {
            let _ = writeln!(text, "{what} {} {} {}", channel.name, channel.value_reference, range.len());
        }
    }
    sha256(&text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_carries_its_occasion() {
        let asked = Occasion { step: 7, iteration: 2, attempt: 1, time: 0.5, communication_step: 0.25 };
        let header = request(3, Command::Step, &asked);
        assert_eq!((occasion(&header), header.command()), (asked, Some(Command::Step)));
    }
}
