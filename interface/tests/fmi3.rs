//! The C functions as an importer calls them, on a unit that can be made to fail.
#![allow(unsafe_code)] // it calls C functions

use cofferdam_unit::export::fmi3::{Handle, Status, Text};
use cofferdam_unit::export::{Contents, FILE, Record, element};
use cofferdam_unit::variables::TIME;
use cofferdam_unit::variables::reservoir::{
    ALL, FIDELITY, GROUND_ACCELERATION, SOUND_SPEED, TOTAL_FORCE, WATER_DENSITY,
};
use cofferdam_unit::{CallError, Capabilities, CoSimulation, Fingerprint, Packable, Variable, open, seal};
use std::collections::BTreeMap;
use std::ffi::{CStr, CString, c_void};
use std::num::NonZeroUsize;
use std::ptr::{null, null_mut};
use std::sync::Mutex;

/// Integrates its input with factor `gain`; logs each step, and panics when it steps beyond 1 s.
struct Integrator {
    gain: f64,
    /// Input (two values, the second never negative), integral, whether it is initialised.
    state: [f64; 4],
}

impl CoSimulation for Integrator {
    type State = [f64; 4];
    type Error = CallError;

    fn name(&self) -> &'static str {
        Self::NAME
    }
    fn variables(&self) -> &'static [Variable] {
        ALL
    }
    fn size(&self, variable: &Variable) -> usize {
        Self::size_for(&self.gain, variable)
    }
    fn fingerprint(&self) -> Fingerprint {
        Fingerprint::of(Self::NAME, &self.gain).expect("a number is hashed")
    }
    fn capabilities(&self) -> Capabilities {
        Self::capabilities_for(&self.gain)
    }
    fn initialise(&mut self, _start_time: f64) -> Result<(), CallError> {
        self.state[3] = 1.0;
        Ok(())
    }
    fn set(&mut self, reference: u32, values: &[f64]) -> Result<(), CallError> {
        if values[1] < 0.0 {
            return Err(CallError::UnknownVariable { unit: Self::NAME, value_reference: reference });
        }
        self.state[..2].copy_from_slice(values);
        Ok(())
    }
    fn step(&mut self, time: f64, communication_step: f64) -> Result<(), CallError> {
        assert!(time < 1.0, "beyond one second");
        tracing::info!("a step");
        self.state[2] += self.gain * self.state[0] * communication_step;
        Ok(())
    }
    fn get(&self, reference: u32, values: &mut [f64]) -> Result<(), CallError> {
        match reference {
            FORCE if self.state[3] == 0.0 => {
                let stage = cofferdam_unit::Stage::Instantiated;
                return Err(CallError::Order { unit: Self::NAME, call: "get", stage });
            }
            FORCE => values[0] = self.state[2] + self.state[0],
            KIND => values[0] = 3.0,
            _ => values.copy_from_slice(&self.state[..2]),
        }
        Ok(())
    }
    fn save_state(&self) -> [f64; 4] {
        self.state
    }
    fn restore_state(&mut self, state: &[f64; 4]) -> Result<(), CallError> {
        self.state = *state;
        Ok(())
    }
    fn serialise_state(&self, state: &[f64; 4]) -> Result<Vec<u8>, CallError> {
        Ok(seal(self.fingerprint(), state)?)
    }
    fn deserialise_state(&self, bytes: &[u8]) -> Result<[f64; 4], CallError> {
        Ok(open(self.fingerprint(), bytes)?)
    }
    fn directional_derivative(
        &self,
        _unknown: u32,
        _known: u32,
        seed: &[f64],
        sensitivity: &mut [f64],
    ) -> Result<(), CallError> {
        sensitivity[0] = self.gain * seed[0];
        Ok(())
    }
}

impl Packable for Integrator {
    type Parameters = f64;
    const NAME: &'static str = "integrator";
    const DESCRIPTION: &'static str = "An integrator";
    const VARIABLES: &'static [Variable] =
        &[GROUND_ACCELERATION, TOTAL_FORCE, WATER_DENSITY, SOUND_SPEED, FIDELITY];

    fn from_parameters(gain: f64, _threads: NonZeroUsize) -> Result<Self, CallError> {
        assert!(gain > 0.0, "no gain");
        Ok(Self { gain, state: [0.0; 4] })
    }
    fn size_for(_gain: &f64, variable: &Variable) -> usize {
        if *variable == GROUND_ACCELERATION { 2 } else { 1 }
    }
    fn capabilities_for(_gain: &f64) -> Capabilities {
        Capabilities { variable_communication_step: true, directional_derivative: true, saved_state: true }
    }
    fn numbers<'a>(gain: &'a mut f64, variable: &Variable) -> Vec<&'a mut f64> {
        if *variable == WATER_DENSITY { vec![gain] } else { Vec::new() }
    }
}

cofferdam_unit::export_fmi!(Integrator);

const FORCE: u32 = TOTAL_FORCE.value_reference;
const INPUT: u32 = GROUND_ACCELERATION.value_reference;
const GAIN: u32 = WATER_DENSITY.value_reference;
/// Of no variable.
const NONE: u32 = 4711;
/// An integer.
const KIND: u32 = FIDELITY.value_reference;

/// Messages of the FMU: status, category, text.
#[derive(Default)]
struct Said(Mutex<Vec<(Status, [String; 2])>>);

impl Said {
    fn last(&self) -> (Status, [String; 2]) {
        self.0.lock().expect("nobody panicked").pop().expect("something was said")
    }

    fn last_text(&self) -> String {
        let (_, [_, text]) = self.last();
        text
    }
}

/// Adds a message of the FMU to the [`Said`] to which the environment points.
unsafe extern "C" fn listen(environment: *mut c_void, status: Status, category: Text, message: Text) {
    // SAFETY: every test passes such an environment, and strings come from the FMU.
    let (said, category, message) =
        unsafe { (&*environment.cast::<Said>(), CStr::from_ptr(category), CStr::from_ptr(message)) };
    let texts = [category, message].map(|text| text.to_string_lossy().into_owned());
    said.0.lock().expect("nobody panicked").push((status, texts));
}

/// A folder of resources, its token, and the messages.
struct Importer {
    folder: tempfile::TempDir,
    token: CString,
    said: Said,
}

impl Importer {
    fn new(gain: f64) -> Self {
        let start = BTreeMap::from([(GROUND_ACCELERATION.name.to_owned(), vec![2.0, 0.0])]);
        Self::of(&Contents { start, parameters: gain, records: Vec::new() })
    }

    fn of(contents: &Contents<f64>) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join(FILE), contents.to_toml().expect("TOML")).expect("a file");
        let token = CString::new(contents.token::<Integrator>().expect("a token")).expect("no NUL");
        Self { folder, token, said: Said::default() }
    }

    fn environment(&self) -> *mut c_void {
        (&raw const self.said).cast_mut().cast()
    }

    fn try_instantiate(&self, token: &CStr) -> Handle {
        let resources = CString::new(self.folder.path().to_str().expect("UTF-8")).expect("no NUL");
        let (name, token, resources) = (c"one".as_ptr(), token.as_ptr(), resources.as_ptr());
        let environment = self.environment();
        let log = Some(listen as _);
        // SAFETY: all pointers live during the call; the environment as long as the importer.
        unsafe {
            fmi3InstantiateCoSimulation(
                name,
                token,
                resources,
                0,
                1,
                0,
                0,
                null(),
                0,
                environment,
                log,
                null(),
            )
        }
    }

    fn instantiate(&self) -> Handle {
        let instance = self.try_instantiate(&self.token);
        assert!(!instance.is_null(), "{:?}", self.said.last());
        instance
    }

    fn in_step_mode(&self) -> Handle {
        let instance = self.instantiate();
        assert_eq!(enter_initialization(instance), Status::Ok);
        // SAFETY: no pointer but the handle.
        assert_eq!(unsafe { fmi3ExitInitializationMode(instance) }, Status::Ok);
        instance
    }
}

fn enter_initialization(instance: Handle) -> Status {
    // SAFETY: no pointer but the handle.
    unsafe { fmi3EnterInitializationMode(instance, 0, 0.0, 0.0, 0, 0.0) }
}

fn get(instance: Handle, reference: u32) -> Result<f64, Status> {
    let mut value = [f64::NAN; 2];
    let size = if reference == INPUT { 2 } else { 1 };
    // SAFETY: both arrays live during the call.
    match unsafe { fmi3GetFloat64(instance, &raw const reference, 1, value.as_mut_ptr(), size) } {
        Status::Ok => Ok(value[0]),
        status => Err(status),
    }
}

fn set(instance: Handle, reference: u32, values: &[f64]) -> Status {
    // SAFETY: both arrays live during the call.
    unsafe { fmi3SetFloat64(instance, &raw const reference, 1, values.as_ptr(), values.len()) }
}

fn step(instance: Handle, time: f64) -> Status {
    let (mut flags, mut end) = ([9u8; 3], 0.0);
    let [event, terminate, early] = flags.each_mut();
    // SAFETY: all places live during the call.
    let status = unsafe { fmi3DoStep(instance, time, 0.5, 0, event, terminate, early, &raw mut end) };
    if status == Status::Ok {
        assert_eq!((flags, end), ([0; 3], time + 0.5));
    }
    status
}

#[test]
fn only_the_functions_of_its_type_read_and_set_a_variable() {
    let importer = Importer::new(3.0);
    let instance = importer.in_step_mode();
    let (mut whole, mut real, mut flag, single) = (0, 0.0, 0, element(KIND, 0));
    let (mut flag_of_fmi2, real_of_fmi2) = (0, element(FORCE, 0));
    // SAFETY: all places live during the calls.
    unsafe {
        assert_eq!(fmi3GetInt32(instance, &KIND, 1, &raw mut whole, 1), Status::Ok);
        assert_eq!(whole, 3);
        whole = 0;
        assert_eq!(fmi2GetInteger(instance, &raw const single, 1, &raw mut whole), Status::Ok);
        assert_eq!(whole, 3);
        for (status, text) in [
            (
                fmi3GetFloat64(instance, &KIND, 1, &raw mut real, 1),
                "fmi3GetFloat64: `fidelity` is of type Int32; use fmi3GetInt32",
            ),
            (
                fmi3GetBoolean(instance, &FORCE, 1, &raw mut flag, 1),
                "fmi3GetBoolean: `total_force` is of type Float64; use fmi3GetFloat64",
            ),
            (
                fmi3SetInt32(instance, &GAIN, 1, &raw const whole, 1),
                "fmi3SetInt32: `water_density` is of type Float64; use fmi3SetFloat64",
            ),
            (
                fmi2GetReal(instance, &raw const single, 1, &raw mut real),
                "fmi2GetReal: `fidelity` is of type Integer; use fmi2GetInteger",
            ),
            (
                fmi2GetBoolean(instance, &raw const real_of_fmi2, 1, &raw mut flag_of_fmi2),
                "fmi2GetBoolean: `total_force` is of type Real; use fmi2GetReal",
            ),
            (fmi3GetInt32(instance, &TIME, 1, &raw mut whole, 1), "`time` is of type Float64"),
            (fmi3SetInt32(instance, &KIND, 1, &raw const whole, 1), "`fidelity` cannot be set"),
            (fmi3GetInt32(instance, &NONE, 1, &raw mut whole, 1), "no variable has value reference 4711"),
        ]
        .into_iter()
        .rev()
        {
            // The last message was said last.
            assert_eq!(status, Status::Error, "{text}");
            let found = importer.said.last_text();
            assert!(found.contains(text), "{found}");
        }
        fmi3FreeInstance(instance);
    }
    assert_eq!((real, flag, flag_of_fmi2), (0.0, 0, 0), "nothing was written");
}

#[test]
fn start_values_and_parameters_hold_and_reset_brings_them_back() {
    let importer = Importer::new(3.0);
    let instance = importer.instantiate();
    assert_eq!((get(instance, INPUT), get(instance, GAIN)), (Ok(2.0), Ok(3.0)));
    assert_eq!(set(instance, GAIN, &[5.0]), Status::Ok);
    assert_eq!(get(instance, FORCE), Err(Status::Error), "there are no outputs yet");
    assert_eq!(enter_initialization(instance), Status::Ok);
    assert_eq!(get(instance, FORCE), Ok(2.0), "on trial");
    assert_eq!(set(instance, INPUT, &[4.0, 0.0]), Status::Ok);
    assert_eq!(get(instance, FORCE), Ok(4.0), "on trial once more");
    assert_eq!(set(instance, GAIN, &[7.0]), Status::Ok, "the unit is made again, its input stays");
    // SAFETY: no pointers but the handle.
    unsafe {
        assert_eq!(fmi3ExitInitializationMode(instance), Status::Ok);
        assert_eq!(step(instance, 0.0), Status::Ok);
        assert_eq!((get(instance, FORCE), get(instance, 0)), (Ok(18.0), Ok(0.5)));
        assert_eq!(set(instance, GAIN, &[8.0]), Status::Error);
        assert!(importer.said.last_text().contains("not allowed in Step Mode"));
        assert_eq!(fmi3Terminate(instance), Status::Ok);
        assert_eq!((get(instance, FORCE), set(instance, INPUT, &[1.0, 0.0])), (Ok(18.0), Status::Error));
        assert_eq!(fmi3Reset(instance), Status::Ok);
        assert_eq!(
            (get(instance, INPUT), get(instance, GAIN), get(instance, 0)),
            (Ok(2.0), Ok(3.0), Ok(0.0))
        );
        fmi3FreeInstance(instance);
    }
}

#[test]
fn a_record_drives_an_input_that_no_importer_sees() {
    let record = |component, samples: &[f64]| Record {
        input: GROUND_ACCELERATION.name.to_owned(),
        component,
        interval: 0.5,
        samples: samples.to_vec(),
        held: false,
    };
    let records = vec![record(0, &[1.0, 3.0, -2.0]), record(1, &[0.0, 5.0])];
    let importer = Importer::of(&Contents { start: BTreeMap::new(), parameters: 2.0, records });
    let instance = importer.instantiate();
    assert_eq!(
        (get(instance, INPUT), set(instance, INPUT, &[9.0, 9.0])),
        (Err(Status::Error), Status::Error)
    );
    assert_eq!(enter_initialization(instance), Status::Ok);
    assert_eq!(get(instance, FORCE), Ok(1.0), "the record at the start");
    assert_eq!(set(instance, GAIN, &[4.0]), Status::Ok, "the unit is made again, its record stays");
    assert_eq!(get(instance, FORCE), Ok(1.0));
    // SAFETY: no pointers but the handle.
    unsafe {
        assert_eq!(fmi3ExitInitializationMode(instance), Status::Ok);
        // Each step has the record's value at its end: 3, then −2.
        assert_eq!((step(instance, 0.0), get(instance, FORCE)), (Status::Ok, Ok(4.0 * 3.0 * 0.5 + 3.0)));
        assert_eq!((step(instance, 0.5), get(instance, FORCE)), (Status::Ok, Ok(4.0 * 0.5 - 2.0)));
        assert_eq!(fmi3Reset(instance), Status::Ok);
        assert_eq!(enter_initialization(instance), Status::Ok);
        assert_eq!(get(instance, FORCE), Ok(1.0), "from the start again");
        fmi3FreeInstance(instance);
    }
}

#[test]
fn a_panic_ends_at_the_border_and_only_its_instance_is_lost() {
    let importer = Importer::new(1.0);
    let [broken, sound] = [importer.in_step_mode(), importer.in_step_mode()];
    assert_eq!(step(broken, 1.0), Status::Fatal);
    assert!(importer.said.last_text().contains("fmi3DoStep failed: beyond one second"));
    assert_eq!(get(broken, FORCE), Err(Status::Fatal));
    assert!(importer.said.last_text().contains("failed in an earlier call"));
    assert_eq!(step(sound, 0.0), Status::Ok);
    let other = Importer::new(-1.0);
    let unmade = other.instantiate();
    assert_eq!(enter_initialization(unmade), Status::Fatal);
    assert!(other.said.last_text().contains("no gain"));
    for instance in [broken, sound, unmade] {
        // SAFETY: no pointer but the handle.
        unsafe { fmi3FreeInstance(instance) };
    }
}

#[test]
fn handles_are_never_followed() {
    let importer = Importer::new(1.0);
    let instance = importer.in_step_mode();
    let nonsense: Handle = std::ptr::without_provenance_mut(0xdead_beef);
    // SAFETY: all arguments other than handles live during the call.
    unsafe {
        for wrong in [null_mut(), nonsense] {
            assert_eq!(step(wrong, 0.0), Status::Error);
            assert_eq!(get(wrong, FORCE), Err(Status::Error));
            assert_eq!(fmi3Reset(wrong), Status::Error);
            assert_eq!(fmi3SetFMUState(instance, wrong), Status::Error);
            fmi3FreeInstance(wrong);
        }
        let mut state: Handle = nonsense;
        assert_eq!(fmi3GetFMUState(instance, &raw mut state), Status::Error);
        state = null_mut();
        assert_eq!(fmi3FreeFMUState(instance, &raw mut state), Status::Ok);
        assert_eq!(fmi3FreeFMUState(instance, null_mut()), Status::Ok);
        assert_eq!(fmi3GetFMUState(instance, &raw mut state), Status::Ok);
        let (first, other) = (state, importer.in_step_mode());
        assert_eq!(fmi3GetFMUState(instance, &raw mut state), Status::Ok);
        assert_eq!(state, first, "a handle is used again");
        assert_eq!(fmi3SetFMUState(other, state), Status::Error, "of another instance");
        assert_eq!(fmi3FreeFMUState(instance, &raw mut state), Status::Ok);
        assert!(state.is_null());
        assert_eq!(fmi3SetFMUState(instance, first), Status::Error, "freed");
        fmi3FreeInstance(instance);
        assert_eq!(get(instance, FORCE), Err(Status::Error), "freed");
    }
}

#[test]
fn a_refused_set_changes_nothing() {
    let importer = Importer::new(3.0);
    let instance = importer.instantiate();
    assert_eq!(enter_initialization(instance), Status::Ok);
    let set = |references: &[u32], values: &[f64]| {
        // SAFETY: both arrays live during the call.
        unsafe {
            fmi3SetFloat64(instance, references.as_ptr(), references.len(), values.as_ptr(), values.len())
        }
    };
    for (references, values) in [
        (&[INPUT, GAIN][..], &[9.0, 9.0, f64::NAN][..]),
        (&[GAIN, INPUT], &[9.0, f64::INFINITY, 0.0]),
        (&[INPUT, FORCE], &[9.0, 9.0, 9.0]),
        (&[INPUT, 0], &[9.0, 9.0, 9.0]),
        (&[INPUT, SOUND_SPEED.value_reference], &[9.0, 9.0, 9.0]),
        // The unit itself refuses this one.
        (&[GAIN, INPUT, INPUT], &[9.0, 9.0, 9.0, 9.0, -1.0]),
    ] {
        assert_eq!(set(references, values), Status::Error, "{references:?}");
        assert_eq!((get(instance, INPUT), get(instance, GAIN)), (Ok(2.0), Ok(3.0)), "{references:?}");
    }
    assert_eq!(set(&[GAIN, INPUT], &[9.0, 8.0, 7.0]), Status::Ok);
    assert_eq!((get(instance, INPUT), get(instance, GAIN)), (Ok(8.0), Ok(9.0)));
    // SAFETY: no pointer but the handle.
    unsafe { fmi3FreeInstance(instance) };
}

#[test]
fn a_state_brings_its_parameters_its_mode_and_its_time() {
    let importer = Importer::new(3.0);
    let instance = importer.instantiate();
    assert_eq!(set(instance, GAIN, &[5.0]), Status::Ok);
    let (mut before, mut after, mut size) = (null_mut(), null_mut(), 0);
    let all = |instance| (get(instance, FORCE), get(instance, GAIN), get(instance, 0));
    // SAFETY: all arguments other than handles live during the call.
    unsafe {
        assert_eq!(enter_initialization(instance), Status::Ok);
        assert_eq!(fmi3GetFMUState(instance, &raw mut before), Status::Ok);
        assert_eq!(fmi3ExitInitializationMode(instance), Status::Ok);
        assert_eq!(step(instance, 0.0), Status::Ok);
        assert_eq!(fmi3GetFMUState(instance, &raw mut after), Status::Ok);
        let expected = (Ok(7.0), Ok(5.0), Ok(0.5));
        assert_eq!(all(instance), expected);
        assert_eq!(fmi3SerializedFMUStateSize(instance, after, &raw mut size), Status::Ok);
        let mut bytes = vec![0; size];
        assert_eq!(fmi3SerializeFMUState(instance, after, bytes.as_mut_ptr(), size - 1), Status::Error);
        assert!(importer.said.last_text().contains("take its size from the FMU (SerializedFMUStateSize)"));
        assert_eq!(fmi3SerializeFMUState(instance, after, bytes.as_mut_ptr(), size), Status::Ok);

        assert_eq!(fmi3Reset(instance), Status::Ok);
        assert_eq!(get(instance, GAIN), Ok(3.0));
        assert_eq!(fmi3SetFMUState(instance, after), Status::Ok);
        assert_eq!(all(instance), expected, "over a reset");
        assert_eq!(fmi3Terminate(instance), Status::Ok);
        assert_eq!(fmi3SetFMUState(instance, before), Status::Ok);
        assert_eq!(step(instance, 0.0), Status::Error, "it is in Initialization Mode again");
        assert_eq!(fmi3ExitInitializationMode(instance), Status::Ok);
        assert_eq!(step(instance, 0.0), Status::Ok);
        assert_eq!(all(instance), expected);

        let other = importer.instantiate();
        let mut read: Handle = std::ptr::without_provenance_mut(77);
        assert_eq!(fmi3DeserializeFMUState(other, bytes.as_ptr(), size, &raw mut read), Status::Ok);
        assert_eq!(fmi3SetFMUState(other, read), Status::Ok);
        assert_eq!(all(other), expected, "in another instance, of other parameters");
        assert_eq!(fmi3SerializedFMUStateSize(other, read, &raw mut size), Status::Ok);
        let mut again = vec![0; size];
        assert_eq!(fmi3SerializeFMUState(other, read, again.as_mut_ptr(), size), Status::Ok);
        assert!(again == bytes);
        for position in 0..size {
            again[position] ^= 1;
            assert_eq!(fmi3DeserializeFMUState(other, again.as_ptr(), size, &raw mut read), Status::Error);
            again[position] ^= 1;
        }
        let stranger = Importer::new(4.0);
        let elsewhere = stranger.instantiate();
        assert_eq!(fmi3DeserializeFMUState(elsewhere, bytes.as_ptr(), size, &raw mut read), Status::Error);
        assert!(stranger.said.last_text().contains("belongs to another unit or scene"));
        [instance, other, elsewhere].into_iter().for_each(|instance| fmi3FreeInstance(instance));
    }
}

#[test]
fn no_step_passes_the_stop_time_and_a_refused_one_says_where_the_instance_stands() {
    let importer = Importer::new(1.0);
    let instance = importer.instantiate();
    let (mut flags, mut end) = ([0u8; 3], f64::NAN);
    let [event, terminate, early] = flags.each_mut().map(std::ptr::from_mut);
    // SAFETY: all places live during the call.
    unsafe {
        for (start, stop) in [(f64::NAN, 1.0), (0.0, f64::NAN), (1.0, 0.5)] {
            assert_eq!(fmi3EnterInitializationMode(instance, 0, 0.0, start, 1, stop), Status::Error);
        }
        assert_eq!(fmi3EnterInitializationMode(instance, 0, 0.0, 0.0, 1, 0.5), Status::Ok);
        assert_eq!(fmi3ExitInitializationMode(instance), Status::Ok);
        assert_eq!(step(instance, 0.0), Status::Ok);
        let status = fmi3DoStep(instance, 0.5, 0.5, 0, event, terminate, early, &raw mut end);
        assert_eq!((status, end), (Status::Error, 0.5));
        assert!(importer.said.last_text().contains("passes the stop time of 0.5 s"));
        // It belongs to the state, after a reset and in another instance.
        let (mut state, mut size) = (null_mut(), 0);
        assert_eq!(fmi3GetFMUState(instance, &raw mut state), Status::Ok);
        assert_eq!(fmi3SerializedFMUStateSize(instance, state, &raw mut size), Status::Ok);
        let mut bytes = vec![0; size];
        assert_eq!(fmi3SerializeFMUState(instance, state, bytes.as_mut_ptr(), size), Status::Ok);
        let (other, mut read) = (importer.instantiate(), null_mut());
        assert_eq!(fmi3DeserializeFMUState(other, bytes.as_ptr(), size, &raw mut read), Status::Ok);
        assert_eq!(fmi3Reset(instance), Status::Ok);
        for (instance, state) in [(instance, state), (other, read)] {
            assert_eq!(fmi3SetFMUState(instance, state), Status::Ok);
            let status = fmi3DoStep(instance, 0.5, 0.5, 0, event, terminate, early, &raw mut end);
            assert_eq!((status, end), (Status::Error, 0.5));
            fmi3FreeInstance(instance);
        }
    }
}

#[test]
fn the_seed_may_be_where_the_sensitivity_goes() {
    let importer = Importer::new(3.0);
    let instance = importer.in_step_mode();
    let mut both = [2.0, 0.0];
    let place = both.as_mut_ptr();
    let (force, input) = (FORCE, INPUT);
    // SAFETY: all places live during the call.
    let status = unsafe {
        fmi3GetDirectionalDerivative(instance, &raw const force, 1, &raw const input, 1, place, 2, place, 1)
    };
    assert_eq!((status, both[0]), (Status::Ok, 6.0));
    // SAFETY: no pointer but the handle.
    unsafe { fmi3FreeInstance(instance) };
}

#[test]
fn instances_of_one_library_run_at_once() {
    let importer = Importer::new(1.0);
    let sums: Vec<f64> = std::thread::scope(|scope| {
        let run = |n: u32| {
            let importer = &importer;
            move || {
                let instance = importer.in_step_mode();
                assert_eq!(set(instance, INPUT, &[f64::from(n), 0.0]), Status::Ok);
                (0..500).for_each(|_| assert_eq!(step(instance, 0.0), Status::Ok));
                get(instance, FORCE).expect("a force")
            }
        };
        let threads: Vec<_> = (1..5).map(|n| scope.spawn(run(n))).collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
    });
    assert_eq!(sums, [251.0, 502.0, 753.0, 1004.0]);
}

#[test]
fn null_and_misaligned_pointers_are_refused_and_empty_arrays_are_not() {
    let importer = Importer::new(1.0);
    let instance = importer.in_step_mode();
    let (force, mut value) = (FORCE, [0.0f64; 2]);
    let reference = &raw const force;
    let room = value.as_mut_ptr();
    let crooked = room.cast::<u8>().wrapping_add(1).cast::<f64>();
    // SAFETY: pointers that are neither null nor misaligned are valid during the call.
    unsafe {
        assert_eq!(fmi3GetFloat64(instance, null(), 0, null_mut(), 0), Status::Ok);
        assert_eq!(fmi3GetUInt64(instance, null(), 0), Status::Ok);
        assert_eq!(fmi3GetUInt64(instance, reference, 1), Status::Error);
        assert_eq!(fmi3GetFloat64(instance, null(), 1, room, 1), Status::Error);
        assert!(importer.said.last_text().contains("`valueReferences` is null"));
        assert_eq!(fmi3GetFloat64(instance, reference, 1, null_mut(), 1), Status::Error);
        assert_eq!(fmi3GetFloat64(instance, reference, 1, crooked, 1), Status::Error);
        assert_eq!(fmi3GetFloat64(instance, reference, 1, room, 2), Status::Error);
        assert!(importer.said.last_text().contains("the variables have 1 values together, 2 were passed"));
        assert_eq!(fmi3SetFloat64(instance, reference, usize::MAX, room, 1), Status::Error);
        assert_eq!(fmi3GetFMUState(instance, null_mut()), Status::Error);
        let nowhere = null_mut();
        assert_eq!(fmi3DoStep(instance, 0.0, 0.5, 0, nowhere, nowhere, nowhere, null_mut()), Status::Error);
        assert_eq!(fmi3SetDebugLogging(instance, 1, 1, null()), Status::Error);
        assert_eq!(fmi3SetDebugLogging(instance, 1, 1, [c"logAll".as_ptr()].as_ptr()), Status::Error);
        assert!(importer.said.last_text().contains("no log category \"logAll\""));
        assert_eq!(get(instance, FORCE), Ok(2.0), "it stands where it stood");
        fmi3FreeInstance(instance);
    }
}

#[test]
fn what_cannot_be_instantiated_says_why() {
    let importer = Importer::new(1.0);
    assert!(importer.try_instantiate(c"another").is_null());
    let (status, [category, text]) = importer.said.last();
    assert_eq!((status, &*category), (Status::Error, "logStatusError"));
    assert!(text.contains("the instantiation token is another"), "{text}");
    let file = importer.folder.path().join(FILE);
    std::fs::write(&file, "parameters = 'none'").expect("a file");
    assert!(importer.try_instantiate(&importer.token).is_null());
    assert!(importer.said.last_text().contains("does not describe this unit"));
    std::fs::remove_file(file).expect("a file");
    assert!(importer.try_instantiate(&importer.token).is_null());
    assert!(importer.said.last_text().contains("cannot be read"));
    let (environment, log) = (importer.environment(), Some(listen as _));
    // SAFETY: null is what is tested; the environment lives.
    unsafe {
        let none = fmi3InstantiateCoSimulation(
            null(),
            null(),
            null(),
            0,
            0,
            0,
            0,
            null(),
            0,
            environment,
            log,
            null(),
        );
        assert!(none.is_null() && importer.said.last_text().contains("`instanceName` is null"));
        let none = fmi3InstantiateModelExchange(null(), null(), null(), 0, 0, environment, log);
        assert!(none.is_null() && importer.said.last_text().contains("does not offer this function"));
    }
}

#[test]
fn events_are_said_to_whom_wants_them() {
    let importer = Importer::new(1.0);
    let instance = importer.in_step_mode();
    let said = || std::mem::take(&mut *importer.said.0.lock().expect("nobody panicked")).len();
    assert_eq!((step(instance, 0.0), said()), (Status::Ok, 1));
    // SAFETY: the categories live during the call.
    unsafe {
        assert_eq!(fmi3SetDebugLogging(instance, 1, 1, [c"logStatusWarning".as_ptr()].as_ptr()), Status::Ok);
        assert_eq!((step(instance, 0.5), said()), (Status::Ok, 0));
        assert_eq!(fmi3SetDebugLogging(instance, 1, 0, null()), Status::Ok);
        assert_eq!((step(instance, 0.5), said()), (Status::Ok, 1));
        assert_eq!(fmi3SetDebugLogging(instance, 0, 0, null()), Status::Ok);
        assert_eq!((step(instance, 0.5), said()), (Status::Ok, 0));
        assert_eq!((get(instance, 77), said()), (Err(Status::Error), 1), "errors are always said");
        fmi3FreeInstance(instance);
    }
}
