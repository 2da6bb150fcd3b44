//! Round cubic curves: a sphere swept along a Bézier curve, whose radius is a Bézier curve too.
//!
//! The curve is cut into `2^k` pieces of equal length in `u`, and each piece is the [linear curve](super::linear)
//! between its ends. Neighbours share the sphere between them, so there are no cracks. `k` depends on the curve alone.
//! Between its ends a piece strays from its chord by an eighth of the second derivative times the square of the step,
//! and so with `m = max |p[i] - 2 p[i + 1] + p[i + 2]|` (the sum of the magnitudes of the four components, the radius
//! being one)
//!
//! ```text
//! deviation <= 3/4 m 4^-k
//! ```
//!
//! `k` is the least number for which that is at most [`CUBIC_TOLERANCE`] of the greatest radius, and
//! [`MAX_CUBIC_HALVINGS`] at most.
//!
//! A ray meets few of the pieces. They are found from the whole curve down, eight parts at a time: a part lies within a
//! capsule around its chord whose radius is the greater one of its ends, and the deviation. There are four such steps
//! at most, and what is still to visit is one byte for each. This follows Nakamaru and Ohno 2002, "Ray Tracing for
//! Curves Primitive", but for the parts, which are evaluated and not split, and for the ends, which are spheres and not
//! flat ribbons.

use bytemuck::{Pod, Zeroable};
use glam::{DVec4, Vec3};

use super::frame::max;
use super::line_test::{Crossing, LineTest, Span};
use super::linear::{capsule_margin, cone_span};
use super::{PrimitiveFault, RayFrame, RoundPrimitive, Sphere, sphere_fault};
use crate::geometry::Aabb;

/// How far pieces may stray from a curve, in parts of its greatest radius.
pub const CUBIC_TOLERANCE: f64 = 1.0 / 256.0;
/// How often a curve is halved at most.
pub const MAX_CUBIC_HALVINGS: u32 = 12;

/// Parts that are tested together, and the halvings that make them.
const PARTS: usize = 8;
const PARTS_HALVINGS: u32 = 3;
/// Steps from the curve to its pieces, at most.
const MAX_STEPS: usize = MAX_CUBIC_HALVINGS.div_ceil(PARTS_HALVINGS) as usize;

/// A sphere swept along a cubic Bézier curve, hit from outside and inside. `u` of hits is the curve's parameter, 0..=1:
/// the centre of the sphere that touches the hit is there.
///
/// It deviates from the ideal by 1/256 of its greatest radius at most, or by 2⁻²⁴ of its second differences if that is
/// more: of the order of what control points are rounded by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct CubicCurve {
    /// The control points, and the control values of the radius, of which one is more than zero and none less.
    pub controls: [Sphere; 4],
}

impl CubicCurve {
    /// The curve of a uniform cubic B-spline over four of its control points.
    pub fn from_b_spline(points: &[Sphere; 4]) -> Self {
        let [a, b, c, d] = points.map(to_vector);
        let thirds = (b + b + c, b + c + c);
        from_vectors([(a + 4.0 * b + c) / 6.0, thirds.0 / 3.0, thirds.1 / 3.0, (b + 4.0 * c + d) / 6.0])
    }

    /// The curve of a uniform Catmull-Rom spline from the second of four points to the third. Control values of the
    /// radius that would be less than zero are zero.
    pub fn from_catmull_rom(points: &[Sphere; 4]) -> Self {
        let [a, b, c, d] = points.map(to_vector);
        from_vectors([b, b + (c - a) / 6.0, c - (d - b) / 6.0, c])
    }

    /// Curves along all points of a strand, by a Catmull-Rom spline: one less than there are points, none for fewer
    /// than two. At the ends the strand goes on as it comes in.
    pub fn strand(points: &[Sphere]) -> impl Iterator<Item = Self> {
        let mirrored = |end: Sphere, next: Sphere| Sphere {
            center: end.center + (end.center - next.center),
            radius: (end.radius + (end.radius - next.radius)).max(0.0),
        };
        (1..points.len()).map(move |i| {
            let (b, c) = (points[i - 1], points[i]);
            let a = if i > 1 { points[i - 2] } else { mirrored(b, c) };
            let d = points.get(i + 1).copied().unwrap_or(mirrored(c, b));
            Self::from_catmull_rom(&[a, b, c, d])
        })
    }
}

fn to_vector(point: Sphere) -> DVec4 {
    point.center.as_dvec3().extend(point.radius.into())
}

fn from_vectors(points: [DVec4; 4]) -> CubicCurve {
    let sphere = |p: DVec4| {
        let p = p.as_vec4();
        // False for NaN, which stays NaN.
        Sphere { center: Vec3::new(p.x, p.y, p.z), radius: if p.w < 0.0 { 0.0 } else { p.w } }
    };
    CubicCurve { controls: points.map(sphere) }
}

impl RoundPrimitive for CubicCurve {
    fn fault(&self) -> Option<PrimitiveFault> {
        sphere_fault(&self.controls)
    }

    /// A curve lies in the hull of its control points, and so do `x - r` and `x + r`.
    #[inline(always)]
    fn bounds(&self) -> Aabb {
        let [a, b, c, d] = &self.controls;
        a.bounds().union(&b.bounds()).union(&c.bounds()).union(&d.bounds())
    }
}

impl LineTest for CubicCurve {
    type Numbers = [f64; 16];
    const IS_CONVEX: bool = false;

    #[inline(always)]
    fn numbers(&self) -> [f64; 16] {
        let [a, b, c, d] = self.controls.map(|control| control.numbers());
        [a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3], c[0], c[1], c[2], c[3], d[0], d[1], d[2], d[3]]
    }

    /// Whether the line passes through the box along the chord around the control points, as seen along the line.
    #[inline(always)]
    fn margin(frame: &RayFrame, n: &[f64; 16]) -> f64 {
        let a = frame.place([n[0], n[1], n[2]]);
        let b = frame.place([n[4], n[5], n[6]]);
        let c = frame.place([n[8], n[9], n[10]]);
        let d = frame.place([n[12], n[13], n[14]]);
        let radius = max(max(n[3], n[7]), max(n[11], n[15]));
        let (ex, ey) = (d[0] - a[0], d[1] - a[1]);
        let reach = radius * radius * (ex * ex + ey * ey);
        let across = gap([a, b, c, d], -ey, ex);
        let along = gap([a, b, c, d], ex, ey);
        let (across, along) = (reach - across * across, reach - along * along);
        if across < along { across } else { along }
    }

    #[inline(always)]
    fn spans(frame: &RayFrame, numbers: &[f64; 16], backwards: bool, mut see: impl FnMut(Span)) {
        let pieces = Pieces::new(frame, numbers);
        pieces.for_each(backwards, |from, to| {
            let (a, b) = (pieces.at(from), pieces.at(to));
            if let Some(mut span) = cone_span(a, b) {
                span.enter.u = from + (to - from) * span.enter.u;
                span.exit.u = from + (to - from) * span.exit.u;
                see(span);
            }
        });
    }

    /// From the curve itself, which has no edges between pieces.
    fn smooth_outward(frame: &RayFrame, numbers: &[f64; 16], crossing: &Crossing) -> [f64; 3] {
        let [x, y, z, _] = Pieces::new(frame, numbers).at(crossing.u);
        [-x, -y, crossing.z - z]
    }
}

/// How far points that are seen along the z axis, and their hull, are from it in the direction of `x` and `y`.
#[inline(always)]
fn gap([a, b, c, d]: [[f64; 3]; 4], x: f64, y: f64) -> f64 {
    let [a, b, c, d] = [a[0] * x + a[1] * y, b[0] * x + b[1] * y, c[0] * x + c[1] * y, d[0] * x + d[1] * y];
    let (least, most) = (min(min(a, b), min(c, d)), max(max(a, b), max(c, d)));
    max(max(least, -most), 0.0)
}

#[inline(always)]
fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// A curve in the space of a ray, and the pieces that it is cut into.
struct Pieces {
    /// Coefficients of 1, `u`, `u²` and `u³`, for x, y, z and the radius.
    powers: [[f64; 4]; 4],
    /// How far the curve strays from its chord.
    deviation: f64,
    halvings: u32,
}

impl Pieces {
    #[inline(always)]
    fn new(frame: &RayFrame, n: &[f64; 16]) -> Self {
        let mut bend = 0.0;
        for first in [0, 4] {
            let mut sum = 0.0;
            for i in first..first + 4 {
                sum += (n[i] - 2.0 * n[i + 4] + n[i + 8]).abs();
            }
            bend = max(bend, sum);
        }
        let deviation = 0.75 * bend;
        let tolerance = CUBIC_TOLERANCE * max(max(n[3], n[7]), max(n[11], n[15]));
        let (mut halvings, mut left) = (0, deviation);
        while left > tolerance && halvings < MAX_CUBIC_HALVINGS {
            left *= 0.25;
            halvings += 1;
        }
        let a = frame.place_sphere(n[0], n[1], n[2], n[3]);
        let b = frame.place_sphere(n[4], n[5], n[6], n[7]);
        let c = frame.place_sphere(n[8], n[9], n[10], n[11]);
        let d = frame.place_sphere(n[12], n[13], n[14], n[15]);
        let mut powers = [[0.0; 4]; 4];
        for (i, power) in powers.iter_mut().enumerate() {
            let (ab, bc) = (b[i] - a[i], c[i] - b[i]);
            *power = [a[i], 3.0 * ab, 3.0 * (bc - ab), d[i] - a[i] - 3.0 * bc];
        }
        Self { powers, deviation, halvings }
    }

    /// The place and the radius at a parameter.
    #[inline(always)]
    fn at(&self, u: f64) -> [f64; 4] {
        let [x, y, z, radius] = self.powers;
        [horner(x, u), horner(y, u), horner(z, u), max(horner(radius, u), 0.0)]
    }

    /// Shows the parameters at the ends of each piece near the z axis, in order.
    #[inline(always)]
    fn for_each(&self, backwards: bool, mut see: impl FnMut(f64, f64)) {
        if self.halvings == 0 {
            return see(0.0, 1.0);
        }
        // Of each step the parts still to visit, and the index of the first.
        let (mut left, mut first) = ([0u8; PARTS], [0u32; PARTS]);
        const { assert!(MAX_STEPS <= PARTS) }
        let mut step = 0;
        left[0] = self.parts_near(0, 0);
        loop {
            let here = step & (PARTS - 1);
            if left[here] == 0 {
                if step == 0 {
                    return;
                }
                step -= 1;
                continue;
            }
            let part = if backwards { 7 - left[here].leading_zeros() } else { left[here].trailing_zeros() };
            left[here] ^= 1 << part;
            let part = first[here] + part;
            let halvings = self.halvings_after(step as u32);
            if halvings == self.halvings {
                let size = size_after(halvings);
                see(f64::from(part) * size, f64::from(part + 1) * size);
            } else {
                step += 1;
                let next = step & (PARTS - 1);
                first[next] = part << (self.halvings_after(step as u32) - halvings);
                left[next] = self.parts_near(first[next], step as u32);
            }
        }
    }

    /// How often the curve has been halved by the end of a step.
    #[inline(always)]
    fn halvings_after(&self, step: u32) -> u32 {
        ((step + 1) * PARTS_HALVINGS).min(self.halvings)
    }

    /// Those of a step's parts that may meet the z axis, a bit each, from the part of this index on.
    #[inline(always)]
    fn parts_near(&self, first: u32, step: u32) -> u8 {
        let halvings = self.halvings_after(step);
        let size = size_after(halvings);
        // The pieces themselves are their chords.
        let stray = if halvings == self.halvings { 0.0 } else { self.deviation * size * size };
        let [x, y, _, radius] = self.powers;
        let mut margins = [0.0; PARTS];
        for (part, margin) in margins.iter_mut().enumerate() {
            let (from, to) = (f64::from(first + part as u32) * size, f64::from(first + part as u32 + 1) * size);
            let a = [horner(x, from), horner(y, from)];
            let b = [horner(x, to), horner(y, to)];
            let wide = max(max(horner(radius, from), horner(radius, to)), 0.0);
            *margin = capsule_margin(a, b, wide + stray);
        }
        let mut near = 0;
        for (part, margin) in margins.iter().enumerate() {
            near |= u8::from(*margin >= 0.0) << part;
        }
        let parts = 1u32 << (halvings - step * PARTS_HALVINGS);
        near & ((1u32 << parts) - 1) as u8
    }
}

#[inline(always)]
fn horner([a, b, c, d]: [f64; 4], u: f64) -> f64 {
    a + u * (b + u * (c + u * d))
}

/// The size of a part after so many halvings.
#[inline(always)]
fn size_after(halvings: u32) -> f64 {
    1.0 / f64::from(1u32 << halvings)
}
