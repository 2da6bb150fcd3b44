//! What decides whether a line meets something round, and where it is inside.

use super::frame::RayFrame;

/// A primitive as a line, the z axis of a ray's space, meets it.
pub trait LineTest: Copy {
    /// What it consists of.
    type Numbers: Copy;
    /// Whether no line has more than one span in it.
    const IS_CONVEX: bool;
    /// Whether it has no inside, so that it is entered from both sides.
    const IS_FLAT: bool = false;

    /// What it consists of.
    fn numbers(&self) -> Self::Numbers;

    /// Less than zero, or NaN, if the line does not meet the primitive; it may be more although it does not. Without a
    /// branch, so that it can be computed in lanes.
    fn margin(frame: &RayFrame, numbers: &Self::Numbers) -> f64;

    /// Shows the parts of the line within the primitive, whose union counts; some of them may overlap. They come in the order
    /// in which they follow each other along the primitive, or in the opposite one.
    fn spans(frame: &RayFrame, numbers: &Self::Numbers, backwards: bool, see: impl FnMut(Span));

    /// A vector along the normal that shading does best with.
    fn smooth_outward(_frame: &RayFrame, _numbers: &Self::Numbers, crossing: &Crossing) -> [f64; 3] {
        crossing.outward
    }
}

/// Where a line crosses the surface.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// How far along the ray.
    pub z: f64,
    /// The `u` of the hit.
    pub u: f64,
    /// A vector along the outward normal, in the ray's space.
    pub outward: [f64; 3],
}

/// A part of a line that is inside, from one end to the other.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// The near end.
    pub enter: Crossing,
    /// The far end.
    pub exit: Crossing,
}
