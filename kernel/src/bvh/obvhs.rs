//! Builds a binary tree with the crate obvhs: PLOC (Meister and Bittner 2018), then parallel reinsertion (Meister and
//! Bittner 2018), both as that crate has them.

use alloc::vec::Vec;

use obvhs::Boundable;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use super::binary::{BinaryNode, BinaryTree};
use crate::geometry::Aabb;

struct Bounds(obvhs::aabb::Aabb);

impl Boundable for Bounds {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        self.0
    }
}

/// Builds a tree over the boxes of `prim_ids`, one primitive a leaf; `prim_ids` is not empty.
///
/// Primitives with equal boxes go in as one: among equal costs the search of the reinsertion cannot prune, and 100,000
/// copies of a triangle take it minutes.
pub(super) fn build(aabbs: &[Aabb], mut prim_ids: Vec<u32>) -> BinaryTree {
    let aabb = |id: u32| &aabbs[id as usize];
    prim_ids.sort_unstable_by_key(|&id| {
        (aabb(id).min.to_array().map(f32::to_bits), aabb(id).max.to_array().map(f32::to_bits), id)
    });
    let groups: Vec<&[u32]> = prim_ids.chunk_by(|&a, &b| aabb(a) == aabb(b)).collect();
    let bounds = groups.iter().map(|group| {
        let aabb = aabb(group[0]);
        Bounds(obvhs::aabb::Aabb::new(aabb.min.into(), aabb.max.into()))
    });
    let bounds: Vec<Bounds> = bounds.collect();
    let numbers = (0..groups.len() as u32).collect();
    let search = PlocSearchDistance::Medium;
    let mut tree = PlocBuilder::with_capacity(groups.len()).build(search, &bounds, numbers, SortPrecision::U128, 1);
    ReinsertionOptimizer::default().run(&mut tree, 1.0, None);

    let mut out = BinaryTree { nodes: Vec::with_capacity(2 * prim_ids.len()), prim_ids: Vec::new() };
    out.nodes.extend(tree.nodes.iter().map(|node| BinaryNode {
        aabb: Aabb { min: node.aabb.min.into(), max: node.aabb.max.into() },
        first: node.first_index,
        count: node.prim_count,
    }));
    for leaf in 0..out.nodes.len() {
        if out.nodes[leaf].is_leaf() {
            let group = groups[tree.primitive_indices[out.nodes[leaf].first as usize] as usize];
            out.nodes[leaf].first = out.prim_ids.len() as u32;
            out.nodes[leaf].count = group.len() as u32;
            out.prim_ids.extend_from_slice(group);
            out.halve(leaf);
        }
    }
    out
}
