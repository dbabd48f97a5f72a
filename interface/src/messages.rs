use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::sync::{Arc, Mutex, PoisonError};
use tracing::field::{Field, Visit};
use tracing::subscriber::Interest;
use tracing::{Dispatch, Event, Metadata, Subscriber, span};

/// Importance of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Level {
    /// For developers of the unit.
    Debug,
    /// Normal progress.
    Information,
    /// Results may be doubtful.
    Warning,
    /// The unit cannot go on.
    Error,
}

impl std::fmt::Display for Level {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Debug => "debug",
            Self::Information => "information",
            Self::Warning => "warning",
            Self::Error => "error",
        })
    }
}

/// Collects the `tracing` events of calls, down to [`Level::Information`].
///
/// Only events of the calling thread are collected.
#[derive(Clone, Debug)]
pub struct Messages {
    dispatch: Dispatch,
    collected: Arc<Mutex<Vec<Message>>>,
}

/// Level, source and text.
type Message = (Level, String, String);

impl Default for Messages {
    fn default() -> Self {
        let collected = Arc::default();
        Self { dispatch: Dispatch::new(Listener(Arc::clone(&collected))), collected }
    }
}

impl Messages {
    /// Calls `call` and collects its events.
    pub fn listen<T>(&self, call: impl FnOnce() -> T) -> T {
        tracing::dispatcher::with_default(&self.dispatch, call)
    }

    /// Takes the messages collected since the last call of `take`: level, source, text.
    pub fn take(&self) -> Vec<(Level, String, String)> {
        std::mem::take(&mut *self.collected.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// A subscriber that keeps events and ignores spans.
struct Listener(Arc<Mutex<Vec<Message>>>);

impl Subscriber for Listener {
    fn register_callsite(&self, metadata: &'static Metadata<'static>) -> Interest {
        if self.enabled(metadata) { Interest::always() } else { Interest::never() }
    }

    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.is_event() && *metadata.level() <= tracing::Level::INFO
    }

    fn new_span(&self, _span: &span::Attributes<'_>) -> span::Id {
        span::Id::from_u64(1)
    }

    fn record(&self, _span: &span::Id, _values: &span::Record<'_>) {}

    fn record_follows_from(&self, _span: &span::Id, _follows: &span::Id) {}

    fn event(&self, event: &Event<'_>) {
        let level = match *event.metadata().level() {
            tracing::Level::ERROR => Level::Error,
            tracing::Level::WARN => Level::Warning,
            tracing::Level::INFO => Level::Information,
            _ => Level::Debug,
        };
        let mut text = Text::default();
        event.record(&mut text);
        let message = (level, event.metadata().target().to_owned(), text.0);
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(message);
    }

    fn enter(&self, _span: &span::Id) {}

    fn exit(&self, _span: &span::Id) {}
}

/// The message of an event, then its fields as `name = value`.
#[derive(Default)]
struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        let separator = if self.0.is_empty() { "" } else { ", " };
        // Writing to a string cannot fail.
        let _ = match field.name() {
            "message" => write!(self.0, "{separator}{value:?}"),
            name => write!(self.0, "{separator}{name} = {value:?}"),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_are_collected_with_their_fields_and_only_while_listening() {
        let messages = Messages::default();
        tracing::info!("nobody listens");
        let answer = messages.listen(|| {
            tracing::warn!(steps = 3, "slow");
            tracing::trace!("too much");
            7
        });
        let source = module_path!().to_owned();
        assert_eq!(
            (answer, messages.take()),
            (7, vec![(Level::Warning, source, "slow, steps = 3".to_owned())])
        );
        assert!(messages.take().is_empty());
    }
}
