//! Photons are sorted into cells.
//!
//! A photon is in the cells of one level that its footprint's box meets. Of photons whose starts are close to each other in
//! a cell, it keeps the one in whose footprint its center is nearest the middle. Threads divide the cells among them, so
//! that these do not depend on threads.

use glam::{IVec3, Vec2};
use halfdome_kernel::geometry::Aabb;
use halfdome_kernel::{Isa, Task};
use rayon::prelude::*;
use smallvec::SmallVec;

use super::{ByCell, Cells, CoarseGrid, Entry, Level};
use crate::world::specular::photons::{Arrival, Emission, Photon, Place};

/// The least width of a cell, as a part of the body's radius.
const MIN_CELL_IN_RADII: f32 = 0.01;
/// The greatest extents of footprints of refracted and of reflected light, as parts of the body's radius: wider
/// footprints are faint, but flat mirrors keep their light together.
const MAX_EXTENTS: [f32; 2] = [0.5, 4.0];
/// The least width of a cell, as a part of its distance from the origin.
const MIN_CELL_IN_DISTANCES: f32 = 1e-6;
/// The most photons of a cell.
const MAX_OF_CELL: usize = 48;

/// A photon with the box that it may light.
#[derive(Debug)]
pub(in crate::world::specular::photons) struct Footprint {
    photon: Photon,
    level: i32,
    around: Aabb,
}

/// The photons of a cell, most often one.
type KeptPhotons = SmallVec<[KeptPhoton; 1]>;

/// A photon of a cell.
#[derive(Clone, Copy, Debug)]
struct KeptPhoton {
    index: u32,
    /// How far the cell's center is from the middle of the footprint.
    off: f32,
    emission: Emission,
}

impl Footprint {
    /// That of a photon that has arrived from a body of this radius, unless it is too wide.
    pub(in crate::world::specular::photons) fn new(arrival: &Arrival, radius: f32) -> Option<Self> {
        let Arrival { photon, point, extent } = *arrival;
        let greatest = extent.max_element();
        let limit = MAX_EXTENTS[usize::from(photon.reflection.is_some())] * radius;
        if greatest.is_nan() || greatest > limit {
            return None;
        }
        // Cells far from the origin are no narrower than a few roundings of their coordinates.
        let least = (MIN_CELL_IN_RADII * radius).max(MIN_CELL_IN_DISTANCES * point.abs().max_element());
        let level = greatest.max(least).log2().floor() as i32;
        Some(Self { photon, level, around: Aabb { min: point - extent, max: point + extent } })
    }
}

impl Cells {
    /// The cells of all photons, if there are any. Photons of neighbouring cells are close to each other in memory.
    pub(in crate::world::specular::photons) fn new(isa: Isa, footprints: &[Footprint]) -> Option<Self> {
        let bounds = footprints.iter().map(|it| it.around).reduce(|all, around| all.union(&around))?;
        let parts = rayon::current_num_threads() as i64;
        let sorted: Vec<_> =
            (0..parts).into_par_iter().map(|part| isa.run(PartOfCells { footprints, part, parts })).collect();
        let mut cells: Vec<_> = sorted.into_iter().flatten().collect();
        cells.sort_unstable_by_key(|((level, at), _)| (*level, at.z, at.y, at.x));
        let mut levels: Vec<Level> = Vec::new();
        for ((exponent, _), _) in &cells {
            if levels.last().is_none_or(|level| level.exponent != *exponent) {
                levels.push(Level::new(*exponent));
            }
        }
        let mut all = Self {
            photons: Vec::new(),
            entries: Vec::new(),
            cells: ByCell::default(),
            coarse: CoarseGrid::new(&bounds, cells.len(), levels.len()),
            levels,
            bounds,
        };
        let mut places = vec![None; footprints.len()];
        for ((exponent, at), kept) in cells {
            let first = all.entries.len();
            for index in kept.into_iter().map(|kept| kept.index as usize) {
                let photon = &footprints[index].photon;
                let irradiance = photon.irradiance;
                // Not of NaN.
                if irradiance >= 0.0 {
                    let photon = *places[index].get_or_insert_with(|| {
                        all.photons.push(*photon);
                        all.photons.len() as u32 - 1
                    });
                    all.entries.push(Entry { irradiance, photon });
                }
            }
            let entries = &mut all.entries[first..];
            entries.sort_by(|a, b| b.irradiance.total_cmp(&a.irradiance));
            all.cells.insert((exponent, at), (first as u32, entries.len() as u32));
            if let (Some(entry), Some(level)) =
                (entries.first(), all.levels.iter().position(|level| level.exponent == exponent))
            {
                let width = all.levels[level].width;
                let corners = [at, at.saturating_add(IVec3::ONE)].map(|at| width * at.as_vec3());
                all.coarse.add(corners, level, entry.irradiance);
            }
        }
        Some(all)
    }
}

/// The cells of one of several parts of space, with their photons, as a task that is compiled for each instruction set.
struct PartOfCells<'a> {
    footprints: &'a [Footprint],
    part: i64,
    parts: i64,
}

impl Task for PartOfCells<'_> {
    type Output = ByCell<KeptPhotons>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { footprints, part, parts } = self;
        let mut cells = ByCell::default();
        let mut asked = CellBlock::default();
        for (index, footprint) in (0..).zip(footprints) {
            let level = Level::new(footprint.level);
            let [min, max] = [footprint.around.min, footprint.around.max].map(|corner| level.cell(corner));
            for z in min.z..=max.z {
                for y in min.y..=max.y {
                    // Diagonal planes take turns.
                    let before = i64::from(min.x) + i64::from(y) + i64::from(z);
                    let mut x = i64::from(min.x) + (part - before).rem_euclid(parts);
                    while x <= i64::from(max.x) {
                        if asked.len == LANES {
                            asked.keep((index, &footprint.photon), level, &mut cells);
                        }
                        asked.at[asked.len] = IVec3::new(x as i32, y, z);
                        asked.len += 1;
                        x += parts;
                    }
                }
            }
            // With many threads most parts have none of a footprint's cells.
            if asked.len > 0 {
                asked.keep((index, &footprint.photon), level, &mut cells);
            }
        }
        cells
    }
}

/// Cells that are looked at together.
const LANES: usize = 16;

/// Cells that a photon may be in.
#[derive(Default)]
struct CellBlock {
    at: [IVec3; LANES],
    len: usize,
}

impl CellBlock {
    /// Puts a photon into those of the cells that its footprint meets, and forgets all.
    #[inline(always)]
    fn keep(&mut self, (index, photon): (u32, &Photon), level: Level, cells: &mut ByCell<KeptPhotons>) {
        let (mut u, mut v, mut off) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let mut is_within = [0_u32; LANES];
        for i in 0..LANES {
            let center = level.width * (self.at[i].as_vec3() + 0.5);
            let (place, within) = photon.place_anywhere(center, level.width);
            (u[i], v[i], off[i]) = (place.coordinates.x, place.coordinates.y, place.off);
            is_within[i] = u32::from(within);
        }
        for i in (0..self.len).filter(|&i| is_within[i] != 0) {
            let place = Place { coordinates: Vec2::new(u[i], v[i]), off: off[i] };
            let own = KeptPhoton { index, off: place.off, emission: photon.emission(&place) };
            own.add_to(cells.entry((level.exponent, self.at[i])).or_default());
        }
        self.len = 0;
    }
}

impl KeptPhoton {
    /// Stores it in a cell, unless this has a better one with a start close to its own.
    fn add_to(self, kept: &mut KeptPhotons) {
        match kept.iter().position(|other| self.emission.is_beside(&other.emission)) {
            Some(place) if self.off < kept[place].off => kept[place] = self,
            None if kept.len() < MAX_OF_CELL => kept.push(self),
            _ => {}
        }
    }
}
