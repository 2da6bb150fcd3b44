//! Triangles by three indices each.

use super::{Mesh, Positions};
use crate::error::InvalidMesh;
use crate::geometry::Triangle;

/// The vertex indices of the triangles' corners, three a triangle.
#[derive(Clone, Copy, Debug)]
pub enum Indices<'a> {
    /// 16 bits each.
    U16(&'a [u16]),
    /// 32 bits each.
    U32(&'a [u32]),
    /// Every three vertices in their order.
    InOrder,
}

/// Triangles whose corners are named by indices.
#[derive(Clone, Copy, Debug)]
pub struct IndexedMesh<'a> {
    positions: Positions<'a>,
    indices: Indices<'a>,
    len: usize,
}

impl<'a> IndexedMesh<'a> {
    /// Checks all indices once.
    ///
    /// # Errors
    /// [`InvalidMesh::IncompleteTriangle`] if the indices, or without them the positions, are not a multiple of 3, and
    /// [`InvalidMesh::IndexOutOfRange`].
    pub fn new(positions: impl Into<Positions<'a>>, indices: Indices<'a>) -> Result<Self, InvalidMesh> {
        let positions = positions.into();
        let count = positions.len();
        let out_of_range = |place: usize, index: u32| InvalidMesh::IndexOutOfRange { place, index, count };
        let len = match indices {
            Indices::U16(indices) => {
                let bad = indices.iter().position(|&index| usize::from(index) >= count);
                bad.map_or(Ok(indices.len()), |place| Err(out_of_range(place, indices[place].into())))
            }
            Indices::U32(indices) => {
                let bad = indices.iter().position(|&index| index as usize >= count);
                bad.map_or(Ok(indices.len()), |place| Err(out_of_range(place, indices[place])))
            }
            Indices::InOrder => Ok(count),
        }?;
        if !len.is_multiple_of(3) {
            return Err(InvalidMesh::IncompleteTriangle { count: len });
        }
        Ok(Self { positions, indices, len: len / 3 })
    }

    /// The positions.
    pub fn positions(&self) -> &Positions<'a> {
        &self.positions
    }
}

impl Mesh for IndexedMesh<'_> {
    fn len(&self) -> usize {
        self.len
    }

    #[inline]
    fn triangle(&self, prim_id: usize) -> Triangle {
        let first = 3 * prim_id;
        let corners = match self.indices {
            Indices::U16(indices) => [0, 1, 2].map(|k| usize::from(indices[first + k])),
            Indices::U32(indices) => [0, 1, 2].map(|k| indices[first + k] as usize),
            Indices::InOrder => [first, first + 1, first + 2],
        };
        corners.map(|vertex| self.positions.get(vertex))
    }
}
