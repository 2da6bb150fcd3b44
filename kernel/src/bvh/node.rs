//! The tree in memory: plain arrays of numbers, traced in place.

use core::ops::Range;

use bytemuck::{Pod, Zeroable};

use crate::geometry::{Aabb, Hit, Triangle};
#[cfg(any(feature = "alloc", test))]
use crate::mesh::Mesh;

/// Children a node, and triangles a block.
pub const WIDTH: usize = 8;

/// The greatest number of entries of a traversal's stack. A tree that could need more is refused.
pub const MAX_STACK: usize = 192;

/// Eight boxes and their contents: four cache lines.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Node {
    /// `planes[axis][side][slot]`: the boxes' lower (side 0) and upper (side 1) bounds. An empty slot's box is inside
    /// out (`+∞ … -∞`).
    pub planes: [[[f32; WIDTH]; 2]; 3],
    /// The contents, as [`Child::pack`] encodes them.
    pub children: [u32; WIDTH],
    /// For each octant of directions the slots from the farthest child to the nearest, three bits a slot, the first one
    /// lowest; see [`Node::sort`].
    pub order: [u32; WIDTH],
}

/// Eight triangles: five cache lines.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct TriangleBlock {
    /// `corners[corner][axis][lane]`; NaN in unused lanes, which no test passes.
    pub corners: [[[f32; WIDTH]; 3]; 3],
    /// The triangles' indices; [`Hit::NO_PRIM`] in unused lanes.
    pub prim_id: [u32; WIDTH],
}

/// What is in a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    /// Nothing.
    Empty,
    /// The node of this index.
    Node(u32),
    /// `count` blocks from `first` on; 1 to [`Child::MAX_BLOCKS`].
    Leaf {
        /// Index of the first block.
        first: u32,
        /// Number of blocks.
        count: u32,
    },
}

impl Child {
    /// The greatest number of blocks in a leaf.
    pub const MAX_BLOCKS: u32 = 1 << 5;
    /// Blocks and nodes have smaller indices than this.
    pub const MAX_INDEX: u32 = 1 << 26;

    const LEAF: u32 = 1 << 31;
    const EMPTY: u32 = u32::MAX;

    /// Bit 31: leaf; bits 26 to 30: its number of blocks, less one; bits 0 to 25: index of its first block. A node is
    /// its index; all bits set are nothing.
    ///
    /// # Panics
    /// If an index is not less than [`MAX_INDEX`](Self::MAX_INDEX), or a count not 1 to
    /// [`MAX_BLOCKS`](Self::MAX_BLOCKS).
    pub fn pack(self) -> u32 {
        let in_range = match self {
            Self::Empty => true,
            Self::Node(index) => index < Self::MAX_INDEX,
            Self::Leaf { first, count } => first < Self::MAX_INDEX && (1..=Self::MAX_BLOCKS).contains(&count),
        };
        assert!(in_range, "{self:?} cannot be packed");
        match self {
            Self::Empty => Self::EMPTY,
            Self::Node(index) => index,
            Self::Leaf { first, count } => Self::LEAF | (count - 1) << 26 | first,
        }
    }

    /// Whether packed bits stand for a node.
    #[inline(always)]
    pub(crate) fn is_node(bits: u32) -> bool {
        bits & Self::LEAF == 0
    }

    /// The blocks of a packed leaf; of an empty slot, a range that no tree has.
    #[inline(always)]
    pub(crate) fn leaf_blocks(bits: u32) -> Range<usize> {
        let first = (bits & (Self::MAX_INDEX - 1)) as usize;
        first..first + (bits >> 26 & (Self::MAX_BLOCKS - 1)) as usize + 1
    }

    /// The first block of a packed leaf.
    #[inline(always)]
    pub(crate) fn first_block(bits: u32) -> u32 {
        bits & (Self::MAX_INDEX - 1)
    }

    /// Whether a packed leaf has more blocks than one.
    #[inline(always)]
    pub(crate) fn has_more_blocks(bits: u32) -> bool {
        bits >> 26 & (Self::MAX_BLOCKS - 1) != 0
    }

    /// A packed leaf of several blocks without its first one.
    #[inline(always)]
    pub(crate) fn without_first_block(bits: u32) -> u32 {
        bits.wrapping_sub(1 << 26).wrapping_add(1)
    }

    /// The inverse of [`pack`](Self::pack).
    #[inline(always)]
    pub fn unpack(bits: u32) -> Self {
        match bits {
            Self::EMPTY => Self::Empty,
            _ if bits & Self::LEAF == 0 => Self::Node(bits),
            _ => Self::Leaf { first: bits & (Self::MAX_INDEX - 1), count: (bits >> 26 & (Self::MAX_BLOCKS - 1)) + 1 },
        }
    }
}

/// The slots from 0 to 7, three bits each.
pub(crate) const SLOTS_IN_ORDER: u32 = 0o76543210;

impl Node {
    /// A node without children.
    pub const EMPTY: Self = Self {
        planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
        children: [Child::EMPTY; WIDTH],
        order: [SLOTS_IN_ORDER; WIDTH],
    };

    /// Puts `child` with its box into `slot`, which is less than [`WIDTH`]; panics like [`Child::pack`].
    pub fn set(&mut self, slot: usize, aabb: &Aabb, child: Child) {
        for axis in 0..3 {
            self.planes[axis][0][slot] = aabb.min[axis];
            self.planes[axis][1][slot] = aabb.max[axis];
        }
        self.children[slot] = child.pack();
    }

    /// Sets the orders: children by the projection of their boxes' centres onto the octant's diagonal. In octant `o`,
    /// bit `a` of `o` says that directions are negative along axis `a`.
    pub fn sort(&mut self) {
        for octant in 0..WIDTH {
            let sign = |axis: usize| if octant >> axis & 1 == 1 { -1.0 } else { 1.0 };
            let depth: [f32; WIDTH] = core::array::from_fn(|slot| match self.aabb(slot) {
                aabb if aabb.is_empty() => f32::INFINITY,
                aabb => (0..3).map(|axis| sign(axis) * (aabb.min[axis] + aabb.max[axis])).sum(),
            });
            let mut slots: [u32; WIDTH] = core::array::from_fn(|slot| slot as u32);
            slots.sort_unstable_by(|&a, &b| depth[b as usize].total_cmp(&depth[a as usize]).then(a.cmp(&b)));
            self.order[octant] = slots.iter().rev().fold(0, |order, slot| order << 3 | slot);
        }
    }

    /// Whether each of the orders names every slot once.
    pub(super) fn orders_are_permutations(&self) -> bool {
        let slots = |order: u32| (0..WIDTH).fold(0u32, |slots, i| slots | 1 << (order >> (3 * i) & 7));
        self.order.iter().all(|&order| order >> 24 == 0 && slots(order) == 0xff)
    }

    /// The box of `slot`, which is less than [`WIDTH`].
    pub fn aabb(&self, slot: usize) -> Aabb {
        let corner = |side: usize| {
            let [x, y, z] = core::array::from_fn(|axis| self.planes[axis][side][slot]);
            glam::Vec3::new(x, y, z)
        };
        Aabb { min: corner(0), max: corner(1) }
    }

    /// The box around all children.
    pub fn bounds(&self) -> Aabb {
        (0..WIDTH).fold(Aabb::EMPTY, |bounds, slot| bounds.union(&self.aabb(slot)))
    }
}

impl TriangleBlock {
    /// A block without triangles.
    pub const EMPTY: Self = Self { corners: [[[f32::NAN; WIDTH]; 3]; 3], prim_id: [Hit::NO_PRIM; WIDTH] };

    /// Puts a triangle into `lane`, which is less than [`WIDTH`].
    pub fn set(&mut self, lane: usize, triangle: &Triangle, prim_id: u32) {
        for (corner, position) in triangle.iter().enumerate() {
            for axis in 0..3 {
                self.corners[corner][axis][lane] = position[axis];
            }
        }
        self.prim_id[lane] = prim_id;
    }

    /// The lanes that hold triangles, with their indices.
    pub(crate) fn used_lanes(&self) -> impl Iterator<Item = (usize, u32)> + use<> {
        self.prim_id.into_iter().enumerate().filter(|&(_, prim_id)| prim_id != Hit::NO_PRIM)
    }

    /// Moves the triangles to their positions in `triangles`, which has all of them.
    #[cfg(any(feature = "alloc", test))]
    pub(super) fn place<M: Mesh + ?Sized>(&mut self, triangles: &M) {
        for (lane, prim_id) in self.used_lanes() {
            self.set(lane, &triangles.triangle(prim_id as usize), prim_id);
        }
    }

    /// The box around the triangles of blocks.
    #[cfg(any(feature = "alloc", test))]
    pub(super) fn bounds_of(blocks: &[Self]) -> Aabb {
        let triangles = blocks.iter().flat_map(|block| block.used_lanes().map(|(lane, _)| block.triangle(lane)));
        triangles.fold(Aabb::EMPTY, |bounds, triangle| bounds.union(&Aabb::around(&triangle)))
    }

    /// The triangle in `lane`, which is less than [`WIDTH`].
    pub fn triangle(&self, lane: usize) -> Triangle {
        self.corners.map(|axes| glam::Vec3::new(axes[0][lane], axes[1][lane], axes[2][lane]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_survive_packing() {
        let leaf = |first, count| Child::Leaf { first, count };
        let last = Child::MAX_INDEX - 1;
        for child in [Child::Empty, Child::Node(0), Child::Node(last), leaf(0, 1), leaf(last, 31), leaf(last - 1, 32)] {
            assert_eq!(Child::unpack(child.pack()), child);
        }
    }

    #[test]
    fn nodes_and_blocks_fill_whole_cache_lines() {
        assert_eq!((size_of::<Node>(), align_of::<Node>()), (256, 64));
        assert_eq!((size_of::<TriangleBlock>(), align_of::<TriangleBlock>()), (320, 64));
    }
}
