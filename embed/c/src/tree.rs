//! Trees: made of triangles, described and freed.

use std::any::Any;
use std::sync::Arc;

use glam::Vec3;
use halfdome_kernel::{BuildOptions, Bvh, BvhView, MAX_COORDINATE, Quality, Triangle};

use crate::border::{Versioned, elements, forever, handle, make, versioned, versioned_room};
use crate::status::hd_status::*;
use crate::status::{Failure, guard, hd_status};

/// A tree of triangles, ready to be traced.
pub struct hd_tree {
    /// Borrows the memory.
    pub(crate) view: BvhView<'static>,
    pub(crate) memory: Memory,
}

/// Where a tree lies.
pub(crate) enum Memory {
    /// Here; shared with the scenes that the tree is in.
    Own(Arc<Bvh>),
    /// In a blob of the program's, which it keeps as long as the tree and those scenes.
    Blob(&'static [u8]),
}

impl Memory {
    /// What a scene has to keep.
    pub(crate) fn shared(&self) -> Option<Arc<dyn Any + Send + Sync>> {
        match self {
            Self::Own(bvh) => Some(bvh.clone()),
            Self::Blob(_) => None,
        }
    }
}

impl From<Bvh> for hd_tree {
    fn from(bvh: Bvh) -> Self {
        let bvh = Arc::new(bvh);
        // SAFETY: the tree keeps its memory beside the view, and whoever copies the view shares the memory.
        let view = unsafe { forever(&*bvh) }.view();
        Self { view, memory: Memory::Own(bvh) }
    }
}

/// Triangles.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct hd_mesh {
    /// sizeof(hd_mesh)
    pub struct_size: usize,
    /// x, y and z of each vertex.
    pub positions: *const f32,
    /// How many vertices there are.
    pub vertex_count: usize,
    /// Bytes from one vertex to the next, a multiple of 4, at least 12; 0 stands for 12.
    pub vertex_stride: usize,
    /// Three vertices for each triangle, counter-clockwise when seen from the front. NULL: 0, 1, 2, 3 …
    pub indices: *const u32,
    /// How many indices there are, a multiple of three; without indices vertex_count is.
    pub index_count: usize,
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

// SAFETY: struct_size comes first; numbers and pointers may have any bits.
unsafe impl Versioned for hd_mesh {
    const NAME: &'static str = "hd_mesh";
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
            let triangles = unsafe { triangles(&mesh) }?;
            let (bvh, _) = Bvh::build(&triangles, &options)?;
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
    Ok(quality.into())
}

/// The mesh's triangles.
///
/// # Safety
/// Where its pointers are not null, as many elements lie there as it says.
unsafe fn triangles(mesh: &hd_mesh) -> Result<Vec<Triangle>, Failure> {
    let stride = if mesh.vertex_stride == 0 { size_of::<[f32; 3]>() } else { mesh.vertex_stride };
    if stride < size_of::<[f32; 3]>() || stride % size_of::<f32>() != 0 {
        let message = format!("mesh->vertex_stride is {stride}: it must be 0, or a multiple of 4 from 12 on");
        return Err(Failure::new(HD_ERROR_SIZE, message));
    }
    let stride = stride / size_of::<f32>();
    let floats = mesh.vertex_count.checked_sub(1).map_or(0, |last| last.saturating_mul(stride).saturating_add(3));
    // SAFETY: the caller's promise; after the last vertex nothing is read.
    let positions = unsafe { elements("mesh->positions", mesh.positions, floats) }?;
    let vertices: Vec<Vec3> = positions.chunks(stride).map(|vertex| Vec3::from_slice(&vertex[..3])).collect();
    if mesh.indices.is_null() && mesh.index_count == 0 {
        whole_triangles("vertex_count", vertices.len())?;
        return (0..).zip(vertices.as_chunks().0).map(|(number, &corners)| checked(number, corners)).collect();
    }
    // SAFETY: the caller's promise.
    let indices = unsafe { elements("mesh->indices", mesh.indices, mesh.index_count) }?;
    whole_triangles("index_count", indices.len())?;
    let triangle = |(number, corners): (usize, &[u32; 3])| {
        if let Some(&index) = corners.iter().find(|&&index| index as usize >= vertices.len()) {
            let count = vertices.len();
            let message = format!("triangle {number} has the index {index}, and there are {count} vertices");
            return Err(Failure::new(HD_ERROR_VALUE, message));
        }
        checked(number, corners.map(|index| vertices[index as usize]))
    };
    (0..).zip(indices.as_chunks().0).map(triangle).collect()
}

fn whole_triangles(name: &str, count: usize) -> Result<(), Failure> {
    if count.is_multiple_of(3) {
        return Ok(());
    }
    Err(Failure::new(HD_ERROR_SIZE, format!("mesh->{name} is {count}: it must be a multiple of three")))
}

/// The triangle, if its corners are within the kernel's limits.
fn checked(number: usize, corners: Triangle) -> Result<Triangle, Failure> {
    match corners.iter().find(|corner| !corner.abs().cmple(Vec3::splat(MAX_COORDINATE)).all()) {
        None => Ok(corners),
        Some(Vec3 { x, y, z }) => {
            let limit = format!("coordinates must be from -{MAX_COORDINATE:e} to {MAX_COORDINATE:e}");
            Err(Failure::new(HD_ERROR_VALUE, format!("triangle {number} has the corner ({x}, {y}, {z}): {limit}")))
        }
    }
}

/// Describes a tree.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hd_tree_describe(tree: Option<&hd_tree>, info: *mut hd_tree_info) -> hd_status {
    guard(|| {
        let tree = handle("tree", tree)?.view;
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
