//! Trees as bytes: saved, and opened again where they lie.

use halfdome_kernel::bvh::BLOB_ALIGNMENT;
use halfdome_kernel::{Bvh, BvhView};

use crate::border::{check, elements, handle, make, room, room_for_one};
use crate::status::hd_status::*;
use crate::status::{Failure, guard, hd_status};
use crate::tree::{Memory, hd_tree};

/// What the address of a blob must be a multiple of, if it is to be traced where it lies.
pub const HD_BLOB_ALIGNMENT: usize = 64;

const _: () = assert!(HD_BLOB_ALIGNMENT == BLOB_ALIGNMENT);

/// Writes a tree as a blob: to bytes, if there is room for it, and its length to *size. Where bytes is NULL and
/// capacity is 0 only the length is written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_tree_save(
    tree: Option<&hd_tree>,
    bytes: *mut u8,
    capacity: usize,
    size: *mut usize,
) -> hd_status {
    guard(|| {
        let owned;
        let blob: &[u8] = match &handle("tree", tree)?.0 {
            Memory::Own(bvh) => {
                owned = bvh.to_bytes();
                &owned
            }
            Memory::Blob { bytes, .. } => bytes,
        };
        // SAFETY: the caller's promise.
        unsafe { write_blob(blob, bytes, capacity, size) }
    })
}

/// Writes a blob where there is room for it, and its length; only that if there is no room at all.
///
/// # Safety
/// That of [`room`].
pub(crate) unsafe fn write_blob(blob: &[u8], bytes: *mut u8, capacity: usize, size: *mut usize) -> Result<(), Failure> {
    if bytes.is_null() && capacity == 0 {
        // SAFETY: the caller's promise.
        *unsafe { room_for_one("size", size) }? = blob.len();
        return Ok(());
    }
    if capacity < blob.len() {
        let message = format!("capacity is {capacity}, and the blob takes {} bytes", blob.len());
        return Err(Failure::new(HD_ERROR_SIZE, message));
    }
    check("size", size, 1)?;
    // SAFETY: the caller's promise.
    let (bytes, size) = unsafe { (room("bytes", bytes, blob.len())?, room_for_one("size", size)?) };
    bytes.copy_from_slice(blob);
    *size = blob.len();
    Ok(())
}

/// Makes a tree of a blob that is traced where it lies, without a copy: bytes is a multiple of HD_BLOB_ALIGNMENT, and
/// stays as it is until the tree, and every scene that it is in, is freed. The blob is checked once, so that whatever
/// it holds is safe to trace.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_tree_open(bytes: *const u8, size: usize, tree: *mut *mut hd_tree) -> hd_status {
    guard(|| {
        let open = || {
            // SAFETY: the caller's promise, which is for as long as the tree lives.
            let blob: &'static [u8] = unsafe { elements("bytes", bytes, size) }?;
            Ok(hd_tree(Memory::Blob { bytes: blob, view: BvhView::from_bytes(blob)? }))
        };
        // SAFETY: the caller's promise.
        unsafe { make("tree", tree, open) }
    })
}

/// Makes a tree of a blob, which is copied and may lie anywhere.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_tree_load(bytes: *const u8, size: usize, tree: *mut *mut hd_tree) -> hd_status {
    guard(|| {
        // SAFETY: the caller's promise.
        let load = || Ok(Bvh::from_bytes(unsafe { elements("bytes", bytes, size) }?)?.into());
        // SAFETY: the caller's promise.
        unsafe { make("tree", tree, load) }
    })
}
