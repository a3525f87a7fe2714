//! The model description of a functional mock-up unit, which is a stranger's.
#![no_main]

use fmu_host::description::Description;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Err(what) = Description::parse(text) {
        assert!(!what.is_empty());
    }
});
