//! The tree of triangles that a packet goes through, and its leaf test: the rays of a [`CoherentPacket`] against the triangles of a block: each triangle against
//! all rays or, if rays are fewer, each ray against all triangles.

use super::coherent::{CoherentPacket, PacketTree};
use crate::bvh::{BvhView, Child, Node, TriangleBlock, WIDTH};
use crate::geometry::HitPacket;
use crate::geometry::setup::Axis;
use crate::geometry::triangle::{self, LineLanes};
use crate::simd::{Lanes, Mask, Simd, lanes_of};
use crate::traverse::collector::ClosestHit;
use crate::traverse::leaf_test::{corners, intersect_block};
use crate::traverse::node_test::prefetch;

/// The triangles of a tree, and the best hits of the rays of one class of directions. With `ANY` one hit of a ray is as
/// good as another, and none is written.
pub(super) struct Triangles<'a, const ANY: bool, const N: usize, L> {
    tree: &'a BvhView<'a>,
    best: &'a mut HitPacket<N>,
    lines: LineLanes<L>,
    /// The same numbers, for when few rays are left.
    line: LineLanes<[f32; N]>,
}

impl<const ANY: bool, const N: usize, L: Lanes<N>> PacketTree<N, L> for Triangles<'_, ANY, N, L> {
    const IS_EXPENSIVE: bool = false;

    #[inline(always)]
    fn node<'n, S: Simd>(&'n self, index: u32, _room: &'n mut Node) -> Option<&'n Node> {
        self.tree.nodes().get(index as usize)
    }

    #[inline(always)]
    fn prefetch<S: Simd>(&self, child: u32) {
        prefetch::<S>(self.tree, child);
    }

    #[inline(always)]
    fn t_max(&self) -> &[f32; N] {
        &self.best.t
    }

    #[inline(always)]
    fn visit_leaf<S: Simd>(&mut self, packet: &CoherentPacket<N, L>, leaf: u32, rays: u32, left: f32) -> u32 {
        let mut found = 0;
        for block in self.tree.blocks().get(Child::leaf_blocks(leaf)).unwrap_or(&[]) {
            let candidates = packet.candidates::<S>(block, left);
            found |= match (ANY, rays.count_ones() < candidates.count_ones()) {
                (true, true) => self.occlude_each::<S>(packet, block, rays & !found),
                (true, false) => self.occlude(packet, block, candidates, rays & !found),
                (false, true) => self.hit_each::<S>(packet, block, rays),
                (false, false) => self.hit(packet, block, candidates, rays),
            };
        }
        found
    }
}

impl<'a, const ANY: bool, const N: usize, L: Lanes<N>> Triangles<'a, ANY, N, L> {
    #[inline(always)]
    pub(super) fn new(tree: &'a BvhView<'a>, best: &'a mut HitPacket<N>, lines: LineLanes<L>) -> Self {
        let ([a, b, c], [d, e, f], [g, h]) = (lines.origin, lines.inverse, lines.shear);
        let line = LineLanes {
            origin: [a.store(), b.store(), c.store()],
            inverse: [d.store(), e.store(), f.store()],
            shear: [g.store(), h.store()],
        };
        Self { tree, best, lines, line }
    }

    /// Tests triangles of a block in turn against all of `rays`. Gives those that found a better hit.
    #[inline(always)]
    fn hit(&mut self, packet: &CoherentPacket<N, L>, block: &TriangleBlock, candidates: u32, rays: u32) -> u32 {
        let (mut found, best, axes) = (0, &mut *self.best, packet.class.axes);
        for triangle in lanes_of(candidates) {
            let triangle = triangle % WIDTH;
            let corners =
                [corner(block, 0, axes, triangle), corner(block, 1, axes, triangle), corner(block, 2, axes, triangle)];
            let Some(crossing) = triangle::cross(&self.lines, corners) else {
                continue;
            };
            let (t_max, prim_id) = (L::load(&best.t), block.prim_id[triangle]);
            let within = packet.t_min.le(crossing.t).bits() & crossing.bits & rays;
            let ties = crossing.t.eq(t_max).bits() & within;
            let mut closer = crossing.t.lt(t_max).bits() & within;
            if ties != 0 {
                closer |= earlier(prim_id, ties, &best.prim_id);
            }
            let mask = L::Mask::from_bits(closer);
            best.t = L::select(mask, crossing.t, t_max).store();
            best.u = L::select(mask, crossing.u, L::load(&best.u)).store();
            best.v = L::select(mask, crossing.v, L::load(&best.v)).store();
            let prim_ids = L::load(bytemuck::cast_ref(&best.prim_id));
            best.prim_id = bytemuck::cast(L::select(mask, L::splat(f32::from_bits(prim_id)), prim_ids).store());
            found |= closer;
        }
        found
    }

    /// Tests triangles of a block in turn against all of `rays`, for any hit. Gives those that found one.
    #[inline(always)]
    fn occlude(&self, packet: &CoherentPacket<N, L>, block: &TriangleBlock, candidates: u32, rays: u32) -> u32 {
        let (mut found, t_max, axes) = (0, L::load(&self.best.t), packet.class.axes);
        for triangle in lanes_of(candidates) {
            let triangle = triangle % WIDTH;
            let corners =
                [corner(block, 0, axes, triangle), corner(block, 1, axes, triangle), corner(block, 2, axes, triangle)];
            found |= triangle::occludes(&self.lines, corners, [packet.t_min, t_max]);
            if rays & !found == 0 {
                break;
            }
        }
        found & rays
    }

    /// Tests `rays` in turn against all triangles of a block. Gives those that found a better hit.
    #[inline(always)]
    fn hit_each<S: Simd>(&mut self, packet: &CoherentPacket<N, L>, block: &TriangleBlock, rays: u32) -> u32 {
        let (t_min, mut found) = (packet.t_min.store(), 0);
        for lane in lanes_of(rays) {
            let lane = lane % N;
            let before = self.best.hit(lane);
            let mut nearest = ClosestHit { best: before };
            let ray = self.line_of::<S>(lane);
            // This collector never ends the search.
            let _ = intersect_block(block, &ray, packet.class.axes, t_min[lane], &mut nearest);
            if nearest.best.precedes(&before) {
                self.best.set(lane, nearest.best);
                found |= 1 << lane;
            }
        }
        found
    }

    /// Tests `rays` in turn against all triangles of a block, for any hit. Gives those that found one.
    #[inline(always)]
    fn occlude_each<S: Simd>(&self, packet: &CoherentPacket<N, L>, block: &TriangleBlock, rays: u32) -> u32 {
        let (t_min, mut found) = (packet.t_min.store(), 0);
        for lane in lanes_of(rays) {
            let lane = lane % N;
            let interval = [S::F8::splat(t_min[lane]), S::F8::splat(self.best.t[lane])];
            if triangle::occludes(&self.line_of::<S>(lane), corners(block, packet.class.axes), interval) != 0 {
                found |= 1 << lane;
            }
        }
        found
    }

    #[inline(always)]
    fn line_of<S: Simd>(&self, lane: usize) -> LineLanes<S::F8> {
        let line = &self.line;
        LineLanes::<S::F8> {
            origin: [
                S::F8::splat(line.origin[0][lane]),
                S::F8::splat(line.origin[1][lane]),
                S::F8::splat(line.origin[2][lane]),
            ],
            inverse: [
                S::F8::splat(line.inverse[0][lane]),
                S::F8::splat(line.inverse[1][lane]),
                S::F8::splat(line.inverse[2][lane]),
            ],
            shear: [S::F8::splat(line.shear[0][lane]), S::F8::splat(line.shear[1][lane])],
        }
    }
}

/// A corner of one triangle in all lanes, in the order of `axes`.
#[inline(always)]
fn corner<const N: usize, L: Lanes<N>>(
    block: &TriangleBlock,
    corner: usize,
    [x, y, z]: [Axis; 3],
    triangle: usize,
) -> [L; 3] {
    let axes = &block.corners[corner];
    [L::splat(axes[x as usize][triangle]), L::splat(axes[y as usize][triangle]), L::splat(axes[z as usize][triangle])]
}

/// Those of `lanes` whose triangle comes after `prim_id`.
#[cold]
#[inline(never)]
fn earlier<const N: usize>(prim_id: u32, lanes: u32, prim_ids: &[u32; N]) -> u32 {
    lanes_of(lanes).filter(|&lane| prim_id < prim_ids[lane % N]).fold(0, |bits, lane| bits | 1 << lane)
}
