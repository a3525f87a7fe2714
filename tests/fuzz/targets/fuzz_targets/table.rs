//! A table of a run (CSV), of which the last row may be cut.
#![no_main]

use libfuzzer_sys::fuzz_target;
use meniscus_fuzz::file;

fuzz_target!(|bytes: &[u8]| {
    let path = file("windows.csv", bytes);
    if let Ok(table) = output::table::read(&path) {
        assert!(table.iter().all(|(_, values)| values.len() == table.rows()));
        let few = output::table::read_at_most(&path, 3).expect("fewer rows of a table that can be read");
        assert!(few.rows() <= table.rows());
    }
});
