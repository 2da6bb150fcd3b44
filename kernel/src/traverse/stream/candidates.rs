//! Triangles that rays of a stream may hit: collected from all of them, and tested eight at a time, each lane with a ray of
//! its own.

use crate::bvh::{TriangleBlock, WIDTH};
use crate::geometry::setup::{Axis, Line};
use crate::geometry::triangle::{self, Crossing, LineLanes};
use crate::simd::{Lanes, Simd};

/// Triangles that may be hit, and by whom. There is to be room for eight more than there may be: a block writes eight,
/// whether its lanes are candidates or not.
pub(super) struct Candidates<const ROOM: usize> {
    /// The block times eight, plus the lane.
    codes: [u32; ROOM],
    rays: [u8; ROOM],
    len: usize,
}

impl<const ROOM: usize> Candidates<ROOM> {
    pub(super) const EMPTY: Self = Self { codes: [0; ROOM], rays: [0; ROOM], len: 0 };

    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds lanes of a block.
    #[inline(always)]
    pub(super) fn push<S: Simd>(&mut self, block: u32, lanes: u32, ray: u8) {
        let codes = self.codes.get_mut(self.len..).and_then(|free| free.first_chunk_mut());
        let rays = self.rays.get_mut(self.len..).and_then(|free| free.first_chunk_mut());
        if let (Some(codes), Some(rays)) = (codes, rays) {
            *rays = [ray; WIDTH];
            self.len += S::compress_indices(lanes, WIDTH as u32 * block, codes);
        }
    }

    /// The codes and the numbers of the rays, eight at a time. To fill the last eight, its first candidate is repeated.
    #[inline(always)]
    pub(super) fn eights(&mut self) -> impl Iterator<Item = (&[u32; WIDTH], &[u8; WIDTH])> {
        let first = self.len / WIDTH * WIDTH;
        for k in self.len..self.len.next_multiple_of(WIDTH) {
            (self.codes[k % ROOM], self.rays[k % ROOM]) = (self.codes[first % ROOM], self.rays[first % ROOM]);
        }
        let count = self.len.div_ceil(WIDTH);
        self.codes.as_chunks().0.iter().zip(self.rays.as_chunks().0).take(count)
    }
}

/// One triangle of a block.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    block: &'a TriangleBlock,
    lane: usize,
    axes: [Axis; 3],
}

impl<'a> Place<'a> {
    /// The triangle of this code, its axes in the order of `line`.
    #[inline(always)]
    pub(super) fn new(blocks: &'a [TriangleBlock], code: u32, line: &Line) -> Self {
        let block = blocks.get(code as usize / WIDTH).unwrap_or(&TriangleBlock::EMPTY);
        Self { block, lane: code as usize % WIDTH, axes: line.axes }
    }

    #[inline(always)]
    pub(super) fn prim_id(&self) -> u32 {
        self.block.prim_id[self.lane]
    }

    #[inline(always)]
    fn coordinate(&self, corner: usize, k: usize) -> f32 {
        self.block.corners[corner][self.axes[k] as usize][self.lane]
    }
}

/// Where lines cross triangles, one of each a lane.
#[inline(always)]
pub(super) fn cross<S: Simd>(triangles: &[Place; WIDTH], lines: &[&Line; WIDTH]) -> Option<Crossing<S::F8>> {
    triangle::cross(&self::lines::<S>(lines), corners::<S>(triangles))
}

/// The lanes in which a line crosses its triangle in its interval.
#[inline(always)]
pub(super) fn occlude<S: Simd>(triangles: &[Place; WIDTH], lines: &[&Line; WIDTH], interval: [S::F8; 2]) -> u32 {
    triangle::occludes(&self::lines::<S>(lines), corners::<S>(triangles), interval)
}

#[inline(always)]
fn lines<S: Simd>(lines: &[&Line; WIDTH]) -> LineLanes<S::F8> {
    let mut rows = [S::F8::splat(0.0); WIDTH];
    for (row, line) in rows.iter_mut().zip(lines) {
        *row = S::F8::load(&line.numbers);
    }
    LineLanes::new(S::transpose(rows))
}

#[inline(always)]
fn corners<S: Simd>(triangles: &[Place; WIDTH]) -> [[S::F8; 3]; 3] {
    [corner::<S>(triangles, 0), corner::<S>(triangles, 1), corner::<S>(triangles, 2)]
}

#[inline(always)]
fn corner<S: Simd>(triangles: &[Place; WIDTH], corner: usize) -> [S::F8; 3] {
    [lanes::<S>(triangles, corner, 0), lanes::<S>(triangles, corner, 1), lanes::<S>(triangles, corner, 2)]
}

#[inline(always)]
fn lanes<S: Simd>([a, b, c, d, e, f, g, h]: &[Place; WIDTH], corner: usize, k: usize) -> S::F8 {
    S::F8::load(&[
        a.coordinate(corner, k),
        b.coordinate(corner, k),
        c.coordinate(corner, k),
        d.coordinate(corner, k),
        e.coordinate(corner, k),
        f.coordinate(corner, k),
        g.coordinate(corner, k),
        h.coordinate(corner, k),
    ])
}
