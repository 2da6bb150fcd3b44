//! The manifest of a bake for programs: JSON beside the maps.
//!
//! It maps parts of pages to surfaces, names the unit of the texels, and holds hashes of all inputs: a bake with the
//! same hashes need not be repeated.

use std::path::Path;

use serde::{Deserialize, Serialize};

pub use super::hashes::{Hash, Hashes};
use crate::scene::{Place, SceneError};

/// The version of the manifest's form; it changes when old readers would misunderstand a new manifest.
const VERSION: u32 = 1;

/// The results and inputs of a bake.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Manifest {
    /// The version of this form, 1.
    pub version: u32,
    /// The program that wrote it, with its version.
    pub generator: String,
    /// The model's file name.
    pub source: String,
    /// The quantity in a texel.
    pub unit: Unit,
    /// What the irradiance was multiplied by before that, 1 if by nothing.
    pub exposure: f32,
    /// The seed of the random numbers.
    pub seed: u64,
    /// Hashes of the inputs.
    pub made_from: Hashes,
    /// The pages, which [`SurfaceEntry::page`] counts from 0.
    pub pages: Vec<PageEntry>,
    /// The baked meshes.
    pub surfaces: Vec<SurfaceEntry>,
    /// All files that were written, but for the manifest.
    pub outputs: Vec<Output>,
}

/// The kind of a page's texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Unit {
    /// Irradiance, W/m².
    #[serde(rename = "E")]
    Irradiance,
    /// Irradiance over π: what a white surface sends to everywhere.
    #[serde(rename = "E/pi")]
    IrradianceOverPi,
    /// Openness from 0 to 1.
    #[serde(rename = "openness")]
    Openness,
}

/// A page of the lightmap.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PageEntry {
    /// The file that the engine reads, beside the manifest.
    pub file: String,
    /// The OpenEXR file with all layers in 32-bit floats.
    pub master: String,
    /// The directional components, for engines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub directional: Option<DirectionalEntry>,
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
}

/// The source of a page's light.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DirectionalEntry {
    /// A KTX2 array of textures in half floats, beside the manifest. Layers of `hl2` are in the unit of the page; those
    /// of `sh`, which have signs, are coefficients of radiance.
    pub file: String,
    /// The names of its layers, as [`Layer::name`](crate::bake::Layer::name) has them.
    pub layers: Vec<String>,
}

/// A mesh, or the part of one, on a page.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurfaceEntry {
    /// The mesh's name in the model, or empty.
    pub name: String,
    /// The node that shows it, if the model is a glTF file.
    pub node: Option<usize>,
    /// The index of the primitive in that node's mesh, likewise.
    pub primitive: Option<usize>,
    /// The page.
    pub page: usize,
    /// The least rectangle around it: left, top, width and height, in 0..=1 of the page. Texture coordinates are the
    /// page's own, not the rectangle's.
    pub rect: [f32; 4],
}

/// A file that was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Output {
    /// Its name, beside the manifest.
    pub file: String,
    /// FNV-1a of its bytes.
    pub hash: Hash,
}

impl Manifest {
    /// This version of this program.
    pub const GENERATOR: &str = concat!("halfdome ", env!("CARGO_PKG_VERSION"));

    /// Nothing yet, by this version of this program.
    pub fn new(source: String, unit: Unit, seed: u64, made_from: Hashes) -> Self {
        Self {
            version: VERSION,
            generator: Self::GENERATOR.to_owned(),
            source,
            unit,
            exposure: 1.0,
            seed,
            made_from,
            pages: Vec::new(),
            surfaces: Vec::new(),
            outputs: Vec::new(),
        }
    }

    /// The manifest as JSON text.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_else(|error| unreachable!("plain data: {error}")) + "\n"
    }

    /// Reads the manifest at `path`.
    ///
    /// # Errors
    /// If there is none, or if it is of another version or broken.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let text = std::fs::read(path).map_err(|error| SceneError::unreadable(path, &error))?;
        Self::parse(path, &text)
    }

    fn parse(path: &Path, text: &[u8]) -> Result<Self, SceneError> {
        #[derive(Deserialize)]
        struct Versioned {
            version: u32,
        }
        let remedy = "remove it, and bake again";
        let broken = |error: serde_json::Error| {
            let problem = format!("this is not a lightmap's manifest: {error}");
            SceneError::new(path, Place::Line(error.line()), problem, remedy)
        };
        let Versioned { version } = serde_json::from_slice(text).map_err(broken)?;
        if version != VERSION {
            let problem = format!("its version is {version}, and {VERSION} is read");
            return Err(SceneError::new(path, Place::File, problem, remedy));
        }
        serde_json::from_slice(text).map_err(broken)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manifest() -> Manifest {
        let made_from = Hashes {
            options: Hash(u64::MAX),
            meshes: vec![("wall".to_owned(), Hash(1)), ("".to_owned(), Hash(2))],
            ..Hashes::default()
        };
        let mut manifest = Manifest::new("level.glb".to_owned(), Unit::IrradianceOverPi, u64::MAX, made_from);
        let (file, master) = ("level-0.ktx2".to_owned(), "level-0.exr".to_owned());
        manifest.outputs.push(Output { file: file.clone(), hash: Hash::of(b"foobar") });
        let layers = vec!["hl2.0".to_owned(), "hl2.1".to_owned(), "hl2.2".to_owned()];
        let directional = Some(DirectionalEntry { file: "level-0.hl2.ktx2".to_owned(), layers });
        manifest.pages.push(PageEntry { file, master, directional, width: 256, height: 128 });
        let (name, rect) = ("wall".to_owned(), [0.0, 0.25, 0.1, 0.5]);
        manifest.surfaces.push(SurfaceEntry { name, node: Some(3), primitive: None, page: 0, rect });
        manifest
    }

    #[test]
    fn what_is_written_is_read() {
        let text = manifest().to_json();
        assert_eq!(Manifest::parse(Path::new("a.json"), text.as_bytes()), Ok(manifest()));
        for part in [r#""unit": "E/pi""#, r#""options": "ffffffffffffffff""#, r#""hash": "85944171f73967e8""#] {
            assert!(text.contains(part), "{part} (the last is the published FNV-1a of \"foobar\") in {text}");
        }
    }

    #[test]
    fn other_files_and_versions_are_refused() {
        let problem = |text: &str| Manifest::parse(Path::new("a.json"), text.as_bytes()).unwrap_err().problem;
        assert_eq!(problem(r#"{"version": 2}"#), "its version is 2, and 1 is read");
        assert!(problem("{}").starts_with("this is not a lightmap's manifest: missing field `version`"));
        let text = manifest().to_json().replace("85944171f73967e8", "+5944171f73967e8");
        assert!(problem(&text).contains("is not a hash of 16 hexadecimal digits"), "{}", problem(&text));
    }
}
