//! Triangles that rays of a stream may hit: collected from all of them, and tested eight at a time, each lane with a
//! ray of its own.

use super::active::ActiveRay;
use super::{HitFilter, Trees};
use crate::bvh::{TriangleBlock, WIDTH};
use crate::geometry::Hit;
use crate::geometry::triangle::{self, LineLanes};
use crate::simd::{Lanes, Mask, Simd, lanes_of};

/// Candidates that are collected before they are tested.
const ROOM: usize = 256;

/// Triangles that may be hit, and by which rays.
pub(super) struct Candidates {
    /// The block times eight, plus the lane. A block writes eight, whether its lanes are candidates or not.
    codes: [u32; ROOM + 2 * WIDTH],
    rays: [u8; ROOM + 2 * WIDTH],
    len: usize,
}

impl Candidates {
    pub(super) const EMPTY: Self = Self { codes: [0; ROOM + 2 * WIDTH], rays: [0; ROOM + 2 * WIDTH], len: 0 };

    /// Whether those of one block more might not fit.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.len > ROOM
    }

    /// Adds the triangles of a block that the active ray of this index may hit. If there is [no room](Self::is_full),
    /// they are lost.
    #[inline(always)]
    pub(super) fn collect<S: Simd>(&mut self, ray: &ActiveRay, ray_index: u8, block: u32, blocks: &[TriangleBlock]) {
        if let Some(rows) = blocks.get(block as usize) {
            let rows: &[f32; 80] = bytemuck::cast_ref(rows);
            let line = LineLanes::<S::F8>::splat(&ray.line);
            let [x, y, z] = ray.corners.map(|row| usize::from(row & 24));
            let corners = [
                rows_from(rows, [x, y, z]),
                rows_from(rows, [x + 24, y + 24, z + 24]),
                rows_from(rows, [x + 48, y + 48, z + 48]),
            ];
            self.push::<S>(block, triangle::inside(&line, corners), ray_index);
        }
    }

    /// Adds lanes of a block.
    #[inline(always)]
    fn push<S: Simd>(&mut self, block: u32, lanes: u32, ray: u8) {
        let codes = self.codes.get_mut(self.len..).and_then(|free| free.first_chunk_mut());
        let rays = self.rays.get_mut(self.len..).and_then(|free| free.first_chunk_mut());
        if let (Some(codes), Some(rays)) = (codes, rays) {
            *rays = [ray; WIDTH];
            self.len += S::compress_indices(lanes, WIDTH as u32 * block, codes);
        }
    }

    /// Tests all candidates, reports those hits to their rays that the filter accepts, and clears the list.
    #[inline(always)]
    pub(super) fn test<const ANY: bool, const N: usize, S: Simd>(
        &mut self,
        trees: &impl Trees,
        active: &mut [ActiveRay; N],
        filter: &mut impl HitFilter,
    ) {
        let mut first = 0;
        while first < self.len {
            let codes = self.codes.get_mut(first..).and_then(|codes| codes.first_chunk_mut::<WIDTH>());
            let rays = self.rays.get_mut(first..).and_then(|rays| rays.first_chunk_mut::<WIDTH>());
            let (Some(codes), Some(rays)) = (codes, rays) else { break };
            // To fill the last eight, its first one is repeated.
            for k in self.len - first..WIDTH {
                (codes[k % WIDTH], rays[k % WIDTH]) = (codes[0], rays[0]);
            }
            test_eight::<ANY, N, S, _>(trees, codes, rays, active, filter);
            first += WIDTH;
        }
        self.len = 0;
    }
}

/// A corner of a block's triangles, of which the coordinates begin at these indices of the block's floats.
#[inline(always)]
fn rows_from<L: Lanes<WIDTH>>(block: &[f32; 80], [x, y, z]: [usize; 3]) -> [L; 3] {
    [row(block, x), row(block, y), row(block, z)]
}

#[inline(always)]
fn row<L: Lanes<WIDTH>>(block: &[f32; 80], first: usize) -> L {
    L::load(block[first..first + WIDTH].first_chunk().expect("eight floats"))
}

/// A triangle of a block, as a ray sees it.
#[derive(Clone, Copy)]
struct Seen<'a> {
    block: &'a [f32; 80],
    /// Where the coordinates of its first corner are, at most 31: so those of all corners are in the block.
    first: [usize; 3],
}

impl<'a> Seen<'a> {
    #[inline(always)]
    fn new(blocks: &'a [TriangleBlock], code: u32, ray: &ActiveRay) -> Self {
        let block = blocks.get(code as usize / WIDTH).unwrap_or(&TriangleBlock::EMPTY);
        let lane = code as usize % WIDTH;
        let [x, y, z] = ray.corners.map(|offset| usize::from(offset & 24) + lane);
        Self { block: bytemuck::cast_ref(block), first: [x, y, z] }
    }

    #[inline(always)]
    fn coordinate(&self, corner: usize, axis: usize) -> f32 {
        self.block[self.first[axis] + 24 * corner]
    }
}

/// A coordinate of eight triangles.
#[inline(always)]
fn coordinates<S: Simd>([a, b, c, d, e, f, g, h]: &[Seen; WIDTH], corner: usize, axis: usize) -> S::F8 {
    S::F8::load(&[
        a.coordinate(corner, axis),
        b.coordinate(corner, axis),
        c.coordinate(corner, axis),
        d.coordinate(corner, axis),
        e.coordinate(corner, axis),
        f.coordinate(corner, axis),
        g.coordinate(corner, axis),
        h.coordinate(corner, axis),
    ])
}

#[inline(always)]
fn corner<S: Simd>(triangles: &[Seen; WIDTH], corner: usize) -> [S::F8; 3] {
    [
        coordinates::<S>(triangles, corner, 0),
        coordinates::<S>(triangles, corner, 1),
        coordinates::<S>(triangles, corner, 2),
    ]
}

/// Tests eight candidates.
#[inline(always)]
fn test_eight<const ANY: bool, const N: usize, S: Simd, F: HitFilter>(
    trees: &impl Trees,
    codes: &[u32; WIDTH],
    rays: &[u8; WIDTH],
    active: &mut [ActiveRay; N],
    filter: &mut F,
) {
    let places = rays.map(|ray_index| usize::from(ray_index) % N);
    let rays = places.map(|place| &active[place]);
    let mut triangles = [Seen::new(trees.blocks(places[0]), codes[0], rays[0]); WIDTH];
    let mut rows = [S::F8::load(&rays[0].line); WIDTH];
    for lane in 1..WIDTH {
        triangles[lane] = Seen::new(trees.blocks(places[lane]), codes[lane], rays[lane]);
        rows[lane] = S::F8::load(&rays[lane].line);
    }
    let [t_min, t_max] = [S::F8::load(&rays.map(|ray| ray.t_min())), S::F8::load(&rays.map(|ray| ray.best.t))];
    let lines = LineLanes::new(S::transpose(rows));
    let corners = [corner::<S>(&triangles, 0), corner::<S>(&triangles, 1), corner::<S>(&triangles, 2)];
    if ANY && !F::DECIDES {
        for lane in lanes_of(triangle::occludes(&lines, corners, [t_min, t_max])) {
            active[places[lane % WIDTH]].end_with_any();
        }
        return;
    }
    let Some(crossing) = triangle::cross(&lines, corners) else {
        return;
    };
    // Hits behind the origin or the best hit are rejected here, as a branch on them would be mispredicted too often.
    let within = t_min.le(crossing.t) & crossing.t.le(t_max);
    let (t, u, v) = (crossing.t.store(), crossing.u.store(), crossing.v.store());
    for lane in lanes_of(crossing.bits & within.bits()) {
        let lane = lane % WIDTH;
        let blocks = trees.blocks(places[lane]);
        let block = blocks.get(codes[lane] as usize / WIDTH).unwrap_or(&TriangleBlock::EMPTY);
        let prim_id = block.prim_id[codes[lane] as usize % WIDTH];
        let (ray, hit) = (&mut active[places[lane]], Hit { t: t[lane], u: u[lane], v: v[lane], prim_id });
        if F::DECIDES {
            // Any hit ends the search of a ray, but not what it has collected before.
            let counts = !(ANY && ray.best.is_hit()) && hit.precedes(&ray.best);
            if !counts || !filter.accepts(ray.index, &hit) {
                continue;
            }
        }
        if ANY {
            ray.end_with_any();
        } else {
            ray.accept::<S>(hit);
        }
    }
}
