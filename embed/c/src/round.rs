//! Trees of points and curves, for scenes.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use halfdome_kernel::bvh::RoundBuild;
use halfdome_kernel::geometry::RoundSurface;
use halfdome_kernel::{BuildOptions, CubicCurve, Disc, LinearCurve, Ray, RoundBvh, Sphere};

use crate::border::{check, elements, make, room_for_one};
use crate::status::hd_status::*;
use crate::status::{Failure, guard, hd_status};
use crate::trace::hd_ray;
use crate::tree::{build_options, hd_build_options};

/// A tree of points or curves. Scenes alone have it.
pub struct hd_round_tree(pub(crate) Arc<RoundBvh>);

/// Spheres of four numbers: centre and radius.
pub const HD_SPHERES: u32 = 0;
/// Flat discs of seven numbers: centre, radius, and a normal of any length but 0.
pub const HD_DISCS: u32 = 1;
/// Spheres swept along segments, of eight numbers: centre and radius at both ends.
pub const HD_LINEAR_CURVES: u32 = 2;
/// Spheres swept along Bézier curves, of sixteen numbers: four control points with a radius each.
pub const HD_CUBIC_CURVES: u32 = 3;

/// What a hit with a point or a curve says of the surface.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct hd_round_surface {
    /// The point, which is nearer to the surface than origin + t * direction.
    pub point: [f32; 3],
    /// How far off the point along the normal, or against it, a ray has to start that leaves the surface.
    pub offset: f32,
    /// Unit normal of the side that the ray has met.
    pub normal: [f32; 3],
    /// 1 if that is the outside, or of a disc the side that it faces, else 0.
    pub is_front: u32,
    /// Unit normal for shading: without the edges that cubic curves have.
    pub shading_normal: [f32; 3],
    /// 0
    pub reserved: u32,
}

/// Does the same with the type of a kind.
macro_rules! with_kind {
    ($kind:expr, $primitive:ident => $do:expr) => {
        match $kind {
            HD_SPHERES => {
                type $primitive = Sphere;
                $do
            }
            HD_DISCS => {
                type $primitive = Disc;
                $do
            }
            HD_LINEAR_CURVES => {
                type $primitive = LinearCurve;
                $do
            }
            HD_CUBIC_CURVES => {
                type $primitive = CubicCurve;
                $do
            }
            other => {
                let message = format!("kind is {other}: it must be one of HD_SPHERES to HD_CUBIC_CURVES, 0 to 3");
                Err(Failure::new(HD_ERROR_VALUE, message))
            }
        }
    };
}

/// Builds a tree of count points or curves of a kind, of which the numbers lie one after the other, and are copied.
/// options may be NULL. Those that no ray can hit are left out: of no radius, too far away, or with a NaN. Put it in a
/// scene as hd_item's round. A hit's prim_id is the place in the array; u is where along a curve it is, 0 to 1, or a
/// disc's distance from the centre in radii; v is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_round_tree_build(
    kind: u32,
    numbers: *const f32,
    count: usize,
    options: *const hd_build_options,
    tree: *mut *mut hd_round_tree,
) -> hd_status {
    guard(|| {
        let build = || {
            // SAFETY: the caller's promise.
            let options = unsafe { build_options(options)? };
            // SAFETY: the caller's promise.
            let tree = with_kind!(kind, Primitive => unsafe { build::<Primitive>(numbers, count, &options) })?;
            Ok(hd_round_tree(Arc::new(tree)))
        };
        // SAFETY: the caller's promise.
        unsafe { make("tree", tree, build) }
    })
}

/// # Safety
/// If `numbers` is not null, as many as `count` primitives have lie there.
unsafe fn build<P: RoundBuild>(numbers: *const f32, count: usize, options: &BuildOptions) -> Result<RoundBvh, Failure> {
    // SAFETY: the caller's promise; primitives are floats, whose alignment is theirs.
    let primitives: &[P] = unsafe { elements("numbers", numbers.cast(), count) }?;
    Ok(RoundBvh::build(primitives, options)?.0)
}

/// What a ray meets of a single point or curve, which has these numbers: after a hit, those of its prim_id. The ray is
/// in the item's own space, as the numbers are.
///
/// HD_ERROR_VALUE if the ray does not hit it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_round_surface_at(
    kind: u32,
    numbers: *const f32,
    ray: *const hd_ray,
    surface: *mut hd_round_surface,
) -> hd_status {
    guard(|| {
        check("ray", ray, 1)?;
        check("surface", surface, 1)?;
        // SAFETY: the caller's promise.
        let ray: Ray = bytemuck::cast(unsafe { *ray });
        let found = with_kind!(kind, Primitive => {
            // SAFETY: the caller's promise.
            let primitive: &[Primitive] = unsafe { elements("numbers", numbers.cast(), 1) }?;
            Ok::<_, Failure>(RoundSurface::of(&ray, &primitive[0]))
        })?;
        let found = found.ok_or_else(|| Failure::new(HD_ERROR_VALUE, "ray does not hit it"))?;
        // SAFETY: the caller's promise.
        *unsafe { room_for_one("surface", surface) }? = hd_round_surface {
            point: found.point.to_array(),
            offset: found.offset,
            normal: found.normal.to_array(),
            is_front: found.is_front.into(),
            shading_normal: found.shading_normal.to_array(),
            reserved: 0,
        };
        Ok(())
    })
}

/// Frees a tree. Scenes that it is in keep it. NULL is allowed.
#[unsafe(no_mangle)]
pub extern "C" fn hd_round_tree_free(tree: Option<Box<hd_round_tree>>) {
    drop(tree);
}
