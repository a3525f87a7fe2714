//! A checkpoint: opened, its header read, and its parts read as states of a structure.
#![no_main]

use libfuzzer_sys::fuzz_target;
use meniscus_fuzz::file;
use output::checkpoint::Checkpoint;
use structure::State;

fuzz_target!(|bytes: &[u8]| {
    let path = file("1.checkpoint", bytes);
    let _ = coupler::run::checkpoint::open(&path);
    if let Ok(mut checkpoint) = Checkpoint::open(&path) {
        for part in ["fluid", "structure", "coupler", "records", "header"] {
            let _ = checkpoint.part(part);
        }
    }
    // The checksum keeps a fuzzer from the states behind it.
    let _ = State::<2>::from_bytes(bytes, 4);
    let _ = State::<3>::from_bytes(bytes, 4);
});
