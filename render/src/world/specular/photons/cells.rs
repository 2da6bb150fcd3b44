//! The photons of one light in cells around where they arrive.
//!
//! Cells are cubes, of a power of two wide: a photon is in those of the level that its footprint's extent gives, which
//! it may light. A point asks one cell a level for photons of at least some irradiance. Most cells have none; a coarse
//! grid tells which have, with all levels of a place side by side in memory.

mod build;

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use glam::{IVec3, UVec3, Vec3};
use halfdome_kernel::geometry::Aabb;

pub(super) use self::build::Footprint;
use super::{Photon, Starts};

/// Cells for each part of the coarse grid, and the most parts along an axis.
const CELLS_OF_PART: f32 = 4.0;
const MAX_PARTS: f32 = 16.0;

/// A map by cells.
type ByCell<T> = HashMap<(i32, IVec3), T, BuildHasherDefault<CellHasher>>;

/// Photons and their cells.
#[derive(Debug)]
pub(super) struct Cells {
    photons: Vec<Photon>,
    /// The photons of all cells, in each by falling irradiance.
    entries: Vec<Entry>,
    /// The first entry of each cell, and their number.
    cells: ByCell<(u32, u32)>,
    levels: Vec<Level>,
    bounds: Aabb,
    coarse: CoarseGrid,
}

/// A photon of a cell.
#[derive(Clone, Copy, Debug)]
struct Entry {
    irradiance: f32,
    photon: u32,
}

/// Cells of one size.
#[derive(Clone, Copy, Debug)]
struct Level {
    /// The binary logarithm of their width.
    exponent: i32,
    width: f32,
}

/// The greatest irradiance of each level in each part of a box.
#[derive(Debug)]
struct CoarseGrid {
    /// Parts along an axis.
    count: u32,
    min: Vec3,
    parts_per_length: Vec3,
    /// By part, of each level the upper bound as an exponent (see [`exponent`]); 0 where there are no photons.
    greatest: Vec<u8>,
}

impl Cells {
    /// Whether a point is in the box of all footprints.
    pub(super) fn may_reach(&self, point: Vec3) -> bool {
        point.cmpge(self.bounds.min).all() && point.cmple(self.bounds.max).all()
    }

    /// Whether photons of at least this irradiance may have arrived near a point in the box.
    pub(super) fn may_light(&self, point: Vec3, irradiance: f32) -> bool {
        let least = exponent(irradiance);
        self.coarse.greatest(point, self.levels.len()).iter().any(|&greatest| greatest >= least)
    }

    /// Adds the starts for a point by photons of at least this irradiance, without those that lead to the same
    /// connection.
    pub(super) fn find(&self, point: Vec3, irradiance: f32, starts: &mut Starts) {
        if !self.may_reach(point) {
            return;
        }
        let least = exponent(irradiance);
        let greatest = self.coarse.greatest(point, self.levels.len());
        for (level, _) in self.levels.iter().zip(greatest).filter(|(_, greatest)| **greatest >= least) {
            let Some(&(first, count)) = self.cells.get(&(level.exponent, level.cell(point))) else { continue };
            let entries = &self.entries[first as usize..][..count as usize];
            for entry in entries.iter().take_while(|entry| entry.irradiance >= irradiance) {
                let photon = &self.photons[entry.photon as usize];
                let beside = if photon.reflection.is_some() { 0.5 * level.width } else { level.width };
                if let Some(start) = photon.start(point, beside) {
                    starts.add(start);
                }
            }
        }
    }
}

impl Level {
    fn new(exponent: i32) -> Self {
        Self { exponent, width: (exponent as f32).exp2() }
    }

    /// The cell that a point is in.
    fn cell(&self, point: Vec3) -> IVec3 {
        let scaled = point / self.width;
        let towards_zero = scaled.as_ivec3();
        towards_zero.saturating_sub(IVec3::from(scaled.cmplt(towards_zero.as_vec3())))
    }
}

impl CoarseGrid {
    fn new(bounds: &Aabb, cells: usize, levels: usize) -> Self {
        let count = (cells as f32 / CELLS_OF_PART).cbrt().clamp(1.0, MAX_PARTS) as u32;
        let size = (bounds.max - bounds.min).max(Vec3::splat(f32::MIN_POSITIVE));
        let greatest = vec![0; levels * (count * count * count) as usize];
        Self { count, min: bounds.min, parts_per_length: count as f32 / size, greatest }
    }

    /// The part that a point is in, or the next one. It does not decrease with any coordinate.
    fn part(&self, point: Vec3) -> UVec3 {
        ((point - self.min) * self.parts_per_length).as_uvec3().min(UVec3::splat(self.count - 1))
    }

    fn index(&self, part: UVec3) -> usize {
        ((part.z * self.count + part.y) * self.count + part.x) as usize
    }

    /// Adds a cell's greatest irradiance.
    fn add(&mut self, corners: [Vec3; 2], level: usize, irradiance: f32) {
        let levels = self.greatest.len() / self.count.pow(3) as usize;
        let [min, max] = corners.map(|corner| self.part(corner));
        for z in min.z..=max.z {
            for y in min.y..=max.y {
                for x in min.x..=max.x {
                    let place = self.index(UVec3::new(x, y, z)) * levels + level;
                    self.greatest[place] = self.greatest[place].max(exponent(irradiance));
                }
            }
        }
    }

    /// The bounds of each level at a point.
    fn greatest(&self, point: Vec3, levels: usize) -> &[u8] {
        &self.greatest[self.index(self.part(point)) * levels..][..levels]
    }
}

/// A positive number's exponent as floats have it, at least 1: it does not decrease with the number.
fn exponent(irradiance: f32) -> u8 {
    ((irradiance.to_bits() >> 23) as u8).max(1)
}

/// A hash of few words, faster than the standard library's, which withstands attackers.
#[derive(Default)]
struct CellHasher(u64);

impl Hasher for CellHasher {
    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 32
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_i32(byte.into()));
    }

    fn write_i32(&mut self, word: i32) {
        // Knuth's multiplier of a linear congruential generator.
        self.0 = (self.0.rotate_left(13) ^ u64::from(word as u32)).wrapping_mul(6_364_136_223_846_793_005);
    }
}

#[cfg(test)]
mod tests {
    use glam::vec3;
    use halfdome_kernel::Isa;
    use halfdome_kernel::sampling::Stream;

    use super::*;
    use crate::world::specular::photons::{Arrival, Sent};

    /// A vector in [0, 1)³.
    fn place(i: u32, set: u32) -> Vec3 {
        let [x, y, z, _] = Stream::new(7, i, 0).uniform4(set);
        vec3(x, y, z)
    }

    /// Photons of many sizes and strengths that arrive in a flat box, sent from places far apart.
    fn cells(count: u32) -> Cells {
        let footprint = |i| {
            let (point, numbers) = (place(i, 0) * vec3(10.0, 3.0, 0.0) - vec3(2.0, 1.0, 0.0), place(i, 1));
            let extent = 2e-2 * (40.0 * numbers.x).max(1.0);
            let photon = Photon {
                origin: point + Vec3::Z,
                direction: Vec3::NEG_Z,
                d_origin: [Vec3::X * extent, Vec3::Y * extent],
                d_direction: [Vec3::ZERO; 2],
                sent: Sent { at: 1000.0 * point, by: [Vec3::X * extent, Vec3::Y * extent] },
                blur: 0.0,
                reflection: Some(0),
                irradiance: (20.0 * numbers.y - 15.0).exp2(),
            };
            Footprint::new(&Arrival { photon, point, extent: vec3(extent, extent, 0.0) }, 1.0)
        };
        Cells::new(Isa::detect(), &(0..count).filter_map(footprint).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn cells_do_not_depend_on_the_number_of_threads() {
        let by = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let cells = pool.install(|| cells(300));
            let mut places: Vec<_> =
                cells.cells.iter().map(|((level, at), range)| (*level, at.to_array(), *range)).collect();
            places.sort_unstable();
            format!("{places:?} {:?} {:?} {:?}", cells.entries, cells.photons, cells.coarse)
        };
        let expected = by(1);
        assert!([2, 3, 8].into_iter().all(|threads| by(threads) == expected));
    }

    #[test]
    fn the_coarse_grid_hides_no_photon() {
        let cells = cells(2000);
        assert!(cells.levels.len() > 4 && cells.coarse.count > 4, "{} {}", cells.levels.len(), cells.coarse.count);
        let (mut known, mut hidden) = (0, 0);
        for i in 0..20_000 {
            let point = place(i, 2) * vec3(10.0, 3.0, 0.0) - vec3(2.0, 1.0, 0.0);
            for (level, &greatest) in cells.levels.iter().zip(cells.coarse.greatest(point, cells.levels.len())) {
                let Some(&(first, count)) = cells.cells.get(&(level.exponent, level.cell(point))) else {
                    hidden += usize::from(greatest == 0);
                    continue;
                };
                let entries = &cells.entries[first as usize..][..count as usize];
                assert!(entries.iter().all(|entry| exponent(entry.irradiance) <= greatest));
                assert!(entries.is_sorted_by(|a, b| a.irradiance >= b.irradiance));
                known += 1;
            }
        }
        assert!(known > 1000 && hidden > 1000, "{known} {hidden}");
    }

    #[test]
    fn photons_are_found_within_their_footprints_if_they_are_strong_enough() {
        let cells = cells(200);
        let mut starts = Starts::default();
        let mut found = [0; 2];
        for photon in &cells.photons {
            let point = photon.origin - Vec3::Z;
            for (count, least) in found.iter_mut().zip([0.0, 1.0]) {
                starts.0.clear();
                cells.find(point, least, &mut starts);
                assert!(starts.iter().all(|start| start.strength >= least));
                let is_there =
                    starts.iter().any(|start| start.emission.sent.distance(photon.sent.at) <= start.emission.spacing);
                assert_eq!(is_there, photon.irradiance >= least, "{photon:?}");
                *count += usize::from(is_there);
            }
        }
        assert!(found[0] == cells.photons.len() && found[1] < found[0], "{found:?}");
    }

    #[test]
    fn exponents_do_not_decrease() {
        let numbers = [0.0, 1e-40, 1e-30, 0.3, 0.5, 0.9, 1.0, 3.0, 1e30, f32::INFINITY];
        assert!(numbers.map(exponent).is_sorted());
        assert_eq!(exponent(0.0), 1);
    }
}
