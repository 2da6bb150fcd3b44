//! Rays through trees: one, or many at a time.

use bytemuck::{Pod, Zeroable, cast_ref, cast_slice, cast_slice_mut};
use halfdome_kernel::{Hit, Isa, Ray};
use std::ffi::{CStr, c_char};

use crate::border::{element, elements, handle, room, room_for_one};
use crate::status::hd_status::*;
use crate::status::{Failure, guard, hd_status};
use crate::tree::hd_tree;

/// The points origin + t direction, from t_min to t_max.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct hd_ray {
    /// Where t is 0.
    pub origin: [f32; 3],
    /// The least t that counts.
    pub t_min: f32,
    /// Where the ray goes. It need not have unit length; t counts in its lengths.
    pub direction: [f32; 3],
    /// The greatest t that counts; may be infinite.
    pub t_max: f32,
}

/// Where a ray meets a triangle: at origin + t direction, which is (1 - u - v) v0 + u v1 + v v2.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct hd_hit {
    /// Distance in lengths of the direction; infinite if nothing was hit.
    pub t: f32,
    /// Weight of the triangle's second corner.
    pub u: f32,
    /// Weight of the triangle's third corner.
    pub v: f32,
    /// The triangle's number in its mesh; HD_NO_PRIM if nothing was hit.
    pub prim_id: u32,
}

/// The prim_id of a ray that hits nothing.
pub const HD_NO_PRIM: u32 = 0xFFFF_FFFF;

const _: () = assert!(HD_NO_PRIM == Hit::NO_PRIM);

/// The rays, as the kernel has them, if they are numbers.
pub(crate) fn checked(rays: &[hd_ray]) -> Result<&[Ray], Failure> {
    let is_nan = |ray: &hd_ray| cast_ref::<hd_ray, [f32; 8]>(ray).iter().any(|number| number.is_nan());
    match rays.iter().position(is_nan) {
        Some(number) => Err(Failure::new(HD_ERROR_VALUE, format!("ray {number} has a NaN"))),
        None => Ok(cast_slice(rays)),
    }
}

/// Finds the nearest hit of a ray; of equally near ones that of the lowest prim_id. A ray hits nothing if t_min > t_max,
/// or if it is out of limits: coordinates of the origin up to 2^42, and the largest of the direction from 2^-50 to 2^50.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_intersect(tree: Option<&hd_tree>, ray: *const hd_ray, hit: *mut hd_hit) -> hd_status {
    guard(|| {
        let tree = handle("tree", tree)?.view();
        // SAFETY: the caller's promise.
        let ray = checked(std::slice::from_ref(unsafe { element("ray", ray) }?))?[0];
        // SAFETY: the caller's promise.
        let hit = unsafe { room_for_one("hit", hit) }?;
        *hit = bytemuck::cast(tree.intersect(&ray).unwrap_or(Hit::MISS));
        Ok(())
    })
}

/// Finds out whether a ray hits anything.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_occluded(tree: Option<&hd_tree>, ray: *const hd_ray, occluded: *mut bool) -> hd_status {
    guard(|| {
        let tree = handle("tree", tree)?.view();
        // SAFETY: the caller's promise.
        let ray = checked(std::slice::from_ref(unsafe { element("ray", ray) }?))?[0];
        // SAFETY: the caller's promise.
        *unsafe { room_for_one("occluded", occluded) }? = tree.occluded(&ray);
        Ok(())
    })
}

/// hd_intersect for many rays: several times as quick as one by one. If a ray has a NaN none is traced.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_intersect_many(
    tree: Option<&hd_tree>,
    rays: *const hd_ray,
    hits: *mut hd_hit,
    count: usize,
) -> hd_status {
    guard(|| {
        let tree = handle("tree", tree)?.view();
        // SAFETY: the caller's promise.
        let rays = checked(unsafe { elements("rays", rays, count) }?)?;
        // SAFETY: the caller's promise.
        let hits = unsafe { room("hits", hits, count) }?;
        tree.intersect_many(rays, cast_slice_mut(hits));
        Ok(())
    })
}

/// hd_occluded for many rays, likewise.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_occluded_many(
    tree: Option<&hd_tree>,
    rays: *const hd_ray,
    occluded: *mut bool,
    count: usize,
) -> hd_status {
    guard(|| {
        let tree = handle("tree", tree)?.view();
        // SAFETY: the caller's promise.
        let rays = checked(unsafe { elements("rays", rays, count) }?)?;
        // SAFETY: the caller's promise.
        let occluded = unsafe { room("occluded", occluded, count) }?;
        tree.occluded_many(rays, occluded);
        Ok(())
    })
}

/// The instruction set that rays are traced with: "avx512", "avx2", "sse2", "portable" or "scalar". The environment
/// variable HALFDOME_ISA can name a lesser one. Hits are the same with all.
#[unsafe(no_mangle)]
pub extern "C" fn hd_instruction_set() -> *const c_char {
    let name: &CStr = match Isa::detect().level().name() {
        "avx512" => c"avx512",
        "avx2" => c"avx2",
        "sse2" => c"sse2",
        "scalar" => c"scalar",
        _ => c"portable",
    };
    name.as_ptr()
}
