//! Eight lines, a lane each, against a block's triangles in turn: where lines cross is found for all triangles first,
//! and then tested in full with a triangle of its own in each lane, looked up in the block.

use crate::bvh::{TriangleBlock, WIDTH};
use crate::geometry::Hit;
use crate::geometry::setup::Axis;
use crate::geometry::triangle::{self, LineLanes};
use crate::simd::{Lanes, Mask, Simd, lanes_of};

/// The results in lanes: the nearest hits' `t`, `u`, `v` and the bits of `prim_id`, then the rays' `t_min`; the rest is
/// unspecified.
pub(super) type HitLanes<L> = [L; WIDTH];

/// The state of rays between `t_min` and `t_max` before the search.
#[inline(always)]
pub(super) fn no_hits<L: Lanes<WIDTH>>(t_min: L, t_max: L) -> HitLanes<L> {
    let zero = L::splat(0.0);
    [t_max, zero, zero, L::splat(f32::from_bits(Hit::NO_PRIM)), t_min, zero, zero, zero]
}

/// Takes hits of the lines with a block's triangles that precede those found before. Whether there may be any. With
/// `ANY` one hit is as good as any other, and nothing is nearer than that.
#[inline(always)]
pub(super) fn hit<const ANY: bool, S: Simd>(
    block: &TriangleBlock,
    axes: [Axis; 3],
    lines: &LineLanes<S::F8>,
    found: &mut HitLanes<S::F8>,
) -> bool {
    // For each triangle, the lines that pass inside of its edges.
    let mut inside = [0; WIDTH];
    let mut any = 0;
    for (triangle, inside) in inside.iter_mut().enumerate() {
        if block.prim_id[triangle] != Hit::NO_PRIM {
            *inside = triangle::inside(lines, spread::<S>(block, axes, triangle));
            any |= *inside;
        }
    }
    let is_any = any != 0;
    while any != 0 {
        // Each lane takes the first of its triangles.
        let (mut places, mut free) = (S::F8::splat(0.0), any);
        for (triangle, inside) in (0..).zip(&mut inside) {
            let taken = *inside & free;
            places = S::F8::select(Mask::from_bits(taken), S::F8::splat(f32::from_bits(triangle)), places);
            free &= !taken;
            *inside &= !taken;
        }
        take::<ANY, S>(block, axes, lines, &bytemuck::cast(places.store()), any, found);
        any = inside.iter().fold(0, |any, inside| any | inside);
    }
    is_any
}

/// Tests `lanes` in full, each with the triangle in its place of the block.
#[inline(always)]
fn take<const ANY: bool, S: Simd>(
    block: &TriangleBlock,
    axes: [Axis; 3],
    lines: &LineLanes<S::F8>,
    places: &[u32; WIDTH],
    lanes: u32,
    [t, u, v, prim_id, t_min, ..]: &mut HitLanes<S::F8>,
) {
    if ANY {
        let occluded = triangle::occludes(lines, picked::<S>(block, axes, places), [*t_min, *t]) & lanes;
        let occluded = Mask::from_bits(occluded);
        *t = S::F8::select(occluded, S::F8::splat(f32::NEG_INFINITY), *t);
        *prim_id = S::F8::select(occluded, S::F8::splat(0.0), *prim_id);
        return;
    }
    let Some(crossing) = triangle::cross(lines, picked::<S>(block, axes, places)) else { return };
    let prim_ids = S::permute(bytemuck::cast_ref(&block.prim_id), places);
    let within = crossing.bits & lanes & t_min.le(crossing.t).bits();
    let mut closer = crossing.t.lt(*t).bits();
    let ties = crossing.t.eq(*t).bits() & within;
    if ties != 0 {
        closer |= earlier(&prim_ids.store(), &prim_id.store(), ties);
    }
    let closer = Mask::from_bits(closer & within);
    *t = S::F8::select(closer, if ANY { S::F8::splat(f32::NEG_INFINITY) } else { crossing.t }, *t);
    *u = S::F8::select(closer, crossing.u, *u);
    *v = S::F8::select(closer, crossing.v, *v);
    *prim_id = S::F8::select(closer, prim_ids, *prim_id);
}

/// Those of `lanes` in which the bits of the first number are less.
#[cold]
#[inline(never)]
fn earlier(first: &[f32; WIDTH], second: &[f32; WIDTH], lanes: u32) -> u32 {
    lanes_of(lanes)
        .filter(|&lane| first[lane % WIDTH].to_bits() < second[lane % WIDTH].to_bits())
        .fold(0, |bits, lane| bits | 1 << lane)
}

/// One triangle's corners in every lane.
#[inline(always)]
fn spread<S: Simd>(block: &TriangleBlock, axes: [Axis; 3], triangle: usize) -> [[S::F8; 3]; 3] {
    let [a, b, c] = &block.corners;
    [splat::<S>(a, axes, triangle), splat::<S>(b, axes, triangle), splat::<S>(c, axes, triangle)]
}

#[inline(always)]
fn splat<S: Simd>(corner: &[[f32; WIDTH]; 3], [x, y, z]: [Axis; 3], triangle: usize) -> [S::F8; 3] {
    let [x, y, z] = [&corner[x as usize], &corner[y as usize], &corner[z as usize]];
    [S::F8::splat(x[triangle]), S::F8::splat(y[triangle]), S::F8::splat(z[triangle])]
}

/// In each lane the corners of one of a block's triangles.
#[inline(always)]
fn picked<S: Simd>(block: &TriangleBlock, axes: [Axis; 3], places: &[u32; WIDTH]) -> [[S::F8; 3]; 3] {
    let [a, b, c] = &block.corners;
    [pick::<S>(a, axes, places), pick::<S>(b, axes, places), pick::<S>(c, axes, places)]
}

#[inline(always)]
fn pick<S: Simd>(corner: &[[f32; WIDTH]; 3], [x, y, z]: [Axis; 3], places: &[u32; WIDTH]) -> [S::F8; 3] {
    let [x, y, z] = [&corner[x as usize], &corner[y as usize], &corner[z as usize]];
    [S::permute(x, places), S::permute(y, places), S::permute(z, places)]
}
