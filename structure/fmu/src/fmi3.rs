//! The C functions of FMI 3.0, every one of them: what the unit does not do answers with an error and says so
//! to the logger.
//!
//! Names, order and types of arguments are those of the standard's headers `fmi3Functions.h` and
//! `fmi3PlatformTypes.h` (version 3.0).

#![expect(unsafe_code, reason = "functions with the standard's names, called from C")]

use crate::boundary::{array, array_mut, call, common_functions, instantiate, set, text};
use crate::instance::{CallError, Instance, Logger, Status};
use crate::phase::Phase;
use crate::resources::Resources;
use std::ffi::{CString, c_char, c_void};
use std::path::Path;

type Handle = *mut c_void;
type Reference = u32;
type LogMessage = unsafe extern "C" fn(*mut c_void, i32, *const c_char, *const c_char);

/// The importer's logger. Categories are the names of the standard's states.
fn logger(environment: *mut c_void, message: Option<LogMessage>) -> Logger {
    Box::new(move |status, words| {
        let Some(message) = message else { return };
        let category = if status == Status::Ok { c"logEvents" } else { c"logStatusError" };
        let words = CString::new(words.replace('\0', " ")).unwrap_or_default();
        // SAFETY: the importer's function, with the environment it came with; both texts end with a zero and
        // live during the call.
        unsafe { message(environment, status as i32, category.as_ptr(), words.as_ptr()) };
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi3SetDebugLogging(
    instance: Handle,
    on: bool,
    _count: usize,
    _categories: *const *const c_char,
) -> i32 {
    call(instance, "fmi3SetDebugLogging", &Phase::ALL, |instance| {
        instance.logging = on;
        Ok(())
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    logging: bool,
    event_mode: bool,
    _early_return: bool,
    _intermediate: *const Reference,
    intermediate_count: usize,
    environment: *mut c_void,
    message: Option<LogMessage>,
    _intermediate_update: *const c_void,
) -> Handle {
    let make = || {
        if event_mode {
            return Err(CallError::Unsupported("event mode"));
        }
        if intermediate_count > 0 {
            return Err(CallError::Unsupported("intermediate update of variables"));
        }
        // SAFETY: texts of the importer, which live during this call.
        let (token, folder) =
            unsafe { (text(token, "instantiationToken")?, text(resources, "resourcePath")?) };
        let resources = Resources::read(Path::new(folder))?;
        Instance::new(resources, token, true, logger(environment, message), logging)
    };
    instantiate(make, logger(environment, message))
}

#[unsafe(no_mangle)]
extern "C" fn fmi3InstantiateModelExchange(
    _name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: bool,
    _logging: bool,
    environment: *mut c_void,
    message: Option<LogMessage>,
) -> Handle {
    instantiate(|| Err(CallError::Unsupported("model exchange")), logger(environment, message))
}

#[unsafe(no_mangle)]
extern "C" fn fmi3InstantiateScheduledExecution(
    _name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: bool,
    _logging: bool,
    environment: *mut c_void,
    message: Option<LogMessage>,
    _clock_update: *const c_void,
    _lock: *const c_void,
    _unlock: *const c_void,
) -> Handle {
    instantiate(|| Err(CallError::Unsupported("scheduled execution")), logger(environment, message))
}

#[unsafe(no_mangle)]
extern "C" fn fmi3EnterInitializationMode(
    instance: Handle,
    _tolerance_defined: bool,
    _tolerance: f64,
    start: f64,
    _stop_defined: bool,
    _stop: f64,
) -> i32 {
    call(instance, "fmi3EnterInitializationMode", &[Phase::Instantiated], |instance| {
        instance.initialize(start)
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3EnterConfigurationMode(instance: Handle) -> i32 {
    call(instance, "fmi3EnterConfigurationMode", &[Phase::Instantiated], |instance| {
        instance.enter(Phase::Configuration);
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3ExitConfigurationMode(instance: Handle) -> i32 {
    call(instance, "fmi3ExitConfigurationMode", &[Phase::Configuration], |instance| {
        instance.enter(Phase::Instantiated);
        Ok(())
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3DoStep(
    instance: Handle,
    start: f64,
    size: f64,
    _no_state_before: bool,
    event_needed: *mut bool,
    terminate: *mut bool,
    early: *mut bool,
    last_successful: *mut f64,
) -> i32 {
    call(instance, "fmi3DoStep", &[Phase::Step], |instance| {
        // SAFETY: places of the importer for what a step gives.
        unsafe {
            set(event_needed, false);
            set(terminate, false);
            set(early, false);
            set(last_successful, start);
        }
        instance.step(start, size)?;
        // SAFETY: as above.
        unsafe { set(last_successful, start + size) };
        Ok(())
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3GetFloat64(
    instance: Handle,
    references: *const Reference,
    count: usize,
    values: *mut f64,
    value_count: usize,
) -> i32 {
    call(instance, "fmi3GetFloat64", &Phase::ALIVE, |instance| {
        // SAFETY: arrays of the importer, of the lengths it says.
        let (references, values) = unsafe {
            (array(references, count, "valueReferences")?, array_mut(values, value_count, "values")?)
        };
        instance.read(references, false, values)
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetFloat64(
    instance: Handle,
    references: *const Reference,
    count: usize,
    values: *const f64,
    value_count: usize,
) -> i32 {
    call(instance, "fmi3SetFloat64", &Phase::ALIVE, |instance| {
        // SAFETY: arrays of the importer, of the lengths it says.
        let (references, values) =
            unsafe { (array(references, count, "valueReferences")?, array(values, value_count, "values")?) };
        instance.write(references, false, values)
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3GetUInt64(
    instance: Handle,
    references: *const Reference,
    count: usize,
    values: *mut u64,
    value_count: usize,
) -> i32 {
    call(instance, "fmi3GetUInt64", &Phase::SOUND, |instance| {
        // SAFETY: arrays of the importer, of the lengths it says.
        let (references, values) = unsafe {
            (array(references, count, "valueReferences")?, array_mut(values, value_count, "values")?)
        };
        let mut numbers = vec![0.0; values.len()];
        instance.read(references, true, &mut numbers)?;
        // Counts are far below 2^53.
        values.iter_mut().zip(numbers).for_each(|(value, number)| *value = number as u64);
        Ok(())
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetUInt64(
    instance: Handle,
    references: *const Reference,
    count: usize,
    values: *const u64,
    value_count: usize,
) -> i32 {
    call(instance, "fmi3SetUInt64", &Phase::SOUND, |instance| {
        // SAFETY: arrays of the importer, of the lengths it says.
        let (references, values) =
            unsafe { (array(references, count, "valueReferences")?, array(values, value_count, "values")?) };
        let numbers: Vec<f64> = values.iter().map(|&value| value as f64).collect();
        instance.write(references, true, &numbers)
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3GetNumberOfVariableDependencies(
    instance: Handle,
    _reference: Reference,
    count: *mut usize,
) -> i32 {
    call(instance, "fmi3GetNumberOfVariableDependencies", &Phase::SOUND, |_| {
        // Outputs are those of the step's end: nothing depends on what is set at the same instant.
        // SAFETY: a place of the importer for a number.
        unsafe { set(count, 0) };
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetVariableDependencies(
    instance: Handle,
    _dependent: Reference,
    _dependent_elements: *mut usize,
    _independents: *mut Reference,
    _independent_elements: *mut usize,
    _kinds: *mut i32,
    count: usize,
) -> i32 {
    call(instance, "fmi3GetVariableDependencies", &Phase::SOUND, |_| match count {
        0 => Ok(()),
        found => Err(CallError::Length { found, expected: 0 }),
    })
}

/// Getters and setters of types that no variable has: nothing to read is no error.
macro_rules! other_types {
    ($($get:ident $set:ident $type:ty;)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $get(instance: Handle, references: *const Reference, count: usize, _values: *mut $type, _value_count: usize) -> i32 {
            no_variable(instance, stringify!($get), references, count)
        }
        #[unsafe(no_mangle)]
        extern "C" fn $set(instance: Handle, references: *const Reference, count: usize, _values: *const $type, _value_count: usize) -> i32 {
            no_variable(instance, stringify!($set), references, count)
        }
    )*};
}

other_types! {
    fmi3GetFloat32 fmi3SetFloat32 f32;
    fmi3GetInt8 fmi3SetInt8 i8;
    fmi3GetUInt8 fmi3SetUInt8 u8;
    fmi3GetInt16 fmi3SetInt16 i16;
    fmi3GetUInt16 fmi3SetUInt16 u16;
    fmi3GetInt32 fmi3SetInt32 i32;
    fmi3GetUInt32 fmi3SetUInt32 u32;
    fmi3GetInt64 fmi3SetInt64 i64;
    fmi3GetBoolean fmi3SetBoolean bool;
    fmi3GetString fmi3SetString *const c_char;
}

fn no_variable(instance: Handle, function: &'static str, references: *const Reference, count: usize) -> i32 {
    call(instance, function, &Phase::SOUND, |_| {
        // SAFETY: an array of the importer, of the length it says.
        match unsafe { array(references, count, "valueReferences")? } {
            [] => Ok(()),
            [reference, ..] => {
                Err(CallError::Reference { reference: *reference, wanted: "variable of this type" })
            }
        }
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetBinary(
    instance: Handle,
    references: *const Reference,
    count: usize,
    _sizes: *mut usize,
    _values: *mut *const u8,
    _value_count: usize,
) -> i32 {
    no_variable(instance, "fmi3GetBinary", references, count)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3SetBinary(
    instance: Handle,
    references: *const Reference,
    count: usize,
    _sizes: *const usize,
    _values: *const *const u8,
    _value_count: usize,
) -> i32 {
    no_variable(instance, "fmi3SetBinary", references, count)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetClock(
    instance: Handle,
    references: *const Reference,
    count: usize,
    _values: *mut bool,
) -> i32 {
    no_variable(instance, "fmi3GetClock", references, count)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3SetClock(
    instance: Handle,
    references: *const Reference,
    count: usize,
    _values: *const bool,
) -> i32 {
    no_variable(instance, "fmi3SetClock", references, count)
}

common_functions! {
    fmi3FreeInstance fmi3ExitInitializationMode fmi3Terminate fmi3Reset
    fmi3GetFMUState fmi3SetFMUState fmi3FreeFMUState
    fmi3SerializedFMUStateSize fmi3SerializeFMUState fmi3DeserializeFMUState
}

/// Functions that belong to what the unit is not.
macro_rules! unsupported {
    ($($function:ident ($($argument:ident: $type:ty),*);)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $function(instance: Handle $(, $argument: $type)*) -> i32 {
            $(let _ = $argument;)*
            call(instance, stringify!($function), &Phase::SOUND, |_| Err(CallError::Unsupported(stringify!($function))))
        }
    )*};
}

unsupported! {
    fmi3GetDirectionalDerivative(unknowns: *const Reference, unknown_count: usize, knowns: *const Reference, known_count: usize, seed: *const f64, seed_count: usize, sensitivity: *mut f64, sensitivity_count: usize);
    fmi3GetAdjointDerivative(unknowns: *const Reference, unknown_count: usize, knowns: *const Reference, known_count: usize, seed: *const f64, seed_count: usize, sensitivity: *mut f64, sensitivity_count: usize);
    fmi3GetOutputDerivatives(references: *const Reference, count: usize, orders: *const i32, values: *mut f64, value_count: usize);
    fmi3EnterEventMode();
    fmi3EnterStepMode();
    fmi3EnterContinuousTimeMode();
    fmi3CompletedIntegratorStep(no_state_before: bool, enter_event_mode: *mut bool, terminate: *mut bool);
    fmi3SetTime(time: f64);
    fmi3SetContinuousStates(states: *const f64, count: usize);
    fmi3GetContinuousStateDerivatives(derivatives: *mut f64, count: usize);
    fmi3GetEventIndicators(indicators: *mut f64, count: usize);
    fmi3GetContinuousStates(states: *mut f64, count: usize);
    fmi3GetNominalsOfContinuousStates(nominals: *mut f64, count: usize);
    fmi3GetNumberOfEventIndicators(count: *mut usize);
    fmi3GetNumberOfContinuousStates(count: *mut usize);
    fmi3EvaluateDiscreteStates();
    fmi3UpdateDiscreteStates(need_update: *mut bool, terminate: *mut bool, nominals_changed: *mut bool, values_changed: *mut bool, next_event_defined: *mut bool, next_event: *mut f64);
    fmi3GetIntervalDecimal(references: *const Reference, count: usize, intervals: *mut f64, qualifiers: *mut i32);
    fmi3GetIntervalFraction(references: *const Reference, count: usize, counters: *mut u64, resolutions: *mut u64, qualifiers: *mut i32);
    fmi3GetShiftDecimal(references: *const Reference, count: usize, shifts: *mut f64);
    fmi3GetShiftFraction(references: *const Reference, count: usize, counters: *mut u64, resolutions: *mut u64);
    fmi3SetIntervalDecimal(references: *const Reference, count: usize, intervals: *const f64);
    fmi3SetIntervalFraction(references: *const Reference, count: usize, counters: *const u64, resolutions: *const u64);
    fmi3SetShiftDecimal(references: *const Reference, count: usize, shifts: *const f64);
    fmi3SetShiftFraction(references: *const Reference, count: usize, counters: *const u64, resolutions: *const u64);
    fmi3ActivateModelPartition(clock: Reference, time: f64);
}
