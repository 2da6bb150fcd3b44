//! Boxes in lanes, one for the ray of each lane.

use super::Aabb;
use crate::simd::{Lanes, Mask, Simd};

/// A box in each lane.
pub(crate) struct BoxLanes<L> {
    min: [L; 3],
    max: [L; 3],
}

impl<L> BoxLanes<L> {
    /// The same box in all lanes.
    #[inline(always)]
    pub(crate) fn splat<const N: usize>(aabb: &Aabb) -> Self
    where
        L: Lanes<N>,
    {
        let Aabb { min, max } = aabb;
        let (min, max) =
            ([L::splat(min.x), L::splat(min.y), L::splat(min.z)], [L::splat(max.x), L::splat(max.y), L::splat(max.z)]);
        Self { min, max }
    }

    /// The lanes whose boxes are not empty.
    #[inline(always)]
    pub(super) fn not_empty<const N: usize>(&self) -> u32
    where
        L: Lanes<N>,
    {
        let [[ax, ay, az], [bx, by, bz]] = [self.min, self.max];
        (ax.le(bx) & ay.le(by) & az.le(bz)).bits()
    }

    /// How far the boxes reach from origins along each axis.
    #[inline(always)]
    pub(crate) fn reach<const N: usize>(&self, o: &[L; 3]) -> [L; 3]
    where
        L: Lanes<N>,
    {
        let [[ax, ay, az], [bx, by, bz]] = [self.min, self.max];
        [reach(o[0], ax, bx), reach(o[1], ay, by), reach(o[2], az, bz)]
    }
}

#[inline(always)]
fn reach<const N: usize, L: Lanes<N>>(o: L, min: L, max: L) -> L {
    (min - o).abs().max((max - o).abs())
}

impl<L: Lanes<8>> BoxLanes<L> {
    /// The boxes from rows of a lower and an upper corner; the fourth and the last word of a row are ignored.
    #[inline(always)]
    pub(crate) fn from_rows<S: Simd<F8 = L>>(rows: [L; 8]) -> Self {
        let [ax, ay, az, _, bx, by, bz, _] = S::transpose(rows);
        Self { min: [ax, ay, az], max: [bx, by, bz] }
    }
}
