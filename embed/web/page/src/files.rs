//! Files that were dropped on the page: without folders, by their names alone.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io;
use std::path::Path;

use halfdome::scene::Files;

/// Files by their names in small letters, as models are often written where capitals do not matter.
#[derive(Default)]
pub(crate) struct Dropped(HashMap<String, Vec<u8>>);

impl Dropped {
    pub(crate) fn add(&mut self, name: &str, bytes: Vec<u8>) {
        self.0.insert(name.to_lowercase(), bytes);
    }

    fn find(&self, path: &Path) -> Option<&[u8]> {
        let name = path.file_name()?.to_str()?.to_lowercase();
        self.0.get(&name).map(Vec::as_slice)
    }
}

impl Files for Dropped {
    fn read(&self, path: &Path) -> io::Result<Cow<'_, [u8]>> {
        self.find(path).map(Cow::Borrowed).ok_or_else(|| io::ErrorKind::NotFound.into())
    }

    fn contains(&self, path: &Path) -> bool {
        self.find(path).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_and_capitals_do_not_matter() {
        let mut files = Dropped::default();
        files.add("Chair.MTL", vec![1, 2]);
        assert_eq!(*files.read(Path::new("materials/chair.mtl")).unwrap(), [1, 2]);
        assert!(files.contains(Path::new("CHAIR.mtl")));
        assert_eq!(files.read(Path::new("table.mtl")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }
}
