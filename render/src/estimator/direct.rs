//! Direct light by sampling one light (next-event estimation).
//!
//! `L_direct = ∫ f L_e cos θ dω` is estimated by one direction to one light, chosen with probability `P` and then, on a
//! triangle, by a point `y` of density `p` per area: `f L_e cos θ cos θ_y / (P p |y - x|²)`. The density per solid angle,
//! which multiple importance sampling compares with that of the bounce, is `P p |y - x|² / cos θ_y`. A plain triangle is
//! sampled where it is bright from the surface (see [`light_warp`]), one with textures evenly. A sky that is as bright
//! everywhere is sampled by the cosine, with the density `P cos θ / π`, and one that is not by its brightness.

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{Triangle as TriangleWarp, Warp};
use halfdome_kernel::{Hit, Ray};

use super::light_warp::light_warp;
use crate::light::{Light, SampledLight};
use crate::scene::PunctualLight;
use crate::settings::LightSampling;
use crate::world::{Surface, World};

/// Light that a surface reflects if `ray` is not occluded.
pub(crate) struct ShadowRay {
    /// From the surface to the light.
    pub ray: Ray,
    /// Radiance reflected, over the density of the sample and with the weight of its technique.
    pub radiance: Vec3,
}

/// Light that arrives from a light if nothing is in between.
pub(crate) struct LightSample {
    pub shadow: Ray,
    /// Unit vector to the light.
    pub direction: Vec3,
    /// Radiance over density; of a delta light, irradiance at right angles to it over probability.
    pub radiance: Vec3,
    /// The reciprocal of the density per solid angle of this direction; 0 for a light that no bounce can hit.
    pub inv_density: f32,
}

/// Samples a light for a point of a surface whose normals face the viewer; `None` if nothing of it is reflected. The
/// first of the numbers in [0, 1) chooses the light, and what is left of it, with the second, a point or a direction.
#[inline(always)]
pub(crate) fn sample_direct(
    world: &World,
    surface: &Surface,
    lights: LightSampling,
    (choice, v): (f64, f32),
) -> Option<ShadowRay> {
    sample_direct_from(world, surface, lights, &world.lights.choose(choice)?, v)
}

/// The same for a light that is chosen.
#[inline(always)]
pub(crate) fn sample_direct_from(
    world: &World,
    surface: &Surface,
    lights: LightSampling,
    choice: &SampledLight,
    v: f32,
) -> Option<ShadowRay> {
    let light = sample_light(world, surface, lights, choice, v)?;
    let (reflected, bounce_density) = surface.evaluate(light.direction);
    let radiance = reflected * light.radiance * lights.light_weight(light.inv_density, bounce_density);
    radiance.cmpgt(Vec3::ZERO).any().then_some(ShadowRay { ray: light.shadow, radiance })
}

/// Samples an area light, a delta light or the sky's sun: the direct light that gathers leave out. With
/// [`LightSampling::Direct`] samples of area lights count in full, as bounces find none of them.
pub(crate) fn sample_direct_without_sky(
    world: &World,
    surface: &Surface,
    lights: LightSampling,
    (choice, v): (f64, f32),
) -> Option<ShadowRay> {
    let (choice, rarer) = world.lights.choose_without_sky(choice)?;
    let light = match choice.light {
        Light::Sky => sample_sun(world, surface, &choice, v)?,
        _ => sample_light(world, surface, lights, &choice, v)?,
    };
    let (reflected, bounce_density) = surface.evaluate(light.direction);
    let radiance = reflected * light.radiance * rarer * lights.light_weight(light.inv_density * rarer, bounce_density);
    radiance.cmpgt(Vec3::ZERO).any().then_some(ShadowRay { ray: light.shadow, radiance })
}

/// The density per solid angle with which [`sample_direct`], among bounces, gives the point of `emitter` that is hit by a ray of
/// a unit vector, from a surface with the unit normal `normal` on the side of the ray. Without one, that of points that are
/// all alike.
pub(crate) fn emitted_density(world: &World, normal: Option<Vec3>, emitter: &Surface, ray: &Ray, hit: &Hit) -> f32 {
    let area_density = world.lights.area_density(emitter.prim_id);
    if area_density == 0.0 {
        return 0.0;
    }
    let density = area_density * hit.t * hit.t / emitter.normal.dot(ray.direction).abs();
    match (normal, world.plain_triangle(hit.prim_id)) {
        (Some(normal), Some(face)) => {
            let place = TriangleWarp.inverse(Vec2::new(hit.u, hit.v));
            density * light_warp(ray.origin, normal, &face.corners, LightSampling::Mis).density(place)
        }
        _ => density,
    }
}

/// The part of an emitter's light that counts along a ray which a surface scattered, as [`sample_direct_without_sky`] finds it too. The
/// ray has a unit vector, chosen with the given density per solid angle, and the unit normal is on its side.
pub(crate) fn scattered_weight(
    world: &World,
    normal: Vec3,
    density: f32,
    emitter: &Surface,
    ray: &Ray,
    hit: &Hit,
) -> f32 {
    // `sample_direct_without_sky` chooses among fewer lights than `sample_direct`.
    let by_lights = emitted_density(world, Some(normal), emitter, ray, hit) / world.lights.share_without_sky();
    LightSampling::Mis.bounce_weight(density, by_lights)
}

/// The density per solid angle with which [`sample_direct`] looks from `surface` to the sky in the unit vector `direction`.
#[inline(always)]
pub(crate) fn sky_density(world: &World, surface: &Surface, direction: Vec3) -> f32 {
    match world.lights.sky_probability() {
        0.0 => 0.0,
        probability => probability * world.sky.density(surface.shading_normal, direction),
    }
}

/// Light from what was chosen; which point or direction, `v` says with what the choice left.
#[inline(always)]
fn sample_light(
    world: &World,
    surface: &Surface,
    lights: LightSampling,
    choice: &SampledLight,
    v: f32,
) -> Option<LightSample> {
    let u = Vec2::new(choice.rest, v);
    let rarer = match choice.light {
        Light::Triangle(prim_id) => return sample_triangle(world, surface, lights, *prim_id, u),
        Light::Punctual(light) => sample_punctual(surface, light, choice.probability),
        Light::Sky => sample_sky(world, surface, u)?,
    };
    // Taken apart and put together, or the samples of triangles would be kept in memory as well.
    let LightSample { shadow, direction, radiance, inv_density } = rarer;
    Some(LightSample { shadow, direction, radiance, inv_density })
}

#[inline(always)]
fn sample_triangle(
    world: &World,
    surface: &Surface,
    lights: LightSampling,
    prim_id: u32,
    u: Vec2,
) -> Option<LightSample> {
    let mut area = world.lights.area_density(prim_id).recip();
    let mut place = u;
    if let Some(face) = world.plain_triangle(prim_id) {
        let warp = light_warp(surface.position, surface.normal, &face.corners, lights);
        place = warp.map(u);
        area *= warp.per_density(place);
    }
    let light = point_on_emitter(world, surface.position, prim_id, place)?;
    let (sample, arrives) = area_light_sample(surface, &light, area);
    arrives.then_some(sample)
}

/// The point of triangle `prim_id` that `u` means, with its normals on the side that sends light to `receiver`, if both
/// do; `None` in a hole.
#[inline(always)]
fn point_on_emitter<'w>(world: &'w World, receiver: Vec3, prim_id: u32, u: Vec2) -> Option<Surface<'w>> {
    let point = TriangleWarp.map(u);
    if world.is_hole(&Hit { prim_id, u: point.x, v: point.y, ..Hit::MISS }) {
        return None;
    }
    let light = world.surface(prim_id, point.x, point.y);
    Some(if light.material.emits_both_sides { light.facing(light.position - receiver) } else { light })
}

/// The light from a point of an emitter, whose front emits and which is chosen with a density per area whose reciprocal is
/// `area`; and whether any of it can arrive. Without a branch, so that loops over it become lanes.
#[inline(always)]
pub(crate) fn area_light_sample(surface: &Surface, light: &Surface, area: f32) -> (LightSample, bool) {
    let to_light = light.position - surface.position;
    let (cosine, cosine_at_light) = (surface.normal.dot(to_light), -light.normal.dot(to_light));
    let inv_distance = to_light.length_squared().sqrt().recip();
    let direction = to_light * inv_distance;
    let inv_density = cosine_at_light * inv_distance * (inv_distance * inv_distance) * area;
    let origin = surface.origin_towards(direction);
    let shadow = Ray::between(origin, light.end_from(origin));
    let sample = LightSample { shadow, direction, radiance: light.emission * inv_density, inv_density };
    (sample, (cosine > 0.0) & (cosine_at_light > 0.0))
}

#[inline(never)]
fn sample_punctual(surface: &Surface, light: &PunctualLight, probability: f32) -> LightSample {
    let (to_light, received) = incident_irradiance(light, surface.position);
    let shadow = match light {
        PunctualLight::Directional { .. } => Ray::new(surface.origin_towards(to_light), to_light),
        PunctualLight::Point { position, .. } | PunctualLight::Spot { position, .. } => {
            Ray::between(surface.origin_towards(to_light), *position)
        }
    };
    let direction = to_light.normalize_or_zero();
    LightSample { shadow, direction, radiance: received / probability, inv_density: 0.0 }
}

#[inline(never)]
fn sample_sky(world: &World, surface: &Surface, u: Vec2) -> Option<LightSample> {
    let direction = world.sky.sample(surface.shading_normal, u);
    let density = sky_density(world, surface, direction);
    let shadow = Ray::new(surface.origin_towards(direction), direction);
    let inv_density = density.recip();
    let radiance = world.sky.radiance(direction) * inv_density;
    (density > 0.0).then_some(LightSample { shadow, direction, radiance, inv_density })
}

#[inline(never)]
fn sample_sun(world: &World, surface: &Surface, choice: &SampledLight, v: f32) -> Option<LightSample> {
    let (direction, radiance) = world.sky.sample_sun(Vec2::new(choice.rest, v))?;
    let shadow = Ray::new(surface.origin_towards(direction), direction);
    Some(LightSample { shadow, direction, radiance: radiance / choice.probability, inv_density: 0.0 })
}

/// The way from a point to a delta light, and the irradiance there on a surface that faces it.
fn incident_irradiance(light: &PunctualLight, point: Vec3) -> (Vec3, Vec3) {
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
