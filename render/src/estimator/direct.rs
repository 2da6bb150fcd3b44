//! Direct light by sampling one light (next-event estimation).
//!
//! `L_direct = ∫ f L_e cos θ dω` is estimated by one direction to one light, chosen with probability `P` for this point
//! (see [`light`](crate::light)) and then, on a triangle, by a point `y` of density `p` per area: `f L_e cos θ cos θ_y
//! / (P p |y - x|²)`. The density per solid angle, which multiple importance sampling compares with that of the bounce,
//! is `P p |y - x|² / cos θ_y`. A triangle is sampled where it is bright from the surface (see [`light_warp`]). A
//! constant sky is sampled by the cosine, with the density `P cos θ / π`, any other sky by its brightness.
//!
//! [`sample_light`] and the densities, [`emitted_density`], [`seen_sky`](super::seen_sky) and that of
//! [`seen_lights`](super::seen_lights), are the interface for integrators, sensors, bakes and probes. The caller
//! chooses the part of the sky that light samples cover ([`SkyPart`]). With [`SkyPart::Bright`] it takes further samples
//! of the sky through openings ([`Openings`](crate::light::Openings)), whose density counts beside that of these.

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::ONE_MINUS_EPSILON;
use halfdome_kernel::sampling::warp::{Triangle as TriangleWarp, Warp};

use super::light_sample::LightSample;
use super::light_warp::light_warp;
use super::punctual::sample_punctual;
use super::reflected::{ReflectedLight, sample_reflected};
use super::refracted::LightWay;
use super::sky::sample_sky;
use crate::bsdf::Scattering;
use crate::light::{Light, Receiver, SampledLight, SkyPart, TrianglePart};
use crate::material::Bsdf;
use crate::settings::LightSampling;
use crate::world::{Hit, Surface, World};

/// Light that a surface reflects if `ray` is not occluded.
pub(crate) struct ShadowRay {
    /// The shadow ray from the surface to the light.
    pub ray: Ray,
    /// The unit direction from which the surface receives it. The ray's direction differs, as its ends are offset: far
    /// from the origin by much.
    pub direction: Vec3,
    /// Radiance reflected, over the density of the sample and with the weight of its technique.
    pub radiance: Vec3,
}

impl ShadowRay {
    /// What comes straight through panes; `None` if nothing does.
    #[inline]
    pub(crate) fn through_panes(self, world: &World, time: f32) -> Option<Self> {
        let (ray, transmittance) = world.through_panes(&self.ray, time)?;
        Some(Self { ray, radiance: self.radiance * transmittance, ..self })
    }
}

/// Samples direct light at a point of a surface whose normals face the viewer: a light, and light that mirrors reflect; none
/// of what is not scattered. The first of the numbers in [0, 1) chooses the light, and its remainder, with the second
/// number, a point or a direction. Lights without a surface are sampled completely. Light comes straight through panes.
#[inline(always)]
pub(crate) fn sample_direct(
    world: &World,
    surface: &Surface,
    scattering: &Scattering<impl Bsdf>,
    how: (LightSampling, SkyPart),
    numbers: (f64, f32),
) -> impl Iterator<Item = ShadowRay> {
    sample_direct_by(world, surface, |direction| scattering.eval(direction), how, numbers)
}

/// The same, given a function of the direction to a light: what is scattered from there, `f cos θ`, which may be
/// negative, and the density of bounces.
#[inline(always)]
pub(crate) fn sample_direct_by(
    world: &World,
    surface: &Surface,
    eval: impl Fn(Vec3) -> (Vec3, f32),
    how: (LightSampling, SkyPart),
    numbers: (f64, f32),
) -> impl Iterator<Item = ShadowRay> {
    let receiver = surface.receiver();
    let weights = world.lights.weigh(&receiver, how.1);
    let light = world.lights.choose(&receiver, &weights, numbers.0);
    sample_direct_from(world, surface, eval, how, (light, numbers))
}

/// The same, given which light the numbers choose.
#[inline(always)]
pub(crate) fn sample_direct_from(
    world: &World,
    surface: &Surface,
    eval: impl Fn(Vec3) -> (Vec3, f32),
    how: (LightSampling, SkyPart),
    (light, numbers): (Option<SampledLight>, (f64, f32)),
) -> impl Iterator<Item = ShadowRay> {
    let straight = match &light {
        Some(light) => sample_one_light(world, surface, &eval, how, (light, numbers.1)),
        None => None,
    };
    let reflected =
        if world.has_reflected_light() { sample_mirrored(world, surface, &eval, how.0, numbers) } else { None };
    straight.into_iter().chain(reflected)
}

/// Samples a light.
#[inline(always)]
fn sample_one_light(
    world: &World,
    surface: &Surface,
    eval: impl Fn(Vec3) -> (Vec3, f32),
    (lights, part): (LightSampling, SkyPart),
    (choice, v): (&SampledLight, f32),
) -> Option<ShadowRay> {
    let light = sample_light(world, surface, (lights, part), choice, v)?;
    let (scattered, bounce_density) = eval(light.direction);
    let inv_density = if light.is_punctual { 0.0 } else { light.inv_density };
    let radiance = scattered * light.radiance * lights.light_weight(inv_density, bounce_density);
    if !radiance.abs().cmpgt(Vec3::ZERO).any() {
        return None;
    }
    let shadow_ray = ShadowRay { ray: light.shadow, direction: light.direction, radiance };
    if light.is_glass_known { Some(shadow_ray) } else { shadow_ray.through_panes(world, surface.time) }
}

/// Samples the light that mirrors and glass reflect.
#[inline(never)]
fn sample_mirrored(
    world: &World,
    surface: &Surface,
    eval: impl Fn(Vec3) -> (Vec3, f32),
    lights: LightSampling,
    (choice, v): (f64, f32),
) -> Option<ShadowRay> {
    let numbers = Vec2::new((choice as f32).min(ONE_MINUS_EPSILON), v);
    let ReflectedLight { direction, shadow, received, .. } = sample_reflected(world, surface, 1.0, numbers)?;
    let (scattered, density) = eval(direction);
    let radiance = scattered * received * lights.light_weight(0.0, density);
    radiance.abs().cmpgt(Vec3::ZERO).any().then_some(ShadowRay { ray: shadow, direction, radiance })
}

/// The density per solid angle with which a light sample at `receiver`, among bounces and with this part of the sky, gives
/// the point of `emitter` that is hit by a ray of a unit vector.
pub(crate) fn emitted_density(
    world: &World,
    receiver: &Receiver,
    part: SkyPart,
    emitter: &Surface,
    ray: &Ray,
    hit: &Hit,
) -> f32 {
    let place = Vec2::new(hit.u, hit.v);
    let Some(light) = world.lights.emitter_at(emitter.prim_id, place) else { return 0.0 };
    let probability = world.lights.probability(light, receiver, part);
    if probability == 0.0 {
        return 0.0;
    }
    let Light::Triangle(cell) = &world.lights.lights()[light as usize] else { return 0.0 };
    let (corners, area) = world.emitter_corners(light, cell, hit.time);
    let place = TriangleWarp.inverse(cell.coordinates(place));
    let on_light = light_warp(receiver, &corners, LightSampling::Mis).density(place);
    probability * on_light * hit.t * hit.t / (area * emitter.normal.dot(ray.direction).abs())
}

/// The part of an emitter's light that counts along a ray which a surface scattered, if light samples without the sky find it
/// too. The ray has a unit vector, chosen with the given density per solid angle.
pub(crate) fn scattered_weight(
    world: &World,
    receiver: &Receiver,
    density: f32,
    emitter: &Surface,
    ray: &Ray,
    hit: &Hit,
) -> f32 {
    let by_lights = emitted_density(world, receiver, SkyPart::Sun, emitter, ray, hit);
    LightSampling::Mis.bounce_weight(density, by_lights)
}

/// Light from what was chosen; which point or direction, `v` says with what the choice left.
#[inline(always)]
pub(crate) fn sample_light(
    world: &World,
    surface: &Surface,
    (lights, part): (LightSampling, SkyPart),
    choice: &SampledLight,
    v: f32,
) -> Option<LightSample> {
    let u = Vec2::new(choice.rest, v);
    let rarer = match &world.lights.lights()[choice.index as usize] {
        Light::Triangle(part) => return sample_triangle(world, surface, lights, (choice, part), u),
        Light::Punctual(light) => {
            let moved = world.motion().and_then(|_| world.moved_light(choice.index, light, surface.time));
            let light = moved.as_ref().unwrap_or(light);
            let (way, solid_angle) = sample_punctual(world, surface, (light, choice.index), u)?;
            let per_probability = choice.probability.recip();
            let (radiance, inv_density) = (way.received / choice.probability, solid_angle * per_probability);
            let LightWay { direction, shadow, .. } = way;
            LightSample { shadow, direction, radiance, inv_density, is_punctual: true, is_glass_known: true }
        }
        Light::Sky => sample_sky(world, surface, part, choice, u)?,
    };
    // Taken apart and put together, or the samples of triangles would be kept in memory as well.
    let LightSample { shadow, direction, radiance, inv_density, is_punctual, is_glass_known } = rarer;
    Some(LightSample { shadow, direction, radiance, inv_density, is_punctual, is_glass_known })
}

#[inline(always)]
fn sample_triangle(
    world: &World,
    surface: &Surface,
    lights: LightSampling,
    (choice, part): (&SampledLight, &TrianglePart),
    u: Vec2,
) -> Option<LightSample> {
    let ((corners, area), receiver) = (world.emitter_corners(choice.index, part, surface.time), surface.receiver());
    let warp = light_warp(&receiver, &corners, lights);
    let place = warp.map(u);
    let area = area / choice.probability * warp.per_density(place);
    let light = point_on_emitter(world, surface, part, place)?;
    let (sample, arrives) = area_light_sample(surface, receiver.behind > 0.0, &light, area);
    arrives.then_some(sample)
}

/// The point of a part of a triangle that `u` means, at the time of `receiver`, with its normals on the side that sends light
/// there, if both do; `None` in a hole.
#[inline(always)]
fn point_on_emitter<'w>(world: &'w World, receiver: &Surface, part: &TrianglePart, u: Vec2) -> Option<Surface<'w>> {
    let (prim_id, point) = (part.prim_id, part.place(TriangleWarp.map(u)));
    let opacity = world.opacity(prim_id, point.to_array());
    if opacity == 0.0 {
        return None;
    }
    let mut light = world.surface_at(&Hit { prim_id, u: point.x, v: point.y, time: receiver.time, ..Hit::MISS });
    light.emission *= opacity;
    Some(if light.material.emits_both_sides { light.facing(light.position - receiver.position) } else { light })
}

/// The light from a point of an emitter, whose front emits and which is chosen with a density per area whose reciprocal is
/// `area`; and whether any of it can arrive, from behind too or not. Without a branch, so that loops over it become lanes.
#[inline(always)]
pub(crate) fn area_light_sample(
    surface: &Surface,
    from_behind: bool,
    light: &Surface,
    area: f32,
) -> (LightSample, bool) {
    let to_light = light.position - surface.position;
    let (cosine, cosine_at_light) = (surface.normal.dot(to_light), -light.normal.dot(to_light));
    let inv_distance = to_light.length_squared().sqrt().recip();
    let direction = to_light * inv_distance;
    let inv_density = cosine_at_light * inv_distance * (inv_distance * inv_distance) * area;
    let origin = surface.origin_towards(direction);
    let shadow = Ray::between(origin, light.end_from(origin));
    let radiance = light.emission * inv_density;
    let sample = LightSample { shadow, direction, radiance, inv_density, is_punctual: false, is_glass_known: false };
    (sample, ((cosine > 0.0) | from_behind) & (cosine_at_light > 0.0))
}
