//! The functions of a library of FMI 2.0.

#![allow(unsafe_code)] // functions of C, and what they call back

use super::error::FmuUnitError;
use super::instance::Said;
use cofferdam_coupling::participant::Level;
use libloading::Library;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

/// A status, whatever number a library returns.
pub type Status = c_int;
pub const OK: Status = 0;
pub const WARNING: Status = 1;
/// A saved state of an instance.
pub type State = *mut c_void;

type Component = *mut c_void;
type Text = *const c_char;

/// Which instance is wanted.
pub struct Wanted<'a> {
    pub library: &'a Path,
    /// Folder of the unpacked FMU.
    pub folder: &'a Path,
    pub name: &'a str,
    pub guid: &'a str,
    /// Whether the importer gives it memory.
    pub memory: bool,
    /// Whether its functions for states are called.
    pub states: bool,
    pub said: &'a Said,
}

/// An instance. Its state is freed with it.
pub struct Instance2 {
    component: Component,
    pub functions: Functions,
    pub states: Option<StateFunctions>,
    /// An instance may call these at any time, and may have kept the pointer alone.
    _callbacks: Box<Callbacks>,
    _said: Box<Said>,
    /// Closed last.
    _library: Library,
}

/// `fmi2CallbackFunctions`.
#[repr(C)]
struct Callbacks {
    logger: extern "C" fn(*mut c_void, Text, Status, Text, Text),
    allocate: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    free: Option<unsafe extern "C" fn(*mut c_void)>,
    step_finished: Option<unsafe extern "C" fn(*mut c_void, Status)>,
    environment: *mut c_void,
}

unsafe extern "C" {
    /// Of fmi-rs, in C: puts a function with variable arguments in place of the logger, which formats a message and passes it on
    /// to the logger of before. There is one for the whole process.
    fn add_logger_proxy(callbacks: *mut Callbacks);
}

/// Functions with the names that the standard gives them.
macro_rules! functions {
    ($(#[$doc:meta])* $set:ident { $($field:ident = $name:literal: fn($($argument:ty),*) $(-> $result:ty)?;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub struct $set { $(pub $field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)* }

        impl $set {
            /// **Errors**: the library lacks one.
            fn of(library: &Library) -> Result<Self, FmuUnitError> {
                Ok(Self { $($field: unsafe { find(library, $name) }?,)* })
            }
        }
    };
}

functions! {
    /// Those that every instance needs.
    Functions {
        instantiate = "fmi2Instantiate": fn(Text, c_int, Text, Text, *const c_void, c_int, c_int) -> Component;
        free_instance = "fmi2FreeInstance": fn(Component);
        setup_experiment = "fmi2SetupExperiment": fn(Component, c_int, f64, f64, c_int, f64) -> Status;
        enter_initialization_mode = "fmi2EnterInitializationMode": fn(Component) -> Status;
        exit_initialization_mode = "fmi2ExitInitializationMode": fn(Component) -> Status;
        get_real = "fmi2GetReal": fn(Component, *const u32, usize, *mut f64) -> Status;
        set_real = "fmi2SetReal": fn(Component, *const u32, usize, *const f64) -> Status;
        get_integer = "fmi2GetInteger": fn(Component, *const u32, usize, *mut c_int) -> Status;
        get_boolean = "fmi2GetBoolean": fn(Component, *const u32, usize, *mut c_int) -> Status;
        set_integer = "fmi2SetInteger": fn(Component, *const u32, usize, *const c_int) -> Status;
        set_boolean = "fmi2SetBoolean": fn(Component, *const u32, usize, *const c_int) -> Status;
        set_string = "fmi2SetString": fn(Component, *const u32, usize, *const Text) -> Status;
        do_step = "fmi2DoStep": fn(Component, f64, f64, c_int) -> Status;
    }
}

functions! {
    /// Those of one that saves its state.
    StateFunctions {
        get = "fmi2GetFMUstate": fn(Component, *mut State) -> Status;
        set = "fmi2SetFMUstate": fn(Component, State) -> Status;
        free = "fmi2FreeFMUstate": fn(Component, *mut State) -> Status;
        serialized_size = "fmi2SerializedFMUstateSize": fn(Component, State, *mut usize) -> Status;
        serialize = "fmi2SerializeFMUstate": fn(Component, State, *mut u8, usize) -> Status;
        deserialize = "fmi2DeSerializeFMUstate": fn(Component, *const u8, usize, *mut State) -> Status;
    }
}

/// # Safety
///
/// The function of this name is of the type `T`, a pointer to a function.
unsafe fn find<T: Copy>(library: &Library, name: &str) -> Result<T, FmuUnitError> {
    let found = unsafe { library.get::<T>(name.as_bytes()) };
    found.map(|symbol| *symbol).map_err(|_| FmuUnitError::without_function(name))
}

/// Takes a message, formatted already.
extern "C" fn log(environment: *mut c_void, _: Text, status: Status, category: Text, message: Text) {
    let text = |pointer: Text| match pointer.is_null() {
        true => String::new(),
        // A text of C, which lives at least as long as this call.
        false => unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned(),
    };
    // That of the instance, which outlives it.
    if let Some(said) = unsafe { environment.cast::<Said>().as_ref() } {
        let level = match status {
            OK => Level::Information,
            WARNING => Level::Warning,
            _ => Level::Error,
        };
        said.add(level, &text(category), &text(message));
    }
}

impl Instance2 {
    /// Loads the library and makes an instance.
    ///
    /// **Errors**: the library cannot be loaded or lacks a function; it makes no instance.
    pub fn new(wanted: &Wanted<'_>) -> Result<Self, FmuUnitError> {
        // Its constructors run, like all that it does, with the rights of this process.
        let library = unsafe { Library::new(wanted.library) };
        let library = library.map_err(|error| FmuUnitError::of_loading(&error))?;
        let functions = Functions::of(&library)?;
        let states = if wanted.states { Some(StateFunctions::of(&library)?) } else { None };
        let mut said = Box::new(wanted.said.clone());
        let mut callbacks = Box::new(Callbacks {
            logger: log,
            allocate: wanted.memory.then_some(libc::calloc),
            free: wanted.memory.then_some(libc::free),
            step_finished: None,
            environment: (&raw mut *said).cast(),
        });
        unsafe { add_logger_proxy(&raw mut *callbacks) };
        let no_instance = || FmuUnitError::NoInstance { message: wanted.said.last() };
        let text = |text: Vec<u8>| CString::new(text).map_err(|_| no_instance());
        let (name, guid) = (text(wanted.name.into())?, text(wanted.guid.into())?);
        let resources = text(url(&wanted.folder.join("resources")).into_bytes())?;
        const CO_SIMULATION: c_int = 1;
        let component = unsafe {
            let callbacks = (&raw const *callbacks).cast();
            let (visible, logging) = (0, 1);
            (functions.instantiate)(
                name.as_ptr(),
                CO_SIMULATION,
                guid.as_ptr(),
                resources.as_ptr(),
                callbacks,
                visible,
                logging,
            )
        };
        if component.is_null() {
            return Err(no_instance());
        }
        Ok(Self { component, functions, states, _callbacks: callbacks, _said: said, _library: library })
    }

    /// Its handle, with which its functions are called.
    pub fn component(&self) -> *mut c_void {
        self.component
    }
}

impl Drop for Instance2 {
    fn drop(&mut self) {
        // It exists, and is not used afterwards.
        unsafe { (self.functions.free_instance)(self.component) };
    }
}

/// A file's URL. All but letters, digits and four signs is encoded, which every reader understands.
fn url(path: &Path) -> String {
    let mut url = "file://".to_owned();
    for &byte in path.as_os_str().as_bytes() {
        match byte {
            b'/' | b'-' | b'_' | b'.' | b'~' => url.push(char::from(byte)),
            _ if byte.is_ascii_alphanumeric() => url.push(char::from(byte)),
            _ => url += &format!("%{byte:02X}"),
        }
    }
    url
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn url_of_a_path() {
        assert_eq!(url(Path::new("/tmp/a b/ü%/x_1.y")), "file:///tmp/a%20b/%C3%BC%25/x_1.y");
    }
}
