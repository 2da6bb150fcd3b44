//! The source of a model's files: the disk, or a program's memory.

use std::borrow::Cow;
use std::cell::RefCell;
use std::io;
use std::path::{Path, PathBuf};

/// Files by their paths. Those that a model names are asked for beside it: in the folder of its own path.
pub trait Files {
    /// The bytes of the file at `path`.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] where there is none, or what else prevents reading.
    fn read(&self, path: &Path) -> io::Result<Cow<'_, [u8]>>;

    /// Whether there is a file at `path`.
    fn contains(&self, path: &Path) -> bool;
}

/// The files of the operating system.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Files for Disk {
    fn read(&self, path: &Path) -> io::Result<Cow<'_, [u8]>> {
        std::fs::read(path).map(Cow::Owned)
    }

    fn contains(&self, path: &Path) -> bool {
        path.is_file()
    }
}

/// Files that remember which of them were read.
pub(super) struct Recorded<'f> {
    files: &'f dyn Files,
    read: RefCell<Vec<PathBuf>>,
}

impl<'f> Recorded<'f> {
    /// None is read yet.
    pub(super) fn new(files: &'f dyn Files) -> Self {
        Self { files, read: RefCell::default() }
    }

    /// The paths of the files that were read, in order.
    pub(super) fn into_paths(self) -> Vec<PathBuf> {
        self.read.into_inner()
    }
}

impl Files for Recorded<'_> {
    fn read(&self, path: &Path) -> io::Result<Cow<'_, [u8]>> {
        let bytes = self.files.read(path)?;
        self.read.borrow_mut().push(path.to_owned());
        Ok(bytes)
    }

    fn contains(&self, path: &Path) -> bool {
        self.files.contains(path)
    }
}
