//! The light of every texel.
//!
//! Direct light is sampled at every texel. What surfaces reflect, and the sky, comes from an irradiance cache in space: texels
//! of different charts that lie side by side there share records, which a cache in the plane of the map could not. Without a
//! cache every texel gathers for itself, with the same rays that a record there would have.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::direct::{Direct, Receive};
use super::journal::{Journal, Stage};
use super::moments::{Lens, Moments};
use super::openness::Openness;
use super::options::{BakeOptions, Directional, Mode};
use super::texels::Texel;
use crate::cache::Cache;
use crate::driver::{CacheUse, Watch};
use crate::estimator::GatherPoint;
use crate::integrator::{Frozen, Uncached, fill_for_texels};
use crate::world::{Surface, World};

/// Texels that a thread takes at once.
const BLOCK: usize = 64;

/// What a bake works with.
pub(super) struct Job<'a> {
    pub(super) world: &'a World,
    pub(super) options: &'a BakeOptions,
    pub(super) journal: &'a Journal,
    pub(super) watch: &'a dyn Watch,
}

/// The light of texels.
pub(super) struct Light {
    /// For each texel irradiance, then the moments that are asked for.
    values: Values,
    /// Rays traced now.
    pub(super) rays: u64,
    /// Gathers: of the texels, or of the cache's records.
    pub(super) gathers: u64,
    /// The cache with its use.
    pub(super) cache: Option<(Cache, CacheUse)>,
}

/// As many vectors for each texel, one after the other.
#[derive(Clone, Debug, Default)]
struct Values {
    layers: usize,
    all: Vec<Vec3>,
}

impl Light {
    /// Vectors for each texel.
    pub(super) fn layers(&self) -> usize {
        self.values.layers
    }

    /// Those of each texel.
    pub(super) fn values(&self) -> impl Iterator<Item = &[Vec3]> {
        self.values.texels()
    }
}

impl Values {
    /// Of these irradiances and moments.
    fn of(layers: usize, texels: impl Iterator<Item = (Vec3, [DVec3; 4])>) -> Self {
        let vectors = |(irradiance, moments): (Vec3, [DVec3; 4])| {
            std::iter::once(irradiance).chain(moments.map(|moment| moment.as_vec3())).take(layers)
        };
        Self { layers, all: texels.flat_map(vectors).collect() }
    }

    fn texels(&self) -> impl Iterator<Item = &[Vec3]> {
        self.all.chunks_exact(self.layers)
    }

    fn add(&mut self, other: &Self) {
        self.all.iter_mut().zip(&other.all).for_each(|(value, other)| *value += *other);
    }

    fn to_words(&self) -> Vec<u32> {
        self.all.iter().flat_map(|value| value.to_array()).map(f32::to_bits).collect()
    }

    fn from_words(layers: usize, words: &[u32]) -> Self {
        let vector = |v: &[u32]| Vec3::from_array([0, 1, 2].map(|i| f32::from_bits(v[i])));
        Self { layers, all: words.chunks_exact(3).map(vector).collect() }
    }
}

/// Irradiance and moments of direct light.
struct Sums {
    normal: Vec3,
    lens: Lens,
    irradiance: DVec3,
    moments: [DVec3; 4],
}

impl Receive for Sums {
    fn receive(&mut self, direction: Vec3, irradiance: Vec3) {
        self.irradiance += irradiance.as_dvec3();
        let cosine = self.normal.dot(direction);
        if cosine > 0.0 {
            self.lens.add(direction, irradiance / cosine, &mut self.moments);
        }
    }
}

impl Job<'_> {
    /// The light of `texels`; `None` if the watcher says stop.
    pub(super) fn light(&self, texels: &[Texel]) -> Option<Light> {
        let (mut values, mut rays) = self.blocks(Stage::Texels, texels, |texels| self.alone(texels))?;
        let mut gathers = if self.gathers_alone() { texels.len() as u64 } else { 0 };
        let mut cache = None;
        if self.needs_cache() {
            let (frozen, filled) = self.fill(texels)?;
            let (indirect, traced) = self.interpolate(&frozen, texels)?;
            values.add(&indirect);
            rays += filled + traced;
            let usage = frozen.usage();
            gathers = usage.records + usage.misses;
            cache = Some((frozen.cache, usage));
        }
        Some(Light { values, rays, gathers, cache })
    }

    /// What is kept of directions.
    fn directional(&self) -> Directional {
        if self.options.mode == Mode::Ao { Directional::None } else { self.options.directional }
    }

    /// Vectors for each texel.
    fn layers(&self) -> usize {
        1 + Lens::layers(self.directional()).len()
    }

    fn is_indirect(&self) -> bool {
        matches!(self.options.mode, Mode::Full | Mode::Indirect)
    }

    fn needs_cache(&self) -> bool {
        self.is_indirect() && !self.options.brute
    }

    fn gathers_alone(&self) -> bool {
        self.is_indirect() && self.options.brute
    }

    fn surface(&self, texel: &Texel) -> Surface<'_> {
        self.world.receiver(texel.point.prim_id, texel.point.barycentric)
    }

    fn lens(&self, texel: &Texel, surface: &Surface) -> Lens {
        Lens::new(self.directional(), surface.shading_normal, texel.tangents[0], texel.tangents[1])
    }

    /// The values of texels, found in blocks on all threads, or known from before; and the rays of those that were not.
    fn blocks(
        &self,
        stage: Stage,
        texels: &[Texel],
        find: impl Fn(&[(usize, Texel)]) -> (Values, u64) + Sync,
    ) -> Option<(Values, u64)> {
        let layers = self.layers();
        let numbered: Vec<(usize, Texel)> = texels.iter().copied().enumerate().collect();
        let block = |(number, texels): (usize, &[(usize, Texel)])| {
            let known = self.journal.get(stage, number as u64);
            if let Some(words) = known.filter(|words| words.len() == 3 * layers * texels.len()) {
                self.watch.advance(texels.len() as u64, 0);
                return Some((Values::from_words(layers, &words), 0));
            }
            if self.watch.stop() {
                return None;
            }
            let (values, rays) = find(texels);
            self.journal.put(stage, number as u64, values.to_words());
            self.watch.advance(texels.len() as u64, rays);
            Some((values, rays))
        };
        let blocks: Vec<Option<(Values, u64)>> = numbered.par_chunks(BLOCK).enumerate().map(block).collect();
        let blocks = blocks.into_iter().collect::<Option<Vec<_>>>()?;
        let rays = blocks.iter().map(|(_, rays)| rays).sum();
        Some((Values { layers, all: blocks.into_iter().flat_map(|(values, _)| values.all).collect() }, rays))
    }

    /// What texels find without a cache.
    fn alone(&self, texels: &[(usize, Texel)]) -> (Values, u64) {
        let (mut values, mut rays) = match self.options.mode {
            Mode::Ao => self.openness(texels),
            Mode::Full | Mode::Direct => self.direct(texels),
            Mode::Indirect => (Values::of(self.layers(), texels.iter().map(|_| (Vec3::ZERO, [DVec3::ZERO; 4]))), 0),
        };
        if self.gathers_alone() {
            let (gathered, traced) = self.gather(texels);
            values.add(&gathered);
            rays += traced;
        }
        (values, rays)
    }

    /// How open texels are.
    fn openness(&self, texels: &[(usize, Texel)]) -> (Values, u64) {
        let Self { world, options, .. } = self;
        let mut openness = Openness::new(options.spp, options.ao_distance);
        let mut rays = 0;
        let open = texels.iter().map(|(number, texel)| {
            let (open, traced) = openness.at(world, &self.surface(texel), options.seed, *number as u32);
            rays += traced;
            (Vec3::splat(open), [DVec3::ZERO; 4])
        });
        (Values::of(1, open), rays)
    }

    /// What lights send to texels.
    fn direct(&self, texels: &[(usize, Texel)]) -> (Values, u64) {
        let Self { world, options, .. } = self;
        let mut direct = Direct::default();
        let mut rays = 0;
        let received = texels.iter().map(|(number, texel)| {
            let surface = self.surface(texel);
            let (normal, lens) = (surface.shading_normal, self.lens(texel, &surface));
            let mut sums = Sums { normal, lens, irradiance: DVec3::ZERO, moments: [DVec3::ZERO; 4] };
            let address = (options.seed, *number as u32);
            rays += direct.sample(world, &surface, address, options.spp, &mut sums);
            (sums.irradiance.as_vec3(), sums.moments)
        });
        (Values::of(self.layers(), received), rays)
    }

    /// What texels gather.
    fn gather(&self, texels: &[(usize, Texel)]) -> (Values, u64) {
        let Self { world, options, .. } = self;
        let point =
            |(number, texel): &(usize, Texel)| GatherPoint { key: *number as u64, surface: self.surface(texel) };
        let points: Vec<GatherPoint> = texels.iter().map(point).collect();
        let (irradiance, rays) = Uncached::new(world, &options.cache, options.seed).irradiance(&points);
        let (moments, further) = self.gather_moments(texels);
        (Values::of(self.layers(), irradiance.into_iter().zip(moments)), rays + further)
    }

    /// The moments that texels gather; zeros if there is nothing to keep.
    fn gather_moments(&self, texels: &[(usize, Texel)]) -> (Vec<[DVec3; 4]>, u64) {
        let mut moments = vec![[DVec3::ZERO; 4]; texels.len()];
        if self.directional() == Directional::None {
            return (moments, 0);
        }
        let mut gatherer = Moments::new(&self.options.cache, self.options.seed);
        let mut rays = 0;
        for ((number, texel), sums) in texels.iter().zip(&mut moments) {
            let surface = self.surface(texel);
            let lens = self.lens(texel, &surface);
            rays += gatherer.gather(self.world, &surface, &lens, *number as u32, sums);
        }
        (moments, rays)
    }

    /// A cache that serves all texels, and its rays; `None` if it was stopped.
    fn fill(&self, texels: &[Texel]) -> Option<(Frozen, u64)> {
        let Self { world, options, journal, watch } = *self;
        let surfaces: Vec<(Surface, f32)> = texels.iter().map(|texel| (self.surface(texel), texel.spacing)).collect();
        let cache = Cache::new(options.cache, world.surroundings_hash());
        let filled = fill_for_texels(world, options.seed, cache, &surfaces, journal, watch);
        (!watch.stop()).then_some(filled)
    }

    /// Indirect light of all texels from a cache; those without a record gather.
    fn interpolate(&self, frozen: &Frozen, texels: &[Texel]) -> Option<(Values, u64)> {
        let (moments, mut rays) = self.moments_of_records(frozen, texels)?;
        let moments: Vec<&[Vec3]> = moments.texels().collect();
        let found: Vec<Option<(Vec3, [DVec3; 4])>> = texels
            .par_iter()
            .map(|texel| {
                let surface = self.surface(texel);
                let irradiance = frozen.irradiance(&surface)?;
                let (mut sums, mut weights) = ([DVec3::ZERO; 4], 0.0);
                if !moments.is_empty() {
                    frozen.cache.weigh(surface.position, surface.shading_normal, |record, weight| {
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
        let (gathered, traced) = self.blocks(Stage::Missing, &lost, |texels| {
            let texels: Vec<(usize, Texel)> = texels.iter().map(|&(i, texel)| (missing[i], texel)).collect();
            self.gather(&texels)
        })?;
        rays += traced;
        let layers = values.layers;
        for (i, gathered) in missing.into_iter().zip(gathered.texels()) {
            values.all[i * layers..(i + 1) * layers].copy_from_slice(gathered);
        }
        Some((values, rays))
    }

    /// The moments at each record, behind an empty irradiance; nothing if there is nothing to keep.
    fn moments_of_records(&self, frozen: &Frozen, texels: &[Texel]) -> Option<(Values, u64)> {
        if self.directional() == Directional::None {
            return Some((Values { layers: 1, all: Vec::new() }, 0));
        }
        let keys: Vec<usize> = frozen.cache.records().iter().map(|record| record.key as usize).collect();
        let points: Vec<Texel> = keys.iter().map(|&key| texels[key]).collect();
        self.blocks(Stage::Moments, &points, |points| {
            let points: Vec<(usize, Texel)> = points.iter().map(|&(i, texel)| (keys[i], texel)).collect();
            let (moments, rays) = self.gather_moments(&points);
            (Values::of(self.layers(), moments.into_iter().map(|moments| (Vec3::ZERO, moments))), rays)
        })
    }
}
