//! Trees: made of triangles, moved with them, described and freed.

use std::sync::Arc;

use halfdome_kernel::mesh::IndexedMesh;
use halfdome_kernel::scene::Object;
use halfdome_kernel::{BuildOptions, Bvh, BvhView, Quality};

use crate::border::{Versioned, check, handle, handle_mut, make, room, room_for_one, versioned, versioned_room};
use crate::mesh::{hd_mesh, with_mesh};
use crate::status::hd_status::*;
use crate::status::{Failure, guard, hd_status};

/// A tree of triangles, ready to be traced.
pub struct hd_tree(pub(crate) Memory);

/// Where a tree lies.
pub(crate) enum Memory {
    /// Here; shared with the scenes that the tree is in.
    Own(Arc<Bvh>),
    /// In a blob of the program's, which it keeps as long as the tree and those scenes.
    Blob { bytes: &'static [u8], view: BvhView<'static> },
}

impl hd_tree {
    /// Borrows the tree for tracing.
    pub(crate) fn view(&self) -> BvhView<'_> {
        match &self.0 {
            Memory::Own(bvh) => bvh.view(),
            Memory::Blob { view, .. } => *view,
        }
    }

    /// The tree as it is now, for a scene.
    pub(crate) fn object(&self) -> Object<'static> {
        match &self.0 {
            Memory::Own(bvh) => bvh.clone().into(),
            Memory::Blob { view, .. } => (*view).into(),
        }
    }
}

impl From<Bvh> for hd_tree {
    fn from(bvh: Bvh) -> Self {
        Self(Memory::Own(Arc::new(bvh)))
    }
}

/// How to build a tree.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct hd_build_options {
    /// sizeof(hd_build_options)
    pub struct_size: usize,
    /// One of HD_QUALITY_*.
    pub quality: u32,
    /// 0
    pub reserved: u32,
}

/// What the library thinks best: HD_QUALITY_HIGH.
pub const HD_QUALITY_DEFAULT: u32 = 0;
/// Built quickly, for trees that are traced little.
pub const HD_QUALITY_FAST: u32 = 1;
/// In between.
pub const HD_QUALITY_MEDIUM: u32 = 2;
/// Traced quickly.
pub const HD_QUALITY_HIGH: u32 = 3;

/// A tree in figures.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct hd_tree_info {
    /// sizeof(hd_tree_info)
    pub struct_size: usize,
    /// Triangles in it. Of those that it was built from some may be missing: those with two equal corners.
    pub triangle_count: usize,
    /// Nodes of the tree.
    pub node_count: usize,
    /// Memory of the tree in bytes.
    pub byte_count: usize,
    /// The least x, y and z; +infinity if there are no triangles.
    pub bounds_min: [f32; 3],
    /// The greatest x, y and z; -infinity if there are no triangles.
    pub bounds_max: [f32; 3],
}

// SAFETY: struct_size comes first; numbers may have any bits.
unsafe impl Versioned for hd_build_options {
    const NAME: &'static str = "hd_build_options";
}

// SAFETY: struct_size comes first; numbers may have any bits.
unsafe impl Versioned for hd_tree_info {
    const NAME: &'static str = "hd_tree_info";
}

/// Builds a tree of a mesh, which is copied. options may be NULL. The same triangles and options give the same tree on
/// every machine. Hits have the numbers of the triangles in the mesh.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_tree_build(
    mesh: *const hd_mesh,
    options: *const hd_build_options,
    tree: *mut *mut hd_tree,
) -> hd_status {
    guard(|| {
        let build = || {
            // SAFETY: the caller's promise.
            let (mesh, options) = unsafe { (versioned("mesh", mesh)?, build_options(options)?) };
            // SAFETY: the caller's promise.
            let (bvh, _) = unsafe { with_mesh(&mesh, |mesh| Ok(Bvh::build_mesh(mesh, &options)?)) }?;
            Ok(bvh.into())
        };
        // SAFETY: the caller's promise.
        unsafe { make("tree", tree, build) }
    })
}

/// # Safety
/// That of [`versioned`].
pub(crate) unsafe fn build_options(options: *const hd_build_options) -> Result<BuildOptions, Failure> {
    if options.is_null() {
        return Ok(BuildOptions::default());
    }
    // SAFETY: the caller's promise.
    let options = unsafe { versioned("options", options) }?;
    let quality = match options.quality {
        HD_QUALITY_DEFAULT | HD_QUALITY_HIGH => Quality::High,
        HD_QUALITY_FAST => Quality::Fast,
        HD_QUALITY_MEDIUM => Quality::Medium,
        other => {
            let message = format!("options->quality is {other}: it must be one of HD_QUALITY_*, 0 to 3");
            return Err(Failure::new(HD_ERROR_VALUE, message));
        }
    };
    match options.reserved {
        0 => Ok(quality.into()),
        other => Err(Failure::new(HD_ERROR_VALUE, format!("options->reserved is {other}: it must be 0"))),
    }
}

/// Moves a tree to where the triangles of a mesh are now, which are as many as before and in the same order: quicker
/// than a new tree, which pays when *decay, the cost of rays as a multiple of what it was when the tree was built, is
/// beyond 1.5. decay may be NULL. Hits are those of a new tree.
///
/// Nobody may be tracing the tree. Scenes that it is in keep it as it was until hd_scene_set_item puts it there again;
/// the tree is then copied first, as is one that was opened in a blob.
///
/// HD_ERROR_VALUE if triangles that rays could hit are gone or new ones have come, as where two corners become one; the
/// tree is then as it was.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_tree_refit(tree: Option<&mut hd_tree>, mesh: *const hd_mesh, decay: *mut f32) -> hd_status {
    guard(|| {
        let tree = handle_mut("tree", tree)?;
        // SAFETY: the caller's promise.
        let mesh = unsafe { versioned("mesh", mesh) }?;
        if !decay.is_null() {
            check("decay", decay, 1)?;
        }
        let refit = |mesh: &IndexedMesh| {
            let refit = match &mut tree.0 {
                Memory::Own(bvh) => Arc::make_mut(bvh).refit_mesh(mesh)?,
                Memory::Blob { bytes, .. } => {
                    let mut bvh = Bvh::from_bytes(bytes)?;
                    let refit = bvh.refit_mesh(mesh)?;
                    *tree = bvh.into();
                    refit
                }
            };
            Ok(refit.cost_ratio)
        };
        // SAFETY: the caller's promise.
        let now = unsafe { with_mesh(&mesh, refit) }?;
        if !decay.is_null() {
            // SAFETY: the caller's promise.
            *unsafe { room_for_one("decay", decay) }? = now;
        }
        Ok(())
    })
}

/// Writes the three corners of a triangle, x, y and z each, to nine numbers. Looks through the whole tree.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_tree_triangle(tree: Option<&hd_tree>, prim_id: u32, corners: *mut f32) -> hd_status {
    guard(|| {
        let tree = handle("tree", tree)?;
        check("corners", corners, 9)?;
        let Some(triangle) = tree.view().triangle(prim_id) else {
            return Err(Failure::new(HD_ERROR_VALUE, format!("the tree has no triangle {prim_id}")));
        };
        // SAFETY: the caller's promise.
        let corners = unsafe { room("corners", corners, 9) }?;
        corners.copy_from_slice(bytemuck::cast_slice(&triangle));
        Ok(())
    })
}

/// Describes a tree.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_tree_describe(tree: Option<&hd_tree>, info: *mut hd_tree_info) -> hd_status {
    guard(|| {
        let tree = handle("tree", tree)?.view();
        // SAFETY: the caller's promise.
        let info = unsafe { versioned_room("info", info) }?;
        let used = tree.blocks().iter().flat_map(|block| block.prim_id).filter(|&id| id != crate::trace::HD_NO_PRIM);
        info.triangle_count = used.count();
        info.node_count = tree.nodes().len();
        info.byte_count = size_of_val(tree.nodes()) + size_of_val(tree.blocks());
        info.bounds_min = tree.bounds().min.to_array();
        info.bounds_max = tree.bounds().max.to_array();
        Ok(())
    })
}

/// Frees a tree, which nobody may be using. NULL is allowed.
#[unsafe(no_mangle)]
pub extern "C" fn hd_tree_free(tree: Option<Box<hd_tree>>) {
    drop(tree);
}
