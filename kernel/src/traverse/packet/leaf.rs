//! The leaf test of a packet: the rays of a [`CoherentPacket`] against the triangles of a block: each triangle against
//! all rays or, if rays are fewer, each ray against all triangles.

use super::coherent::CoherentPacket;
use crate::bvh::{TriangleBlock, WIDTH};
use crate::geometry::HitPacket;
use crate::geometry::triangle::{self, LineLanes};
use crate::simd::{Lanes, Mask, Simd, lanes_of};
use crate::traverse::collector::ClosestHit;
use crate::traverse::leaf_test::{corners, intersect_block};

impl<const N: usize, L: Lanes<N>> CoherentPacket<N, L> {
    /// Tests triangles of a block in turn against all of `rays`. Gives those that found a better hit.
    #[inline(always)]
    pub(super) fn hit(&self, block: &TriangleBlock, candidates: u32, rays: u32, best: &mut HitPacket<N>) -> u32 {
        let mut found = 0;
        for triangle in lanes_of(candidates) {
            let triangle = triangle % WIDTH;
            let corners =
                [self.corner(block, 0, triangle), self.corner(block, 1, triangle), self.corner(block, 2, triangle)];
            let Some(crossing) = triangle::cross(&self.lines, corners) else {
                continue;
            };
            let (t_max, prim_id) = (L::load(&best.t), block.prim_id[triangle]);
            let within = self.t_min.le(crossing.t).bits() & crossing.bits & rays;
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
    pub(super) fn occlude(&self, block: &TriangleBlock, candidates: u32, rays: u32, t_max: &[f32; N]) -> u32 {
        let (mut found, t_max) = (0, L::load(t_max));
        for triangle in lanes_of(candidates) {
            let triangle = triangle % WIDTH;
            let corners =
                [self.corner(block, 0, triangle), self.corner(block, 1, triangle), self.corner(block, 2, triangle)];
            found |= triangle::occludes(&self.lines, corners, [self.t_min, t_max]);
            if rays & !found == 0 {
                break;
            }
        }
        found & rays
    }

    /// Tests `rays` in turn against all triangles of a block. Gives those that found a better hit.
    #[inline(always)]
    pub(super) fn hit_each<S: Simd>(&self, block: &TriangleBlock, rays: u32, best: &mut HitPacket<N>) -> u32 {
        let (t_min, mut found) = (self.t_min.store(), 0);
        for lane in lanes_of(rays) {
            let lane = lane % N;
            let before = best.hit(lane);
            let mut nearest = ClosestHit { best: before };
            let ray = self.line_of::<S>(lane);
            // This collector never ends the search.
            let _ = intersect_block(block, &ray, self.class.axes, t_min[lane], &mut nearest);
            if nearest.best.precedes(&before) {
                best.set(lane, nearest.best);
                found |= 1 << lane;
            }
        }
        found
    }

    /// Tests `rays` in turn against all triangles of a block, for any hit. Gives those that found one.
    #[inline(always)]
    pub(super) fn occlude_each<S: Simd>(&self, block: &TriangleBlock, rays: u32, t_max: &[f32; N]) -> u32 {
        let (t_min, mut found) = (self.t_min.store(), 0);
        for lane in lanes_of(rays) {
            let lane = lane % N;
            let interval = [S::F8::splat(t_min[lane]), S::F8::splat(t_max[lane])];
            if triangle::occludes(&self.line_of::<S>(lane), corners(block, self.class.axes), interval) != 0 {
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

    /// A corner of one triangle, in the order of the class's axes.
    #[inline(always)]
    fn corner(&self, block: &TriangleBlock, corner: usize, triangle: usize) -> [L; 3] {
        let [x, y, z] = self.class.axes.map(|axis| axis as usize);
        let axes = &block.corners[corner];
        [L::splat(axes[x][triangle]), L::splat(axes[y][triangle]), L::splat(axes[z][triangle])]
    }
}

/// Those of `lanes` whose triangle comes after `prim_id`.
#[cold]
#[inline(never)]
fn earlier<const N: usize>(prim_id: u32, lanes: u32, prim_ids: &[u32; N]) -> u32 {
    lanes_of(lanes).filter(|&lane| prim_id < prim_ids[lane % N]).fold(0, |bits, lane| bits | 1 << lane)
}
