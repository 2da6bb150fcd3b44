//! A gather: the light that a point receives, by a ray through each cell of its hemisphere.
//!
//! Direct light is excluded: a gather collects light *reflected by surfaces*, and the sky without its sun, which is as
//! smooth and is not sampled elsewhere with a cache. Paths or a cache provide the radiance along the rays; this module
//! makes rays and sums up their results. Many gathers run together, so that rays are traced in large batches.
//!
//! Secondary lights, which few cells would hit, are [sampled](super::aimed_rays), and their light has
//! its own gradients and second derivatives.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::irradiance::{Gather, Hemicube, Hessian, Layout, PointSource, Stratified};
use halfdome_kernel::sampling::{Frame, Pattern, SampleId, Sampler, Strata};

use super::aimed_rays::{AimedFrom, AimedRays};
use super::follow::Follow;
use super::occluders::OccluderSectors;
use super::salts;
use crate::settings::GatherLayout;
use crate::world::{Hit, Surface, World};

/// The set of random numbers for the position of a ray in its cell. Later sets are for the paths that follow the rays.
const JITTER_SET: u32 = 0;
/// The first set of random numbers that is free for the paths that follow the rays.
pub(crate) const GATHER_FIRST_SET: u32 = 1;
/// Rays that are traced together, about.
const BATCH: usize = 2048;

/// A point that gathers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GatherPoint<'w> {
    /// The address of its random numbers.
    pub(crate) key: u64,
    /// Its surface, with normals on the side that is lit.
    pub(crate) surface: Surface<'w>,
}

impl GatherPoint<'_> {
    /// The same without what maps do to its normals.
    pub(crate) fn smooth(self) -> Self {
        Self { surface: self.surface.smooth(), ..self }
    }
}

/// The result of a gather.
#[derive(Clone, Debug)]
pub(crate) struct Gathered {
    /// Irradiance, gradients and distances, in world space.
    pub(crate) gather: Gather,
    /// The Hessian of irradiance, in the frame about the normal, if requested.
    pub(crate) hessian: Option<Hessian>,
    /// The occluders.
    pub(crate) occluders: OccluderSectors,
}

/// Makes gathers of one kind.
pub(crate) struct Gatherer {
    layout: Box<dyn Layout + Send + Sync>,
    with_hessian: bool,
    seed: u64,
}

/// The rays of several gathers, one after the other. The next batch uses the memory again.
#[derive(Default)]
struct GatherScratch {
    /// Directions in local coordinates.
    directions: Vec<Vec3>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    samplers: Vec<Sampler>,
    addresses: Vec<SampleId>,
    /// The position of each direction in its cell.
    jitter: Vec<Vec2>,
    radiance: Vec<Vec3>,
    distance: Vec<f32>,
    /// The sampling of secondary lights by each point, and its results.
    aimed_from: Vec<AimedFrom>,
    aimed: AimedRays,
}

impl Gatherer {
    /// Gathers of about `rays` rays each, with Hessians or without.
    pub(crate) fn new(layout: GatherLayout, rays: u32, with_hessian: bool, seed: u64) -> Self {
        let layout: Box<dyn Layout + Send + Sync> = match layout {
            GatherLayout::Stratified => {
                let strata = Strata::near(rays);
                let table = vec![0.0; Stratified::table_len(&strata)];
                Box::new(Stratified::new(strata, table).expect("the table is as long as needed"))
            }
            GatherLayout::Hemicube => {
                // 3 n² texels, n even.
                let size = (2.0 * (rays as f32 / 12.0).sqrt().round()).max(2.0) as u32;
                let table = vec![0.0; Hemicube::table_len(size)];
                Box::new(Hemicube::new(size, table).expect("an even size and a table as long as needed"))
            }
        };
        Self { layout, with_hessian, seed: seed ^ salts::GATHER }
    }

    /// The rays of a gather.
    pub(crate) fn rays(&self) -> usize {
        self.layout.cells()
    }

    /// Gathers at `points`; gives what each found, in their order, and the number of all rays.
    pub(crate) fn gather(
        &self,
        world: &World,
        points: &[GatherPoint],
        follow: &mut dyn Follow,
    ) -> (Vec<Gathered>, u64) {
        let mut batch = GatherScratch::default();
        let mut rays = 0;
        let gathers = points.chunks((BATCH / self.layout.cells()).max(1)).flat_map(|points| {
            rays += batch.trace(self, world, points, follow);
            let cells = self.layout.cells();
            let gathers: Vec<_> =
                points.iter().enumerate().map(|(i, point)| batch.sum(self, world, point, (i, i * cells))).collect();
            gathers
        });
        (gathers.collect(), rays)
    }
}

/// A key as the pixel of a sampler: the finalizer of SplitMix64 (Steele, Lea and Flood 2014), its upper half.
fn address(key: u64) -> u32 {
    let mixed = (key ^ key >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    (mixed >> 32) as u32
}

impl GatherScratch {
    /// Traces the rays of `points` and finds their radiance.
    fn trace(&mut self, gatherer: &Gatherer, world: &World, points: &[GatherPoint], follow: &mut dyn Follow) -> u64 {
        let cells = gatherer.layout.cells();
        self.directions.resize(points.len() * cells, Vec3::Z);
        self.rays.clear();
        self.samplers.clear();
        for point in points {
            let pixel = address(point.key);
            let sampler = |cell| Sampler::new(Pattern::Sobol, gatherer.seed, pixel, cell);
            self.samplers.extend((0..cells as u32).map(sampler));
        }
        self.addresses.clear();
        self.addresses.extend(self.samplers.iter().map(Sampler::address));
        self.jitter.resize(self.samplers.len(), Vec2::ZERO);
        if let Some(sampler) = self.samplers.first() {
            sampler.fill2(world.tree().isa(), JITTER_SET, &self.addresses, &mut self.jitter);
        }
        let parts = self.directions.chunks_exact_mut(cells).zip(self.jitter.chunks_exact(cells));
        for (point, (directions, jitter)) in points.iter().zip(parts) {
            gatherer.layout.directions(&mut |cell| jitter[cell], directions).expect("a direction for each cell");
            let frame = point.surface.frame();
            let origin = point.surface.origin_towards(point.surface.normal);
            let ray = |&local: &Vec3| Ray::new(origin, point.surface.above(frame.to_world(local)));
            self.rays.extend(directions.iter().map(ray));
        }
        self.hits.resize(self.rays.len(), Hit::MISS);
        self.radiance.clear();
        self.radiance.resize(self.rays.len(), Vec3::ZERO);
        world.intersect_many(&self.rays, &mut self.hits);
        let mut further = follow.follow(&self.rays, &self.hits, &self.samplers, &mut self.radiance);
        if world.lights.lit.has_any() {
            further += self.aim(gatherer, world, points, follow);
        }
        self.distance.clear();
        for ((ray, hit), radiance) in self.rays.iter().zip(&self.hits).zip(&mut self.radiance) {
            if !hit.is_hit() {
                *radiance = world.lights.sky.ambient(&world.lights.sky.view(ray.direction));
            }
            self.distance.push(if hit.is_hit() { hit.t } else { f32::INFINITY });
        }
        self.rays.len() as u64 + further
    }

    /// Samples secondary lights, with weights against the other rays; returns the number of rays.
    fn aim(&mut self, gatherer: &Gatherer, world: &World, points: &[GatherPoint], follow: &mut dyn Follow) -> u64 {
        let cells = gatherer.layout.cells();
        self.aimed.clear();
        self.aimed_from.clear();
        let rays = self.rays.chunks_exact(cells).zip(self.hits.chunks_exact(cells));
        for (i, ((point, (rays, hits)), radiance)) in
            points.iter().zip(rays).zip(self.radiance.chunks_exact_mut(cells)).enumerate()
        {
            let (surface, pixel) = (&point.surface, address(point.key));
            // Rays that are expected a steradian, as those of a cosine distribution.
            let others = |direction| surface.lambert(direction) * cells as f32;
            let from = AimedFrom::new(world, surface, cells);
            for ((ray, hit), radiance) in rays.iter().zip(hits).zip(radiance).filter(|((_, hit), _)| hit.is_hit()) {
                *radiance *= from.kept(world, ray, hit, others(ray.direction));
            }
            let sampler = |seed, number| Sampler::new(Pattern::Sobol, seed, pixel, number);
            self.aimed.push(world, (surface, &from), (i, gatherer.seed), sampler, others);
            self.aimed_from.push(from);
        }
        self.aimed.trace(world, follow)
    }

    /// Adds what rays found that were aimed at secondary lights.
    fn add_aimed(&self, world: &World, point: &GatherPoint, number: usize, found: &mut (Gather, Option<Hessian>)) {
        let (frame, count) = (point.surface.frame(), self.aimed_from[number].count() as f32);
        let (mut sum, mut squares) = (Vec3::ZERO, Vec3::ZERO);
        for lit in self.aimed.found(world, number) {
            let direction = frame.to_local(lit.direction);
            let irradiance = lit.flux * (PI * point.surface.lambert(lit.direction));
            let source =
                PointSource { to_point: direction * lit.distance, normal: frame.to_local(lit.normal), irradiance };
            found.0.add_source(&source);
            if let Some(hessian) = &mut found.1 {
                hessian.add_source(&source);
            }
            (sum, squares) = (sum + irradiance, squares + irradiance * irradiance);
        }
        // The variance of a sum of so many independent samples.
        let variance = (squares - sum * sum / count.max(1.0)).max_element().max(0.0);
        found.0.standard_error = found.0.standard_error.hypot(variance.sqrt());
    }

    /// Sums up the rays of gather `number`, which begin with number `first`.
    fn sum(
        &self,
        gatherer: &Gatherer,
        world: &World,
        point: &GatherPoint,
        (number, first): (usize, usize),
    ) -> Gathered {
        let range = first..first + gatherer.layout.cells();
        let directions = &self.directions[range.clone()];
        let (rays, hits) = (&self.rays[range.clone()], &self.hits[range.clone()]);
        let (radiance, distance) = (&self.radiance[range.clone()], &self.distance[range]);
        let frame: Frame = point.surface.frame();
        let gather = gatherer.layout.accumulate(radiance, distance).expect("a value for each cell");
        let hessian = gatherer
            .with_hessian
            .then(|| gatherer.layout.hessian(directions, radiance, distance).expect("a value for each cell"));
        let mut found = (gather, hessian);
        if world.lights.lit.has_any() {
            self.add_aimed(world, point, number, &mut found);
        }
        let (gather, hessian) = found;
        let mut occluders = OccluderSectors::OPEN;
        for (ray, hit) in rays.iter().zip(hits) {
            let direction = frame.to_local(ray.direction);
            if !OccluderSectors::is_flat(direction) {
                continue;
            }
            occluders.mark_seen(direction);
            if hit.is_hit() {
                let found = world.surface_at(hit).facing(ray.direction);
                occluders.add_hit(direction, hit.t, frame.to_local(found.normal));
            }
        }
        Gathered { gather: gather.to_world(&frame), hessian, occluders }
    }
}
