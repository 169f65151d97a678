#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| windswept_fuzz::read("film", bytes));
