//! A ray stream through a tree of one node: each waits at the leaf that it visits next until there are eight that run
//! fastest along the same axis, which then meet the leaf's triangles together, a lane each (queues of rays at places of
//! the scene: Pharr, Kolb, Gershbein and Hanrahan 1997).
//!
//! So small a tree stays in the first-level cache, and there is no latency to hide; what a stream does for each ray
//! alone, its lists and the gathering of triangles one by one, would be most of what a ray costs. Here triangles are
//! looked up in their block's own lanes.

use core::hint::select_unpredictable;

use super::lanes;
use crate::bvh::{BvhView, Child, Node, WIDTH};
use crate::geometry::setup::Axis;
use crate::geometry::setup_lanes::SetupLanes;
use crate::geometry::setup_rows::{FORWARD, rows};
use crate::geometry::triangle::LineLanes;
use crate::geometry::{Hit, Ray};
use crate::simd::{CompressChildren, Lanes, Mask, Simd};
use crate::traverse::node_test::{intersect_children, visit_octant};

/// Active rays: enough for a few in every queue, and few enough for the first-level cache.
const RAYS: usize = 128;
/// Groups that are chosen before the first of them meets its leaf: which queue is full next is known only when a group
/// has been tested, and would hold up the next.
const ROUND: usize = 3;
/// Above this many blocks a stream is faster: it tests a ray against a block's eight triangles at once.
const MAX_BLOCKS: usize = 16;

/// Whether a tree is small enough.
#[inline(always)]
pub(in crate::traverse) fn suit(tree: &BvhView) -> bool {
    tree.nodes().len() == 1 && tree.blocks().len() <= MAX_BLOCKS
}

/// Gives `write` the index of each ray and its nearest hit, or with `ANY` one that stands for any, in any order. The
/// tree has a single node.
#[inline(always)]
pub(in crate::traverse) fn trace<const ANY: bool, S: Simd>(
    tree: &BvhView,
    rays: &[Ray],
    mut write: impl FnMut(usize, Hit),
) {
    let Some(root) = tree.nodes().first() else { return };
    let (mut waiting, mut queues) = (Waiting::NONE, Queues::EMPTY);
    let mut started = 0;
    while started < rays.len().min(RAYS) {
        let slots = [0, 1, 2, 3, 4, 5, 6, 7].map(|lane| (started + lane) as u8);
        waiting.start::<ANY, S>(tree, root, rays, started, &slots, &mut queues);
        started += WIDTH;
    }
    let mut round = [Group { queue: 0, rays: [0; WIDTH], len: 0 }; ROUND];
    loop {
        let len = queues.take_round(&mut round);
        if len == 0 {
            return;
        }
        for group in &round[..len] {
            if group.queue == ARRIVED {
                for &i in group.rays() {
                    write(waiting.indices[usize::from(i) % RAYS], waiting.result(i));
                }
            } else {
                let leaf = root.children[group.queue / 4 % WIDTH];
                waiting.visit::<ANY, S>(tree, leaf, FORWARD[group.queue % 4 % 3], group.rays());
            }
        }
        for group in &round[..len] {
            if group.queue != ARRIVED {
                waiting.queue_up::<S>(group.rays(), &mut queues);
            } else if started < rays.len() {
                waiting.start::<ANY, S>(tree, root, rays, started, group.rays(), &mut queues);
                started += group.len;
            }
        }
    }
}

/// Up to eight rays of one queue.
#[derive(Clone, Copy)]
struct Group {
    queue: usize,
    rays: [u8; WIDTH],
    len: usize,
}

impl Group {
    #[inline(always)]
    fn rays(&self) -> &[u8] {
        &self.rays[..self.len.min(WIDTH)]
    }
}

/// Queues: four for each leaf, one for each axis along which rays run fastest, and that of the rays that have arrived.
const QUEUES: usize = 64;
const ARRIVED: usize = 4 * WIDTH;

/// The queues of the leaves in each slot, by axis.
const QUEUE_OF: [[u32; WIDTH]; 3] =
    [[0, 4, 8, 12, 16, 20, 24, 28], [1, 5, 9, 13, 17, 21, 25, 29], [2, 6, 10, 14, 18, 22, 26, 30]];

/// Numbers of rays, by what they visit next.
struct Queues {
    /// With room for the eight that are read, whether they are there or not.
    rays: [[u8; RAYS + WIDTH]; QUEUES],
    lens: [u8; QUEUES],
    /// A bit for each queue of eight or more.
    full: u64,
}

impl Queues {
    const EMPTY: Self = Self { rays: [[0; RAYS + WIDTH]; QUEUES], lens: [0; QUEUES], full: 0 };

    #[inline(always)]
    fn push(&mut self, queue: usize, ray: u8) {
        let queue = queue % QUEUES;
        let len = self.lens[queue];
        self.rays[queue][usize::from(len) % RAYS] = ray;
        self.lens[queue] = len + 1;
        self.full |= u64::from(len + 1 >= WIDTH as u8) << queue;
    }

    /// Takes groups from full queues, as many as there are and as there is room for; if none is full, one from the
    /// longest. Gives their number, which is 0 if all queues are empty.
    #[inline(always)]
    fn take_round(&mut self, round: &mut [Group; ROUND]) -> usize {
        let Some(mut queue) = self.next() else { return 0 };
        let mut groups = 0;
        for group in round {
            *group = self.take(queue);
            groups += 1;
            if self.full == 0 {
                break;
            }
            queue = self.full.trailing_zeros() as usize;
        }
        groups
    }

    /// A full queue; if there is none, the longest one, or none if all are empty.
    #[inline(always)]
    fn next(&self) -> Option<usize> {
        if self.full != 0 {
            return Some(self.full.trailing_zeros() as usize);
        }
        let (mut longest, mut most) = (0, 0);
        for (queue, &len) in self.lens.iter().enumerate().take(ARRIVED + 1) {
            if len > most {
                (longest, most) = (queue, len);
            }
        }
        (most > 0).then_some(longest)
    }

    /// Takes up to eight rays from the end of a queue.
    #[inline(always)]
    fn take(&mut self, queue: usize) -> Group {
        let queue = queue % QUEUES;
        let len = self.lens[queue];
        let first = len.saturating_sub(WIDTH as u8);
        self.lens[queue] = first;
        self.full &= !(u64::from(first < WIDTH as u8) << queue);
        let last = self.rays[queue].get(usize::from(first)..).and_then(|rays| rays.first_chunk());
        Group { queue, rays: last.copied().unwrap_or_default(), len: usize::from(len - first) }
    }
}

/// Rays under way. Rows do not cross cache lines.
#[repr(C, align(64))]
struct Waiting {
    /// [`Line::numbers`](crate::geometry::setup::Line::numbers), in the order [`FORWARD`].
    lines: [[f32; WIDTH]; RAYS],
    /// [`lanes::HitLanes`].
    found: [[f32; WIDTH]; RAYS],
    /// The queues of the leaves to visit, the next one last, and where their boxes begin.
    leaves: [[u32; WIDTH]; RAYS],
    near: [[f32; WIDTH]; RAYS],
    /// Of each ray in its batch.
    indices: [usize; RAYS],
    heights: [u8; RAYS],
}

impl Waiting {
    const NONE: Self = Self {
        lines: [[0.0; WIDTH]; RAYS],
        found: [[0.0; WIDTH]; RAYS],
        leaves: [[0; WIDTH]; RAYS],
        near: [[0.0; WIDTH]; RAYS],
        indices: [0; RAYS],
        heights: [0; RAYS],
    };

    /// Takes rays, from the one numbered `first` on, through the root, as many as there are and as there are `slots`:
    /// at most eight.
    #[inline(always)]
    fn start<const ANY: bool, S: Simd>(
        &mut self,
        tree: &BvhView,
        root: &Node,
        rays: &[Ray],
        first: usize,
        slots: &[u8],
        queues: &mut Queues,
    ) {
        let mut lanes = [S::F8::splat(f32::NAN); WIDTH];
        for (lanes, ray) in lanes.iter_mut().zip(&rays[first..]) {
            *lanes = S::F8::load(bytemuck::cast_ref(ray));
        }
        let setups = SetupLanes::new(S::transpose(lanes), &tree.bounds());
        let (near, far) = intersect_children::<S>(&setups, root);
        let found = rows::<S>(lanes::no_hits(setups.t_min, setups.t_max));
        let (lines, classes) = (rows::<S>(setups.lines), setups.classes());
        for (lane, &slot) in slots.iter().enumerate().take(rays.len() - first) {
            let (i, lane) = (usize::from(slot) % RAYS, lane % WIDTH);
            self.indices[i] = first + lane;
            (self.lines[i], self.found[i]) = (lines[lane], found[lane]);
            let order = root.order[usize::from(visit_octant(classes.octant(lane), ANY) & 7)];
            let leaves = &QUEUE_OF[classes.fastest(lane) % 3];
            let (kept, nears) = (&mut self.leaves[i], &mut self.near[i]);
            let height = S::F8::compress(near[lane], far[lane], order, leaves, kept, nears);
            // A ray that can hit nothing has arrived at once.
            self.heights[i] = select_unpredictable(setups.live >> lane & 1 != 0, height as u8, 0);
        }
        self.queue_up::<S>(&slots[..slots.len().min(rays.len() - first)], queues);
    }

    /// Moves up to eight rays to the queues of their next leaves, if one is left that does not begin behind the best
    /// hit. Equal distances are kept: ties are decided by `prim_id`.
    #[inline(always)]
    fn queue_up<S: Simd>(&mut self, eight: &[u8], queues: &mut Queues) {
        let mut next = [0; WIDTH];
        for (next, &i) in next.iter_mut().zip(eight) {
            let i = usize::from(i) % RAYS;
            let within = S::F8::load(&self.near[i]).le(S::F8::splat(self.found[i][0])).bits();
            let left = within & ((1 << (self.heights[i] & 15)) - 1);
            let top = (31 - (left | 1).leading_zeros()) as usize % WIDTH;
            self.heights[i] = top as u8;
            *next = select_unpredictable(left != 0, self.leaves[i][top], ARRIVED as u32);
        }
        // Apart from the above: each push waits for the one before.
        for (&queue, &i) in next.iter().zip(eight) {
            queues.push(queue as usize, i);
        }
    }

    /// Tests up to eight rays, which share their fastest axis, against a leaf's triangles.
    #[inline(always)]
    fn visit<const ANY: bool, S: Simd>(&mut self, tree: &BvhView, leaf: u32, axes: [Axis; 3], eight: &[u8]) {
        let (mut lines, mut found) = ([S::F8::splat(0.0); WIDTH], [S::F8::splat(0.0); WIDTH]);
        for (lane, &i) in eight.iter().enumerate().take(WIDTH) {
            let i = usize::from(i) % RAYS;
            (lines[lane], found[lane]) = (S::F8::load(&self.lines[i]), S::F8::load(&self.found[i]));
        }
        let lines = LineLanes::new(S::transpose(lines));
        let mut found = S::transpose(found);
        let mut any = false;
        for block in tree.blocks().get(Child::leaf_blocks(leaf)).unwrap_or(&[]) {
            any |= lanes::hit::<ANY, S>(block, axes, &lines, &mut found);
        }
        if any {
            for (row, &i) in S::transpose(found).iter().zip(eight) {
                self.found[usize::from(i) % RAYS] = row.store();
            }
        }
    }

    #[inline(always)]
    fn result(&self, i: u8) -> Hit {
        let [t, u, v, prim_id, ..] = self.found[usize::from(i) % RAYS];
        Hit { t, u, v, prim_id: prim_id.to_bits() }.or_miss()
    }
}
