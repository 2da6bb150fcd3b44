//! Training paths of a [guide](crate::guide), in rounds: each has twice as many as the one before, and is guided by its
//! result. The last round's guide is learned from the last two, three quarters of all paths.
//!
//! They depend on scene, options and seed alone, and not on the picture's samples, tiles or shares. They cannot be
//! stopped, as a picture without its guide would differ.

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::Sampler;
use rayon::prelude::*;

use super::path::{PathObservers, Trainer, radiance};
use super::{FILM_SET, FIRST_SET, LENS_SET, RayBatch, TIME_SET, Wavefront};
use crate::camera::{Camera, FilmPoint, FilmSample};
use crate::guide::{Guide, GuideSample};
use crate::settings::{PathOptions, Settings};
use crate::world::{Hit, World};

/// Paths that are traced together.
const BATCH: u32 = 4096;
/// Paths of the first round, if there are as many.
const FIRST_ROUND: u32 = 1 << 14;

/// Traces this many paths of the picture, in rounds; returns the guide and the number of rays.
pub(super) fn train(world: &World, settings: &Settings, options: &PathOptions, paths: u32) -> (Option<Guide>, u64) {
    let camera = world.camera_on(settings.width, settings.height);
    let (mut guide, mut before, mut rays) = (None, Vec::new(), 0);
    let rounds = rounds(paths);
    for (number, &count) in (0..).zip(&rounds) {
        let round = Round { world, settings, options, camera: &camera, guide: guide.as_ref(), number, count };
        let batches: Vec<_> = (0..count.div_ceil(BATCH)).into_par_iter().map(|batch| round.trace(batch)).collect();
        let mut samples = Vec::new();
        for (found, traced) in batches {
            samples.extend(found);
            rays += traced;
        }
        if number as usize + 1 == rounds.len() {
            samples.append(&mut before);
        } else if number as usize + 2 == rounds.len() {
            before.clone_from(&samples);
        }
        guide = Guide::learn(samples);
    }
    (guide, rays)
}

/// The paths of each round.
fn rounds(paths: u32) -> Vec<u32> {
    let (mut rounds, mut left) = (Vec::new(), paths);
    while left > 0 {
        // Counted from the last round: half of the rest, until little is left.
        let count = if left < 4 * FIRST_ROUND { left } else { left.div_ceil(2) };
        rounds.push(count);
        left -= count;
    }
    rounds.reverse();
    rounds
}

/// A round.
struct Round<'a> {
    world: &'a World,
    settings: &'a Settings,
    options: &'a PathOptions,
    camera: &'a Camera,
    guide: Option<&'a Guide>,
    number: u32,
    count: u32,
}

impl Round<'_> {
    /// Traces the paths of this batch. Gives their bounces that found light, and the number of rays.
    fn trace(&self, batch: u32) -> (Vec<GuideSample>, u64) {
        let Settings { sampler, seed, width, height, .. } = self.settings;
        let size = Vec2::new(*width as f32, *height as f32);
        let paths = batch * BATCH..self.count.min((batch + 1) * BATCH);
        // Beyond all pixels, so that no random number is shared with the picture.
        let samplers = paths.map(|path| Sampler::new(*sampler, *seed, u32::MAX - self.number, path));
        let sample = |sampler: &Sampler| FilmSample {
            film: FilmPoint::within(sampler.uniform2(FILM_SET) * size),
            lens: sampler.uniform2(LENS_SET),
        };
        let (samplers, film): (Vec<_>, Vec<_>) = samplers
            .map(|sampler| (sampler, sample(&sampler)))
            .filter(|(_, sample)| self.camera.covers(&sample.film))
            .unzip();
        let times: Vec<f32> = match self.world.motion() {
            Some(motion) => samplers.iter().map(|sampler| motion.time(sampler.uniform2(TIME_SET).x)).collect(),
            None => Vec::new(),
        };
        let mut rays = vec![Ray::new(Vec3::ZERO, Vec3::ZERO); film.len()];
        self.camera.rays(self.world.isa(), &film, &mut rays);
        let mut hits = vec![Hit::MISS; rays.len()];
        self.world.intersect_side_by_side(&rays, &times, &mut hits);
        let batch = RayBatch {
            rays: &rays,
            hits: &hits,
            samplers: &samplers,
            times: &times,
            first_set: FIRST_SET,
            density: f32::INFINITY,
        };
        let mut trainer = Trainer::default();
        let companions = PathObservers { guide: self.guide, trainer: Some(&mut trainer), recorder: None };
        let mut found = vec![Vec3::ZERO; rays.len()];
        let mut wave = Wavefront::default();
        let traced = radiance(self.world, self.options, &batch, &mut wave, &mut found, &mut |_| (), companions);
        (trainer.found().collect(), rays.len() as u64 + traced)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_grow_and_add_up() {
        for paths in [1, 1000, 1 << 16, 1 << 19, 1_000_001] {
            let rounds = rounds(paths);
            assert_eq!(rounds.iter().sum::<u32>(), paths);
            assert!(rounds.is_sorted(), "{rounds:?}");
        }
        assert!(rounds(0).is_empty());
        assert_eq!(rounds(1 << 19).len(), 5);
    }
}
