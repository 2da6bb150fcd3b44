//! An approximation of the direct light that surfaces scatter.
//!
//! A sample of the irradiance is the light tree's estimate without shadows if a shadow ray arrives, and the radiance of
//! the sky without its sun in a cosine-distributed direction. A material has its mean albedo.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Triangle as TriangleWarp, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};

use crate::light::{Light, Receiver, SkyPart, TriangleLight, TrianglePart, area, luminance_weight};
use crate::scene::PunctualLight;
use crate::world::{Surface, World};

/// Points of a part of a surface at which its light is estimated.
const POINTS: u32 = 4;

impl World {
    /// The albedo of a triangle's material, as luminance.
    pub(super) fn albedo(&self, prim_id: u32) -> f32 {
        let material = &self.materials[self.triangle_records[prim_id as usize].material as usize];
        luminance_weight(material.mean_albedo()).min(1.0)
    }

    /// Whether lamps may cause so much scattered light at a triangle, if nothing is in between.
    pub(super) fn may_be_lit_by_lamps(&self, prim_id: u32, least: f32) -> bool {
        let middle = self.surface(prim_id, 1.0 / 3.0, 1.0 / 3.0);
        let lamps = |side: Vec3| self.lights.lamp_irradiance(&Receiver::new(middle.position, side, false));
        lamps(middle.normal).max(lamps(-middle.normal)) * self.albedo(prim_id) * FRAC_1_PI >= least
    }

    /// A part of a triangle as the light that it is by what it scatters, if that is at least so bright. `indirect` is the
    /// part of it by light that was reflected before.
    pub(super) fn lit(&self, part: &TrianglePart, (indirect, least): (f32, f32)) -> Option<TriangleLight> {
        let prim_id = part.prim_id;
        let record = &self.triangle_records[prim_id as usize];
        let material = &self.materials[record.material as usize];
        if self.albedo(prim_id) <= 0.0 || material.is_glass() {
            return None;
        }
        let mut sides = [indirect; 2];
        for number in 0..POINTS {
            let place = TriangleWarp.map(Sampler::new(Pattern::Sobol, 0, prim_id, number).uniform2(3));
            let place = part.place(place);
            let front = self.surface(prim_id, place.x, place.y);
            let back = front.facing(front.normal);
            sides[0] += self.scattered(&front, number) / POINTS as f32;
            sides[1] += self.scattered(&back, number) / POINTS as f32;
            // Most parts are dark, which two points tell.
            if number == 1 && sides[0].max(sides[1]) < least * 0.25 {
                return None;
            }
        }
        let radiance = sides[0].max(sides[1]);
        if radiance < least {
            return None;
        }
        let both_sides = sides[0].min(sides[1]) >= least;
        let normal = if sides[0] >= sides[1] { record.normal } else { -record.normal };
        let corners = part.corners(&record.corners);
        Some(TriangleLight { corners, normal, radiance, area: area(&corners), both_sides })
    }

    /// A sample, by its number, of the mean radiance of a side of a surface by light that it reflects or transmits.
    pub(super) fn scattered(&self, side: &Surface, number: u32) -> f32 {
        let albedo = self.albedo(side.prim_id) * FRAC_1_PI;
        if albedo <= 0.0 {
            return 0.0;
        }
        let transmitted = side.material.inputs.diffuse_transmission_weight;
        let irradiance = |side: &Surface| self.irradiance_samples(side, number).iter().sum::<f32>();
        let reflected = (1.0 - transmitted) * irradiance(side);
        let other = if transmitted > 0.0 { transmitted * irradiance(&side.facing(side.normal)) } else { 0.0 };
        albedo * (reflected + other)
    }

    /// Samples of a side's irradiance by lights and by the sky, by their number.
    pub(super) fn irradiance_samples(&self, side: &Surface, number: u32) -> [f32; 2] {
        let sampler = Sampler::new(Pattern::Sobol, 0, side.prim_id, number);
        let receiver = Receiver::new(side.position, side.normal, false);
        let [a, b, c, d] = sampler.uniform4(0);
        let choice = self.lights.choose_closely(&receiver, SkyPart::Sun, [a, b]);
        let reached = choice.filter(|&(_, light)| self.is_reached(side, light, Vec2::new(c, d)));
        let lights = reached.map_or(0.0, |(irradiance, _)| irradiance);
        if self.lights.sky.mean() == Vec3::ZERO {
            return [lights, 0.0];
        }
        let direction = side.frame().to_world(CosineHemisphere.map(sampler.uniform2(2)));
        let ray = Ray::new(side.origin_towards(direction), direction);
        let is_free = side.normal.dot(direction) > 0.0 && !self.occluded(&self.beyond_glass(ray));
        let sky = if is_free { PI * luminance_weight(self.lights.sky.ambient(direction)) } else { 0.0 };
        [lights, sky]
    }

    /// Whether nothing is between a surface and the point of a light that the numbers mean.
    fn is_reached(&self, side: &Surface, light: u32, u: Vec2) -> bool {
        let light = &self.lights.lights()[light as usize];
        let is_punctual = matches!(light, Light::Punctual(_));
        let end = match light {
            Light::Triangle(part) => {
                let point = part.place(TriangleWarp.map(u));
                self.surface(part.prim_id, point.x, point.y).end_from(side.position)
            }
            Light::Punctual(
                PunctualLight::Point { position, .. }
                | PunctualLight::Spot { position, .. }
                | PunctualLight::Profiled { position, .. },
            ) => *position,
            Light::Punctual(PunctualLight::Directional { direction, .. }) => {
                return !self.occluded(&self.beyond_glass(Ray::new(side.origin_towards(-*direction), -*direction)));
            }
            Light::Sky => {
                let receiver = Receiver::new(side.position, side.normal, false);
                let direction = self.lights.sky.sample(&receiver, SkyPart::Sun, u).direction;
                let ray = Ray::new(side.origin_towards(direction), direction);
                return side.normal.dot(direction) > 0.0 && !self.occluded(&self.beyond_glass(ray));
            }
        };
        let ray = Ray::between(side.origin_towards(end - side.position), end);
        !self.occluded(&if is_punctual { self.beyond_glass(ray) } else { ray })
    }
}
