//! The data of paths in columns: each field of all paths in a block, side by side.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use halfdome_kernel::columns::{Columns, Row};
use halfdome_kernel::{Isa, Triangle, columns};

use crate::world::InstanceRecord;

/// Paths in a block: few enough for the first-level cache.
pub(in crate::integrator) const LANES: usize = 64;

/// A number of each path.
pub(super) type Column = [f32; LANES];

/// An integer of each path; where it is a truth value, 0 or 1.
pub(super) type Integers = [u32; LANES];

/// A vector of each path.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(in crate::integrator) struct Vectors {
    x: Column,
    y: Column,
    z: Column,
}

/// [`Ray`](halfdome_kernel::Ray)s.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Rays {
    pub origin: Vectors,
    pub t_min: Column,
    pub direction: Vectors,
    pub t_max: Column,
}

/// [`Path`](super::super::state::Path)s.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(in crate::integrator) struct Paths {
    pub index: Integers,
    pub throughput: Vectors,
    pub density: Column,
    pub sky_probability: Column,
    pub normal: Integers,
    pub target: Integers,
}

/// [`TriangleRecord`](crate::world::TriangleRecord)s.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct TriangleColumns {
    pub corners: [Vectors; 3],
    pub normal: Vectors,
    pub offset: Column,
    mesh: Integers,
    pub material: Integers,
    pub is_plain: Integers,
}

/// [`InstanceRecord`](crate::world::InstanceRecord)s.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct InstanceColumns {
    axes: [Vectors; 3],
    translation: Vectors,
    scale: Column,
    error: Column,
    side: Column,
    unused: Integers,
}

/// [`MaterialRecord`](crate::world::MaterialRecord)s.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct MaterialColumns {
    pub diffuse: Vectors,
    pub kind: Integers,
    pub emission: Vectors,
    pub emits_both_sides: Integers,
}

/// [`EmitterRecord`](crate::world::EmitterRecord)s.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct EmitterColumns {
    pub corners: [Vectors; 3],
    pub normal: Vectors,
    pub offset: Column,
    pub emission: Vectors,
    pub area: Column,
    pub emits_both_sides: Integers,
    pub is_plain: Integers,
    unused: [Integers; 5],
}

impl TriangleColumns {
    /// Takes each triangle to where its instance is.
    #[inline(always)]
    pub(super) fn place(&mut self, instances: &InstanceColumns) {
        for i in 0..LANES {
            let record = InstanceRecord {
                axes: [instances.axes[0].get(i), instances.axes[1].get(i), instances.axes[2].get(i)],
                translation: instances.translation.get(i),
                scale: instances.scale[i],
                error: instances.error[i],
                side: instances.side[i],
                unused: 0,
            };
            let (corners, normal, offset) = record.place(&triangle(&self.corners, i), self.offset[i]);
            for (column, corner) in self.corners.iter_mut().zip(corners) {
                column.set(i, corner);
            }
            self.normal.set(i, normal);
            self.offset[i] = offset;
        }
    }
}

impl Vectors {
    #[inline(always)]
    pub(super) fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    #[inline(always)]
    pub(super) fn set(&mut self, i: usize, vector: Vec3) {
        (self.x[i], self.y[i], self.z[i]) = (vector.x, vector.y, vector.z);
    }
}

/// The triangle with these corners of path `i`.
#[inline(always)]
pub(super) fn triangle(corners: &[Vectors; 3], i: usize) -> Triangle {
    let [a, b, c] = corners;
    [a.get(i), b.get(i), c.get(i)]
}

/// Writes the rows of these numbers, of `PARTS` times eight words each, to their columns.
#[inline(always)]
pub(super) fn gather<const PARTS: usize, R: Pod, C: Pod>(isa: Isa, rows: &[R], numbers: &[u32], columns: &mut C) {
    let rows: &[[Row; PARTS]] = bytemuck::cast_slice(rows);
    let columns: &mut [Columns<LANES>; PARTS] = bytemuck::cast_mut(columns);
    columns::load(isa, rows, numbers, columns);
}

/// Writes those of the first columns that `keeps` names to the start of `rows`, of `WIDTH` words each, and gives their
/// number.
#[inline(always)]
pub(super) fn keep<const WIDTH: usize, R: Pod, C: Pod>(isa: Isa, columns: &C, keeps: &[u32], rows: &mut [R]) -> usize {
    let columns: &[[f32; LANES]; WIDTH] = bytemuck::cast_ref(columns);
    let rows: &mut [[f32; WIDTH]] = bytemuck::cast_slice_mut(rows);
    columns::compress(isa, columns, keeps, rows)
}
