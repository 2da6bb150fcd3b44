//! Finding the library: where the environment says, else by the names that the system's loader knows, else where
//! packages put it.

use std::env;
use std::error::Error as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::api::{Api, LoadError, Version};
use crate::device::Device;

/// The environment variable with the path of the library.
pub const VARIABLE: &str = "OIDN_LIB";

/// What the library's file is called here.
pub const FILE: &str = if cfg!(target_os = "windows") {
    "OpenImageDenoise.dll"
} else if cfg!(target_os = "macos") {
    "libOpenImageDenoise.dylib"
} else {
    "libOpenImageDenoise.so"
};

/// Names that the system's loader looks up in its own places (`LD_LIBRARY_PATH`, `PATH` and so on). Those with the
/// number of a version first: a bare name may be an older one.
#[cfg(target_os = "windows")]
const NAMES: &[&str] = &[FILE];
#[cfg(target_os = "macos")]
const NAMES: &[&str] = &["libOpenImageDenoise.2.dylib", FILE];
#[cfg(not(any(target_os = "windows", target_os = "macos")))]
const NAMES: &[&str] = &["libOpenImageDenoise.so.2", FILE];

/// Folders where packages and the archives of its makers put it, for loaders that do not look there.
#[cfg(target_os = "windows")]
const FOLDERS: &[&str] = &[r"C:\Program Files\OpenImageDenoise\bin", r"C:\Program Files\Intel\OpenImageDenoise\bin"];
#[cfg(target_os = "macos")]
const FOLDERS: &[&str] = &["/opt/homebrew/lib", "/usr/local/lib", "/opt/local/lib"];
#[cfg(not(any(target_os = "windows", target_os = "macos")))]
const FOLDERS: &[&str] =
    &["/usr/local/lib", "/usr/local/lib64", "/usr/lib64", "/usr/lib", "/usr/lib/x86_64-linux-gnu", "/opt/oidn/lib"];

/// The open library, whose CPU device has been seen to work.
#[derive(Clone)]
pub struct Library {
    api: Arc<Api>,
    path: PathBuf,
    version: Version,
}

impl Library {
    /// The library that [`VARIABLE`] names if it is set, and no other then; else the first that is found.
    ///
    /// # Errors
    /// If there is none, it is something else, is older than 2.0, or has no device on the CPU.
    pub fn find() -> Result<Self, LoadError> {
        match env::var_os(VARIABLE).filter(|path| !path.is_empty()) {
            Some(path) => Self::open(Path::new(&path)),
            None => {
                let names: Vec<PathBuf> = NAMES.iter().map(PathBuf::from).collect();
                Self::first(&names, FOLDERS)
            }
        }
    }

    /// The library at `path`; a name without a folder is looked up by the system.
    ///
    /// # Errors
    /// The errors of [`find`](Self::find).
    pub fn open(path: &Path) -> Result<Self, LoadError> {
        Self::first(&[path.to_owned()], &[])
    }

    /// The first that is right of these, and of files of these names in folders.
    fn first(names: &[PathBuf], folders: &'static [&'static str]) -> Result<Self, LoadError> {
        let paths = folders.iter().flat_map(|folder| names.iter().map(move |name| Path::new(folder).join(name)));
        let places: Vec<PathBuf> = names.iter().cloned().chain(paths.filter(|path| path.exists())).collect();
        let mut reason = String::new();
        let mut wrong = None;
        for path in &places {
            // SAFETY: opening a library runs its initialisers. It is the one that the user has named, or one by the
            // name of Open Image Denoise from folders that only the machine's administrator can write to.
            match unsafe { libloading::Library::new(path) } {
                Ok(library) => match Api::of(library, path).and_then(|api| Self::checked(api, path)) {
                    Ok(library) => return Ok(library),
                    Err(error) => wrong = wrong.or(Some(error)),
                },
                Err(error) => {
                    // The system's own words are the source's.
                    reason = error.source().map_or(error.to_string(), ToString::to_string);
                }
            }
        }
        Err(wrong.unwrap_or(LoadError::Missing { looked_for: names.to_vec(), folders, reason }))
    }

    /// Asks a device for its version, and so whether it works.
    fn checked(api: Api, path: &Path) -> Result<Self, LoadError> {
        let unknown = Version { major: 0, minor: 0, patch: 0 };
        let library = Self { api: Arc::new(api), path: path.to_owned(), version: unknown };
        let failed = |message: String| LoadError::Device { path: path.to_owned(), message };
        let number = library.device(1).map_err(|error| failed(error.to_string()))?.int(c"version");
        let version = Version { major: number / 10_000, minor: number / 100 % 100, patch: number % 100 };
        if version.major < 2 {
            return Err(LoadError::Old { path: path.to_owned(), symbol: "of version 2" });
        }
        Ok(Self { version, ..library })
    }

    /// A device on the CPU with so many threads, or as many as there are cores with 0.
    ///
    /// # Errors
    /// What the library says.
    pub fn device(&self, threads: u32) -> Result<Device, crate::FilterError> {
        Device::new(Arc::clone(&self.api), threads)
    }

    /// Where it is, or the name by which the system found it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its version, 2.0 or later.
    pub fn version(&self) -> Version {
        self.version
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_library_that_is_not_there_is_named() {
        let error = Library::open(Path::new("/nowhere/libOpenImageDenoise.so")).err().expect("it is not there");
        assert!(matches!(&error, LoadError::Missing { looked_for, .. } if looked_for.len() == 1));
        assert!(error.to_string().starts_with("looked for /nowhere/libOpenImageDenoise.so: "), "{error}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn another_library_is_refused() {
        let error = Library::open(Path::new("libc.so.6")).err().expect("it is another");
        let expected = "libc.so.6 is not Open Image Denoise: it lacks the function oidnNewDevice";
        assert_eq!(error.to_string(), expected);
    }
}
