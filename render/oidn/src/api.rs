//! The functions of the library that are used, with the types of `oidn.h`.

use std::ffi::{c_char, c_int, c_void};
use std::fmt;
use std::path::PathBuf;

use libloading::Library as Dynamic;

/// `OIDNDevice`, `OIDNFilter`: opaque.
pub(crate) type Handle = *mut c_void;
/// `OIDNProgressMonitorFunction`.
pub(crate) type Monitor = unsafe extern "C" fn(user: *mut c_void, done: f64) -> bool;

/// `OIDN_DEVICE_TYPE_CPU`.
pub(crate) const CPU: c_int = 1;
/// `OIDN_FORMAT_FLOAT3`.
pub(crate) const FLOAT3: c_int = 3;
/// `OIDN_ERROR_OUT_OF_MEMORY`.
pub(crate) const OUT_OF_MEMORY: c_int = 4;
/// `OIDN_ERROR_CANCELLED`.
pub(crate) const CANCELLED: c_int = 6;

/// What is called in the library, and the library itself, which stays open as long as these are used.
pub(crate) struct Api {
    pub(crate) new_device: unsafe extern "C" fn(c_int) -> Handle,
    pub(crate) set_device_int: unsafe extern "C" fn(Handle, *const c_char, c_int),
    pub(crate) get_device_int: unsafe extern "C" fn(Handle, *const c_char) -> c_int,
    pub(crate) commit_device: unsafe extern "C" fn(Handle),
    pub(crate) get_device_error: unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int,
    pub(crate) release_device: unsafe extern "C" fn(Handle),
    pub(crate) new_filter: unsafe extern "C" fn(Handle, *const c_char) -> Handle,
    pub(crate) set_shared_image:
        unsafe extern "C" fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize),
    pub(crate) set_filter_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    pub(crate) set_monitor: unsafe extern "C" fn(Handle, Option<Monitor>, *mut c_void),
    pub(crate) commit_filter: unsafe extern "C" fn(Handle),
    pub(crate) execute_filter: unsafe extern "C" fn(Handle),
    pub(crate) release_filter: unsafe extern "C" fn(Handle),
    _library: Dynamic,
}

/// A version of the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version {
    /// The first number, at least 2.
    pub major: u32,
    /// The second.
    pub minor: u32,
    /// The third.
    pub patch: u32,
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

/// Why the library cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LoadError {
    /// It is nowhere: what was looked for, and what the system said of the last.
    #[error("looked for {}{}: {reason}", names(.looked_for), in_folders(.folders))]
    Missing {
        /// A path, or names that the system looks up.
        looked_for: Vec<PathBuf>,
        /// Folders that were looked into besides.
        folders: &'static [&'static str],
        /// What the system says.
        reason: String,
    },
    /// A file that is a library, but not this one.
    #[error("{} is not Open Image Denoise: it lacks the function {symbol}", .path.display())]
    Other {
        /// The file.
        path: PathBuf,
        /// A function that every version has.
        symbol: &'static str,
    },
    /// A version before 2.
    #[error("{} is Open Image Denoise before version 2: it lacks the function {symbol}", .path.display())]
    Old {
        /// The file.
        path: PathBuf,
        /// A function that came with version 2.
        symbol: &'static str,
    },
    /// It has no device on the CPU that works here.
    #[error("{}: its CPU device does not work: {message}", .path.display())]
    Device {
        /// The file.
        path: PathBuf,
        /// What the library says.
        message: String,
    },
}

fn in_folders(folders: &[&str]) -> String {
    if folders.is_empty() { String::new() } else { format!(" where the system looks, and in {}", folders.join(", ")) }
}

fn names(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// The first symbol that is not there, without its final zero.
struct Lacks(&'static str);

impl Api {
    /// The functions of a library; `path` is for messages.
    pub(crate) fn of(library: Dynamic, path: &std::path::Path) -> Result<Self, LoadError> {
        // What version 1 has, too.
        for symbol in [c"oidnNewDevice", c"oidnNewFilter", c"oidnExecuteFilter"] {
            // SAFETY: the symbol is only looked for, and neither called nor read.
            let found = unsafe { library.get::<*const c_void>(symbol.to_bytes_with_nul()) };
            if found.is_err() {
                let symbol = symbol.to_str().unwrap_or_default();
                return Err(LoadError::Other { path: path.to_owned(), symbol });
            }
        }
        Self::functions(library).map_err(|Lacks(symbol)| LoadError::Old { path: path.to_owned(), symbol })
    }

    fn functions(library: Dynamic) -> Result<Self, Lacks> {
        macro_rules! function {
            ($name:literal) => {
                // SAFETY: the type is that of `oidn.h`, for all versions 2.x, whose functions keep their types.
                *unsafe { library.get(concat!($name, "\0").as_bytes()) }.map_err(|_| Lacks($name))?
            };
        }
        Ok(Self {
            new_device: function!("oidnNewDevice"),
            set_device_int: function!("oidnSetDeviceInt"),
            get_device_int: function!("oidnGetDeviceInt"),
            commit_device: function!("oidnCommitDevice"),
            get_device_error: function!("oidnGetDeviceError"),
            release_device: function!("oidnReleaseDevice"),
            new_filter: function!("oidnNewFilter"),
            set_shared_image: function!("oidnSetSharedFilterImage"),
            set_filter_bool: function!("oidnSetFilterBool"),
            set_monitor: function!("oidnSetFilterProgressMonitorFunction"),
            commit_filter: function!("oidnCommitFilter"),
            execute_filter: function!("oidnExecuteFilter"),
            release_filter: function!("oidnReleaseFilter"),
            _library: library,
        })
    }
}
