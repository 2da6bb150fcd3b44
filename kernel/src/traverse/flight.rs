//! A ray on its way through the tree, a step at a time: against the eight boxes of a node, or the eight triangles of a
//! block.
//!
//! Most of a step's time is waiting, for the node's memory and for the branches that depend on it. So a batch keeps
//! several rays in flight in one loop, and each fetches what it needs next before the others have their turn: what the
//! database people call asynchronous memory access chaining (Kocberber, Falsafi and Grot 2015). Children are not
//! sorted by distance but taken in an order that the tree keeps for each octant of directions, which needs no branch.

use core::hint::select_unpredictable;

use crate::bvh::{BvhView, Child, MAX_STACK, Node, TriangleBlock, WIDTH};
use crate::geometry::setup::{Course, RayLanes, RaySetup};
use crate::geometry::triangle;
use crate::geometry::{Hit, Ray};
use crate::simd::{Children, Lanes, Mask, Simd, lanes_of};

/// Rays that are in flight at once in a batch.
const IN_FLIGHT: usize = 4;

/// A ray, the subtrees that it has still to visit, and what it has hit.
pub(super) struct Flight {
    setup: RaySetup,
    t_min: f32,
    best: Hit,
    height: usize,
    /// Subtrees, the next one last. A node writes eight, whether it keeps them or not.
    children: [u32; MAX_STACK + WIDTH],
    /// Where the ray enters their boxes.
    near: [f32; MAX_STACK + WIDTH],
}

impl Flight {
    /// A ray that has landed.
    fn landed() -> Self {
        Self {
            setup: RaySetup::NOWHERE,
            t_min: 0.0,
            best: Hit::MISS,
            height: 0,
            children: [0; MAX_STACK + WIDTH],
            near: [0.0; MAX_STACK + WIDTH],
        }
    }

    /// Starts `ray` at the root. A ray that can hit nothing lands at once.
    #[inline(always)]
    fn start(&mut self, tree: &BvhView, ray: &Ray) {
        self.best = Hit::none_before(ray.t_max);
        self.height = 0;
        if let Some(setup) = RaySetup::new(ray, &tree.bounds()) {
            self.setup = setup;
            self.t_min = ray.t_min;
            (self.children[0], self.near[0]) = (0, ray.t_min);
            self.height = 1;
        }
    }

    /// Visits a node or a leaf; `false` if there is none left. With `ANY` the first hit ends the flight.
    #[inline(always)]
    fn step<const ANY: bool, S: Simd>(&mut self, tree: &BvhView) -> bool {
        let child = loop {
            let Some(top) = self.height.checked_sub(1) else {
                return false;
            };
            self.height = top;
            // Another hit may have come nearer since. As near is not nearer: there may be a tie to decide.
            if ANY || self.near[top] <= self.best.t {
                break self.children[top];
            }
        };
        // Nothing is never on the stack: its box is inside out.
        if Child::is_node(child) {
            if let Some(node) = tree.nodes().get(child as usize) {
                self.enter::<S>(node);
            }
        } else {
            for block in tree.blocks().get(Child::leaf_blocks(child)).unwrap_or(&[]) {
                self.hit::<S>(block);
                if ANY && self.best.is_hit() {
                    self.height = 0;
                    return false;
                }
            }
        }
        self.prefetch::<S>(tree);
        true
    }

    /// Puts the children whose boxes the ray meets within its interval on the stack, the nearest one last.
    #[inline(always)]
    fn enter<S: Simd>(&mut self, node: &Node) {
        let ray = &self.setup;
        let (near_x, far_x) = slab::<S>(node, ray, 0);
        let (near_y, far_y) = slab::<S>(node, ray, 1);
        let (near_z, far_z) = slab::<S>(node, ray, 2);
        let near = near_x.max(near_y).max(near_z.max(S::F8::splat(self.t_min)));
        let far = far_x.min(far_y).min(far_z.min(S::F8::splat(self.best.t)));
        let order = node.order[ray.course.octant & 7];
        let free = self.children.get_mut(self.height..).and_then(|free| free.first_chunk_mut());
        let distances = self.near.get_mut(self.height..).and_then(|free| free.first_chunk_mut());
        if let (Some(children), Some(distances)) = (free, distances) {
            self.height += S::F8::keep(near, far, order, &node.children, children, distances);
        }
    }

    /// Takes the block's nearest hit if it precedes the best one.
    #[inline(always)]
    fn hit<S: Simd>(&mut self, block: &TriangleBlock) {
        let lanes = RayLanes::<S::F8>::splat(&self.setup);
        hit_block(block, &lanes, &self.setup.course, self.t_min, &mut self.best);
    }

    /// Fetches what the next step needs.
    #[inline(always)]
    fn prefetch<S: Simd>(&self, tree: &BvhView) {
        if let Some(top) = self.height.checked_sub(1) {
            let child = self.children[top];
            // Not a branch: whether a node or a leaf is next is as good as random.
            let node = tree.nodes().as_ptr().wrapping_add(child as usize).cast();
            let block = tree.blocks().as_ptr().wrapping_add(Child::leaf_blocks(child).start).cast();
            S::prefetch::<{ size_of::<TriangleBlock>() }>(select_unpredictable(Child::is_node(child), node, block));
        }
    }
}

/// Where the ray enters and leaves the slabs of the eight boxes across one of its axes.
#[inline(always)]
fn slab<S: Simd>(node: &Node, ray: &RaySetup, k: usize) -> (S::F8, S::F8) {
    let (near, far) = ray.course.planes()[k];
    let inverse = S::F8::splat(ray.inverse[k]);
    let near = S::F8::load(&node.planes[near]).mul_sub(inverse, S::F8::splat(ray.near_shift[k]));
    let far = S::F8::load(&node.planes[far]).mul_sub(inverse, S::F8::splat(ray.far_shift[k]));
    (near, far)
}

/// Replaces `best` by the block's nearest hit, if that precedes it.
#[inline(always)]
fn hit_block<L: Lanes<WIDTH>>(block: &TriangleBlock, ray: &RayLanes<L>, course: &Course, t_min: f32, best: &mut Hit) {
    let corners = [corner(block, 0, course), corner(block, 1, course), corner(block, 2, course)];
    let Some(crossing) = triangle::cross(ray, corners) else {
        return;
    };
    let within = L::splat(t_min).le(crossing.t) & crossing.t.le(L::splat(best.t));
    let bits = within.bits() & crossing.bits;
    if bits == 0 {
        return;
    }
    let (t, u, v) = (crossing.t.store(), crossing.u.store(), crossing.v.store());
    for lane in lanes_of(bits) {
        let hit = Hit { t: t[lane], u: u[lane], v: v[lane], prim_id: block.prim_id[lane] };
        if hit.precedes(best) {
            *best = hit;
        }
    }
}

/// A corner of the eight triangles, in the order of the course's axes.
#[inline(always)]
fn corner<L: Lanes<WIDTH>>(block: &TriangleBlock, corner: usize, course: &Course) -> [L; 3] {
    let [x, y, z] = course.axes;
    let axes = &block.corners[corner];
    [L::load(&axes[x]), L::load(&axes[y]), L::load(&axes[z])]
}

/// The nearest hit of one ray, or with `ANY` the first one found.
#[inline(always)]
pub(super) fn trace<const ANY: bool, S: Simd>(tree: &BvhView, ray: &Ray) -> Option<Hit> {
    let mut flight = Flight::landed();
    flight.start(tree, ray);
    while flight.step::<ANY, S>(tree) {}
    flight.best.found()
}

/// Gives `land` the number of each ray and its nearest hit, or with `ANY` the first one found, in any order.
#[inline(always)]
pub(super) fn trace_many<const ANY: bool, S: Simd>(
    tree: &BvhView,
    rays: &[Ray],
    mut land: impl FnMut(usize, Option<Hit>),
) {
    let mut waiting = rays.iter().enumerate();
    let mut flights: [(usize, Flight); IN_FLIGHT] = core::array::from_fn(|_| (usize::MAX, Flight::landed()));
    let mut flying = 0;
    for (number, flight) in &mut flights {
        if let Some((next, ray)) = waiting.next() {
            *number = next;
            flight.start(tree, ray);
            flying += 1;
        }
    }
    while flying > 0 {
        for (number, flight) in &mut flights {
            if *number == usize::MAX || flight.step::<ANY, S>(tree) {
                continue;
            }
            land(*number, flight.best.found());
            match waiting.next() {
                Some((next, ray)) => {
                    *number = next;
                    flight.start(tree, ray);
                }
                None => {
                    *number = usize::MAX;
                    flying -= 1;
                }
            }
        }
    }
}
