//! Films on disk, `.hdf`: checkpoints of a render, and parts of it from several machines.
//!
//! All numbers are little-endian. A file is the magic bytes, a version, the length of the header and the header as JSON
//! ([`FilmHeader`]), its level (not a number if there is none), the seconds, the number of tiles that have samples, and
//! for each its index, its samples, those that are not numbers, whether it has pixels that see nothing, its sums of 128
//! bits, pixel by pixel, the hits of first samples, and for each pixel of its Cryptomatte layers the number of names,
//! their ids and sums; in the end the XXH3 hash of all that. A file that is cut off, changed or of another kind is
//! refused.

use super::bytes::Bytes;
use super::cryptomatte::Coverage;
use super::sum::{PositiveSum, Sum};
use super::tile::{BadSamples, FEATURE_NAMES, FirstHit, Pixel, Tile};
use super::{Film, FilmError, FilmHeader};
use crate::settings::Settings;

/// The extension of films.
pub const FILM_EXTENSION: &str = "hdf";

const MAGIC: [u8; 8] = *b"halfdFLM";
const VERSION: u32 = 4;
const CHECKSUM: usize = 8;
/// In place of the row of the first sample that is not a number, if there is none.
const NONE: u32 = u32::MAX;

impl Film {
    /// The film as a file's bytes.
    pub fn encode(&self) -> Vec<u8> {
        let header = serde_json::to_vec(&self.header).unwrap_or_default();
        let mut out = Vec::with_capacity(64 + header.len() + self.sums() * 16);
        out.extend(MAGIC);
        out.extend(VERSION.to_le_bytes());
        out.extend((header.len() as u32).to_le_bytes());
        out.extend(header);
        out.extend(self.header.level.unwrap_or(f64::NAN).to_le_bytes());
        out.extend(super::Metadata::stored_seconds(self.seconds).to_le_bytes());
        let tiles = || (0_u32..).zip(&self.tiles).filter(|(_, tile)| !tile.samples.is_empty());
        out.extend((tiles().count() as u32).to_le_bytes());
        for (number, tile) in tiles() {
            let (row, column) = tile.bad.first.unwrap_or((NONE, NONE));
            let has_uncovered = u32::from(!tile.uncovered.is_empty());
            for word in [number, tile.samples.start, tile.samples.end, row, column, has_uncovered] {
                out.extend(word.to_le_bytes());
            }
            out.extend(tile.bad.count.to_le_bytes());
            tile.clone().visit(&mut |sum| out.extend(sum.to_le_bytes()));
            for FirstHit { sample, depth, ids, motion } in &tile.first_hits {
                let words = [*sample, depth.to_bits()].into_iter().chain(*ids).chain(motion.map(f32::to_bits));
                words.for_each(|word| out.extend(word.to_le_bytes()));
            }
            for Coverage(names) in tile.mattes.iter().flatten() {
                out.extend((names.len() as u32).to_le_bytes());
                for (id, weight) in names {
                    out.extend(id.to_le_bytes());
                    out.extend(weight.0.to_le_bytes());
                }
            }
        }
        out.extend(xxhash_rust::xxh3::xxh3_64(&out).to_le_bytes());
        out
    }

    /// The film in a file's bytes.
    ///
    /// # Errors
    /// If they are no film, cut off or damaged, or made by a newer version.
    pub fn decode(bytes: &[u8]) -> Result<Self, FilmError> {
        const AGAIN: &str = "name a film (.hdf) that `halfdome render` wrote";
        let cut = || FilmError::new("is cut off or damaged: its checksum is wrong", "render this part again");
        if !bytes.starts_with(&MAGIC) {
            return Err(FilmError::new("is no film", AGAIN));
        }
        let mut reader = Bytes(&bytes[MAGIC.len()..]);
        let version = reader.word().ok_or_else(cut)?;
        if version != VERSION {
            let problem = format!("is a film of format {version}, and this program reads format {VERSION}");
            return Err(FilmError::new(problem, "use the version of halfdome that wrote it"));
        }
        let (contents, checksum) = bytes.split_last_chunk::<CHECKSUM>().ok_or_else(cut)?;
        if xxhash_rust::xxh3::xxh3_64(contents) != u64::from_le_bytes(*checksum) {
            return Err(cut());
        }
        let mut reader = Bytes(&contents[MAGIC.len() + 4..]);
        reader.film().ok_or_else(|| FilmError::new("is damaged: its contents do not fit together", AGAIN))
    }

    /// An estimate of the 128-bit sums that it has.
    fn sums(&self) -> usize {
        let extras = 4 * usize::from(self.header.halves) + (FEATURE_NAMES.len() + 3) * usize::from(self.header.aov);
        self.header.width as usize * self.header.height as usize * (4 + extras)
    }
}

impl Bytes<'_> {
    fn film(&mut self) -> Option<Film> {
        let length = self.word()? as usize;
        let mut header: FilmHeader = serde_json::from_slice(self.slice(length)?).ok()?;
        header.level = Some(f64::from_le_bytes(self.array()?)).filter(|level| !level.is_nan());
        Settings::check_pixels(header.width, header.height).ok().filter(|()| header.width > 0 && header.height > 0)?;
        let mut film = Film::new(header);
        film.seconds = f64::from(f32::from_le_bytes(self.array()?));
        let mut next = 0;
        for _ in 0..self.word()? {
            let number = self.word()?;
            // In their order, so that each is there once.
            let tile = film.tiles.get_mut(number as usize).filter(|_| number >= next)?;
            next = number + 1;
            self.tile(tile)?;
        }
        self.0.is_empty().then_some(film)
    }

    fn tile(&mut self, tile: &mut Tile) -> Option<()> {
        let [start, end, row, column, has_uncovered] =
            [self.word()?, self.word()?, self.word()?, self.word()?, self.word()?];
        let count = self.long()?;
        tile.samples = (start < end).then_some(start..end)?;
        tile.bad = BadSamples { count, first: (row != NONE).then_some((row, column)) };
        if has_uncovered == 1 {
            tile.uncovered = vec![Sum::default(); tile.pixels.len()];
        }
        let mut is_whole = true;
        tile.visit(&mut |sum| match self.array() {
            Some(bytes) => *sum = i128::from_le_bytes(bytes),
            None => is_whole = false,
        });
        for hit in &mut tile.first_hits {
            let (sample, depth) = (self.word()?, f32::from_bits(self.word()?));
            let ids = [self.word()?, self.word()?, self.word()?, self.word()?];
            let motion = [self.word()?, self.word()?].map(f32::from_bits);
            *hit = FirstHit { sample, depth, ids, motion };
        }
        for Coverage(names) in tile.mattes.iter_mut().flatten() {
            for _ in 0..self.word()? {
                let (id, weight) = (self.word()?, Sum(i128::from_le_bytes(self.array()?)));
                // In their order, so that each is there once.
                names.last().is_none_or(|&(last, _)| last < id).then(|| names.push((id, weight)))?;
            }
        }
        is_whole.then_some(())
    }
}

impl Tile {
    /// Visits all its sums in their order in a file.
    fn visit(&mut self, visit: &mut dyn FnMut(&mut i128)) {
        for Pixel { weight, radiance } in self.pixels.iter_mut().chain(&mut self.halves) {
            visit(&mut weight.0);
            radiance.iter_mut().for_each(|sum| visit(&mut sum.0));
        }
        self.features.iter_mut().flatten().for_each(|sum| visit(&mut sum.0));
        self.light.iter_mut().flatten().flatten().for_each(|sum| visit(&mut sum.0));
        for PositiveSum(sum) in self.squares.iter_mut().flatten() {
            let mut signed = *sum as i128;
            visit(&mut signed);
            *sum = signed as u128;
        }
        self.uncovered.iter_mut().for_each(|sum| visit(&mut sum.0));
    }
}
