//! The setup of a ray, computed once before any box or triangle is tested.

use glam::Vec3;

use super::{Aabb, Ray};

/// The greatest magnitude of a coordinate: 2⁴², about 4.4e12. Products of sheared coordinates and distances to planes
/// then stay finite.
pub const MAX_COORDINATE: f32 = (1u64 << 42) as f32;
/// The least magnitude of a direction's largest component: 2⁻⁵⁰, about 8.9e-16.
pub const MIN_DIRECTION: f32 = 1.0 / MAX_DIRECTION;
/// The greatest magnitude of a direction's largest component: 2⁵⁰, about 1.1e15.
pub const MAX_DIRECTION: f32 = (1u64 << 50) as f32;

impl Aabb {
    /// Whether the box is not empty, and within the numeric limits.
    pub(crate) fn is_usable(&self) -> bool {
        !self.is_empty() && self.min.min_element() >= -MAX_COORDINATE && self.max.max_element() <= MAX_COORDINATE
    }
}

/// The box of a triangle is widened by this times its reach from the origin; see the module's error bounds.
pub(crate) const OWN_PAD: f32 = 8.0 / (1u32 << 24) as f32;
/// The boxes of nodes are widened by this times the scene's reach from the origin …
pub(crate) const NODE_PAD: f32 = 16.0 / (1u32 << 24) as f32;
/// … and by this times the origin itself.
pub(crate) const NODE_ORIGIN_PAD: f32 = 4.0 / (1u32 << 24) as f32;
/// Distances to nodes are widened by this besides: it changes only numbers so small that the pads above are rounded
/// away.
pub(crate) const UNDERFLOW_PAD: f32 = 4.0 * f32::MIN_POSITIVE;
/// Smaller components of the direction, relative to the largest one, are raised to this value, which keeps reciprocals
/// finite. Over the whole scene the ray strays from its class by less than the boxes are widened.
pub(crate) const MIN_COMPONENT: f32 = 1.0 / (1u64 << 32) as f32;

/// Determinants smaller than this lose their digits to underflow, and are computed in `f64`.
pub(crate) const MIN_DETERMINANT: f32 = 1.0 / (1u128 << 100) as f32;

/// An axis of space: an index that is always in range.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(u8)]
pub(crate) enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    const CYCLE: [Self; 5] = [Self::X, Self::Y, Self::Z, Self::X, Self::Y];

    /// The order of [`Line::axes`] for a ray that runs fastest along axis `z`, 0 to 2.
    #[inline(always)]
    pub(crate) const fn permutation(z: usize, negative: bool) -> [Self; 3] {
        let [x, y, z] = [Self::CYCLE[z + 1], Self::CYCLE[z + 2], Self::CYCLE[z]];
        if negative { [y, x, z] } else { [x, y, z] }
    }
}

/// What boxes are tested with, in the order x, y, z.
///
/// The distance to a near plane of a node is `plane * inverse - near_shift`, to a far one likewise: the shifts are
/// `inverse` times the origin, moved so that near planes come nearer, and far planes farther, by the nodes' pad.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slabs {
    /// Reciprocals of the direction, with small components raised to [`MIN_COMPONENT`].
    pub inverse: [f32; 3],
    pub near_shift: [f32; 3],
    pub far_shift: [f32; 3],
    /// Whether the direction is negative, so that near planes are the upper ones.
    pub negative: [bool; 3],
}

impl Slabs {
    /// Bit `a` says that the direction is negative along axis `a`.
    #[inline(always)]
    pub(crate) fn octant(&self) -> u8 {
        u8::from(self.negative[0]) | u8::from(self.negative[1]) << 1 | u8::from(self.negative[2]) << 2
    }
}

/// What triangles are tested with, in the order of `axes`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// The axis along which the ray runs fastest is the last one, and the others so that the shear keeps the winding.
    pub axes: [Axis; 3],
    /// The origin, the reciprocals of the direction, and the shear: `d[0] / d[2]` and `d[1] / d[2]`, by way of the
    /// reciprocal.
    pub numbers: [f32; 8],
}

/// A ray prepared for traversal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RaySetup {
    pub slabs: Slabs,
    pub line: Line,
}

impl RaySetup {
    /// `None` if the ray can hit nothing: out of limits, NaN, an empty interval, or an empty scene.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray, scene: &Aabb) -> Option<Self> {
        let valid = is_in_limits(ray) && ray.t_min <= ray.t_max && !scene.is_empty();
        if !valid {
            return None;
        }
        let size = ray.direction.abs();
        let largest = size.max_element();
        let z = if size.x == largest {
            0
        } else if size.y == largest {
            1
        } else {
            2
        };
        let (d, o) = (ray.direction.to_array(), ray.origin.to_array());
        let axes = Axis::permutation(z, d[z] < 0.0);

        let inverse = d.map(|d| 1.0 / raise(d, largest * MIN_COMPONENT));
        let reach = (scene.min - ray.origin).abs().max((scene.max - ray.origin).abs());
        let pad = (reach + reach[z]) * NODE_PAD + ray.origin.abs() * NODE_ORIGIN_PAD;
        let mut slabs = Slabs { inverse, near_shift: [0.0; 3], far_shift: [0.0; 3], negative: [false; 3] };
        for axis in 0..3 {
            let pad = pad[axis].copysign(d[axis]);
            slabs.near_shift[axis] = (o[axis] + pad) * inverse[axis] + UNDERFLOW_PAD;
            slabs.far_shift[axis] = (o[axis] - pad) * inverse[axis] - UNDERFLOW_PAD;
            slabs.negative[axis] = inverse[axis] < 0.0;
        }

        let [x, y, z] = axes.map(|axis| axis as usize);
        let shear = [d[x] * inverse[z], d[y] * inverse[z]];
        let numbers = [o[x], o[y], o[z], inverse[x], inverse[y], inverse[z], shear[0], shear[1]];
        let line = Line { axes, numbers };
        Some(Self { slabs, line })
    }
}

impl Slabs {
    /// Widens boxes by `pad` besides, along each axis.
    #[inline(always)]
    pub(crate) fn widen(&mut self, pad: Vec3) {
        for axis in 0..3 {
            let distance = pad[axis] * self.inverse[axis].abs();
            self.near_shift[axis] += distance;
            self.far_shift[axis] -= distance;
        }
    }
}

/// Whether origin and direction are within the [numeric limits](crate#numeric-limits).
#[inline(always)]
pub(crate) fn is_in_limits(ray: &Ray) -> bool {
    ray.origin.abs().cmple(Vec3::splat(MAX_COORDINATE)).all()
        && ray.direction.is_finite()
        && (MIN_DIRECTION..=MAX_DIRECTION).contains(&ray.direction.abs().max_element())
}

/// `value`, or `least` with its sign if that is larger.
pub(crate) fn raise(value: f32, least: f32) -> f32 {
    if value.abs() < least { least.copysign(value) } else { value }
}
