//! An approximation of the direct light that triangles reflect.
//!
//! Irradiance is the light tree's estimate without shadows, times the unoccluded fraction of a few shadow rays. The sky
//! is left out, and a material has its mean albedo.

use std::f32::consts::FRAC_1_PI;

use glam::Vec2;
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{Triangle as TriangleWarp, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler, unit_double};

use super::seen_points::SeenPoints;
use crate::light::{Light, Receiver, SkyPart, TriangleLight, luminance_weight};
use crate::scene::PunctualLight;
use crate::world::{Surface, World};

/// Shadow rays that estimate how much of the light arrives at a triangle.
const SHADOW_RAYS: u32 = 16;
/// The same, at a point that represents many.
const POINT_SHADOW_RAYS: u32 = 4;
/// Values above this multiple of the mean are clamped in a mean of few.
const OUTLIER: f32 = 8.0;

impl World {
    /// The mean radiance that bounces find, of light that was reflected once.
    pub(super) fn mean_reflected(&self, points: &SeenPoints) -> f32 {
        let reflected = |point: Surface| self.reflected(&point, self.albedo(point.prim_id), 0.0, POINT_SHADOW_RAYS);
        let found: Vec<f32> = points.scattered(self).map(reflected).collect();
        let mean =
            |most: f32| found.iter().map(|&radiance| radiance.min(most)).sum::<f32>() / found.len().max(1) as f32;
        // A few of them may be secondary lights.
        mean(OUTLIER * mean(f32::INFINITY))
    }

    /// The albedo of a triangle's material, as luminance.
    fn albedo(&self, prim_id: u32) -> f32 {
        let material = &self.materials[self.triangle_records[prim_id as usize].material as usize];
        luminance_weight(material.mean_albedo()).min(1.0)
    }

    /// A triangle as the light that it is by what it reflects, if that is at least so bright.
    pub(super) fn lit(&self, prim_id: u32, area: f32, least: f32) -> Option<TriangleLight> {
        let material = &self.materials[self.triangle_records[prim_id as usize].material as usize];
        let albedo = self.albedo(prim_id);
        if albedo <= 0.0 || material.is_glass() {
            return None;
        }
        let middle = self.surface(prim_id, 1.0 / 3.0, 1.0 / 3.0);
        let sides =
            [middle, middle.facing(middle.normal)].map(|side| self.reflected(&side, albedo, least, SHADOW_RAYS));
        let radiance = sides[0].max(sides[1]);
        if radiance < least {
            return None;
        }
        let both_sides = sides[0].min(sides[1]) >= least || material.inputs.diffuse_transmission_weight > 0.0;
        let normal = if sides[0] >= sides[1] { middle.normal } else { -middle.normal };
        let corners = self.triangle_records[prim_id as usize].corners;
        Some(TriangleLight { corners, normal, radiance, area, both_sides })
    }

    /// The mean radiance that a side of this albedo reflects of the lights'; 0 if it is less than `least`.
    fn reflected(&self, side: &Surface, albedo: f32, least: f32, shadow_rays: u32) -> f32 {
        let receiver = Receiver::new(side.position, side.normal, false);
        let weights = self.lights.weigh(&receiver, SkyPart::Sun);
        let unshadowed = weights.total() * albedo * FRAC_1_PI;
        if unshadowed < least || unshadowed == 0.0 {
            return 0.0;
        }
        let reached = (0..shadow_rays).filter(|&number| {
            let [a, b, c, d] = Sampler::new(Pattern::Sobol, 0, side.prim_id, number).uniform4(0);
            let choice = self.lights.choose(&receiver, &weights, unit_double(Vec2::new(a, b)));
            choice.is_some_and(|choice| self.is_reached(side, choice.index, Vec2::new(c, d)))
        });
        unshadowed * reached.count() as f32 / shadow_rays as f32
    }

    /// Whether nothing is between a surface and the point of a light that the numbers mean.
    fn is_reached(&self, side: &Surface, light: u32, u: Vec2) -> bool {
        let light = &self.lights.lights()[light as usize];
        let is_punctual = matches!(light, Light::Punctual(_));
        let end = match light {
            Light::Triangle(prim_id) => {
                let point = TriangleWarp.map(u);
                self.surface(*prim_id, point.x, point.y).end_from(side.position)
            }
            Light::Punctual(
                PunctualLight::Point { position, .. }
                | PunctualLight::Spot { position, .. }
                | PunctualLight::Profiled { position, .. },
            ) => *position,
            Light::Punctual(PunctualLight::Directional { direction, .. }) => {
                return !self.occluded(&self.beyond_glass(Ray::new(side.origin_towards(-*direction), -*direction)));
            }
            Light::Sky => return false,
        };
        let ray = Ray::between(side.origin_towards(end - side.position), end);
        !self.occluded(&if is_punctual { self.beyond_glass(ray) } else { ray })
    }
}
