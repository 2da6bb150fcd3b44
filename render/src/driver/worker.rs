//! A picture shared among workers without common memory or a clock, such as a browser's: each has some of the tiles,
//! and does one step per call, so that it can handle other messages in between.
//!
//! The picture equals that of [`render`](super::render()) to the bit, for any number of workers.

use std::ops::Range;

use super::frame::{FrameRender, TileScratch};
use super::levels;
use crate::cache::Cache;
use crate::film::{Extras, TILE_SIDE, Tile, tiles};
use crate::integrator::Prepared;
use crate::settings::{Cryptomatte, Integrator, Settings};
use crate::world::World;

/// Samples a pixel that a step takes, but for the first: with these a tile is about a full batch of rays.
const SAMPLES: u32 = 2;

/// One worker's tiles of a picture: first one sample a pixel from coarse to fine, then wave by wave the others.
pub struct TileWorker {
    frame: FrameRender,
    tiles: Vec<Tile>,
    scratch: TileScratch,
    /// The tile that is next.
    next: usize,
    /// The side in pixels of the squares at hand, or 0 when every pixel has a sample.
    side: u32,
}

/// The result of a step on one tile.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The tile's columns.
    pub x: Range<u32>,
    /// The tile's rows.
    pub y: Range<u32>,
    /// Linear radiance of its pixels so far, row by row; as long as only the corners of squares have a sample, squares
    /// of one colour.
    pub radiance: Vec<[f32; 3]>,
    /// Camera samples taken.
    pub samples: u64,
    /// Rays traced.
    pub rays: u64,
}

impl TileWorker {
    /// Every tile of the picture that `world`'s camera sees whose index leaves the remainder `number` when divided by
    /// `count`, the number of workers, more than 0. The integrator `cached` reads `cache`, to which nothing is added
    /// ([`fill_cache`](super::fill_cache) does that): where it has no record, or without one, paths are traced. Paths
    /// are not guided.
    pub fn new(world: &World, settings: &Settings, cache: Option<Cache>, number: usize, count: usize) -> Self {
        let prepared = match &settings.integrator {
            Integrator::Cached(options) => {
                Prepared::frozen(cache.unwrap_or_else(|| Cache::new(*options, world.surroundings_hash())))
            }
            _ => Prepared::Nothing,
        };
        let settings = Settings {
            aov: false,
            halves: false,
            cryptomatte: Cryptomatte::default(),
            aovs: Vec::new(),
            light_groups: false,
            ..settings.clone()
        };
        let tiles =
            tiles(settings.width, settings.height, Extras::default()).into_iter().skip(number).step_by(count).collect();
        Self {
            frame: FrameRender::new(world, settings, prepared, None),
            tiles,
            scratch: TileScratch::default(),
            next: 0,
            side: TILE_SIDE,
        }
    }

    /// Does a step; `None` if everything is done. `world` is the one that the share was made for, with any camera.
    pub fn step(&mut self, world: &World) -> Option<Step> {
        let Self { frame, tiles, scratch, next, side } = self;
        let spp = frame.settings.spp;
        let tile = tiles.get_mut(*next).filter(|tile| *side > 0 || tile.samples.end < spp)?;
        let pixels = tile.pixels().enumerate();
        let (samples, rays, square);
        if *side > 0 {
            let pixels: Vec<_> = pixels.filter(|&(_, (x, y))| levels::is_new(x, y, *side, TILE_SIDE)).collect();
            rays = frame.sample(world, scratch, tile, &pixels, 0..1);
            samples = pixels.len();
            tile.samples.end = u32::from(*side == 1);
            square = *side;
        } else {
            let pixels: Vec<_> = pixels.collect();
            let next = tile.samples.end..spp.min(tile.samples.end + SAMPLES);
            rays = frame.sample(world, scratch, tile, &pixels, next.clone());
            samples = pixels.len() * next.len();
            tile.samples.end = next.end;
            square = 1;
        }
        let (x, y) = tile.extent();
        let radiance = radiance(tile, square);
        *next += 1;
        if *next == tiles.len() {
            (*next, *side) = (0, *side / 2);
        }
        Some(Step { x, y, radiance, samples: samples as u64, rays })
    }

    /// Samples a pixel that all tiles have.
    pub fn samples_per_pixel(&self) -> u32 {
        self.tiles.iter().map(|tile| tile.samples.end).min().unwrap_or(self.frame.settings.spp)
    }
}

/// The radiance of a tile's pixels, each that of the upper left one in its square.
fn radiance(tile: &Tile, square: u32) -> Vec<[f32; 3]> {
    let (columns, rows) = tile.extent();
    let corner = |i: u32| i - i % square;
    tile.pixels()
        .map(|(x, y)| {
            let (x, y) = (corner(x) - columns.start, corner(y) - rows.start);
            tile.radiance(y as usize * columns.len() + x as usize)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::driver::{fill_cache, render};
    use crate::film::Picture;
    use crate::scene::cornell_box;
    use crate::watch::NeverStops;

    fn settings(name: &str) -> Settings {
        let integrator = Integrator::named(name).unwrap();
        Settings { width: 75, height: 40, spp: 4, integrator, ..Settings::default() }
    }

    /// The pixel's colour in a whole picture.
    fn pixel(picture: &Picture, x: u32, y: u32) -> [f32; 3] {
        ["R", "G", "B"].map(|name| picture.channel(name).unwrap().values[(y * picture.width + x) as usize])
    }

    #[test]
    fn shares_make_up_the_picture() {
        let world = World::new(cornell_box()).unwrap();
        for name in ["path", "ao", "cached"] {
            let settings = settings(name);
            let whole = render(&world, &settings, &NeverStops);
            let cache =
                |options| fill_cache(&world, &settings, Cache::new(options, world.surroundings_hash()), &NeverStops);
            let cache = match settings.integrator {
                Integrator::Cached(options) => Some(cache(options)),
                _ => None,
            };
            for count in [1, 2, 7] {
                let mut seen = 0;
                let (mut rays, mut samples) = (0, 0);
                for number in 0..count {
                    let mut worker = TileWorker::new(&world, &settings, cache.clone(), number, count);
                    let mut last = Vec::new();
                    while let Some(step) = worker.step(&world) {
                        (rays, samples) = (rays + step.rays, samples + step.samples);
                        last.retain(|tile: &Step| tile.x != step.x || tile.y != step.y);
                        last.push(step);
                    }
                    assert_eq!(worker.samples_per_pixel(), 4);
                    for Step { x, y, radiance, .. } in last {
                        let places = y.flat_map(|y| x.clone().map(move |x| (x, y)));
                        for ((x, y), found) in places.zip(radiance) {
                            assert_eq!(found, pixel(&whole.picture, x, y), "{name}: {x}, {y}");
                            seen += 1;
                        }
                    }
                }
                assert_eq!((seen, samples), (75 * 40, 4 * 75 * 40), "{name}, {count} workers");
                // A cache's own rays were traced before.
                assert!(if cache.is_none() { rays == whole.rays } else { rays < whole.rays }, "{name}: {rays}");
            }
        }
    }

    #[test]
    fn blocks_have_the_colour_of_their_corner() {
        let world = World::new(cornell_box()).unwrap();
        let settings = settings("normals");
        let mut worker = TileWorker::new(&world, &settings, None, 0, 6);
        for side in [32, 16, 8, 4, 2, 1] {
            let Step { radiance, samples, .. } = worker.step(&world).unwrap();
            assert_eq!(samples, if side == 32 { 1 } else { 3 * (32 / side) * (32 / side) / 4 });
            for (i, value) in radiance.iter().enumerate() {
                let (x, y) = (i % 32, i / 32);
                let side = side as usize;
                assert_eq!(*value, radiance[(y - y % side) * 32 + (x - x % side)]);
            }
        }
    }

    #[test]
    fn a_worker_too_many_has_nothing_to_do() {
        let world = World::new(cornell_box()).unwrap();
        let mut worker = TileWorker::new(&world, &settings("ao"), None, 6, 7);
        assert_eq!((worker.step(&world), worker.samples_per_pixel()), (None, 4));
    }
}
