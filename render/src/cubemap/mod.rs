//! Cube maps: the radiance around a point, filtered for reflections of all roughnesses, without seams between faces.
//!
//! The first level is the radiance in each texel's own solid angle. Each further level is half as large and filtered by
//! a wider [`Lobe`], always from the first level and exactly at its texels' directions, so that errors do not add up.

mod environment;
mod face;
mod filter;
mod grid;
mod level;
mod lobe;
mod manifest;
pub mod measure;
mod shader;
#[cfg(test)]
mod tests;
pub mod unfold;

use glam::Vec3;
use rayon::prelude::*;

pub use environment::{Environment, Paths};
pub use face::{Axes, Face};
pub use grid::{Seams, TexelGrid};
pub use level::Level;
pub use lobe::{Filter, Lobe, Mapping};
pub use manifest::manifest;
pub use shader::{Language, lookup};

use crate::watch::Watch;
use environment::Viewer;
use filter::Pyramid;

/// The options of a cube map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Texels across a face: a power of two from [`MIN_SIZE`](Self::MIN_SIZE) to [`MAX_SIZE`](Self::MAX_SIZE).
    pub size: u32,
    /// Levels, from 1 to as many as halving takes to get to one texel.
    pub levels: u32,
    /// The treatment of seams.
    pub seams: Seams,
    /// The filter of levels after the first.
    pub filter: Filter,
    /// The roughness of a level.
    pub mapping: Mapping,
    /// The lookup of engines.
    pub axes: Axes,
    /// Texels across a face of a further map of irradiance over π, a power of two in the same range; `None` for no such
    /// map.
    pub diffuse: Option<u32>,
    /// Selects the random numbers.
    pub seed: u64,
}

impl Options {
    /// The smallest map.
    pub const MIN_SIZE: u32 = 2;
    /// The largest: a gigabyte while it is filtered.
    pub const MAX_SIZE: u32 = 2048;
    /// The default width of the last level in texels: fewer texels cannot represent a lobe's shape.
    pub const LAST_SIZE: u32 = 4;

    /// The most levels that a map of this size has.
    pub fn max_levels(size: u32) -> u32 {
        size.ilog2() + 1
    }

    /// As many levels as end with [`LAST_SIZE`](Self::LAST_SIZE).
    pub fn default_levels(size: u32) -> u32 {
        (size / Self::LAST_SIZE).max(1).ilog2() + 1
    }
}

/// A cube map.
#[derive(Clone, Debug, PartialEq)]
pub struct CubeMap {
    /// The options that it was made with.
    pub options: Options,
    /// Its levels, the largest first.
    pub levels: Vec<Level>,
    /// Irradiance over π for normals in all directions, if it was asked for.
    pub diffuse: Option<Level>,
    /// Rays traced.
    pub rays: u64,
    /// The root mean square of the first level's standard errors, relative to its mean; 0 if paths were counted.
    pub error: f32,
}

/// Texels that a thread takes at once.
const CHUNK: usize = 64;

/// Steps that [`make`] reports to its watcher: samples of the first level, and texels of the others.
pub fn work(source: &Environment, options: &Options) -> u64 {
    let texels = |size: u32| TexelGrid { size, seams: options.seams }.texels() as u64;
    let filtered: u64 = (1..options.levels).map(|level| texels(options.size >> level)).sum();
    texels(options.size) * source.samples() + filtered + options.diffuse.map_or(0, texels)
}

/// Makes a cube map on the threads of the current rayon pool; `None` if the watcher stops. It depends on the source and
/// the options alone.
///
/// # Panics
/// If the options are out of their ranges.
pub fn make(source: &Environment, options: &Options, watch: &dyn Watch) -> Option<CubeMap> {
    let (size, count) = (options.size, options.levels);
    let sizes = [Some(size), options.diffuse].into_iter().flatten();
    assert!(
        sizes.into_iter().all(|size| size.is_power_of_two() && (Options::MIN_SIZE..=Options::MAX_SIZE).contains(&size)),
        "sizes are powers of two in their range"
    );
    assert!((1..=Options::max_levels(size)).contains(&count), "there are levels, and not too many");
    let grid = |size: u32| TexelGrid { size, seams: options.seams };
    let (first, rays, variance) = radiance(source, options, grid(size), watch)?;
    let mean = first.mean();
    let error = if mean > 0.0 { (variance.sqrt() / mean) as f32 } else { 0.0 };
    let pyramid = Pyramid::new(first.grid, &first.texels);
    let mut levels = vec![first];
    for number in 1..count {
        let lobe = Lobe::of_level(options.filter, options.mapping, number, count);
        levels.push(filtered(&pyramid, grid(size >> number), lobe, watch)?);
    }
    let diffuse = match options.diffuse {
        Some(size) => Some(filtered(&pyramid, grid(size), Lobe::Phong { power: 1.0 }, watch)?),
        None => None,
    };
    Some(CubeMap { options: *options, levels, diffuse, rays, error })
}

/// The first level, the rays that it took, and the mean variance of its texels.
fn radiance(source: &Environment, options: &Options, grid: TexelGrid, watch: &dyn Watch) -> Option<(Level, u64, f64)> {
    let places: Vec<_> = (0..).zip(grid.places()).collect();
    let chunk = |viewer: &mut Viewer, places: &[(u32, (Face, u32, u32))]| {
        let (mut rays, mut variance) = (0, 0.0);
        let texel = |&(number, place): &(u32, (Face, u32, u32))| {
            if watch.stop() {
                return None;
            }
            let seen = source.texel(viewer, (&grid, options.axes), number, place);
            watch.advance(source.samples(), seen.rays);
            (rays, variance) = (rays + seen.rays, variance + seen.variance);
            Some(seen.radiance)
        };
        let texels: Option<Vec<Vec3>> = places.iter().map(texel).collect();
        texels.map(|texels| (texels, rays, variance))
    };
    let chunks: Option<Vec<(Vec<Vec3>, u64, f64)>> =
        places.par_chunks(CHUNK).map_init(Viewer::default, chunk).collect();
    let chunks = chunks?;
    let rays = chunks.iter().map(|(_, rays, _)| rays).sum();
    let variance = chunks.iter().map(|(.., variance)| variance).sum::<f64>() / places.len() as f64;
    let mut texels: Vec<Vec3> = chunks.into_iter().flat_map(|(texels, ..)| texels).collect();
    grid.weld(&mut texels);
    Some((Level { grid, lobe: None, texels }, rays, variance))
}

/// A level that is filtered by a lobe.
fn filtered(pyramid: &Pyramid, grid: TexelGrid, lobe: Lobe, watch: &dyn Watch) -> Option<Level> {
    let places: Vec<_> = grid.places().collect();
    let chunk = |places: &[(Face, u32, u32)]| {
        if watch.stop() {
            return None;
        }
        let texel = |&(face, x, y): &(Face, u32, u32)| pyramid.filtered(grid.point(face, x, y).normalize(), &lobe);
        let texels: Vec<Vec3> = places.iter().map(texel).collect();
        watch.advance(texels.len() as u64, 0);
        Some(texels)
    };
    let chunks: Option<Vec<Vec<Vec3>>> = places.par_chunks(CHUNK).map(chunk).collect();
    let mut texels = chunks?.concat();
    grid.weld(&mut texels);
    Some(Level { grid, lobe: Some(lobe), texels })
}
