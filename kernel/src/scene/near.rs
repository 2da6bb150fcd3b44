//! Proximity queries of scenes: the closest point of the triangles, and all primitives that overlap a box.
//!
//! Triangles are tested in the scene's space: their corners are transformed by the product of all transforms on the
//! path, in `f64`, and rounded once. Boxes of trees are transformed likewise and rounded outwards. Rounding is
//! monotonic, so they enclose their triangles, and culling by boxes loses nothing: the results equal the loops in
//! [`reference`] bit for bit on all instruction sets. For static triangles without a transform they equal
//! [`BvhView::closest_point`](crate::BvhView::closest_point) and
//! [`BvhView::for_each_overlap`](crate::BvhView::for_each_overlap).
//!
//! Nothing here allocates or panics. Walks recurse once a level, with up to 8 KB of stack each.

use core::ops::{ControlFlow, Range};

use glam::Vec3;

use super::object::Target;
use super::space::{Proximity, Space, between, next};
use super::{Item, SceneHit, ScenePoint, SceneView, reference, round};
use crate::bvh::{Child, MAX_STACK, Node, TriangleBlock, WIDTH};
use crate::geometry::closest::{ClosestCandidate, closest_point};
use crate::geometry::moment::Moment;
use crate::geometry::{Aabb, Hit, Triangle, overlaps};
use crate::simd::Level;

impl SceneView<'_> {
    /// The point of the scene's triangles at a time that is closest to `point`, if it is not farther than `radius`.
    /// Only items whose mask has a bit in common with `mask` count; points, curves and custom shapes do not. Of equally
    /// close ones the lowest `item` counts, then the lowest `prim_id`, then the lowest `path`.
    ///
    /// `None` too if `point` is out of the [numeric limits](crate#numeric-limits), `time` is NaN, or `radius` is
    /// negative or NaN; it may be infinite.
    pub fn closest_point(&self, point: Vec3, radius: f32, time: f32, mask: u32) -> Option<ScenePoint> {
        let best = ClosestCandidate::none_within(point, radius)?;
        let mut search = Closest { point, best, place: SceneHit::MISS };
        self.search(&mut search, time, mask);
        let SceneHit { item, depth, path, .. } = search.place;
        search.best.found(point).map(|point| ScenePoint { point, item, depth, path })
    }

    /// Gives `visit` every primitive that [overlaps](overlaps()) a box at a time, once for each path to it and in the
    /// tree's order, until it breaks off; returns whether it did. Hits have a `t` of 0. Touching counts; the box may be
    /// infinite, or a point. Only items whose mask has a bit in common with `mask` count; points, curves and primitives
    /// of custom shapes count with their boxes.
    pub fn for_each_overlap(
        &self,
        aabb: &Aabb,
        time: f32,
        mask: u32,
        mut visit: impl FnMut(&SceneHit) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        if aabb.is_empty() {
            return ControlFlow::Continue(());
        }
        let mut search = Overlapping { aabb, visit: &mut visit, flow: ControlFlow::Continue(()) };
        self.search(&mut search, time, mask);
        search.flow
    }

    fn search(&self, search: &mut impl Proximity, time: f32, mask: u32) {
        // The search itself records whether it was ended early.
        let _ = match self.isa().level() {
            Level::Scalar => reference::search(self, &Space::OWN, (time, mask), (0, 0), search),
            _ => Visit { time, mask, search }.scene(self, &Space::OWN, 0, 0),
        };
    }
}

/// The closest point.
struct Closest {
    point: Vec3,
    best: ClosestCandidate,
    /// The item and path of the closest point.
    place: SceneHit,
}

impl Proximity for Closest {
    /// The distance, squared, computed as that of a triangle is.
    fn measure(&self, aabb: &Aabb) -> f32 {
        let gap = (aabb.min - self.point).max(self.point - aabb.max).max(Vec3::ZERO);
        gap.x * gap.x + gap.y * gap.y + gap.z * gap.z
    }

    fn most(&self) -> f32 {
        self.best.distance2
    }

    fn meet(&mut self, triangle: &Triangle, place: SceneHit) -> ControlFlow<()> {
        let foot = ClosestCandidate { prim_id: place.hit.prim_id, ..closest_point(self.point, triangle) };
        let order = |foot: &ClosestCandidate, place: &SceneHit| (place.item, foot.prim_id, place.path);
        let is_first = || order(&foot, &place) < order(&self.best, &self.place);
        if foot.distance2 < self.best.distance2 || foot.distance2 == self.best.distance2 && is_first() {
            (self.best, self.place) = (foot, place);
        }
        ControlFlow::Continue(())
    }

    fn meet_box(&mut self, _aabb: &Aabb, _place: SceneHit) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// The primitives that overlap a box.
struct Overlapping<'a> {
    aabb: &'a Aabb,
    visit: &'a mut dyn FnMut(&SceneHit) -> ControlFlow<()>,
    flow: ControlFlow<()>,
}

impl Overlapping<'_> {
    fn see(&mut self, mut place: SceneHit) -> ControlFlow<()> {
        place.hit.t = 0.0;
        self.flow = (self.visit)(&place);
        self.flow
    }
}

impl Proximity for Overlapping<'_> {
    fn measure(&self, aabb: &Aabb) -> f32 {
        let meets = aabb.min.cmple(self.aabb.max).all() && self.aabb.min.cmple(aabb.max).all();
        if meets { 0.0 } else { f32::INFINITY }
    }

    fn most(&self) -> f32 {
        0.0
    }

    fn meet(&mut self, triangle: &Triangle, place: SceneHit) -> ControlFlow<()> {
        if overlaps(triangle, self.aabb) { self.see(place) } else { ControlFlow::Continue(()) }
    }

    fn meet_box(&mut self, aabb: &Aabb, place: SceneHit) -> ControlFlow<()> {
        let is_met = !aabb.is_empty() && self.measure(aabb) == 0.0;
        if is_met { self.see(place) } else { ControlFlow::Continue(()) }
    }
}

/// A search on its way through a scene.
struct Visit<'s, Q> {
    time: f32,
    mask: u32,
    search: &'s mut Q,
}

impl<Q: Proximity> Visit<'_, Q> {
    /// Searches a scene that is in a space, the first of whose paths is `first_path`.
    fn scene(&mut self, scene: &SceneView, space: &Space, first_path: u64, depth: u32) -> ControlFlow<()> {
        let tree = scene.tree();
        let Some(moment) = Moment::new(self.time, tree.keys()) else { return ControlFlow::Continue(()) };
        let path = first_path + (scene.paths() - 1);
        let mut walk = Walk::new([tree.nodes(moment.key), tree.nodes(next(moment))], moment.fraction, *space);
        while let Some(contents) = walk.next(self.search) {
            for &index in tree.items().get(contents).unwrap_or(&[]) {
                let Some(part) = scene.parts().get(index as usize) else { continue };
                let Some(item) = scene.items().get(part.item as usize).filter(|item| item.mask & self.mask != 0) else {
                    continue;
                };
                let Some(space) = space.of(&item.placement, self.time) else { continue };
                let hit = Hit { prim_id: part.prim_id, ..Hit::MISS };
                let place = SceneHit { hit, item: part.item, depth, path };
                self.item(item, &space, place, first_path + item.first_path)?;
            }
        }
        ControlFlow::Continue(())
    }

    fn item(&mut self, item: &Item, space: &Space, place: SceneHit, first_path: u64) -> ControlFlow<()> {
        match item.object.target() {
            Target::Nothing => ControlFlow::Continue(()),
            Target::Mesh(tree) => {
                let walk = Walk::new([tree.nodes(); 2], 0.0, *space);
                self.triangles(walk, [tree.blocks(); 2], place)
            }
            Target::Moving(tree) => {
                let Some(moment) = Moment::new(self.time, tree.keys()) else { return ControlFlow::Continue(()) };
                let keys = [moment.key, next(moment)];
                let walk = Walk::new(keys.map(|key| tree.nodes(key)), moment.fraction, *space);
                self.triangles(walk, keys.map(|key| tree.blocks(key)), place)
            }
            Target::Round(tree) => {
                let mut walk = Walk::new([tree.nodes(); 2], 0.0, *space);
                while let Some(contents) = walk.next(self.search) {
                    round::meet(&tree, contents, space, self.search, place)?;
                }
                ControlFlow::Continue(())
            }
            Target::Shape(shape) => self.search.meet_box(&space.aabb(&shape.bounds(place.hit.prim_id)), place),
            Target::Scene(scene) => self.scene(&scene, space, first_path, place.depth + 1),
        }
    }

    /// Tests the triangles that a walk reaches.
    fn triangles(&mut self, mut walk: Walk, blocks: [&[TriangleBlock]; 2], place: SceneHit) -> ControlFlow<()> {
        while let Some(contents) = walk.next(self.search) {
            let [from, to] = blocks.map(|blocks| blocks.get(contents.clone()).unwrap_or(&[]));
            for (from, to) in from.iter().zip(to) {
                for (lane, prim_id) in from.used_lanes() {
                    let corners = between(&from.triangle(lane), &to.triangle(lane), walk.fraction);
                    let hit = Hit { prim_id, ..place.hit };
                    self.search.meet(&walk.space.triangle(&corners), SceneHit { hit, ..place })?;
                }
            }
        }
        ControlFlow::Continue(())
    }
}

/// A walk through a tree, from leaf to leaf, the nearest first.
struct Walk<'a> {
    /// The nodes at two keys, or at one key twice.
    nodes: [&'a [Node]; 2],
    fraction: f32,
    space: Space,
    /// Subtrees to visit, and the measures of their boxes.
    stack: [(u32, f32); MAX_STACK],
    height: usize,
}

impl<'a> Walk<'a> {
    fn new(nodes: [&'a [Node]; 2], fraction: f32, space: Space) -> Self {
        // The root is node 0.
        Self { nodes, fraction, space, stack: [(0, f32::NEG_INFINITY); MAX_STACK], height: 1 }
    }

    /// The contents of the next leaf within the search.
    fn next(&mut self, search: &impl Proximity) -> Option<Range<usize>> {
        while let Some(top) = self.height.checked_sub(1) {
            self.height = top;
            let &(child, measure) = self.stack.get(top)?;
            if measure > search.most() {
                continue;
            }
            if !Child::is_node(child) {
                return Some(Child::leaf_blocks(child));
            }
            self.enter(child as usize, search);
        }
        None
    }

    /// Pushes the children of a node that are within the search, the nearest last.
    fn enter(&mut self, node: usize, search: &impl Proximity) {
        let (Some(from), Some(to)) = (self.nodes[0].get(node), self.nodes[1].get(node)) else { return };
        let moment = Moment { key: 0, fraction: self.fraction };
        let first = self.height;
        for slot in 0..WIDTH {
            let aabb = match self.fraction {
                0.0 => from.aabb(slot),
                _ => moment.aabb(&from.aabb(slot), &to.aabb(slot)),
            };
            // Between boxes of nothing there is none, or a NaN.
            if Child::unpack(from.children[slot]) == Child::Empty {
                continue;
            }
            let measure = search.measure(&self.space.aabb(&aabb));
            if measure > search.most() || self.height >= MAX_STACK {
                continue;
            }
            let mut place = self.height;
            self.height += 1;
            while place > first && self.stack[place - 1].1 < measure {
                self.stack[place] = self.stack[place - 1];
                place -= 1;
            }
            self.stack[place] = (from.children[slot], measure);
        }
    }
}
