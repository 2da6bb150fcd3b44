//! The film: samples of pixel filters, order-independent sums of samples, and the resulting picture.
//!
//! A film may hold a part of a picture's tiles or samples. Parts of one picture add up to the whole film to the bit,
//! whichever processes made them; as files they are checkpoints and shards.

mod bytes;
mod cryptomatte;
mod file;
mod filter_sampler;
mod header;
mod merge;
mod noise;
mod picture;
mod planes;
mod sum;
#[cfg(test)]
mod tests;
mod tile;

pub(crate) use bytes::Bytes;
pub use cryptomatte::MatteLayer;
pub(crate) use cryptomatte::{NO_NAME, id};
pub use file::FILM_EXTENSION;
pub use filter_sampler::{FilterSample, FilterSampler};
pub use header::{FilmError, FilmHeader};
pub use merge::{Merger, Missing};
pub use picture::{Channel, Metadata, Picture};
pub(crate) use planes::{COLORS, is_for_denoising};
pub(crate) use sum::MAX as MAX_SAMPLE;
pub use tile::BadSamples;
pub(crate) use tile::{Extras, Features, FirstHit, TILE_SIDE, Tile, tiles};

use std::ops::Range;

use glam::DVec3;

/// The luminance of linear sRGB by its channels (Rec. 709).
pub(crate) const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// The sums of a picture's samples, of all of it or a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    pub(crate) header: FilmHeader,
    /// All tiles, in their order; those that are not this film's have no samples.
    pub(crate) tiles: Vec<Tile>,
    /// Wall-clock seconds that it took, the only part that differs between two equal renders.
    pub(crate) seconds: f64,
}

impl Film {
    /// A film without samples.
    pub(crate) fn new(header: FilmHeader) -> Self {
        let tiles = tiles(header.width, header.height, header.extras());
        Self { header, tiles, seconds: 0.0 }
    }

    /// The header of the film.
    pub fn header(&self) -> &FilmHeader {
        &self.header
    }

    /// The least and the most samples that its pixels have.
    pub fn samples(&self) -> Range<u32> {
        let counts = || self.tiles.iter().map(|tile| tile.samples.len() as u32);
        counts().min().unwrap_or(0)..counts().max().unwrap_or(0)
    }

    /// Camera samples of all pixels.
    pub fn total_samples(&self) -> u64 {
        self.tiles.iter().map(|tile| tile.samples.len() as u64 * tile.pixels().count() as u64).sum()
    }

    /// Its samples that are not numbers.
    pub fn bad_samples(&self) -> BadSamples {
        self.tiles.iter().fold(BadSamples::default(), |sum, tile| sum.and(tile.bad))
    }

    /// The picture.
    pub fn picture(&self) -> Picture {
        self.picture_of(|_| true)
    }

    /// The picture with some of its channels, by their names.
    pub fn picture_of(&self, wants: impl Fn(&str) -> bool) -> Picture {
        let FilmHeader { width, height, seed, scene_hash, world_to_camera, ref integrator, .. } = self.header;
        let metadata = Metadata {
            samples_per_pixel: self.samples().start,
            render_time_seconds: Metadata::stored_seconds(self.seconds),
            world_to_camera,
            seed,
            scene_hash,
            integrator: integrator.clone(),
            attributes: self.header.cryptomatte.iter().flat_map(MatteLayer::attributes).collect(),
        };
        Picture { width, height, channels: self.channels(&wants), metadata }
    }

    /// Whether every tile of a share has a sample, by whether the share has it; with `level`, that is known too.
    pub(crate) fn has_first_samples(&self, has: impl Fn(usize) -> bool) -> bool {
        let has_samples = |(number, tile): (usize, &Tile)| !has(number) || !tile.samples.is_empty();
        self.tiles.iter().enumerate().all(has_samples)
    }

    /// Forgets all tiles but these.
    pub(crate) fn keep(&mut self, has: impl Fn(usize) -> bool) {
        let empty = tiles(self.header.width, self.header.height, self.header.extras());
        for (number, (tile, empty)) in self.tiles.iter_mut().zip(empty).enumerate() {
            if !has(number) {
                *tile = empty;
            }
        }
    }

    /// Refuses a film whose samples begin elsewhere.
    ///
    /// # Errors
    /// If any tile's first sample is another one.
    pub(crate) fn check_first_sample(&self, first: u32) -> Result<(), FilmError> {
        match self.tiles.iter().find(|tile| !tile.samples.is_empty() && tile.samples.start != first) {
            None => Ok(()),
            Some(tile) => Err(FilmError::new(
                format!("the film begins with sample {}, not {first}", tile.samples.start),
                "resume the film of the same samples",
            )),
        }
    }
}
