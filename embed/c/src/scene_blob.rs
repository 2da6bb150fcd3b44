//! Scenes as bytes: saved, opened where they lie, and loaded.

use std::sync::Arc;

use halfdome_kernel::Scene;

use crate::blob::write_blob;
use crate::border::{elements, handle, make};
use crate::scene::hd_scene;
use crate::status::{guard, hd_status};

/// Writes a scene as of its last commit as a blob, with all trees and scenes in it: to bytes, if there is room for it,
/// and its length to *size. Where bytes is NULL and capacity is 0 only the length is written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_save(
    scene: Option<&hd_scene>,
    bytes: *mut u8,
    capacity: usize,
    size: *mut usize,
) -> hd_status {
    guard(|| {
        let blob = handle("scene", scene)?.0.to_bytes()?;
        // SAFETY: the caller's promise.
        unsafe { write_blob(&blob, bytes, capacity, size) }
    })
}

/// Makes a scene of a blob whose trees are traced where they lie, without a copy: bytes is a multiple of
/// HD_BLOB_ALIGNMENT, and stays as it is until the scene, and every scene that it is in, is freed. Items and handles
/// are those of hd_scene_load.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_open(bytes: *const u8, size: usize, scene: *mut *mut hd_scene) -> hd_status {
    guard(|| {
        let open = || {
            // SAFETY: the caller's promise, which is for as long as the scene lives.
            let blob: &'static [u8] = unsafe { elements("bytes", bytes, size) }?;
            Ok(hd_scene(Arc::new(Scene::over_bytes(blob)?)))
        };
        // SAFETY: the caller's promise.
        unsafe { make("scene", scene, open) }
    })
}

/// Makes a scene of a blob, which is copied and may lie anywhere, and is checked so that whatever it holds is safe to
/// trace. Items have the numbers that they had, and handles of generation 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_scene_load(bytes: *const u8, size: usize, scene: *mut *mut hd_scene) -> hd_status {
    guard(|| {
        // SAFETY: the caller's promise.
        let load = || Ok(hd_scene(Arc::new(Scene::from_bytes(unsafe { elements("bytes", bytes, size) }?)?)));
        // SAFETY: the caller's promise.
        unsafe { make("scene", scene, load) }
    })
}
