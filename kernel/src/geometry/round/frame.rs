//! The space of a ray: its origin is at zero, and it runs along z. Distances from its line are those from the z axis.

use glam::Vec3;

use crate::geometry::Ray;
use crate::geometry::setup::is_in_limits;

/// Takes points to the space of a ray, in `f64`.
#[derive(Clone, Copy, Debug)]
pub struct RayFrame {
    origin: [f64; 3],
    /// Unit vectors along x, y and z of the ray's space.
    axes: [[f64; 3]; 3],
    /// That of the ray's direction.
    length: f64,
}

impl RayFrame {
    /// `None` if the ray can hit nothing: out of limits, NaN, or an empty interval.
    ///
    /// The axes are those of Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Option<Self> {
        if !is_in_limits(ray) || ray.t_min.is_nan() || ray.t_max.is_nan() || ray.t_min > ray.t_max {
            return None;
        }
        let d = ray.direction.to_array().map(f64::from);
        let length = libm::sqrt(dot(d, d));
        let [x, y, z] = d.map(|component| component / length);
        let sign = 1f64.copysign(z);
        let a = -1.0 / (sign + z);
        let b = x * y * a;
        let axes = [[1.0 + sign * x * x * a, sign * b, -sign * x], [b, sign + y * y * a, -y], [x, y, z]];
        Some(Self { origin: ray.origin.to_array().map(f64::from), axes, length })
    }

    /// A vector in the ray's space.
    #[inline(always)]
    pub(super) fn turn(&self, v: [f64; 3]) -> [f64; 3] {
        [dot(self.axes[0], v), dot(self.axes[1], v), dot(self.axes[2], v)]
    }

    /// A point in the ray's space.
    #[inline(always)]
    pub(super) fn place(&self, p: [f64; 3]) -> [f64; 3] {
        self.turn([p[0] - self.origin[0], p[1] - self.origin[1], p[2] - self.origin[2]])
    }

    /// A point and its radius.
    #[inline(always)]
    pub(super) fn place_sphere(&self, x: f64, y: f64, z: f64, radius: f64) -> [f64; 4] {
        let [x, y, z] = self.place([x, y, z]);
        [x, y, z, radius]
    }

    /// How far along the ray a `t` is.
    #[inline(always)]
    pub(super) fn z_at(&self, t: f32) -> f64 {
        f64::from(t) * self.length
    }

    /// The `t` of a distance along the ray.
    #[inline(always)]
    pub(super) fn t_at(&self, z: f64) -> f64 {
        z / self.length
    }

    /// Where the ray is at a distance.
    pub(super) fn at(&self, z: f64) -> [f64; 3] {
        core::array::from_fn(|axis| self.origin[axis] + self.axes[2][axis] * z)
    }

    /// The unit vector in the scene's space along a vector of the ray's; zero if that is.
    pub(super) fn turn_back(&self, v: [f64; 3]) -> Vec3 {
        let length = libm::sqrt(dot(v, v));
        let inverse = if length > 0.0 { 1.0 / length } else { 0.0 };
        let component = |axis: usize| {
            let [x, y, z] = self.axes;
            ((x[axis] * v[0] + y[axis] * v[1] + z[axis] * v[2]) * inverse) as f32
        };
        Vec3::new(component(0), component(1), component(2))
    }
}

#[inline(always)]
pub(super) fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
