//! A case file: whatever it says, it is a case or a list of mistakes; a case as resolved reads back as itself.
#![no_main]

use interfaces::case::Case;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|text: &str| {
    let sections = [fluid::participant::SECTIONS, structure::participant::SECTIONS];
    let read = |text: &str| Case::parse(text, Path::new("case.toml"), &[], &sections);
    match read(text) {
        Ok(case) => assert_eq!(read(&case.to_toml()).map(|again| again.hash()), Ok(case.hash())),
        Err(errors) => assert!(!errors.errors.is_empty() && !errors.to_string().is_empty()),
    }
});
