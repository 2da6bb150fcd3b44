//! Direct light by sampling one light (next-event estimation).
//!
//! `L_direct = ∫ ρ/π L_e cos θ dω` is estimated by one point `y` of one light, chosen with probability `P` and then with
//! density `1/A` on a triangle: `ρ/π L_e cos θ cos θ_y A / (P |y - x|²)`. The density per solid angle, which multiple
//! importance sampling compares with that of the bounce, is `P |y - x|² / (A cos θ_y)`.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{Triangle as TriangleWarp, Warp};

use crate::light::Source;
use crate::scene::PunctualLight;
use crate::world::{Surface, World};

/// Light that a point receives if `shadow` is free.
pub(crate) struct LightSample {
    /// From the point to the light.
    pub shadow: Ray,
    /// Irradiance per unit of the choice's probability: `L_e cos θ / density`, or its like for a light without surface.
    pub irradiance: Vec3,
    /// Density per solid angle of this direction; infinite for a light that no bounce can hit.
    pub density: f32,
}

/// Samples a light for a point of a surface whose normals face the viewer; `None` if it sends nothing there.
pub(crate) fn sample_light(world: &World, surface: &Surface, choice: f64, u: Vec2) -> Option<LightSample> {
    let (source, probability) = world.lights.choose(choice)?;
    match source {
        Source::Triangle(prim_id) => sample_triangle(world, surface, *prim_id, u),
        Source::Punctual(light) => {
            let (to_light, received) = receive(light, surface.position);
            let cosine = reflected_cosine(surface, to_light.normalize_or_zero())?;
            let shadow = match light {
                PunctualLight::Directional { .. } => Ray::new(surface.origin_towards(to_light), to_light),
                PunctualLight::Point { position, .. } | PunctualLight::Spot { position, .. } => {
                    Ray::between(surface.origin_towards(to_light), *position)
                }
            };
            let irradiance = received * (cosine / probability);
            irradiance.cmpgt(Vec3::ZERO).any().then_some(LightSample { shadow, irradiance, density: f32::INFINITY })
        }
    }
}

/// The density per solid angle with which [`sample_light`] gives the point of `emitter` that a ray with the unit vector
/// `direction` hits at distance `t`.
pub(crate) fn emitted_density(world: &World, emitter: &Surface, direction: Vec3, t: f32) -> f32 {
    match world.lights.area_density(emitter.prim_id) {
        0.0 => 0.0,
        area_density => area_density * t * t / emitter.normal.dot(direction).abs(),
    }
}

fn sample_triangle(world: &World, surface: &Surface, prim_id: u32, u: Vec2) -> Option<LightSample> {
    let point = TriangleWarp.map(u);
    let light = world.surface(prim_id, point.x, point.y);
    let to_light = light.position - surface.position;
    let distance_squared = to_light.length_squared();
    let direction = to_light.normalize_or_zero();
    let cosine = reflected_cosine(surface, direction)?;
    let emitted = light.emitted(direction);
    let cosine_at_light = light.normal.dot(direction).abs();
    if emitted == Vec3::ZERO || cosine_at_light == 0.0 {
        return None;
    }
    let density = world.lights.area_density(prim_id) * distance_squared / cosine_at_light;
    let shadow = Ray::between(surface.origin_towards(direction), light.origin_towards(-direction));
    Some(LightSample { shadow, irradiance: emitted * (cosine / density), density })
}

/// The cosine by which light from the unit vector `direction` is reflected; `None` if it comes from behind.
fn reflected_cosine(surface: &Surface, direction: Vec3) -> Option<f32> {
    let cosine = surface.shading_normal.dot(direction);
    (cosine > 0.0 && surface.normal.dot(direction) > 0.0).then_some(cosine)
}

/// The way from a point to a light without a surface, and the irradiance there on a surface that faces it.
fn receive(light: &PunctualLight, point: Vec3) -> (Vec3, Vec3) {
    match *light {
        PunctualLight::Point { position, intensity } => {
            let to_light = position - point;
            (to_light, intensity / to_light.length_squared())
        }
        PunctualLight::Spot { position, direction, intensity, cos_inner, cos_outer } => {
            let to_light = position - point;
            let cosine = -to_light.normalize_or_zero().dot(direction);
            // The square of a linear ramp, as KHR_lights_punctual recommends.
            let ramp = ((cosine - cos_outer) / (cos_inner - cos_outer).max(1e-6)).clamp(0.0, 1.0);
            (to_light, intensity * (ramp * ramp / to_light.length_squared()))
        }
        PunctualLight::Directional { direction, irradiance } => (-direction, irradiance),
    }
}

impl LightSample {
    /// Radiance reflected by a diffuse surface.
    pub(crate) fn reflected(&self, albedo: Vec3) -> Vec3 {
        albedo * self.irradiance * (1.0 / PI)
    }
}
