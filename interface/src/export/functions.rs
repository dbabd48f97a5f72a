//! The exported names of the C functions of FMI 2.0 and 3.0.

/// Exports the C functions of FMI 2.0 and of FMI 3.0 for Co-Simulation for a [`Packable`](crate::Packable) unit.
///
/// Use it once in a library, as the names are fixed by FMI: `cofferdam_unit::export_fmi!(Unit);`.
#[macro_export]
macro_rules! export_fmi {
    ($unit:ty) => {
        $crate::export_fmi2!($unit);
        $crate::export_fmi3!($unit);
    };
}

/// The part of [`export_fmi!`] for FMI 3.0.
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi3 {
    ($unit:ty) => {
        static INSTANCES: $crate::export::fmi3::Instances<$unit> = $crate::export::fmi3::Instances::new();

        #[unsafe(no_mangle)]
        static cofferdam_unit: [u8; $crate::export::MARKER.len() + <$unit as $crate::Packable>::NAME.len() + 1] =
            $crate::export::marker(<$unit as $crate::Packable>::NAME);

        #[unsafe(no_mangle)]
        extern "C" fn fmi3GetVersion() -> *const ::core::ffi::c_char {
            c"3.0".as_ptr()
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn fmi3InstantiateCoSimulation(
            name: $crate::export::fmi3::Text,
            token: $crate::export::fmi3::Text,
            resources: $crate::export::fmi3::Text,
            _visible: u8,
            logging: u8,
            event_mode: u8,
            _early_return_allowed: u8,
            _required_intermediate_variables: *const u32,
            _count: usize,
            environment: *mut ::core::ffi::c_void,
            log_message: Option<$crate::export::fmi3::LogMessage>,
            _intermediate_update: *const ::core::ffi::c_void,
        ) -> $crate::export::fmi3::Handle {
            unsafe {
                $crate::export::fmi3::instantiate(
                    &INSTANCES,
                    "fmi3InstantiateCoSimulation",
                    [name, token, resources],
                    [logging, event_mode],
                    environment,
                    log_message,
                )
            }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn fmi3InstantiateModelExchange(
            _name: $crate::export::fmi3::Text,
            _token: $crate::export::fmi3::Text,
            _resources: $crate::export::fmi3::Text,
            _visible: u8,
            _logging: u8,
            environment: *mut ::core::ffi::c_void,
            log_message: Option<$crate::export::fmi3::LogMessage>,
        ) -> $crate::export::fmi3::Handle {
            let call = "fmi3InstantiateModelExchange";
            $crate::export::fmi3::refuse_instance(&INSTANCES, call, environment, log_message)
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn fmi3InstantiateScheduledExecution(
            _name: $crate::export::fmi3::Text,
            _token: $crate::export::fmi3::Text,
            _resources: $crate::export::fmi3::Text,
            _visible: u8,
            _logging: u8,
            environment: *mut ::core::ffi::c_void,
            log_message: Option<$crate::export::fmi3::LogMessage>,
            _clock_update: *const ::core::ffi::c_void,
            _lock_preemption: *const ::core::ffi::c_void,
            _unlock_preemption: *const ::core::ffi::c_void,
        ) -> $crate::export::fmi3::Handle {
            let call = "fmi3InstantiateScheduledExecution";
            $crate::export::fmi3::refuse_instance(&INSTANCES, call, environment, log_message)
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn fmi3FreeInstance(instance: $crate::export::fmi3::Handle) {
            $crate::export::fmi3::free_instance(&INSTANCES, instance)
        }

        $crate::fmi_functions! { fmi3 INSTANCES
            fmi3SetDebugLogging = set_debug_logging(on: u8, n: usize, categories: *const $crate::export::fmi3::Text)
                => (on, (n, categories));
            fmi3EnterInitializationMode = enter_initialization_mode(
                _tolerance_defined: u8, _tolerance: f64, start_time: f64, stop_time_defined: u8, stop_time: f64
            ) => (start_time, (stop_time_defined, stop_time));
            fmi3ExitInitializationMode = exit_initialization_mode() => ();
            fmi3Terminate = terminate() => ();
            fmi3Reset = reset() => ();
            fmi3GetFloat64 = get_float64(references: *const u32, n: usize, values: *mut f64, length: usize)
                => ((references, n), (values, length));
            fmi3SetFloat64 = set_float64(references: *const u32, n: usize, values: *const f64, length: usize)
                => ((references, n), (values, length));
            fmi3GetInt32 = get_int32(references: *const u32, n: usize, values: *mut i32, length: usize)
                => ((references, n), (values, length));
            fmi3SetInt32 = set_int32(references: *const u32, n: usize, values: *const i32, length: usize)
                => ((references, n), (values, length));
            fmi3GetBoolean = get_boolean(references: *const u32, n: usize, values: *mut u8, length: usize)
                => ((references, n), (values, length));
            fmi3SetBoolean = set_boolean(references: *const u32, n: usize, values: *const u8, length: usize)
                => ((references, n), (values, length));
            fmi3GetFMUState = get_fmu_state(state: *mut $crate::export::fmi3::Handle) => (state);
            fmi3SetFMUState = set_fmu_state(state: $crate::export::fmi3::Handle) => (state);
            fmi3FreeFMUState = free_fmu_state(state: *mut $crate::export::fmi3::Handle) => (state);
            fmi3SerializedFMUStateSize = serialized_fmu_state_size(
                state: $crate::export::fmi3::Handle, size: *mut usize
            ) => (state, size);
            fmi3SerializeFMUState = serialize_fmu_state(
                state: $crate::export::fmi3::Handle, bytes: *mut u8, size: usize
            ) => (state, (bytes, size));
            fmi3DeserializeFMUState = deserialize_fmu_state(
                bytes: *const u8, size: usize, state: *mut $crate::export::fmi3::Handle
            ) => ((bytes, size), state);
            fmi3GetDirectionalDerivative = get_directional_derivative(
                unknowns: *const u32, n_unknowns: usize, knowns: *const u32, n_knowns: usize,
                seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize
            ) => ([(unknowns, n_unknowns), (knowns, n_knowns)], (seed, n_seed), (sensitivity, n_sensitivity));
            fmi3DoStep = do_step(
                time: f64, communication_step: f64, _no_earlier_state: u8, event_handling_needed: *mut u8,
                terminate_simulation: *mut u8, early_return: *mut u8, last_successful_time: *mut f64
            ) => (
                [time, communication_step],
                [
                    ("eventHandlingNeeded", event_handling_needed),
                    ("terminateSimulation", terminate_simulation),
                    ("earlyReturn", early_return),
                ],
                last_successful_time
            );
        }

        // No variable has these types. What follows the number of references is not looked at.
        $crate::fmi_functions! { fmi3 INSTANCES
            fmi3GetFloat32 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3GetInt8 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3GetUInt8 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3GetInt16 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3GetUInt16 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3GetUInt32 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3GetInt64 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3GetUInt64 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3GetString = no_variable(_references: *const u32, n: usize) => (n);
            fmi3GetBinary = no_variable(_references: *const u32, n: usize) => (n);
            fmi3GetClock = no_variable(_references: *const u32, n: usize) => (n);
            fmi3SetFloat32 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3SetInt8 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3SetUInt8 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3SetInt16 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3SetUInt16 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3SetUInt32 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3SetInt64 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3SetUInt64 = no_variable(_references: *const u32, n: usize) => (n);
            fmi3SetString = no_variable(_references: *const u32, n: usize) => (n);
            fmi3SetBinary = no_variable(_references: *const u32, n: usize) => (n);
            fmi3SetClock = no_variable(_references: *const u32, n: usize) => (n);
            fmi3GetIntervalDecimal = no_variable(_references: *const u32, n: usize) => (n);
            fmi3GetIntervalFraction = no_variable(_references: *const u32, n: usize) => (n);
            fmi3GetShiftDecimal = no_variable(_references: *const u32, n: usize) => (n);
            fmi3GetShiftFraction = no_variable(_references: *const u32, n: usize) => (n);
            fmi3SetIntervalDecimal = no_variable(_references: *const u32, n: usize) => (n);
            fmi3SetIntervalFraction = no_variable(_references: *const u32, n: usize) => (n);
            fmi3SetShiftDecimal = no_variable(_references: *const u32, n: usize) => (n);
            fmi3SetShiftFraction = no_variable(_references: *const u32, n: usize) => (n);
            fmi3GetOutputDerivatives = no_variable(_references: *const u32, n: usize) => (n);
        }

        // Not offered. Arguments after the instance are not looked at.
        $crate::fmi_functions! { fmi3 INSTANCES
            fmi3EnterEventMode = refuse() => ();
            fmi3EnterStepMode = refuse() => ();
            fmi3EnterConfigurationMode = refuse() => ();
            fmi3ExitConfigurationMode = refuse() => ();
            fmi3GetNumberOfVariableDependencies = refuse() => ();
            fmi3GetVariableDependencies = refuse() => ();
            fmi3GetAdjointDerivative = refuse() => ();
            fmi3EvaluateDiscreteStates = refuse() => ();
            fmi3UpdateDiscreteStates = refuse() => ();
            fmi3EnterContinuousTimeMode = refuse() => ();
            fmi3CompletedIntegratorStep = refuse() => ();
            fmi3SetTime = refuse() => ();
            fmi3SetContinuousStates = refuse() => ();
            fmi3GetContinuousStateDerivatives = refuse() => ();
            fmi3GetEventIndicators = refuse() => ();
            fmi3GetContinuousStates = refuse() => ();
            fmi3GetNominalsOfContinuousStates = refuse() => ();
            fmi3GetNumberOfEventIndicators = refuse() => ();
            fmi3GetNumberOfContinuousStates = refuse() => ();
            fmi3ActivateModelPartition = refuse() => ();
        }
    };
}

/// The part of [`export_fmi!`] for FMI 2.0; its instances are those of `export_fmi3!`.
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi2 {
    ($unit:ty) => {
        #[unsafe(no_mangle)]
        extern "C" fn fmi2GetTypesPlatform() -> *const ::core::ffi::c_char {
            c"default".as_ptr()
        }

        #[unsafe(no_mangle)]
        extern "C" fn fmi2GetVersion() -> *const ::core::ffi::c_char {
            c"2.0".as_ptr()
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn fmi2Instantiate(
            name: $crate::export::fmi2::Text,
            kind: i32,
            token: $crate::export::fmi2::Text,
            location: $crate::export::fmi2::Text,
            callbacks: *const $crate::export::fmi2::Callbacks,
            _visible: i32,
            logging: i32,
        ) -> $crate::export::fmi2::Handle {
            unsafe {
                $crate::export::fmi2::instantiate(
                    &INSTANCES,
                    "fmi2Instantiate",
                    [name, token, location],
                    kind,
                    callbacks,
                    logging,
                )
            }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn fmi2FreeInstance(instance: $crate::export::fmi2::Handle) {
            $crate::export::fmi2::free_instance(&INSTANCES, instance)
        }

        $crate::fmi_functions! { fmi2 INSTANCES
            fmi2SetDebugLogging = set_debug_logging(on: i32, n: usize, categories: *const $crate::export::fmi2::Text)
                => (on, (n, categories));
            fmi2SetupExperiment = setup_experiment(
                _tolerance_defined: i32, _tolerance: f64, start_time: f64, stop_time_defined: i32, stop_time: f64
            ) => (start_time, (stop_time_defined, stop_time));
            fmi2EnterInitializationMode = enter_initialization_mode() => ();
            fmi2ExitInitializationMode = exit_initialization_mode() => ();
            fmi2Terminate = terminate() => ();
            fmi2Reset = reset() => ();
            fmi2GetReal = get_real(references: *const u32, n: usize, values: *mut f64) => ((references, n), (values, n));
            fmi2SetReal = set_real(references: *const u32, n: usize, values: *const f64) => ((references, n), (values, n));
            fmi2GetInteger = get_integer(references: *const u32, n: usize, values: *mut i32) => ((references, n), (values, n));
            fmi2SetInteger = set_integer(references: *const u32, n: usize, values: *const i32) => ((references, n), (values, n));
            fmi2GetBoolean = get_boolean(references: *const u32, n: usize, values: *mut i32) => ((references, n), (values, n));
            fmi2SetBoolean = set_boolean(references: *const u32, n: usize, values: *const i32) => ((references, n), (values, n));
            fmi2GetFMUstate = get_fmu_state(state: *mut $crate::export::fmi2::Handle) => (state);
            fmi2SetFMUstate = set_fmu_state(state: $crate::export::fmi2::Handle) => (state);
            fmi2FreeFMUstate = free_fmu_state(state: *mut $crate::export::fmi2::Handle) => (state);
            fmi2SerializedFMUstateSize = serialized_fmu_state_size(
                state: $crate::export::fmi2::Handle, size: *mut usize
            ) => (state, size);
            fmi2SerializeFMUstate = serialize_fmu_state(
                state: $crate::export::fmi2::Handle, bytes: *mut u8, size: usize
            ) => (state, (bytes, size));
            fmi2DeSerializeFMUstate = deserialize_fmu_state(
                bytes: *const u8, size: usize, state: *mut $crate::export::fmi2::Handle
            ) => ((bytes, size), state);
            fmi2GetDirectionalDerivative = get_directional_derivative(
                unknowns: *const u32, n_unknowns: usize, knowns: *const u32, n_knowns: usize,
                seed: *const f64, sensitivity: *mut f64
            ) => ([(unknowns, n_unknowns), (knowns, n_knowns)], seed, sensitivity);
            fmi2SetRealInputDerivatives = set_real_input_derivatives(
                references: *const u32, n: usize, orders: *const i32, values: *const f64
            ) => ((references, n), orders, values);
            fmi2DoStep = do_step(time: f64, communication_step: f64, _no_earlier_state: i32)
                => (time, communication_step);
            fmi2GetRealStatus = get_real_status(kind: i32, value: *mut f64) => (kind, value);
        }

        // No variable has these types. What follows the number of references is not looked at.
        $crate::fmi_functions! { fmi2 INSTANCES
            fmi2GetString = no_variable(_references: *const u32, n: usize) => (n);
            fmi2SetString = no_variable(_references: *const u32, n: usize) => (n);
            fmi2GetRealOutputDerivatives = no_variable(_references: *const u32, n: usize) => (n);
        }

        // Not offered: no step ends later. Arguments after the instance are not looked at.
        $crate::fmi_functions! { fmi2 INSTANCES
            fmi2CancelStep = refuse() => ();
            fmi2GetStatus = refuse() => ();
            fmi2GetIntegerStatus = refuse() => ();
            fmi2GetBooleanStatus = refuse() => ();
            fmi2GetStringStatus = refuse() => ();
        }
    };
}

/// C functions of an instance in a version of FMI: `name = body(arguments) => (what the body is given of them)`.
#[doc(hidden)]
#[macro_export]
macro_rules! fmi_functions {
    ($version:ident $instances:ident $(
        $name:ident = $body:ident($($argument:ident: $type:ty),* $(,)?) => ($($given:expr),*);
    )*) => {$(
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $name(
            instance: $crate::export::$version::Handle,
            $($argument: $type),*
        ) -> $crate::export::$version::Status {
            #[allow(unused_unsafe)] // some bodies are safe
            unsafe { $crate::export::$version::$body(&$instances, stringify!($name), instance, $($given),*) }
        }
    )*};
}
