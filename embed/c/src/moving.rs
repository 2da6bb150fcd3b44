//! Trees of triangles that move between keys, for scenes.

use std::sync::Arc;

use halfdome_kernel::Triangle;
use halfdome_kernel::bvh::MovingBvh;
use halfdome_kernel::mesh::Mesh as _;

use crate::border::{make, stride, versioned};
use crate::mesh::{hd_mesh, with_mesh};
use crate::status::{guard, hd_status};
use crate::tree::{build_options, hd_build_options};

/// A tree of triangles that move. Scenes alone have it, as their rays have a time.
pub struct hd_moving_tree(pub(crate) Arc<MovingBvh>);

/// Builds a tree of key_count meshes, which are copied: the same triangles, in the same order, where they are at times
/// evenly spaced from 0 to 1; in between they move in straight lines. options may be NULL. Put it in a scene as
/// hd_item's moving.
///
/// HD_ERROR_VALUE if there is no mesh, or if they differ in the number of triangles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_moving_tree_build(
    keys: *const hd_mesh,
    key_count: usize,
    options: *const hd_build_options,
    tree: *mut *mut hd_moving_tree,
) -> hd_status {
    guard(|| {
        let build = || {
            // SAFETY: the caller's promise.
            let (stride, options) = unsafe { (stride("keys", keys, key_count)?, build_options(options)?) };
            let mut soups: Vec<Vec<Triangle>> = Vec::new();
            for number in 0..key_count {
                // SAFETY: the caller's promise.
                let soup = unsafe {
                    versioned(&format!("keys[{number}]"), keys.byte_add(number * stride)).and_then(|key| {
                        with_mesh(&key, |mesh| Ok((0..mesh.len()).map(|prim| mesh.triangle(prim)).collect()))
                    })
                };
                soups.push(soup.map_err(|failure| failure.of("key", number))?);
            }
            let keys: Vec<&[Triangle]> = soups.iter().map(Vec::as_slice).collect();
            Ok(hd_moving_tree(Arc::new(MovingBvh::build(&keys, &options)?.0)))
        };
        // SAFETY: the caller's promise.
        unsafe { make("tree", tree, build) }
    })
}

/// Frees a tree. Scenes that it is in keep it. NULL is allowed.
#[unsafe(no_mangle)]
pub extern "C" fn hd_moving_tree_free(tree: Option<Box<hd_moving_tree>>) {
    drop(tree);
}
