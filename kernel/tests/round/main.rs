//! Points and curves: hits against an oracle in `f64` without formulas for them, rays that leave, and invalid
//! primitives.

mod faults;
mod leaving;
mod oracle;

use glam::{DVec3, DVec4, Vec3, vec3};
use halfdome_kernel::geometry::PrimitiveFault;
use halfdome_kernel::geometry::intersect_round;
use halfdome_kernel::geometry::round::{CUBIC_TOLERANCE, RoundPrimitive};
use halfdome_kernel::sampling::Stream;
use halfdome_kernel::{BuildOptions, CubicCurve, Disc, LinearCurve, Ray, RoundBvh, RoundBvhView, RoundSurface, Sphere};

/// Random numbers of a seed, one after the other.
struct Random {
    stream: Stream,
    set: u32,
}

impl Random {
    fn new(seed: u64) -> Self {
        Self { stream: Stream::new(seed, 0, 0), set: 0 }
    }

    fn four(&mut self) -> [u32; 4] {
        self.set += 1;
        self.stream.bits4(self.set)
    }

    fn bits(&mut self) -> u32 {
        self.four()[0]
    }

    /// A number in [0, 1).
    fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1 << 24) as f32
    }

    /// A point of the cube from -1 to 1.
    fn vector(&mut self) -> Vec3 {
        let [x, y, z, _] = self.four().map(|bits| (bits >> 8) as f32 / (1 << 24) as f32);
        vec3(x, y, z) * 2.0 - 1.0
    }

    /// A direction of unit length.
    fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vector();
            if (0.01..=1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }
}
