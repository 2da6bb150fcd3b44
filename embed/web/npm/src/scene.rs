//! A scene of the instance's meshes: items that come, move and go.

use std::cell::RefCell;

use glam::{Affine3A, Mat4, Vec3};
use halfdome_kernel::scene::{Handle, Scene};
use halfdome_kernel::{Item, Quality, SceneHit, SceneRay};

use crate::answer::Answer;
use crate::{STATE, State};

struct Stage {
    matrix: [f32; 16],
    scene: Scene<'static>,
    /// The mesh of each item, by its number.
    meshes: Vec<usize>,
}

thread_local! {
    static STAGE: RefCell<Stage> =
        RefCell::new(Stage { matrix: [0.0; 16], scene: Scene::new(Quality::Fast.into()), meshes: Vec::new() });
}

/// Room for a matrix of 16 numbers, column by column.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn matrix() -> *mut f32 {
    STAGE.with_borrow_mut(|stage| stage.matrix.as_mut_ptr())
}

/// Adds an item where the matrix takes a mesh: its number, or -1 if there is no such mesh or the matrix is refused.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn insert(mesh: usize, mask: u32) -> i32 {
    with_both(|Stage { matrix, scene, meshes }, state| {
        let item = Item::new(state.meshes.get(mesh)?.clone()).with_mask(mask).placed(&transform(matrix));
        let index = scene.insert(item.ok()?).index();
        let place = index as usize;
        meshes.resize(meshes.len().max(place + 1), usize::MAX);
        meshes[place] = mesh;
        i32::try_from(index).ok()
    })
    .unwrap_or(-1)
}

/// Gives all items that have a mesh the mesh as it is now.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn follow(mesh: usize) {
    with_both(|Stage { scene, meshes, .. }, state| {
        let items = (0..).zip(meshes.iter()).filter(|&(_, own)| *own == mesh);
        for handle in items.filter_map(|(index, _)| scene.handle(index)).collect::<Vec<Handle>>() {
            scene.set_object(handle, state.meshes.get(mesh)?.clone()).ok()?;
        }
        Some(())
    });
}

/// Puts an item where the matrix takes its mesh. 0, or -1 if that is refused.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn set_transform(item: u32) -> i32 {
    change(item, |Stage { matrix, scene, .. }, handle| scene.set_transform(handle, &transform(matrix)).ok())
}

/// Says who sees an item. 0, or -1 if there is no such.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn set_mask(item: u32, mask: u32) -> i32 {
    change(item, |stage, handle| stage.scene.set_mask(handle, mask).ok())
}

/// Exchanges an item's mesh. 0, or -1 if there is no such item or mesh.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn set_mesh(item: u32, mesh: usize) -> i32 {
    change(item, |Stage { scene, meshes, .. }, handle| {
        let bvh = STATE.with_borrow(|state| state.meshes.get(mesh).cloned())?;
        scene.set_object(handle, bvh).ok()?;
        *meshes.get_mut(item as usize)? = mesh;
        Some(())
    })
}

/// Removes an item. 0, or -1 if there is no such.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn remove(item: u32) -> i32 {
    change(item, |stage, handle| stage.scene.remove(handle).ok())
}

/// Makes all changes: the number of items that rays can see if their masks allow, or -1 if it cannot.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn commit() -> i32 {
    STAGE.with_borrow_mut(|stage| stage.scene.commit().map_or(-1, |commit| commit.seen as i32))
}

/// Traces `count` of the rays to their nearest hits. Gives the address of what [`Answer`] says, and behind that of the numbers
/// of the items, -1 for none.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn scene_closest(count: usize, mask: u32) -> *const u32 {
    with_both(|stage, state| {
        let rays = rays(state, count, mask);
        let mut hits = vec![SceneHit::MISS; rays.len()];
        stage.scene.view().intersect_many(&rays, &mut hits);
        state.answer.clear();
        push_hits(&mut state.answer, &hits);
        state.answer.address()
    })
}

/// Traces `count` of the rays until they hit anything. Gives the address of a byte for each: 1 if it does, else 0.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn scene_any(count: usize, mask: u32) -> *const u32 {
    with_both(|stage, state| {
        let rays = rays(state, count, mask);
        let mut occluded = vec![false; rays.len()];
        stage.scene.view().occluded_many(&rays, &mut occluded);
        state.answer.clear();
        state.answer.push_bytes(&occluded);
        state.answer.address()
    })
}

/// Finds the nearest `most` hits of `count` of the rays. Gives the address of how many hits there are up to the end of each
/// ray's, and behind that what [`scene_closest`] gives.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn scene_all_hits(count: usize, most: usize, mask: u32) -> *const u32 {
    with_both(|stage, state| {
        let scene = stage.scene.view();
        let (mut hits, mut ends) = (Vec::new(), Vec::new());
        for ray in rays(state, count, mask) {
            let first = hits.len();
            hits.resize(first + scene.count_hits(&ray).min(most), SceneHit::MISS);
            scene.nearest_hits(&ray, &mut hits[first..]);
            ends.push(hits.len() as u32);
        }
        state.answer.clear();
        state.answer.push_words(ends);
        push_hits(&mut state.answer, &hits);
        state.answer.address()
    })
}

/// Finds what is closest to `count` of the points. Gives the address of what [`scene_closest`] gives, with distances for `t`,
/// and behind that three coordinates for each.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn scene_closest_points(count: usize, mask: u32) -> *const u32 {
    with_both(|stage, state| {
        let scene = stage.scene.view();
        let closest = |&[x, y, z, radius]: &[f32; 4]| {
            scene.closest_point(Vec3::new(x, y, z), radius, 0.0, mask).unwrap_or((Vec3::NAN, SceneHit::MISS))
        };
        let (places, hits): (Vec<Vec3>, Vec<SceneHit>) = state.points(count).iter().map(closest).unzip();
        state.answer.clear();
        push_hits(&mut state.answer, &hits);
        state.answer.push_places(places.into_iter());
        state.answer.address()
    })
}

fn push_hits(answer: &mut Answer, hits: &[SceneHit]) {
    answer.push_hits(hits.iter().map(|hit| &hit.hit));
    answer.push_words(hits.iter().map(|hit| hit.geometry_id));
}

fn rays(state: &State, count: usize, mask: u32) -> Vec<SceneRay> {
    state.rays(count).iter().map(|&ray| SceneRay::new(ray).with_mask(mask)).collect()
}

fn with_both<T>(work: impl FnOnce(&mut Stage, &mut State) -> T) -> T {
    STAGE.with_borrow_mut(|stage| STATE.with_borrow_mut(|state| work(stage, state)))
}

/// Changes the item of this number.
fn change(item: u32, work: impl FnOnce(&mut Stage, Handle) -> Option<()>) -> i32 {
    let done = STAGE.with_borrow_mut(|stage| {
        let handle = stage.scene.handle(item)?;
        work(stage, handle)
    });
    if done.is_some() { 0 } else { -1 }
}

fn transform(matrix: &[f32; 16]) -> Affine3A {
    Affine3A::from_mat4(Mat4::from_cols_array(matrix))
}
