//! The kernel behind functions that JavaScript calls: `index.js`, beside, is their only caller.
//!
//! An instance holds meshes, and with the feature `scene` a scene of them. JavaScript requests memory, writes the next
//! function's input there, and reads its output at the returned address; no function keeps an address. Invalid numbers
//! are refused on the JavaScript side, with errors; here they only lead to a failed build. So this border needs no
//! unsafe code but the names of its functions.

mod answer;
#[cfg(feature = "scene")]
pub mod scene;
mod tree;

use std::cell::RefCell;
use std::sync::Arc;

use glam::Vec3;
use halfdome_kernel::mesh::{IndexedMesh, Indices, Positions};
use halfdome_kernel::{BuildOptions, Bvh, Hit, Quality, Ray};

use answer::Answer;
use tree::Tree;

/// All that an instance has, but for its scene.
#[derive(Default)]
struct State {
    positions: Vec<f32>,
    /// `None`: every three vertices are a triangle. An empty list is none at all.
    indices: Option<Vec<u32>>,
    rays: Vec<Ray>,
    /// Coordinates, and how far to look.
    points: Vec<[f32; 4]>,
    /// By their indices, which are used again.
    meshes: Vec<Option<Tree>>,
    /// Numbers that no mesh has.
    free: Vec<usize>,
    answer: Answer,
}

impl State {
    /// Adds a mesh: its index.
    fn add(&mut self, tree: Tree) -> i32 {
        let number = self.free.pop().unwrap_or_else(|| {
            self.meshes.push(None);
            self.meshes.len() - 1
        });
        self.meshes[number] = Some(tree);
        number as i32
    }

    fn tree(&self, mesh: usize) -> Option<&Tree> {
        self.meshes.get(mesh)?.as_ref()
    }

    fn rays(&self, count: usize) -> &[Ray] {
        &self.rays[..count.min(self.rays.len())]
    }

    /// The tree over a mesh that keeps its shape.
    fn still(&self, mesh: usize) -> Option<&Bvh> {
        self.tree(mesh).and_then(Tree::still)
    }

    fn points(&self, count: usize) -> &[[f32; 4]] {
        &self.points[..count.min(self.points.len())]
    }
}

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

/// A ray of which nothing is known yet.
const NO_RAY: Ray = Ray { origin: Vec3::ZERO, t_min: 0.0, direction: Vec3::ZERO, t_max: 0.0 };

/// Room for `count` coordinates of vertices: its address, or 0 if there is no memory left. Forgets the indices.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn positions(count: usize) -> *mut f32 {
    STATE.with_borrow_mut(|state| {
        state.indices = None;
        room(&mut state.positions, count, 0.0)
    })
}

/// Room for `count` numbers of vertices, three for each triangle: its address, or 0. After the positions; a mesh that
/// has no indices does not ask.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn indices(count: usize) -> *mut u32 {
    STATE.with_borrow_mut(|state| room(state.indices.get_or_insert_default(), count, 0))
}

/// Room for `count` rays of 32 bytes (origin, least `t`, direction, greatest `t`): its address, or 0.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn rays(count: usize) -> *mut Ray {
    STATE.with_borrow_mut(|state| room(&mut state.rays, count, NO_RAY))
}

/// Room for `count` points of 16 bytes (coordinates, and how far to look): its address, or 0.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn points(count: usize) -> *mut [f32; 4] {
    STATE.with_borrow_mut(|state| room(&mut state.points, count, [0.0; 4]))
}

/// Whether there is memory for so many pieces of 64 KiB: 1 or 0. Where a build runs out of it, the instance is lost.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn has_room(pieces: usize) -> u32 {
    // Memory that has gaps need not have it in one.
    const PIECE: usize = 1 << 16;
    const MAX_PIECES: usize = 1 << 10;
    let mut held: Vec<Vec<u8>> = Vec::new();
    let lengths = (0..pieces).step_by(MAX_PIECES).map(|first| PIECE * MAX_PIECES.min(pieces - first));
    for length in lengths {
        let mut part = Vec::new();
        if part.try_reserve_exact(length).is_err() || held.try_reserve(1).is_err() {
            return 0;
        }
        held.push(part);
    }
    1
}

/// 1 if this is the build with SIMD, else 0.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn simd() -> u32 {
    cfg!(target_feature = "simd128").into()
}

/// Builds a tree with this quality (0 fast, 1 medium, 2 high) from the positions and, if it was given any, the
/// indices, which it forgets. Gives the mesh's index, or -1 if it refuses them.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn add_mesh(quality: usize) -> i32 {
    STATE
        .with_borrow_mut(|state| {
            let (positions, indices) = (std::mem::take(&mut state.positions), std::mem::take(&mut state.indices));
            let options = BuildOptions::from(*Quality::ALL.get(quality)?);
            let (bvh, _) = Bvh::build_mesh(&mesh(&positions, indices.as_deref())?, &options).ok()?;
            Some(state.add(Tree::Still(Arc::new(bvh))))
        })
        .unwrap_or(-1)
}

/// Moves a mesh to the positions and indices, which it forgets. Gives the cost of rays as a multiple of what it was
/// when the tree was built; -1 if the triangles are not those of the tree, or if it is one that changes its shape.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn refit(number: usize) -> f32 {
    STATE
        .with_borrow_mut(|state| {
            let (positions, indices) = (std::mem::take(&mut state.positions), std::mem::take(&mut state.indices));
            // A scene that has the tree keeps it as it is.
            let bvh = Arc::make_mut(state.meshes.get_mut(number)?.as_mut()?.still_mut()?);
            Some(bvh.refit_mesh(&mesh(&positions, indices.as_deref())?).ok()?.cost_ratio)
        })
        .unwrap_or(-1.0)
}

/// Frees a mesh, whose index the next one gets; a scene's items that have it keep it. 0, or -1 if there is no such.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn free_mesh(mesh: usize) -> i32 {
    STATE.with_borrow_mut(|state| match state.meshes.get_mut(mesh).and_then(Option::take) {
        Some(_) => {
            state.free.push(mesh);
            0
        }
        None => -1,
    })
}

/// How many triangles a mesh has that can be hit.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn triangles(mesh: usize) -> usize {
    STATE.with_borrow(|state| state.tree(mesh).map_or(0, Tree::triangles))
}

/// The bytes that a mesh takes.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn bytes(mesh: usize) -> usize {
    STATE.with_borrow(|state| state.tree(mesh).map_or(0, Tree::bytes))
}

/// Traces `count` of the rays to their nearest hits with a mesh; see `Answer` for what is at the address.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn closest(mesh: usize, count: usize) -> *const u32 {
    STATE.with_borrow_mut(|state| {
        let mut hits = vec![Hit::MISS; count.min(state.rays.len())];
        if let Some(bvh) = state.still(mesh) {
            bvh.view().intersect_many(state.rays(count), &mut hits);
        }
        state.answer.clear();
        state.answer.push_hits(hits.iter());
        state.answer.address()
    })
}

/// Traces `count` of the rays until they hit anything of a mesh. Gives the address of a byte for each: 1 if it does,
/// else 0.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn any(mesh: usize, count: usize) -> *const u32 {
    STATE.with_borrow_mut(|state| {
        let mut occluded = vec![false; count.min(state.rays.len())];
        if let Some(bvh) = state.still(mesh) {
            bvh.view().occluded_many(state.rays(count), &mut occluded);
        }
        state.answer.clear();
        state.answer.push_bytes(&occluded);
        state.answer.address()
    })
}

/// Finds the nearest `most` hits of `count` of the rays with a mesh. Gives the address of how many hits there are up to
/// the end of each ray's, and behind that of what `Answer` says.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn all_hits(mesh: usize, count: usize, most: usize) -> *const u32 {
    STATE.with_borrow_mut(|state| {
        let (mut hits, mut ends) = (Vec::new(), Vec::new());
        for ray in state.rays(count) {
            if let Some(bvh) = state.still(mesh) {
                hits.extend(bvh.view().hits(ray).take(most));
            }
            ends.push(hits.len() as u32);
        }
        state.answer.clear();
        state.answer.push_words(ends);
        state.answer.push_hits(hits.iter());
        state.answer.address()
    })
}

/// Finds what of a mesh is closest to `count` of the points. Gives the address of what `Answer` says, with distances
/// for `t`, and behind that three coordinates for each.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn closest_points(mesh: usize, count: usize) -> *const u32 {
    STATE.with_borrow_mut(|state| {
        let bvh = state.still(mesh);
        let closest = |&[x, y, z, radius]: &[f32; 4]| {
            let found = bvh.and_then(|bvh| bvh.view().closest_point(Vec3::new(x, y, z), radius));
            found.map_or((Vec3::NAN, Hit::MISS), |found| (found.point, found.to_hit()))
        };
        let found: Vec<(Vec3, Hit)> = state.points(count).iter().map(closest).collect();
        state.answer.clear();
        state.answer.push_hits(found.iter().map(|(_, hit)| hit));
        state.answer.push_places(found.iter().map(|&(place, _)| place));
        state.answer.address()
    })
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

/// A mesh of consecutive vertices if it has no indices. `None` if there is a vertex that does not exist.
fn mesh<'a>(positions: &'a [f32], indices: Option<&'a [u32]>) -> Option<IndexedMesh<'a>> {
    let positions = Positions::from(positions.as_chunks::<3>().0);
    IndexedMesh::new(positions, indices.map_or(Indices::InOrder, Indices::U32)).ok()
}
