//! The sample points of direct light, all over a texel, so that the edge of a shadow across it is as soft as the texel
//! is wide.
//!
//! Points on other triangles than the texel's own are left out, and points occluded from the texel's own point: a floor
//! continues under a crate, where it is dark.

use halfdome_kernel::Ray;

use crate::bake::layout::texels::{Surfaces, Texel};
use crate::world::{Surface, World};

/// Points across and down a texel.
const SIDE: u32 = 4;

/// The points of a texel, its own alone if nothing else will do; and the number of rays that it took.
pub(super) fn direct_points<'w>(world: &'w World, surfaces: &Surfaces, texel: &Texel) -> (Vec<Surface<'w>>, u64) {
    let own = world.receiver(texel.point.prim_id, texel.point.barycentric);
    if texel.is_moved {
        return (vec![own], 0);
    }
    let points = surfaces.spread(texel, SIDE);
    let mut found: Vec<Surface> =
        points.into_iter().map(|point| world.receiver(point.prim_id, point.barycentric)).collect();
    let start = own.origin_towards(own.normal);
    let way = |point: &Surface| {
        let way = point.origin_towards(point.normal) - start;
        Ray { t_max: 1.0, ..Ray::new(start, way) }
    };
    let rays: Vec<Ray> = found.iter().map(way).collect();
    let mut occluded = vec![false; rays.len()];
    world.occluded_many(&rays, &mut occluded);
    let mut is_hidden = occluded.into_iter();
    found.retain(|_| !is_hidden.next().unwrap_or(false));
    if found.is_empty() {
        found.push(own);
    }
    (found, rays.len() as u64)
}
