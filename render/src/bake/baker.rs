//! The light of every texel.
//!
//! Direct light is sampled at every texel, and with it the sun of a sky's picture. What surfaces reflect, and the rest of the
//! sky, comes from an irradiance cache in space: texels of different charts that lie side by side there share records, which a cache in the plane of the map could not.
//!
//! Without a cache every texel gathers for itself, by paths, with as many rays as a record would have.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::ao::AmbientOcclusion;
use super::checkpoint::{Checkpoint, CheckpointedRecords, Stage};
use super::footprint::footprint;
use super::moments::{DirectionalBasis, Moments};
use super::options::{BakeOptions, Directional, Mode};
use super::texels::{Surfaces, Texel};
use super::values::Values;
use crate::cache::Cache;
use crate::estimator::{GatherPoint, IncidentSampler, IncidentSink};
use crate::integrator::CacheUse;
use crate::integrator::{GatherSource, Uncached};
use crate::settings::Shard;
use crate::watch::Watch;
use crate::world::{Surface, World};

/// Texels that a thread takes at once.
const CHUNK: usize = 64;

/// What a bake works with.
pub(super) struct Baker<'a> {
    pub(super) world: &'a World,
    pub(super) surfaces: &'a Surfaces<'a>,
    pub(super) options: &'a BakeOptions,
    pub(super) checkpoint: &'a Checkpoint,
    pub(super) watch: &'a dyn Watch,
}

/// The light of texels.
pub(super) struct BakedTexels {
    /// For each texel irradiance, then the moments that are asked for.
    values: Values,
    /// Rays traced now.
    pub(super) rays: u64,
    /// Gathers: of the texels, or of the cache's records.
    pub(super) gathers: u64,
    /// The cache with its use.
    pub(super) cache: Option<(Cache, CacheUse)>,
}

impl BakedTexels {
    /// Vectors for each texel.
    pub(super) fn layers(&self) -> usize {
        self.values.layers()
    }

    /// Those of each texel.
    pub(super) fn values(&self) -> impl Iterator<Item = &[Vec3]> {
        self.values.texels()
    }
}

/// Irradiance and moments of direct light.
struct Sums {
    normal: Vec3,
    basis: DirectionalBasis,
    irradiance: DVec3,
    moments: [DVec3; 4],
}

impl IncidentSink for Sums {
    fn add_light(&mut self, direction: Vec3, irradiance: Vec3) {
        self.irradiance += irradiance.as_dvec3();
        let cosine = self.normal.dot(direction);
        if cosine > 0.0 {
            self.basis.add(direction, irradiance / cosine, &mut self.moments);
        }
    }
}

impl Baker<'_> {
    /// The light of `texels`; `None` if the watcher says stop.
    pub(super) fn bake_texels(&self, texels: &[Texel]) -> Option<BakedTexels> {
        let (without_cache, mut rays) = self.chunks(Stage::Texels, texels, |texels| self.without_cache(texels))?;
        if !self.needs_cache() {
            let gathers = if self.is_brute_force() { texels.len() as u64 } else { 0 };
            return Some(BakedTexels { values: without_cache, rays, gathers, cache: None });
        }
        let options = &self.options.cache;
        let (mut gathers, mut first) = (0, None);
        if self.uses_first_map() {
            let (map, records, traced) = self.first_map(texels, &without_cache)?;
            (gathers, rays) = (gathers + records, rays + traced);
            first = Some(map);
        }
        let source = first.as_ref().map_or(GatherSource::paths(options), |map| GatherSource::Map(map));
        let records = CheckpointedRecords { checkpoint: self.checkpoint, stage: Stage::Records };
        let (frozen, filled) = self.fill(texels, (*options, self.options.seed), source, &records)?;
        let (mut values, traced) = self.interpolate(&frozen, texels, source)?;
        if self.options.mode == Mode::Full {
            values.add(&without_cache);
        }
        let usage = frozen.usage();
        gathers += usage.records + usage.misses;
        Some(BakedTexels { values, rays: rays + filled + traced, gathers, cache: Some((frozen.cache, usage)) })
    }

    /// What is kept of directions.
    pub(super) fn directional(&self) -> Directional {
        if self.options.mode == Mode::Ao { Directional::None } else { self.options.directional }
    }

    /// Vectors for each texel.
    pub(super) fn layers(&self) -> usize {
        1 + DirectionalBasis::layers(self.directional()).len()
    }

    fn is_indirect(&self) -> bool {
        matches!(self.options.mode, Mode::Full | Mode::Indirect)
    }

    pub(super) fn needs_cache(&self) -> bool {
        self.options.has_cache()
    }

    fn is_brute_force(&self) -> bool {
        self.is_indirect() && self.options.brute
    }

    pub(super) fn surface(&self, texel: &Texel) -> Surface<'_> {
        self.world.receiver(texel.point.prim_id, texel.point.barycentric)
    }

    fn basis(&self, texel: &Texel, surface: &Surface) -> DirectionalBasis {
        DirectionalBasis::new(self.directional(), surface.shading_normal, texel.tangents[0], texel.tangents[1])
    }

    /// Puts the light that needs no cache of a shard's texels into the checkpoint; `None` if the watcher says stop.
    pub(super) fn bake_shard(&self, texels: &[Texel], shard: Shard) -> Option<()> {
        self.checkpoint.put_shard(shard, false);
        let found = self.chunks_of(shard, Stage::Texels, texels, |texels| self.without_cache(texels));
        self.checkpoint.put_shard(shard, found.is_some());
        found.map(|_| ())
    }

    /// The values of texels, found in chunks on all threads, or known from before; and the rays of those that were not.
    pub(super) fn chunks(
        &self,
        stage: Stage,
        texels: &[Texel],
        find: impl Fn(&[(usize, Texel)]) -> (Values, u64) + Sync,
    ) -> Option<(Values, u64)> {
        self.chunks_of(Shard::ALL, stage, texels, find)
    }

    /// The same of the chunks of a shard alone.
    fn chunks_of(
        &self,
        shard: Shard,
        stage: Stage,
        texels: &[Texel],
        find: impl Fn(&[(usize, Texel)]) -> (Values, u64) + Sync,
    ) -> Option<(Values, u64)> {
        let layers = self.layers();
        let numbered: Vec<(usize, Texel)> = texels.iter().copied().enumerate().collect();
        let chunk = |(number, texels): (usize, &[(usize, Texel)])| {
            let known = self.checkpoint.get(stage, number as u64);
            if let Some(words) = known.filter(|words| words.len() == 3 * layers * texels.len()) {
                self.watch.advance(texels.len() as u64, 0);
                return Some((Values::from_words(layers, &words), 0));
            }
            if self.watch.stop() {
                return None;
            }
            let (values, rays) = find(texels);
            self.checkpoint.put(stage, number as u64, values.to_words());
            self.watch.advance(texels.len() as u64, rays);
            Some((values, rays))
        };
        let chunks = numbered.par_chunks(CHUNK).enumerate().filter(|(number, _)| shard.has(*number));
        let chunks: Vec<Option<(Values, u64)>> = chunks.map(chunk).collect();
        let chunks = chunks.into_iter().collect::<Option<Vec<_>>>()?;
        let rays = chunks.iter().map(|(_, rays)| rays).sum();
        Some((Values::joined(layers, chunks.into_iter().map(|(values, _)| values)), rays))
    }

    /// What texels find without a cache.
    fn without_cache(&self, texels: &[(usize, Texel)]) -> (Values, u64) {
        let (mut values, mut rays) = match self.options.mode {
            Mode::Ao => self.ambient_occlusion(texels),
            Mode::Full | Mode::Direct => self.direct(texels),
            Mode::Indirect if self.uses_first_map() => self.direct(texels),
            Mode::Indirect => (Values::of(self.layers(), texels.iter().map(|_| (Vec3::ZERO, [DVec3::ZERO; 4]))), 0),
        };
        if self.is_brute_force() {
            let (gathered, traced) = self.gather(texels, GatherSource::paths(&self.options.cache));
            values.add(&gathered);
            rays += traced;
        }
        (values, rays)
    }

    /// How open texels are.
    fn ambient_occlusion(&self, texels: &[(usize, Texel)]) -> (Values, u64) {
        let Self { world, options, .. } = self;
        let mut ambient_occlusion = AmbientOcclusion::new(options.spp, options.ao_distance);
        let mut rays = 0;
        let open = texels.iter().map(|(number, texel)| {
            let (open, traced) = ambient_occlusion.at(world, &self.surface(texel), options.seed, *number as u32);
            rays += traced;
            (Vec3::splat(open), [DVec3::ZERO; 4])
        });
        (Values::of(1, open), rays)
    }

    /// What lights send to texels.
    fn direct(&self, texels: &[(usize, Texel)]) -> (Values, u64) {
        let Self { world, options, .. } = self;
        let mut incident = IncidentSampler::default();
        let mut rays = 0;
        let received = texels.iter().map(|(number, texel)| {
            let surface = self.surface(texel);
            let (normal, basis) = (surface.shading_normal, self.basis(texel, &surface));
            let mut sums = Sums { normal, basis, irradiance: DVec3::ZERO, moments: [DVec3::ZERO; 4] };
            let address = (options.seed, *number as u32);
            let (surfaces, traced) = footprint(world, self.surfaces, texel);
            rays += traced + incident.sample(world, &surfaces, address, options.spp, &mut sums);
            (sums.irradiance.as_vec3(), sums.moments)
        });
        (Values::of(self.layers(), received), rays)
    }

    /// What texels gather.
    pub(super) fn gather(&self, texels: &[(usize, Texel)], source: GatherSource) -> (Values, u64) {
        let Self { world, options, .. } = self;
        let point =
            |(number, texel): &(usize, Texel)| GatherPoint { key: *number as u64, surface: self.surface(texel) };
        let points: Vec<GatherPoint> = texels.iter().map(point).collect();
        let (irradiance, rays) = Uncached::new(world, &options.cache, source, options.seed).irradiance(&points);
        let (moments, further) = self.gather_moments(texels);
        (Values::of(self.layers(), irradiance.into_iter().zip(moments)), rays + further)
    }

    /// The moments that texels gather; zeros if there is nothing to keep.
    pub(super) fn gather_moments(&self, texels: &[(usize, Texel)]) -> (Vec<[DVec3; 4]>, u64) {
        let mut moments = vec![[DVec3::ZERO; 4]; texels.len()];
        if self.directional() == Directional::None {
            return (moments, 0);
        }
        let mut gatherer = Moments::new(&self.options.cache, self.options.seed);
        let mut rays = 0;
        for ((number, texel), sums) in texels.iter().zip(&mut moments) {
            let surface = self.surface(texel);
            let basis = self.basis(texel, &surface);
            rays += gatherer.gather(self.world, &surface, &basis, *number as u32, sums);
        }
        (moments, rays)
    }
}
