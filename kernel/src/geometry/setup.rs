//! What is computed once a ray, before any box or triangle is tested.

use super::{Aabb, Ray};
use crate::simd::Lanes;

/// The greatest magnitude of a coordinate: 2⁴², about 4.4e12. Products of sheared coordinates and distances to planes
/// then stay finite.
pub const MAX_COORDINATE: f32 = (1u64 << 42) as f32;
/// The least magnitude of a direction's largest component: 2⁻⁵⁰, about 8.9e-16.
pub const MIN_DIRECTION: f32 = 1.0 / MAX_DIRECTION;
/// The greatest magnitude of a direction's largest component: 2⁵⁰, about 1.1e15.
pub const MAX_DIRECTION: f32 = (1u64 << 50) as f32;

/// The box of a triangle is widened by this times its reach from the origin; see the module's error bounds.
pub(crate) const OWN_PAD: f32 = 8.0 / (1u32 << 24) as f32;
/// The boxes of nodes are widened by this times the scene's reach from the origin …
pub(crate) const NODE_PAD: f32 = 16.0 / (1u32 << 24) as f32;
/// … and by this times the origin itself.
pub(crate) const NODE_ORIGIN_PAD: f32 = 4.0 / (1u32 << 24) as f32;
/// Distances to nodes are widened by this besides: it changes only numbers so small that the pads above are rounded away.
pub(crate) const UNDERFLOW_PAD: f32 = 4.0 * f32::MIN_POSITIVE;
/// Components of the direction smaller than this times the largest one count as this, which keeps reciprocals finite.
/// Over the whole scene the ray strays from its course by less than the boxes are widened.
pub(crate) const LEAST_COMPONENT: f32 = 1.0 / (1u64 << 32) as f32;

/// Determinants smaller than this lose their digits to underflow, and are computed in `f64`.
pub(crate) const LEAST_DETERMINANT: f32 = 1.0 / (1u128 << 100) as f32;

/// The part of a ray's setup that selects code paths and memory: rays of one packet share it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Course {
    /// The axes, the one along which the ray runs fastest last, ordered so that the shear keeps the winding.
    pub axes: [usize; 3],
    /// Whether the direction is negative along each of [`axes`](Self::axes).
    pub negative: [bool; 3],
    /// The same as a number: bit `a` says that the direction is negative along axis `a`.
    pub octant: usize,
}

impl Course {
    /// The planes through which the ray enters a box and those through which it leaves, as indices into
    /// `[min x, max x, min y, max y, min z, max z]`, in the order of [`axes`](Self::axes).
    #[inline(always)]
    pub(crate) fn planes(&self) -> [(usize, usize); 3] {
        [self.planes_across(0), self.planes_across(1), self.planes_across(2)]
    }

    #[inline(always)]
    fn planes_across(&self, k: usize) -> (usize, usize) {
        let (min, negative) = (2 * self.axes[k], self.negative[k] as usize);
        (min + negative, min + 1 - negative)
    }
}

/// A ray made ready. Vectors are in the order of the course's axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RaySetup {
    pub course: Course,
    pub origin: [f32; 3],
    /// Reciprocals of the direction, with small components raised to [`LEAST_COMPONENT`].
    pub inverse: [f32; 3],
    /// `d[0] / d[2]` and `d[1] / d[2]`, by way of the reciprocal.
    pub shear: [f32; 2],
    /// The distance to a near plane of a node is `plane * inverse - near_shift`, to a far one likewise: the shifts are
    /// `inverse` times the origin, moved so that near planes come nearer, and far planes farther, by the nodes' pad.
    pub near_shift: [f32; 3],
    pub far_shift: [f32; 3],
}

impl RaySetup {
    /// The setup of no ray.
    pub(crate) const NOWHERE: Self = Self {
        course: Course { axes: [0, 1, 2], negative: [false; 3], octant: 0 },
        origin: [0.0; 3],
        inverse: [0.0; 3],
        shear: [0.0; 2],
        near_shift: [0.0; 3],
        far_shift: [0.0; 3],
    };

    /// `None` if the ray can hit nothing: out of limits, NaN, an empty interval, or an empty scene.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray, scene: &Aabb) -> Option<Self> {
        let size = ray.direction.abs();
        let largest = size.max_element();
        let valid = ray.origin.abs().cmple(glam::Vec3::splat(MAX_COORDINATE)).all()
            && ray.direction.is_finite()
            && (MIN_DIRECTION..=MAX_DIRECTION).contains(&largest)
            && ray.t_min <= ray.t_max
            && !scene.is_empty();
        if !valid {
            return None;
        }
        let z = if size.x == largest {
            0
        } else if size.y == largest {
            1
        } else {
            2
        };
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if ray.direction[z] < 0.0 {
            (x, y) = (y, x);
        }
        let axes = [x, y, z];
        let direction = axes.map(|axis| ray.direction[axis]);
        let origin = axes.map(|axis| ray.origin[axis]);
        let inverse = direction.map(|d| 1.0 / raise(d, largest * LEAST_COMPONENT));
        let reach = axes.map(|axis| {
            let (lower, upper) = (scene.min[axis] - ray.origin[axis], scene.max[axis] - ray.origin[axis]);
            lower.abs().max(upper.abs())
        });
        let pad: [f32; 3] = core::array::from_fn(|k| {
            let pad = (reach[k] + reach[2]) * NODE_PAD + origin[k].abs() * NODE_ORIGIN_PAD;
            pad.copysign(direction[k])
        });
        let negative = inverse.map(|inverse| inverse < 0.0);
        Some(Self {
            course: Course { axes, negative, octant: (0..3).map(|k| usize::from(negative[k]) << axes[k]).sum() },
            origin,
            inverse,
            shear: [direction[0] * inverse[2], direction[1] * inverse[2]],
            near_shift: core::array::from_fn(|k| (origin[k] + pad[k]) * inverse[k] + UNDERFLOW_PAD),
            far_shift: core::array::from_fn(|k| (origin[k] - pad[k]) * inverse[k] - UNDERFLOW_PAD),
        })
    }
}

/// `value`, or `least` with its sign if that is larger.
pub(crate) fn raise(value: f32, least: f32) -> f32 {
    if value.abs() < least { least.copysign(value) } else { value }
}

#[inline(always)]
fn splat<const N: usize, L: Lanes<N>>(v: [f32; 3]) -> [L; 3] {
    [L::splat(v[0]), L::splat(v[1]), L::splat(v[2])]
}

/// Ray setups in lanes: one ray in all of them, or one in each. Fields as in [`RaySetup`].
#[derive(Clone, Copy)]
pub(crate) struct RayLanes<L> {
    pub negative: [bool; 3],
    pub origin: [L; 3],
    pub inverse: [L; 3],
    pub shear: [L; 2],
    pub near_shift: [L; 3],
    pub far_shift: [L; 3],
}

impl<L> RayLanes<L> {
    /// The same ray in every lane.
    #[inline(always)]
    pub(crate) fn splat<const N: usize>(ray: &RaySetup) -> Self
    where
        L: Lanes<N>,
    {
        Self {
            negative: ray.course.negative,
            origin: splat(ray.origin),
            inverse: splat(ray.inverse),
            shear: [L::splat(ray.shear[0]), L::splat(ray.shear[1])],
            near_shift: splat(ray.near_shift),
            far_shift: splat(ray.far_shift),
        }
    }

    /// A ray a lane; all of them on one course.
    #[inline(always)]
    pub(crate) fn gather<const N: usize>(rays: &[RaySetup; N]) -> Self
    where
        L: Lanes<N>,
    {
        Self {
            negative: rays[0].course.negative,
            origin: gather(rays, |ray| ray.origin),
            inverse: gather(rays, |ray| ray.inverse),
            shear: gather(rays, |ray| ray.shear),
            near_shift: gather(rays, |ray| ray.near_shift),
            far_shift: gather(rays, |ray| ray.far_shift),
        }
    }
}

/// The same part of all rays, turned into lanes.
#[inline(always)]
fn gather<const N: usize, const M: usize, L: Lanes<N>>(
    rays: &[RaySetup; N],
    part: impl Fn(&RaySetup) -> [f32; M],
) -> [L; M] {
    let mut lanes = [L::splat(0.0); M];
    for (k, lanes) in lanes.iter_mut().enumerate() {
        let mut values = [0.0; N];
        for (value, ray) in values.iter_mut().zip(rays) {
            *value = part(ray)[k];
        }
        *lanes = L::load(&values);
    }
    lanes
}
