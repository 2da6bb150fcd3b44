//! Discs: the line's crossing with the plane, and its distance from the centre.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::frame::dot;
use super::line_test::{Crossing, LineTest, Span};
use super::{PrimitiveFault, RayFrame, RoundPrimitive, sphere_fault};
use crate::geometry::{Aabb, MAX_COORDINATE};

/// A flat disc, hit from both sides; `u` of hits is the distance from the centre in radii.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Disc {
    /// The centre.
    pub center: Vec3,
    /// The radius; discs of radius zero, less or NaN are left out.
    pub radius: f32,
    /// The normal, of any length but zero. Discs with a zero normal are left out.
    pub normal: Vec3,
}

impl RoundPrimitive for Disc {
    fn fault(&self) -> Option<PrimitiveFault> {
        let Self { center, radius, normal } = *self;
        if !normal.is_finite() {
            return Some(PrimitiveFault::NotFinite);
        }
        if normal.abs().max_element() > MAX_COORDINATE {
            return Some(PrimitiveFault::OutOfRange);
        }
        let fault = sphere_fault(&[super::Sphere { center, radius }]);
        fault.or_else(|| (normal == Vec3::ZERO).then_some(PrimitiveFault::Degenerate))
    }

    /// Along each axis the disc's extent is the radius times the sine of the angle between axis and normal.
    #[inline(always)]
    fn bounds(&self) -> Aabb {
        let n = self.normal.to_array().map(f64::from);
        let square = dot(n, n);
        let corner = |axis: usize, side: f64| {
            let across = (square - n[axis] * n[axis]).max(0.0) / square;
            f64::from(self.center[axis]) + side * f64::from(self.radius) * libm::sqrt(across)
        };
        let min = [0, 1, 2].map(|axis| (corner(axis, -1.0) as f32).next_down());
        let max = [0, 1, 2].map(|axis| (corner(axis, 1.0) as f32).next_up());
        Aabb { min: min.into(), max: max.into() }
    }
}

impl LineTest for Disc {
    type Numbers = [f64; 7];
    const IS_CONVEX: bool = true;
    const IS_FLAT: bool = true;

    #[inline(always)]
    fn numbers(&self) -> [f64; 7] {
        let Self { center: c, radius, normal: n } = *self;
        [c.x.into(), c.y.into(), c.z.into(), radius.into(), n.x.into(), n.y.into(), n.z.into()]
    }

    #[inline(always)]
    fn margin(frame: &RayFrame, numbers: &[f64; 7]) -> f64 {
        let (center, _, along) = crossing(frame, numbers);
        let radius = numbers[3];
        radius * radius - center[0] * center[0] - center[1] * center[1] - along * along
    }

    #[inline(always)]
    fn spans(frame: &RayFrame, numbers: &[f64; 7], _backwards: bool, mut see: impl FnMut(Span)) {
        let (center, normal, along) = crossing(frame, numbers);
        let distance = libm::sqrt(center[0] * center[0] + center[1] * center[1] + along * along);
        let crossing = Crossing { z: center[2] + along, u: distance / numbers[3], outward: normal };
        see(Span { enter: crossing, exit: crossing });
    }
}

/// The centre and the normal in the ray's space, and the distance behind the centre at which the line crosses the
/// plane: infinity or NaN if it does not.
#[inline(always)]
fn crossing(frame: &RayFrame, &[x, y, z, _, nx, ny, nz]: &[f64; 7]) -> ([f64; 3], [f64; 3], f64) {
    let (center, normal) = (frame.place([x, y, z]), frame.turn([nx, ny, nz]));
    let along = (normal[0] * center[0] + normal[1] * center[1]) / normal[2];
    (center, normal, along)
}
