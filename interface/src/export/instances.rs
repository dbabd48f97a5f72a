use super::ExportError;
use super::fmi3::Status;
use super::instance::Instance;
use super::log::Log;
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
    heard: Messages,
    instance: Mutex<Instance<U>>,
}

impl<U: Packable> Instances<U> {
    /// None yet.
    #[allow(clippy::new_without_default)] // it is made in a static
    pub const fn new() -> Self {
        Self { live: Mutex::new(BTreeMap::new()), handles: AtomicUsize::new(1) }
    }

    /// A handle that was never used while this library is loaded, nor by another library.
    pub fn new_handle(&self) -> usize {
        // No two libraries have this page of memory.
        let library = (std::ptr::from_ref(self).addr() >> 12) << (usize::BITS / 2);
        library.wrapping_add(self.handles.fetch_add(1, Ordering::Relaxed))
    }

    /// Makes an instance; returns its handle, or nothing, and says why.
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
        let live = Arc::new(Live { log, heard: Messages::default(), instance });
        self.live.lock().unwrap_or_else(PoisonError::into_inner).insert(handle, live);
        Some(handle)
    }

    fn find(&self, handle: usize) -> Option<Arc<Live<U>>> {
        self.live.lock().unwrap_or_else(PoisonError::into_inner).get(&handle).cloned()
    }

    /// Frees an instance, if there is one, with all its saved states.
    pub fn remove(&self, handle: usize) {
        let removed = self.live.lock().unwrap_or_else(PoisonError::into_inner).remove(&handle);
        release(removed);
    }

    /// Calls `body` with the instance, and tells the importer what was said meanwhile and what went wrong.
    ///
    /// A handle that is no instance's has nobody to tell.
    pub fn call(
        &self,
        call: &'static str,
        handle: usize,
        body: impl FnOnce(&mut Instance<U>, &Log) -> Result<(), ExportError>,
    ) -> Status {
        let Some(live) = self.find(handle) else { return Status::Error };
        let result = guarded(call, || {
            let mut instance = live.instance.lock().map_err(|_| ExportError::Broken)?;
            live.heard.listen(|| body(&mut instance, &live.log))
        });
        for (level, _, text) in live.heard.take() {
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

/// Drops what an instance leaves behind: if it is the last to hold it and breaks down, nobody is left to be told.
fn release<T>(left: T) {
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| drop(left))) {
        std::mem::forget(panic);
    }
}

/// Calls `body`; a panic becomes an error, for it must not reach the importer.
fn guarded<T>(call: &'static str, body: impl FnOnce() -> Result<T, ExportError>) -> Result<T, ExportError> {
    catch_unwind(AssertUnwindSafe(body)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let cause = text.or_else(|| panic.downcast_ref::<String>().cloned());
        // Dropping it might panic once more.
        std::mem::forget(panic);
        Err(ExportError::Panicked { call, cause: cause.unwrap_or_else(|| "it said nothing".to_owned()) })
    })
}
