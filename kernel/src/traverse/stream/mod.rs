//! A ray stream: up to 64 rays are traced at the same time, in phases: all that visit a node next, then all that visit
//! a block of a leaf, then all triangles whose edges a ray's line passes inside of.
//!
//! What a ray visits next is as good as random, and so is whether its line crosses a triangle: one ray alone pays a
//! mispredicted branch for each. Here a visit puts its ray on the list of the next visit's kind, and nothing branches
//! on it; and each ray prefetches what it visits next a whole round before its turn (what the database people call
//! asynchronous memory access chaining: Kocberber, Falsafi and Grot 2015). Triangles that are crossed are few, and
//! their test is long: they are collected from all rays, and tested eight at a time, each lane with a ray of its own.
//! All rays visit the root first, eight at a time, a lane each.

mod active;
mod candidates;
mod lanes;
pub(super) mod leaf_queues;

pub(crate) use active::ActiveRay;
use candidates::Candidates;

use crate::bvh::{BvhView, Child, Node, TriangleBlock, WIDTH};
use crate::geometry::setup_lanes::SetupLanes;
use crate::geometry::setup_rows::SetupRows;
use crate::geometry::{Hit, Ray};
use crate::simd::{Lanes, Simd};
use crate::traverse::node_test::{intersect_children, prefetch_of};
use crate::traverse::single;

/// The visit of a ray when nothing is left: an empty child, which no node pushes.
pub(crate) const NONE: u32 = u32::MAX;

/// Rays that are traced at the same time. Fewer hide less latency; more do not fit into the first-level cache.
const MAX_ACTIVE: usize = 64;

/// Fewer rays are traced one by one: most lanes would be empty, and setting up a stream would take longer than it
/// saves.
pub(crate) const MIN_STREAM_RAYS: usize = 24;

/// The trees that the rays of a stream are in, each at its place.
pub(crate) trait Trees {
    fn nodes(&self, place: usize) -> &[Node];
    fn blocks(&self, place: usize) -> &[TriangleBlock];
}

/// All rays are in the same tree.
impl Trees for BvhView<'_> {
    #[inline(always)]
    fn nodes(&self, _place: usize) -> &[Node] {
        self.nodes()
    }

    #[inline(always)]
    fn blocks(&self, _place: usize) -> &[TriangleBlock] {
        self.blocks()
    }
}

/// Decides which hits of the rays of a stream count.
pub(crate) trait HitFilter {
    /// Whether there is anything to decide.
    const DECIDES: bool;

    /// Whether a hit of the ray of an index counts. It sees those hits that precede the nearest one accepted so far.
    fn accepts(&mut self, ray: usize, hit: &Hit) -> bool;

    /// Finishes the search of the ray of an index, of which `best` has been found so far, from the root.
    fn finish(&mut self, tree: &BvhView, ray: (usize, &Ray), best: Hit, any: bool) -> Hit;
}

/// All hits count.
pub(crate) struct AllHits;

impl HitFilter for AllHits {
    const DECIDES: bool = false;

    #[inline(always)]
    fn accepts(&mut self, _: usize, _: &Hit) -> bool {
        true
    }

    #[inline(always)]
    fn finish(&mut self, tree: &BvhView, (_, ray): (usize, &Ray), best: Hit, any: bool) -> Hit {
        single::finish(tree, ray, best, any)
    }
}

/// Gives `write` the index of each ray and its nearest hit, or with `ANY` one that stands for any, in any order.
#[inline(always)]
pub(super) fn trace<const ANY: bool, S: Simd>(tree: &BvhView, rays: &[Ray], write: impl FnMut(usize, Hit)) {
    trace_filtered::<ANY, S>(tree, rays, AllHits, write);
}

/// The same, of the hits that a filter accepts.
#[inline(always)]
pub(super) fn trace_filtered<const ANY: bool, S: Simd>(
    tree: &BvhView,
    rays: &[Ray],
    mut filter: impl HitFilter,
    mut write: impl FnMut(usize, Hit),
) {
    let mut stream = Stream::<MAX_ACTIVE>::EMPTY;
    let root = tree.nodes().first().unwrap_or(&Node::EMPTY);
    loop {
        while stream.has_room_for_eight(rays.len()) {
            let lanes = ray_lanes::<S>(&rays[stream.started..]);
            stream.start_eight::<ANY, S>(&SetupLanes::new(lanes, &tree.bounds()), rays.len(), root, tree);
        }
        let Next { nodes, leaves, ended } = stream.classify::<S>();
        if stream.busy == 0 {
            return;
        }
        let crowded = stream.visit_nodes::<S>(nodes, tree);
        stream.visit_leaves::<ANY, S>(leaves, tree, &mut filter);
        for place in places_of(ended) {
            write(stream.active[place].index, stream.active[place].best.or_miss());
        }
        for place in places_of(crowded) {
            let ray = &stream.active[place];
            if let Some(original) = rays.get(ray.index) {
                write(ray.index, filter.finish(tree, (ray.index, original), ray.best, ANY).or_miss());
            }
        }
        stream.busy &= !(ended | crowded);
    }
}

/// The numbers of up to eight rays, one in each lane, in the order of [`Ray`]; NaN where there are no more.
#[inline(always)]
fn ray_lanes<S: Simd>(rays: &[Ray]) -> [S::F8; WIDTH] {
    let mut rows = [S::F8::splat(f32::NAN); WIDTH];
    for (row, ray) in rows.iter_mut().zip(rays) {
        *row = S::F8::load(bytemuck::cast_ref(ray));
    }
    S::transpose(rows)
}

/// Up to `N` rays that are traced at the same time, each at a place of its own; `N` is a multiple of eight, and at
/// most 64.
pub(crate) struct Stream<const N: usize> {
    pub(crate) active: [ActiveRay; N],
    /// The next visit of each ray.
    next: [u32; N],
    /// A bit for each place with a ray.
    pub(crate) busy: u64,
    /// Rays that were started, of all in the batch.
    pub(crate) started: usize,
    candidates: Candidates,
}

/// The places of rays by what they visit next.
pub(crate) struct Next {
    pub(crate) nodes: u64,
    pub(crate) leaves: u64,
    /// Nothing: their stack is empty, or only what lies under a [`NONE`] is left.
    pub(crate) ended: u64,
}

impl<const N: usize> Stream<N> {
    /// All zeros, which are written in place: with anything else a copy would be made on the stack.
    pub(crate) const EMPTY: Self =
        Self { active: [ActiveRay::EMPTY; N], next: [0; N], busy: 0, started: 0, candidates: Candidates::EMPTY };

    /// All places.
    const ALL: u64 = u64::MAX >> (64 - N);

    /// Whether there are rays to start, of so many in all, and places for eight.
    #[inline(always)]
    pub(crate) fn has_room_for_eight(&self, rays: usize) -> bool {
        self.started < rays && (Self::ALL & !self.busy).count_ones() as usize >= WIDTH
    }

    /// Starts the next rays of the batch, up to eight, from their setup: tests the root of their tree, with a ray in
    /// each lane. Gives their places.
    #[inline(always)]
    pub(crate) fn start_eight<const ANY: bool, S: Simd>(
        &mut self,
        setups: &SetupLanes<WIDTH, S::F8>,
        rays: usize,
        root: &Node,
        trees: &impl Trees,
    ) -> u64 {
        let (near, far) = intersect_children::<S>(setups, root);
        let live = setups.live;
        let setups: SetupRows = setups.rows::<S>();
        let count = WIDTH.min(rays - self.started);
        let mut places = 0;
        for (lane, i) in places_of(Self::ALL & !self.busy).enumerate().take(count) {
            let i = i % N;
            places |= 1 << i;
            let (near, far) = (near[lane], far[lane]);
            let next = self.active[i].start::<ANY, S>(&setups, lane, self.started + lane, root, (near, far));
            // A ray that can hit nothing is finished at once.
            let next = if live >> lane & 1 != 0 { next } else { NONE };
            self.next[i] = next;
            prefetch_of::<S>(trees.nodes(i), trees.blocks(i), next);
        }
        self.busy |= places;
        self.started += count;
        places
    }

    /// The next visits of the rays.
    #[inline(always)]
    pub(crate) fn classify<S: Simd>(&self) -> Next {
        let (mut leaves, mut ended) = (0, 0);
        for (eight, next) in self.next.as_chunks::<WIDTH>().0.iter().enumerate() {
            let [negative, none] = S::classify(next);
            leaves |= u64::from(negative) << (WIDTH * eight);
            ended |= u64::from(none) << (WIDTH * eight);
        }
        Next { nodes: !leaves & self.busy, leaves: leaves & !ended & self.busy, ended: ended & self.busy }
    }

    /// Visits the nodes that the rays at `visitors` visit next. Returns the places of rays whose stacks are full:
    /// another tracer has to finish them.
    #[inline(always)]
    pub(crate) fn visit_nodes<S: Simd>(&mut self, visitors: u64, trees: &impl Trees) -> u64 {
        let mut crowded = 0;
        for i in places_of(visitors) {
            let i = i % N;
            let Some(node) = trees.nodes(i).get(self.next[i] as usize) else { continue };
            if !self.active[i].visit_node::<S>(node) {
                crowded |= 1 << i;
            }
        }
        // Apart from the visits, whose results take long to arrive.
        for i in places_of(visitors) {
            let next = self.active[i % N].pop();
            self.visit_next::<S>(i, next, trees);
        }
        crowded
    }

    /// The next visit of the ray at a place.
    #[inline(always)]
    pub(crate) fn visit_next<S: Simd>(&mut self, place: usize, next: u32, trees: &impl Trees) {
        prefetch_of::<S>(trees.nodes(place), trees.blocks(place), next);
        self.next[place % N] = next;
    }

    /// The next visit of the ray at a place.
    #[inline(always)]
    pub(crate) fn next(&self, place: usize) -> u32 {
        self.next[place % N]
    }

    /// Visits the first blocks of the leaves that the rays at `visitors` visit next.
    #[inline(always)]
    pub(crate) fn visit_leaves<const ANY: bool, S: Simd>(
        &mut self,
        visitors: u64,
        trees: &impl Trees,
        filter: &mut impl HitFilter,
    ) {
        for i in places_of(visitors) {
            let i = i % N;
            if self.candidates.is_full() {
                self.candidates.test::<ANY, N, S>(trees, &mut self.active, filter);
            }
            let block = Child::first_block(self.next[i]);
            self.candidates.collect::<S>(&self.active[i], i as u8, block, trees.blocks(i));
        }
        self.candidates.test::<ANY, N, S>(trees, &mut self.active, filter);
        for i in places_of(visitors) {
            let i = i % N;
            let next = self.active[i].after_block::<ANY>(self.next[i]);
            self.visit_next::<S>(i, next, trees);
        }
    }
}

/// The places set in a bit mask, lowest first.
#[inline(always)]
pub(crate) fn places_of(mut places: u64) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let place = places.trailing_zeros() as usize;
        let is_there = places != 0;
        places &= places.wrapping_sub(1);
        is_there.then_some(place)
    })
}
