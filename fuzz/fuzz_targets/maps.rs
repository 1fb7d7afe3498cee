#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| fuzz::tried::count(fuzz::maps::run(input)));
