//! How much of the light of lamps in glass comes from where they are seen straight through the glass: little where the glass
//! bends it much, as the surface of water does.

use glam::Vec2;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Triangle as TriangleWarp, Warp};
use halfdome_kernel::sampling::{Frame, Pattern, Sampler};
use halfdome_kernel::{Aabb, Ray, triangle_normal};

use crate::light::{box_faces, luminance_weight};
use crate::material::{Closure, Shading};
use crate::world::{Hit, MIDDLE, World, interpolate};

/// Rays that measure it: of all lamps together, and the least and the most of each.
const RAYS: usize = 1 << 16;
const LEAST_RAYS: usize = 24;
const MOST_RAYS: usize = 240;
/// The most faces of glass on the way.
const MAX_FACES: u32 = 8;

/// The number of rays for each of so many lamps.
pub(super) fn arriving_rays(lamps: usize) -> u32 {
    (RAYS / lamps.max(1)).clamp(LEAST_RAYS, MOST_RAYS) as u32
}

impl World {
    /// The light that rays towards a lamp's box find through glass, relative to what they would find if the glass bent
    /// none: by so many rays. The lamp's emissive triangles are among these, which ascend.
    pub(super) fn arriving(&self, bounds: &Aabb, emitters: &[u32], count: u32) -> f32 {
        let faces = box_faces(bounds);
        let (mut found, mut straight) = (0.0, 0.0);
        for number in 0..count {
            let corners = faces[number as usize % faces.len()];
            let sampler = Sampler::new(Pattern::Sobol, 0, 0, number);
            let ([.., x, y], v) = (sampler.uniform4(1), sampler.uniform2(2));
            let point = TriangleWarp.map(Vec2::new(x, y));
            let point = interpolate(corners, [1.0 - point.x - point.y, point.x, point.y]);
            let outwards = Frame::from_normal(triangle_normal(&corners)).to_world(CosineHemisphere.map(v));
            let Some(ray) = self.back_from_beyond_glass(&Ray::new(point, outwards)) else { continue };
            let hit = self.intersect_at(&ray, MIDDLE);
            let lamp = self.straight_behind_glass(&ray, &hit, MIDDLE);
            if emitters.binary_search(&lamp.prim_id).is_ok() {
                straight += 1.0;
            }
            found += self.refracted(ray, emitters, number);
        }
        if straight > 0.0 { found / straight } else { 0.0 }
    }

    /// A ray back along one, from where it has left all glass; `None` if it meets none.
    fn back_from_beyond_glass(&self, outwards: &Ray) -> Option<Ray> {
        let (mut ray, mut left) = (*outwards, None);
        for _ in 0..MAX_FACES {
            let hit = self.intersect_at(&ray, MIDDLE);
            if !self.is_clear_glass(&hit) {
                break;
            }
            left = Some(hit);
            ray.t_min = hit.t.next_up();
        }
        let back = self.surface_at(&left?).origin_towards(outwards.direction);
        Some(Ray::new(back, -outwards.direction))
    }

    /// The part of an emitter's light that a path finds by way of glass alone.
    fn refracted(&self, mut ray: Ray, emitters: &[u32], number: u32) -> f32 {
        let mut throughput = 1.0;
        for depth in 0..MAX_FACES {
            let hit: Hit = self.intersect_at(&ray, MIDDLE);
            if emitters.binary_search(&hit.prim_id).is_ok() {
                return throughput;
            }
            if !self.is_clear_glass(&hit) {
                break;
            }
            let surface = self.surface_at(&hit).facing(ray.direction);
            let shading = Shading::new(surface.normal, surface.shading_normal, surface.tangent, surface.wo);
            let u = Sampler::new(Pattern::Sobol, 0, 1 + depth, number).uniform2(0);
            let Some(next) = shading.sample(&self.closure::<Closure>(&surface), surface.wo, u) else { break };
            throughput *= luminance_weight(next.weight);
            ray = Ray::new(surface.origin_towards(next.wi), next.wi);
        }
        0.0
    }
}
