//! Meshes as C has them: strided vertices of 32 or 16 bits a number, indices of 32 or 16 bits, read where they lie.

use std::ffi::c_void;

use glam::Vec3;
use halfdome_kernel::mesh::{IndexedMesh, Indices, Mesh, Positions};
use halfdome_kernel::{InvalidMesh, MAX_COORDINATE, Triangle};

use crate::border::{Versioned, check, elements};
use crate::status::Failure;
use crate::status::hd_status::*;

/// Positions are three floats.
pub const HD_POSITIONS_F32: u32 = 0;
/// Positions are three uint16_t, of which each is q * scale + offset.
pub const HD_POSITIONS_U16: u32 = 1;
/// Positions are three int16_t, likewise.
pub const HD_POSITIONS_I16: u32 = 2;

/// Triangles.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct hd_mesh {
    /// sizeof(hd_mesh)
    pub struct_size: usize,
    /// x, y and z of each vertex: floats, unless position_format says otherwise.
    pub positions: *const c_void,
    /// How many vertices there are.
    pub vertex_count: usize,
    /// Bytes from one vertex to the next, a multiple of the size of a number, and at least that of three; 0 stands for
    /// that.
    pub vertex_stride: usize,
    /// Three vertices for each triangle, counter-clockwise when seen from the front: uint32_t, unless index_size says
    /// otherwise. NULL: 0, 1, 2, 3 …
    pub indices: *const c_void,
    /// How many indices there are, a multiple of three; without indices vertex_count is.
    pub index_count: usize,
    /// The bytes of an index: 4, or 2 for uint16_t. 0 stands for 4.
    pub index_size: u32,
    /// One of HD_POSITIONS_*.
    pub position_format: u32,
    /// What positions of 16 bits are multiplied by. All 0 stands for all 1.
    pub scale: [f32; 3],
    /// What is added to positions of 16 bits then.
    pub offset: [f32; 3],
}

// SAFETY: struct_size comes first; numbers and pointers may have any bits, and zeros say that there is nothing new.
unsafe impl Versioned for hd_mesh {
    const NAME: &'static str = "hd_mesh";
    const FIRST_SIZE: usize = std::mem::offset_of!(Self, index_size);
}

/// Calls `work` with the mesh where it lies, if all its triangles are within the kernel's limits.
///
/// # Safety
/// Where its pointers are not null, as many elements lie there as it says, which nobody changes meanwhile.
pub(crate) unsafe fn with_mesh<T>(
    mesh: &hd_mesh,
    work: impl FnOnce(&IndexedMesh) -> Result<T, Failure>,
) -> Result<T, Failure> {
    // SAFETY: the caller's promise.
    let (positions, indices) = unsafe { (positions(mesh)?, indices(mesh)?) };
    let (name, count) = match indices {
        Indices::InOrder => ("vertex_count", mesh.vertex_count),
        Indices::U16(_) | Indices::U32(_) => ("index_count", mesh.index_count),
    };
    if !count.is_multiple_of(3) {
        return Err(Failure::new(HD_ERROR_SIZE, format!("mesh->{name} is {count}: it must be a multiple of three")));
    }
    let mesh = IndexedMesh::new(positions, indices).map_err(|error| match error {
        InvalidMesh::IndexOutOfRange { place, index, count } => {
            let triangle = place / 3;
            let message = format!("triangle {triangle} has the index {index}, and there are {count} vertices");
            Failure::new(HD_ERROR_VALUE, message)
        }
        other => Failure::from(halfdome_kernel::Error::from(other)),
    })?;
    (0..mesh.len()).try_for_each(|number| check_corners(number, &mesh.triangle(number)))?;
    work(&mesh)
}

/// # Safety
/// That of [`with_mesh`].
unsafe fn positions<'a>(mesh: &hd_mesh) -> Result<Positions<'a>, Failure> {
    let number = match mesh.position_format {
        HD_POSITIONS_F32 => size_of::<f32>(),
        HD_POSITIONS_U16 | HD_POSITIONS_I16 => size_of::<u16>(),
        other => {
            let message = format!("mesh->position_format is {other}: it must be one of HD_POSITIONS_*, 0 to 2");
            return Err(Failure::new(HD_ERROR_VALUE, message));
        }
    };
    let least = 3 * number;
    let stride = if mesh.vertex_stride == 0 { least } else { mesh.vertex_stride };
    if stride < least || stride % number != 0 {
        let message =
            format!("mesh->vertex_stride is {stride}: it must be 0, or a multiple of {number} from {least} on");
        return Err(Failure::new(HD_ERROR_SIZE, message));
    }
    let bytes = mesh.vertex_count.checked_sub(1).map_or(0, |last| last.saturating_mul(stride).saturating_add(least));
    if bytes > 0 {
        match number {
            2 => check("mesh->positions", mesh.positions.cast::<u16>(), bytes.div_ceil(2))?,
            _ => check("mesh->positions", mesh.positions.cast::<f32>(), bytes.div_ceil(4))?,
        }
    }
    // SAFETY: the caller's promise; after the last vertex nothing is read.
    let bytes: &[u8] = unsafe { elements("mesh->positions", mesh.positions.cast(), bytes) }?;
    let scale = if mesh.scale == [0.0; 3] { Vec3::ONE } else { Vec3::from_array(mesh.scale) };
    let offset = Vec3::from_array(mesh.offset);
    let positions = match mesh.position_format {
        HD_POSITIONS_U16 => Positions::u16(bytes, 0, stride, scale, offset),
        HD_POSITIONS_I16 => Positions::i16(bytes, 0, stride, scale, offset),
        _ => Positions::f32(bytes, 0, stride),
    };
    positions.map_err(|error| halfdome_kernel::Error::from(error).into())
}

/// # Safety
/// That of [`with_mesh`].
unsafe fn indices<'a>(mesh: &hd_mesh) -> Result<Indices<'a>, Failure> {
    if mesh.indices.is_null() && mesh.index_count == 0 {
        return Ok(Indices::InOrder);
    }
    let (name, count) = ("mesh->indices", mesh.index_count);
    // SAFETY: the caller's promise.
    unsafe {
        match mesh.index_size {
            0 | 4 => Ok(Indices::U32(elements(name, mesh.indices.cast(), count)?)),
            2 => Ok(Indices::U16(elements(name, mesh.indices.cast(), count)?)),
            other => {
                let message = format!("mesh->index_size is {other}: it must be 0, 2 or 4");
                Err(Failure::new(HD_ERROR_VALUE, message))
            }
        }
    }
}

/// Checks that a triangle's corners are within the kernel's limits.
fn check_corners(number: usize, corners: &Triangle) -> Result<(), Failure> {
    match corners.iter().find(|corner| !corner.abs().cmple(Vec3::splat(MAX_COORDINATE)).all()) {
        None => Ok(()),
        Some(Vec3 { x, y, z }) => {
            let limit = format!("coordinates must be from -{MAX_COORDINATE:e} to {MAX_COORDINATE:e}");
            Err(Failure::new(HD_ERROR_VALUE, format!("triangle {number} has the corner ({x}, {y}, {z}): {limit}")))
        }
    }
}
