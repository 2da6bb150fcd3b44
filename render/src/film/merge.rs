//! Adds up the parts of one picture.

use std::ops::Range;

use super::tile::{Pixel, Tile};
use super::{Film, FilmError};

/// Parts of one picture as they come, in any order.
#[derive(Debug, Default)]
pub struct Merger {
    sum: Option<Film>,
    /// The names of the parts in messages.
    names: Vec<String>,
    /// The samples of each tile, and the parts that they come from.
    ranges: Vec<Vec<(Range<u32>, usize)>>,
}

impl Merger {
    /// Adds a part.
    ///
    /// # Errors
    /// If it is of another picture than the first, or has samples that another part has too.
    pub fn add(&mut self, name: String, part: Film) -> Result<(), FilmError> {
        let number = self.names.len();
        let Some(sum) = &mut self.sum else {
            self.ranges = part.tiles.iter().map(|tile| has(tile, number)).collect();
            self.sum = Some(part);
            self.names.push(name);
            return Ok(());
        };
        part.header.check(&sum.header).map_err(|error| error.naming(&name))?;
        for (tile, ranges) in part.tiles.iter().zip(&self.ranges) {
            let common = |(range, owner): &(Range<u32>, usize)| {
                let common = range.start.max(tile.samples.start)..range.end.min(tile.samples.end);
                (!common.is_empty()).then(|| overlap(tile, &common, (&self.names[*owner], &name)))
            };
            if let Some(error) = ranges.iter().find_map(common) {
                return Err(error);
            }
        }
        for ((tile, other), ranges) in sum.tiles.iter_mut().zip(&part.tiles).zip(&mut self.ranges) {
            ranges.extend(has(other, number));
            tile.add_tile(other);
        }
        sum.header.level = sum.header.level.or(part.header.level);
        sum.seconds += part.seconds;
        self.names.push(name);
        Ok(())
    }

    /// The sum of all parts, and what is missing; `None` without parts.
    pub fn finish(self) -> Option<(Film, Missing)> {
        let mut sum = self.sum?;
        let mut missing = Missing { tiles: 0, of: sum.tiles.len(), first: None };
        for (tile, mut ranges) in sum.tiles.iter_mut().zip(self.ranges) {
            ranges.sort_unstable_by_key(|(range, _)| range.start);
            let mut end = 0;
            let mut is_whole = !ranges.is_empty();
            for (range, _) in &ranges {
                is_whole &= range.start == end;
                end = range.end;
            }
            if !is_whole {
                missing.tiles += 1;
                missing.first = missing.first.or(Some(tile.extent()));
            }
            tile.samples = ranges.first().map_or(0, |(range, _)| range.start)..end;
        }
        Some((sum, missing))
    }
}

/// The missing parts of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// Tiles without samples, or with a gap in them.
    pub tiles: usize,
    /// Tiles of the picture.
    pub of: usize,
    /// The columns and rows of the first one.
    pub first: Option<(Range<u32>, Range<u32>)>,
}

/// The samples of a tile, if it has any, and their owner.
fn has(tile: &Tile, owner: usize) -> Vec<(Range<u32>, usize)> {
    if tile.samples.is_empty() { Vec::new() } else { vec![(tile.samples.clone(), owner)] }
}

fn overlap(tile: &Tile, common: &Range<u32>, (one, other): (&str, &str)) -> FilmError {
    let (x, y) = tile.extent();
    let problem = format!(
        "{one} and {other} both have the samples {}..{} of the pixels {}..{} by {}..{}",
        common.start, common.end, x.start, x.end, y.start, y.end
    );
    FilmError::new(problem, "leave one of them out, or render all shards with the same N")
}

impl Tile {
    /// Adds all that another tile of the same pixels has, but for which samples these are.
    fn add_tile(&mut self, other: &Self) {
        let pixels = |sums: &mut [Pixel], others: &[Pixel]| {
            for (sum, other) in sums.iter_mut().zip(others) {
                sum.weight.merge(other.weight);
                sum.radiance.iter_mut().zip(other.radiance).for_each(|(sum, other)| sum.merge(other));
            }
        };
        pixels(&mut self.pixels, &other.pixels);
        pixels(&mut self.halves, &other.halves);
        for (sums, others) in self.features.iter_mut().zip(&other.features) {
            sums.iter_mut().zip(others).for_each(|(sum, other)| sum.merge(*other));
        }
        for (pixel, &hit) in other.first_hits.iter().enumerate() {
            self.add_hit(pixel, hit);
        }
        for (sums, others) in self.squares.iter_mut().zip(&other.squares) {
            sums.iter_mut().zip(others).for_each(|(sum, other)| sum.merge(*other));
        }
        for (sums, others) in self.light.iter_mut().flatten().zip(other.light.iter().flatten()) {
            sums.iter_mut().zip(others).for_each(|(sum, other)| sum.merge(*other));
        }
        for (sums, others) in self.mattes.iter_mut().flatten().zip(other.mattes.iter().flatten()) {
            sums.merge(others);
        }
        if !other.uncovered.is_empty() {
            self.uncovered.resize(self.pixels.len(), Default::default());
            self.uncovered.iter_mut().zip(&other.uncovered).for_each(|(sum, other)| sum.merge(*other));
        }
        self.bad = self.bad.and(other.bad);
    }
}
