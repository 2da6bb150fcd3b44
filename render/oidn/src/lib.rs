//! Intel Open Image Denoise (OIDN) 2.x, found and loaded at run time: nothing of it is needed to build.
//!
//! [`Library::find`] opens the library, [`Library::device`] makes a device on the CPU, and [`Device::run`] filters an
//! image. Images are borrowed for the time of a call, and their sizes are checked here, so that the library reads and
//! writes what it may and nothing else.
//!
//! Source: the header `oidn.h` and the manual of Open Image Denoise 2.

mod api;
mod device;
mod find;

pub use api::{LoadError, Version};
pub use device::{Device, FilterError, Image, Role};
pub use find::{FILE, Library, VARIABLE};
