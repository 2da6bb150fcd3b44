//! Queries without rays: the closest point, and the triangles that overlap a box.

use std::ops::ControlFlow;

use bytemuck::{Pod, Zeroable, cast};
use glam::Vec3;
use halfdome_kernel::{Aabb, Hit, SceneHit};

use crate::border::{check, elements, handle, room, room_for_one};
use crate::scene::{hd_scene, hd_scene_hit, mask_of};
use crate::status::hd_status::*;
use crate::status::{Failure, guard, hd_status};
use crate::trace::hd_hit;
use crate::tree::hd_tree;

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
