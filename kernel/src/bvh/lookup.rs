//! Triangles by their `prim_id`: where they are in a tree's blocks, for trees that hold the only copy, such as loaded
//! ones.

#[cfg(any(feature = "alloc", test))]
use alloc::vec::Vec;

use super::BvhView;
#[cfg(any(feature = "alloc", test))]
use super::WIDTH;
use crate::geometry::Triangle;

impl BvhView<'_> {
    /// The triangle of this `prim_id`; of several the first in the tree. Searches all blocks; for many lookups build a
    /// `TriangleIndex`.
    pub fn triangle(&self, prim_id: u32) -> Option<Triangle> {
        self.blocks().iter().find_map(|block| {
            let (lane, _) = block.used_lanes().find(|&(_, id)| id == prim_id)?;
            Some(block.triangle(lane))
        })
    }
}

/// Where the triangles of a tree are, by `prim_id`: 8 bytes for each. It stays valid when the tree is refitted.
#[cfg(any(feature = "alloc", test))]
#[derive(Clone, Debug)]
pub struct TriangleIndex {
    /// Sorted by `prim_id`; the place is the block times eight, plus the lane.
    places: Vec<(u32, u32)>,
}

#[cfg(any(feature = "alloc", test))]
impl TriangleIndex {
    /// The index of a tree.
    pub fn new(tree: &BvhView) -> Self {
        let lanes = (0..).zip(tree.blocks()).flat_map(|(block, contents)| {
            contents.used_lanes().map(move |(lane, prim_id)| (prim_id, WIDTH as u32 * block + lane as u32))
        });
        let mut places: Vec<_> = lanes.collect();
        places.sort_unstable();
        Self { places }
    }

    /// The triangle of this `prim_id` in `tree`, which is the tree that the index was made of, or a refitted one.
    pub fn triangle(&self, tree: &BvhView, prim_id: u32) -> Option<Triangle> {
        let first = self.places.partition_point(|&(id, _)| id < prim_id);
        let &(found, place) = self.places.get(first)?;
        let block = tree.blocks().get(place as usize / WIDTH)?;
        (found == prim_id).then(|| block.triangle(place as usize % WIDTH))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traverse::tests::{Random, soup};
    use crate::{BuildOptions, Bvh};

    #[test]
    fn triangles_are_found_by_number() {
        let mut random = Random(81);
        let mut triangles = soup(&mut random, 300, 0.4);
        triangles[5] = [glam::Vec3::ONE; 3];
        let (mut tree, _) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
        let index = TriangleIndex::new(&tree.view());
        let check = |tree: &Bvh, triangles: &[Triangle]| {
            for (prim_id, triangle) in (0..).zip(triangles) {
                let expected = (prim_id != 5).then_some(*triangle);
                assert_eq!(tree.view().triangle(prim_id), expected);
                assert_eq!(index.triangle(&tree.view(), prim_id), expected);
            }
            for nobody in [300, crate::Hit::NO_PRIM] {
                assert_eq!((tree.view().triangle(nobody), index.triangle(&tree.view(), nobody)), (None, None));
            }
        };
        check(&tree, &triangles);
        triangles.iter_mut().flatten().for_each(|p| *p *= 2.0);
        tree.refit(&triangles).unwrap();
        check(&tree, &triangles);
        // In another tree there may be less.
        let (other, _) = Bvh::build(&triangles[..3], &BuildOptions::default()).unwrap();
        assert!((0..300).filter(|&id| index.triangle(&other.view(), id).is_some()).count() <= 8);
    }
}
