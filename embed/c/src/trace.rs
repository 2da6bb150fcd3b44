//! Rays through trees: one, or many at a time; and what scenes share of it.

use std::ffi::{CStr, c_char};

use bytemuck::{Pod, Zeroable, cast_slice, cast_slice_mut};
use halfdome_kernel::{Hit, Isa, Ray, Verdict};

use crate::border::{elements, handle, room};
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
    /// The triangle's index in its mesh; HD_NO_PRIM if nothing was hit.
    pub prim_id: u32,
}

/// The prim_id of a ray that hits nothing.
pub const HD_NO_PRIM: u32 = 0xFFFF_FFFF;

const _: () = assert!(HD_NO_PRIM == Hit::NO_PRIM);

/// What can be traced. C's rays and hits lie in memory as the kernel's do.
pub(crate) trait Traceable {
    /// What it is called where it is an argument.
    const NAME: &'static str;
    /// The number of floats that a ray begins with.
    const FLOATS: usize;
    type Ray: Pod;
    type Hit: Pod;
    type KernelRay: Pod;
    type KernelHit: Pod;
    /// What is written for a ray that hits nothing.
    const MISS: Self::KernelHit;

    fn intersect_many(&self, rays: &[Self::KernelRay], hits: &mut [Self::KernelHit]);
    fn occluded_many(&self, rays: &[Self::KernelRay], occluded: &mut [bool]);
    fn filtered(&self, ray: &Self::KernelRay, filter: &mut Filter<Self::KernelHit>) -> Option<Self::KernelHit>;
    fn occluded_filtered(&self, ray: &Self::KernelRay, filter: &mut Filter<Self::KernelHit>) -> bool;
    fn nearest_hits(&self, ray: &Self::KernelRay, hits: &mut [Self::KernelHit]) -> usize;
    fn count_hits(&self, ray: &Self::KernelRay) -> usize;
}

/// What judges hits.
pub(crate) type Filter<'a, H> = dyn FnMut(&H) -> Verdict + 'a;

impl Traceable for hd_tree {
    const NAME: &'static str = "tree";
    const FLOATS: usize = 8;
    type Ray = hd_ray;
    type Hit = hd_hit;
    type KernelRay = Ray;
    type KernelHit = Hit;
    const MISS: Hit = Hit::MISS;

    fn intersect_many(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.view().intersect_many(rays, hits);
    }
    fn occluded_many(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.view().occluded_many(rays, occluded);
    }
    fn filtered(&self, ray: &Ray, filter: &mut Filter<Hit>) -> Option<Hit> {
        self.view().intersect_filtered(ray, filter)
    }
    fn occluded_filtered(&self, ray: &Ray, filter: &mut Filter<Hit>) -> bool {
        self.view().occluded_filtered(ray, filter)
    }
    fn nearest_hits(&self, ray: &Ray, hits: &mut [Hit]) -> usize {
        self.view().nearest_hits(ray, hits)
    }
    fn count_hits(&self, ray: &Ray) -> usize {
        self.view().count_hits(ray)
    }
}

/// The rays, as the kernel has them, if they are numbers.
///
/// # Safety
/// That of [`elements`].
pub(crate) unsafe fn rays<'a, T: Traceable>(
    name: &str,
    rays: *const T::Ray,
    count: usize,
) -> Result<&'a [T::KernelRay], Failure> {
    // SAFETY: the caller's promise.
    let rays: &[T::Ray] = unsafe { elements(name, rays, count) }?;
    let is_nan = |ray: &T::Ray| {
        let floats: &[f32] = cast_slice(std::slice::from_ref(ray));
        floats[..T::FLOATS].iter().any(|float| float.is_nan())
    };
    match rays.iter().position(is_nan) {
        Some(number) => Err(Failure::new(HD_ERROR_VALUE, format!("ray {number} has a NaN"))),
        None => Ok(cast_slice(rays)),
    }
}

/// The nearest hits of rays, whose arguments have these names.
///
/// # Safety
/// That of [`elements`] and [`room`].
pub(crate) unsafe fn closest<T: Traceable>(
    traced: Option<&T>,
    [rays_name, hits_name]: [&str; 2],
    from: *const T::Ray,
    to: *mut T::Hit,
    count: usize,
) -> hd_status {
    guard(|| {
        let traced = handle(T::NAME, traced)?;
        // SAFETY: the caller's promise.
        let (rays, hits) = unsafe { (rays::<T>(rays_name, from, count)?, room(hits_name, to, count)?) };
        traced.intersect_many(rays, cast_slice_mut(hits));
        Ok(())
    })
}

/// Whether rays hit anything.
///
/// # Safety
/// That of [`elements`] and [`room`].
pub(crate) unsafe fn any<T: Traceable>(
    traced: Option<&T>,
    [rays_name, occluded_name]: [&str; 2],
    from: *const T::Ray,
    to: *mut bool,
    count: usize,
) -> hd_status {
    guard(|| {
        let traced = handle(T::NAME, traced)?;
        // SAFETY: the caller's promise.
        let (rays, occluded) = unsafe { (rays::<T>(rays_name, from, count)?, room(occluded_name, to, count)?) };
        traced.occluded_many(rays, occluded);
        Ok(())
    })
}

/// Finds the nearest hit of a ray; of equally near ones that of the lowest prim_id. A ray hits nothing if t_min >
/// t_max, or if it is out of limits: coordinates of the origin up to 2^42, and the largest of the direction from 2^-50
/// to 2^50.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_intersect(tree: Option<&hd_tree>, ray: *const hd_ray, hit: *mut hd_hit) -> hd_status {
    // SAFETY: the caller's promise.
    unsafe { closest(tree, ["ray", "hit"], ray, hit, 1) }
}

/// Finds out whether a ray hits anything.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_occluded(tree: Option<&hd_tree>, ray: *const hd_ray, occluded: *mut bool) -> hd_status {
    // SAFETY: the caller's promise.
    unsafe { any(tree, ["ray", "occluded"], ray, occluded, 1) }
}

/// hd_intersect for count rays: several times as quick as one by one. If a ray has a NaN none is traced.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_intersect_many(
    tree: Option<&hd_tree>,
    rays: *const hd_ray,
    hits: *mut hd_hit,
    count: usize,
) -> hd_status {
    // SAFETY: the caller's promise.
    unsafe { closest(tree, ["rays", "hits"], rays, hits, count) }
}

/// hd_occluded for count rays, likewise.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_occluded_many(
    tree: Option<&hd_tree>,
    rays: *const hd_ray,
    occluded: *mut bool,
    count: usize,
) -> hd_status {
    // SAFETY: the caller's promise.
    unsafe { any(tree, ["rays", "occluded"], rays, occluded, count) }
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
