//! Pictures of the chosen lights: for each camera ray the colour of the light that path tracing would sample at the
//! first surface, with the same random number. A pixel's mean mixes the colours in proportion to its light samples.

use glam::Vec3;
use halfdome_kernel::Ray;

use super::path::SKY;
use super::shadow_queue::ShadowQueue;
use super::state::Path;
use super::wavefront::{PathVertex, ScalarSteps, VertexStep};
use super::{RayBatch, Wavefront};
use crate::world::World;

/// Writes the colour of the light that is chosen for each camera ray, black where there is none; traces no further ray.
pub(super) fn colors(world: &World, batch: &RayBatch, wave: &mut Wavefront, radiance: &mut [Vec3]) -> u64 {
    wave.follow(world, batch, &mut ScalarSteps { world, step: ChosenLight { world } }, radiance)
}

struct ChosenLight<'a> {
    world: &'a World,
}

impl VertexStep for ChosenLight<'_> {
    fn max_depth(&self) -> u32 {
        1
    }

    #[inline(always)]
    fn step(&mut self, _: Path, vertex: &PathVertex, _: &mut ShadowQueue, color: &mut Vec3) -> Option<(Path, Ray)> {
        let PathVertex { ray, hit, numbers, .. } = vertex;
        if hit.is_hit() {
            let mut surface = self.world.surface_at(hit).facing(ray.direction);
            // Leaves and panes receive light from behind.
            self.world.scattering(&mut surface);
            let receiver = surface.receiver();
            let weights = self.world.lights.weigh(&receiver, SKY);
            if let Some(light) = self.world.lights.choose(&receiver, &weights, numbers.light().0) {
                *color = self.world.light_color(light.index);
            }
        }
        None
    }
}
