//! The test of a line against a round primitive: whether it hits, and its spans inside.

use super::frame::RayFrame;

/// The test of a primitive against the z axis of a ray's space.
pub trait LineTest: Copy {
    /// The primitive's numbers.
    type Numbers: Copy;
    /// Whether every line has at most one span in the primitive.
    const IS_CONVEX: bool;
    /// Whether the primitive has no inside, so that it is entered from both sides.
    const IS_FLAT: bool = false;

    /// The primitive's numbers.
    fn numbers(&self) -> Self::Numbers;

    /// Less than zero, or NaN, if the line does not meet the primitive; it may be positive although the line misses.
    /// Without a branch, so that it can be computed in lanes.
    fn margin(frame: &RayFrame, numbers: &Self::Numbers) -> f64;

    /// Shows the parts of the line within the primitive, whose union counts; some of them may overlap. They come in the
    /// order in which they follow each other along the primitive, or in the opposite one.
    fn spans(frame: &RayFrame, numbers: &Self::Numbers, backwards: bool, see: impl FnMut(Span));

    /// A vector along the shading normal.
    fn smooth_outward(_frame: &RayFrame, _numbers: &Self::Numbers, crossing: &Crossing) -> [f64; 3] {
        crossing.outward
    }
}

/// Where a line crosses the surface.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// The distance along the ray.
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
