//! Round linear curves: a sphere swept along a segment, with a radius that changes evenly.
//!
//! The swept solid is the convex hull of the spheres at the ends: these, and between them a cone that touches both.
//! With the axis `a + u e`, the radius `r - u δ` and `D = e·e - δ²`, a point `x` is nearest to the surface of the
//! sphere of
//!
//! ```text
//! u(x) = ((x - a)·e - r δ) / D
//! ```
//!
//! and is on the cone where `|x - a|² - r² = D u²`, if `0 <= u <= 1`. If `D <= 0`, one sphere is within the other. Put
//! into the line `x = (0, 0, z)` of the ray's own space that is a quadratic equation in `z`. The axis' point that is
//! nearest to the line stands in for `a` and its depth for `z = 0`, so that nothing cancels however far the ray comes
//! from, and however thin and long the curve is.

use bytemuck::{Pod, Zeroable};

use super::frame::{dot, max};
use super::line_test::{LineTest, Span};
use super::{PrimitiveFault, RayFrame, RoundPrimitive, Sphere, sphere_fault};
use crate::geometry::Aabb;

/// A sphere swept along a segment, from one end to the other: a cone or a cylinder with round ends, hit from outside
/// and inside. `u` of hits goes from 0 at the first end to 1 at the second; the centre of the sphere that touches the
/// hit is there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LinearCurve {
    /// The spheres at the ends. One of them may have the radius zero.
    pub ends: [Sphere; 2],
}

impl RoundPrimitive for LinearCurve {
    fn fault(&self) -> Option<PrimitiveFault> {
        sphere_fault(&self.ends)
    }

    #[inline(always)]
    fn bounds(&self) -> Aabb {
        self.ends[0].bounds().union(&self.ends[1].bounds())
    }
}

impl LineTest for LinearCurve {
    type Numbers = [f64; 8];
    const IS_CONVEX: bool = true;

    #[inline(always)]
    fn numbers(&self) -> [f64; 8] {
        let [[ax, ay, az, ar], [bx, by, bz, br]] = [self.ends[0].numbers(), self.ends[1].numbers()];
        [ax, ay, az, ar, bx, by, bz, br]
    }

    #[inline(always)]
    fn margin(frame: &RayFrame, &[ax, ay, az, ar, bx, by, bz, br]: &[f64; 8]) -> f64 {
        let (a, b) = (frame.place([ax, ay, az]), frame.place([bx, by, bz]));
        capsule_margin([a[0], a[1]], [b[0], b[1]], if ar > br { ar } else { br })
    }

    #[inline(always)]
    fn spans(frame: &RayFrame, numbers: &[f64; 8], _backwards: bool, mut see: impl FnMut(Span)) {
        let &[ax, ay, az, ar, bx, by, bz, br] = numbers;
        let (a, b) = (frame.place_sphere(ax, ay, az, ar), frame.place_sphere(bx, by, bz, br));
        if let Some(span) = cone_span(a, b) {
            see(span);
        }
    }
}

/// How much less the square of the distance between the z axis and a segment that is seen along it is than that of a
/// radius.
#[inline(always)]
pub(super) fn capsule_margin(a: [f64; 2], b: [f64; 2], radius: f64) -> f64 {
    let (ex, ey) = (b[0] - a[0], b[1] - a[1]);
    let foot = foot(a, [ex, ey]);
    let (x, y) = (a[0] + foot * ex, a[1] + foot * ey);
    radius * radius - x * x - y * y
}

/// How far along an edge from `a` the point is that is nearest to zero, in 0..=1.
#[inline(always)]
fn foot(a: [f64; 2], [ex, ey]: [f64; 2]) -> f64 {
    let foot = -(a[0] * ex + a[1] * ey) / (ex * ex + ey * ey);
    // False for NaN.
    let foot = if foot > 0.0 { foot } else { 0.0 };
    if foot < 1.0 { foot } else { 1.0 }
}

/// The part of the z axis inside of the convex hull of two spheres, each with its centre and radius.
#[inline(always)]
pub(super) fn cone_span(a: [f64; 4], b: [f64; 4]) -> Option<Span> {
    let e = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let delta = a[3] - b[3];
    let mut span = None;
    for (end, u) in [(a, 0.0), (b, 1.0)] {
        let square = end[3] * end[3] - end[0] * end[0] - end[1] * end[1];
        if square >= 0.0 {
            let half = libm::sqrt(square);
            Span::grow(&mut span, end[2] - half, u);
            Span::grow(&mut span, end[2] + half, u);
        }
    }
    let flat = e[0] * e[0] + e[1] * e[1];
    let long = flat + e[2] * e[2] - delta * delta;
    if long > 0.0 {
        let foot = foot([a[0], a[1]], [e[0], e[1]]);
        let p = [a[0] + foot * e[0], a[1] + foot * e[1], a[2] + foot * e[2]];
        let radius = a[3] - foot * delta;
        // `A z² + 2 B z + C = 0`, and the part of `u D` that is the same for all `z`.
        let off = p[0] * p[0] + p[1] * p[1] - radius * radius;
        let along = -(p[0] * e[0] + p[1] * e[1]) - radius * delta;
        let square = flat - delta * delta;
        let middle = -e[2] * along;
        let discriminant = long * (along * along - square * off);
        if discriminant >= 0.0 {
            let sum = -(middle + libm::sqrt(discriminant).copysign(middle));
            for z in [sum / square, (long * off - along * along) / sum] {
                let u = foot + (along + z * e[2]) / long;
                // False for NaN.
                if (0.0..=1.0).contains(&u) {
                    Span::grow(&mut span, p[2] + z, u);
                }
            }
        }
    }
    let mut span = span?;
    for (end, is_exit) in [(&mut span.enter, false), (&mut span.exit, true)] {
        let u = end.u;
        end.outward = [-(a[0] + u * e[0]), -(a[1] + u * e[1]), end.z - (a[2] + u * e[2])];
        if a[3] - u * delta <= THIN * end.z.abs() {
            end.outward = thin_outward(e, delta, is_exit);
        }
    }
    Some(span)
}

/// A radius less than this times the distance is too small for a normal to be told from the centre: what is left has
/// too few digits.
const THIN: f64 = 1.0 / (1u64 << 32) as f64;

/// The normal of such a thin cone: the normal of a plane that touches the whole cone, on the side where the line
/// enters, or leaves.
#[inline(always)]
fn thin_outward(e: [f64; 3], delta: f64, is_exit: bool) -> [f64; 3] {
    let (side, square) = (if is_exit { 1.0 } else { -1.0 }, dot(e, e));
    let along = e[2] / square;
    let across = [-along * e[0], -along * e[1], 1.0 - along * e[2]];
    let length = libm::sqrt(dot(across, across));
    if square == 0.0 || length == 0.0 {
        return [0.0, 0.0, side];
    }
    let (sin, cos) = (delta / libm::sqrt(square), libm::sqrt(max(square - delta * delta, 0.0)));
    let (m, n) = (side * cos / length, sin);
    [across[0] * m + e[0] * n, across[1] * m + e[1] * n, across[2] * m + e[2] * n]
}
