//! Triangles as others keep them: indexed, with positions in vertex buffers of any stride, as `f32` or quantised to 16 bits.
//!
//! A tree has its own copy of the corners: blocks of 320 bytes hold up to eight triangles, 40 bytes each in full ones, and
//! nodes of 256 bytes have up to eight blocks or nodes. `Bvh::statistics` says what a tree takes in all. What is avoided is
//! the copy before it: trees are built from and refitted to a [`Mesh`] as it lies, one triangle at a time.
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

/// Triangles that are numbered from 0.
pub trait Mesh: Sync {
    /// How many triangles there are.
    fn len(&self) -> usize;

    /// The triangle of this number, which is less than [`len`](Self::len). Always the same one.
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
