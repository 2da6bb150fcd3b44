//! The receiver: a point for which a light is chosen.

use glam::Vec3;

/// A point of a surface that receives light, as far as choosing lights depends on it.
///
/// The normal has 15 bits an axis, in an octahedral map (Cigolle et al. 2014), and so fits into one word: a path keeps
/// it until its bounce hits a light, and recovers exactly the receiver for which that light might have been chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Receiver {
    pub position: Vec3,
    /// Unit vector on the side that light is reflected to.
    pub normal: Vec3,
    /// 1 if light from behind counts too, else 0.
    pub behind: f32,
}

/// Steps from 0 to 1 of a coordinate in the map.
const STEPS: f32 = 16383.0;
/// The bits of a coordinate.
const BITS: u32 = 15;

impl Receiver {
    /// A surface that receives light on the side of its shading normal, or on both.
    #[inline(always)]
    pub(crate) fn new(position: Vec3, normal: Vec3, both_sides: bool) -> Self {
        Self::unpack(position, pack(normal, both_sides))
    }

    /// A normal and the sides of a surface that receive light, packed into a word.
    #[inline(always)]
    pub(crate) fn pack(normal: Vec3, both_sides: bool) -> u32 {
        pack(normal, both_sides)
    }

    /// The receiver at this position whose [`packed`](Self::packed) normal is known.
    #[inline(always)]
    pub(crate) fn unpack(position: Vec3, packed: u32) -> Self {
        let mask = (1 << BITS) - 1;
        let x = ((packed & mask) as i32 as f32 - STEPS) * (1.0 / STEPS);
        let y = ((packed >> BITS & mask) as i32 as f32 - STEPS) * (1.0 / STEPS);
        let z = 1.0 - x.abs() - y.abs();
        // The lower half is folded over the diagonals.
        let fold = (-z).max(0.0);
        let normal = Vec3::new(x - fold.copysign(x), y - fold.copysign(y), z);
        let scale = normal.length_squared().sqrt().recip();
        let behind = (packed >> (2 * BITS) & 1) as f32;
        Self { position, normal: normal * scale, behind }
    }

    /// The height of a segment's end above the surface, or below it if light counts from there; 0 on the other side.
    #[inline(always)]
    pub(crate) fn height(&self, way: Vec3) -> f32 {
        let height = self.normal.dot(way);
        if self.behind > 0.0 { height.abs() } else { height.max(0.0) }
    }

    /// Normal and sides in one word.
    #[inline(always)]
    pub(crate) fn packed(&self) -> u32 {
        pack(self.normal, self.behind > 0.0)
    }
}

#[inline(always)]
fn pack(normal: Vec3, both_sides: bool) -> u32 {
    let scale = (normal.x.abs() + normal.y.abs() + normal.z.abs()).recip();
    let (x, y) = (normal.x * scale, normal.y * scale);
    let is_low = normal.z < 0.0;
    let across = if is_low { (1.0 - y.abs()).copysign(x) } else { x };
    let up = if is_low { (1.0 - x.abs()).copysign(y) } else { y };
    // Half a step more and then cut off, for rounding is no instruction everywhere.
    let step = |x: f32| (x.clamp(-1.0, 1.0) * STEPS + (STEPS + 0.5)) as i32 as u32;
    step(across) | step(up) << BITS | u32::from(both_sides) << (2 * BITS)
}

#[cfg(test)]
mod tests {
    use halfdome_kernel::sampling::Stream;
    use halfdome_kernel::sampling::warp::{UniformSphere, Warp};

    use super::*;

    #[test]
    fn packing_turns_normals_by_less_than_a_ten_thousandth_and_only_once() {
        let axes = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
        let random = (0..10_000).map(|i| UniformSphere.map(Stream::new(5, i, 0).uniform2(0)));
        for normal in axes.into_iter().chain(random) {
            for both_sides in [false, true] {
                let receiver = Receiver::new(Vec3::ONE, normal, both_sides);
                assert!(receiver.normal.is_normalized() && receiver.normal.angle_between(normal) < 5e-4);
                assert!((receiver.normal - normal).length() < 1.3e-4, "{normal} became {}", receiver.normal);
                assert_eq!(receiver.behind, f32::from(both_sides));
                assert_eq!(Receiver::unpack(Vec3::ONE, receiver.packed()), receiver);
            }
        }
        for axis in axes {
            assert_eq!(Receiver::new(Vec3::ZERO, axis, false).normal, axis);
        }
    }
}
