#![allow(unsafe_code)] // it calls back into C

use super::ExportError;
use super::types::{LogMessage, Logger, Status};
use crate::Level;
use std::ffi::{CString, c_void};
use std::io::Write;
use std::sync::atomic::{AtomicU8, Ordering};

/// The log categories by their bits, and what their messages say.
pub const LOG_CATEGORIES: [(&str, &str); 3] = [
    ("logStatusError", "errors: calls that were refused, and why"),
    ("logStatusWarning", "doubtful results, and why"),
    ("logEvents", "messages of the unit while it computes"),
];
const ERROR: usize = 0;
const WARNING: usize = 1;
const EVENT: usize = 2;

/// Passes the messages of an instance to the importer: errors always, other categories where it has turned them on. If the
/// importer has no callback for messages, errors are written to standard error.
pub struct Log {
    callback: Option<Callback>,
    /// Address that the importer gets back with each message.
    environment: usize,
    wanted: AtomicU8,
}

/// The importer's function for messages.
pub enum Callback {
    /// Of FMI 3.0.
    LogMessage(LogMessage),
    /// Of FMI 2.0, with the name of the instance.
    Logger(Logger, CString),
}

impl Log {
    /// A log that calls `callback`; `on` turns all categories on.
    pub fn new(callback: Option<Callback>, environment: *mut c_void, on: bool) -> Self {
        let new = Self { callback, environment: environment as usize, wanted: AtomicU8::new(0) };
        new.choose(on, ALL);
        new
    }

    /// Turns the `categories` (bits) on, and all others off; or all off.
    pub fn choose(&self, on: bool, categories: u8) {
        let wanted = if on { categories } else { 0 };
        self.wanted.store(wanted | 1 << ERROR, Ordering::Relaxed);
    }

    /// Passes on why a call was refused.
    pub fn error(&self, status: Status, error: &ExportError) {
        self.say(ERROR, status, &error.to_string());
    }

    /// Passes on a message of the unit.
    pub fn message(&self, level: Level, text: &str) {
        match level {
            Level::Error => self.say(ERROR, Status::Error, text),
            Level::Warning => self.say(WARNING, Status::Warning, text),
            Level::Information | Level::Debug => self.say(EVENT, Status::Ok, text),
        }
    }

    fn say(&self, category: usize, status: Status, text: &str) {
        let Some(callback) = &self.callback else {
            if category == ERROR {
                // There is nobody to tell that standard error is closed.
                let _ = writeln!(std::io::stderr(), "{text}");
            }
            return;
        };
        if self.wanted.load(Ordering::Relaxed) & 1 << category == 0 {
            return;
        }
        // In FMI 2.0 a message is a format.
        let text = match callback {
            Callback::LogMessage(_) => text.to_owned(),
            Callback::Logger(..) => text.replace('%', "%%"),
        };
        // Messages contain no NUL themselves, but may quote text that the importer passed.
        let [category, text] =
            [LOG_CATEGORIES[category].0, &text].map(|text| CString::new(text.replace('\0', "")));
        if let (Ok(category), Ok(text)) = (category, text) {
            let environment = self.environment as *mut c_void;
            let (category, text) = (category.as_ptr(), text.as_ptr());
            // SAFETY: the importer promises that the callback may be called with its environment as long as the
            // instance lives; all strings live until it returns, and no argument is left out that the text names.
            unsafe {
                match callback {
                    Callback::LogMessage(callback) => callback(environment, status, category, text),
                    Callback::Logger(callback, name) => {
                        callback(environment, name.as_ptr(), status, category, text);
                    }
                }
            }
        }
    }
}

/// The bits of all categories.
pub const ALL: u8 = (1 << LOG_CATEGORIES.len()) - 1;

/// The bit of a category.
pub fn category(name: &str) -> Result<u8, ExportError> {
    let found = LOG_CATEGORIES.iter().position(|(category, _)| *category == name);
    found.map(|bit| 1 << bit).ok_or_else(|| ExportError::Category { found: name.to_owned() })
}
