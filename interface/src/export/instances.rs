use super::ExportError;
use super::instance::Instance;
use super::log::Log;
use super::types::Status;
use crate::{Messages, Packable};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// All instances of one library.
pub struct Instances<U: Packable> {
    live: Mutex<BTreeMap<usize, Arc<Live<U>>>>,
    handles: AtomicUsize,
}

struct Live<U: Packable> {
    log: Log,
    messages: Messages,
    instance: Mutex<Instance<U>>,
}

impl<U: Packable> Instances<U> {
    /// Without instances.
    #[allow(clippy::new_without_default)] // a static needs a const function
    pub const fn new() -> Self {
        Self { live: Mutex::new(BTreeMap::new()), handles: AtomicUsize::new(1) }
    }

    /// A handle that neither this library, since it was loaded, nor another library of this project has used.
    pub fn new_handle(&self) -> usize {
        // The memory page of this static belongs to this library alone.
        let library = (std::ptr::from_ref(self).addr() >> 12) << (usize::BITS / 2);
        library.wrapping_add(self.handles.fetch_add(1, Ordering::Relaxed))
    }

    /// Makes an instance and returns its handle; on an error, logs it and returns nothing.
    pub fn insert(
        &self,
        call: &'static str,
        log: Log,
        make: impl FnOnce() -> Result<Instance<U>, ExportError>,
    ) -> Option<usize> {
        let instance = match guarded(call, make) {
            Ok(instance) => Mutex::new(instance),
            Err(error) => {
                log.error(status_of(&error), &error);
                return None;
            }
        };
        let handle = self.new_handle();
        let live = Arc::new(Live { log, messages: Messages::default(), instance });
        self.live.lock().unwrap_or_else(PoisonError::into_inner).insert(handle, live);
        Some(handle)
    }

    fn find(&self, handle: usize) -> Option<Arc<Live<U>>> {
        self.live.lock().unwrap_or_else(PoisonError::into_inner).get(&handle).cloned()
    }

    /// Frees the instance of `handle`, if there is one, with its saved states.
    pub fn remove(&self, handle: usize) {
        let removed = self.live.lock().unwrap_or_else(PoisonError::into_inner).remove(&handle);
        release(removed);
    }

    /// Calls `body` with the instance, then passes the messages of the unit and the error, if any, to the importer.
    ///
    /// A handle that belongs to no instance gives [`Status::Error`] without a message: there is no log to write to.
    pub fn call(
        &self,
        call: &'static str,
        handle: usize,
        body: impl FnOnce(&mut Instance<U>, &Log) -> Result<(), ExportError>,
    ) -> Status {
        let Some(live) = self.find(handle) else { return Status::Error };
        let result = guarded(call, || {
            let mut instance = live.instance.lock().map_err(|_| ExportError::Broken)?;
            live.messages.listen(|| body(&mut instance, &live.log))
        });
        for (level, _, text) in live.messages.take() {
            live.log.message(level, &text);
        }
        let status = match &result {
            Ok(()) => Status::Ok,
            Err(error) => status_of(error),
        };
        if let Err(error) = result {
            live.log.error(status, &error);
        }
        release(live);
        status
    }
}

fn status_of(error: &ExportError) -> Status {
    match error {
        ExportError::Panicked { .. } | ExportError::Broken => Status::Fatal,
        _ => Status::Error,
    }
}

/// Drops `left`. A panic in its destructor is ignored: it must not reach the importer, and there is no log left for it.
fn release<T>(left: T) {
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| drop(left))) {
        std::mem::forget(panic);
    }
}

/// Calls `body`; a panic becomes an error, because it must not reach the importer.
fn guarded<T>(call: &'static str, body: impl FnOnce() -> Result<T, ExportError>) -> Result<T, ExportError> {
    catch_unwind(AssertUnwindSafe(body)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let cause = text.or_else(|| panic.downcast_ref::<String>().cloned());
        // Dropping the payload might panic again.
        std::mem::forget(panic);
        Err(ExportError::Panicked { call, cause: cause.unwrap_or_else(|| "without a message".to_owned()) })
    })
}
