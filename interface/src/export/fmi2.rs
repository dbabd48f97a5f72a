//! The C functions of FMI 2.0, generic over the unit. [`export_fmi!`](crate::export_fmi) gives them their names. What both
//! versions have in common is that of [`fmi3`](super::fmi3); every variable is a scalar here, by its
//! [`element`](super::element).
//!
//! **Source**: Functional Mock-up Interface specification 2.0.4, sections 2.1 and 4.2, and its header files.
#![allow(unsafe_code)] // C calls it

use super::ExportError;
use super::fmi3::{made, text};
use super::log::{Callback, Log};
use super::pointers::{place, slice, slice_mut};
use crate::Packable;
use std::ffi::CString;
use std::path::PathBuf;

pub use super::access::{
    get_flag as get_boolean, get_float64 as get_real, get_int32 as get_integer, set_flag as set_boolean,
    set_float64 as set_real, set_int32 as set_integer,
};
pub use super::fmi3::{
    deserialize_fmu_state, exit_initialization_mode, free_fmu_state, free_instance, get_fmu_state, refuse,
    reset, serialize_fmu_state, serialized_fmu_state_size, set_fmu_state, terminate,
};
pub use super::instances::Instances;
pub use super::types::{Callbacks, Handle, Status, Text};

/// `fmi2Type` of co-simulation.
const CO_SIMULATION: i32 = 1;

/// `fmi2Instantiate`, with the arguments that this FMU uses.
///
/// # Safety
/// As FMI 2.0 demands of importers.
pub unsafe fn instantiate<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    [name, token, location]: [Text; 3],
    kind: i32,
    callbacks: *const Callbacks,
    logging: i32,
) -> Handle {
    // SAFETY: by the caller.
    let callbacks = unsafe { slice(call, "functions", callbacks, 1) }.ok().and_then(|given| given.first());
    // SAFETY: by the caller.
    let named = unsafe { text(call, "instanceName", name) };
    let owned = named.as_ref().ok().and_then(|name| CString::new(*name).ok()).unwrap_or_default();
    let callback = callbacks.and_then(|given| given.logger).map(|logger| Callback::Logger(logger, owned));
    let environment = callbacks.map_or(std::ptr::null_mut(), |given| given.environment);
    let log = Log::new(callback, environment, logging != 0);
    let instance = instances.insert(call, log, || {
        named?;
        // SAFETY: by the caller.
        let found = unsafe { text(call, "fmuGUID", token) }?;
        // SAFETY: by the caller.
        let location = unsafe { text(call, "fmuResourceLocation", location) }?;
        if callbacks.is_none() {
            return Err(ExportError::Pointer { call, argument: "functions" });
        }
        if kind != CO_SIMULATION {
            return Err(ExportError::NotOffered { call });
        }
        made(&folder(location)?, found)
    });
    instance.map_or(std::ptr::null_mut(), std::ptr::without_provenance_mut)
}

/// The folder of a `file:` URI; some importers pass its path instead.
fn folder(location: &str) -> Result<PathBuf, ExportError> {
    let refused = || ExportError::Location { found: location.to_owned() };
    let path = match location.split_once(':') {
        Some((scheme, rest)) if scheme.eq_ignore_ascii_case("file") => {
            // An authority is empty or this machine.
            let path = match rest.strip_prefix("//") {
                Some(rest) => rest.strip_prefix("localhost").unwrap_or(rest),
                None => rest,
            };
            return decoded(path).filter(|path| path.is_absolute()).ok_or_else(refused);
        }
        _ => PathBuf::from(location),
    };
    if path.is_absolute() { Ok(path) } else { Err(refused()) }
}

/// A path with its percent-encoded bytes decoded.
fn decoded(path: &str) -> Option<PathBuf> {
    let (mut bytes, mut rest) = (Vec::new(), path.as_bytes());
    while let [first, others @ ..] = rest {
        if *first == b'%' {
            let digits = std::str::from_utf8(others.get(..2)?).ok()?;
            bytes.push(u8::from_str_radix(digits, 16).ok()?);
            rest = &others[2..];
        } else {
            bytes.push(*first);
            rest = others;
        }
    }
    String::from_utf8(bytes).ok().map(PathBuf::from)
}

/// `fmi2SetDebugLogging`; an empty list means all categories.
///
/// # Safety
/// As FMI 2.0 demands of importers.
pub unsafe fn set_debug_logging<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    on: i32,
    (count, categories): (usize, *const Text),
) -> Status {
    // SAFETY: by the caller.
    unsafe {
        super::fmi3::set_debug_logging(instances, call, instance, u8::from(on != 0), (count, categories))
    }
}

/// `fmi2SetupExperiment`; the tolerance is not used.
pub fn setup_experiment<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    start_time: f64,
    (has_stop_time, stop_time): (i32, f64),
) -> Status {
    let stop_time = (has_stop_time != 0).then_some(stop_time);
    instances.call(call, instance.addr(), |i, _| i.set_experiment(call, start_time, stop_time))
}

/// `fmi2EnterInitializationMode`.
pub fn enter_initialization_mode<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
) -> Status {
    instances.call(call, instance.addr(), |i, _| i.enter_initialization_of_experiment(call))
}

/// Getters and setters of types that no variable has: they accept only an empty list of variables.
pub fn no_variable<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    references: usize,
) -> Status {
    super::fmi3::no_variable(instances, call, instance, references)
}

/// `fmi2SetRealInputDerivatives`.
///
/// # Safety
/// As FMI 2.0 demands of importers.
pub unsafe fn set_real_input_derivatives<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    (references, count): (*const u32, usize),
    orders: *const i32,
    values: *const f64,
) -> Status {
    instances.call(call, instance.addr(), |i, _| {
        // SAFETY: by the caller.
        let references = unsafe { slice(call, "vr", references, count) }?;
        // SAFETY: by the caller.
        let orders = unsafe { slice(call, "order", orders, count) }?;
        // SAFETY: by the caller.
        let values = unsafe { slice(call, "value", values, count) }?;
        i.set_slopes(call, references, orders, values)
    })
}

/// `fmi2DoStep`.
pub fn do_step<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    time: f64,
    communication_step: f64,
) -> Status {
    instances.call(call, instance.addr(), |i, _| i.step(call, time, communication_step).map(drop))
}

/// `fmi2GetRealStatus`: only the last successful time is known.
///
/// # Safety
/// As FMI 2.0 demands of importers.
pub unsafe fn get_real_status<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    kind: i32,
    value: *mut f64,
) -> Status {
    const LAST_SUCCESSFUL_TIME: i32 = 2;
    instances.call(call, instance.addr(), |i, _| {
        if kind != LAST_SUCCESSFUL_TIME {
            return Err(ExportError::NotOffered { call });
        }
        // SAFETY: by the caller.
        *unsafe { place(call, "value", value) }? = i.time();
        Ok(())
    })
}

/// `fmi2GetDirectionalDerivative`: one seed for each known, one sensitivity for each unknown.
///
/// # Safety
/// As FMI 2.0 demands of importers.
pub unsafe fn get_directional_derivative<U: Packable>(
    instances: &Instances<U>,
    call: &'static str,
    instance: Handle,
    [unknowns, knowns]: [(*const u32, usize); 2],
    seed: *const f64,
    sensitivity: *mut f64,
) -> Status {
    instances.call(call, instance.addr(), |i, _| {
        // SAFETY: by the caller.
        let unknowns = unsafe { slice(call, "vUnknown_ref", unknowns.0, unknowns.1) }?;
        // SAFETY: by the caller.
        let knowns = unsafe { slice(call, "vKnown_ref", knowns.0, knowns.1) }?;
        // The importer may pass the same array for both.
        // SAFETY: by the caller.
        let seed = unsafe { slice(call, "dvKnown", seed, knowns.len()) }?.to_vec();
        // SAFETY: by the caller.
        let sensitivity = unsafe { slice_mut(call, "dvUnknown", sensitivity, unknowns.len()) }?;
        i.directional_derivative(call, [unknowns, knowns], &seed, sensitivity)
    })
}

#[cfg(test)]
mod tests {
    use super::folder;
    use std::path::Path;

    #[test]
    fn locations_are_uris_of_local_folders_or_paths() {
        for (location, path) in [
            ("file:///tmp/a%20b/%C3%BC", "/tmp/a b/ü"),
            ("file:/tmp/fmu", "/tmp/fmu"),
            ("FILE://localhost/tmp/fmu", "/tmp/fmu"),
            ("/tmp/a%20b", "/tmp/a%20b"),
        ] {
            assert_eq!(folder(location).ok().as_deref(), Some(Path::new(path)), "{location}");
        }
        for wrong in ["", "https://host/x", "file://host/x", "file:///tmp/%2", "file:///%ff", "resources"] {
            let error = folder(wrong).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(error.contains("is no local folder"), "{wrong}: {error}");
        }
    }
}
