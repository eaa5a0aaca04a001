#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    ergopath_fuzz::targets::amc(data);
});
