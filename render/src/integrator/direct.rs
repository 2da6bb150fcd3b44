//! Direct light: what a surface emits and reflects of light that comes straight from its source, with its shadow.
//!
//! Each sample takes one light, by its power: `L = L_e + f L_light cos θ / P`, if nothing is in between. What a mirror or
//! a pane shows is seen as directly as what the camera sees (Whitted 1980): paths go on for as long as their density is
//! infinite, as that of the camera's ray is.

use glam::Vec3;
use halfdome_kernel::sampling::unit_double;

use super::path::{emission, sky};
use super::wavefront::Path;
use super::{CameraRays, Wavefront};
use crate::estimator::connect;
use crate::settings::{DirectOptions, LightSampling};
use crate::world::World;

/// Writes the radiance along each camera ray; gives the number of further rays.
pub(super) fn radiance(
    world: &World,
    options: &DirectOptions,
    camera: &CameraRays,
    wave: &mut Wavefront,
    radiance: &mut [Vec3],
) -> u64 {
    const LIGHTS: LightSampling = LightSampling::Direct;
    radiance.fill(Vec3::ZERO);
    wave.start(camera);
    let mut traced = 0;
    for depth in 1..=options.max_depth {
        wave.advance(world, camera, depth, |path, ray, hit, [first, on_light, onwards], connections| {
            let Path { index, throughput, .. } = path;
            if !hit.is_hit() {
                radiance[index] += throughput * sky(world, LIGHTS, &path, ray.direction);
                return None;
            }
            let surface = world.surface_at(hit);
            radiance[index] += throughput * emission(world, LIGHTS, &path, &surface, ray, hit.t);

            let surface = surface.facing(ray.direction);
            let choice = unit_double(first);
            if let Some(connection) = connect(world, &surface, LIGHTS, choice, on_light) {
                connections.push(index, throughput, connection);
            }
            path.through(&surface, ray, onwards)
        });
        traced += wave.connect(world, radiance);
        if wave.is_empty() {
            break;
        }
        traced += wave.trace(world);
    }
    traced
}
