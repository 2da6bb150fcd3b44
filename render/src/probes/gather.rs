//! The light at a probe: harmonics of radiance, and irradiance along the axes.
//!
//! Emitters, delta lights and the sky's sun are sampled, as they are for a bake's texels: by two sensors back to back,
//! whose cosines are divided out. All other light, the rest of the sky included, is found by paths along the directions
//! of a randomly rotated [`Quadrature`], so that noise has no pattern from probe to probe, and light without fine
//! detail has no noise. The sensors sample secondary lights too.

use std::f32::consts::PI;
use std::slice;

use glam::{DQuat, DVec3, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::{Pattern, Sampler};

use super::Options;
use super::harmonics::basis;
use super::quadrature::Quadrature;
use crate::estimator::{AimedFrom, AimedRays, Follow, IncidentSampler, IncidentSink, salts};
use crate::integrator::{Follower, GatherSource};
use crate::world::{Hit, World};

/// The set of random numbers by which a probe's directions are turned.
const TURN_SET: u32 = 0;
/// Rays that are traced together, at most.
const BATCH: usize = 2048;

/// The incident light at a point, linear sRGB.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProbeLight {
    /// Coefficients of radiance, W/(m² sr), in the order and with the signs of [`harmonics`](super::harmonics).
    pub harmonics: [Vec3; 9],
    /// Irradiance, W/m², for normals along +x, -x, +y, -y, +z and -z.
    pub axes: [Vec3; 6],
}

impl ProbeLight {
    /// A weighted sum.
    pub(super) fn add(&mut self, other: &Self, weight: f32) {
        self.harmonics.iter_mut().zip(other.harmonics).for_each(|(sum, value)| *sum += value * weight);
        self.axes.iter_mut().zip(other.axes).for_each(|(sum, value)| *sum += value * weight);
    }
}

/// Sums of fluxes, each times the fifteen numbers of a light's direction.
#[derive(Default)]
struct Sums {
    normal: Vec3,
    harmonics: [DVec3; 9],
    axes: [DVec3; 6],
}

impl Sums {
    /// Adds radiance times solid angle from a unit vector.
    fn add(&mut self, direction: DVec3, flux: DVec3) {
        self.harmonics.iter_mut().zip(basis(direction)).for_each(|(sum, y)| *sum += flux * y);
        let DVec3 { x, y, z } = direction;
        let cosines = [x, -x, y, -y, z, -z].map(|cosine| cosine.max(0.0));
        self.axes.iter_mut().zip(cosines).for_each(|(sum, cosine)| *sum += flux * cosine);
    }

    fn light(&self) -> ProbeLight {
        ProbeLight { harmonics: self.harmonics.map(|sum| sum.as_vec3()), axes: self.axes.map(|sum| sum.as_vec3()) }
    }
}

impl IncidentSink for Sums {
    fn add_light(&mut self, direction: Vec3, irradiance: Vec3) {
        let cosine = self.normal.dot(direction);
        if cosine > 0.0 {
            self.add(direction.as_dvec3().normalize(), irradiance.as_dvec3() / f64::from(cosine));
        }
    }
}

/// Gathers for probes, and their memory.
pub(super) struct ProbeGatherer<'a> {
    world: &'a World,
    options: &'a Options,
    sphere: &'a Quadrature,
    rays: Vec<Ray>,
    weights: Vec<f64>,
    samplers: Vec<Sampler>,
    hits: Vec<Hit>,
    radiance: Vec<Vec3>,
    aimed: AimedRays,
    incident: IncidentSampler,
}

impl<'a> ProbeGatherer<'a> {
    pub(super) fn new(world: &'a World, options: &'a Options, sphere: &'a Quadrature) -> Self {
        Self {
            world,
            options,
            sphere,
            rays: Vec::new(),
            weights: Vec::new(),
            samplers: Vec::new(),
            hits: Vec::new(),
            radiance: Vec::new(),
            aimed: AimedRays::default(),
            incident: IncidentSampler::default(),
        }
    }

    /// The light at a point, and the number of rays. `number` selects the random numbers.
    pub(super) fn light(&mut self, position: Vec3, number: u32) -> (ProbeLight, u64) {
        let seed = self.options.seed ^ salts::PROBE;
        let turn = turn(Sampler::new(Pattern::Random, seed, number, 0).uniform4(TURN_SET));
        let mut sums = Sums::default();
        let mut traced = 0;
        let axis = (turn * DVec3::Z).as_vec3();
        let directions: Vec<(DVec3, f64)> = self.sphere.points().collect();
        let others = directions.len() as f32 / (4.0 * PI);
        let sides = [axis, -axis].map(|normal| self.world.sensor(position, normal));
        let aims = sides.each_ref().map(|side| AimedFrom::new(self.world, side, directions.len()));
        for (side, sensor) in sides.iter().enumerate() {
            sums.normal = sensor.normal;
            let address = number.wrapping_mul(2).wrapping_add(side as u32);
            let incident = &mut self.incident;
            traced += incident.sample(
                self.world,
                slice::from_ref(sensor),
                (seed, address),
                (0..self.options.spp.max(1), 1.0 / self.options.spp.max(1) as f32),
                &mut sums,
            );
            self.aimed.clear();
            let sampler = |seed, i| Sampler::new(Pattern::Sobol, seed, address, i);
            self.aimed.push(self.world, (sensor, &aims[side]), (0, seed), sampler, |_| others);
            let source = GatherSource::Paths(None);
            traced += self.aimed.trace(self.world, &mut Follower::new(self.world, source, TURN_SET + 1));
            for lit in self.aimed.found(self.world, 0) {
                sums.add(lit.direction.as_dvec3(), lit.flux.as_dvec3());
            }
        }
        for (batch, directions) in (0..).zip(directions.chunks(BATCH)) {
            self.rays.clear();
            self.rays.extend(directions.iter().map(|(d, _)| Ray::new(position, (turn * *d).as_vec3().normalize())));
            self.weights.clear();
            self.weights.extend(directions.iter().map(|(_, weight)| *weight));
            self.samplers.clear();
            let first = batch * BATCH as u32;
            self.samplers.extend(
                (first..first + directions.len() as u32).map(|ray| Sampler::new(Pattern::Sobol, seed, number, ray)),
            );
            let kept = |ray: &Ray, hit: &Hit| {
                let side = usize::from(axis.dot(ray.direction) <= 0.0);
                if hit.is_hit() { aims[side].kept(self.world, ray, hit, others) } else { 1.0 }
            };
            traced += self.rays.len() as u64 + self.gather(&mut sums, kept);
        }
        (sums.light(), traced)
    }

    /// Adds what a batch of rays finds, of which each keeps a part; gives the number of further rays.
    fn gather(&mut self, sums: &mut Sums, kept: impl Fn(&Ray, &Hit) -> f32) -> u64 {
        let Self { world, rays, hits, samplers, radiance, .. } = self;
        hits.resize(rays.len(), Hit::MISS);
        radiance.resize(rays.len(), Vec3::ZERO);
        world.intersect_many(rays, hits);
        let mut follower = Follower::new(world, GatherSource::Paths(None), TURN_SET + 1);
        let traced = follower.follow(rays, hits, samplers, radiance);
        for (((ray, hit), weight), seen) in rays.iter().zip(&*hits).zip(&self.weights).zip(radiance) {
            let seen = if seen.is_finite() { seen.as_dvec3() } else { DVec3::ZERO };
            sums.add(ray.direction.as_dvec3(), seen * (*weight * f64::from(kept(ray, hit))));
        }
        traced
    }
}

/// A rotation, each as likely as any other (Shoemake 1992, "Uniform Random Rotations").
fn turn([a, b, c, _]: [f32; 4]) -> DQuat {
    use std::f64::consts::TAU;
    let [a, b, c] = [a, b, c].map(f64::from);
    let (low, high) = ((1.0 - a).sqrt(), a.sqrt());
    let ((s1, c1), (s2, c2)) = ((TAU * b).sin_cos(), (TAU * c).sin_cos());
    DQuat::from_xyzw(low * s1, low * c1, high * s2, high * c2).normalize()
}
