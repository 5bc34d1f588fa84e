//! Any bytes for the reader `threemf`: see `tests/common/readers.rs`.

#![no_main]

#[path = "../../tests/common/readers.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    readers::threemf(bytes);
});
