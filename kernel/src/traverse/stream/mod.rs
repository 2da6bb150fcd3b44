//! A ray stream: up to 64 rays are traced at the same time, in phases: all that visit a node next, then all that visit a block
//! of a leaf, then all triangles whose edges a ray's line passes inside of.
//!
//! What a ray visits next is as good as random, and so is whether its line crosses a triangle: one ray alone pays a
//! mispredicted branch for each. Here a visit puts its ray on the list of the next visit's kind, and nothing branches on
//! it; and each ray prefetches what it visits next a whole round before its turn (what the database people call asynchronous
//! memory access chaining: Kocberber, Falsafi and Grot 2015). Triangles that are crossed are few, and their test is long:
//! they are collected from all rays, and tested eight at a time, each lane with a ray of its own. All rays visit the root
//! first, eight at a time, a lane each.

mod candidates;
mod lanes;
pub(super) mod leaf_queues;

use candidates::{Candidates, Place};

use crate::bvh::{BvhView, Child, Node, TriangleBlock, WIDTH};
use crate::geometry::setup::{Line, RaySetup, Slabs};
use crate::geometry::setup_lanes::SetupLanes;
use crate::geometry::triangle::{self, LineLanes};
use crate::geometry::{Hit, Ray};
use crate::simd::{Lanes, Mask, Simd, lanes_of};
use crate::traverse::leaf_test::corners;
use crate::traverse::node_test::{intersect_children, prefetch, visit_octant};
use crate::traverse::stack::TraversalStack;

/// Rays that are traced at the same time. Fewer hide less latency; more do not fit into the first-level cache.
pub(super) const MAX_ACTIVE: usize = 64;

/// One block of each ray.
type StreamCandidates = Candidates<{ (MAX_ACTIVE + 1) * WIDTH }>;

/// Gives `write` the number of each ray and its nearest hit, or with `ANY` the first one found, in any order.
#[inline(always)]
pub(super) fn trace<const ANY: bool, S: Simd>(tree: &BvhView, rays: &[Ray], mut write: impl FnMut(usize, Hit)) {
    let mut active: [ActiveRay; MAX_ACTIVE] = core::array::from_fn(|_| ActiveRay::EMPTY);
    let mut lists = Lists::default();
    let mut idle = List::default();
    (0..MAX_ACTIVE as u8).for_each(|i| idle.push(i, true));
    let mut candidates = StreamCandidates::EMPTY;
    let mut started = 0;
    loop {
        while idle.len() >= WIDTH && started < rays.len() {
            start::<ANY, S>(tree, rays, started, &mut active, &mut idle, &mut lists);
            started += WIDTH;
        }
        if lists.are_empty() {
            return;
        }
        let visitors = lists.nodes.restart();
        for k in 0..visitors {
            active[lists.nodes.ray(k)].visit_node::<S>(tree.nodes());
        }
        // Apart from the visits, whose results take long to arrive.
        for k in 0..visitors {
            let i = lists.nodes.ray(k);
            active[i].schedule::<S>(i, tree, &mut lists);
        }
        candidates.clear();
        let visitors = lists.leaves.restart();
        for k in 0..visitors {
            let i = lists.leaves.ray(k);
            active[i].find_candidates::<S>(i, tree.blocks(), &mut candidates);
        }
        test::<ANY, S>(tree.blocks(), &mut candidates, &mut active);
        for k in 0..visitors {
            let i = lists.leaves.ray(k);
            active[i].schedule::<S>(i, tree, &mut lists);
        }
        for k in 0..lists.done.restart() {
            let i = lists.done.ray(k);
            write(active[i].number, active[i].best.or_miss());
            idle.push(i as u8, true);
        }
    }
}

/// Starts up to eight of `rays`, from the one numbered `first` on: makes them ready and tests the root.
#[inline(always)]
fn start<const ANY: bool, S: Simd>(
    tree: &BvhView,
    rays: &[Ray],
    first: usize,
    active: &mut [ActiveRay; MAX_ACTIVE],
    idle: &mut List,
    lists: &mut Lists,
) {
    let root = tree.nodes().first().unwrap_or(&Node::EMPTY);
    let mut rows = [S::F8::splat(f32::NAN); WIDTH];
    for (row, ray) in rows.iter_mut().zip(&rays[first..]) {
        *row = S::F8::load(bytemuck::cast_ref(ray));
    }
    let setups = SetupLanes::new(S::transpose(rows), &tree.bounds());
    let (near, far) = intersect_children::<S>(&setups, root);
    let live = setups.live;
    let setups = setups.rows::<S>();
    for lane in 0..WIDTH.min(rays.len() - first) {
        let i = idle.pop();
        let ray = &mut active[i];
        RaySetup { slabs: ray.slabs, line: ray.line } = setups.setup(lane);
        ray.octant = visit_octant::<ANY>(ray.slabs.octant());
        let (t_min, t_max) = setups.interval(lane);
        ray.t_min = t_min;
        ray.best = Hit::none_before(t_max);
        ray.number = first + lane;
        // One that can hit nothing is done at once.
        ray.stack.clear();
        if live >> lane & 1 != 0 {
            ray.stack.reset_to_children::<S>(root, near[lane], far[lane], ray.octant);
        }
        ray.schedule::<S>(i, tree, lists);
    }
}

/// Tests the candidates, eight at a time, and hands the hits to their rays.
#[inline(always)]
fn test<const ANY: bool, S: Simd>(
    blocks: &[TriangleBlock],
    candidates: &mut StreamCandidates,
    active: &mut [ActiveRay; MAX_ACTIVE],
) {
    for (codes, numbers) in candidates.eights() {
        let lines = numbers.map(|number| &active[usize::from(number) % MAX_ACTIVE].line);
        let mut triangles = [Place::new(blocks, codes[0], lines[0]); WIDTH];
        for lane in 1..WIDTH {
            triangles[lane] = Place::new(blocks, codes[lane], lines[lane]);
        }
        let [t_min, t_max] = intervals::<S>(numbers, active);
        if ANY {
            for lane in lanes_of(candidates::occlude::<S>(&triangles, &lines, [t_min, t_max])) {
                active[usize::from(numbers[lane % WIDTH]) % MAX_ACTIVE].end_with_any();
            }
            continue;
        }
        let Some(crossing) = candidates::cross::<S>(&triangles, &lines) else {
            continue;
        };
        // What is behind the origin or the best hit is sorted out here, as a branch on it is mispredicted too often.
        let within = t_min.le(crossing.t) & crossing.t.le(t_max);
        let (t, u, v) = (crossing.t.store(), crossing.u.store(), crossing.v.store());
        for lane in lanes_of(crossing.bits & within.bits()) {
            let lane = lane % WIDTH;
            let hit = Hit { t: t[lane], u: u[lane], v: v[lane], prim_id: triangles[lane].prim_id() };
            active[usize::from(numbers[lane]) % MAX_ACTIVE].accept::<S>(hit);
        }
    }
}

/// Eight active rays' `t_min`, and the `t` of their best hits.
#[inline(always)]
fn intervals<S: Simd>(numbers: &[u8; WIDTH], active: &[ActiveRay; MAX_ACTIVE]) -> [S::F8; 2] {
    let eight = numbers.map(|number| &active[usize::from(number) % MAX_ACTIVE]);
    [S::F8::load(&eight.map(|ray| ray.t_min)), S::F8::load(&eight.map(|ray| ray.best.t))]
}

/// An active ray: a cache line for the node test, one for the leaf test, and its stack. All of them, and the nodes that they
/// prefetch, fill the first-level cache.
#[repr(C, align(64))]
struct ActiveRay {
    slabs: Slabs,
    /// [`visit_octant`].
    octant: u8,
    t_min: f32,
    best: Hit,
    line: Line,
    /// Of the ray in its batch.
    number: usize,
    stack: TraversalStack,
}

const _: () = assert!(core::mem::offset_of!(ActiveRay, line) <= 64 && core::mem::offset_of!(ActiveRay, stack) == 128);

impl ActiveRay {
    const EMPTY: Self = Self {
        slabs: RaySetup::NOWHERE.slabs,
        octant: 0,
        t_min: 0.0,
        best: Hit::MISS,
        line: RaySetup::NOWHERE.line,
        number: usize::MAX,
        stack: TraversalStack::EMPTY,
    };

    /// Visits the node that is next.
    #[inline(always)]
    fn visit_node<S: Simd>(&mut self, nodes: &[Node]) {
        let (child, _) = self.stack.pop();
        if let Some(node) = nodes.get(child as usize) {
            self.stack.push_children::<S>(node, &self.slabs, self.octant, self.t_min, self.best.t);
        }
    }

    /// Adds the triangles of the block that is next which may be hit.
    #[inline(always)]
    fn find_candidates<S: Simd>(&mut self, number: usize, blocks: &[TriangleBlock], candidates: &mut StreamCandidates) {
        let first = self.stack.pop_block();
        if let Some(block) = blocks.get(first as usize) {
            let line = &self.line;
            let inside = triangle::inside(&LineLanes::<S::F8>::splat(line), corners(block, line.axes));
            candidates.push::<S>(first, inside, number as u8);
        }
    }

    /// Prefetches what is next, and puts the ray on the list of its kind.
    #[inline(always)]
    fn schedule<S: Simd>(&self, number: usize, tree: &BvhView, lists: &mut Lists) {
        let top = self.stack.top();
        prefetch::<S>(tree, top);
        lists.push(number as u8, top);
    }

    /// Takes a hit if it precedes the best one, and forgets what is behind it.
    #[inline(always)]
    fn accept<S: Simd>(&mut self, hit: Hit) {
        if hit.precedes(&self.best) {
            self.best = hit;
            self.stack.cull::<S>(hit.t);
        }
    }

    /// Any hit will do, and has been found.
    #[inline(always)]
    fn end_with_any(&mut self) {
        self.best = Hit::any_if(true);
        self.stack.clear();
    }
}

/// Numbers of rays, in memory that an index of eight bits cannot leave.
struct List {
    rays: [u8; 256],
    len: u8,
}

impl Default for List {
    fn default() -> Self {
        Self { rays: [0; 256], len: 0 }
    }
}

impl List {
    /// Writes `ray`, to stay only if `it_belongs` here.
    #[inline(always)]
    fn push(&mut self, ray: u8, it_belongs: bool) {
        self.rays[usize::from(self.len)] = ray;
        self.len = self.len.wrapping_add(u8::from(it_belongs));
    }

    /// Takes the last one off the list, which has one.
    #[inline(always)]
    fn pop(&mut self) -> usize {
        self.len = self.len.wrapping_sub(1);
        self.ray(usize::from(self.len))
    }

    /// Begins anew, and gives the number of rays there were. They can be read still, each until as many are pushed.
    #[inline(always)]
    fn restart(&mut self) -> usize {
        usize::from(core::mem::take(&mut self.len))
    }

    #[inline(always)]
    fn ray(&self, place: usize) -> usize {
        usize::from(self.rays[place % 256]) % MAX_ACTIVE
    }

    #[inline(always)]
    fn len(&self) -> usize {
        usize::from(self.len)
    }
}

/// Who visits what next.
#[derive(Default)]
struct Lists {
    nodes: List,
    leaves: List,
    done: List,
}

impl Lists {
    /// Puts a ray on the list for what it visits next.
    #[inline(always)]
    fn push(&mut self, ray: u8, next: u32) {
        let (is_node, is_done) = (Child::is_node(next), next == TraversalStack::NONE);
        self.nodes.push(ray, is_node);
        self.leaves.push(ray, !is_node & !is_done);
        self.done.push(ray, is_done);
    }

    #[inline(always)]
    fn are_empty(&self) -> bool {
        self.nodes.len | self.leaves.len | self.done.len == 0
    }
}
