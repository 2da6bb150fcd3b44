//! Setup of a packet of rays in lanes: equal to [`RaySetup`](super::setup::RaySetup) bit for bit, for directions of one
//! class, and the [`Shaft`] that encloses them.

use glam::Vec3;

use super::setup::{
    Axis, MAX_COORDINATE, MAX_DIRECTION, MIN_COMPONENT, MIN_DIRECTION, NODE_ORIGIN_PAD, NODE_PAD, UNDERFLOW_PAD, raise,
};
use super::shaft::{Shaft, Surroundings};
use super::triangle::LineLanes;
use super::{Aabb, RayPacket};
use crate::simd::{Lanes, Mask};

/// Octant and fastest axis of a direction: what decides which planes are near, and along which axis triangles are
/// sheared.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct DirectionClass {
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
    /// The active rays that can hit anything.
    pub live: u32,
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
        // Each component on its own: a maximum may lose a NaN.
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

    /// The direction class of the first ray of `rays`, a non-empty mask, and which of the rays share it.
    #[inline(always)]
    fn class<const N: usize>(&self, rays: u32) -> (DirectionClass, u32)
    where
        L: Lanes<N>,
    {
        let first = rays.trailing_zeros() as usize % N;
        let mut sharing = rays;
        let mut negative = [false; 3];
        for (negative, &direction) in negative.iter_mut().zip(&self.direction) {
            let signs = signs(direction);
            *negative = signs >> first & 1 != 0;
            sharing &= if *negative { signs } else { !signs };
        }
        let fastest = |axis: usize| self.direction[axis].abs().eq(self.largest).bits();
        let (x, y) = (fastest(0), fastest(1));
        let (z, along) = match (x >> first & 1 != 0, y >> first & 1 != 0) {
            (true, _) => (0, x),
            (false, true) => (1, y & !x),
            (false, false) => (2, !x & !y),
        };
        (DirectionClass { axes: Axis::permutation(z, negative[z]), negative }, sharing & along)
    }

    /// Takes the first of the rays `waiting`, a non-empty mask, and those that can be traced together with it: they
    /// share its direction class, are among `alike`, as it is, and begin ahead of their origins. A ray that does not is
    /// taken alone.
    #[inline(always)]
    pub(crate) fn take_part<const N: usize>(&self, waiting: &mut u32, alike: u32) -> (DirectionClass, u32)
    where
        L: Lanes<N>,
    {
        let (class, sharing) = self.class(*waiting);
        let first = sharing & sharing.wrapping_neg();
        let ahead = L::splat(0.0).le(self.t_min).bits();
        let rays = if first & ahead == 0 { first } else { sharing & ahead & alike };
        *waiting &= !rays;
        (class, rays)
    }

    /// What triangles are tested with: for the lanes of `class` the numbers of [`Line`](super::setup::Line).
    #[inline(always)]
    pub(crate) fn lines<const N: usize>(&self, class: &DirectionClass) -> LineLanes<L>
    where
        L: Lanes<N>,
    {
        let [x, y, z] = class.axes.map(|axis| axis as usize);
        let (d, o) = (&self.direction, &self.origin);
        let inverse = [self.inverse(class, x), self.inverse(class, y), self.inverse(class, z)];
        LineLanes { origin: [o[x], o[y], o[z]], inverse, shear: [d[x] * inverse[2], d[y] * inverse[2]] }
    }

    /// The reciprocal of the direction along an axis, with small components raised.
    #[inline(always)]
    fn inverse<const N: usize>(&self, class: &DirectionClass, axis: usize) -> L
    where
        L: Lanes<N>,
    {
        let least = self.largest * L::splat(MIN_COMPONENT);
        let signed = if class.negative[axis] { L::splat(0.0) - least } else { least };
        let d = self.direction[axis];
        L::splat(1.0) / L::select(d.abs().lt(least), signed, d)
    }

    /// What nodes' boxes are tested with, in the order of the axes: the reciprocals, and the shifts to near and to far
    /// planes of [`Slabs`](super::setup::Slabs), with the larger pad of the shaft.
    #[inline(always)]
    pub(crate) fn slabs<const N: usize>(
        &self,
        class: &DirectionClass,
        lines: &LineLanes<L>,
        shaft: &Shaft,
    ) -> ([L; 3], [L; 3], [L; 3])
    where
        L: Lanes<N>,
    {
        let (mut near, mut far) = (lines.origin, lines.origin);
        for k in 0..3 {
            let axis = class.axes[k] as usize;
            let pad = L::splat(if class.negative[axis] { -shaft.pad[axis] } else { shaft.pad[axis] });
            near[k] = (lines.origin[k] + pad) * lines.inverse[k] + L::splat(UNDERFLOW_PAD);
            far[k] = (lines.origin[k] - pad) * lines.inverse[k] - L::splat(UNDERFLOW_PAD);
        }
        (lines.inverse, near, far)
    }

    /// How far the rays go, at most: to `t_max`, or out of the surroundings along the fastest axis.
    #[inline(always)]
    pub(crate) fn lengths<const N: usize>(
        &self,
        class: &DirectionClass,
        lines: &LineLanes<L>,
        t_max: L,
        Surroundings { bounds, pad }: &Surroundings,
    ) -> L
    where
        L: Lanes<N>,
    {
        let z = class.axes[2] as usize;
        let end = if class.negative[z] { bounds.min[z] } else { bounds.max[z] };
        let (far, o) = (L::splat(end) - self.origin[z], self.origin[z].abs());
        let pad = far.abs() * L::splat(4.0 * NODE_PAD) + o * L::splat(NODE_ORIGIN_PAD) + L::splat(pad[z]);
        let pad = if class.negative[z] { L::splat(0.0) - pad } else { pad };
        t_max.min((far + pad) * lines.inverse[2]).max(L::splat(0.0))
    }

    /// The shaft of `rays`, a non-empty mask of rays of `class`, of the given lengths.
    #[inline(always)]
    pub(crate) fn shaft<const N: usize>(
        &self,
        class: &DirectionClass,
        lengths: L,
        rays: u32,
        surroundings: &Surroundings,
    ) -> Shaft
    where
        L: Lanes<N>,
    {
        let (origins, is_pointed) = self.origins(rays);
        let rays = L::Mask::from_bits(rays);
        let mut ends = Aabb::EMPTY;
        for axis in 0..3 {
            let end = self.origin[axis] + lengths * self.direction[axis];
            (ends.min[axis], ends.max[axis]) = range(rays, end);
        }
        let reach = surroundings.reach(&origins);
        let reach_z = reach[class.axes[2] as usize];
        let pad = (reach + reach_z) * (2.0 * NODE_PAD)
            + origins.min.abs().max(origins.max.abs()) * (2.0 * NODE_ORIGIN_PAD)
            + (surroundings.pad + Vec3::splat(f32::MIN_POSITIVE));
        let sides = [(origins.max + pad, ends.max + pad), (origins.min - pad, ends.min - pad)];
        let mut shaft = Shaft {
            inverse: [[0.0; 3]; 2],
            shift: [[0.0; 3]; 2],
            rises: [[false; 3]; 2],
            pad: pad.to_array(),
            is_pointed,
        };
        for (side, (from, to)) in sides.into_iter().enumerate() {
            for axis in 0..3 {
                let slope = raise(to[axis] - from[axis], (pad[axis] * MIN_COMPONENT).max(f32::MIN_POSITIVE));
                let inverse = 1.0 / slope;
                shaft.inverse[side][axis] = inverse;
                shaft.shift[side][axis] = from[axis] * inverse;
                shaft.rises[side][axis] = slope > 0.0;
            }
        }
        shaft
    }
}

impl<L: Copy> Bundle<L> {
    /// The box around the origins of `rays`, a non-empty mask, and whether they are one point.
    #[inline(always)]
    pub(crate) fn origins<const N: usize>(&self, rays: u32) -> (Aabb, bool)
    where
        L: Lanes<N>,
    {
        let first = rays.trailing_zeros() as usize % N;
        let [x, y, z] = self.origin;
        let point = Vec3::new(x.store()[first], y.store()[first], z.store()[first]);
        let same = x.eq(L::splat(point.x)) & y.eq(L::splat(point.y)) & z.eq(L::splat(point.z));
        if same.bits() & rays == rays {
            return (Aabb { min: point, max: point }, true);
        }
        let rays = L::Mask::from_bits(rays);
        let mut origins = Aabb::EMPTY;
        for axis in 0..3 {
            (origins.min[axis], origins.max[axis]) = range(rays, self.origin[axis]);
        }
        (origins, false)
    }
}

/// The least and the greatest of the lanes in `rays`, a non-empty mask.
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
fn signs<const N: usize, L: Lanes<N>>(lanes: L) -> u32 {
    L::splat(1.0).copysign(lanes).lt(L::splat(0.0)).bits()
}

#[inline(always)]
fn three<const N: usize, L: Lanes<N>>(axes: &[[f32; N]; 3]) -> [L; 3] {
    [L::load(&axes[0]), L::load(&axes[1]), L::load(&axes[2])]
}
