//! The light of every texel.
//!
//! Direct light is sampled at every texel, and with it the sun of a sky's picture. What surfaces reflect, and the rest of the
//! sky, comes from an irradiance cache in space: texels of different charts that lie side by side there share records, which a cache in the plane of the map could not.
//!
//! Without a cache every texel gathers for itself, by paths, with as many rays as a record would have.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::footprint::footprint;
use super::journal::{Journal, Notes, Stage};
use super::moments::{Lens, Moments};
use super::openness::Openness;
use super::options::{BakeOptions, Directional, Mode};
use super::texels::{Surfaces, Texel};
use super::values::Values;
use crate::cache::Cache;
use crate::driver::{CacheUse, Watch};
use crate::estimator::{GatherPoint, Incident, Receive};
use crate::integrator::{Source, Uncached};
use crate::world::{Surface, World};

/// Texels that a thread takes at once.
const BLOCK: usize = 64;

/// What a bake works with.
pub(super) struct Job<'a> {
    pub(super) world: &'a World,
    pub(super) surfaces: &'a Surfaces<'a>,
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

impl Light {
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
        let (alone, mut rays) = self.blocks(Stage::Texels, texels, |texels| self.alone(texels))?;
        if !self.needs_cache() {
            let gathers = if self.gathers_alone() { texels.len() as u64 } else { 0 };
            return Some(Light { values: alone, rays, gathers, cache: None });
        }
        let options = &self.options.cache;
        let (mut gathers, mut first) = (0, None);
        if self.looks_up() {
            let (map, records, traced) = self.first_map(texels, &alone)?;
            (gathers, rays) = (gathers + records, rays + traced);
            first = Some(map);
        }
        let source = first.as_ref().map_or(Source::paths(options), |map| Source::Known(map));
        let notes = Notes { journal: self.journal, stage: Stage::Records };
        let (frozen, filled) = self.fill(texels, (*options, self.options.seed), source, &notes)?;
        let (mut values, traced) = self.interpolate(&frozen, texels, source)?;
        if self.options.mode == Mode::Full {
            values.add(&alone);
        }
        let usage = frozen.usage();
        gathers += usage.records + usage.misses;
        Some(Light { values, rays: rays + filled + traced, gathers, cache: Some((frozen.cache, usage)) })
    }

    /// What is kept of directions.
    pub(super) fn directional(&self) -> Directional {
        if self.options.mode == Mode::Ao { Directional::None } else { self.options.directional }
    }

    /// Vectors for each texel.
    pub(super) fn layers(&self) -> usize {
        1 + Lens::layers(self.directional()).len()
    }

    fn is_indirect(&self) -> bool {
        matches!(self.options.mode, Mode::Full | Mode::Indirect)
    }

    pub(super) fn needs_cache(&self) -> bool {
        self.options.has_cache()
    }

    fn gathers_alone(&self) -> bool {
        self.is_indirect() && self.options.brute
    }

    pub(super) fn surface(&self, texel: &Texel) -> Surface<'_> {
        self.world.receiver(texel.point.prim_id, texel.point.barycentric)
    }

    fn lens(&self, texel: &Texel, surface: &Surface) -> Lens {
        Lens::new(self.directional(), surface.shading_normal, texel.tangents[0], texel.tangents[1])
    }

    /// The values of texels, found in blocks on all threads, or known from before; and the rays of those that were not.
    pub(super) fn blocks(
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
        Some((Values::joined(layers, blocks.into_iter().map(|(values, _)| values)), rays))
    }

    /// What texels find without a cache.
    fn alone(&self, texels: &[(usize, Texel)]) -> (Values, u64) {
        let (mut values, mut rays) = match self.options.mode {
            Mode::Ao => self.openness(texels),
            Mode::Full | Mode::Direct => self.direct(texels),
            Mode::Indirect if self.looks_up() => self.direct(texels),
            Mode::Indirect => (Values::of(self.layers(), texels.iter().map(|_| (Vec3::ZERO, [DVec3::ZERO; 4]))), 0),
        };
        if self.gathers_alone() {
            let (gathered, traced) = self.gather(texels, Source::paths(&self.options.cache));
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
        let mut incident = Incident::default();
        let mut rays = 0;
        let received = texels.iter().map(|(number, texel)| {
            let surface = self.surface(texel);
            let (normal, lens) = (surface.shading_normal, self.lens(texel, &surface));
            let mut sums = Sums { normal, lens, irradiance: DVec3::ZERO, moments: [DVec3::ZERO; 4] };
            let address = (options.seed, *number as u32);
            let (surfaces, traced) = footprint(world, self.surfaces, texel);
            rays += traced + incident.sample(world, &surfaces, address, options.spp, &mut sums);
            (sums.irradiance.as_vec3(), sums.moments)
        });
        (Values::of(self.layers(), received), rays)
    }

    /// What texels gather.
    pub(super) fn gather(&self, texels: &[(usize, Texel)], source: Source) -> (Values, u64) {
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
            let lens = self.lens(texel, &surface);
            rays += gatherer.gather(self.world, &surface, &lens, *number as u32, sums);
        }
        (moments, rays)
    }
}
