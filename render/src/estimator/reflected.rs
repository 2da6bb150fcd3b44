//! Light of points, spots and suns that arrives from a mirror or a glass face, by connections with one reflection.
//!
//! Where photons have left starts, manifold exploration finds the connections (see
//! [`specular`](crate::world::SpecularConnection)). They are samples of their own, beside that of a light: which light is
//! reflected to a point, the light tree does not know, as it may be behind the surface. One number `r` in [0, 1) decides
//! which starts are worth a search, all of them with the same number: those with
//!
//! `r ≤ q = min(1, s w / ALWAYS)`,
//!
//! where `s` is a start's strength, and what they find is divided by `q`. The light's share `w` is its own irradiance by
//! that of all lights, from 1/16 to 1, so that a faint lamp beside a sun costs little. The strongest come first, so that a
//! connection that several starts lead to counts with the probability of finding it. Of the connections that were found
//! one is chosen by what it brings. Of many lights, four are looked for.
//!
//! A light with a size is a disc that faces the photon's direction, of which one point is sampled and of the sun of a sky picture
//! one direction.

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::Frame;
use halfdome_kernel::sampling::warp::{PolarDisc, Warp};
use smallvec::SmallVec;

use super::punctual::{direction_of_sun, intensity};
use super::refracted::FINER;
use crate::light::{SkyPart, luminance_weight};
use crate::scene::PunctualLight;
use crate::world::{LightEnd, LightInMirrors, SpecularConnection, Start, Starts, Surface, World};

/// The strength from which on a start is always searched, of a light that is alone.
const ALWAYS: f32 = 0.5;
/// The least share of a light. What the light tree takes for bright may be behind a wall.
const LEAST_SHARE: f32 = 1.0 / 16.0;
/// The most connections to a point.
const MAX_CONNECTIONS: usize = 16;

/// Reflected light that arrives if nothing is in between.
pub(crate) struct ReflectedLight {
    /// The index of the light.
    pub light: u32,
    /// The unit vector by which it arrives.
    pub direction: Vec3,
    /// The ray from the last face to the light.
    pub shadow: Ray,
    /// Irradiance on what faces the direction, over the probability of the choice.
    pub received: Vec3,
    /// Whether bounces of narrow lobes find it too: it has a size, and its chain begins with the reflection.
    pub is_seen: bool,
}

/// A sample of the light that mirrors and glass reflect to a surface. The less important it is, from 0 to 1, the fewer
/// searches are made.
#[inline(never)]
pub(crate) fn sample_reflected(world: &World, surface: &Surface, importance: f32, u: Vec2) -> Option<ReflectedLight> {
    let [roulette, mut choice] = [u.x, u.y].map(|u| (FINER * u).fract());
    let mut starts = Starts::default();
    let mut found = SmallVec::<[(u32, SpecularConnection); MAX_CONNECTIONS]>::new();
    let (mut total, mut chosen) = (0.0, None);
    let always = ALWAYS / importance;
    let mut of_all_lights = None;
    for reflected in world.lights_in_mirrors(surface.position, (always, roulette)) {
        let all = *of_all_lights.get_or_insert_with(|| world.lights.weigh(&surface.receiver(), SkyPart::All).total());
        let always = always / share(&reflected, all);
        reflected.find_starts(surface.position, always, &mut starts);
        if starts.is_empty() {
            continue;
        }
        let LightInMirrors { index, light, inv_probability, .. } = reflected;
        let is_sky = index == world.lights.sky_number();
        let has_size = light.has_size();
        let instead = match is_sky {
            true => world.lights.sky.point_of_sun(u),
            false => world.motion().and_then(|_| world.moved_light(index, light, surface.time)),
        };
        // The numbers may mean another part of the sky.
        if is_sky && instead.is_none() {
            continue;
        }
        let light = instead.as_ref().unwrap_or(light);
        for start in starts.iter() {
            let probability = (start.strength / always).min(1.0);
            if found.len() == MAX_CONNECTIONS {
                break;
            }
            let (end, spread_of_size) = light_end(light, start, u);
            // The spacing of a sun's photons is no angle.
            let spacing = if let LightEnd::Point(_) = end { start.emission.spacing } else { 0.0 };
            if !surface.transmits && surface.normal.dot(start.direction) <= 0.0 {
                continue;
            }
            let Some(connection) = world.connection_from(surface, (end, start.emission.reflection), start.direction)
            else {
                continue;
            };
            let is_known =
                |(other, known): &(u32, SpecularConnection)| *other == index && known.is_same(&connection, spacing);
            if found.iter().any(is_known) {
                continue;
            }
            let SpecularConnection { direction, rest, leaving, transmittance, spread, .. } = connection;
            let received =
                transmittance * intensity(light, leaving) * (spread_of_size * spread * inv_probability / probability);
            let brought = received.element_sum() * surface.shading_normal.dot(direction).abs();
            if brought > 0.0 {
                total += brought;
                let share = brought / total;
                if choice < share {
                    let is_seen = start.emission.reflection == Some(0) && has_size;
                    chosen =
                        Some((ReflectedLight { light: index, direction, shadow: rest, received, is_seen }, brought));
                    choice /= share;
                } else {
                    choice = (choice - share) / (1.0 - share);
                }
            }
            found.push((index, connection));
        }
    }
    let (light, brought) = chosen?;
    Some(ReflectedLight { received: light.received * (total / brought), ..light })
}

/// A light's own irradiance on what faces it, as a part of that of all lights.
fn share(reflected: &LightInMirrors, of_all_lights: f32) -> f32 {
    let &LightInMirrors { light, distance_squared, .. } = reflected;
    let greatest = if let PunctualLight::Profiled { profile, .. } = light { profile.greatest() } else { 1.0 };
    let own = greatest * luminance_weight(light.power().0) / distance_squared;
    // Nothing but this light may reach the point, by its reflection.
    if own < of_all_lights { (own / of_all_lights).max(LEAST_SHARE) } else { 1.0 }
}

/// The point or direction of a light that two numbers in [0, 1) mean, and the radiance of that part over the density of its
/// choice, for an intensity or irradiance of one.
fn light_end(light: &PunctualLight, start: &Start, u: Vec2) -> (LightEnd, f32) {
    if let PunctualLight::Directional { direction, half_angle, .. } = *light {
        return direction_of_sun(direction, half_angle, u);
    }
    let (position, _, radius) = light.place().unwrap_or_default();
    let across = Frame::from_normal(start.emission.sent.normalize_or_zero()).to_world(PolarDisc.map(u).extend(0.0));
    (LightEnd::Point(position + radius * across), 1.0)
}

#[cfg(test)]
mod tests;
