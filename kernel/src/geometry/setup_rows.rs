//! Setups of eight rays as rows, one for each ray, and the classes of the rays' directions.

use super::setup::Axis;
#[cfg(doc)]
use super::setup::{Line, Slabs};
use crate::simd::{Lanes, Simd};

/// The classes of eight rays' directions: octants and fastest axes.
#[derive(Clone, Copy)]
pub(crate) struct DirectionClasses {
    pub(super) fastest: [u32; 2],
    pub(super) negative: [u32; 3],
}

impl DirectionClasses {
    /// The axis along which the ray of `lane` runs fastest: 0 to 2.
    #[inline(always)]
    pub(crate) fn fastest(&self, lane: usize) -> usize {
        let (x, y) = (self.fastest[0] >> lane & 1, self.fastest[1] >> lane & 1);
        // Without a branch, which would be unpredictable.
        ((1 - x) * (2 - y)) as usize
    }

    /// The rows of a node that hold near planes along x, y and z.
    #[inline(always)]
    pub(crate) fn near_rows(&self, lane: usize) -> [u8; 3] {
        let [x, y, z] = self.negative.map(|negative| (negative >> lane & 1) as u8);
        [x, 2 + y, 4 + z]
    }

    /// Where in a block the coordinates of the first corners begin, in the order of the line's axes.
    #[inline(always)]
    pub(crate) fn corner_offsets(&self, lane: usize) -> [u8; 3] {
        const OFFSETS: [[u8; 3]; 4] = [[8, 16, 0], [16, 0, 8], [0, 8, 16], [0; 3]];
        OFFSETS[self.fastest(lane) % 4]
    }

    /// As [`Slabs::octant`].
    #[inline(always)]
    pub(crate) fn octant(&self, lane: usize) -> u8 {
        let [x, y, z] = self.negative;
        (x >> lane & 1 | (y >> lane & 1) << 1 | (z >> lane & 1) << 2) as u8
    }
}

/// Eight setups, one after the other.
pub(crate) struct SetupRows {
    /// [`Line::numbers`].
    pub lines: [[f32; 8]; 8],
    /// [`Slabs::inverse`] and `near_shift`, then the rays' intervals.
    pub slabs: [[f32; 8]; 8],
    pub(super) far_shifts: [[f32; 8]; 8],
    pub classes: DirectionClasses,
}

impl SetupRows {
    /// [`Slabs::far_shift`].
    #[inline(always)]
    pub(crate) fn far_shift(&self, lane: usize) -> [f32; 3] {
        let [x, y, z, ..] = self.far_shifts[lane];
        [x, y, z]
    }
}

/// The orders of [`Line::axes`] for rays that run fastest along x, y or z, whether forward or backward: that only
/// mirrors the triangles, and no hit changes, but front and back change places.
pub(crate) const FORWARD: [[Axis; 3]; 3] =
    [Axis::permutation(0, false), Axis::permutation(1, false), Axis::permutation(2, false)];

/// Eight rows of lanes, transposed and stored.
#[inline(always)]
pub(crate) fn rows<S: Simd>(lanes: [S::F8; 8]) -> [[f32; 8]; 8] {
    let [a, b, c, d, e, f, g, h] = S::transpose(lanes);
    [a.store(), b.store(), c.store(), d.store(), e.store(), f.store(), g.store(), h.store()]
}
