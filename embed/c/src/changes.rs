//! Scenes that change: items come, move and go, and a commit makes that what rays see.

use std::sync::Arc;

use halfdome_kernel::InvalidScene;
use halfdome_kernel::scene::{Handle, Scene};

use crate::border::{Versioned, check, elements, handle, handle_mut, room_for_one, versioned_room};
use crate::scene::{hd_item, hd_scene, item, mask_of, transform};
use crate::status::{Failure, guard, hd_status};

/// The name of an item, valid until the item is removed. Numbers of items are used again, but under other names.
#[derive(Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct hd_handle {
    /// The item's index: the item field of its hits.
    pub index: u32,
    /// How many items had this index before.
    pub generation: u32,
}

/// What a commit did.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct hd_commit {
    /// sizeof(hd_commit)
    pub struct_size: usize,
    /// How many items were inserted, changed or removed.
    pub changed: usize,
    /// How many items rays can see if their masks allow; others are empty, flat or removed, or reach beyond the limits.
    pub seen: usize,
    /// The expected number of nodes of the scene's own tree that a random ray visits.
    pub cost: f32,
    /// 1 if that tree was built anew, and 0 if it was fitted to the changes.
    pub rebuilt: u32,
}

// SAFETY: struct_size comes first; numbers may have any bits.
unsafe impl Versioned for hd_commit {
    const NAME: &'static str = "hd_commit";
}

impl From<Handle> for hd_handle {
    fn from(handle: Handle) -> Self {
        Self { index: handle.index(), generation: handle.generation() }
    }
}

/// The scene, to be changed: copied first if it is in another one, which keeps it as it was.
fn changing(scene: Option<&mut hd_scene>) -> Result<&mut Scene<'static>, Failure> {
    Ok(Arc::make_mut(&mut handle_mut("scene", scene)?.0))
}

/// The kernel's handle of an item.
fn named(scene: &Scene, hd_handle { index, generation }: hd_handle) -> Result<Handle, Failure> {
    let known = scene.handle(index).filter(|handle| handle.generation() == generation);
    Ok(known.ok_or(halfdome_kernel::Error::from(InvalidScene::NoSuchItem { index, generation }))?)
}

/// Adds an item, which rays see from the next commit on. Items of hd_scene_build have handles too: their index, and
/// generation 0.
///
/// This and the other functions that change a scene need it for themselves: nobody may be tracing it. Scenes that it is
/// in keep it as it was until hd_scene_set_item puts it there again; it is then copied first.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_insert(
    scene: *mut hd_scene,
    item: *const hd_item,
    handle: *mut hd_handle,
) -> hd_status {
    guard(|| {
        check("scene", scene, 1)?;
        check("handle", handle, 1)?;
        // SAFETY: the caller's promise. The item may be the scene itself, as it is now: only then is it borrowed to be
        // changed.
        let (made, scene, handle) =
            unsafe { (self::item("item", item)?, changing(scene.as_mut())?, room_for_one("handle", handle)?) };
        *handle = scene.insert(made)?.into();
        Ok(())
    })
}

/// Removes an item: rays see it until the next commit, and its handle is valid no more.
#[unsafe(no_mangle)]
pub extern "C" fn hd_scene_remove(scene: Option<&mut hd_scene>, handle: hd_handle) -> hd_status {
    guard(|| {
        let scene = changing(scene)?;
        let handle = named(scene, handle)?;
        Ok(scene.remove(handle)?)
    })
}

/// Puts an item where a transform of twelve numbers (the three rows of a matrix, four numbers each) takes its points,
/// from the next commit on. One that flattens hides it; one with a NaN or nearly flat is refused, and the item stays
/// where it was.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_set_transform(
    scene: Option<&mut hd_scene>,
    handle: hd_handle,
    rows: *const f32,
) -> hd_status {
    guard(|| {
        let scene = changing(scene)?;
        let handle = named(scene, handle)?;
        // SAFETY: the caller's promise.
        let rows: &[f32] = unsafe { elements("rows", rows, 12) }?;
        Ok(scene.set_transform(handle, &transform(&rows.as_chunks().0[0]))?)
    })
}

/// Says which rays see an item from the next commit on: those whose mask has a bit in common. 0 stands for all bits.
#[unsafe(no_mangle)]
pub extern "C" fn hd_scene_set_mask(scene: Option<&mut hd_scene>, handle: hd_handle, mask: u32) -> hd_status {
    guard(|| {
        let scene = changing(scene)?;
        let handle = named(scene, handle)?;
        Ok(scene.set_mask(handle, mask_of(mask))?)
    })
}

/// Exchanges an item as a whole, from the next commit on: what it is, such as a tree that was refitted, where, and who
/// sees it. Its handle stays.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_set_item(scene: *mut hd_scene, handle: hd_handle, item: *const hd_item) -> hd_status {
    guard(|| {
        check("scene", scene, 1)?;
        // SAFETY: the caller's promise. The item may be the scene itself, as it is now.
        let (made, scene) = unsafe { (self::item("item", item)?, changing(scene.as_mut())?) };
        let handle = named(scene, handle)?;
        Ok(scene.set_item(handle, made)?)
    })
}

/// Makes all changes since the last commit, which rays see from now on. The scene's own tree is fitted to them, or
/// built again where that is better. commit may be NULL. If it fails the scene is as of the last commit, and the
/// changes still wait.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_commit(scene: Option<&mut hd_scene>, commit: *mut hd_commit) -> hd_status {
    guard(|| {
        let scene = changing(scene)?;
        // SAFETY: the caller's promise.
        let room = if commit.is_null() { None } else { Some(unsafe { versioned_room("commit", commit) }?) };
        let done = scene.commit()?;
        if let Some(room) = room {
            room.changed = done.changed;
            room.seen = done.seen;
            room.cost = done.cost;
            room.rebuilt = u32::from(done.is_rebuilt);
        }
        Ok(())
    })
}

/// Gives the handle of the item that a hit names by its item field. HD_ERROR_VALUE if it was removed since.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_handle(scene: Option<&hd_scene>, item: u32, handle: *mut hd_handle) -> hd_status {
    guard(|| {
        let scene = self::handle("scene", scene)?;
        check("handle", handle, 1)?;
        let Some(found) = scene.0.handle(item) else {
            let message = format!("there is no item {item}");
            return Err(Failure::new(crate::status::hd_status::HD_ERROR_VALUE, message));
        };
        // SAFETY: the caller's promise.
        *unsafe { room_for_one("handle", handle) }? = found.into();
        Ok(())
    })
}
