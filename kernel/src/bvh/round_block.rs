//! Blocks of points and curves in a tree's leaves: eight primitives as a structure of arrays.

use bytemuck::{Pod, Zeroable};

use super::WIDTH;
use crate::error::InvalidTree;
use crate::geometry::round::{LineTest, RayFrame, RoundPrimitive};
use crate::geometry::{Aabb, CubicCurve, Disc, Hit, LinearCurve, Sphere};

/// Eight primitives of a kind.
pub trait RoundBlock: LaneTest + Pod + Send + Sync {
    /// The kind.
    type Primitive: RoundPrimitive;

    /// A block without primitives.
    const EMPTY: Self;

    /// Puts a primitive into `lane`, which is less than [`WIDTH`].
    fn set(&mut self, lane: usize, primitive: &Self::Primitive, prim_id: u32);

    /// The primitive in `lane`, which is less than [`WIDTH`].
    fn primitive(&self, lane: usize) -> Self::Primitive;

    /// The primitives' indices; [`Hit::NO_PRIM`] in unused lanes.
    fn prim_ids(&self) -> &[u32; WIDTH];
}

/// The test of all lanes of a block.
pub trait LaneTest {
    /// A bit mask of the lanes that the ray may hit, by their margins.
    fn lanes_near(&self, frame: &RayFrame) -> u32;
}

macro_rules! block {
    ($(#[$doc:meta])* $block:ident, $primitive:ident, $numbers:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
        #[repr(C, align(32))]
        pub struct $block {
            /// Each number of the primitive in memory, a lane each; NaN in unused lanes, which no test passes.
            pub numbers: [[f32; WIDTH]; $numbers],
            /// The primitives' indices; [`Hit::NO_PRIM`] in unused lanes.
            pub prim_id: [u32; WIDTH],
        }

        impl RoundBlock for $block {
            type Primitive = $primitive;
            const EMPTY: Self = Self { numbers: [[f32::NAN; WIDTH]; $numbers], prim_id: [Hit::NO_PRIM; WIDTH] };

            fn set(&mut self, lane: usize, primitive: &$primitive, prim_id: u32) {
                let numbers: [f32; $numbers] = bytemuck::cast(*primitive);
                for (row, number) in self.numbers.iter_mut().zip(numbers) {
                    row[lane] = number;
                }
                self.prim_id[lane] = prim_id;
            }

            #[inline(always)]
            fn primitive(&self, lane: usize) -> $primitive {
                let mut numbers = [0.0; $numbers];
                for (number, row) in numbers.iter_mut().zip(&self.numbers) {
                    *number = row[lane];
                }
                bytemuck::cast::<[f32; $numbers], _>(numbers)
            }

            #[inline(always)]
            fn prim_ids(&self) -> &[u32; WIDTH] {
                &self.prim_id
            }
        }

        impl LaneTest for $block {
            #[inline(always)]
            fn lanes_near(&self, frame: &RayFrame) -> u32 {
                let mut margins = [0.0; WIDTH];
                for (lane, margin) in margins.iter_mut().enumerate() {
                    let mut numbers = [0.0; $numbers];
                    for (number, row) in numbers.iter_mut().zip(&self.numbers) {
                        *number = f64::from(row[lane]);
                    }
                    *margin = <$primitive as LineTest>::margin(frame, &numbers);
                }
                let mut near = 0;
                for (lane, &margin) in margins.iter().enumerate() {
                    near |= u32::from(margin >= 0.0) << lane;
                }
                near
            }
        }
    };
}

block!(
    /// Eight spheres: 160 bytes.
    SphereBlock,
    Sphere,
    4
);
block!(
    /// Eight discs: 256 bytes.
    DiscBlock,
    Disc,
    7
);
block!(
    /// Eight round linear curves: 288 bytes.
    LinearCurveBlock,
    LinearCurve,
    8
);
block!(
    /// Eight round cubic curves: 544 bytes.
    CubicCurveBlock,
    CubicCurve,
    16
);

/// The blocks of a tree, all of a kind.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum RoundBlocks<'a> {
    /// Spheres.
    Spheres(&'a [SphereBlock]),
    /// Discs.
    Discs(&'a [DiscBlock]),
    /// Round linear curves.
    LinearCurves(&'a [LinearCurveBlock]),
    /// Round cubic curves.
    CubicCurves(&'a [CubicCurveBlock]),
}

/// Does the same with the slice of blocks, whatever their kind.
macro_rules! with_blocks {
    ($blocks:expr, $slice:ident => $do:expr) => {
        match $blocks {
            $crate::bvh::RoundBlocks::Spheres($slice) => $do,
            $crate::bvh::RoundBlocks::Discs($slice) => $do,
            $crate::bvh::RoundBlocks::LinearCurves($slice) => $do,
            $crate::bvh::RoundBlocks::CubicCurves($slice) => $do,
        }
    };
}
pub(crate) use with_blocks;

impl RoundBlocks<'_> {
    /// The number of blocks.
    pub fn len(&self) -> usize {
        with_blocks!(self, blocks => blocks.len())
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

macro_rules! from {
    ($($block:ident: $kind:ident),*) => {$(
        impl<'a> From<&'a [$block]> for RoundBlocks<'a> {
            fn from(blocks: &'a [$block]) -> Self {
                Self::$kind(blocks)
            }
        }
    )*};
}

from!(SphereBlock: Spheres, DiscBlock: Discs, LinearCurveBlock: LinearCurves, CubicCurveBlock: CubicCurves);

/// The lanes that hold primitives, with their indices.
pub(crate) fn used_lanes<B: RoundBlock>(block: &B) -> impl Iterator<Item = (usize, u32)> + use<'_, B> {
    block.prim_ids().iter().copied().enumerate().filter(|&(_, prim_id)| prim_id != Hit::NO_PRIM)
}

/// The box around a leaf's primitives, of which the first block has this index.
pub(super) fn leaf_bounds<B: RoundBlock>(blocks: &[B], first: u32) -> Result<Aabb, InvalidTree> {
    let mut bounds = Aabb::EMPTY;
    for (index, block) in (first..).zip(blocks) {
        for (lane, &prim_id) in block.prim_ids().iter().enumerate() {
            let primitive = block.primitive(lane);
            let numbers: &[f32] = bytemuck::cast_slice(core::slice::from_ref(&primitive));
            let is_used = prim_id != Hit::NO_PRIM;
            let is_good = if is_used { primitive.fault().is_none() } else { numbers.iter().all(|x| x.is_nan()) };
            if !is_good {
                return Err(InvalidTree::BadPrimitive { block: index, lane: lane as u32 });
            }
            if is_used {
                bounds = bounds.union(&primitive.bounds());
            }
        }
    }
    Ok(bounds)
}
