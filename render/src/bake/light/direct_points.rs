//! The points of a texel at which a bake samples direct light: spread over the texel, so that the edge of a shadow
//! across it is as soft as the texel is wide.
//!
//! Points on other triangles than the texel's own are left out, and so are points occluded from the texel's own point:
//! a floor continues under a crate, where it is dark.

use halfdome_kernel::Ray;

use crate::bake::layout::texels::{Surfaces, Texel};
use crate::world::{Surface, World};

/// Points across and down a texel.
const SIDE: u32 = 4;

/// The points of a texel at which direct light is sampled, its own alone if no other is usable; and the number of rays
/// that were traced to test them.
pub(super) fn direct_points<'w>(world: &'w World, surfaces: &Surfaces, texel: &Texel) -> (Vec<Surface<'w>>, u64) {
    let own = world.receiver(texel.point.prim_id, texel.point.barycentric);
    if texel.is_moved {
        return (vec![own], 0);
    }
    let points = surfaces.spread(texel, SIDE);
    let mut found: Vec<Surface> =
        points.into_iter().map(|point| world.receiver(point.prim_id, point.barycentric)).collect();
    let start = own.origin_towards(own.normal);
    let to_point = |point: &Surface| Ray::between(start, point.origin_towards(point.normal));
    let rays: Vec<Ray> = found.iter().map(to_point).collect();
    let mut occluded = vec![false; rays.len()];
    world.occluded_many(&rays, &mut occluded);
    let mut is_hidden = occluded.into_iter();
    found.retain(|_| !is_hidden.next().unwrap_or(false));
    if found.is_empty() {
        found.push(own);
    }
    (found, rays.len() as u64)
}
