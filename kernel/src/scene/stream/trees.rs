//! The trees that the rays of a stream are in, one for each place: the scene's own, or that of an item, at a key or on
//! the way from one key to the next.

use super::super::SceneView;
use super::super::object::{Object, Target};
use super::ACTIVE;
use crate::bvh::{Child, Node, TriangleBlock};
use crate::geometry::Aabb;
use crate::geometry::moment::Moment;
use crate::simd::Simd;
use crate::traverse::node_test::prefetch_of;
use crate::traverse::stream::Trees;

/// A tree at a key. The scene's own has no blocks.
#[derive(Clone, Copy)]
pub(super) struct AtKey<'a> {
    nodes: &'a [Node],
    blocks: &'a [TriangleBlock],
}

impl AtKey<'_> {
    pub(super) const NONE: Self = Self { nodes: &[], blocks: &[] };
}

/// Triangles where they are at a time: those at a key, and if it is between two keys, how far it is to the next.
#[derive(Clone, Copy)]
pub(super) struct MeshAt<'a> {
    from: AtKey<'a>,
    to: AtKey<'a>,
    fraction: f32,
    pub(super) bounds: Aabb,
}

impl<'a> MeshAt<'a> {
    pub(super) const NONE: Self = Self { from: AtKey::NONE, to: AtKey::NONE, fraction: 0.0, bounds: Aabb::EMPTY };

    /// `None` if the object is something else than triangles.
    #[inline(always)]
    pub(super) fn new(object: &'a Object<'a>, time: f32) -> Option<Self> {
        match object.target() {
            Target::Mesh(tree) => {
                let from = AtKey { nodes: tree.nodes(), blocks: tree.blocks() };
                Some(Self { from, to: AtKey::NONE, fraction: 0.0, bounds: tree.bounds() })
            }
            Target::Moving(tree) => {
                let Moment { key, fraction } = Moment::new(time, tree.keys())?;
                let at = |key: usize| AtKey { nodes: tree.nodes(key), blocks: tree.blocks(key) };
                let still = fraction == 0.0;
                let bounds = if still { tree.at_key(key).bounds() } else { tree.bounds() };
                Some(Self { from: at(key), to: if still { AtKey::NONE } else { at(key + 1) }, fraction, bounds })
            }
            _ => None,
        }
    }
}

/// For each place the tree that its ray is in.
pub(super) struct PlaceTrees<'a> {
    scene: &'a SceneView<'a>,
    from: [AtKey<'a>; ACTIVE],
    /// Of places that `moving` names.
    to: [AtKey<'a>; ACTIVE],
    fractions: [f32; ACTIVE],
    items: [u32; ACTIVE],
    /// A bit for each place whose ray is in an item.
    pub(super) inside: u64,
    /// A bit for each place whose tree is between two keys.
    pub(super) moving: u64,
}

impl Trees for PlaceTrees<'_> {
    #[inline(always)]
    fn nodes(&self, place: usize) -> &[Node] {
        self.from[place % ACTIVE].nodes
    }

    #[inline(always)]
    fn blocks(&self, place: usize) -> &[TriangleBlock] {
        self.from[place % ACTIVE].blocks
    }
}

impl<'a> PlaceTrees<'a> {
    /// All places are in the scene's own tree, at the first key.
    #[inline(always)]
    pub(super) fn new(scene: &'a SceneView<'a>) -> Self {
        let from = AtKey { nodes: scene.tree().nodes(0), blocks: &[] };
        Self {
            scene,
            from: [from; ACTIVE],
            to: [AtKey::NONE; ACTIVE],
            fractions: [0.0; ACTIVE],
            items: [0; ACTIVE],
            inside: 0,
            moving: 0,
        }
    }

    /// The ray at a place is in the scene's own tree at this time; no longer in an item.
    #[inline(always)]
    pub(super) fn enter_scene(&mut self, place: usize, time: f32) {
        self.inside &= !(1 << place);
        self.moving &= !(1 << place);
        let tree = self.scene.tree();
        let at = |key: usize| AtKey { nodes: tree.nodes(key), blocks: &[] };
        let mut key = 0;
        if tree.keys() > 1
            && let Some(moment) = Moment::new(time, tree.keys())
        {
            key = moment.key;
            if moment.fraction != 0.0 {
                self.move_between(place, at(key + 1), moment.fraction);
            }
        }
        self.from[place % ACTIVE] = at(key);
    }

    /// The ray at a place is in an item.
    #[inline(always)]
    pub(super) fn enter_item(&mut self, place: usize, item: u32, mesh: &MeshAt<'a>) {
        self.inside |= 1 << place;
        self.moving &= !(1 << place);
        self.items[place % ACTIVE] = item;
        self.from[place % ACTIVE] = mesh.from;
        if mesh.fraction != 0.0 {
            self.move_between(place, mesh.to, mesh.fraction);
        }
    }

    #[inline(always)]
    fn move_between(&mut self, place: usize, to: AtKey<'a>, fraction: f32) {
        self.moving |= 1 << place;
        self.to[place % ACTIVE] = to;
        self.fractions[place % ACTIVE] = fraction;
    }

    /// The item that the ray at a place is in.
    #[inline(always)]
    pub(super) fn item(&self, place: usize) -> u32 {
        self.items[place % ACTIVE]
    }

    /// A node at the key before and at the key after, and how far it is to the latter.
    #[inline(always)]
    pub(super) fn moving_node(&self, place: usize, node: u32) -> Option<(&'a Node, &'a Node, f32)> {
        let (from, to) = (&self.from[place % ACTIVE], &self.to[place % ACTIVE]);
        Some((from.nodes.get(node as usize)?, to.nodes.get(node as usize)?, self.fractions[place % ACTIVE]))
    }

    /// Likewise the first block of a leaf.
    #[inline(always)]
    pub(super) fn moving_block(&self, place: usize, leaf: u32) -> Option<(&'a TriangleBlock, &'a TriangleBlock, f32)> {
        let (from, to) = (&self.from[place % ACTIVE], &self.to[place % ACTIVE]);
        let block = Child::first_block(leaf) as usize;
        Some((from.blocks.get(block)?, to.blocks.get(block)?, self.fractions[place % ACTIVE]))
    }

    /// Prefetches what the ray at a place visits next, at the key after.
    #[inline(always)]
    pub(super) fn prefetch_later<S: Simd>(&self, place: usize, next: u32) {
        let AtKey { nodes, blocks } = self.to[place % ACTIVE];
        prefetch_of::<S>(nodes, blocks, next);
    }
}
