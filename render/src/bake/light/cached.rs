//! Indirect light of texels from an irradiance cache, which is filled twice.
//!
//! A rough cache of few records, by paths, gives a first map of all light; then each ray of the final cache's gathers
//! ends with a lookup in that map ([`TexelIrradiance`]). Errors of the first map affect only light reflected twice or
//! more, averaged over a hemisphere. With a number of bounces there is no first map: each bounce has a cache of its
//! own.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::baker::{Baker, Found};
use super::partly_covered::is_partly_covered;
use super::texel_irradiance::TexelIrradiance;
use super::values::Values;
use crate::bake::files::checkpoint::{CheckpointedRecords, Stage};
use crate::bake::layout::texels::Texel;
use crate::bake::options::Directional;
use crate::cache::Cache;
use crate::estimator::salts;
use crate::integrator::{FillTarget, FrozenCache, GatherSource, fill_for_texels, lookup_point};
use crate::settings::CachedOptions;
use crate::world::Surface;

/// How many times as far the records of the rough cache reach.
const ROUGH: f32 = 3.0;

impl Baker<'_> {
    /// Whether gathers look at a map that is there before.
    pub(super) fn uses_first_map(&self) -> bool {
        self.needs_cache() && self.options.cache.bounces.is_none()
    }

    /// All light of texels by a rough cache, the number of its records, and its rays; `direct` has the rest of the
    /// light.
    pub(super) fn first_map<'t>(
        &'t self,
        texels: &'t [Texel],
        direct: &Values,
    ) -> Option<(TexelIrradiance<'t>, u64, u64)> {
        let options = self.options.cache;
        let error = (ROUGH * options.error).min(CachedOptions::MAX_ERROR);
        let rough = CachedOptions { error, accuracy: None, ..options };
        let records = CheckpointedRecords { checkpoint: self.checkpoint, stage: Stage::Rough };
        let source = GatherSource::paths(&rough);
        let (frozen, rays) =
            self.fill(texels, (rough, self.options.seed ^ salts::ROUGH), (source, FillTarget::Means), &records)?;
        let indirect = |texel: &Texel| frozen.irradiance(self.world, &self.surface(texel));
        let is_mean_seen = |texel: &&Texel| !is_partly_covered(self.world, self.surfaces, texel);
        let indirect = |texel: &Texel| Some(texel).filter(is_mean_seen).and_then(indirect);
        let indirect: Vec<Option<Vec3>> = texels.par_iter().map(indirect).collect();
        let all = indirect.into_iter().zip(direct.texels()).map(|(indirect, direct)| Some(indirect? + direct[0]));
        let map = TexelIrradiance::new(self.surfaces, texels, all.collect());
        self.watch.filled();
        self.watch.advance(texels.len() as u64, 0);
        Some((map, frozen.usage().records, rays))
    }

    /// A cache that serves all texels, and its rays; `None` if it was stopped.
    pub(super) fn fill(
        &self,
        texels: &[Texel],
        (options, seed): (CachedOptions, u64),
        (source, aim): (GatherSource, FillTarget),
        records: &CheckpointedRecords,
    ) -> Option<(FrozenCache, u64)> {
        let Self { world, watch, .. } = *self;
        let places: Vec<(Surface, f32)> = texels.iter().map(|texel| (self.surface(texel), texel.spacing)).collect();
        let cache = Cache::new(options, world.surroundings_hash());
        let filled = fill_for_texels(world, seed, cache, &places, (source, aim), records, watch);
        (!watch.stop()).then_some(filled)
    }

    /// Indirect light of all texels from a cache; those without a record gather.
    pub(super) fn interpolate(
        &self,
        frozen: &FrozenCache,
        texels: &[Texel],
        source: GatherSource,
    ) -> Option<(Values, u64)> {
        let moments = self.moments_of_records(frozen, texels)?;
        let mut rays = moments.rays;
        let moments: Vec<&[Vec3]> = moments.values.texels().collect();
        let found: Vec<Option<(Vec3, [DVec3; 4])>> = texels
            .par_iter()
            .map(|texel| {
                let surface = self.surface(texel);
                let point = lookup_point(self.world, &surface);
                let irradiance = frozen.irradiance_at(&point, surface.shading_normal)?;
                let (mut sums, mut weights) = ([DVec3::ZERO; 4], 0.0);
                if !moments.is_empty() {
                    frozen.cache.weigh(&point, |record, weight| {
                        weights += f64::from(weight);
                        for (sum, moment) in sums.iter_mut().zip(&moments[record][1..]) {
                            *sum += f64::from(weight) * moment.as_dvec3();
                        }
                    });
                    sums.iter_mut().for_each(|sum| *sum /= weights);
                }
                Some((irradiance, sums))
            })
            .collect();
        let missing: Vec<usize> = (0..texels.len()).filter(|&i| found[i].is_none()).collect();
        let mut values = Values::of(self.layers(), found.into_iter().map(Option::unwrap_or_default));
        let lost: Vec<Texel> = missing.iter().map(|&i| texels[i]).collect();
        let gathered = self.chunks(Stage::Missing, &lost, |texels| {
            let texels: Vec<(usize, Texel)> = texels.iter().map(|&(i, texel)| (missing[i], texel)).collect();
            self.gather(&texels, source)
        })?;
        rays += gathered.rays;
        missing.into_iter().zip(gathered.values.texels()).for_each(|(i, gathered)| values.set(i, gathered));
        Some((values, rays))
    }

    /// The moments at each record, behind an empty irradiance; nothing if there is nothing to keep.
    fn moments_of_records(&self, frozen: &FrozenCache, texels: &[Texel]) -> Option<Found> {
        if self.directional() == Directional::None {
            return Some(Found { values: Values::of(1, std::iter::empty()), ..Found::default() });
        }
        let keys: Vec<usize> = frozen.cache.records().iter().map(|record| record.key as usize).collect();
        let points: Vec<Texel> = keys.iter().map(|&key| texels[key]).collect();
        self.chunks(Stage::Moments, &points, |points| {
            let points: Vec<(usize, Texel)> = points.iter().map(|&(i, texel)| (keys[i], texel)).collect();
            let (moments, rays) = self.gather_moments(&points);
            let values = Values::of(self.layers(), moments.into_iter().map(|moments| (Vec3::ZERO, moments)));
            Found { values, rays, variance: 0.0 }
        })
    }
}
