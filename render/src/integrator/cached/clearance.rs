//! The clearance of a point: the distance of its surroundings on all sides. Where it is far less than at a record, the
//! record is not valid there: the point lies behind something, such as a ceiling above a lamp that hangs just below it.
//! From outside, few rays of a gather are flat enough to find such a gap.

use std::f32::consts::FRAC_1_SQRT_2;

use glam::Vec3;
use halfdome_kernel::Ray;

use crate::cache::LookupPoint;
use crate::world::{Hit, Surface, World};

/// Directions halfway up, on four sides.
const DIRECTIONS: [Vec3; 4] = [
    Vec3::new(0.5, 0.5, FRAC_1_SQRT_2),
    Vec3::new(-0.5, 0.5, FRAC_1_SQRT_2),
    Vec3::new(-0.5, -0.5, FRAC_1_SQRT_2),
    Vec3::new(0.5, -0.5, FRAC_1_SQRT_2),
];

/// A surface's point that asks for records, with its clearance.
pub(crate) fn lookup_point(world: &World, surface: &Surface) -> LookupPoint {
    LookupPoint { clearance: Some(clearance(world, surface)), ..lookup_point_anywhere(surface) }
}

/// The same without its clearance, which takes rays.
pub(super) fn lookup_point_anywhere(surface: &Surface) -> LookupPoint {
    LookupPoint { position: surface.position, normal: surface.smooth_normal, clearance: None }
}

/// The distance to the farthest of what a ray to each side hits; infinite if any hits nothing.
pub(super) fn clearance(world: &World, surface: &Surface) -> f32 {
    // Whatever maps do to its normal.
    let surface = surface.smooth();
    let (frame, origin) = (surface.frame(), surface.origin_towards(surface.normal));
    let rays = DIRECTIONS.map(|direction| Ray::new(origin, frame.to_world(direction)));
    let mut hits = [Hit::MISS; DIRECTIONS.len()];
    world.intersect_many(&rays, &mut hits);
    hits.iter().map(|hit| if hit.is_hit() { hit.t } else { f32::INFINITY }).fold(0.0, f32::max)
}
