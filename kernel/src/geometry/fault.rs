//! Primitives that no ray hits, and that trees leave out.

/// Why no ray hits a primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrimitiveFault {
    /// A coordinate or radius is NaN or infinite.
    NotFinite,
    /// The primitive reaches beyond [`MAX_COORDINATE`](super::MAX_COORDINATE).
    OutOfRange,
    /// The primitive has no surface: two corners of a triangle are equal, all radii are zero or one is less, a disc's
    /// normal is zero, a box is empty.
    Degenerate,
}
