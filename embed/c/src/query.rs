//! Queries of rays beside the nearest hit: filters, and the nearest few hits.

use std::ffi::c_void;

use bytemuck::{Pod, cast, cast_slice_mut};
use halfdome_kernel::Verdict;

use crate::border::{check, handle, room, room_for_one};
use crate::scene::{hd_scene, hd_scene_hit, hd_scene_ray};
use crate::status::hd_status::*;
use crate::status::{Failure, guard, hd_status};
use crate::trace::{Filter, Traceable, hd_hit, hd_ray, rays};
use crate::tree::hd_tree;

/// A filter's verdict: the hit does not count, and the ray goes on.
pub const HD_REJECT: u32 = 0;
/// The hit counts.
pub const HD_ACCEPT: u32 = 1;
/// The hit counts, and the search ends with it, whether there are nearer ones or not.
pub const HD_STOP: u32 = 2;

/// Judges a hit: HD_REJECT, HD_ACCEPT or HD_STOP. user is what was given with it. It must return, by no exception and
/// no longjmp; it may trace other rays.
pub type hd_filter = Option<unsafe extern "C" fn(user: *mut c_void, hit: *const hd_hit) -> u32>;

/// hd_filter for the hits of a scene.
pub type hd_scene_filter = Option<unsafe extern "C" fn(user: *mut c_void, hit: *const hd_scene_hit) -> u32>;

/// The one ray that is behind a pointer.
///
/// # Safety
/// That of [`elements`].
unsafe fn one_ray<'a, T: Traceable>(ray: *const T::Ray) -> Result<&'a T::KernelRay, Failure> {
    check("ray", ray, 1)?;
    // SAFETY: the caller's promise.
    unsafe { rays::<T>("ray", ray, 1) }.map(|rays| &rays[0])
}

/// Runs a search with what judges hits in C.
///
/// # Safety
/// The filter can be called with `user` and any hit.
unsafe fn judged<H: Pod, K: Pod, R>(
    filter: Option<unsafe extern "C" fn(*mut c_void, *const H) -> u32>,
    user: *mut c_void,
    search: impl FnOnce(&mut Filter<K>) -> R,
) -> Result<R, Failure> {
    let Some(filter) = filter else {
        return Err(Failure::new(HD_ERROR_NULL, "filter is NULL"));
    };
    let mut unknown = None;
    let mut judge = |hit: &K| {
        let hit: H = cast(*hit);
        // SAFETY: the caller's promise.
        match unsafe { filter(user, &raw const hit) } {
            HD_REJECT => Verdict::Reject,
            HD_ACCEPT => Verdict::Accept,
            HD_STOP => Verdict::Stop,
            other => {
                unknown = Some(other);
                Verdict::Stop
            }
        }
    };
    let found = search(&mut judge);
    match unknown {
        Some(verdict) => {
            let message = format!("the filter gave {verdict}: it must be HD_REJECT, HD_ACCEPT or HD_STOP, 0 to 2");
            Err(Failure::new(HD_ERROR_VALUE, message))
        }
        None => Ok(found),
    }
}

/// # Safety
/// That of [`one_ray`], [`room`] and [`judged`].
unsafe fn filtered<T: Traceable>(
    traced: Option<&T>,
    ray: *const T::Ray,
    filter: Option<unsafe extern "C" fn(*mut c_void, *const T::Hit) -> u32>,
    user: *mut c_void,
    hit: *mut T::Hit,
) -> hd_status {
    guard(|| {
        let traced = handle(T::NAME, traced)?;
        check("hit", hit, 1)?;
        // SAFETY: the caller's promise.
        unsafe {
            let ray = one_ray::<T>(ray)?;
            let found = judged(filter, user, |filter| traced.filtered(ray, filter))?;
            *room_for_one("hit", hit)? = cast(found.unwrap_or(T::MISS));
        }
        Ok(())
    })
}

/// # Safety
/// That of [`one_ray`], [`room`] and [`judged`].
unsafe fn any_filtered<T: Traceable>(
    traced: Option<&T>,
    ray: *const T::Ray,
    filter: Option<unsafe extern "C" fn(*mut c_void, *const T::Hit) -> u32>,
    user: *mut c_void,
    occluded: *mut bool,
) -> hd_status {
    guard(|| {
        let traced = handle(T::NAME, traced)?;
        check("occluded", occluded, 1)?;
        // SAFETY: the caller's promise.
        unsafe {
            let ray = one_ray::<T>(ray)?;
            let found = judged(filter, user, |filter| traced.occluded_filtered(ray, filter))?;
            *room_for_one("occluded", occluded)? = found;
        }
        Ok(())
    })
}

/// # Safety
/// That of [`one_ray`] and [`room`].
unsafe fn nearest<T: Traceable>(
    traced: Option<&T>,
    ray: *const T::Ray,
    hits: *mut T::Hit,
    capacity: usize,
    count: *mut usize,
) -> hd_status {
    guard(|| {
        let traced = handle(T::NAME, traced)?;
        check("count", count, 1)?;
        // SAFETY: the caller's promise.
        unsafe {
            let ray = one_ray::<T>(ray)?;
            let hits = room("hits", hits, capacity)?;
            *room_for_one("count", count)? = match capacity {
                0 => traced.count_hits(ray),
                _ => traced.nearest_hits(ray, cast_slice_mut(hits)),
            };
        }
        Ok(())
    })
}

/// Finds the nearest hit of a ray that a filter accepts, or the one that it stops at. The filter sees the hits that are
/// nearer than what it accepted so far, each once, roughly from near to far.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_intersect_filtered(
    tree: Option<&hd_tree>,
    ray: *const hd_ray,
    filter: hd_filter,
    user: *mut c_void,
    hit: *mut hd_hit,
) -> hd_status {
    // SAFETY: the caller's promise.
    unsafe { filtered(tree, ray, filter, user, hit) }
}

/// Finds out whether a ray hits anything that a filter accepts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_occluded_filtered(
    tree: Option<&hd_tree>,
    ray: *const hd_ray,
    filter: hd_filter,
    user: *mut c_void,
    occluded: *mut bool,
) -> hd_status {
    // SAFETY: the caller's promise.
    unsafe { any_filtered(tree, ray, filter, user, occluded) }
}

/// Writes the nearest hits of a ray, nearest first: as many as there are and as hits has room for, and their number to
/// *count. With a capacity of 0, *count is the number of all hits.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_nearest_hits(
    tree: Option<&hd_tree>,
    ray: *const hd_ray,
    hits: *mut hd_hit,
    capacity: usize,
    count: *mut usize,
) -> hd_status {
    // SAFETY: the caller's promise.
    unsafe { nearest(tree, ray, hits, capacity, count) }
}

/// hd_intersect_filtered for a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_intersect_filtered(
    scene: Option<&hd_scene>,
    ray: *const hd_scene_ray,
    filter: hd_scene_filter,
    user: *mut c_void,
    hit: *mut hd_scene_hit,
) -> hd_status {
    // SAFETY: the caller's promise.
    unsafe { filtered(scene, ray, filter, user, hit) }
}

/// hd_occluded_filtered for a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_occluded_filtered(
    scene: Option<&hd_scene>,
    ray: *const hd_scene_ray,
    filter: hd_scene_filter,
    user: *mut c_void,
    occluded: *mut bool,
) -> hd_status {
    // SAFETY: the caller's promise.
    unsafe { any_filtered(scene, ray, filter, user, occluded) }
}

/// hd_nearest_hits for a scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_nearest_hits(
    scene: Option<&hd_scene>,
    ray: *const hd_scene_ray,
    hits: *mut hd_scene_hit,
    capacity: usize,
    count: *mut usize,
) -> hd_status {
    // SAFETY: the caller's promise.
    unsafe { nearest(scene, ray, hits, capacity, count) }
}
