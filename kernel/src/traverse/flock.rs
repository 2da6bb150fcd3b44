//! Many rays on their way through the tree together, in phases: all that visit a node next, then all that visit a block
//! of a leaf, then all triangles whose edges a ray's line passes inside of.
//!
//! What a ray visits next is as good as random, and so is whether its line crosses a triangle: one ray alone pays a
//! mispredicted branch for each. Here a visit puts its ray on the list of the next visit's kind, and nothing branches on
//! it; and each ray fetches what it visits next a whole round before its turn (what the database people call asynchronous
//! memory access chaining: Kocberber, Falsafi and Grot 2015). Triangles that are crossed are few, and their test is long:
//! they are gathered, of all rays, and tested eight at a time, each lane with a ray of its own. All rays visit the root
//! first: they set out eight at a time, a lane each.

use super::candidates::{self, Candidates, Place};
use super::pending::{Pending, corners, fetch, first_octant, meet_children};
use crate::bvh::{BvhView, Child, Node, TriangleBlock, WIDTH};
use crate::geometry::setup::{Line, RaySetup, Slabs};
use crate::geometry::setup_lanes::SetupLanes;
use crate::geometry::triangle::{self, LineLanes};
use crate::geometry::{Hit, Ray};
use crate::simd::{Lanes, Mask, Simd, lanes_of};

/// Rays of a flock. Fewer hide less; more do not fit into the first-level cache.
pub(super) const FLOCK: usize = 64;

/// One block of each ray.
type FlocksCandidates = Candidates<{ (FLOCK + 1) * WIDTH }>;

/// Gives `land` the number of each ray and its nearest hit, or with `ANY` the first one found, in any order.
#[inline(always)]
pub(super) fn trace<const ANY: bool, S: Simd>(tree: &BvhView, rays: &[Ray], mut land: impl FnMut(usize, Hit)) {
    let mut birds: [Bird; FLOCK] = core::array::from_fn(|_| Bird::LANDED);
    let mut lists = Lists::default();
    let mut resting = List::default();
    (0..FLOCK as u8).for_each(|i| resting.push(i, true));
    let mut candidates = FlocksCandidates::EMPTY;
    let mut departed = 0;
    loop {
        while resting.len() >= WIDTH && departed < rays.len() {
            depart::<ANY, S>(tree, rays, departed, &mut birds, &mut resting, &mut lists);
            departed += WIDTH;
        }
        if lists.are_empty() {
            return;
        }
        let visitors = lists.nodes.restart();
        for k in 0..visitors {
            birds[lists.nodes.bird(k)].enter::<S>(tree.nodes());
        }
        // Apart from the visits, whose results take long to arrive.
        for k in 0..visitors {
            let i = lists.nodes.bird(k);
            birds[i].join::<S>(i, tree, &mut lists);
        }
        candidates.clear();
        let visitors = lists.leaves.restart();
        for k in 0..visitors {
            let i = lists.leaves.bird(k);
            birds[i].find_candidates::<S>(i, tree.blocks(), &mut candidates);
        }
        test::<ANY, S>(tree.blocks(), &mut candidates, &mut birds);
        for k in 0..visitors {
            let i = lists.leaves.bird(k);
            birds[i].join::<S>(i, tree, &mut lists);
        }
        for k in 0..lists.done.restart() {
            let i = lists.done.bird(k);
            land(birds[i].number, birds[i].best.or_miss());
            resting.push(i as u8, true);
        }
    }
}

/// Sends up to eight of `rays`, from the one numbered `first` on, through the root.
#[inline(always)]
fn depart<const ANY: bool, S: Simd>(
    tree: &BvhView,
    rays: &[Ray],
    first: usize,
    birds: &mut [Bird; FLOCK],
    resting: &mut List,
    lists: &mut Lists,
) {
    let root = tree.nodes().first().unwrap_or(&Node::EMPTY);
    let mut rows = [S::F8::splat(f32::NAN); WIDTH];
    for (row, ray) in rows.iter_mut().zip(&rays[first..]) {
        *row = S::F8::load(bytemuck::cast_ref(ray));
    }
    let setups = SetupLanes::new(S::transpose(rows), &tree.bounds());
    let (near, far) = meet_children::<S>(&setups, root);
    let live = setups.live;
    let setups = setups.rows::<S>();
    for lane in 0..WIDTH.min(rays.len() - first) {
        let i = resting.pop();
        let bird = &mut birds[i];
        RaySetup { slabs: bird.slabs, line: bird.line } = setups.setup(lane);
        bird.octant = first_octant::<ANY>(bird.slabs.octant());
        let (t_min, t_max) = setups.interval(lane);
        bird.t_min = t_min;
        bird.best = Hit::none_before(t_max);
        bird.number = first + lane;
        // One that can hit nothing has landed at once.
        bird.pending.clear();
        if live >> lane & 1 != 0 {
            bird.pending.start_below::<S>(root, near[lane], far[lane], bird.octant);
        }
        bird.join::<S>(i, tree, lists);
    }
}

/// Tests the candidates, eight at a time, and tells their birds of the hits.
#[inline(always)]
fn test<const ANY: bool, S: Simd>(
    blocks: &[TriangleBlock],
    candidates: &mut FlocksCandidates,
    birds: &mut [Bird; FLOCK],
) {
    for (codes, numbers) in candidates.eights() {
        let lines = numbers.map(|number| &birds[usize::from(number) % FLOCK].line);
        let mut triangles = [Place::new(blocks, codes[0], lines[0]); WIDTH];
        for lane in 1..WIDTH {
            triangles[lane] = Place::new(blocks, codes[lane], lines[lane]);
        }
        let [t_min, t_max] = intervals::<S>(numbers, birds);
        if ANY {
            for lane in lanes_of(candidates::occlude::<S>(&triangles, &lines, [t_min, t_max])) {
                birds[usize::from(numbers[lane % WIDTH]) % FLOCK].end_with_any();
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
            birds[usize::from(numbers[lane]) % FLOCK].take::<S>(hit);
        }
    }
}

/// Where the rays of eight birds begin, and where their best hits are.
#[inline(always)]
fn intervals<S: Simd>(numbers: &[u8; WIDTH], birds: &[Bird; FLOCK]) -> [S::F8; 2] {
    let eight = numbers.map(|number| &birds[usize::from(number) % FLOCK]);
    [S::F8::load(&eight.map(|bird| bird.t_min)), S::F8::load(&eight.map(|bird| bird.best.t))]
}

/// A ray under way: a cache line for nodes, one for triangles, and what is pending. Flock and nodes fill the first-level
/// cache.
#[repr(C, align(64))]
struct Bird {
    slabs: Slabs,
    /// [`first_octant`].
    octant: u8,
    t_min: f32,
    best: Hit,
    line: Line,
    /// Of the ray in its batch.
    number: usize,
    pending: Pending,
}

const _: () = assert!(core::mem::offset_of!(Bird, line) <= 64 && core::mem::offset_of!(Bird, pending) == 128);

impl Bird {
    const LANDED: Self = Self {
        slabs: RaySetup::NOWHERE.slabs,
        octant: 0,
        t_min: 0.0,
        best: Hit::MISS,
        line: RaySetup::NOWHERE.line,
        number: usize::MAX,
        pending: Pending::EMPTY,
    };

    /// Visits the node that is next.
    #[inline(always)]
    fn enter<S: Simd>(&mut self, nodes: &[Node]) {
        let (child, _) = self.pending.take();
        if let Some(node) = nodes.get(child as usize) {
            self.pending.enter::<S>(node, &self.slabs, self.octant, self.t_min, self.best.t);
        }
    }

    /// Adds the triangles of the block that is next which may be hit.
    #[inline(always)]
    fn find_candidates<S: Simd>(&mut self, number: usize, blocks: &[TriangleBlock], candidates: &mut FlocksCandidates) {
        let first = self.pending.take_block();
        if let Some(block) = blocks.get(first as usize) {
            let line = &self.line;
            let inside = triangle::inside(&LineLanes::<S::F8>::splat(line), corners(block, line.axes));
            candidates.push::<S>(first, inside, number as u8);
        }
    }

    /// Fetches what is next, and joins the list of its kind.
    #[inline(always)]
    fn join<S: Simd>(&self, number: usize, tree: &BvhView, lists: &mut Lists) {
        let top = self.pending.top();
        fetch::<S>(tree, top);
        lists.push(number as u8, top);
    }

    /// Takes a hit if it precedes the best one, and forgets what is behind it.
    #[inline(always)]
    fn take<S: Simd>(&mut self, hit: Hit) {
        if hit.precedes(&self.best) {
            self.best = hit;
            self.pending.cull::<S>(hit.t);
        }
    }

    /// Any hit will do, and has been found.
    #[inline(always)]
    fn end_with_any(&mut self) {
        self.best = Hit::any_if(true);
        self.pending.clear();
    }
}

/// Numbers of birds, in memory that an index of eight bits cannot leave.
struct List {
    birds: [u8; 256],
    len: u8,
}

impl Default for List {
    fn default() -> Self {
        Self { birds: [0; 256], len: 0 }
    }
}

impl List {
    /// Writes `bird`, to stay only if `it_belongs` here.
    #[inline(always)]
    fn push(&mut self, bird: u8, it_belongs: bool) {
        self.birds[usize::from(self.len)] = bird;
        self.len = self.len.wrapping_add(u8::from(it_belongs));
    }

    /// Takes the last one off the list, which has one.
    #[inline(always)]
    fn pop(&mut self) -> usize {
        self.len = self.len.wrapping_sub(1);
        self.bird(usize::from(self.len))
    }

    /// Begins anew, and gives the number of birds there were. They can be read still, each until as many are pushed.
    #[inline(always)]
    fn restart(&mut self) -> usize {
        usize::from(core::mem::take(&mut self.len))
    }

    #[inline(always)]
    fn bird(&self, place: usize) -> usize {
        usize::from(self.birds[place % 256]) % FLOCK
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
    /// Puts a bird on the list for what it visits next.
    #[inline(always)]
    fn push(&mut self, bird: u8, next: u32) {
        let (is_node, is_done) = (Child::is_node(next), next == Pending::NONE);
        self.nodes.push(bird, is_node);
        self.leaves.push(bird, !is_node & !is_done);
        self.done.push(bird, is_done);
    }

    #[inline(always)]
    fn are_empty(&self) -> bool {
        self.nodes.len | self.leaves.len | self.done.len == 0
    }
}
