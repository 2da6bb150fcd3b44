//! Decides which samples of a picture are taken, and when they are enough.
//!
//! A tile is finished when it has all its samples, or when its error, estimated from its own samples, is small enough.
//! So the result does not depend on which process renders which tiles, or on interruptions. The test is made only at
//! the ends of waves: at 1, 2, 4, 8, 16 samples and every multiple of 16. Stopping as soon as an estimate is small
//! favours pixels that are dark by chance; as a tile has a thousand pixels, and there is no test before
//! [`MIN_SAMPLES`], this bias is small against the noise.

use super::option_names;
use crate::cache::Cache;
use crate::film::{Film, FilmError, FilmHeader, MatteLayer, Tile};
use crate::integrator;
use crate::settings::{Integrator, Settings, Shard};
use crate::world::World;

/// The most samples a pixel that one wave takes, and so the most by which tiles differ after an interruption.
const MAX_WAVE: u32 = 16;
/// Samples before which no error is trusted.
pub(super) const MIN_SAMPLES: u32 = 32;

/// The samples of a picture to take, and when they are enough.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// The `cached` integrator adds to this; it must be of the world and of the integrator's options.
    pub cache: Option<Cache>,
    /// Samples taken before.
    pub film: Option<Film>,
    /// The tiles that are rendered.
    pub shard: Shard,
    /// The first sample of each pixel; the settings' samples per pixel are the end.
    pub first_sample: u32,
    /// The relative error, more than 0, at which a tile is finished before all its samples are taken. The settings must
    /// include halves.
    pub noise: Option<f64>,
}

/// The header that identifies a picture's film: equal for all parts of it.
pub fn film_header(world: &World, settings: &Settings, cache: Option<&Cache>) -> FilmHeader {
    let Settings {
        width,
        height,
        filter,
        integrator,
        spp: _,
        sampler,
        seed,
        build: _,
        aov,
        aov_through,
        halves,
        cryptomatte,
        aovs: _,
        light_groups: _,
    } = settings;
    let aovs = integrator::aovs(world, settings);
    let mut options = vec![("--sampler".to_owned(), format!("{sampler:?}").to_lowercase())];
    options.extend(option_names::of_filter(filter));
    options.extend(option_names::of_integrator(integrator));
    if *aov_through {
        options.push(("what AOVs show".to_owned(), "what mirrors and clear glass show".to_owned()));
    }
    if let (Some(cache), Integrator::Cached(_)) = (cache, integrator) {
        options.push(("the irradiance cache".to_owned(), format!("{:016x}", cache.hash())));
    }
    for aov in &aovs {
        options.push((format!("the AOV {}", aov.name), aov.expression.text().to_owned()));
    }
    if !aovs.is_empty() {
        options
            .push(("the names of lights and surfaces".to_owned(), format!("{:016x}", integrator::labels_hash(world))));
    }
    let camera = world.camera_on(*width, *height);
    FilmHeader {
        program: env!("CARGO_PKG_VERSION").to_owned(),
        width: *width,
        height: *height,
        has_border: camera.has_border(),
        aov: *aov,
        halves: *halves,
        light: aovs.into_iter().map(|aov| aov.name).collect(),
        cryptomatte: (cryptomatte.kinds.iter())
            .map(|&kind| MatteLayer::new(kind.layer(), cryptomatte.levels, world.names(kind)))
            .collect(),
        seed: *seed,
        integrator: integrator.name().to_owned(),
        options: options.into_iter().collect(),
        scene_hash: world.hash(),
        surroundings_hash: world.surroundings_hash(),
        world_to_camera: camera.world_to_camera(),
        level: None,
    }
}

/// The number of samples at the end of the next wave after `samples`.
pub(super) fn next_wave(samples: u32) -> u32 {
    let is_early = samples < MAX_WAVE;
    if is_early { (samples + 1).next_power_of_two() } else { (samples / MAX_WAVE + 1).saturating_mul(MAX_WAVE) }
}

/// Whether waves end at this number of samples.
fn is_end_of_wave(samples: u32) -> bool {
    if samples < MAX_WAVE { samples.is_power_of_two() } else { samples.is_multiple_of(MAX_WAVE) }
}

impl Plan {
    /// The film to continue.
    pub(super) fn begin(&mut self, header: FilmHeader, spp: u32) -> Result<Film, FilmError> {
        if self.first_sample > 0 && self.first_sample >= spp {
            let problem = format!("the first sample is {}, and a pixel has {spp}", self.first_sample);
            return Err(FilmError::new(problem, "begin with an earlier sample, or take more a pixel"));
        }
        let Some(film) = self.film.take() else { return Ok(Film::new(header)) };
        film.header().check(&header)?;
        film.check_first_sample(self.first_sample)?;
        Ok(film)
    }

    /// Whether a tile has had enough.
    pub(super) fn is_enough(&self, tile: &Tile, level: Option<f64>, spp: u32) -> bool {
        tile.samples.end >= spp || self.noise.is_some() && self.is_precise(tile, level)
    }

    /// Whether a tile's error is as small as it was asked to be.
    pub(super) fn is_precise(&self, tile: &Tile, level: Option<f64>) -> bool {
        let Some(noise) = self.noise else { return true };
        let samples = tile.samples.len() as u32;
        let is_time = samples >= MIN_SAMPLES && is_end_of_wave(samples);
        is_time && level.and_then(|level| tile.relative_error(level)).is_some_and(|error| error <= noise)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_double_and_then_go_on() {
        let ends: Vec<u32> = std::iter::successors(Some(0), |&end| Some(next_wave(end))).take(9).collect();
        assert_eq!(ends, [0, 1, 2, 4, 8, 16, 32, 48, 64]);
        assert_eq!([3, 5, 17, 47].map(next_wave), [4, 8, 32, 48]);
        assert!(ends[1..].iter().all(|&end| is_end_of_wave(end)) && ![3, 12, 40].map(is_end_of_wave).contains(&true));
        assert_eq!(next_wave(u32::MAX - 3), u32::MAX);
    }
}
