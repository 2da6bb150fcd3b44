//! Trees of all qualities over triangles of any bits: valid, without a triangle that should not be missing, the same as
//! a blob, and traced to the hits of a loop over all triangles.
#![no_main]

use halfdome_fuzz::Bytes;
use halfdome_fuzz::check::check;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let triangles = bytes.triangles(100);
    let rays = bytes.rays(&triangles, 8);
    check(&triangles, &rays);
});
