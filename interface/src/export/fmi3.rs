//! The C functions of FMI 3.0, generic over the unit. [`export_fmi3!`](crate::export_fmi3) gives them their names.
//!
//! **Source**: Functional Mock-up Interface specification 3.0.2, sections 2.2 and 4.2, and its header files.
#![allow(unsafe_code)] // C calls it

use super::instance::Instance;
use super::log::{self, Callback, Log};
use super::pointers::{place, slice, slice_mut};
use super::{Contents, ExportError};
use crate::Packable;
use std::ffi::{CStr, c_void};
use std::path::Path;

pub use super::access::{get_boolean, get_float64, get_int32, set_boolean, set_float64, set_int32};
pub use super::instances::Instances;
pub use super::types::{Boolean, Handle, LogMessage, Status, Text};

/// The text at `pointer`.
///
/// # Safety
/// A pointer that is not null points to a C string.
pub(super) unsafe fn text<'a>(
    call: &'static str,
    argument: &'static str,
    pointer: Text,
) -> Result<&'a str, ExportError> {
    if pointer.is_null() {
        return Err(ExportError::Pointer { call, argument });
    }
    // SAFETY: by the caller.
    unsafe { CStr::from_ptr(pointer) }.to_str().map_err(|_| ExportError::Text { call, argument })
}

/// `fmi3InstantiateCoSimulation`, with the arguments that this FMU uses.
///
/// # Safety
/// As FMI 3.0 demands of importers.
pub unsafe fn instantiate<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    [name, token, resources]: [Text; 3],
    [logging, event_mode]: [Boolean; 2],
    environment: *mut c_void,
    log_message: Option<LogMessage>,
) -> Handle {
    let log = Log::new(log_message.map(Callback::LogMessage), environment, logging != 0);
    let made = instances.insert(call, log, || {
        // SAFETY: by the caller.
        unsafe { text(call, "instanceName", name) }?;
        // SAFETY: by the caller.
        let found = unsafe { text(call, "instantiationToken", token) }?;
        // SAFETY: by the caller.
        let resources = unsafe { text(call, "resourcePath", resources) }?;
        if event_mode != 0 {
            return Err(ExportError::EventMode);
        }
        made(resources.as_ref(), found)
    });
    made.map_or(std::ptr::null_mut(), std::ptr::without_provenance_mut)
}

/// The instance with the contents of a folder of resources, whose token is `found`.
pub(super) fn made<U: Packable>(resources: &Path, found: &str) -> Result<Instance<U>, ExportError> {
    // The importer may change its working directory before the unit is made.
    let resources = std::path::absolute(resources).unwrap_or_else(|_| resources.into());
    let contents = Contents::read(&resources)?;
    let expected = contents.token::<U>()?;
    if found != expected {
        return Err(ExportError::Token { found: found.to_owned(), expected });
    }
    Instance::new(contents, &resources)
}

/// The instantiation of another kind of FMU: logs an error and returns null.
pub fn refuse_instance<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    environment: *mut c_void,
    log_message: Option<LogMessage>,
) -> Handle {
    let log = Log::new(log_message.map(Callback::LogMessage), environment, false);
    instances.insert(call, log, || Err(ExportError::NotOffered { call }));
    std::ptr::null_mut()
}

/// `fmi3FreeInstance`.
pub fn free_instance<U: Packable>(instances: &Instances<U>, instance: Handle) {
    instances.remove(instance.addr());
}

/// A function that this FMU does not offer.
pub fn refuse<U: Packable>(instances: &Instances<U>, call: &'static str, instance: Handle) -> Status {
    instances.call(call, instance.addr(), |_, _| Err(ExportError::NotOffered { call }))
}

/// Getters and setters of types that no variable has: they accept only an empty list of variables.
pub fn no_variable<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    references: usize,
) -> Status {
    instances.call(call, instance.addr(), |_, _| match references {
        0 => Ok(()),
        _ => Err(ExportError::NotOffered { call }),
    })
}

/// `fmi3SetDebugLogging`; an empty list means all categories.
///
/// # Safety
/// As FMI 3.0 demands of importers.
pub unsafe fn set_debug_logging<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    on: Boolean,
    (count, categories): (usize, *const Text),
) -> Status {
    instances.call(call, instance.addr(), |_, log| {
        // SAFETY: by the caller.
        let categories = unsafe { slice(call, "categories", categories, count) }?;
        let mut wanted = if count == 0 { log::ALL } else { 0 };
        for category in categories {
            // SAFETY: by the caller.
            wanted |= log::category(unsafe { text(call, "categories", *category) }?)?;
        }
        log.choose(on != 0, wanted);
        Ok(())
    })
}

/// `fmi3EnterInitializationMode`.
pub fn enter_initialization_mode<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    start_time: f64,
    (has_stop_time, stop_time): (Boolean, f64),
) -> Status {
    let stop_time = (has_stop_time != 0).then_some(stop_time);
    instances.call(call, instance.addr(), |i, _| i.enter_initialization(call, start_time, stop_time))
}

/// `fmi3ExitInitializationMode`.
pub fn exit_initialization_mode<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
) -> Status {
    instances.call(call, instance.addr(), |i, _| i.exit_initialization(call))
}

/// `fmi3Terminate`.
pub fn terminate<U: Packable>(instances: &Instances<U>, call: &'static str, instance: Handle) -> Status {
    instances.call(call, instance.addr(), |i, _| i.terminate(call))
}

/// `fmi3Reset`.
pub fn reset<U: Packable>(instances: &Instances<U>, call: &'static str, instance: Handle) -> Status {
    instances.call(call, instance.addr(), |i, _| i.reset())
}

/// `fmi3DoStep`; there are no events, early returns or terminations by the FMU.
///
/// # Safety
/// As FMI 3.0 demands of importers.
pub unsafe fn do_step<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    [time, communication_step]: [f64; 2],
    flags: [(&'static str, *mut Boolean); 3],
    last_successful_time: *mut f64,
) -> Status {
    instances.call(call, instance.addr(), |i, _| {
        for (argument, flag) in flags {
            // SAFETY: by the caller.
            *unsafe { place(call, argument, flag) }? = 0;
        }
        // SAFETY: by the caller.
        let end = unsafe { place(call, "lastSuccessfulTime", last_successful_time) }?;
        *end = i.time();
        *end = i.step(call, time, communication_step)?;
        Ok(())
    })
}

/// `fmi3GetDirectionalDerivative`.
///
/// # Safety
/// As FMI 3.0 demands of importers.
pub unsafe fn get_directional_derivative<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    [unknowns, knowns]: [(*const u32, usize); 2],
    (seed, seed_length): (*const f64, usize),
    (sensitivity, sensitivity_length): (*mut f64, usize),
) -> Status {
    instances.call(call, instance.addr(), |i, _| {
        // SAFETY: by the caller.
        let unknowns = unsafe { slice(call, "unknowns", unknowns.0, unknowns.1) }?;
        // SAFETY: by the caller.
        let knowns = unsafe { slice(call, "knowns", knowns.0, knowns.1) }?;
        // The importer may pass the same array for both.
        // SAFETY: by the caller.
        let seed = unsafe { slice(call, "seed", seed, seed_length) }?.to_vec();
        // SAFETY: by the caller.
        let sensitivity = unsafe { slice_mut(call, "sensitivity", sensitivity, sensitivity_length) }?;
        i.directional_derivative(call, [unknowns, knowns], &seed, sensitivity)
    })
}

/// `fmi3GetFMUState`; a handle that is not null must belong to a saved state, which is overwritten.
///
/// # Safety
/// As FMI 3.0 demands of importers.
pub unsafe fn get_fmu_state<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    state: *mut Handle,
) -> Status {
    instances.call(call, instance.addr(), |i, _| {
        // SAFETY: by the caller.
        let state = unsafe { place(call, "FMUState", state) }?;
        let handle = match state.addr() {
            0 => instances.new_handle(),
            known if i.has_state(known) => known,
            _ => return Err(ExportError::UnknownState { call }),
        };
        i.save_state(handle)?;
        *state = std::ptr::without_provenance_mut(handle);
        Ok(())
    })
}

/// `fmi3SetFMUState`.
pub fn set_fmu_state<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    state: Handle,
) -> Status {
    instances.call(call, instance.addr(), |i, _| i.restore_state(call, state.addr()))
}

/// `fmi3FreeFMUState`; a null pointer or null handle is ignored, any other handle is set to null.
///
/// # Safety
/// As FMI 3.0 demands of importers.
pub unsafe fn free_fmu_state<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    state: *mut Handle,
) -> Status {
    instances.call(call, instance.addr(), |i, _| {
        if state.is_null() {
            return Ok(());
        }
        // SAFETY: by the caller.
        let state = unsafe { place(call, "FMUState", state) }?;
        if !state.is_null() {
            i.free_state(call, state.addr())?;
            *state = std::ptr::null_mut();
        }
        Ok(())
    })
}

/// `fmi3SerializedFMUStateSize`.
///
/// # Safety
/// As FMI 3.0 demands of importers.
pub unsafe fn serialized_fmu_state_size<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    state: Handle,
    size: *mut usize,
) -> Status {
    instances.call(call, instance.addr(), |i, _| {
        // SAFETY: by the caller.
        *unsafe { place(call, "size", size) }? = i.serialise_state(call, state.addr())?.len();
        Ok(())
    })
}

/// `fmi3SerializeFMUState`.
///
/// # Safety
/// As FMI 3.0 demands of importers.
pub unsafe fn serialize_fmu_state<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    state: Handle,
    (bytes, size): (*mut u8, usize),
) -> Status {
    instances.call(call, instance.addr(), |i, _| {
        // SAFETY: by the caller.
        let room = unsafe { slice_mut(call, "serializedState", bytes, size) }?;
        let written = i.serialise_state(call, state.addr())?;
        if written.len() != size {
            return Err(ExportError::StateSize { expected: written.len(), found: size });
        }
        room.copy_from_slice(&written);
        Ok(())
    })
}

/// `fmi3DeserializeFMUState`; the handle of a saved state is reused, any other is replaced.
///
/// # Safety
/// As FMI 3.0 demands of importers.
pub unsafe fn deserialize_fmu_state<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    (bytes, size): (*const u8, usize),
    state: *mut Handle,
) -> Status {
    instances.call(call, instance.addr(), |i, _| {
        // SAFETY: by the caller.
        let bytes = unsafe { slice(call, "serializedState", bytes, size) }?;
        // SAFETY: by the caller.
        let state = unsafe { place(call, "FMUState", state) }?;
        let handle = if i.has_state(state.addr()) { state.addr() } else { instances.new_handle() };
        i.deserialise_state(bytes, handle)?;
        *state = std::ptr::without_provenance_mut(handle);
        Ok(())
    })
}
