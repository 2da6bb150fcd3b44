//! Spheres: the distance of the line from the centre decides whether it is hit, and half the chord where (Haines,
//! Günther and Akenine-Möller 2019, "Precision Improvements for Ray/Sphere Intersection").

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::line_test::{Crossing, LineTest, Span};
use super::{PrimitiveFault, RayFrame, RoundPrimitive};
use crate::geometry::Aabb;

/// A sphere: the surface, not the ball. For a curve, a point of its axis and the radius there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Sphere {
    /// The centre.
    pub center: Vec3,
    /// The radius; spheres of radius zero, less or NaN are left out.
    pub radius: f32,
}

impl Sphere {
    /// A sphere.
    pub const fn new(center: Vec3, radius: f32) -> Self {
        Self { center, radius }
    }
}

impl RoundPrimitive for Sphere {
    fn fault(&self) -> Option<PrimitiveFault> {
        super::sphere_fault(&[*self])
    }

    #[inline(always)]
    fn bounds(&self) -> Aabb {
        let (min, max) = ((self.center - self.radius).to_array(), (self.center + self.radius).to_array());
        Aabb { min: Vec3::from_array(min.map(f32::next_down)), max: Vec3::from_array(max.map(f32::next_up)) }
    }
}

impl LineTest for Sphere {
    type Numbers = [f64; 4];
    const IS_CONVEX: bool = true;

    #[inline(always)]
    fn numbers(&self) -> [f64; 4] {
        let Self { center, radius } = *self;
        [center.x.into(), center.y.into(), center.z.into(), radius.into()]
    }

    /// The square of half the chord.
    #[inline(always)]
    fn margin(frame: &RayFrame, &[x, y, z, radius]: &[f64; 4]) -> f64 {
        let [x, y, _, radius] = frame.place_sphere(x, y, z, radius);
        radius * radius - x * x - y * y
    }

    #[inline(always)]
    fn spans(frame: &RayFrame, &[x, y, z, radius]: &[f64; 4], _backwards: bool, mut see: impl FnMut(Span)) {
        let [x, y, z, radius] = frame.place_sphere(x, y, z, radius);
        let square = radius * radius - x * x - y * y;
        if square >= 0.0 {
            let half = libm::sqrt(square);
            let crossing = |side: f64| Crossing { z: z + side, u: 0.0, outward: [-x, -y, side] };
            see(Span { enter: crossing(-half), exit: crossing(half) });
        }
    }
}
