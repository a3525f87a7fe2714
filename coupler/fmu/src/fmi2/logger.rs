//! The logger that a unit of FMI 2.0 calls, with a message like `printf`'s and whatever belongs into its
//! places.
//!
//! Rust cannot define a function of a variable number of arguments, and needs not: where the convention of
//! calls is that of System V on x86-64, such arguments are passed as all others are, the first of the whole
//! numbers in a register, of the others of them and of more than eight floating-point numbers on the stack. A
//! function with that many arguments of its own finds them there, and hands them to C's `vsnprintf` in the
//! form in which the convention has a list of arguments. Elsewhere a message is told with its places
//! unfilled.

use crate::unit::hear;
use std::ffi::{c_char, c_void};

/// The logger, as the standard's callbacks hold it.
pub(super) fn pointer() -> *const c_void {
    log as *const () as *const c_void
}

#[cfg(not(all(target_arch = "x86_64", unix)))]
unsafe extern "C" fn log(
    environment: *mut c_void,
    _instance: *const c_char,
    status: i32,
    _category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the unit hands back the environment it was given, and a text.
    unsafe { hear(environment, status, message) };
}

/// Arguments on the stack that a message can have.
#[cfg(all(target_arch = "x86_64", unix))]
const ON_STACK: usize = 12;
/// Longest message (bytes); more is cut.
#[cfg(all(target_arch = "x86_64", unix))]
const LONGEST: usize = 4096;

/// `va_list` of the convention: how far the registers' copies are used up, where they are, and what is on the
/// stack.
#[cfg(all(target_arch = "x86_64", unix))]
#[repr(C)]
struct Arguments {
    whole: u32,
    floating: u32,
    on_stack: *const u64,
    registers: *const u64,
}

#[cfg(all(target_arch = "x86_64", unix))]
unsafe extern "C" {
    fn vsnprintf(to: *mut c_char, size: usize, format: *const c_char, arguments: *const Arguments) -> i32;
}

#[cfg(all(target_arch = "x86_64", unix))]
unsafe extern "C" fn log(
    environment: *mut c_void,
    _instance: *const c_char,
    status: i32,
    _category: *const c_char,
    message: *const c_char,
    whole: u64,
    f0: f64,
    f1: f64,
    f2: f64,
    f3: f64,
    f4: f64,
    f5: f64,
    f6: f64,
    f7: f64,
    s0: u64,
    s1: u64,
    s2: u64,
    s3: u64,
    s4: u64,
    s5: u64,
    s6: u64,
    s7: u64,
    s8: u64,
    s9: u64,
    s10: u64,
    s11: u64,
) {
    if message.is_null() {
        return;
    }
    // Six registers of eight bytes, then eight of sixteen; five of the first are the arguments with names.
    let mut registers = [0_u64; 6 + 2 * 8];
    registers[5] = whole;
    for (index, value) in [f0, f1, f2, f3, f4, f5, f6, f7].into_iter().enumerate() {
        registers[6 + 2 * index] = value.to_bits();
    }
    let on_stack: [u64; ON_STACK] = [s0, s1, s2, s3, s4, s5, s6, s7, s8, s9, s10, s11];
    let arguments = Arguments {
        whole: 5 * 8,
        floating: 6 * 8,
        on_stack: on_stack.as_ptr(),
        registers: registers.as_ptr(),
    };
    let mut text = [0; LONGEST];
    // SAFETY: the list has the form that C's library has for one, and lives during the call; that the message
    // asks for no more than was passed is for the unit to keep, as it is in C.
    unsafe {
        vsnprintf(text.as_mut_ptr(), LONGEST, message, &raw const arguments);
        hear(environment, status, text.as_ptr());
    }
}

#[cfg(all(test, target_arch = "x86_64", unix))]
mod tests {
    use super::*;
    use crate::unit::Teller;
    use std::ffi::CStr;
    use std::path::Path;

    type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, i32, *const c_char, *const c_char, ...);

    #[test]
    fn a_message_is_told_with_its_places_filled() {
        let teller = Teller::new(Path::new("unit.fmu"));
        // SAFETY: it is called as a C function that takes any arguments, as a unit does.
        let logger: Logger = unsafe { std::mem::transmute(pointer()) };
        let name = c"unit".as_ptr();
        let told = |format: &CStr, call: &dyn Fn(*mut c_void, *const c_char)| {
            call(teller.environment(), format.as_ptr());
            teller.error("fmi2DoStep", "Error").to_string()
        };
        let said = told(c"%s of %d at %g: %s, %5.2f%%", &|environment, format| {
            let (what, where_) = (c"node", c"outside");
            // SAFETY: as above.
            unsafe {
                logger(environment, name, 3, name, format, what.as_ptr(), 7, 0.25, where_.as_ptr(), 99.5);
            }
        });
        assert!(said.ends_with("answered Error: node of 7 at 0.25: outside, 99.50%"), "{said}");
        let said = told(c"%d %d %d %d %d %d %g %g %g %g %g %g %g %g %g %s", &|environment, format| {
            let last = c"end";
            // SAFETY: as above.
            unsafe {
                logger(
                    environment,
                    name,
                    3,
                    name,
                    format,
                    1,
                    2,
                    3,
                    4,
                    5,
                    6,
                    1.5,
                    2.5,
                    3.5,
                    4.5,
                    5.5,
                    6.5,
                    7.5,
                    8.5,
                    9.5,
                    last.as_ptr(),
                );
            }
        });
        assert!(said.ends_with(": 1 2 3 4 5 6 1.5 2.5 3.5 4.5 5.5 6.5 7.5 8.5 9.5 end"), "{said}");
        let said = told(c"100 % plain", &|environment, format| {
            // SAFETY: as above.
            unsafe { logger(environment, name, 3, name, format) };
        });
        assert!(said.contains("100"), "{said}");
    }
}
