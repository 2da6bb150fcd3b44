//! Numbers and vectors of the paths in a block, in columns.

use glam::Vec3;

/// Paths in a block: few enough for the first-level cache.
pub(in crate::integrator) const LANES: usize = 64;

/// A number of each path.
pub(super) type Column = [f32; LANES];

/// A vector of each path.
#[derive(Clone, Copy)]
pub(in crate::integrator) struct Vectors {
    x: Column,
    y: Column,
    z: Column,
}

impl Vectors {
    pub(super) const ZERO: Self = Self { x: [0.0; LANES], y: [0.0; LANES], z: [0.0; LANES] };

    #[inline(always)]
    pub(super) fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    #[inline(always)]
    pub(super) fn set(&mut self, i: usize, vector: Vec3) {
        (self.x[i], self.y[i], self.z[i]) = (vector.x, vector.y, vector.z);
    }
}
