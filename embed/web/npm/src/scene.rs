//! A scene of the instance's meshes: items are inserted, moved and removed.

use std::cell::RefCell;
use std::sync::Arc;

use glam::{Affine3A, Mat4, Vec3};
use halfdome_kernel::bvh::{MovingBvh, RoundBuild};
use halfdome_kernel::mesh::Mesh;
use halfdome_kernel::scene::{Handle, Scene};
use halfdome_kernel::{
    BuildOptions, CubicCurve, Disc, Error, InvalidScene, Item, LinearCurve, Quality, RoundBvh, SceneHit, SceneRay,
    Sphere, Triangle,
};

use crate::answer::Answer;
use crate::tree::Tree;
use crate::{STATE, State, mesh, room};

#[derive(Default)]
struct Stage {
    /// Where the next item is: at times evenly spaced from 0 to 1, if there are several.
    matrices: Vec<[f32; 16]>,
    /// When each of the rays is; none if all are at 0.
    times: Vec<f32>,
    /// The triangles of the next mesh that changes its shape, at its keys.
    keys: Vec<Vec<Triangle>>,
    scene: Scene<'static>,
    /// The mesh of each item, by its index.
    meshes: Vec<usize>,
}

thread_local! {
    static STAGE: RefCell<Stage> =
        RefCell::new(Stage { scene: Scene::new(Quality::Fast.into()), ..Stage::default() });
}

/// Room for `count` matrices of 16 numbers, column by column: its address, or 0 if there is no memory left.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn matrices(count: usize) -> *mut [f32; 16] {
    STAGE.with_borrow_mut(|stage| room(&mut stage.matrices, count, [0.0; 16]))
}

/// Room for the times of `count` rays: its address, or 0. With room for none all rays are at time 0.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn times(count: usize) -> *mut f32 {
    STAGE.with_borrow_mut(|stage| room(&mut stage.times, count, 0.0))
}

/// Forgets keys of a mesh that was not built, as there was no memory for all.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn forget_keys() {
    STAGE.with_borrow_mut(|stage| stage.keys.clear());
}

/// Adds a key to the next mesh that changes its shape, from the positions and indices, which it forgets. 0, or -1 if it
/// refuses them.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn add_key() -> i32 {
    with_both(|stage, state| {
        let (positions, indices) = (std::mem::take(&mut state.positions), std::mem::take(&mut state.indices));
        let mesh = mesh(&positions, indices.as_deref())?;
        stage.keys.push((0..mesh.len()).map(|number| mesh.triangle(number)).collect());
        Some(0)
    })
    .unwrap_or(-1)
}

/// Builds a tree over the keys, which it forgets, as `add_mesh` does.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn add_moving_mesh(quality: usize) -> i32 {
    with_both(|stage, state| {
        let keys = std::mem::take(&mut stage.keys);
        let keys: Vec<&[Triangle]> = keys.iter().map(Vec::as_slice).collect();
        let options = BuildOptions::from(*Quality::ALL.get(quality)?);
        let (bvh, _) = MovingBvh::build(&keys, &options).ok()?;
        Some(state.add(Tree::Moving(Arc::new(bvh))))
    })
    .unwrap_or(-1)
}

/// Builds a tree over points or curves of this kind (0 spheres, 1 discs, 2 linear curves, 3 cubic curves), whose
/// numbers are the positions, which it forgets. The number of what it adds, or -1 if it refuses them.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn add_round(kind: usize, quality: usize) -> i32 {
    STATE
        .with_borrow_mut(|state| {
            let numbers = std::mem::take(&mut state.positions);
            let options = BuildOptions::from(*Quality::ALL.get(quality)?);
            let tree = match kind {
                0 => round::<Sphere>(&numbers, &options),
                1 => round::<Disc>(&numbers, &options),
                2 => round::<LinearCurve>(&numbers, &options),
                3 => round::<CubicCurve>(&numbers, &options),
                _ => None,
            };
            Some(state.add(tree?))
        })
        .unwrap_or(-1)
}

fn round<P: RoundBuild>(numbers: &[f32], options: &BuildOptions) -> Option<Tree> {
    let primitives: &[P] = bytemuck::try_cast_slice(numbers).ok()?;
    let (bvh, report) = RoundBvh::build(primitives, options).ok()?;
    Some(Tree::Round(Arc::new(bvh), report.kept))
}

/// Adds an item where the matrices take a mesh: its index; -1 if there is no such mesh, or there are too many items;
/// and less if a matrix is refused, see [`placed`].
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn insert(mesh: usize, mask: u32) -> i32 {
    with_both(|Stage { matrices, scene, meshes, .. }, state| {
        let tree = state.tree(mesh).ok_or(-1)?;
        let item = placed(Item::new(tree.object()).with_mask(mask), matrices)?;
        let index = scene.insert(item).map_err(|_| -1)?.index();
        let place = index as usize;
        meshes.resize(meshes.len().max(place + 1), usize::MAX);
        meshes[place] = mesh;
        i32::try_from(index).map_err(|_| -1)
    })
    .unwrap_or_else(|refused| refused)
}

/// Gives all items that have a mesh the mesh as it is now.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn follow(mesh: usize) {
    with_both(|Stage { scene, meshes, .. }, state| {
        let items = (0..).zip(meshes.iter()).filter(|&(_, own)| *own == mesh);
        for handle in items.filter_map(|(index, _)| scene.handle(index)).collect::<Vec<Handle>>() {
            scene.set_object(handle, state.tree(mesh)?.object()).ok()?;
        }
        Some(())
    });
}

/// Puts an item where the matrices take its mesh. 0; -1 if there is no such item; and less if a matrix is refused, see
/// [`placed`].
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn set_transform(item: u32) -> i32 {
    STAGE
        .with_borrow_mut(|Stage { matrices, scene, .. }| {
            let handle = scene.handle(item).ok_or(-1)?;
            // Nearly all calls are this one, for which nothing is allocated. Invalid calls are refused again below,
            // with the reason.
            if let [only] = matrices[..]
                && scene.set_transform(handle, &transform(&only)).is_ok()
            {
                return Ok(());
            }
            let old = scene.get(handle).ok_or(-1)?;
            let item = placed(Item::new(old.object().clone()).with_mask(old.mask()), matrices)?;
            scene.set_item(handle, item).map_err(|_| -1)
        })
        .map_or_else(|refused| refused, |()| 0)
}

/// Sets an item's mask. Returns 0, or -1 if there is no such item.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn set_mask(item: u32, mask: u32) -> i32 {
    change(item, |stage, handle| stage.scene.set_mask(handle, mask).ok())
}

/// Exchanges an item's mesh. 0, or -1 if there is no such item or mesh.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn set_mesh(item: u32, mesh: usize) -> i32 {
    change(item, |Stage { scene, meshes, .. }, handle| {
        let object = STATE.with_borrow(|state| state.tree(mesh).map(Tree::object))?;
        scene.set_object(handle, object).ok()?;
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

/// Traces `count` of the rays to their nearest hits. Gives the address of what [`Answer`] says, and behind that of the
/// numbers of the items, -1 for none.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn scene_closest(count: usize, mask: u32) -> *const u32 {
    with_both(|stage, state| {
        let rays = stage.rays(state, count, mask);
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
        let rays = stage.rays(state, count, mask);
        let mut occluded = vec![false; rays.len()];
        stage.scene.view().occluded_many(&rays, &mut occluded);
        state.answer.clear();
        state.answer.push_bytes(&occluded);
        state.answer.address()
    })
}

/// Finds the nearest `most` hits of `count` of the rays. Gives the address of how many hits there are up to the end of
/// each ray's, and behind that what [`scene_closest`] gives.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn scene_all_hits(count: usize, most: usize, mask: u32) -> *const u32 {
    with_both(|stage, state| {
        let scene = stage.scene.view();
        let (mut hits, mut ends) = (Vec::new(), Vec::new());
        for ray in stage.rays(state, count, mask) {
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

/// Finds what is closest to `count` of the points at a time. Gives the address of what [`scene_closest`] gives, with
/// distances for `t`, and behind that three coordinates for each.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn scene_closest_points(count: usize, mask: u32, time: f32) -> *const u32 {
    with_both(|stage, state| {
        let scene = stage.scene.view();
        let closest = |&[x, y, z, radius]: &[f32; 4]| {
            let found = scene.closest_point(Vec3::new(x, y, z), radius, time, mask);
            found.map_or((Vec3::NAN, SceneHit::MISS), |found| (found.point.point, found.to_hit()))
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
    answer.push_words(hits.iter().map(|hit| hit.item));
}

impl Stage {
    fn rays(&self, state: &State, count: usize, mask: u32) -> Vec<SceneRay> {
        let times = self.times.iter().copied().chain(std::iter::repeat(0.0));
        let ray = |(&ray, time)| SceneRay::new(ray).with_mask(mask).at_time(time);
        state.rays(count).iter().zip(times).map(ray).collect()
    }
}

/// The item where the matrices take it. -1 if an element is not finite, -2 - 2k if matrix `k` has no useful inverse,
/// and one less if it loses it on the way to the next.
fn placed(item: Item<'static>, matrices: &[[f32; 16]]) -> Result<Item<'static>, i32> {
    let refused = |error| match error {
        Error::InvalidScene(InvalidScene::Singular { key }) => {
            let itself = |key: usize| {
                let alone = matrices.get(key).map(|matrix| Item::new(item.object().clone()).placed(&transform(matrix)));
                alone.is_some_and(|placed| placed.map_or(true, |item| item.is_flat()))
            };
            let (key, between) = match key {
                key if itself(key) => (key, 0),
                key if itself(key + 1) => (key + 1, 0),
                key => (key, 1),
            };
            -2 - 2 * key as i32 - between
        }
        _ => -1,
    };
    match matrices {
        [] => Ok(item),
        [only] => item.clone().placed(&transform(only)).map_err(refused),
        keys => item.clone().moving_shared(keys.iter().map(transform).collect()).map_err(refused),
    }
}

fn with_both<T>(work: impl FnOnce(&mut Stage, &mut State) -> T) -> T {
    STAGE.with_borrow_mut(|stage| STATE.with_borrow_mut(|state| work(stage, state)))
}

/// Changes the item of this index.
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
