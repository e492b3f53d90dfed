#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = muspin_fuzz::formats::read("wav", bytes);
});
