//! Between C and the instance: pointers checked, panics caught, errors told to the importer's logger.
//!
//! What an importer holds as instance is a number of a living one, not an address: a pointer that was freed,
//! or never was one, is answered with an error and never followed.

#![expect(
    unsafe_code,
    reason = "arrays and strings of the importer are read and written through its pointers"
)]

use crate::instance::{CallError, Instance, Status};
use crate::phase::Phase;
use crate::saved::InstanceState;
use std::collections::BTreeMap;
use std::ffi::{CStr, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Things of one kind that the importer refers to by handles.
pub struct Handles<T> {
    alive: Mutex<(usize, BTreeMap<usize, T>)>,
}

impl<T> Handles<T> {
    const fn new() -> Self {
        Self { alive: Mutex::new((0, BTreeMap::new())) }
    }

    fn lock(&self) -> MutexGuard<'_, (usize, BTreeMap<usize, T>)> {
        // Nothing under this lock runs code that could leave it half changed.
        self.alive.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps a thing, and gives its handle, which is not null and never given again.
    pub fn keep(&self, thing: T) -> *mut c_void {
        let mut alive = self.lock();
        alive.0 += 1;
        // As an aligned address: some importers look at the low bits.
        let handle = alive.0 * 16;
        alive.1.insert(handle, thing);
        handle as *mut c_void
    }

    /// Ends a thing; nothing where the handle is none.
    pub fn release(&self, handle: *mut c_void) -> Option<T> {
        self.lock().1.remove(&(handle as usize))
    }
}

impl<T: Clone> Handles<T> {
    /// The thing of a handle.
    pub fn get(&self, handle: *mut c_void) -> Option<T> {
        self.lock().1.get(&(handle as usize)).cloned()
    }
}

/// An instance that may be called from any thread, one call at a time.
pub struct Shared(Mutex<Instance>);

// SAFETY: the one part of an instance that is bound to nothing by itself is the importer's logger. Both
// standards allow calls of one instance from different threads, though not at the same time, so its logger
// must bear that.
unsafe impl Send for Shared {}
// SAFETY: as above; the mutex keeps calls apart even if an importer does not.
unsafe impl Sync for Shared {}

/// All living instances.
static INSTANCES: Handles<Arc<Shared>> = Handles::new();
/// All saved states.
static STATES: Handles<Arc<InstanceState>> = Handles::new();

/// Makes an instance; null where it cannot be made, after the logger was told.
pub fn instantiate(
    make: impl FnOnce() -> Result<Instance, CallError>,
    tell: impl Fn(Status, &str),
) -> *mut c_void {
    match catch_unwind(AssertUnwindSafe(make)) {
        Ok(Ok(instance)) => INSTANCES.keep(Arc::new(Shared(Mutex::new(instance)))),
        Ok(Err(error)) => {
            tell(Status::Error, &error.to_string());
            std::ptr::null_mut()
        }
        Err(panic) => {
            tell(Status::Fatal, &format!("panic while instantiating: {}", words(panic.as_ref())));
            std::ptr::null_mut()
        }
    }
}

/// Ends an instance. One that is none is left alone.
pub fn free(handle: *mut c_void) {
    let _ = catch_unwind(AssertUnwindSafe(|| drop(INSTANCES.release(handle))));
}

/// Calls an instance in one of the phases in which `function` is allowed.
pub fn call(
    handle: *mut c_void,
    function: &'static str,
    phases: &[Phase],
    body: impl FnOnce(&mut Instance) -> Result<(), CallError>,
) -> i32 {
    let Some(shared) = INSTANCES.get(handle) else { return Status::Error as i32 };
    let mut instance = shared.0.lock().unwrap_or_else(PoisonError::into_inner);
    let result = catch_unwind(AssertUnwindSafe(|| {
        instance.expect(function, phases)?;
        body(&mut instance)
    }));
    let message = match result {
        Ok(Ok(())) => return Status::Ok as i32,
        Ok(Err(error)) => format!("{function}: {error}"),
        Err(panic) => {
            instance.break_down();
            format!("{function}: panic: {}", words(panic.as_ref()))
        }
    };
    instance.say(Status::Error, &message);
    Status::Error as i32
}

fn words(panic: &(dyn std::any::Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("without words")
}

/// An array of the importer.
///
/// # Safety
/// `pointer` is null or points at `length` values that live and do not change during the call.
pub unsafe fn array<'a, T>(
    pointer: *const T,
    length: usize,
    what: &'static str,
) -> Result<&'a [T], CallError> {
    if length == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() {
        return Err(CallError::Null { what });
    }
    // SAFETY: as the caller promises.
    Ok(unsafe { std::slice::from_raw_parts(pointer, length) })
}

/// An array of the importer, to write.
///
/// # Safety
/// `pointer` is null or points at `length` values that nobody else uses during the call.
pub unsafe fn array_mut<'a, T>(
    pointer: *mut T,
    length: usize,
    what: &'static str,
) -> Result<&'a mut [T], CallError> {
    if length == 0 {
        return Ok(&mut []);
    }
    if pointer.is_null() {
        return Err(CallError::Null { what });
    }
    // SAFETY: as the caller promises.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, length) })
}

/// Sets a value of the importer; one it does not want has a null pointer.
///
/// # Safety
/// `pointer` is null or points at a value that nobody else uses during the call.
pub unsafe fn set<T>(pointer: *mut T, value: T) {
    if !pointer.is_null() {
        // SAFETY: as the caller promises.
        unsafe { pointer.write(value) };
    }
}

/// A text of the importer.
///
/// # Safety
/// `pointer` is null or points at a text that ends with a zero and lives during the call.
pub unsafe fn text<'a>(pointer: *const c_char, what: &'static str) -> Result<&'a str, CallError> {
    if pointer.is_null() {
        return Err(CallError::Null { what });
    }
    // SAFETY: as the caller promises.
    unsafe { CStr::from_ptr(pointer) }.to_str().map_err(|_| CallError::Text { what })
}

/// A kept state.
pub fn saved(state: *mut c_void) -> Result<Arc<InstanceState>, CallError> {
    STATES.get(state).ok_or(CallError::Null { what: "the state (freed, or never given)" })
}

/// Keeps the state of an instance, and puts its handle in `place`; a state that the place holds already is
/// replaced, as both standards allow.
pub fn keep_at(place: &mut [*mut c_void], state: InstanceState) {
    let _ = STATES.release(place[0]);
    place[0] = STATES.keep(Arc::new(state));
}

/// Lets a kept state go, and clears its place.
pub fn release_at(place: &mut [*mut c_void]) {
    let _ = STATES.release(place[0]);
    place[0] = std::ptr::null_mut();
}

/// The functions that both standards have under names of their own, with the same arguments: the end of an
/// instance's life, and its states.
macro_rules! common_functions {
    ($free:ident $exit_initialization:ident $terminate:ident $reset:ident
     $get_state:ident $set_state:ident $free_state:ident $state_size:ident $serialize:ident $deserialize:ident) => {
        #[unsafe(no_mangle)]
        extern "C" fn $free(instance: Handle) {
            $crate::boundary::free(instance);
        }

        #[unsafe(no_mangle)]
        extern "C" fn $exit_initialization(instance: Handle) -> i32 {
            call(instance, stringify!($exit_initialization), &[Phase::Initialization], Instance::begin_steps)
        }

        #[unsafe(no_mangle)]
        extern "C" fn $terminate(instance: Handle) -> i32 {
            call(instance, stringify!($terminate), &[Phase::Step, Phase::Broken], |instance| {
                instance.enter(Phase::Terminated);
                Ok(())
            })
        }

        #[unsafe(no_mangle)]
        extern "C" fn $reset(instance: Handle) -> i32 {
            call(instance, stringify!($reset), &Phase::ALL, Instance::reset)
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $get_state(instance: Handle, place: *mut Handle) -> i32 {
            call(instance, stringify!($get_state), &Phase::SOUND, |instance| {
                let state = instance.save()?;
                // SAFETY: a place of the importer for a handle.
                $crate::boundary::keep_at(unsafe { array_mut(place, 1, "the place for the state")? }, state);
                Ok(())
            })
        }

        #[unsafe(no_mangle)]
        extern "C" fn $set_state(instance: Handle, state: Handle) -> i32 {
            let restore = |instance: &mut Instance| instance.restore(&*$crate::boundary::saved(state)?);
            call(instance, stringify!($set_state), &Phase::ALL, restore)
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $free_state(instance: Handle, place: *mut Handle) -> i32 {
            call(instance, stringify!($free_state), &Phase::ALL, |_| {
                // SAFETY: a place of the importer for a handle.
                $crate::boundary::release_at(unsafe { array_mut(place, 1, "the place of the state")? });
                Ok(())
            })
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $state_size(instance: Handle, state: Handle, size: *mut usize) -> i32 {
            call(instance, stringify!($state_size), &Phase::SOUND, |instance| {
                let length = instance.serialize(&*$crate::boundary::saved(state)?).len();
                // SAFETY: a place of the importer for a number.
                unsafe { $crate::boundary::set(size, length) };
                Ok(())
            })
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $serialize(instance: Handle, state: Handle, bytes: *mut u8, size: usize) -> i32 {
            call(instance, stringify!($serialize), &Phase::SOUND, |instance| {
                let serialized = instance.serialize(&*$crate::boundary::saved(state)?);
                if serialized.len() != size {
                    return Err(CallError::Length { found: size, expected: serialized.len() });
                }
                // SAFETY: an array of the importer, of the length it says.
                unsafe { array_mut(bytes, size, "serializedState")? }.copy_from_slice(&serialized);
                Ok(())
            })
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $deserialize(
            instance: Handle,
            bytes: *const u8,
            size: usize,
            place: *mut Handle,
        ) -> i32 {
            call(instance, stringify!($deserialize), &Phase::SOUND, |instance| {
                // SAFETY: an array of the importer, of the length it says, and a place for a handle.
                let (bytes, place) = unsafe {
                    (array(bytes, size, "serializedState")?, array_mut(place, 1, "the place for the state")?)
                };
                $crate::boundary::keep_at(place, instance.deserialize(bytes)?);
                Ok(())
            })
        }
    };
}
pub(crate) use common_functions;
