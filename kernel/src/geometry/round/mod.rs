//! Points and curves: spheres, discs, and spheres that are swept along segments and Bézier curves.
//!
//! # The test
//! A primitive is transformed to the space of the ray (`frame`), whose line is the z axis there, and where crossings
//! with the line are easily computed (`sphere`, `disc`, `linear`, `cubic`). All of this is in `f64`: `f32` cannot
//! resolve a hair of radius 1e-4 at a distance of 1e3. The hit is the first crossing in the ray's interval (`span`):
//! the entry for a ray from outside, the exit for a ray from inside, and never a crossing in between. It is rounded to
//! `f32` once, and then clamped to the primitive's box, so that a tree gives exactly what a loop over all primitives
//! gives.
//!
//! Operations are correctly rounded, in one order and never fused, so hits are equal bit for bit on every instruction
//! set. Lanes compute the margin (`line_test`) of eight primitives by the function that decides for a single one.
//!
//! # Error bounds
//! With `R` the greatest distance of the primitive from the ray's origin, a line that passes inside of a primitive by
//! more than `2⁻⁴⁰ R` hits it, and one that passes outside by more does not. The point at the unrounded distance is off
//! the surface by `2⁻⁴⁰ R` at most; the `t` of a hit is that distance rounded to `f32`. `cubic` describes the further
//! deviation of cubic curves. As [`RoundSurface`] has the unrounded point, rays that leave a surface start from there.

mod cubic;
mod disc;
mod frame;
mod line_test;
mod linear;
mod span;
mod sphere;
mod surface;

pub use cubic::{CUBIC_TOLERANCE, CubicCurve, MAX_CUBIC_HALVINGS};
pub use disc::Disc;
pub use linear::LinearCurve;
pub use sphere::Sphere;
pub use surface::RoundSurface;

pub(crate) use frame::RayFrame;
pub(crate) use line_test::LineTest;

use line_test::Crossing;

use super::{Aabb, Hit, PrimitiveFault, Ray, own_box};

/// What a [`RoundBvhView`](crate::RoundBvhView) traces: [`Sphere`], [`Disc`], [`LinearCurve`], [`CubicCurve`].
pub trait RoundPrimitive: LineTest + bytemuck::Pod + Send + Sync {
    /// Why no ray hits the primitive, if none does.
    fn fault(&self) -> Option<PrimitiveFault>;

    /// The box around it, rounded outwards. Unspecified for a primitive with a fault.
    fn bounds(&self) -> Aabb;
}

/// Where `ray` meets a point or a curve, with `prim_id` 0; `None` if it does not within `t_min..=t_max`, or if one of
/// them is out of the [numeric limits](crate#numeric-limits). The [module](self) defines which crossing counts.
pub fn intersect_round<P: RoundPrimitive>(ray: &Ray, primitive: &P) -> Option<Hit> {
    let frame = RayFrame::new(ray)?;
    match primitive.fault() {
        Some(_) => None,
        None => intersect(&frame, ray, primitive),
    }
}

/// The hit of a ray with a primitive without a fault: the definition.
#[inline(always)]
pub(crate) fn intersect<P: RoundPrimitive>(frame: &RayFrame, ray: &Ray, primitive: &P) -> Option<Hit> {
    let interval = own_box::interval(ray, &primitive.bounds())?;
    let (crossing, _) = crossing(frame, ray, primitive)?;
    // Adding zero makes a negative zero positive.
    let u = (crossing.u as f32).clamp(0.0, 1.0) + 0.0;
    own_box::clamped(ray, interval, Hit { t: frame.t_at(crossing.z) as f32, u, v: 0.0, prim_id: 0 })
}

/// The crossing that counts of a ray with a primitive, and whether it is an entry.
#[inline(always)]
fn crossing<P: RoundPrimitive>(frame: &RayFrame, ray: &Ray, primitive: &P) -> Option<(Crossing, bool)> {
    let numbers = primitive.numbers();
    let margin = P::margin(frame, &numbers);
    if margin.is_nan() || margin < 0.0 {
        return None;
    }
    let (crossing, is_entry) = span::first_crossing::<P>(frame, &numbers, frame.z_at(ray.t_min))?;
    (crossing.z <= frame.z_at(ray.t_max)).then_some((crossing, is_entry))
}

/// The fault of a primitive made of swept spheres.
fn sphere_fault(spheres: &[Sphere]) -> Option<PrimitiveFault> {
    if !spheres.iter().all(|sphere| sphere.center.is_finite() && sphere.radius.is_finite()) {
        return Some(PrimitiveFault::NotFinite);
    }
    if spheres.iter().any(|sphere| sphere.radius < 0.0) || spheres.iter().all(|sphere| sphere.radius == 0.0) {
        return Some(PrimitiveFault::Degenerate);
    }
    let is_usable = |sphere: &Sphere| sphere.bounds().is_usable();
    (!spheres.iter().all(is_usable)).then_some(PrimitiveFault::OutOfRange)
}
