use iceoryx2::prelude::ZeroCopySend;

/// Version of the protocol: header, commands, and the lines on standard output.
pub const PROTOCOL_VERSION: u32 = 6;

/// Command of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Command {
    /// Answer with the variable of value reference [`Header::variable`], which is not an exchanged one.
    Read = 1,
    /// Initialise at [`Header::time`] with the inputs, answer with the outputs.
    Initialise = 2,
    /// Step with the inputs, answer with the outputs.
    Step = 3,
    /// Save the state, then step.
    SaveAndStep = 4,
    /// Return to the saved state, then step.
    RestoreAndStep = 5,
    /// Write the state as bytes to the file that both know.
    Serialise = 6,
    /// Return to the saved state, then write it.
    RestoreAndSerialise = 7,
    /// Take the state in that file, in place of initialisation.
    Deserialise = 8,
    /// Answer with the values of that variable at the places that the request holds.
    ReadAt = 9,
}

/// Result of a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Status {
    /// The answer holds the outputs.
    Done = 0,
    /// The unit writes the reason to its standard output; the answer is empty.
    Failed = 1,
    /// The unit does not offer the command; the answer is empty.
    NotOffered = 2,
}

/// Header of every request; an answer repeats it and fills the last three fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("cofferdam.Header")]
#[allow(unsafe_code)] // the derive's promise that the type may lie in shared memory
pub struct Header {
    /// [`PROTOCOL_VERSION`].
    pub protocol_version: u32,
    /// [`Command`].
    pub command: u32,
    /// Number of the run.
    pub run: u64,
    /// Number of the communication step, from 1; 0 is initialisation.
    pub step: u64,
    /// Iteration of the communication step, from 1.
    pub iteration: u32,
    /// Number of the attempt, from 1; each attempt has another step length.
    pub attempt: u32,
    /// Start of the step, s.
    pub time: f64,
    /// Length H of the step, s.
    pub communication_step: f64,
    /// Value reference, for [`Command::Read`].
    pub variable: u32,
    /// [`Status`]; 0 in a request.
    pub status: u32,
    /// Time that the unit spent, ns; 0 in a request.
    pub busy: u64,
    /// Number of lines ([`Word`](crate::Word)) that the unit has written to its standard output so far;
    /// 0 in a request.
    pub words: u64,
}

/// A field of the header that must be echoed.
pub type HeaderField = &'static str;

impl Header {
    /// Its fields: name, type, offset in bytes.
    pub const FIELDS: [(HeaderField, &str, usize); 12] = [
        ("protocol_version", "u32", 0),
        ("command", "u32", 4),
        ("run", "u64", 8),
        ("step", "u64", 16),
        ("iteration", "u32", 24),
        ("attempt", "u32", 28),
        ("time", "f64", 32),
        ("communication_step", "f64", 40),
        ("variable", "u32", 48),
        ("status", "u32", 52),
        ("busy", "u64", 56),
        ("words", "u64", 64),
    ];

    /// The command, if it is one.
    pub fn command(&self) -> Option<Command> {
        use Command::{
            Deserialise, Initialise, Read, ReadAt, RestoreAndSerialise, RestoreAndStep, SaveAndStep,
            Serialise, Step,
        };
        [
            Read,
            Initialise,
            Step,
            SaveAndStep,
            RestoreAndStep,
            Serialise,
            RestoreAndSerialise,
            Deserialise,
            ReadAt,
        ]
        .into_iter()
        .find(|c| *c as u32 == self.command)
    }

    /// The first field that `answer` does not repeat: its name, the value sent, the value in the answer.
    pub fn difference(&self, answer: &Self) -> Option<(HeaderField, String, String)> {
        let echoed = |h: &Self| {
            [
                h.protocol_version.into(),
                h.command.into(),
                h.run,
                h.step,
                h.iteration.into(),
                h.attempt.into(),
                h.time.to_bits(),
                h.communication_step.to_bits(),
                h.variable.into(),
            ]
        };
        let (sent, found) = (echoed(self), echoed(answer));
        let index = (0..sent.len()).find(|&i| sent[i] != found[i])?;
        let (name, kind, _) = Self::FIELDS[index];
        let show = |bits: u64| match kind {
            "f64" => f64::from_bits(bits).to_string(),
            _ => bits.to_string(),
        };
        Some((name, show(sent[index]), show(found[index])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;

    #[test]
    fn the_list_of_fields_is_that_of_the_struct() {
        let offsets = [
            offset_of!(Header, protocol_version),
            offset_of!(Header, command),
            offset_of!(Header, run),
            offset_of!(Header, step),
            offset_of!(Header, iteration),
            offset_of!(Header, attempt),
            offset_of!(Header, time),
            offset_of!(Header, communication_step),
            offset_of!(Header, variable),
            offset_of!(Header, status),
            offset_of!(Header, busy),
            offset_of!(Header, words),
        ];
        assert_eq!(Header::FIELDS.map(|f| f.2), offsets);
        assert_eq!(size_of::<Header>(), 72);
    }

    #[test]
    fn an_echo_that_differs_is_named() {
        let command = Command::Step as u32;
        let request =
            Header { protocol_version: 2, command, run: 3, step: 7, time: 0.5, ..Header::default() };
        assert_eq!(request.command(), Some(Command::Step));
        let answer = Header { status: 1, busy: 9, words: 2, ..request };
        assert_eq!(request.difference(&answer), None);
        let late = Header { time: 0.25, ..request };
        assert_eq!(request.difference(&late), Some(("time", "0.5".to_owned(), "0.25".to_owned())));
        let other = Header { run: 4, ..request };
        assert_eq!(request.difference(&other), Some(("run", "3".to_owned(), "4".to_owned())));
        assert_eq!(Header { command: 99, ..request }.command(), None);
    }
}
