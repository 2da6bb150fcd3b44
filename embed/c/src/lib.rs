//! halfdome's kernel for C: functions and structures of which cbindgen makes `include/halfdome.h`.
//!
//! All `unsafe` here is about pointers from C, of which `border` makes slices and references. A function's failure or
//! panic becomes an `hd_status` in `status`, so that nothing unwinds into C.
//!
//! Names are C's, with the prefix `hd_`, as they stand in the header.
#![allow(non_camel_case_types, reason = "names as they stand in the header")]
#![allow(clippy::missing_safety_doc, reason = "the header's first lines say what holds of all pointers")]

mod border;

// In the order of the header.
pub mod status;

pub mod mesh;

pub mod tree;

pub mod trace;

pub mod blob;

pub mod moving;

pub mod round;

pub mod scene;

pub mod scene_blob;

pub mod changes;

pub mod query;

pub mod proximity;
