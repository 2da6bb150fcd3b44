//! Texels of which something close in front covers a part.
//!
//! Light beneath a rug, or between a ceiling and the lamps below it, differs from that beside it, and rays from the room
//! see the part beside alone. So a texel's mean says nothing about what they see there.

use halfdome_kernel::Ray;

use crate::bake::layout::texels::{Point, Surfaces, Texel};
use crate::world::World;

/// Points across and down a texel.
const SIDE: u32 = 4;

/// Whether something is in front of some of a texel's points, but not of all, no farther than the texel is wide.
pub(super) fn is_partly_covered(world: &World, surfaces: &Surfaces, texel: &Texel) -> bool {
    let upwards = |point: Point| {
        let surface = world.receiver(point.prim_id, point.barycentric);
        Ray { t_max: texel.spacing, ..Ray::new(surface.origin_towards(surface.normal), surface.normal) }
    };
    let rays: Vec<Ray> = surfaces.spread(texel, SIDE).into_iter().map(upwards).collect();
    let mut covered = vec![false; rays.len()];
    world.occluded_many(&rays, &mut covered);
    covered.iter().any(|&is_covered| is_covered) && !covered.iter().all(|&is_covered| is_covered)
}
