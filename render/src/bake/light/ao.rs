//! Ambient occlusion at a texel: `1/π ∫ V cos θ dω`, with V = 1 if nothing is nearer than the greatest distance, else
//! 0.

use halfdome_kernel::Ray;
use halfdome_kernel::sampling::{Pattern, Sampler};

use crate::estimator::Hemisphere;
use crate::settings::HemisphereSampling;
use crate::world::{Surface, World};

/// The set of random numbers that a direction comes from.
const DIRECTION_SET: u32 = 0;
/// Rays that are traced together, at most.
const BATCH: usize = 2048;

/// Rays of ambient occlusion, and their memory.
pub(super) struct AmbientOcclusion {
    hemisphere: Hemisphere,
    t_max: f32,
    rays: Vec<Ray>,
    occluded: Vec<bool>,
}

impl AmbientOcclusion {
    /// About `rays` rays a texel that see as far as `distance`.
    pub(super) fn new(rays: u32, distance: Option<f32>) -> Self {
        let hemisphere = Hemisphere::new(HemisphereSampling::Stratified, rays);
        Self { hemisphere, t_max: distance.unwrap_or(f32::INFINITY), rays: Vec::new(), occluded: Vec::new() }
    }

    /// How open a point is, from 0 to 1, and the number of rays. `number` selects the random numbers.
    pub(super) fn at(&mut self, world: &World, surface: &Surface, seed: u64, number: u32) -> (f32, u64) {
        let frame = surface.frame();
        let (mut free, mut traced) = (0, 0);
        for ray in 0..self.hemisphere.rays() {
            let u = Sampler::new(Pattern::Sobol, seed, number, ray).uniform2(DIRECTION_SET);
            let direction = surface.above(frame.to_world(self.hemisphere.direction(ray, u).0));
            let ray = Ray::new(surface.origin_towards(surface.normal), direction);
            self.rays.push(Ray { t_max: self.t_max, ..ray });
            if self.rays.len() == BATCH {
                traced += BATCH as u64;
                free += self.trace(world);
            }
        }
        traced += self.rays.len() as u64;
        free += self.trace(world);
        (free as f32 / self.hemisphere.rays() as f32, traced)
    }

    /// How many of the rays hit nothing; then there are none.
    fn trace(&mut self, world: &World) -> u64 {
        self.occluded.resize(self.rays.len(), false);
        world.occluded_many(&self.rays, &mut self.occluded);
        self.rays.clear();
        self.occluded.iter().filter(|occluded| !**occluded).count() as u64
    }
}
