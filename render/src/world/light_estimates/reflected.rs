//! An approximation of the direct light that surfaces scatter.
//!
//! A sample of the irradiance is the light tree's estimate without shadows if a shadow ray arrives, and the radiance of
//! the sky without its sun in a cosine-distributed direction. A material has its mean albedo, and rough glass
//! transmits as a diffuse surface would.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Triangle as TriangleWarp, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};

use crate::light::{Light, Receiver, SkyLight, SkyPart, TriangleLight, TrianglePart, area, luminance_weight};
use crate::scene::{Material, PunctualLight};
use crate::world::{MIDDLE, Surface, World};

/// Points of a part of a surface at which its light is estimated.
const POINTS: u32 = 4;
/// The same of glass, which light comes to by many ways.
const GLASS_POINTS: u32 = 16;

/// The parts of light that a material reflects and transmits, as luminance.
pub(super) fn albedos(material: &Material) -> [f32; 2] {
    material.mean_scattering().map(|part| luminance_weight(part).min(1.0))
}

impl World {
    /// Whether lamps may cause so much scattered light at a triangle, if nothing is in between.
    pub(super) fn may_be_lit_by_lamps(&self, prim_id: u32, least: f32) -> bool {
        let middle = self.surface(prim_id, 1.0 / 3.0, 1.0 / 3.0);
        let lamps = |side: Vec3| self.lights.lamp_irradiance(&Receiver::new(middle.position, side, false));
        let white = lamps(middle.normal).max(lamps(-middle.normal)) * FRAC_1_PI;
        // Most triangles are far from lamps, whatever their albedo.
        white >= least && white * albedos(middle.material).iter().sum::<f32>() >= least
    }

    /// A part of a triangle as the light that it is by what it scatters, if that is at least so bright. `indirect` is the
    /// part of it by light that was reflected before.
    pub(super) fn lit(&self, part: &TrianglePart, (indirect, least): (f32, f32)) -> Option<TriangleLight> {
        let prim_id = part.prim_id;
        let record = &self.triangle_records[prim_id as usize];
        let material = &self.materials[record.material as usize];
        if albedos(material) == [0.0; 2] {
            return None;
        }
        let is_glass = material.is_glass();
        let points = if is_glass { GLASS_POINTS } else { POINTS };
        let mut sides = if is_glass { [0.0; 2] } else { [indirect; 2] };
        for number in 0..points {
            let place = TriangleWarp.map(Sampler::new(Pattern::Sobol, 0, prim_id, number).uniform2(3));
            let place = part.place(place);
            let front = self.surface(prim_id, place.x, place.y);
            let back = front.facing(front.normal);
            for (radiance, side) in sides.iter_mut().zip([front, back]) {
                *radiance += self.scattered(&side, number) / points as f32;
                if is_glass {
                    *radiance += self.through_glass(&side, number) / points as f32;
                }
            }
            // Most parts are dark, which half of the points tell.
            if number == points / 2 - 1 && sides[0].max(sides[1]) < least * 0.25 {
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
        let [reflected, transmitted] = albedos(side.material).map(|albedo| albedo * FRAC_1_PI);
        let scattered = |albedo: f32, side: &Surface| {
            if albedo > 0.0 { albedo * self.irradiance_samples(side, number).iter().sum::<f32>() } else { 0.0 }
        };
        scattered(reflected, side) + scattered(transmitted, &side.facing(side.normal))
    }

    /// A sample, by its number, of the mean radiance of a side of glass by light that the next surface behind it
    /// scatters, such as the other face of a globe around a lamp.
    fn through_glass(&self, side: &Surface, number: u32) -> f32 {
        let [_, transmitted] = albedos(side.material);
        let behind = side.facing(side.normal);
        let u = Sampler::new(Pattern::Sobol, 0, side.prim_id, number).uniform2(4);
        let direction = behind.frame().to_world(CosineHemisphere.map(u));
        if transmitted == 0.0 || behind.normal.dot(direction) <= 0.0 {
            return 0.0;
        }
        let hit = self.intersect_at(&Ray::new(behind.origin_towards(direction), direction), MIDDLE);
        if !hit.is_hit() {
            return 0.0;
        }
        transmitted * self.scattered(&self.surface_at(&hit).facing(direction), number)
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
        let ambient = |sky: &SkyLight| PI * luminance_weight(sky.ambient(&sky.view(direction)));
        let sky = if is_free { ambient(&self.lights.sky) } else { 0.0 };
        [lights, sky]
    }

    /// Whether nothing is between a surface and the point of a light that the numbers mean.
    fn is_reached(&self, side: &Surface, number: u32, u: Vec2) -> bool {
        let light = &self.lights.lights()[number as usize];
        let is_punctual = matches!(light, Light::Punctual(_));
        let end = match light {
            Light::Triangle(part) => {
                let point = part.place(TriangleWarp.map(u));
                let end = self.surface(part.prim_id, point.x, point.y).end_from(side.position);
                if self.lights.lamp_images.hide(part.prim_id) {
                    return self.shows_lamp(side, end);
                }
                end
            }
            Light::Punctual(
                PunctualLight::Point { position, .. }
                | PunctualLight::Spot { position, .. }
                | PunctualLight::Profiled { position, .. },
            ) => {
                if self.lights.lamp_images.hide_point(number) {
                    return self.shows_lamp(side, *position);
                }
                *position
            }
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

    /// Whether a lamp in glass shows at a point, straight through the glass, to a surface that is no part of it.
    fn shows_lamp(&self, side: &Surface, point: Vec3) -> bool {
        let way = point - side.position;
        let ray = Ray::new(side.origin_towards(way), way);
        !side.material.is_glass() && self.image_along(&ray).is_some()
    }
}
