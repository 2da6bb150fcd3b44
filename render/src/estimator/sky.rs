//! Light samples of the sky.
//!
//! Light comes straight through panes. What other glass does with it is left to bounces, but for the [sun](SkyLight::sun) of a
//! picture, which these would rarely find: if a sample looks there, its light may come by connections, too.

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;

use super::light_sample::LightSample;
use super::refracted::{FINER, LightWay, Wedges, choose_way};
#[cfg(doc)]
use crate::light::SkyLight;
use crate::light::{Receiver, SampledLight, SkyPart, SkySample, SkyView};
use crate::world::{Between, LightEnd, SpecularConnection, Surface, World};

/// The probability with which light samples at `surface` look at this part of the sky, without those through openings.
pub(crate) fn sky_probability(world: &World, surface: &Surface, part: SkyPart) -> f32 {
    if world.lights.sky.has(part) { world.lights.weigh(&surface.receiver(), part).sky_probability() } else { 0.0 }
}

/// The radiance of the sky in a unit vector with its view, and the density per solid angle with which light samples at
/// `receiver` that look at this part of it with a probability, and those through openings, look there.
pub(crate) fn seen_sky(
    world: &World,
    receiver: &Receiver,
    (probability, part): (f32, SkyPart),
    (direction, view): (Vec3, &SkyView),
) -> (Vec3, f32) {
    let sky = &world.lights.sky;
    let openings = sky.openings().filter(|_| part == SkyPart::Bright);
    let through_openings = openings.map_or(0.0, |openings| openings.density(receiver, direction));
    let SkySample { radiance, density, .. } = sky.seen(receiver, part, view);
    (radiance, probability * density + through_openings)
}

/// A sample of this part of the sky, which was chosen among all lights.
#[inline(never)]
pub(super) fn sample_sky(
    world: &World,
    surface: &Surface,
    part: SkyPart,
    choice: &SampledLight,
    u: Vec2,
) -> Option<LightSample> {
    let (sky, receiver) = (&world.lights.sky, surface.receiver());
    let SkySample { direction, radiance, density, of_sun } = sky.sample(&receiver, part, u);
    let is_below = !surface.transmits && surface.normal.dot(direction) <= 0.0;
    let may_bend = of_sun != Vec3::ZERO && world.has_clear_glass();
    if density <= 0.0 || (is_below && !may_bend) {
        return None;
    }
    let shadow = Ray::new(surface.origin_towards(direction), direction);
    let openings = sky.openings().filter(|_| part == SkyPart::Bright);
    let through_openings = openings.map_or(0.0, |openings| openings.density(&receiver, direction));
    let density = choice.probability * density;
    let inv_density = (density + through_openings).recip();
    let radiance = if is_below { Vec3::ZERO } else { radiance * inv_density };
    // No bounce sees the sun where that is what is asked for.
    let inv_density = if part == SkyPart::Sun { 0.0 } else { inv_density };
    let straight = LightSample { shadow, direction, radiance, inv_density, is_punctual: false, is_glass_known: false };
    if !may_bend {
        return Some(straight);
    }
    let way = sun_by_glass(world, surface, choice.index, &straight, of_sun / density, (u.x * FINER).fract())?;
    let LightWay { direction, shadow, received: radiance, is_bent, .. } = way;
    let inv_density = if is_bent { 0.0 } else { inv_density };
    Some(LightSample { shadow, direction, radiance, inv_density, is_punctual: false, is_glass_known: true })
}

/// The way to a surface of light from the direction of a sample of the sky, which has this number, of which `bent` is the sun's
/// radiance over the density.
fn sun_by_glass(
    world: &World,
    surface: &Surface,
    number: u32,
    sample: &LightSample,
    bent: Vec3,
    u: f32,
) -> Option<LightWay> {
    let LightSample { direction, shadow, radiance, .. } = *sample;
    let way = |shadow, received, is_bent, wedges| LightWay { direction, shadow, received, is_bent, wedges };
    let known = world.panes().and_then(|_| world.through_panes(&shadow, surface.time));
    let between = || world.glass_between(&shadow, surface.time);
    let straight = match known {
        // Samples through openings and bounces find it too.
        Some((rest, transmittance)) => {
            let crosses_wedges =
                rest.t_min > shadow.t_min && !matches!(between(), Between::Panes { are_exact: true, .. });
            let wedges = if crosses_wedges { Wedges::OfBounces } else { Wedges::None };
            Some(way(rest, transmittance * radiance, false, wedges))
        }
        None => match between() {
            Between::NoGlass => Some(way(shadow, radiance, false, Wedges::None)),
            Between::Panes { rest, transmittance, are_exact } => {
                Some(way(rest, transmittance * bent, true, Wedges::of_samples(are_exact)))
            }
            Between::Bends => None,
        },
    };
    let received = |connection: &SpecularConnection| connection.transmittance * connection.spread * bent;
    choose_way(world, surface, (LightEnd::Direction(direction), number), straight, received, u)
}
