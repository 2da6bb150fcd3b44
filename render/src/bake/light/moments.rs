//! Directional components of irradiance.
//!
//! - `hl2`: irradiance for three normals about the surface's, `∫ L max(0, ω·b_i) dω`, with McTaggart's (2004) basis
//!   `(√(2/3), 0, 1/√3)`, `(-1/√6, ±1/√2, 1/√3)` in the tangent space of the lightmap: x along u, y along v, which runs
//!   down the picture, and z along the normal.
//! - `sh1`: `∫ L Y dω` for the real spherical harmonics `Y_00 = 1/(2√π)` and `Y_1m = √(3/(4π)) (y, z, x)` in world
//!   space.
//!
//! Both are over the hemisphere above the surface. Cosine-weighted rays would have to be divided by the cosine, so rays
//! are spread evenly here.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::{Pattern, Sampler};

use crate::bake::options::Directional;
use crate::estimator::{AimedFrom, AimedRays, Follow, Hemisphere, salts};
use crate::integrator::{Follower, GatherSource};
use crate::settings::{CachedOptions, HemisphereSampling};
use crate::world::{Hit, Surface, World};

/// The set of random numbers that a direction comes from.
const DIRECTION_SET: u32 = 0;
/// Rays that are traced together, about.
const BATCH: usize = 2048;

/// The moments of light at a point, as functions of directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DirectionalBasis {
    kind: Directional,
    /// The normals of `hl2`.
    basis: [Vec3; 3],
}

impl DirectionalBasis {
    /// The names of the layers, after that of irradiance.
    pub(crate) fn layers(kind: Directional) -> &'static [&'static str] {
        match kind {
            Directional::None => &[],
            Directional::Hl2 => &["hl2.0", "hl2.1", "hl2.2"],
            Directional::Sh1 => &["sh.0", "sh.1-1", "sh.10", "sh.11"],
        }
    }

    /// The moments at a point with this shading normal, where u grows along `tangent` and v along `bitangent`.
    pub(crate) fn new(kind: Directional, normal: Vec3, tangent: Vec3, bitangent: Vec3) -> Self {
        // Into the plane of the shading normal.
        let x = (tangent - normal * normal.dot(tangent)).normalize_or(normal.any_orthonormal_vector());
        let y = normal.cross(x);
        let y = if y.dot(bitangent) < 0.0 { -y } else { y };
        let [half, third, sixth] = [0.5f32.sqrt(), (1.0f32 / 3.0).sqrt(), (1.0f32 / 6.0).sqrt()];
        let basis = [(2.0 * sixth, 0.0), (-sixth, half), (-sixth, -half)].map(|(u, v)| x * u + y * v + normal * third);
        Self { kind, basis }
    }

    /// The functions at a unit vector.
    fn at(&self, direction: Vec3) -> [f32; 4] {
        match self.kind {
            Directional::None => [0.0; 4],
            Directional::Hl2 => {
                let [a, b, c] = self.basis.map(|normal| normal.dot(direction).max(0.0));
                [a, b, c, 0.0]
            }
            Directional::Sh1 => {
                let first = (3.0 / (4.0 * PI)).sqrt();
                [0.5 / PI.sqrt(), first * direction.y, first * direction.z, first * direction.x]
            }
        }
    }

    /// Adds `flux`, radiance times solid angle, that comes from a direction.
    pub(crate) fn add(&self, direction: Vec3, flux: Vec3, sums: &mut [DVec3; 4]) {
        for (sum, factor) in sums.iter_mut().zip(self.at(direction)) {
            *sum += (flux * factor).as_dvec3();
        }
    }
}

/// Gathers of moments, and their memory.
pub(crate) struct Moments {
    hemisphere: Hemisphere,
    max_depth: Option<u32>,
    seed: u64,
    samplers: Vec<Sampler>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    radiance: Vec<Vec3>,
    aimed: AimedRays,
}

impl Moments {
    /// Gathers with as many rays as records have, and with as many bounces.
    pub(crate) fn new(options: &CachedOptions, seed: u64) -> Self {
        Self {
            hemisphere: Hemisphere::new(HemisphereSampling::StratifiedUniform, options.rays),
            max_depth: options.bounces.map(|bounces| bounces + 1),
            seed: seed ^ salts::MOMENTS,
            samplers: Vec::new(),
            rays: Vec::new(),
            hits: Vec::new(),
            radiance: Vec::new(),
            aimed: AimedRays::default(),
        }
    }

    /// Adds the moments of all but direct light at a point; gives the number of rays. `number` selects the random
    /// numbers.
    pub(crate) fn gather(
        &mut self,
        world: &World,
        surface: &Surface,
        basis: &DirectionalBasis,
        number: u32,
        sums: &mut [DVec3; 4],
    ) -> u64 {
        let frame = surface.frame();
        let solid_angle = 2.0 * PI / self.hemisphere.rays() as f32;
        let mut follower = Follower::new(world, GatherSource::Paths(self.max_depth), DIRECTION_SET + 1);
        let from = AimedFrom::new(world, surface, self.hemisphere.rays() as usize);
        self.aimed.clear();
        let sampler = |seed, i| Sampler::new(Pattern::Sobol, seed, number, i);
        self.aimed.push(world, (surface, &from), (0, self.seed), sampler, |_| 1.0 / solid_angle);
        let mut traced = self.aimed.trace(world, &mut follower);
        for lit in self.aimed.found(world, 0) {
            basis.add(lit.direction, lit.flux, sums);
        }
        for first in (0..self.hemisphere.rays()).step_by(BATCH) {
            let end = self.hemisphere.rays().min(first + BATCH as u32);
            self.samplers.clear();
            self.rays.clear();
            for ray in first..end {
                let sampler = Sampler::new(Pattern::Sobol, self.seed, number, ray);
                let direction = frame.to_world(self.hemisphere.direction(ray, sampler.uniform2(DIRECTION_SET)).0);
                // A shading normal may point a ray into the surface.
                if surface.normal.dot(direction) > 0.0 {
                    self.samplers.push(sampler);
                    self.rays.push(Ray::new(surface.origin_towards(surface.normal), direction));
                }
            }
            self.hits.resize(self.rays.len(), Hit::MISS);
            self.radiance.resize(self.rays.len(), Vec3::ZERO);
            world.intersect_many(&self.rays, &mut self.hits);
            traced += follower.follow(&self.rays, &self.hits, &self.samplers, &mut self.radiance);
            traced += self.rays.len() as u64;
            for ((ray, hit), radiance) in self.rays.iter().zip(&self.hits).zip(&self.radiance) {
                let kept = if hit.is_hit() { from.kept(world, ray, hit, 1.0 / solid_angle) } else { 1.0 };
                basis.add(ray.direction, *radiance * (kept * solid_angle), sums);
            }
        }
        traced
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments of even light from the hemisphere: those of hl2 have the irradiance on a tilted surface that sees a part
    /// of the hemisphere, `π (1 + cos θ)/2`; the first harmonic is half of that of a sphere.
    #[test]
    fn even_light_has_the_moments_of_a_hemisphere() {
        let normal = Vec3::new(0.6, 0.0, 0.8);
        let hemisphere = Hemisphere::new(HemisphereSampling::StratifiedUniform, 10_000);
        let frame = halfdome_kernel::sampling::Frame::from_normal(normal);
        let sum = |kind| {
            let basis = DirectionalBasis::new(kind, normal, Vec3::Y, Vec3::X);
            let mut sums = [DVec3::ZERO; 4];
            for ray in 0..hemisphere.rays() {
                let local = hemisphere.direction(ray, glam::Vec2::splat(0.5)).0;
                basis.add(frame.to_world(local), Vec3::splat(2.0 * PI / hemisphere.rays() as f32), &mut sums);
            }
            (sums.map(|sum| sum.x as f32), basis)
        };
        let (hl2, basis) = sum(Directional::Hl2);
        let expected = PI * 0.5 * (1.0 + (1.0f32 / 3.0).sqrt());
        assert!(hl2[..3].iter().all(|moment| (moment - expected).abs() < 1e-3), "{hl2:?}, not {expected}");
        for (i, a) in basis.basis.iter().enumerate() {
            assert!((a.dot(normal) - (1.0f32 / 3.0).sqrt()).abs() < 1e-6);
            assert!(basis.basis[..i].iter().all(|b| a.dot(*b).abs() < 1e-6), "at right angles");
        }
        assert!(basis.basis[0].dot(Vec3::Y) > 0.8 && basis.basis[1].dot(Vec3::X) > 0.5, "along u, then along v");
        let (sh, _) = sum(Directional::Sh1);
        let half = (3.0 / (4.0 * PI)).sqrt() * PI;
        for (found, expected) in sh.into_iter().zip([PI.sqrt(), 0.0, half * normal.z, half * normal.x]) {
            assert!((found - expected).abs() < 1e-3, "{sh:?}");
        }
    }
}
