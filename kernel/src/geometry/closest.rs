//! The point of a triangle that is closest to another point.
//!
//! Ericson 2005, "Real-Time Collision Detection", 5.1.5, decides by signs whether it is in the interior, on an edge or
//! at a corner. For needles these signs are noise, so here the candidates themselves are compared: the closest points
//! of the three edges, which are well-behaved however thin the triangle, and the foot of the perpendicular if that is
//! inside (its barycentric weights are those of Heidrich 2005, "Computing the Barycentric Coordinates of a Projected
//! Point"). For needles these weights are inexact, and the foot is off along the needle: a step along two edges, each
//! to the least distance, corrects that.
//!
//! The coordinates are relative to the point from which the distance is measured, and the closest point is clamped to
//! the triangle's own box. So its distance, computed in the same way, is never less than that of a box around the
//! triangle, to the last bit: each rounded operation is monotonic. Culling boxes then never loses the closest triangle,
//! nor one as close, and no allowance for rounding is needed.
//!
//! Squares of distances below 1e-19 vanish: such distances count as equal, and as zero.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::{Hit, MAX_COORDINATE, Triangle};
use crate::simd::Lanes;

/// A point on a surface that is closest to another point: `(1 - u - v) v0 + u v1 + v v2`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SurfacePoint {
    /// The point.
    pub point: Vec3,
    /// How far it is from the other one.
    pub distance: f32,
    /// Barycentric weight of the triangle's second corner, 0..=1.
    pub u: f32,
    /// Barycentric weight of the triangle's third corner, 0..=1.
    pub v: f32,
    /// The triangle's index in the slice that the tree was built from.
    pub prim_id: u32,
}

impl SurfacePoint {
    /// The point as a hit, whose `t` is the distance.
    pub fn to_hit(&self) -> Hit {
        Hit { t: self.distance, u: self.u, v: self.v, prim_id: self.prim_id }
    }
}

/// A candidate for the closest point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClosestCandidate {
    /// The position relative to the query point.
    pub offset: [f32; 3],
    /// The distance, squared.
    pub distance2: f32,
    pub u: f32,
    pub v: f32,
    pub prim_id: u32,
}

impl ClosestCandidate {
    /// Whether this is closer than `other`, or as close on a triangle that comes first.
    #[inline(always)]
    pub(crate) fn precedes(&self, other: &Self) -> bool {
        self.distance2 < other.distance2 || self.distance2 == other.distance2 && self.prim_id < other.prim_id
    }

    /// The initial candidate of a search around `from`: all that are not farther than `radius` precede it. `None` if
    /// nothing can be found, as `from` is out of limits, or `radius` is negative or NaN.
    pub(crate) fn none_within(from: Vec3, radius: f32) -> Option<Self> {
        let is_valid = from.abs().cmple(Vec3::splat(MAX_COORDINATE)).all() && radius >= 0.0;
        let distance2 = radius * radius;
        is_valid.then_some(Self { offset: [0.0; 3], distance2, u: 0.0, v: 0.0, prim_id: Hit::NO_PRIM })
    }

    /// The result of a search around `from`.
    pub(crate) fn found(self, from: Vec3) -> Option<SurfacePoint> {
        let Self { offset, distance2, u, v, prim_id } = self;
        let surface =
            || SurfacePoint { point: from + Vec3::from(offset), distance: libm::sqrtf(distance2), u, v, prim_id };
        (prim_id != Hit::NO_PRIM).then(surface)
    }
}

/// The foot on `triangle` of the point `from`; its `prim_id` is 0. The definition: lanes equal it bit for bit.
pub(crate) fn closest_point(from: Vec3, triangle: &Triangle) -> ClosestCandidate {
    let [a, b, c] = triangle.map(|p| [p.x - from.x, p.y - from.y, p.z - from.z]);
    let foot = |weights: [f32; 3], offset: [f32; 3]| ClosestCandidate {
        offset,
        distance2: dot(offset, offset),
        u: weights[1],
        v: weights[2],
        prim_id: 0,
    };
    // Where the segment from `p` to `q` is closest to zero: the weight of `q`, and the point.
    let on_edge = |p: [f32; 3], q: [f32; 3]| {
        let edge = sub(q, p);
        let length2 = dot(edge, edge);
        let along = 0.0 - dot(p, edge);
        let s = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
        (s, [0, 1, 2].map(|k| (1.0 - s) * p[k] + s * q[k]))
    };
    let (ab, on_ab) = on_edge(a, b);
    let (bc, on_bc) = on_edge(b, c);
    let (ca, on_ca) = on_edge(c, a);
    let mut best = foot([1.0 - ab, ab, 0.0], on_ab);
    for other in [foot([0.0, 1.0 - bc, bc], on_bc), foot([ca, 0.0, 1.0 - ca], on_ca)] {
        if other.distance2 < best.distance2 {
            best = other;
        }
    }
    // The normal's length does not matter, so it is brought near one, where its square neither overflows nor vanishes.
    let (edge_b, edge_c) = (sub(b, a), sub(c, a));
    let normal = cross(edge_b, edge_c);
    let scale = 1.0 / normal[0].abs().max(normal[1].abs()).max(normal[2].abs());
    let unit = normal.map(|n| n * scale);
    let area = dot(normal, unit);
    let u = dot(cross(edge_c, a), unit) / area;
    let v = dot(cross(a, edge_b), unit) / area;
    let w = 1.0 - u - v;
    let rough = [0, 1, 2].map(|k| w * a[k] + u * b[k] + v * c[k]);
    let step = |p: [f32; 3], edge: [f32; 3]| {
        let s = (0.0 - dot(p, edge)) / dot(edge, edge);
        (s, [0, 1, 2].map(|k| p[k] + s * edge[k]))
    };
    let (more_b, nearer) = step(rough, edge_b);
    let (more_c, nearest) = step(nearer, edge_c);
    let (u, v) = (u + more_b, v + more_c);
    let w = 1.0 - u - v;
    if u >= 0.0 && v >= 0.0 && w >= 0.0 {
        let inside = foot([w, u, v], nearest);
        if inside.distance2 < best.distance2 {
            best = inside;
        }
    }
    let offset = [0, 1, 2].map(|k| {
        let (lower, upper) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
        let x = best.offset[k];
        let x = if x < lower { lower } else { x };
        // Never a negative zero, here and below.
        (if x > upper { upper } else { x }) + 0.0
    });
    ClosestCandidate { offset, distance2: dot(offset, offset), u: best.u + 0.0, v: best.v + 0.0, prim_id: 0 }
}

fn sub(p: [f32; 3], q: [f32; 3]) -> [f32; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

fn dot(p: [f32; 3], q: [f32; 3]) -> f32 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

fn cross(p: [f32; 3], q: [f32; 3]) -> [f32; 3] {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}

/// Feet on several triangles; fields as in [`ClosestCandidate`].
pub(crate) struct ClosestCandidateLanes<L> {
    pub offset: [L; 3],
    pub distance2: L,
    pub u: L,
    pub v: L,
}

/// The feet of zero on triangles whose `corners` are relative to it. Lanes without a triangle hold NaN, and give it.
#[inline(always)]
pub(crate) fn closest_points<const N: usize, L: Lanes<N>>([a, b, c]: [[L; 3]; 3]) -> ClosestCandidateLanes<L> {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let (ab, on_ab) = on_edge(a, b);
    let (bc, on_bc) = on_edge(b, c);
    let (ca, on_ca) = on_edge(c, a);
    let best = ClosestCandidateLanes { offset: on_ab, distance2: dot_lanes(on_ab, on_ab), u: ab, v: zero };
    let best =
        nearer(ClosestCandidateLanes { offset: on_bc, distance2: dot_lanes(on_bc, on_bc), u: one - bc, v: bc }, best);
    let best =
        nearer(ClosestCandidateLanes { offset: on_ca, distance2: dot_lanes(on_ca, on_ca), u: zero, v: one - ca }, best);

    let (edge_b, edge_c) = (sub_lanes(b, a), sub_lanes(c, a));
    let normal = cross_lanes(edge_b, edge_c);
    let scale = one / normal[0].abs().max(normal[1].abs()).max(normal[2].abs());
    let unit = [normal[0] * scale, normal[1] * scale, normal[2] * scale];
    let area = dot_lanes(normal, unit);
    let u = dot_lanes(cross_lanes(edge_c, a), unit) / area;
    let v = dot_lanes(cross_lanes(a, edge_b), unit) / area;
    let w = one - u - v;
    let rough = [w * a[0] + u * b[0] + v * c[0], w * a[1] + u * b[1] + v * c[1], w * a[2] + u * b[2] + v * c[2]];
    let (more_b, nearer_foot) = step(rough, edge_b);
    let (more_c, offset) = step(nearer_foot, edge_c);
    let (u, v) = (u + more_b, v + more_c);
    let w = one - u - v;
    let is_inside = zero.le(u) & zero.le(v) & zero.le(w);
    // Out of the way if it is outside: what is not a number is not nearer.
    let distance2 = L::select(is_inside, dot_lanes(offset, offset), L::splat(f32::NAN));
    let best = nearer(ClosestCandidateLanes { offset, distance2, u, v }, best);

    let [x, y, z] = best.offset;
    let offset =
        [clamp(x, [a[0], b[0], c[0]]) + zero, clamp(y, [a[1], b[1], c[1]]) + zero, clamp(z, [a[2], b[2], c[2]]) + zero];
    ClosestCandidateLanes { offset, distance2: dot_lanes(offset, offset), u: best.u + zero, v: best.v + zero }
}

/// How far along an edge from `p` zero is closest, and the point.
#[inline(always)]
fn step<const N: usize, L: Lanes<N>>(p: [L; 3], edge: [L; 3]) -> (L, [L; 3]) {
    let s = (L::splat(0.0) - dot_lanes(p, edge)) / dot_lanes(edge, edge);
    (s, [p[0] + s * edge[0], p[1] + s * edge[1], p[2] + s * edge[2]])
}

/// Where segments from `p` to `q` are closest to zero: the weight of `q`, and the point.
#[inline(always)]
fn on_edge<const N: usize, L: Lanes<N>>(p: [L; 3], q: [L; 3]) -> (L, [L; 3]) {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let edge = sub_lanes(q, p);
    let length2 = dot_lanes(edge, edge);
    let s = (zero - dot_lanes(p, edge)) / length2;
    let s = L::select(s.lt(zero), zero, s);
    let s = L::select(one.lt(s), one, s);
    let s = L::select(zero.lt(length2), s, zero);
    let rest = one - s;
    (s, [rest * p[0] + s * q[0], rest * p[1] + s * q[1], rest * p[2] + s * q[2]])
}

/// In each lane `foot` if it is nearer than `other`, else `other`.
#[inline(always)]
fn nearer<const N: usize, L: Lanes<N>>(
    foot: ClosestCandidateLanes<L>,
    other: ClosestCandidateLanes<L>,
) -> ClosestCandidateLanes<L> {
    let is_nearer = foot.distance2.lt(other.distance2);
    ClosestCandidateLanes {
        offset: [
            L::select(is_nearer, foot.offset[0], other.offset[0]),
            L::select(is_nearer, foot.offset[1], other.offset[1]),
            L::select(is_nearer, foot.offset[2], other.offset[2]),
        ],
        distance2: L::select(is_nearer, foot.distance2, other.distance2),
        u: L::select(is_nearer, foot.u, other.u),
        v: L::select(is_nearer, foot.v, other.v),
    }
}

/// `x` moved into the interval of three numbers.
#[inline(always)]
fn clamp<const N: usize, L: Lanes<N>>(x: L, [a, b, c]: [L; 3]) -> L {
    let (lower, upper) = (a.min(b).min(c), a.max(b).max(c));
    let x = L::select(x.lt(lower), lower, x);
    L::select(upper.lt(x), upper, x)
}

#[inline(always)]
fn sub_lanes<const N: usize, L: Lanes<N>>(p: [L; 3], q: [L; 3]) -> [L; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

#[inline(always)]
fn dot_lanes<const N: usize, L: Lanes<N>>(p: [L; 3], q: [L; 3]) -> L {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

#[inline(always)]
fn cross_lanes<const N: usize, L: Lanes<N>>(p: [L; 3], q: [L; 3]) -> [L; 3] {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}
