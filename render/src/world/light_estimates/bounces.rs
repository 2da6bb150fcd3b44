//! What cosine-distributed bounces find from points that paths come to: light that lights and the sky send to surfaces,
//! and that is reflected a few times.
//!
//! An approximation for estimates: each surface is diffuse with its material's mean albedo, rough glass too, and smooth
//! glass is black.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};
use rayon::prelude::*;

use super::reflected::albedos;
use super::seen_points::SeenPoints;
use crate::world::{Hit, Surface, World};

/// Bounces from each point.
const BOUNCES: u32 = 8;
/// Samples of the direct light of a point.
const SAMPLES: u32 = 4;
/// Surfaces of a path behind the first.
const DEPTH: u32 = 2;
/// The first set of random numbers that seen points leave: for bounces, for the paths behind them, and for
/// further paths from what these find.
const FIRST_SALT: u32 = 4;
const BEHIND_SALT: u32 = FIRST_SALT + 1;
pub(super) const INDIRECT_SALT: u32 = BEHIND_SALT + DEPTH;

/// A point that paths come to.
pub(super) struct View<'a> {
    pub point: Surface<'a>,
    /// About the radiance of a white surface there, as luminance.
    pub radiance: f32,
    /// The variance of that by single samples of lights and sky.
    pub variance: f32,
}

/// What a bounce has found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounce {
    /// The index of the view that it comes from.
    pub view: usize,
    pub hit: Hit,
    /// A unit vector.
    pub direction: Vec3,
    /// The radiance that the surface scatters towards the view, as luminance: of light from lights and the sky, and of
    /// light that surfaces have scattered before.
    pub direct: f32,
    pub indirect: f32,
}

impl Bounce {
    /// All that it finds.
    pub(super) fn radiance(&self) -> f32 {
        self.direct + self.indirect
    }
}

impl World {
    /// The points with the direct light that arrives there.
    pub(super) fn views<'a>(&'a self, points: &'a SeenPoints) -> Vec<View<'a>> {
        let points: Vec<Surface> = points.all(self).collect();
        let view = |point: Surface<'a>| {
            let mut view = View { point, radiance: 0.0, variance: 0.0 };
            let samples: [_; SAMPLES as usize] =
                std::array::from_fn(|number| self.irradiance_samples(&point, number as u32));
            for kind in 0..2 {
                let values = samples.map(|sample| sample[kind] * FRAC_1_PI);
                let mean = values.iter().sum::<f32>() / SAMPLES as f32;
                view.radiance += mean;
                view.variance += values.map(|value| (value - mean).powi(2)).iter().sum::<f32>() / (SAMPLES - 1) as f32;
            }
            view
        };
        points.into_par_iter().map(view).collect()
    }

    /// What bounces from these points find of direct light.
    pub(super) fn bounces(&self, views: &[View]) -> Vec<Bounce> {
        let from = views.iter().enumerate().flat_map(|(view, from)| (0..BOUNCES).map(move |_| (view, from.point)));
        let hits = self.bounce(from.collect(), FIRST_SALT);
        let bounce = |(number, (view, hit, direction)): (usize, (usize, Hit, Vec3))| {
            let direct = self.scattered(&self.surface_at(&hit).facing(direction), number as u32);
            Bounce { view, hit, direction, direct, indirect: 0.0 }
        };
        hits.into_par_iter().enumerate().map(bounce).collect()
    }

    /// Adds what they find of indirect light.
    pub(super) fn add_indirect(&self, bounces: &mut [Bounce]) {
        let surface = |bounce: &Bounce| self.surface_at(&bounce.hit).facing(bounce.direction);
        let indirect = self.indirect(bounces.iter().map(surface).collect(), BEHIND_SALT);
        bounces.iter_mut().zip(indirect).for_each(|(bounce, indirect)| bounce.indirect = indirect);
    }

    /// The radiance that each surface scatters, of light that was reflected before, by one path from each.
    pub(super) fn indirect(&self, from: Vec<Surface>, salt: u32) -> Vec<f32> {
        let mut found = vec![0.0; from.len()];
        // The number of each path, and the albedo of the surfaces that it has come to.
        let mut paths: Vec<(usize, f32)> = from.iter().map(albedo).enumerate().collect();
        let mut from: Vec<(usize, Surface)> = from.into_iter().enumerate().collect();
        for depth in 0..DEPTH {
            let hits = self.bounce(from, salt + depth);
            let next: Vec<(Surface, f32)> = hits
                .par_iter()
                .enumerate()
                .map(|(number, (_, hit, direction))| {
                    let surface = self.surface_at(hit).facing(*direction);
                    (surface, self.scattered(&surface, number as u32))
                })
                .collect();
            paths = hits
                .iter()
                .zip(&next)
                .map(|((path, ..), (surface, light))| {
                    let (number, throughput) = paths[*path];
                    found[number] += throughput * light;
                    (number, throughput * albedo(surface))
                })
                .collect();
            from = next.into_iter().map(|(surface, _)| surface).enumerate().collect();
        }
        found
    }

    /// Sends a ray from each surface, by the cosine, and gives its number, hit and direction. Surfaces that transmit do
    /// that in part.
    fn bounce(&self, from: Vec<(usize, Surface)>, salt: u32) -> Vec<(usize, Hit, Vec3)> {
        let ray = |(number, (index, surface)): (usize, (usize, Surface))| {
            let sampler = Sampler::new(Pattern::Sobol, 0, salt, number as u32);
            let [side, _, x, y] = sampler.uniform4(0);
            let [reflected, transmitted] = albedos(surface.material);
            let transmits = side * (reflected + transmitted) < transmitted;
            let surface = if transmits { surface.facing(surface.normal) } else { surface };
            let direction = surface.frame().to_world(CosineHemisphere.map(Vec2::new(x, y)));
            let is_sent = surface.normal.dot(direction) > 0.0 && reflected + transmitted > 0.0;
            is_sent.then(|| (index, Ray::new(surface.origin_towards(direction), direction)))
        };
        let (numbers, rays): (Vec<usize>, Vec<Ray>) = from.into_iter().enumerate().filter_map(ray).unzip();
        let mut hits = vec![Hit::MISS; rays.len()];
        self.intersect_many(&rays, &mut hits);
        let hits = numbers.into_iter().zip(hits).zip(rays).filter(|((_, hit), _)| hit.is_hit());
        hits.map(|((number, hit), ray)| (number, hit, ray.direction)).collect()
    }
}

/// All that a surface's material scatters.
fn albedo(surface: &Surface) -> f32 {
    albedos(surface.material).iter().sum()
}
