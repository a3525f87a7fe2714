//! A snapshot (VTU), and a collection of them (PVD).
#![no_main]

use libfuzzer_sys::fuzz_target;
use meniscus_fuzz::file;

fuzz_target!(|bytes: &[u8]| {
    let _ = output::vtu::read(&file("fluid.vtu", bytes));
    let _ = output::pvd::read(&file("fluid.pvd", bytes));
});
