//! Meshes in the caller's memory: indexed, with positions in vertex buffers of any stride, as `f32` or quantised to 16
//! bits.
//!
//! A tree has its own copy of the corners: blocks of 320 bytes hold up to eight triangles, 40 bytes each in full ones,
//! and nodes of 256 bytes have up to eight blocks or nodes. `Bvh::statistics` gives a tree's total memory. No further
//! copy is needed: trees are built from and refitted to a [`Mesh`] in place, one triangle at a time.
//!
//! ```
//! # #[cfg(feature = "alloc")] {
//! use halfdome_kernel::mesh::{IndexedMesh, Indices, Positions};
//! use halfdome_kernel::{Bvh, BuildOptions};
//!
//! let vertices: [[f32; 8]; 3] = [[0.0; 8], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]];
//! let positions = Positions::f32(bytemuck::cast_slice(&vertices), 0, 32)?;
//! let mesh = IndexedMesh::new(positions, Indices::U16(&[0, 1, 2]))?;
//! let (tree, _) = Bvh::build_mesh(&mesh, &BuildOptions::default())?;
//! # }
//! # Ok::<(), halfdome_kernel::Error>(())
//! ```

mod indexed;
mod positions;
#[cfg(test)]
mod tests;

pub use indexed::{IndexedMesh, Indices};
pub use positions::Positions;

use crate::geometry::Triangle;

/// A list of triangles with indices from 0.
pub trait Mesh: Sync {
    /// How many triangles there are.
    fn len(&self) -> usize;

    /// The triangle of this index, which is less than [`len`](Self::len). It must not change between calls.
    fn triangle(&self, prim_id: usize) -> Triangle;

    /// Whether there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Mesh for [Triangle] {
    fn len(&self) -> usize {
        <[Triangle]>::len(self)
    }

    #[inline]
    fn triangle(&self, prim_id: usize) -> Triangle {
        self[prim_id]
    }
}
