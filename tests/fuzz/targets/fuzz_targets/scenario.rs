//! A scenario, and a request to a run: both are files that anybody may write.
#![no_main]

use coupler::request::Request;
use coupler::scenario::Scenario;
use coupler::status::Status;
use libfuzzer_sys::fuzz_target;
use meniscus_fuzz::{file, folder};

fuzz_target!(|bytes: &[u8]| {
    if let Err(error) = Scenario::read(&file("scenario.toml", bytes)) {
        assert!(!error.mistakes.is_empty());
    }
    file(coupler::request::FILE, bytes);
    let taken = Request::take(folder()).expect("a file was there");
    assert!(taken.map_or(true, |request| request.output_interval.is_none_or(|interval| interval > 0.0)));
    file(coupler::status::FILE, bytes);
    if let Ok(status) = Status::read(folder()) {
        assert!(!status.lines(std::time::Duration::ZERO).is_empty());
    }
});
