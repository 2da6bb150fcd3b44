//! The textures of a model whose materials name files: each file is read once.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::Vec3;

use super::{Texture, decode};
use crate::scene::{Files, SceneError};

/// Textures by their paths.
pub(crate) struct TextureStore<'a> {
    files: &'a dyn Files,
    /// The textures that have been read.
    pub(crate) list: Vec<Texture>,
    /// The number in the list of each file, or what is wrong with it.
    known: BTreeMap<PathBuf, Result<usize, Problem>>,
}

/// The problem with a texture file, and the remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Problem {
    pub(crate) problem: String,
    pub(crate) remedy: String,
}

impl<'a> TextureStore<'a> {
    /// No texture yet; further ones get numbers after those in `list`.
    pub(crate) fn new(files: &'a dyn Files, list: Vec<Texture>) -> Self {
        Self { files, list, known: BTreeMap::new() }
    }

    /// The index of the texture in the file at `path`.
    pub(crate) fn load(&mut self, path: &Path) -> Result<usize, Problem> {
        if let Some(known) = self.known.get(path) {
            return known.clone();
        }
        let found = self.read(path).map(|texture| self.add(texture));
        self.known.insert(path.to_owned(), found.clone());
        found
    }

    /// Whether there is such a file.
    pub(crate) fn contains(&self, path: &Path) -> bool {
        self.files.contains(path)
    }

    /// The index of a texture that is made here.
    pub(crate) fn add(&mut self, texture: Texture) -> usize {
        self.list.push(texture);
        self.list.len() - 1
    }

    fn read(&self, path: &Path) -> Result<Texture, Problem> {
        let name = path.display();
        let bytes = self.files.read(path).map_err(|error| {
            let SceneError { problem, remedy, .. } = SceneError::unreadable(path, &error);
            Problem { problem: format!("{name}: {problem}"), remedy }
        })?;
        decode(&bytes, Some(path))
            .map_err(|error| Problem { problem: format!("{name}: {}", error.problem), remedy: error.remedy.to_owned() })
    }
}

impl Texture {
    /// A texture of one channel with `map` of each texel's red, in 16 bits; `map` gives 0 to 1.
    pub(crate) fn mapped_red(&self, map: impl Fn(f32) -> f32) -> Self {
        let (width, height) = self.size();
        let count = width as usize * height as usize;
        let code = |index: usize| {
            let red = self.fetch(super::ColorSpace::Linear, index).x;
            (map(red).clamp(0.0, 1.0) * 65535.0).round() as u16
        };
        Self::from_texels(width, height, 1, super::Texels::U16((0..count).map(code).collect()))
    }

    /// A texture with `map` of each texel's linear colour, in 16 bits; `map` gives 0 to 1 a channel. Alpha is left out.
    pub(crate) fn mapped(&self, space: super::ColorSpace, map: impl Fn(Vec3) -> Vec3) -> Self {
        let (width, height) = self.size();
        let count = width as usize * height as usize;
        let code = |part: f32| (part.clamp(0.0, 1.0) * 65535.0).round() as u16;
        let codes = (0..count).flat_map(|index| map(self.fetch(space, index).truncate()).to_array().map(code));
        Self::from_texels(width, height, 3, super::Texels::U16(codes.collect()))
    }

    /// Whether the texels, as linear numbers, look like normals in tangent space: on average along z, and bluish.
    pub(crate) fn looks_like_normals(&self) -> bool {
        let mean = self.mean_in(super::ColorSpace::Linear);
        let is_grey = self.channels() < 3 || (mean.x - mean.z).abs() < 0.05;
        !is_grey && mean.z > 0.7 && (mean.x - 0.5).abs() < 0.15 && (mean.y - 0.5).abs() < 0.15
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ColorSpace, Texels};
    use super::*;
    use crate::scene::Disk;

    #[test]
    fn a_file_is_read_once_and_its_problem_told_each_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        image::RgbImage::from_raw(1, 1, vec![1, 2, 3]).unwrap().save(&path).unwrap();
        let mut store = TextureStore::new(&Disk, vec![Texture::new(1, 1, vec![[0; 4]])]);
        assert_eq!([store.load(&path), store.load(&path)], [Ok(1), Ok(1)]);
        assert_eq!(store.list.len(), 2);
        let missing = folder.path().join("b.png");
        let problem = store.load(&missing).unwrap_err();
        assert_eq!(store.load(&missing), Err(problem.clone()));
        assert!(problem.problem.ends_with("b.png: no such file"), "{problem:?}");
    }

    #[test]
    fn normals_are_told_from_heights() {
        let texture = |texel: [u8; 3]| Texture::from_texels(1, 1, 3, Texels::U8(texel.into()));
        assert!(texture([128, 128, 255]).looks_like_normals());
        assert!(texture([140, 120, 230]).looks_like_normals());
        assert!(!texture([128, 128, 128]).looks_like_normals());
        assert!(!texture([255, 255, 255]).looks_like_normals());
        assert!(!Texture::from_texels(1, 1, 1, Texels::U8(vec![128])).looks_like_normals());
        let doubled = texture([51, 0, 0]).mapped_red(|red| 2.0 * red);
        assert!((doubled.mean_in(ColorSpace::Linear).x - 0.4).abs() < 1e-4 && doubled.channels() == 1);
    }
}
