//! Rays at the leaves of the scene's tree: they enter meshes eight at a time, and other objects one by one.

use super::super::search::Search;
use super::super::walk::{MeetItem, Visit};
use super::super::{SceneHit, SceneRay, SceneView};
use super::entering::Entering;
use super::trees::MeshAt;
use super::{ACTIVE, Answers, SceneStream};
use crate::bvh::Child;
use crate::geometry::Ray;
use crate::simd::{Simd, dispatch};
use crate::traverse::TraversalStack;
use crate::traverse::stream::{NONE, places_of};

impl<'a, A: Answers> SceneStream<'a, A> {
    /// Rays meet the first item of the leaf that they visit next.
    #[inline(always)]
    pub(super) fn meet_items<S: Simd>(&mut self, places: u64) {
        let mut entering = Entering::<S>::none();
        let mut crowded = 0;
        for place in places_of(places) {
            let leaf = self.stream.next(place);
            if Child::has_more_blocks(leaf)
                && !self.stream.active[place % ACTIVE].push(Child::without_first_block(leaf))
            {
                crowded |= 1 << place;
                continue;
            }
            let index = self.scene.tree().items().get(Child::first_block(leaf) as usize).copied().unwrap_or(u32::MAX);
            match self.mesh(index, self.ray(place)) {
                Some((item, mesh, ray)) => {
                    entering.push(place, item, mesh, &ray);
                    if entering.is_full() {
                        crowded |= self.enter::<S>(&entering);
                        entering.clear();
                    }
                }
                None => self.meet_alone::<S>(place, index),
            }
        }
        crowded |= self.enter::<S>(&entering);
        self.finish(crowded);
    }

    /// The item of the box at this index of the tree, if the ray sees it and it is made of triangles: its index, where
    /// the triangles are at the ray's time, and the ray in its space.
    #[inline(always)]
    fn mesh(&self, index: u32, SceneRay { ray, time, mask }: &SceneRay) -> Option<(u32, MeshAt<'a>, Ray)> {
        let (part, item) = self.scene.item_of(index)?;
        if item.mask & mask == 0 {
            return None;
        }
        let mesh = MeshAt::new(&item.object, *time)?;
        Some((part.item, mesh, item.placement.to_local(ray, *time)?))
    }

    /// Moves up to eight rays into items. Returns the places of rays whose stacks are full.
    #[inline(always)]
    fn enter<S: Simd>(&mut self, entering: &Entering<'a, S>) -> u64 {
        let mut crowded = 0;
        if entering.len == 0 {
            return crowded;
        }
        let setups = entering.set_up();
        let live = setups.live;
        let setups = setups.rows::<S>();
        for (lane, (place, item, mesh)) in entering.iter().enumerate() {
            if live >> lane & 1 == 0 {
                self.go_on::<S>(place);
                continue;
            }
            let t_max = self.ray(place).ray.t_max;
            let active = &mut self.stream.active[place % ACTIVE];
            if !active.push(NONE) {
                crowded |= 1 << place;
                continue;
            }
            active.set_up(&setups, lane, A::ANY);
            let common = SceneHit { item, ..self.common };
            active.best = self.answers.to_precede(active.index, t_max, &common);
            self.trees.enter_item(place, item, mesh);
            self.turned &= !(1 << place);
            self.visit_next::<S>(place, Child::Node(0).pack());
        }
        crowded
    }

    /// Tests a ray against the object with the box of this index like a single ray, if its mask allows.
    #[inline(always)]
    fn meet_alone<S: Simd>(&mut self, place: usize, index: u32) {
        let ray = *self.ray(place);
        let is_seen = self.scene.item_of(index).is_some_and(|(_, item)| item.mask & ray.mask != 0);
        if is_seen {
            let active = &mut self.stream.active[place % ACTIVE];
            let mut search = self.answers.search(active.index, ray.ray.t_max);
            meet(self.scene, &ray, index, &mut search);
            if search.t_max() < active.best.t {
                active.best.t = search.t_max();
                active.cull::<S>(search.t_max());
            }
            if self.answers.advance(active.index, search) {
                return self.end(1 << place);
            }
        }
        self.go_on::<S>(place);
    }
}

/// Not inlined, so that its stack frame exists only while it runs.
#[inline(never)]
fn meet<Q: Search>(scene: &SceneView, ray: &SceneRay, index: u32, search: &mut Q) {
    let triangles = &mut TraversalStack::new();
    let visit = Visit { scene, isa: scene.isa(), ray: *ray, first_path: 0, depth: 0, search, triangles };
    dispatch(scene.isa(), MeetItem { visit, index });
}
