//! Spheres, as an example of a [`Shape`].

use glam::{DVec3, Vec3};

use super::Shape;
use crate::geometry::{Aabb, Hit, Ray, Sphere};

/// Spheres, hit from outside and inside. `u` and `v` of hits are zero, as the normal is `point - center`.
#[derive(Clone, Copy, Debug)]
pub struct Spheres<'a>(pub &'a [Sphere]);

impl Shape for Spheres<'_> {
    fn count(&self) -> u32 {
        // More are refused, as no tree has room for so many.
        u32::try_from(self.0.len()).unwrap_or(u32::MAX)
    }

    fn bounds(&self, prim_id: u32) -> Aabb {
        let Sphere { center, radius } = self.0[prim_id as usize];
        if radius.is_nan() || radius <= 0.0 {
            return Aabb::EMPTY;
        }
        let (min, max) = ((center - radius).to_array(), (center + radius).to_array());
        Aabb { min: Vec3::from_array(min.map(f32::next_down)), max: Vec3::from_array(max.map(f32::next_up)) }
    }

    /// In `f64`, by the distance of the line from the centre (Haines, Günther and Akenine-Möller 2019, "Precision
    /// Improvements for Ray/Sphere Intersection").
    fn intersect(&self, prim_id: u32, ray: &Ray, _time: f32) -> Option<Hit> {
        let Sphere { center, radius } = self.0[prim_id as usize];
        let direction = ray.direction.as_dvec3();
        let to_center = center.as_dvec3() - ray.origin.as_dvec3();
        let square = dot(direction, direction);
        let middle = dot(to_center, direction) / square;
        let off = to_center - direction * middle;
        let half = (f64::from(radius) * f64::from(radius) - dot(off, off)) / square;
        if half < 0.0 {
            return None;
        }
        let half = libm::sqrt(half);
        let within = |t: &f32| (ray.t_min..=ray.t_max).contains(t);
        let t = [(middle - half) as f32, (middle + half) as f32].into_iter().find(within)?;
        Some(Hit { t, u: 0.0, v: 0.0, prim_id })
    }
}

fn dot(a: DVec3, b: DVec3) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}
