//! Questions beside the nearest hit: filters, all hits, the closest point, overlaps.

use std::ffi::c_void;
use std::ops::ControlFlow;

use bytemuck::{Pod, Zeroable, cast, cast_slice_mut};
use glam::Vec3;
use halfdome_kernel::{Aabb, Hit, SceneHit, Verdict};

use crate::border::{check, elements, handle, room, room_for_one};
use crate::scene::{hd_scene, hd_scene_hit, hd_scene_ray, mask_of};
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

/// A point of which all coordinates are numbers.
///
/// # Safety
/// That of [`elements`].
unsafe fn point(name: &str, numbers: *const f32) -> Result<Vec3, Failure> {
    // SAFETY: the caller's promise.
    let point = Vec3::from_slice(unsafe { elements(name, numbers, 3) }?);
    if point.is_nan() { Err(Failure::new(HD_ERROR_VALUE, format!("{name} has a NaN"))) } else { Ok(point) }
}

fn check_radius(radius: f32) -> Result<(), Failure> {
    if radius >= 0.0 {
        return Ok(());
    }
    Err(Failure::new(HD_ERROR_VALUE, format!("radius is {radius}: it must be 0 or more, and may be infinite")))
}

fn check_time(time: f32) -> Result<(), Failure> {
    if time.is_nan() { Err(Failure::new(HD_ERROR_VALUE, "time is NaN")) } else { Ok(()) }
}

/// Finds the point of a tree's triangles that is closest to a point (three numbers) and not farther than radius, which
/// may be infinite. Writes its coordinates to the three numbers of closest, and to hit which triangle it is on, with
/// the distance as t; where there is none, HD_NO_PRIM, and closest is all 0. closest may be NULL. Of equally close
/// triangles the lowest counts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_closest_point(
    tree: Option<&hd_tree>,
    point: *const f32,
    radius: f32,
    closest: *mut f32,
    hit: *mut hd_hit,
) -> hd_status {
    guard(|| {
        let tree = handle("tree", tree)?;
        check_radius(radius)?;
        // SAFETY: the caller's promise.
        let from = unsafe { self::point("point", point) }?;
        let found = tree.view().closest_point(from, radius);
        let found = found.map_or((Vec3::ZERO, Hit::MISS), |found| (found.point, found.to_hit()));
        // SAFETY: the caller's promise.
        unsafe { write_closest(found, closest, hit) }
    })
}

/// hd_closest_point for a scene at a time (0 to 1) and for items whose mask has a bit in common with mask, of which 0
/// stands for all bits.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_closest_point(
    scene: Option<&hd_scene>,
    point: *const f32,
    radius: f32,
    time: f32,
    mask: u32,
    closest: *mut f32,
    hit: *mut hd_scene_hit,
) -> hd_status {
    guard(|| {
        let scene = handle("scene", scene)?;
        check_radius(radius)?;
        check_time(time)?;
        // SAFETY: the caller's promise.
        let from = unsafe { self::point("point", point) }?;
        let found = scene.0.view().closest_point(from, radius, time, mask_of(mask));
        let found = found.map_or((Vec3::ZERO, SceneHit::MISS), |found| (found.point.point, found.to_hit()));
        // SAFETY: the caller's promise.
        unsafe { write_closest(found, closest, hit) }
    })
}

/// # Safety
/// That of [`room`].
unsafe fn write_closest<H: Pod, K: Pod>((at, found): (Vec3, K), closest: *mut f32, hit: *mut H) -> Result<(), Failure> {
    check("hit", hit, 1)?;
    // SAFETY: the caller's promise.
    unsafe {
        if !closest.is_null() {
            room("closest", closest, 3)?.copy_from_slice(&at.to_array());
        }
        *room_for_one("hit", hit)? = cast(found);
    }
    Ok(())
}

/// Finds the triangles that have a point in common with a box, whose least and greatest corner are three numbers each,
/// and writes as many of their indices as prim_ids has room for, in an order that is the tree's own. *count is the
/// number of all of them, which may be more than capacity. Touching counts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_overlaps(
    tree: Option<&hd_tree>,
    min: *const f32,
    max: *const f32,
    prim_ids: *mut u32,
    capacity: usize,
    count: *mut usize,
) -> hd_status {
    guard(|| {
        let tree = handle("tree", tree)?;
        // SAFETY: the caller's promise.
        unsafe {
            let aabb = Aabb { min: point("min", min)?, max: point("max", max)? };
            let mut list = List::new("prim_ids", prim_ids, capacity, count)?;
            let _ = tree.view().for_each_overlap(&aabb, |prim_id| list.push(prim_id));
        }
        Ok(())
    })
}

/// hd_overlaps for a scene at a time (0 to 1) and for items whose mask has a bit in common with mask, of which 0 stands
/// for all bits. Hits have a t of 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_overlaps(
    scene: Option<&hd_scene>,
    min: *const f32,
    max: *const f32,
    time: f32,
    mask: u32,
    hits: *mut hd_scene_hit,
    capacity: usize,
    count: *mut usize,
) -> hd_status {
    guard(|| {
        let scene = handle("scene", scene)?;
        check_time(time)?;
        // SAFETY: the caller's promise.
        unsafe {
            let aabb = Aabb { min: point("min", min)?, max: point("max", max)? };
            let mut list = List::new("hits", hits, capacity, count)?;
            let visit = |hit: &SceneHit| list.push(cast(*hit));
            let _ = scene.0.view().for_each_overlap(&aabb, time, mask_of(mask), visit);
        }
        Ok(())
    })
}

/// Where the first of many answers are written, and all are counted.
struct List<'a, T> {
    room: &'a mut [T],
    count: &'a mut usize,
}

impl<T: Zeroable> List<'_, T> {
    /// # Safety
    /// That of [`room`], for as long as the list.
    unsafe fn new(name: &str, elements: *mut T, capacity: usize, count: *mut usize) -> Result<Self, Failure> {
        check("count", count, 1)?;
        // SAFETY: the caller's promise.
        unsafe { Ok(Self { room: room(name, elements, capacity)?, count: room_for_one("count", count)? }) }
    }

    fn push(&mut self, element: T) -> ControlFlow<()> {
        if let Some(place) = self.room.get_mut(*self.count) {
            *place = element;
        }
        *self.count += 1;
        ControlFlow::Continue(())
    }
}
