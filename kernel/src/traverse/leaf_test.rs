//! The leaf test: the eight triangles of a block against a ray.

use core::ops::ControlFlow;

use super::collector::Collector;
use crate::bvh::{TriangleBlock, WIDTH};
use crate::geometry::Hit;
use crate::geometry::setup::Axis;
use crate::geometry::triangle::{self, LineLanes};
use crate::simd::{Lanes, Mask, lanes_of};

/// Shows `collector` the hits with the triangles of one block.
#[inline(always)]
pub(super) fn intersect_block<L: Lanes<WIDTH>, C: Collector>(
    block: &TriangleBlock,
    ray: &LineLanes<L>,
    axes: [Axis; 3],
    t_min: f32,
    collector: &mut C,
) -> ControlFlow<()> {
    let Some(crossing) = triangle::cross(ray, corners(block, axes)) else {
        return ControlFlow::Continue(());
    };
    let within = L::splat(t_min).le(crossing.t) & crossing.t.le(L::splat(collector.t_max()));
    let bits = within.bits() & crossing.bits;
    if bits == 0 {
        return ControlFlow::Continue(());
    }
    let (t, u, v) = (crossing.t.store(), crossing.u.store(), crossing.v.store());
    for lane in lanes_of(bits) {
        // The lanes before this one may have lowered it.
        if t[lane] <= collector.t_max() {
            let hit = Hit { t: t[lane], u: u[lane], v: v[lane], prim_id: block.prim_id[lane] };
            collector.report(hit, crossing.front >> lane & 1 != 0)?;
        }
    }
    ControlFlow::Continue(())
}

/// The corners of a block's eight triangles, in the order of `axes`.
#[inline(always)]
pub(super) fn corners<L: Lanes<WIDTH>>(block: &TriangleBlock, axes: [Axis; 3]) -> [[L; 3]; 3] {
    [corner(block, 0, axes), corner(block, 1, axes), corner(block, 2, axes)]
}

#[inline(always)]
fn corner<L: Lanes<WIDTH>>(block: &TriangleBlock, corner: usize, [x, y, z]: [Axis; 3]) -> [L; 3] {
    let axes = &block.corners[corner];
    [L::load(&axes[x as usize]), L::load(&axes[y as usize]), L::load(&axes[z as usize])]
}
