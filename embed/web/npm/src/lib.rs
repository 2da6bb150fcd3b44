//! The kernel behind functions that JavaScript calls: `index.js`, beside, is their only caller.
//!
//! An instance holds one tree. JavaScript asks for room, writes there what the next function reads, and reads where that
//! says; no function keeps an address. Numbers that would be wrong are refused on the JavaScript side, which knows how to
//! say so; here they lead to no more than a tree that is not built. So this border needs no unsafe code but the names of
//! its functions.

use std::cell::RefCell;

use glam::Vec3;
use halfdome_kernel::{BuildOptions, Bvh, Hit, Quality, Ray, Triangle};

/// All that an instance has.
#[derive(Default)]
struct State {
    positions: Vec<f32>,
    indices: Vec<u32>,
    bvh: Option<Bvh>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    occluded: Vec<bool>,
    /// What the last batch gave, as JavaScript reads it.
    answer: Vec<u32>,
}

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

/// A ray of which nothing is known yet.
const NO_RAY: Ray = Ray { origin: Vec3::ZERO, t_min: 0.0, direction: Vec3::ZERO, t_max: 0.0 };

/// Room for `count` coordinates of vertices: its address, or 0 if there is no memory left.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn positions(count: usize) -> *mut f32 {
    STATE.with_borrow_mut(|state| room(&mut state.positions, count, 0.0))
}

/// Room for `count` numbers of vertices, three for each triangle: its address, or 0.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn indices(count: usize) -> *mut u32 {
    STATE.with_borrow_mut(|state| room(&mut state.indices, count, 0))
}

/// Room for `count` rays of 32 bytes (origin, least `t`, direction, greatest `t`): its address, or 0.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn rays(count: usize) -> *mut Ray {
    STATE.with_borrow_mut(|state| room(&mut state.rays, count, NO_RAY))
}

/// Builds the tree with the quality of this number (0 fast, 1 medium, 2 high) from the positions and, unless there are
/// none, indices, which it forgets. Gives the number of triangles in it, or -1 if it refuses them.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn build(quality: usize) -> i32 {
    STATE
        .with_borrow_mut(|state| {
            let (positions, indices) = (std::mem::take(&mut state.positions), std::mem::take(&mut state.indices));
            let triangles = triangles(&positions, &indices)?;
            let options = BuildOptions::from(*Quality::ALL.get(quality)?);
            let (bvh, report) = Bvh::build(&triangles, &options).ok()?;
            state.bvh = Some(bvh);
            i32::try_from(report.kept).ok()
        })
        .unwrap_or(-1)
}

/// Traces `count` of the rays to their nearest hits. Gives the address of all `t`, then all `u`, all `v`, and all numbers
/// of triangles, -1 for none.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn closest(count: usize) -> *const u32 {
    STATE.with_borrow_mut(|State { bvh, rays, hits, answer, .. }| {
        let rays = &rays[..count.min(rays.len())];
        hits.clear();
        hits.resize(rays.len(), Hit::MISS);
        if let Some(bvh) = bvh {
            bvh.view().intersect_many(rays, hits);
        }
        answer.clear();
        answer.extend(hits.iter().map(|hit| hit.t.to_bits()));
        answer.extend(hits.iter().map(|hit| hit.u.to_bits()));
        answer.extend(hits.iter().map(|hit| hit.v.to_bits()));
        answer.extend(hits.iter().map(|hit| hit.prim_id));
        answer.as_ptr()
    })
}

/// Traces `count` of the rays until they hit anything. Gives the address of a byte for each: 1 if it does, else 0.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn any(count: usize) -> *const bool {
    STATE.with_borrow_mut(|State { bvh, rays, occluded, .. }| {
        let rays = &rays[..count.min(rays.len())];
        occluded.clear();
        occluded.resize(rays.len(), false);
        if let Some(bvh) = bvh {
            bvh.view().occluded_many(rays, occluded);
        }
        occluded.as_ptr()
    })
}

/// The bytes that the tree takes.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn bytes() -> usize {
    STATE.with_borrow(|state| state.bvh.as_ref().map_or(0, |bvh| bvh.statistics().bytes))
}

/// Makes `list` as long as asked for: its address, or null if there is no memory left.
fn room<T: Clone>(list: &mut Vec<T>, count: usize, value: T) -> *mut T {
    list.clear();
    if list.try_reserve_exact(count).is_err() {
        return std::ptr::null_mut();
    }
    list.resize(count, value);
    list.as_mut_ptr()
}

/// The triangles of a mesh; of consecutive vertices if it has no indices. `None` if one has a vertex that does not exist.
fn triangles(positions: &[f32], indices: &[u32]) -> Option<Vec<Triangle>> {
    let vertices: Vec<Vec3> = positions.as_chunks().0.iter().map(|&vertex| Vec3::from_array(vertex)).collect();
    if indices.is_empty() {
        return Some(vertices.as_chunks().0.to_vec());
    }
    let vertex = |index: u32| vertices.get(index as usize).copied();
    let corners = indices.as_chunks().0.iter();
    corners.map(|&[a, b, c]| Some([vertex(a)?, vertex(b)?, vertex(c)?])).collect()
}
