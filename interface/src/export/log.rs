#![allow(unsafe_code)] // it calls back into C

use super::ExportError;
use super::fmi3::{LogMessage, Status};
use crate::Level;
use std::ffi::{CString, c_void};
use std::sync::atomic::{AtomicU8, Ordering};

/// The categories of messages, by their bits.
const CATEGORIES: [&str; 3] = ["logStatusError", "logStatusWarning", "logEvents"];
const ERROR: usize = 0;
const WARNING: usize = 1;
const EVENT: usize = 2;

/// Says to the importer what an instance has to say: errors always, the rest if it wants to hear it.
pub struct Log {
    callback: Option<LogMessage>,
    /// Address that the importer wants back.
    environment: usize,
    wanted: AtomicU8,
}

impl Log {
    /// Speaks through `callback`.
    pub fn new(callback: Option<LogMessage>, environment: *mut c_void, on: bool) -> Self {
        let new = Self { callback, environment: environment as usize, wanted: AtomicU8::new(0) };
        new.choose(on, ALL);
        new
    }

    /// Turns the `categories` (bits) on, and all others off; or all off.
    pub fn choose(&self, on: bool, categories: u8) {
        let wanted = if on { categories } else { 0 };
        self.wanted.store(wanted | 1 << ERROR, Ordering::Relaxed);
    }

    /// Says why a call is refused.
    pub fn error(&self, status: Status, error: &ExportError) {
        self.say(ERROR, status, &error.to_string());
    }

    /// Says what the unit said.
    pub fn message(&self, level: Level, text: &str) {
        match level {
            Level::Error => self.say(ERROR, Status::Error, text),
            Level::Warning => self.say(WARNING, Status::Warning, text),
            Level::Information | Level::Debug => self.say(EVENT, Status::Ok, text),
        }
    }

    fn say(&self, category: usize, status: Status, text: &str) {
        let Some(callback) = self.callback else { return };
        if self.wanted.load(Ordering::Relaxed) & 1 << category == 0 {
            return;
        }
        // Nothing that is said holds a NUL, but what an importer passed may.
        let [category, text] = [CATEGORIES[category], text].map(|text| CString::new(text.replace('\0', "")));
        if let (Ok(category), Ok(text)) = (category, text) {
            let environment = self.environment as *mut c_void;
            // SAFETY: the importer promises that the callback may be called with its environment as long as the
            // instance lives; both strings live until it returns.
            unsafe { callback(environment, status, category.as_ptr(), text.as_ptr()) };
        }
    }
}

/// The bits of all categories.
pub const ALL: u8 = (1 << CATEGORIES.len()) - 1;

/// The bit of a category.
pub fn category(name: &str) -> Result<u8, ExportError> {
    let found = CATEGORIES.iter().position(|category| *category == name);
    found.map(|bit| 1 << bit).ok_or_else(|| ExportError::Category { found: name.to_owned() })
}
