//! Rays that sample secondary lights, besides the rays over a hemisphere, which rarely hit them.
//!
//! Both techniques are combined by the power heuristic with the numbers of rays (Veach 1997): of `N` rays with the
//! density `p` and `n` aimed ones with `q`, a hit of the first keeps `(N p)²/((N p)² + (n q)²)` of its radiance, and
//! one of the aimed rays the rest. All light reflected by a secondary light counts, not light samples alone as in
//! [`secondary_lights`](super::secondary_lights), as gathers should have little noise.

use glam::Vec3;
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::{Sampler, power, unit_double};

use super::follow::Follow;
use super::salts;
use super::secondary_lights::{aim, aimed_density, lit_at};
use crate::light::Receiver;
use crate::world::{Hit, Surface, World};

/// The set of random numbers for the direction of a ray. Later sets are for the path that follows the ray.
const AIM_SET: u32 = 0;

/// The sampling of secondary lights by one point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AimedFrom {
    receiver: Receiver,
    count: u32,
}

/// Aimed rays of some points, and their memory.
#[derive(Default)]
pub(crate) struct AimedRays {
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    samplers: Vec<Sampler>,
    radiance: Vec<Vec3>,
    aimed: Vec<Aimed>,
}

/// The data of a ray before it is traced.
struct Aimed {
    point: usize,
    prim_id: u32,
    /// The factor on its radiance.
    solid_angle: f32,
}

/// The result of an aimed ray.
pub(crate) struct FoundLit {
    /// A unit vector.
    pub direction: Vec3,
    pub distance: f32,
    /// The triangle's normal on the side of the point.
    pub normal: Vec3,
    /// Radiance times solid angle; its mean over many rays is what they all find.
    pub flux: Vec3,
}

impl AimedFrom {
    /// The number of such rays for a surface with this many other rays: more where more of its light comes from lit
    /// triangles.
    pub(crate) fn new(world: &World, surface: &Surface, others: usize) -> Self {
        let receiver = Receiver::new(surface.position, surface.shading_normal, false);
        Self { receiver, count: world.lights.lit.aimed_rays(&receiver, others) }
    }

    /// The rays that it aims.
    pub(crate) fn count(&self) -> u32 {
        self.count
    }

    /// The weight of another ray's radiance at its hit; `others` is the expected number of such rays per steradian
    /// there.
    #[inline]
    pub(crate) fn kept(&self, world: &World, ray: &Ray, hit: &Hit, others: f32) -> f32 {
        let found = if self.count == 0 { None } else { lit_at(world, ray, hit) };
        let density = |at| self.count as f32 * aimed_density(world, &self.receiver, ray, &at);
        found.map_or(1.0, |at| power(others, density(at)))
    }
}

impl AimedRays {
    /// Forgets all rays.
    pub(crate) fn clear(&mut self) {
        self.rays.clear();
        self.samplers.clear();
        self.aimed.clear();
    }

    /// Samples secondary lights from `surface`, the point of index `point`; `sampler(seed, i)` has the random numbers of
    /// ray `i`, for a `seed` of its own, and `others(direction)` is the expected number of other rays per steradian.
    pub(crate) fn push(
        &mut self,
        world: &World,
        (surface, from): (&Surface, &AimedFrom),
        (point, seed): (usize, u64),
        sampler: impl Fn(u64, u32) -> Sampler,
        others: impl Fn(Vec3) -> f32,
    ) {
        for i in 0..from.count {
            let sampler = sampler(seed ^ salts::AIMED, i);
            let [a, b, c, _] = sampler.uniform4(AIM_SET);
            let numbers = (unit_double(glam::Vec2::new(a, b)), c);
            let Some(aimed) = aim(world, surface, &from.receiver, numbers) else { continue };
            let direction = aimed.ray.direction;
            if surface.normal.dot(direction) > 0.0 && surface.shading_normal.dot(direction) > 0.0 {
                let density = from.count as f32 / aimed.inv_density;
                let solid_angle = power(density, others(direction)) / density;
                self.rays.push(aimed.ray);
                self.samplers.push(sampler);
                self.aimed.push(Aimed { point, prim_id: aimed.prim_id, solid_angle });
            }
        }
    }

    /// Traces all rays, and has those followed that arrive; gives the number of rays.
    pub(crate) fn trace(&mut self, world: &World, follow: &mut dyn Follow) -> u64 {
        if self.rays.is_empty() {
            return 0;
        }
        let Self { rays, hits, samplers, radiance, aimed } = self;
        hits.resize(rays.len(), Hit::MISS);
        radiance.clear();
        radiance.resize(rays.len(), Vec3::ZERO);
        world.intersect_many(rays, hits);
        for ((hit, ray), aimed) in hits.iter_mut().zip(&*rays).zip(aimed) {
            if lit_at(world, ray, hit).is_none_or(|(at, _)| at.part.cell.prim_id != aimed.prim_id) {
                *hit = Hit::MISS;
            }
        }
        rays.len() as u64 + follow.follow(rays, hits, samplers, radiance)
    }

    /// The results of a point's rays.
    pub(crate) fn found<'a>(&'a self, world: &'a World, point: usize) -> impl Iterator<Item = FoundLit> + 'a {
        let hits = self.hits.iter().zip(&self.rays).zip(&self.radiance).zip(&self.aimed);
        hits.filter(move |(((hit, _), _), aimed)| aimed.point == point && hit.is_hit()).map(
            |(((hit, ray), radiance), aimed)| {
                let normal = world.surface_at(hit).facing(ray.direction).normal;
                FoundLit { direction: ray.direction, distance: hit.t, normal, flux: *radiance * aimed.solid_angle }
            },
        )
    }
}
