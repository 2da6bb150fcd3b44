//! Rays in lanes made ready together: the numbers of [`RaySetup`](super::setup::RaySetup), bit for bit, where they run on
//! one course, and a hull that no ray of them leaves.
//!
//! The hull is what Embree calls a frustum (Wald et al. 2014): for each axis the box of the origins, and the least and the
//! greatest reciprocal of the directions. Along an axis on which all rays run upwards,
//! `(plane - highest origin) * least inverse` is no later than any of them passes the plane, and
//! `(plane - lowest origin) * greatest inverse` no earlier, if they pass it ahead of their origins; if the plane lies behind
//! an origin, what comes out is not positive. So for `t_min >= 0` a box that the hull misses is missed by all rays. The
//! pads are those of the rays, of which the rounding here uses a part that a ray's own test leaves.

use glam::Vec3;

use super::setup::{
    Axis, LEAST_COMPONENT, MAX_COORDINATE, MAX_DIRECTION, MIN_DIRECTION, NODE_ORIGIN_PAD, NODE_PAD, UNDERFLOW_PAD,
};
use super::triangle::LineLanes;
use super::{Aabb, RayPacket};
use crate::simd::{Lanes, Mask};

/// What decides which code rays take: rays on one course can share it.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Course {
    /// The axes in the order of [`Line`](super::setup::Line).
    pub axes: [Axis; 3],
    /// Whether directions are negative along x, y and z.
    pub negative: [bool; 3],
}

/// Rays of a packet in lanes.
pub(crate) struct Bundle<L> {
    origin: [L; 3],
    direction: [L; 3],
    largest: L,
    /// Their least `t`.
    pub t_min: L,
    /// The active rays that can hit something.
    pub live: u32,
}

/// What boxes are tested with for all rays at once.
#[derive(Clone, Copy)]
pub(crate) struct Hull {
    pub near_inverse: [f32; 3],
    pub near_shift: [f32; 3],
    pub far_inverse: [f32; 3],
    pub far_shift: [f32; 3],
}

impl<L: Copy> Bundle<L> {
    #[inline(always)]
    pub(crate) fn new<const N: usize>(rays: &RayPacket<N>, scene: &Aabb) -> Self
    where
        L: Lanes<N>,
    {
        let origin: [L; 3] = three(&rays.origin);
        let direction: [L; 3] = three(&rays.direction);
        let (t_min, t_max) = (L::load(&rays.t_min), L::load(&rays.t_max));
        let size = [direction[0].abs(), direction[1].abs(), direction[2].abs()];
        let largest = size[0].max(size[1]).max(size[2]);
        // Each component by itself: a maximum may lose a NaN.
        let (coordinate, length) = (L::splat(MAX_COORDINATE), L::splat(MAX_DIRECTION));
        let valid = origin[0].abs().le(coordinate)
            & origin[1].abs().le(coordinate)
            & origin[2].abs().le(coordinate)
            & size[0].le(length)
            & size[1].le(length)
            & size[2].le(length)
            & L::splat(MIN_DIRECTION).le(largest)
            & t_min.le(t_max);
        let live = if scene.is_empty() { 0 } else { valid.bits() & rays.active };
        Self { origin, direction, largest, t_min, live }
    }

    /// The course of the first ray of `rays`, which are not none, and which of them share it.
    #[inline(always)]
    pub(crate) fn course<const N: usize>(&self, packet: &RayPacket<N>, rays: u32) -> (Course, u32)
    where
        L: Lanes<N>,
    {
        let first = rays.trailing_zeros() as usize % N;
        let mut sharing = rays;
        let mut negative = [false; 3];
        for axis in 0..3 {
            let signs = signs(&packet.direction[axis]);
            negative[axis] = signs >> first & 1 != 0;
            sharing &= if negative[axis] { signs } else { !signs };
        }
        let fastest = |axis: usize| self.direction[axis].abs().eq(self.largest).bits();
        let (x, y) = (fastest(0), fastest(1));
        let (z, along) = match (x >> first & 1 != 0, y >> first & 1 != 0) {
            (true, _) => (0, x),
            (false, true) => (1, y & !x),
            (false, false) => (2, !x & !y),
        };
        (Course { axes: Axis::course(z, negative[z]), negative }, sharing & along)
    }

    /// What triangles are tested with: for the lanes on `course` the numbers of [`Line`](super::setup::Line).
    #[inline(always)]
    pub(crate) fn lines<const N: usize>(&self, course: &Course) -> LineLanes<L>
    where
        L: Lanes<N>,
    {
        let [x, y, z] = course.axes.map(|axis| axis as usize);
        let (d, o) = (&self.direction, &self.origin);
        let inverse = [self.inverse(course, x), self.inverse(course, y), self.inverse(course, z)];
        LineLanes { origin: [o[x], o[y], o[z]], inverse, shear: [d[x] * inverse[2], d[y] * inverse[2]] }
    }

    /// The reciprocal of the direction along an axis, with small components raised.
    #[inline(always)]
    fn inverse<const N: usize>(&self, course: &Course, axis: usize) -> L
    where
        L: Lanes<N>,
    {
        let least = self.largest * L::splat(LEAST_COMPONENT);
        let signed = if course.negative[axis] { L::splat(0.0) - least } else { least };
        let d = self.direction[axis];
        L::splat(1.0) / L::select(d.abs().lt(least), signed, d)
    }

    /// A hull of `rays`, which are on `course` and not none.
    #[inline(always)]
    pub(crate) fn hull<const N: usize>(&self, course: &Course, lines: &LineLanes<L>, rays: u32, scene: &Aabb) -> Hull
    where
        L: Lanes<N>,
    {
        let rays = L::Mask::from_bits(rays);
        let mut hull = Hull { near_inverse: [0.0; 3], near_shift: [0.0; 3], far_inverse: [0.0; 3], far_shift: [0.0; 3] };
        let (mut low, mut high) = (Vec3::ZERO, Vec3::ZERO);
        for k in 0..3 {
            let axis = course.axes[k] as usize;
            (low[axis], high[axis]) = range(rays, lines.origin[k]);
            let (least, greatest) = range(rays, lines.inverse[k]);
            (hull.near_inverse[axis], hull.far_inverse[axis]) =
                if course.negative[axis] { (greatest, least) } else { (least, greatest) };
        }
        let reach = (scene.max - low).abs().max((scene.max - high).abs());
        let reach = reach.max((scene.min - low).abs()).max((scene.min - high).abs());
        let pad = (reach + reach[course.axes[2] as usize]) * NODE_PAD + low.abs().max(high.abs()) * NODE_ORIGIN_PAD;
        for axis in 0..3 {
            let (last, first) = if course.negative[axis] {
                (low[axis] - pad[axis], high[axis] + pad[axis])
            } else {
                (high[axis] + pad[axis], low[axis] - pad[axis])
            };
            hull.near_shift[axis] = last * hull.near_inverse[axis] + UNDERFLOW_PAD;
            hull.far_shift[axis] = first * hull.far_inverse[axis] - UNDERFLOW_PAD;
        }
        hull
    }
}

/// The least and the greatest of the lanes in `rays`, which are not none.
#[inline(always)]
fn range<const N: usize, L: Lanes<N>>(rays: L::Mask, lanes: L) -> (f32, f32) {
    let mut least = L::select(rays, lanes, L::splat(f32::INFINITY)).store();
    let mut greatest = L::select(rays, lanes, L::splat(f32::NEG_INFINITY)).store();
    let mut half = N / 2;
    while half > 0 {
        for lane in 0..half {
            let (a, b) = (least[lane + half], greatest[lane + half]);
            least[lane] = if a < least[lane] { a } else { least[lane] };
            greatest[lane] = if b > greatest[lane] { b } else { greatest[lane] };
        }
        half /= 2;
    }
    (least[0], greatest[0])
}

/// The greatest of the lanes.
#[inline(always)]
pub(crate) fn greatest<const N: usize, L: Lanes<N>>(lanes: L) -> f32 {
    range::<N, L>(L::Mask::from_bits(u32::MAX), lanes).1
}

/// The sign bits, those of zeros and NaN too.
#[inline(always)]
fn signs<const N: usize>(values: &[f32; N]) -> u32 {
    let mut signs = 0;
    for (lane, value) in values.iter().enumerate() {
        signs |= (value.to_bits() >> 31) << lane;
    }
    signs
}

#[inline(always)]
fn three<const N: usize, L: Lanes<N>>(axes: &[[f32; N]; 3]) -> [L; 3] {
    [L::load(&axes[0]), L::load(&axes[1]), L::load(&axes[2])]
}
