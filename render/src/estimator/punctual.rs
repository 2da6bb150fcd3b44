//! Samples of point, spot and directional lights, delta lights or not.
//!
//! A point light of radius `r` is a sphere of even radiance `L = I / (π r²)`, of which a receiver at the distance `d`
//! sees a cap of directions with `sin θ_max = r / d`. Directions are spread evenly over it, so that radiance over
//! density is `2π (1 - cos θ_max) L = 2 I / (d² (1 + cos θ_max))`, which is `I / d²` for a delta light. A sun that
//! causes the irradiance `E` likewise gives `2 E / (1 + cos θ_max)`. Within the sphere light comes from everywhere,
//! with `4π L`.
//!
//! Rays from mirrors and glossy surfaces hit the lights with a size ([`seen`]). Shadow rays to all of them cross panes,
//! and refracted light is found by manifold exploration; for reflected light see [`reflected`](super::reflected).

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::Frame;
use halfdome_kernel::sampling::warp::{UniformSphere, Warp};

use super::refracted::{FINER, LightWay, Wedges, choose_way};
use crate::light::SpotCone;
use crate::scene::PunctualLight;
use crate::world::{LightEnd, SpecularConnection, Surface, World};

/// Such a light on the way of a ray.
pub(super) struct Seen {
    pub radiance: Vec3,
    /// The distance to its near side.
    pub distance: f32,
    /// The solid angle at the ray's origin.
    pub solid_angle: f32,
}

/// The sample of `light`, which has this number, for a point of a surface that the two numbers in [0, 1) mean, and the
/// reciprocal of its density per solid angle, which is 0 of what no bounce will find; `None` if glass keeps it off.
#[inline(never)]
pub(super) fn sample_punctual(
    world: &World,
    surface: &Surface,
    (light, number): (&PunctualLight, u32),
    u: Vec2,
) -> Option<(LightWay, f32)> {
    let (end, per_intensity) = match *light {
        PunctualLight::Directional { direction, half_angle, .. } => direction_of_sun(direction, half_angle, u),
        PunctualLight::Point { position, radius, .. }
        | PunctualLight::Spot { position, radius, .. }
        | PunctualLight::Profiled { position, radius, .. } => {
            let (end, per_intensity) = point_on_sphere(surface.position, position, radius, u);
            (LightEnd::Point(end), per_intensity)
        }
    };
    let (direction, shadow) = match end {
        LightEnd::Direction(direction) => (direction, Ray::new(surface.origin_towards(direction), direction)),
        LightEnd::Point(end) => towards(surface, end),
    };
    let received = intensity(light, -direction) * per_intensity;
    let straight = LightWay { direction, shadow, received, is_bent: false, wedges: Wedges::None };
    let solid_angle = solid_angle(surface.position, light);
    if !world.has_clear_glass() {
        return Some((straight, solid_angle));
    }
    let received = |connection: &SpecularConnection| {
        let spread = match end {
            LightEnd::Direction(_) => connection.spread,
            // Per area of the light in place of solid angle.
            LightEnd::Point(end) => connection.spread * end.distance_squared(surface.position),
        };
        connection.transmittance * intensity(light, connection.leaving) * (per_intensity * spread)
    };
    // The low digits: place and choice depend on one number, but hardly on each other. Parts of 1/4096 and less may never be chosen.
    let straight = straight.straight(world, surface.time);
    let way = choose_way(world, surface, (end, number), straight, received, (u.x * FINER).fract())?;
    // The density of the place on the light stays what bounces take it for.
    let inv_density = if way.is_bent { 0.0 } else { solid_angle };
    Some((way, inv_density))
}

/// The intensity in a unit vector that leaves a light; of a sun, its irradiance.
pub(super) fn intensity(light: &PunctualLight, leaving: Vec3) -> Vec3 {
    match *light {
        PunctualLight::Directional { irradiance, .. } => irradiance,
        PunctualLight::Point { intensity, .. } => intensity,
        PunctualLight::Spot { direction: axis, intensity, cos_inner, cos_outer, edge, .. } => {
            intensity * SpotCone::new(cos_inner, cos_outer, edge).part(leaving.dot(axis))
        }
        PunctualLight::Profiled { ref frame, intensity, ref profile, .. } => {
            intensity * profile.candela(frame, leaving)
        }
    }
}

/// The solid angle of a light from a point; 0 for a delta light.
fn solid_angle(from: Vec3, light: &PunctualLight) -> f32 {
    let sin_squared = match light {
        PunctualLight::Directional { half_angle, .. } => half_angle.sin() * half_angle.sin(),
        _ => match light.place() {
            Some((position, _, radius)) if radius > 0.0 => radius * radius / position.distance_squared(from),
            _ => 0.0,
        },
    };
    if sin_squared < 1.0 { TAU * sin_squared / (1.0 + (1.0 - sin_squared).sqrt()) } else { 2.0 * TAU }
}

/// What a ray in a unit vector sees of a light of a size up to the distance `t_max`.
pub(super) fn seen(ray: &Ray, t_max: f32, light: &PunctualLight) -> Option<Seen> {
    let (origin, direction) = (ray.origin, ray.direction);
    let (distance, radiance) = match *light {
        PunctualLight::Directional { direction: axis, irradiance, half_angle } => {
            let sin = half_angle.sin();
            // Compares chords, as a cosine near 1 is inexact.
            let is_in = (direction + axis).length_squared() < 4.0 * (0.5 * half_angle).sin().powi(2);
            (is_in && t_max == f32::INFINITY).then(|| (f32::INFINITY, irradiance / (PI * sin * sin)))?
        }
        _ => {
            let (position, _, radius) = light.place()?;
            let distance = met(position - origin, radius, direction)?;
            (distance, intensity(light, -direction) * (PI * radius * radius).recip())
        }
    };
    let is_seen = distance <= t_max && radiance.cmpgt(Vec3::ZERO).any();
    is_seen.then(|| Seen { radiance, distance, solid_angle: solid_angle(origin, light) })
}

/// Where a ray from the origin in a unit vector first meets the sphere about `center`, which has no inside if it has no size.
fn met(center: Vec3, radius: f32, direction: Vec3) -> Option<f32> {
    let (along, squared) = (center.dot(direction), radius * radius);
    let is_met = (center - direction * along).length_squared() < squared;
    let is_inside = center.length_squared() < squared;
    (is_met && (is_inside || along > 0.0))
        .then(|| crossing(center, radius, direction, if is_inside { 1.0 } else { -1.0 }))
}

/// The unit vector from a surface to a point, and the ray in between.
fn towards(surface: &Surface, end: Vec3) -> (Vec3, Ray) {
    let way = end - surface.position;
    (way.normalize_or_zero(), Ray::between(surface.origin_towards(way), end))
}

/// A point of a sphere that is seen from `from`, and its radiance over density for an intensity of one.
fn point_on_sphere(from: Vec3, center: Vec3, radius: f32, u: Vec2) -> (Vec3, f32) {
    let way = center - from;
    let squared = way.length_squared();
    if radius == 0.0 {
        return (center, squared.recip());
    }
    let sin_squared = radius * radius / squared;
    if sin_squared < 1.0 {
        let cos = (1.0 - sin_squared).sqrt();
        let direction = in_cap(way * squared.sqrt().recip(), sin_squared.sqrt(), cos, u);
        (from + direction * crossing(way, radius, direction, -1.0), 2.0 / (squared * (1.0 + cos)))
    } else {
        let direction = UniformSphere.map(u);
        (from + direction * crossing(way, radius, direction, 1.0), 4.0 / (radius * radius))
    }
}

/// Where a ray from the origin in a unit vector enters (`side` is -1) or leaves (1) the sphere about `center`.
fn crossing(center: Vec3, radius: f32, direction: Vec3, side: f32) -> f32 {
    let along = center.dot(direction);
    // What is left of the centre's way across the ray, as the difference of squares would not be exact.
    let across = (center - direction * along).length_squared();
    along + side * (radius * radius - across).max(0.0).sqrt()
}

/// A direction to a sun that shines along `direction`, and its radiance over density for an irradiance of one.
pub(super) fn direction_of_sun(direction: Vec3, half_angle: f32, u: Vec2) -> (LightEnd, f32) {
    let (sin, cos) = half_angle.sin_cos();
    let to_light = if half_angle > 0.0 { in_cap(-direction, sin, cos, u) } else { -direction };
    (LightEnd::Direction(to_light), 2.0 / (1.0 + cos))
}

/// A unit vector in the cap about `axis` whose rim has this sine and cosine, evenly by solid angle.
fn in_cap(axis: Vec3, sin: f32, cos: f32, u: Vec2) -> Vec3 {
    // 1 - cos θ, without the rounding of a cosine near 1.
    let depth = u.x * (sin * sin / (1.0 + cos));
    let out = (depth * (2.0 - depth)).max(0.0).sqrt();
    let (y, x) = (TAU * u.y).sin_cos();
    Frame::from_normal(axis).to_world(Vec3::new(out * x, out * y, 1.0 - depth))
}
