//! The light of every texel.
//!
//! Direct light, with the sun of a sky picture, is sampled at every texel. Light reflected by surfaces, and the rest of
//! the sky, comes from an irradiance cache in space: neighbouring texels of different charts share records, which a
//! cache in the plane of the map could not do.
//!
//! Without a cache every texel gathers for itself, by paths, with as many rays as a record would have.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::ao::AmbientOcclusion;
use super::direct_points::direct_points;
use super::moments::{DirectionalBasis, Moments};
use super::values::Values;
use crate::bake::files::checkpoint::{Checkpoint, CheckpointedRecords, Stage};
use crate::bake::layout::texels::{Surfaces, Texel};
use crate::bake::options::{BakeOptions, Directional, Mode};
use crate::cache::Cache;
use crate::estimator::{GatherPoint, IncidentSampler, IncidentSink, RoundsMean, mean_in_rounds};
use crate::integrator::CacheUse;
use crate::integrator::{DirectGatherer, FillTarget, GatherSource, HeldOut, MeanLight, SAMPLED_SHARE};
use crate::settings::Shard;
use crate::watch::Watch;
use crate::world::{Surface, World};

/// Texels that a thread takes at once.
const CHUNK: usize = 64;

/// The state of a bake.
pub(crate) struct Baker<'a> {
    pub(crate) world: &'a World,
    pub(crate) surfaces: &'a Surfaces<'a>,
    pub(crate) options: &'a BakeOptions,
    pub(crate) checkpoint: &'a Checkpoint,
    pub(crate) watch: &'a dyn Watch,
}

/// The light of texels.
pub(crate) struct BakedTexels {
    /// For each texel irradiance, then the moments that are asked for.
    values: Values,
    /// Rays traced now.
    pub(crate) rays: u64,
    /// Gathers: of the texels, or of the cache's records.
    pub(crate) gathers: u64,
    /// The cache with its use.
    pub(crate) cache: Option<(Cache, CacheUse)>,
    /// An estimate of the root mean square error, relative to the mean, if an accuracy was requested.
    pub(crate) error: Option<f32>,
}

/// The values of a chunk's texels, and their cost.
#[derive(Default)]
pub(crate) struct Found {
    pub(crate) values: Values,
    pub(crate) rays: u64,
    /// The sum of the variances of irradiance, as far as they are known, in W²/m⁴.
    pub(crate) variance: f64,
}

impl BakedTexels {
    /// Vectors for each texel.
    pub(crate) fn layers(&self) -> usize {
        self.values.layers()
    }

    /// The values of each texel.
    pub(crate) fn values(&self) -> impl Iterator<Item = &[Vec3]> {
        self.values.texels()
    }
}

impl Found {
    /// The values of texels and their variance, as a checkpoint has them.
    fn to_words(&self) -> Vec<u32> {
        let bits = self.variance.to_bits();
        let mut words = self.values.to_words();
        words.extend([bits as u32, (bits >> 32) as u32]);
        words
    }

    /// The same of `count` texels; `None` if it is something else.
    fn from_words(layers: usize, count: usize, words: &[u32]) -> Option<Self> {
        let (values, &[low, high]) = words.split_last_chunk::<2>()?;
        let variance = f64::from_bits(u64::from(high) << 32 | u64::from(low));
        let values = (values.len() == 3 * layers * count).then(|| Values::from_words(layers, values))?;
        Some(Self { values, rays: 0, variance })
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

/// The allowed noise of direct light, in W/m².
fn direct_noise(held_out: &HeldOut) -> f64 {
    SAMPLED_SHARE.sqrt() * held_out.allowed_error()
}

impl Baker<'_> {
    /// The light of `texels`; `None` if the watcher stops.
    pub(crate) fn bake_texels(&self, texels: &[Texel]) -> Option<BakedTexels> {
        let held_out = self.held_out(texels)?;
        let noise = held_out.as_ref().map(direct_noise);
        let found = self.chunks(Stage::Texels, texels, |texels| self.without_cache(texels, noise))?;
        let (without_cache, variance) = (found.values, found.variance / texels.len().max(1) as f64);
        let mut rays = found.rays + held_out.as_ref().map_or(0, |held_out| held_out.traced);
        if !self.needs_cache() {
            let gathers = if self.is_brute_force() { texels.len() as u64 } else { 0 };
            let error = held_out.map(|held_out| held_out.relative(variance));
            return Some(BakedTexels { values: without_cache, rays, gathers, cache: None, error });
        }
        let aim = held_out.as_ref().map_or(FillTarget::Options, FillTarget::Accuracy);
        let options = &self.options.cache;
        let (mut gathers, mut first) = (0, None);
        if self.uses_first_map() {
            let (map, records, traced) = self.first_map(texels, &without_cache)?;
            (gathers, rays) = (gathers + records, rays + traced);
            first = Some(map);
        }
        let source = first.as_ref().map_or(GatherSource::paths(options), |map| GatherSource::Map(map));
        let records = CheckpointedRecords { checkpoint: self.checkpoint, stage: Stage::Records };
        let (frozen, filled) = self.fill(texels, (*options, self.options.seed), (source, aim), &records)?;
        let (mut values, traced) = self.interpolate(&frozen, texels, source)?;
        if self.options.mode == Mode::Full {
            values.add(&without_cache);
        }
        let usage = frozen.usage();
        gathers += usage.records + usage.misses;
        let sampled = if self.options.mode == Mode::Full { variance } else { 0.0 };
        let error = frozen.cache.estimate().map(|estimate| estimate.with(sampled));
        Some(BakedTexels { values, rays: rays + filled + traced, gathers, cache: Some((frozen.cache, usage)), error })
    }

    /// What is true at some of the texels, if an accuracy is requested; the outer `None` if the watcher stops.
    #[allow(clippy::option_option, reason = "the outer one is for `?`")]
    fn held_out(&self, texels: &[Texel]) -> Option<Option<HeldOut<'_>>> {
        let light = match self.options.mode {
            Mode::Full => MeanLight::Total,
            Mode::Direct => MeanLight::Direct,
            Mode::Indirect => MeanLight::Indirect,
            Mode::Ao => return Some(None),
        };
        if self.options.cache.accuracy.is_none() {
            return Some(None);
        }
        let points = (texels.len(), |i: usize| self.surface(&texels[i]));
        HeldOut::new(self.world, &self.options.cache, points, light, self.options.seed, self.watch).map(Some)
    }

    /// The directional components.
    pub(crate) fn directional(&self) -> Directional {
        if self.options.mode == Mode::Ao { Directional::None } else { self.options.directional }
    }

    /// Vectors for each texel.
    pub(crate) fn layers(&self) -> usize {
        1 + DirectionalBasis::layers(self.directional()).len()
    }

    fn is_indirect(&self) -> bool {
        matches!(self.options.mode, Mode::Full | Mode::Indirect)
    }

    pub(crate) fn needs_cache(&self) -> bool {
        self.options.has_cache()
    }

    fn is_brute_force(&self) -> bool {
        self.is_indirect() && self.options.brute
    }

    pub(crate) fn surface(&self, texel: &Texel) -> Surface<'_> {
        self.world.receiver(texel.point.prim_id, texel.point.barycentric)
    }

    fn basis(&self, texel: &Texel, surface: &Surface) -> DirectionalBasis {
        DirectionalBasis::new(self.directional(), surface.shading_normal, texel.tangents[0], texel.tangents[1])
    }

    /// Puts the light that needs no cache of a shard's texels into the checkpoint; `None` if the watcher stops.
    pub(crate) fn bake_shard(&self, texels: &[Texel], shard: Shard) -> Option<()> {
        self.checkpoint.put_shard(shard, false);
        let held_out = self.held_out(texels)?;
        let noise = held_out.as_ref().map(direct_noise);
        let found = self.chunks_of(shard, Stage::Texels, texels, |texels| self.without_cache(texels, noise));
        self.checkpoint.put_shard(shard, found.is_some());
        found.map(|_| ())
    }

    /// The values of texels, found in chunks on all threads, or known from before; and the rays of those that were not.
    pub(crate) fn chunks(
        &self,
        stage: Stage,
        texels: &[Texel],
        find: impl Fn(&[(usize, Texel)]) -> Found + Sync,
    ) -> Option<Found> {
        self.chunks_of(Shard::ALL, stage, texels, find)
    }

    /// The same of the chunks of a shard alone.
    fn chunks_of(
        &self,
        shard: Shard,
        stage: Stage,
        texels: &[Texel],
        find: impl Fn(&[(usize, Texel)]) -> Found + Sync,
    ) -> Option<Found> {
        let layers = self.layers();
        let numbered: Vec<(usize, Texel)> = texels.iter().copied().enumerate().collect();
        let chunk = |(number, texels): (usize, &[(usize, Texel)])| {
            let known = self.checkpoint.get(stage, number as u64);
            if let Some(found) = known.and_then(|words| Found::from_words(layers, texels.len(), &words)) {
                self.watch.advance(texels.len() as u64, 0);
                return Some(found);
            }
            if self.watch.stop() {
                return None;
            }
            let found = find(texels);
            self.checkpoint.put(stage, number as u64, found.to_words());
            self.watch.advance(texels.len() as u64, found.rays);
            Some(found)
        };
        let chunks = numbered.par_chunks(CHUNK).enumerate().filter(|(number, _)| shard.has(*number));
        let chunks: Vec<Option<Found>> = chunks.map(chunk).collect();
        let chunks = chunks.into_iter().collect::<Option<Vec<_>>>()?;
        let rays = chunks.iter().map(|found| found.rays).sum();
        let variance = chunks.iter().map(|found| found.variance).sum();
        Some(Found { values: Values::joined(layers, chunks.into_iter().map(|found| found.values)), rays, variance })
    }

    /// What texels find without a cache, with this much noise of direct light in W/m² or with the samples of the
    /// options.
    fn without_cache(&self, texels: &[(usize, Texel)], noise: Option<f64>) -> Found {
        let mut found = match self.options.mode {
            Mode::Ao => self.ambient_occlusion(texels),
            Mode::Full | Mode::Direct => self.direct(texels, noise),
            Mode::Indirect if self.uses_first_map() => self.direct(texels, noise),
            Mode::Indirect => {
                let nothing = texels.iter().map(|_| (Vec3::ZERO, [DVec3::ZERO; 4]));
                Found { values: Values::of(self.layers(), nothing), ..Found::default() }
            }
        };
        if self.is_brute_force() {
            let gathered = self.gather(texels, GatherSource::paths(&self.options.cache));
            found.values.add(&gathered.values);
            found.rays += gathered.rays;
        }
        found
    }

    /// The openness of texels.
    fn ambient_occlusion(&self, texels: &[(usize, Texel)]) -> Found {
        let Self { world, options, .. } = self;
        let mut ambient_occlusion = AmbientOcclusion::new(options.spp, options.ao_distance);
        let mut rays = 0;
        let open = texels.iter().map(|(number, texel)| {
            let (open, traced) = ambient_occlusion.at(world, &self.surface(texel), options.seed, *number as u32);
            rays += traced;
            (Vec3::splat(open), [DVec3::ZERO; 4])
        });
        let values = Values::of(1, open);
        Found { values, rays, variance: 0.0 }
    }

    /// The direct light of texels.
    fn direct(&self, texels: &[(usize, Texel)], noise: Option<f64>) -> Found {
        let Self { world, options, .. } = self;
        let mut incident = IncidentSampler::default();
        let (mut rays, mut variance) = (0, 0.0);
        let received = texels.iter().map(|(number, texel)| {
            let surface = self.surface(texel);
            let (normal, basis) = (surface.shading_normal, self.basis(texel, &surface));
            let mut sums = Sums { normal, basis, irradiance: DVec3::ZERO, moments: [DVec3::ZERO; 4] };
            let (surfaces, traced) = direct_points(world, self.surfaces, texel);
            rays += traced;
            let mut sample = |seed, samples, share| {
                let address = (seed, *number as u32);
                rays += incident.sample(world, &surfaces, address, (samples, share), &mut sums);
                sums.irradiance
            };
            let Some(noise) = noise else {
                sample(options.seed, 0..options.spp, 1.0 / options.spp as f32);
                return (sums.irradiance.as_vec3(), sums.moments);
            };
            let mut before = DVec3::ZERO;
            let found: RoundsMean = mean_in_rounds(
                options.seed,
                |_| noise,
                |seed, samples| {
                    let all = sample(seed, samples, 1.0);
                    all - std::mem::replace(&mut before, all)
                },
            );
            variance += found.variance;
            (found.mean.as_vec3(), sums.moments.map(|moment| moment / f64::from(found.samples)))
        });
        let values = Values::of(self.layers(), received);
        Found { values, rays, variance }
    }

    /// The indirect light of texels.
    pub(crate) fn gather(&self, texels: &[(usize, Texel)], source: GatherSource) -> Found {
        let Self { world, options, .. } = self;
        let point =
            |(number, texel): &(usize, Texel)| GatherPoint { key: *number as u64, surface: self.surface(texel) };
        let points: Vec<GatherPoint> = texels.iter().map(point).collect();
        let (irradiance, rays) = DirectGatherer::new(world, &options.cache, source, options.seed).irradiance(&points);
        let (moments, further) = self.gather_moments(texels);
        let values = Values::of(self.layers(), irradiance.into_iter().zip(moments));
        Found { values, rays: rays + further, variance: 0.0 }
    }

    /// The moments that texels gather; zeros if there is nothing to keep.
    pub(crate) fn gather_moments(&self, texels: &[(usize, Texel)]) -> (Vec<[DVec3; 4]>, u64) {
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
