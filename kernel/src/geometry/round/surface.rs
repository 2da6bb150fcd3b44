//! The surface at a hit with a point or a curve, and origins of rays that leave it.
//!
//! The point is found in `f64` and rounded once. Along the normal `n` that puts it off the surface by `u Σ |n| |x|` at
//! most, with `u = 2⁻²⁴`, and so does its sum with the offset; the offset has twice as much, so that the origin is
//! truly outside. As the test of the next ray is in `f64` too, it finds no crossing there. Two terms are for thin
//! curves that are seen from afar, where a normal may be off by `2⁻²⁰`, or is that of a touching plane nearby
//! (`linear`): one of the extent, along which a grazing ray might come back, and one of the distance.

use glam::Vec3;

use super::{RayFrame, RoundPrimitive, crossing};
use crate::geometry::{Ray, offset_point};

/// The rounding of the point and of its sum with the offset, twice over, in units of its coordinates.
const POINT_ERROR: f32 = 4.0 / (1u32 << 24) as f32;
/// The allowance for errors of the normal, in units of the primitive's extent.
const NORMAL_ERROR: f32 = 1.0 / (1u32 << 20) as f32;
/// How far a plane that touches a thin curve may be from the point, in units of the distance.
const PLANE_ERROR: f32 = 1.0 / (1u32 << 31) as f32;

/// The surface at a hit with a point or a curve: point, normals and side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundSurface {
    /// The point: nearer to the surface than `ray.at(t)`.
    pub point: Vec3,
    /// The unit normal of the side that the ray has hit. Cubic curves have edges between their pieces.
    pub normal: Vec3,
    /// The unit normal of the smooth curve, without edges, for shading; it may differ from `normal` by about half a
    /// degree.
    pub shading_normal: Vec3,
    /// Whether the ray has hit the outside, or the front of a disc.
    pub is_front: bool,
    /// The distance from the surface at which a ray that leaves it has to start.
    pub offset: f32,
}

impl RoundSurface {
    /// The surface where `ray` meets a primitive; `None` if it does not hit it. In a scene, both are in the item's own
    /// space.
    pub fn of<P: RoundPrimitive>(ray: &Ray, primitive: &P) -> Option<Self> {
        let frame = RayFrame::new(ray)?;
        if primitive.fault().is_some() {
            return None;
        }
        let (crossing, is_entry) = crossing(&frame, ray, primitive)?;
        let [x, y, z] = frame.at(crossing.z);
        let point = Vec3::new(x as f32, y as f32, z as f32);
        let is_front = if P::IS_FLAT { crossing.outward[2] <= 0.0 } else { is_entry };
        let side = |outward: [f64; 3]| {
            let normal = frame.turn_back(outward);
            if is_front { normal } else { -normal }
        };
        let (normal, smooth) = (side(crossing.outward), P::smooth_outward(&frame, &primitive.numbers(), &crossing));
        let bounds = primitive.bounds();
        let extent = (bounds.max - bounds.min).max_element();
        let offset =
            normal.abs().dot(point.abs()) * POINT_ERROR + extent * NORMAL_ERROR + crossing.z.abs() as f32 * PLANE_ERROR;
        Some(Self { point, normal, shading_normal: side(smooth), is_front, offset })
    }

    /// The origin of a ray into `direction` that leaves the surface, on the side to which it points.
    ///
    /// On the outside that ray does not hit the primitive again, unless a curve bends into its path. Inside a primitive
    /// thinner than the last place of its coordinates, the origin may lie beyond the far side.
    pub fn origin(&self, direction: Vec3) -> Vec3 {
        offset_point(self.point, self.normal, self.offset, direction)
    }
}
