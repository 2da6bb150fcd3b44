//! Scenes: trees and other scenes, each where a transform puts it, standing still or moving.
//!
//! A scene shares the memory of what is in it, so handles can be freed in any order.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Vec3};
use halfdome_kernel::scene::{Item, Object, Scene, SceneHit, SceneRay};

use crate::border::{Versioned, check, elements, handle, make, room, stride, versioned};
use crate::moving::hd_moving_tree;
use crate::round::hd_round_tree;
use crate::status::hd_status::*;
use crate::status::{Failure, guard, hd_status};
use crate::trace::{Filter, Traceable, any, closest, hd_hit, hd_ray};
use crate::tree::{build_options, hd_build_options, hd_tree};

/// A scene, ready to be traced as it was at its last commit.
pub struct hd_scene(pub(crate) Arc<Scene<'static>>);

/// Something in a scene: either a tree, a scene, a tree that moves or one of points or curves, of which there may be
/// many instances.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct hd_item {
    /// sizeof(hd_item)
    pub struct_size: usize,
    /// The tree, or NULL.
    pub tree: *const hd_tree,
    /// The scene, or NULL.
    pub scene: *const hd_scene,
    /// Twelve numbers for each key: the three rows of a matrix, four numbers each, that takes the item's points (x, y,
    /// z, 1) to the scene. NULL: where its own coordinates say. A single one that flattens to nothing, such as a scale
    /// of zero, hides the item; one that flattens nearly is an HD_ERROR_VALUE.
    pub transforms: *const f32,
    /// How many transforms there are. Several are where the item is at times evenly spaced from 0 to 1; in between
    /// their elements are interpolated.
    pub transform_count: usize,
    /// Rays see it whose mask has a bit in common with it. 0 stands for all bits.
    pub mask: u32,
    /// 0
    pub reserved: u32,
    /// The tree of triangles that move, or NULL.
    pub moving: *const hd_moving_tree,
    /// The tree of points or curves, or NULL.
    pub round: *const hd_round_tree,
}

// SAFETY: struct_size comes first; numbers and pointers may have any bits, and zeros say that there is nothing new.
unsafe impl Versioned for hd_item {
    const NAME: &'static str = "hd_item";
    const FIRST_SIZE: usize = std::mem::offset_of!(Self, moving);
}

/// A ray with what a scene asks of it besides.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct hd_scene_ray {
    /// The ray.
    pub ray: hd_ray,
    /// When, from 0 to 1; less counts as 0, and more as 1.
    pub time: f32,
    /// Which items it sees: those whose mask has a bit in common with it, at every level. 0 stands for all bits.
    pub mask: u32,
}

/// Where a ray meets a triangle of a scene.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct hd_scene_hit {
    /// Where, and which triangle of its mesh. t is the same in all spaces.
    pub hit: hd_hit,
    /// The item that has the mesh: its index in the scene that has the item.
    pub item: u32,
    /// How many nested scenes enclose the item.
    pub depth: u32,
    /// The index of the path of nested scenes to the item among all paths; hd_scene_instances lists the items on it.
    pub path: u64,
}

impl Traceable for hd_scene {
    const NAME: &'static str = "scene";
    const FLOATS: usize = 9;
    type Ray = hd_scene_ray;
    type Hit = hd_scene_hit;
    type KernelRay = SceneRay;
    type KernelHit = SceneHit;
    const MISS: SceneHit = SceneHit::MISS;

    fn intersect_many(&self, rays: &[SceneRay], hits: &mut [SceneHit]) {
        seeing(rays, hits, |rays, hits| self.0.view().intersect_many(rays, hits));
    }
    fn occluded_many(&self, rays: &[SceneRay], occluded: &mut [bool]) {
        seeing(rays, occluded, |rays, occluded| self.0.view().occluded_many(rays, occluded));
    }
    fn filtered(&self, ray: &SceneRay, filter: &mut Filter<SceneHit>) -> Option<SceneHit> {
        self.0.view().intersect_filtered(&sees_all(ray), filter)
    }
    fn occluded_filtered(&self, ray: &SceneRay, filter: &mut Filter<SceneHit>) -> bool {
        self.0.view().occluded_filtered(&sees_all(ray), filter)
    }
    fn nearest_hits(&self, ray: &SceneRay, hits: &mut [SceneHit]) -> usize {
        self.0.view().nearest_hits(&sees_all(ray), hits)
    }
    fn count_hits(&self, ray: &SceneRay) -> usize {
        self.0.view().count_hits(&sees_all(ray))
    }
}

/// Rays whose masks are changed at a time: 2.5 KiB of stack, so that nothing is allocated.
const CHUNK: usize = 64;

/// Traces rays with all bits for masks of 0, which would see nothing.
fn seeing<T>(rays: &[SceneRay], answers: &mut [T], trace: impl Fn(&[SceneRay], &mut [T])) {
    if rays.iter().all(|ray| ray.mask != 0) {
        return trace(rays, answers);
    }
    for (rays, answers) in rays.chunks(CHUNK).zip(answers.chunks_mut(CHUNK)) {
        let changed: [SceneRay; CHUNK] = std::array::from_fn(|i| sees_all(&rays[i.min(rays.len() - 1)]));
        trace(&changed[..rays.len()], answers);
    }
}

/// A ray with all bits for a mask of 0.
fn sees_all(ray: &SceneRay) -> SceneRay {
    ray.with_mask(mask_of(ray.mask))
}

/// A mask as the kernel has it, where 0 stands for all bits.
pub(crate) fn mask_of(mask: u32) -> u32 {
    if mask == 0 { u32::MAX } else { mask }
}

/// Builds a scene of count items, whose numbers are their places in the array. options may be NULL. The trees and
/// scenes in it can be freed before it; blobs that trees were opened in have to stay. With a count of 0 the scene is
/// empty, for items that are inserted. Where items move each frame, HD_QUALITY_FAST is right, as the scene's own tree,
/// which is over items, is built again now and then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_build(
    items: *const hd_item,
    count: usize,
    options: *const hd_build_options,
    scene: *mut *mut hd_scene,
) -> hd_status {
    guard(|| {
        let build = || {
            // SAFETY: the caller's promise.
            let (stride, options) = unsafe { (stride("items", items, count)?, build_options(options)?) };
            let mut placed = Vec::new();
            for number in 0..count {
                // SAFETY: the caller's promise.
                let made = unsafe { item(&format!("items[{number}]"), items.byte_add(number * stride)) };
                placed.push(made.map_err(|failure| failure.of("item", number))?);
            }
            let (scene, _) = Scene::build(placed, &options)?;
            Ok(hd_scene(Arc::new(scene)))
        };
        // SAFETY: the caller's promise.
        unsafe { make("scene", scene, build) }
    })
}

/// What the kernel makes of an item.
///
/// # Safety
/// If `item` is not null, an item lies there whose pointers are null or to as much as it says.
pub(crate) unsafe fn item(name: &str, item: *const hd_item) -> Result<Item<'static>, Failure> {
    // SAFETY: the caller's promise.
    let (item, objects) = unsafe {
        let item = versioned(name, item)?;
        let tree = item.tree.as_ref().map(hd_tree::object);
        let scene = item.scene.as_ref().map(|hd_scene(scene)| Object::from(scene.clone()));
        let moving = item.moving.as_ref().map(|hd_moving_tree(tree)| Object::from(tree.clone()));
        let round = item.round.as_ref().map(|hd_round_tree(tree)| Object::from(tree.clone()));
        (item, [tree, scene, moving, round])
    };
    let mut objects = objects.into_iter().flatten();
    let object = match (objects.next(), objects.next()) {
        (Some(object), None) => object,
        (None, _) => return Err(Failure::new(HD_ERROR_NULL, "it has none of tree, scene, moving and round")),
        _ => return Err(Failure::new(HD_ERROR_VALUE, "it has more than one of tree, scene, moving and round")),
    };
    if item.transform_count == 0 && !item.transforms.is_null() {
        return Err(Failure::new(HD_ERROR_SIZE, "it has transforms, and a transform_count of 0"));
    }
    let floats = item.transform_count.saturating_mul(12);
    // SAFETY: the caller's promise.
    let floats = unsafe { elements("its transforms", item.transforms, floats) }?;
    let placed = match floats.as_chunks().0 {
        [] => Item::new(object),
        [only] => Item::new(object).placed(&transform(only))?,
        keys => Item::new(object).moving_shared(keys.iter().map(transform).collect())?,
    };
    Ok(placed.with_mask(mask_of(item.mask)))
}

/// The transform whose matrix has these rows.
pub(crate) fn transform(rows: &[f32; 12]) -> Affine3A {
    let column = |k: usize| Vec3::new(rows[k], rows[4 + k], rows[8 + k]);
    Affine3A {
        matrix3: glam::Mat3A::from_cols(column(0).into(), column(1).into(), column(2).into()),
        translation: column(3).into(),
    }
}

/// Finds the nearest hit of a ray; of equally near ones that of the lowest item, then prim_id, then path.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_intersect(
    scene: Option<&hd_scene>,
    ray: *const hd_scene_ray,
    hit: *mut hd_scene_hit,
) -> hd_status {
    // SAFETY: the caller's promise.
    unsafe { closest(scene, ["ray", "hit"], ray, hit, 1) }
}

/// Finds out whether a ray hits anything.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_occluded(
    scene: Option<&hd_scene>,
    ray: *const hd_scene_ray,
    occluded: *mut bool,
) -> hd_status {
    // SAFETY: the caller's promise.
    unsafe { any(scene, ["ray", "occluded"], ray, occluded, 1) }
}

/// hd_scene_intersect for count rays. If a ray has a NaN none is traced.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_intersect_many(
    scene: Option<&hd_scene>,
    rays: *const hd_scene_ray,
    hits: *mut hd_scene_hit,
    count: usize,
) -> hd_status {
    // SAFETY: the caller's promise.
    unsafe { closest(scene, ["rays", "hits"], rays, hits, count) }
}

/// hd_scene_occluded for count rays, likewise.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_occluded_many(
    scene: Option<&hd_scene>,
    rays: *const hd_scene_ray,
    occluded: *mut bool,
    count: usize,
) -> hd_status {
    // SAFETY: the caller's promise.
    unsafe { any(scene, ["rays", "occluded"], rays, occluded, count) }
}

/// Writes the items that are scenes on the path to a hit of this scene, the outermost first: their indices, each in the
/// scene that has it, as many as hit->depth says. instances has room for capacity of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_instances(
    scene: Option<&hd_scene>,
    hit: *const hd_scene_hit,
    instances: *mut u32,
    capacity: usize,
) -> hd_status {
    guard(|| {
        let view = handle("scene", scene)?.0.view();
        check("hit", hit, 1)?;
        // SAFETY: the caller's promise.
        let hit: SceneHit = bytemuck::cast(unsafe { *hit });
        let found = view.instances(&hit).map(|(number, _)| number);
        if found.clone().count() != hit.depth as usize {
            return Err(Failure::new(HD_ERROR_VALUE, "hit is none of this scene"));
        }
        if hit.depth as usize > capacity {
            let needed = format!("instances has room for {capacity}, and the hit has {}", hit.depth);
            return Err(Failure::new(HD_ERROR_SIZE, needed));
        }
        // SAFETY: the caller's promise.
        let room = unsafe { room("instances", instances, hit.depth as usize) }?;
        room.iter_mut().zip(found).for_each(|(place, number)| *place = number);
        Ok(())
    })
}

/// Frees a scene, which nobody may be using. Scenes that it is in stay as they are. NULL is allowed.
#[unsafe(no_mangle)]
pub extern "C" fn hd_scene_free(scene: Option<Box<hd_scene>>) {
    drop(scene);
}
