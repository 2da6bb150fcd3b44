//! Many rays on their way through the tree together, in phases: all that visit a node next, then all that visit a block
//! of a leaf, then all triangles whose edges a ray's line passes inside of.
//!
//! What a ray visits next is as good as random, and so is whether its line crosses a triangle: one ray alone pays a
//! mispredicted branch for each. Here a visit puts its ray on the list of the next visit's kind, and nothing branches on
//! it; and each ray fetches what it visits next a whole round before its turn (what the database people call asynchronous
//! memory access chaining: Kocberber, Falsafi and Grot 2015). Triangles that are crossed are few, and their test is long:
//! they are gathered, of all rays, and tested eight at a time, each lane with a ray of its own.

use core::hint::select_unpredictable;

use super::pending::{Pending, corners};
use crate::bvh::{BvhView, Child, Node, TriangleBlock, WIDTH};
use crate::geometry::setup::{RaySetup, Slabs};
use crate::geometry::triangle::{self, LineLanes};
use crate::geometry::{Hit, Ray};
use crate::simd::{Lanes, Simd};

/// Rays of a flock. Fewer hide less; more do not fit into the first-level cache.
pub(super) const FLOCK: usize = 64;
/// What their blocks may hold, and room for the eight that a block writes, whether its lanes are candidates or not.
const CANDIDATES: usize = (FLOCK + 1) * WIDTH;

/// Gives `land` the number of each ray and its nearest hit, or with `ANY` the first one found, in any order.
#[inline(always)]
pub(super) fn trace<const ANY: bool, S: Simd>(tree: &BvhView, rays: &[Ray], mut land: impl FnMut(usize, Option<Hit>)) {
    let mut birds: [Bird; FLOCK] = core::array::from_fn(|_| Bird::LANDED);
    let mut waiting = rays.iter().enumerate();
    let mut lists = Lists::default();
    let mut candidates = Candidates { codes: [0; CANDIDATES], birds: [0; CANDIDATES], len: 0 };
    for (i, bird) in birds.iter_mut().enumerate() {
        if let Some((number, ray)) = waiting.next() {
            bird.start(tree, ray, number);
            lists.push(i as u8, bird.pending.top());
        }
    }
    while !lists.are_empty() {
        let turn = core::mem::take(&mut lists);
        for &i in turn.nodes.birds() {
            birds[usize::from(i) % FLOCK].enter::<S>(tree.nodes());
        }
        // Apart from the visits, whose results take long to arrive.
        for &i in turn.nodes.birds() {
            birds[usize::from(i) % FLOCK].join::<S>(i, tree, &mut lists);
        }
        candidates.len = 0;
        for &i in turn.leaves.birds() {
            birds[usize::from(i) % FLOCK].find_candidates::<S>(i, tree.blocks(), &mut candidates);
        }
        test::<ANY, S>(tree.blocks(), &candidates, &mut birds);
        for &i in turn.leaves.birds() {
            birds[usize::from(i) % FLOCK].join::<S>(i, tree, &mut lists);
        }
        for &i in turn.done.birds() {
            let bird = &mut birds[usize::from(i) % FLOCK];
            land(bird.number, bird.best.found());
            if let Some((number, ray)) = waiting.next() {
                bird.start(tree, ray, number);
                lists.push(i, bird.pending.top());
            }
        }
    }
}

/// A ray under way.
struct Bird {
    setup: RaySetup,
    octant: u8,
    t_min: f32,
    best: Hit,
    /// Of the ray in its batch.
    number: usize,
    pending: Pending,
}

impl Bird {
    const LANDED: Self = Self {
        setup: RaySetup::NOWHERE,
        octant: 0,
        t_min: 0.0,
        best: Hit::MISS,
        number: usize::MAX,
        pending: Pending::EMPTY,
    };

    /// Starts with `ray`. One that can hit nothing has landed at once.
    #[inline(always)]
    fn start(&mut self, tree: &BvhView, ray: &Ray, number: usize) {
        self.best = Hit::none_before(ray.t_max);
        self.number = number;
        self.pending.clear();
        if let Some(setup) = RaySetup::new(ray, &tree.bounds()) {
            self.setup = setup;
            self.octant = setup.slabs.octant();
            self.t_min = ray.t_min;
            self.pending.start();
        }
    }

    /// Visits the node that is next.
    #[inline(always)]
    fn enter<S: Simd>(&mut self, nodes: &[Node]) {
        let (child, _) = self.pending.take();
        if let Some(node) = nodes.get(child as usize) {
            let slabs: &Slabs = &self.setup.slabs;
            self.pending.enter::<S>(node, slabs, self.octant, self.t_min, self.best.t);
        }
    }

    /// Adds the triangles of the block that is next which may be hit.
    #[inline(always)]
    fn find_candidates<S: Simd>(&mut self, number: u8, blocks: &[TriangleBlock], candidates: &mut Candidates) {
        let first = self.pending.take_block();
        if let Some(block) = blocks.get(first as usize) {
            let line = &self.setup.line;
            let inside = triangle::inside(&LineLanes::<S::F8>::splat(line), corners(block, line.axes));
            candidates.push::<S>(first, inside, number);
        }
    }

    /// Fetches what is next, and joins the list of its kind.
    #[inline(always)]
    fn join<S: Simd>(&self, number: u8, tree: &BvhView, lists: &mut Lists) {
        let top = self.pending.top();
        let node = tree.nodes().as_ptr().wrapping_add(top as usize).cast();
        let block = tree.blocks().as_ptr().wrapping_add(Child::first_block(top) as usize).cast();
        S::prefetch::<{ size_of::<Node>() }>(select_unpredictable(Child::is_node(top), node, block));
        lists.push(number, top);
    }

    /// Takes a hit if it precedes the best one, and forgets what is behind it.
    #[inline(always)]
    fn take<const ANY: bool, S: Simd>(&mut self, hit: Hit) {
        if self.t_min <= hit.t && hit.precedes(&self.best) {
            self.best = hit;
            if ANY {
                self.pending.clear();
            } else {
                self.pending.cull::<S>(hit.t);
            }
        }
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

    #[inline(always)]
    fn birds(&self) -> &[u8] {
        &self.birds[..usize::from(self.len)]
    }
}

/// Who visits what in the next turn.
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

/// Triangles that may be hit, and by whom.
struct Candidates {
    /// The block times eight, plus the lane.
    codes: [u32; CANDIDATES],
    birds: [u8; CANDIDATES],
    len: usize,
}

impl Candidates {
    /// Adds lanes of a block.
    #[inline(always)]
    fn push<S: Simd>(&mut self, block: u32, lanes: u32, bird: u8) {
        let codes = self.codes.get_mut(self.len..).and_then(|free| free.first_chunk_mut());
        let birds = self.birds.get_mut(self.len..).and_then(|free| free.first_chunk_mut());
        if let (Some(codes), Some(birds)) = (codes, birds) {
            *birds = [bird; WIDTH];
            self.len += S::set_lanes(lanes, WIDTH as u32 * block, codes);
        }
    }
}

/// Tests the candidates, eight at a time, and tells their birds of the hits.
#[inline(always)]
fn test<const ANY: bool, S: Simd>(blocks: &[TriangleBlock], candidates: &Candidates, birds: &mut [Bird; FLOCK]) {
    let all =
        (&candidates.codes[..candidates.len.min(CANDIDATES)], &candidates.birds[..candidates.len.min(CANDIDATES)]);
    for (codes, numbers) in all.0.chunks(WIDTH).zip(all.1.chunks(WIDTH)) {
        let mut eight = Eight::EMPTY;
        for (lane, (&code, &number)) in (0..WIDTH).zip(codes.iter().zip(numbers)) {
            if let Some(block) = blocks.get(code as usize / WIDTH) {
                eight.set(lane, block, code as usize % WIDTH, &birds[usize::from(number) % FLOCK].setup);
            }
        }
        let Some(crossing) = triangle::cross(&eight.lines::<S::F8>(), eight.corners()) else {
            continue;
        };
        let (t, u, v) = (crossing.t.store(), crossing.u.store(), crossing.v.store());
        for (lane, &number) in (0..WIDTH).zip(numbers) {
            if crossing.bits >> lane & 1 != 0 {
                let hit = Hit { t: t[lane], u: u[lane], v: v[lane], prim_id: eight.prim_id[lane] };
                birds[usize::from(number) % FLOCK].take::<ANY, S>(hit);
            }
        }
    }
}

/// Eight triangles, each with a line, and with its axes in that line's order.
struct Eight {
    corners: [[[f32; WIDTH]; 3]; 3],
    origin: [[f32; WIDTH]; 3],
    inverse: [[f32; WIDTH]; 3],
    shear: [[f32; WIDTH]; 2],
    prim_id: [u32; WIDTH],
}

impl Eight {
    /// No triangles: none of their edges encloses anything.
    const EMPTY: Self = Self {
        corners: [[[f32::NAN; WIDTH]; 3]; 3],
        origin: [[0.0; WIDTH]; 3],
        inverse: [[0.0; WIDTH]; 3],
        shear: [[0.0; WIDTH]; 2],
        prim_id: [Hit::NO_PRIM; WIDTH],
    };

    #[inline(always)]
    fn set(&mut self, lane: usize, block: &TriangleBlock, from: usize, ray: &RaySetup) {
        let line = &ray.line;
        for k in 0..3 {
            for corner in 0..3 {
                self.corners[corner][k][lane] = block.corners[corner][line.axes[k] as usize][from];
            }
            self.origin[k][lane] = line.origin[k];
            self.inverse[k][lane] = line.inverse[k];
        }
        self.shear[0][lane] = line.shear[0];
        self.shear[1][lane] = line.shear[1];
        self.prim_id[lane] = block.prim_id[from];
    }

    #[inline(always)]
    fn corners<L: Lanes<WIDTH>>(&self) -> [[L; 3]; 3] {
        [three(&self.corners[0]), three(&self.corners[1]), three(&self.corners[2])]
    }

    #[inline(always)]
    fn lines<L: Lanes<WIDTH>>(&self) -> LineLanes<L> {
        let [x, y] = &self.shear;
        LineLanes { origin: three(&self.origin), inverse: three(&self.inverse), shear: [L::load(x), L::load(y)] }
    }
}

#[inline(always)]
fn three<L: Lanes<WIDTH>>([x, y, z]: &[[f32; WIDTH]; 3]) -> [L; 3] {
    [L::load(x), L::load(y), L::load(z)]
}
