//! The files of a page: the master with all layers, the map that the model uses, and directional layers; and the
//! mapping of its parts to surfaces.

use std::path::Path;

use glam::{Vec2, Vec3};

use super::{Files, Ready};
use crate::bake::atlas::{NO_CHART, Part};
use crate::bake::manifest::{DirectionalEntry, PageEntry, SurfaceEntry};
use crate::bake::{Bake, BakeOptions, Directional, Preset};
use crate::cli::error::CliError;
use crate::film::{Channel, Metadata, Picture};
use crate::output::{EncodedMap, Map, Shape, Texture, encode_exr, encode_hdr, encode_ktx2, encode_ktx2_texture};
use crate::scene::{Scene, count};

/// A page, ready to be written.
pub(super) struct Encoded {
    pub(super) entry: PageEntry,
    /// All of its files.
    pub(super) files: Vec<Ready>,
    /// The bytes of the file that the model shows.
    pub(super) map: Vec<u8>,
}

impl Files {
    /// Encodes a page; irradiance is multiplied by `scale` in all but the master.
    pub(super) fn encode(
        &self,
        bake: &Bake,
        index: usize,
        options: &BakeOptions,
        scale: f32,
        warnings: &mut Vec<String>,
    ) -> Result<Encoded, CliError> {
        let (page, size) = (&bake.maps[index], bake.atlas.pages[index]);
        let master = self.page(index, "exr");
        let path = self.beside(&master);
        let bytes = encode_exr(&path, &picture(bake, index, options)).map_err(CliError::system)?;
        let mut files = vec![Ready { path, bytes: bytes.clone() }];
        let mut entry =
            PageEntry { file: master.clone(), master, directional: None, width: size.width, height: size.height };
        let Some(name) = self.map_name(index) else { return Ok(Encoded { entry, files, map: bytes }) };

        let texels: Vec<Vec3> = page.layers[0].texels.iter().map(|value| *value * scale).collect();
        let map = Map { width: size.width, height: size.height, texels: &texels };
        entry.file = name;
        let path = self.beside(&entry.file);
        let encoded = match self.preset {
            Preset::Three => encode_hdr(&path, &map),
            Preset::Bevy | Preset::Raw => encode_ktx2(&path, &map),
        };
        let map = checked(&path, encoded.map_err(CliError::system)?, warnings);
        files.push(Ready { path, bytes: map.clone() });

        if let Some(file) = self.directional_name(index, options).filter(|_| page.layers.len() > 1) {
            let layers = &page.layers[1..];
            // Irradiance for three normals; harmonics are of radiance, and have signs.
            let is_signed = options.directional == Directional::Sh1;
            let scale = if is_signed { 1.0 } else { scale };
            let texels: Vec<Vec3> = layers.iter().flat_map(|layer| &layer.texels).map(|value| *value * scale).collect();
            let shape = Shape::Layers([size.width, size.height, layers.len() as u32]);
            let texture = Texture { shape, levels: vec![&texels], is_signed };
            let path = self.beside(&file);
            let encoded = encode_ktx2_texture(&path, &texture).map_err(CliError::system)?;
            let bytes = checked(&path, encoded, warnings);
            files.push(Ready { path, bytes });
            let layers = layers.iter().map(|layer| layer.name.to_owned()).collect();
            entry.directional = Some(DirectionalEntry { file, layers });
        }
        Ok(Encoded { entry, files, map })
    }
}

/// The bytes, and a warning if something did not fit.
fn checked(path: &Path, EncodedMap { bytes, clamped }: EncodedMap, warnings: &mut Vec<String>) -> Vec<u8> {
    if clamped > 0 {
        let texels = count(clamped, "texel is", "texels are");
        warnings.push(format!("{}: {texels} brighter than the format can store, clamped", path.display()));
    }
    bytes
}

/// A page as a picture with all of its layers, and the chart of each texel, counted from 1.
fn picture(bake: &Bake, page: usize, options: &BakeOptions) -> Picture {
    let (size, map) = (bake.atlas.pages[page], &bake.maps[page]);
    let mut channels = Vec::new();
    for layer in &map.layers {
        for (i, channel) in ["R", "G", "B"].into_iter().enumerate() {
            let name = if layer.name.is_empty() { channel.to_owned() } else { format!("{}.{channel}", layer.name) };
            channels.push(Channel { name, values: layer.texels.iter().map(|value| value[i]).collect() });
        }
    }
    let chart = |&owner: &u32| if owner == NO_CHART { 0.0 } else { owner as f32 + 1.0 };
    channels.push(Channel { name: "chart".to_owned(), values: map.owners.iter().map(chart).collect() });
    let metadata = Metadata {
        samples_per_pixel: options.spp,
        seed: options.seed,
        integrator: format!("bake {}", options.mode.name()),
        ..Metadata::default()
    };
    Picture { width: size.width, height: size.height, channels, metadata }
}

/// The surfaces of each page's parts.
pub(super) fn surfaces(scene: &Scene, bake: &Bake) -> Vec<SurfaceEntry> {
    let surface = |part: &Part| {
        let mesh = &scene.meshes[part.mesh];
        let (low, high) = part.vertices.iter().fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), vertex| {
            (low.min(vertex.uv), high.max(vertex.uv))
        });
        let size = high - low;
        SurfaceEntry {
            name: mesh.name.clone(),
            node: mesh.origin.map(|origin| origin.node),
            primitive: mesh.origin.map(|origin| origin.primitive),
            page: part.page,
            rect: [low.x, low.y, size.x, size.y],
        }
    };
    bake.atlas.parts.iter().map(surface).collect()
}
