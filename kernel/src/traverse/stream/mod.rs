//! A ray stream: up to 64 rays are traced at the same time, in phases: all that visit a node next, then all that visit a block
//! of a leaf, then all triangles whose edges a ray's line passes inside of.
//!
//! What a ray visits next is as good as random, and so is whether its line crosses a triangle: one ray alone pays a
//! mispredicted branch for each. Here a visit puts its ray on the list of the next visit's kind, and nothing branches on
//! it; and each ray prefetches what it visits next a whole round before its turn (what the database people call asynchronous
//! memory access chaining: Kocberber, Falsafi and Grot 2015). Triangles that are crossed are few, and their test is long:
//! they are collected from all rays, and tested eight at a time, each lane with a ray of its own. All rays visit the root
//! first, eight at a time, a lane each.

mod active;
mod candidates;
mod lanes;
pub(super) mod leaf_queues;

use active::{ActiveRay, after_block};
use candidates::Candidates;

use crate::bvh::{BvhView, Child, Node, WIDTH};
use crate::geometry::setup_lanes::SetupLanes;
use crate::geometry::{Hit, Ray};
use crate::simd::{Lanes, Simd};
use crate::traverse::node_test::{intersect_children, prefetch};

/// What a ray visits next when nothing is left: an empty child, which no node pushes.
const NONE: u32 = u32::MAX;

/// Rays that are traced at the same time. Fewer hide less latency; more do not fit into the first-level cache.
pub(super) const MAX_ACTIVE: usize = 64;

/// Gives `write` the number of each ray and its nearest hit, or with `ANY` one that stands for any, in any order.
#[inline(always)]
pub(super) fn trace<const ANY: bool, S: Simd>(tree: &BvhView, rays: &[Ray], mut write: impl FnMut(usize, Hit)) {
    let mut stream = Stream::EMPTY;
    loop {
        stream.start::<ANY, S>(tree, rays);
        let [nodes, leaves, done] = stream.classify::<S>();
        if stream.busy == 0 {
            return;
        }
        stream.visit_nodes::<ANY, S>(nodes, tree, rays);
        stream.visit_leaves::<ANY, S>(leaves, tree);
        for i in rays_of(done) {
            write(stream.active[i].number, stream.active[i].best.or_miss());
        }
        stream.busy &= !done;
    }
}

/// The rays that are traced at the same time.
struct Stream {
    active: [ActiveRay; MAX_ACTIVE],
    /// What each of them visits next.
    next: [u32; MAX_ACTIVE],
    /// A bit for each place that has a ray.
    busy: u64,
    /// Rays that were started, of all in the batch.
    started: usize,
    candidates: Candidates,
}

impl Stream {
    /// All zeros, which are written in place: with anything else a copy would be made on the stack.
    const EMPTY: Self = Self {
        active: [ActiveRay::EMPTY; MAX_ACTIVE],
        next: [0; MAX_ACTIVE],
        busy: 0,
        started: 0,
        candidates: Candidates::EMPTY,
    };

    /// Starts rays, eight at a time, while there are places for so many.
    #[inline(always)]
    fn start<const ANY: bool, S: Simd>(&mut self, tree: &BvhView, rays: &[Ray]) {
        while self.started < rays.len() && self.busy.count_zeros() as usize >= WIDTH {
            self.start_eight::<ANY, S>(tree, rays);
        }
    }

    /// Starts up to eight rays: makes them ready, and tests the root, with a ray in each lane.
    #[inline(always)]
    fn start_eight<const ANY: bool, S: Simd>(&mut self, tree: &BvhView, rays: &[Ray]) {
        let root = tree.nodes().first().unwrap_or(&Node::EMPTY);
        let rays = &rays[self.started..];
        let mut rows = [S::F8::splat(f32::NAN); WIDTH];
        for (row, ray) in rows.iter_mut().zip(rays) {
            *row = S::F8::load(bytemuck::cast_ref(ray));
        }
        let setups = SetupLanes::new(S::transpose(rows), &tree.bounds());
        let (near, far) = intersect_children::<S>(&setups, root);
        let live = setups.live;
        let setups = setups.rows::<S>();
        for (lane, i) in rays_of(!self.busy).enumerate().take(WIDTH.min(rays.len())) {
            let (near, far) = (near[lane], far[lane]);
            let next = self.active[i].start::<ANY, S>(&setups, lane, self.started + lane, root, (near, far));
            // One that can hit nothing is done at once.
            let next = if live >> lane & 1 != 0 { next } else { NONE };
            self.next[i] = next;
            self.busy |= 1 << i;
            prefetch::<S>(tree, next);
        }
        self.started += WIDTH.min(rays.len());
    }

    /// The rays that visit a node next, those that visit a leaf, and those that are done.
    #[inline(always)]
    fn classify<S: Simd>(&self) -> [u64; 3] {
        let (mut leaves, mut done) = (0, 0);
        for (eight, next) in self.next.as_chunks::<WIDTH>().0.iter().enumerate() {
            let [negative, none] = S::classify(next);
            leaves |= u64::from(negative) << (WIDTH * eight);
            done |= u64::from(none) << (WIDTH * eight);
        }
        [!leaves & self.busy, leaves & !done & self.busy, done & self.busy]
    }

    /// Visits the nodes that `rays` visit next.
    #[inline(always)]
    fn visit_nodes<const ANY: bool, S: Simd>(&mut self, visitors: u64, tree: &BvhView, rays: &[Ray]) {
        for i in rays_of(visitors) {
            let Some(node) = tree.nodes().get(self.next[i] as usize) else { continue };
            let ray = &mut self.active[i];
            if !ray.visit_node::<S>(node)
                && let Some(original) = rays.get(ray.number)
            {
                ray.finish(tree, original, ANY);
            }
        }
        // Apart from the visits, whose results take long to arrive.
        for i in rays_of(visitors) {
            let next = self.active[i].pop();
            prefetch::<S>(tree, next);
            self.next[i] = next;
        }
    }

    /// Visits the first blocks of the leaves that `rays` visit next.
    #[inline(always)]
    fn visit_leaves<const ANY: bool, S: Simd>(&mut self, visitors: u64, tree: &BvhView) {
        for i in rays_of(visitors) {
            if self.candidates.is_full() {
                self.candidates.test::<ANY, S>(tree.blocks(), &mut self.active);
            }
            let block = Child::first_block(self.next[i]);
            self.candidates.collect::<S>(&self.active[i], i as u8, block, tree.blocks());
        }
        self.candidates.test::<ANY, S>(tree.blocks(), &mut self.active);
        for i in rays_of(visitors) {
            let next = after_block::<ANY>(self.next[i], &mut self.active[i]);
            prefetch::<S>(tree, next);
            self.next[i] = next;
        }
    }
}

/// The places set in a bit mask, lowest first.
#[inline(always)]
fn rays_of(mut places: u64) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let place = places.trailing_zeros() as usize;
        let is_there = places != 0;
        places &= places.wrapping_sub(1);
        is_there.then_some(place % MAX_ACTIVE)
    })
}
