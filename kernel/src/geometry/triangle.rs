//! The triangle test in lanes: one ray against several triangles, or several rays against one.
//!
//! It equals the scalar [`intersect_triangle`](super::intersect_triangle) bit for bit.

#[cfg(doc)]
use super::setup::Line;
use super::setup::{MIN_DETERMINANT, OWN_PAD};
use crate::simd::{Lanes, Mask, lanes_of};

/// Lines in lanes: one ray's in all of them, or one in each. Fields as in [`Line`].
#[derive(Clone, Copy)]
pub(crate) struct LineLanes<L> {
    pub origin: [L; 3],
    pub inverse: [L; 3],
    pub shear: [L; 2],
}

impl<L> LineLanes<L> {
    /// The line of these [numbers](Line::numbers) in every lane.
    #[inline(always)]
    pub(crate) fn splat<const N: usize>(numbers: &[f32; 8]) -> Self
    where
        L: Lanes<N>,
    {
        let [ox, oy, oz, ix, iy, iz, sx, sy] = *numbers;
        Self::new([
            L::splat(ox),
            L::splat(oy),
            L::splat(oz),
            L::splat(ix),
            L::splat(iy),
            L::splat(iz),
            L::splat(sx),
            L::splat(sy),
        ])
    }

    /// From the [numbers](Line::numbers) of the lines.
    #[inline(always)]
    pub(crate) fn new([ox, oy, oz, ix, iy, iz, sx, sy]: [L; 8]) -> Self {
        Self { origin: [ox, oy, oz], inverse: [ix, iy, iz], shear: [sx, sy] }
    }
}

/// Where lanes meet their triangles, whatever their `t` intervals: only lanes of `bits` mean anything.
pub(crate) struct Crossing<L> {
    pub bits: u32,
    /// The lanes that come from the front.
    pub front: u32,
    pub t: L,
    pub u: L,
    pub v: L,
}

/// The crossing of rays and triangles; `None` if there is none in any lane. Corners are in the order of the class's
/// axes; lanes without a triangle hold NaN.
#[inline(always)]
pub(crate) fn cross<const N: usize, L: Lanes<N>>(ray: &LineLanes<L>, corners: [[L; 3]; 3]) -> Option<Crossing<L>> {
    let zero = L::splat(0.0);
    let [a, b, c] = [sub(corners[0], ray.origin), sub(corners[1], ray.origin), sub(corners[2], ray.origin)];
    let sheared = [shear(a, ray.shear), shear(b, ray.shear), shear(c, ray.shear)];
    let [u, v, w] = areas(sheared);
    let mut bits = of_one_sign([u, v, w]);
    if bits == 0 {
        return None;
    }
    let [[ax, ay], [bx, by], [cx, cy]] = sheared;
    let sum = u + v + w;
    let doubtful = u.eq(zero) | v.eq(zero) | w.eq(zero) | sum.abs().lt(L::splat(MIN_DETERMINANT));
    let inverse = L::splat(1.0) / sum;
    let (mut u, mut v, mut w) = (u * inverse, v * inverse, w * inverse);
    let mut front = zero.lt(sum).bits();
    let doubtful = bits & doubtful.bits();
    if doubtful != 0 {
        let sheared = [ax.store(), ay.store(), bx.store(), by.store(), cx.store(), cy.store()];
        let mut weights = [u.store(), v.store(), w.store()];
        (bits, front) = decide_in_f64(&sheared, (bits, front), doubtful, &mut weights);
        if bits == 0 {
            return None;
        }
        (u, v, w) = (L::load(&weights[0]), L::load(&weights[1]), L::load(&weights[2]));
    }
    let (u, v, w) = refine([ax, ay], [bx, by], [cx, cy], [u, v, w]);
    // Adding zero makes a negative zero positive: backends differ in which one they give.
    let t = (u * a[2] + v * b[2] + w * c[2]) * ray.inverse[2] + zero;

    let (near, far) = own_box(ray, [a, b, c]);
    let t = L::select(t.lt(near), near + zero, t);
    let t = L::select(far.lt(t), far + zero, t);
    bits &= near.le(far).bits();
    Some(Crossing { bits, front, t, u: unit(v), v: unit(w) })
}

/// The lanes whose lines cross their triangles in their intervals: [`cross`] and `t` within, but faster, as the line's
/// interval in the triangle's box mostly decides.
#[inline(always)]
pub(crate) fn occludes<const N: usize, L: Lanes<N>>(
    ray: &LineLanes<L>,
    corners: [[L; 3]; 3],
    [t_min, t_max]: [L; 2],
) -> u32 {
    let zero = L::splat(0.0);
    let [a, b, c] = [sub(corners[0], ray.origin), sub(corners[1], ray.origin), sub(corners[2], ray.origin)];
    let [u, v, w] = areas([shear(a, ray.shear), shear(b, ray.shear), shear(c, ray.shear)]);
    let inside = of_one_sign([u, v, w]);
    if inside == 0 {
        return 0;
    }
    let (near, far) = own_box(ray, [a, b, c]);
    let inside = inside & (near.le(far) & near.le(t_max) & t_min.le(far)).bits();
    let whole = t_min.le(near) & far.le(t_max);
    let strictly = zero.lt(u.min(v).min(w)) | u.max(v).max(w).lt(zero);
    let certain = strictly & L::splat(MIN_DETERMINANT).le((u + v + w).abs()) & whole;
    if inside & !certain.bits() == 0 {
        return inside;
    }
    match cross(ray, corners) {
        Some(crossing) => crossing.bits & (t_min.le(crossing.t) & crossing.t.le(t_max)).bits(),
        None => 0,
    }
}

/// The lanes whose line passes inside of their triangle's edges, or on one as far as `f32` can tell: where there may be
/// a [crossing](cross).
#[inline(always)]
pub(crate) fn inside<const N: usize, L: Lanes<N>>(ray: &LineLanes<L>, corners: [[L; 3]; 3]) -> u32 {
    let (a, b, c) = (sub(corners[0], ray.origin), sub(corners[1], ray.origin), sub(corners[2], ray.origin));
    of_one_sign(areas([shear(a, ray.shear), shear(b, ray.shear), shear(c, ray.shear)]))
}

/// Twice the areas opposite the corners: edge functions of the origin.
#[inline(always)]
fn areas<const N: usize, L: Lanes<N>>([[ax, ay], [bx, by], [cx, cy]]: [[L; 2]; 3]) -> [L; 3] {
    [cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax]
}

/// The lanes in which no two of the areas have opposite signs: the origin is inside.
#[inline(always)]
fn of_one_sign<const N: usize, L: Lanes<N>>([u, v, w]: [L; 3]) -> u32 {
    let zero = L::splat(0.0);
    (zero.le(u.min(v).min(w)) | u.max(v).max(w).le(zero)).bits()
}

#[inline(always)]
fn sub<const N: usize, L: Lanes<N>>(p: [L; 3], q: [L; 3]) -> [L; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

#[inline(always)]
fn shear<const N: usize, L: Lanes<N>>(p: [L; 3], shear: [L; 2]) -> [L; 2] {
    [p[0] - shear[0] * p[2], p[1] - shear[1] * p[2]]
}

/// The least and the greatest.
#[inline(always)]
fn range<const N: usize, L: Lanes<N>>([a, b, c]: [L; 3]) -> [L; 2] {
    [a.min(b).min(c), a.max(b).max(c)]
}

/// How far from zero it goes.
#[inline(always)]
fn reach<const N: usize, L: Lanes<N>>([lower, upper]: [L; 2]) -> L {
    lower.abs().max(upper.abs())
}

/// Weights with which the corners' mean is nearer to the ray; one may be slightly below zero. The areas of a needle are
/// small differences, and along it the mean strays by a rounding times length over width: it is moved back along the
/// longest edge.
#[inline(always)]
fn refine<const N: usize, L: Lanes<N>>(a: [L; 2], b: [L; 2], c: [L; 2], [u, v, w]: [L; 3]) -> (L, L, L) {
    let stray = [u * a[0] + v * b[0] + w * c[0], u * a[1] + v * b[1] + w * c[1]];
    let (ab, bc, ca) = ([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]], [a[0] - c[0], a[1] - c[1]]);
    let (ab2, bc2, ca2) = (dot(ab, ab), dot(bc, bc), dot(ca, ca));
    let zero = L::splat(0.0);
    let ab_longest = bc2.le(ab2) & ca2.le(ab2);
    let bc_longest = ca2.le(bc2);
    let along = L::select(ab_longest, dot(stray, ab), L::select(bc_longest, dot(stray, bc), dot(stray, ca)));
    let length = ab2.max(bc2).max(ca2);
    let shift = L::select(L::splat(MIN_DETERMINANT).le(length), along / length, zero);
    // From the edge's end to its beginning: `shift` of the weight.
    let to_u = L::select(ab_longest, shift, L::select(bc_longest, zero, zero - shift));
    let to_v = L::select(ab_longest, zero - shift, L::select(bc_longest, shift, zero));
    let to_w = L::select(ab_longest, zero, L::select(bc_longest, zero - shift, shift));
    (u + to_u, v + to_v, w + to_w)
}

#[inline(always)]
fn dot<const N: usize, L: Lanes<N>>(p: [L; 2], q: [L; 2]) -> L {
    p[0] * q[0] + p[1] * q[1]
}

/// A weight in 0..=1, never a negative zero.
#[inline(always)]
fn unit<const N: usize, L: Lanes<N>>(x: L) -> L {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let x = L::select(x.lt(zero), zero, x);
    L::select(one.lt(x), one, x) + zero
}

/// The interval in which the ray is inside the triangle's own box; corners are relative to its origin.
#[inline(always)]
fn own_box<const N: usize, L: Lanes<N>>(ray: &LineLanes<L>, [a, b, c]: [[L; 3]; 3]) -> (L, L) {
    let (x, y, z) = (range([a[0], b[0], c[0]]), range([a[1], b[1], c[1]]), range([a[2], b[2], c[2]]));
    let reach_z = reach(z);
    let (near_x, far_x) = interval(ray.inverse[0], x, reach_z);
    let (near_y, far_y) = interval(ray.inverse[1], y, reach_z);
    let (near_z, far_z) = interval(ray.inverse[2], z, reach_z);
    (near_x.max(near_y).max(near_z), far_x.min(far_y).min(far_z))
}

/// Where the ray enters and leaves the slab of one axis between two bounds, widened by their error.
#[inline(always)]
fn interval<const N: usize, L: Lanes<N>>(inverse: L, [lower, upper]: [L; 2], reach_z: L) -> (L, L) {
    let pad = (reach([lower, upper]) + reach_z) * L::splat(OWN_PAD);
    let (lower, upper) = ((lower - pad) * inverse, (upper + pad) * inverse);
    (lower.min(upper), lower.max(upper))
}

/// Decides `lanes` again where `f32` could not: an edge function is zero, or all are near underflow. Products of `f32`
/// are exact in `f64`, so the signs are. Takes and gives the masks of the lanes inside and of those in front.
#[cold]
#[inline(never)]
fn decide_in_f64<const N: usize>(
    sheared: &[[f32; N]; 6],
    (mut inside, mut front): (u32, u32),
    lanes: u32,
    weights: &mut [[f32; N]; 3],
) -> (u32, u32) {
    for i in lanes_of(lanes) {
        let [ax, ay, bx, by, cx, cy] = sheared.map(|x| x[i] as f64);
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        let sum = u + v + w;
        let same_sign = u.min(v).min(w) >= 0.0 || u.max(v).max(w) <= 0.0;
        if same_sign && sum != 0.0 {
            for (weight, area) in weights.iter_mut().zip([u, v, w]) {
                weight[i] = (area / sum) as f32;
            }
            front = front & !(1 << i) | u32::from(sum > 0.0) << i;
        } else {
            inside &= !(1 << i);
        }
    }
    (inside, front)
}
