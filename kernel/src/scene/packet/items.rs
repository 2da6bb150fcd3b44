//! A packet at the items in a scene's tree.

use super::super::object::Target;
use super::super::{Item, SceneHit, SceneView};
use super::entering::{EnterMesh, Entering};
use super::visit::{EnterScene, PacketVisit, Traced};
use crate::bvh::{BvhView, Child, Node};
use crate::geometry::Hit;
use crate::geometry::moment::Moment;
use crate::simd::{Lanes, Simd};
use crate::traverse::Width;
use crate::traverse::node_test::prefetch_of;
use crate::traverse::packet::{CoherentPacket, PacketTree, TracePacket};
use crate::traverse::single::moving::node_between;

/// Fewer rays meet an item one by one: the setup of a packet would take longer than it saves. Packets of four are set
/// up if they are whole.
const FEW: u32 = 6;

/// Up to this many scenes, one nested in another, packets of sixteen are traced together, and from there ray by ray:
/// more of their stack frames, and that of the triangles, would not fit into 32 KiB.
const DEEPEST: u32 = 1;

/// The items of a scene at a moment.
pub(super) struct Items<'v, 'a, 's, const ANY: bool, const N: usize> {
    visit: &'v mut PacketVisit<'a, 's, ANY, N>,
    nodes: &'a [Node],
    /// Those at the next key.
    later: &'a [Node],
    fraction: f32,
    /// That of all rays, if the scene's tree has more than one key: otherwise no item moves.
    time: f32,
}

impl<'v, 'a, 's, const ANY: bool, const N: usize> Items<'v, 'a, 's, ANY, N> {
    #[inline(always)]
    pub(super) fn new(visit: &'v mut PacketVisit<'a, 's, ANY, N>, time: f32, Moment { key, fraction }: Moment) -> Self {
        let tree = visit.scene.tree();
        let (nodes, later) = (tree.nodes(key), if fraction == 0.0 { &[] } else { tree.nodes(key + 1) });
        Self { visit, nodes, later, fraction, time }
    }
}

impl<const ANY: bool, const N: usize, L: Lanes<N>> PacketTree<N, L> for Items<'_, '_, '_, ANY, N>
where
    Width<N>: TracePacket<N>,
{
    const IS_EXPENSIVE: bool = true;

    #[inline(always)]
    fn node<'n, S: Simd>(&'n self, index: u32, room: &'n mut Node) -> Option<&'n Node> {
        let node = self.nodes.get(index as usize)?;
        if self.fraction == 0.0 {
            return Some(node);
        }
        *room = node_between::<S>(node, self.later.get(index as usize)?, self.fraction);
        Some(room)
    }

    #[inline(always)]
    fn prefetch<S: Simd>(&self, child: u32) {
        prefetch_of::<S>(self.nodes, &[], child);
    }

    #[inline(always)]
    fn t_max(&self) -> &[f32; N] {
        &self.visit.best.hits.t
    }

    #[inline(always)]
    fn visit_leaf<S: Simd>(&mut self, _packet: &CoherentPacket<N, L>, leaf: u32, rays: u32, _left: f32) -> u32 {
        let mut found = 0;
        for &index in self.visit.scene.tree().items().get(Child::leaf_blocks(leaf)).unwrap_or(&[]) {
            found |= self.meet(index, if ANY { rays & !found } else { rays });
        }
        found
    }
}

impl<const ANY: bool, const N: usize> Items<'_, '_, '_, ANY, N>
where
    Width<N>: TracePacket<N>,
{
    /// Traces rays through the entry with the box of this index. Gives those that found a better hit.
    #[inline(always)]
    fn meet(&mut self, index: u32, rays: u32) -> u32 {
        let Some((part, item)) = self.visit.scene.item_of(index) else { return 0 };
        let mut seeing = 0;
        for (lane, mask) in self.visit.mask.iter().enumerate() {
            seeing |= u32::from(item.mask & mask != 0) << lane;
        }
        let rays = rays & seeing;
        if rays.count_ones() < FEW.min(N as u32) {
            return self.visit.one_by_one(rays, Some(index));
        }
        match item.object.target() {
            Target::Mesh(tree) => self.meet_mesh(&tree, item, part.item, rays),
            Target::Moving(tree) => match Moment::new(self.time, tree.keys()) {
                Some(Moment { key, fraction: 0.0 }) => self.meet_mesh(&tree.at_key(key), item, part.item, rays),
                _ => self.visit.one_by_one(rays, Some(index)),
            },
            Target::Scene(inner) if N <= 8 || self.visit.depth < DEEPEST => self.meet_scene(&inner, item, index, rays),
            _ => self.visit.one_by_one(rays, Some(index)),
        }
    }

    /// Rays meet an item of triangles.
    #[inline(always)]
    fn meet_mesh(&mut self, tree: &BvhView, item: &Item, index: u32, rays: u32) -> u32 {
        let PacketVisit { scene, isa, first_path, depth, .. } = *self.visit;
        let common = SceneHit { hit: Hit::MISS, item: index, depth, path: first_path + (scene.paths() - 1) };
        Width::<N>::run(isa, EnterMesh::<ANY, N> { tree, entering: self.entering(item, rays), common })
    }

    /// Rays enter a nested scene: the recursive call.
    #[inline(always)]
    fn meet_scene(&mut self, scene: &SceneView, item: &Item, index: u32, rays: u32) -> u32 {
        let PacketVisit { isa, time, mask, first_path, depth, .. } = *self.visit;
        let (first_path, depth, entering) = (first_path + item.first_path, depth + 1, self.entering(item, rays));
        let enter = EnterScene::<ANY, N> { scene, isa, entering, time, mask, first_path, depth };
        let Traced { found, left } = Width::<N>::run(isa, enter);
        found | self.visit.one_by_one(left, Some(index))
    }

    #[inline(always)]
    fn entering<'i>(&'i mut self, item: &'i Item, active: u32) -> Entering<'i, 'i, N> {
        let PacketVisit { rays, best, .. } = &mut *self.visit;
        Entering { placement: &item.placement, rays, active, time: self.time, best }
    }
}
