//! Random numbers independent of the kernel's: PCG32 (O'Neill 2014, "PCG: A Family of Simple Fast Space-Efficient
//! Statistically Good Algorithms for Random Number Generation").

use glam::DVec3;

const MULTIPLIER: u64 = 6_364_136_223_846_793_005;

/// A generator of 32 bits at a time.
#[derive(Clone, Debug)]
pub struct Pcg {
    state: u64,
    increment: u64,
}

impl Pcg {
    /// The generator of this seed; every seed has a stream of its own.
    pub fn new(seed: u64) -> Self {
        let mut pcg = Self { state: 0, increment: seed << 1 | 1 };
        pcg.bits();
        pcg.state = pcg.state.wrapping_add(0x853c_49e6_748f_ea9b);
        pcg.bits();
        pcg
    }

    /// 32 random bits.
    pub fn bits(&mut self) -> u32 {
        let old = self.state;
        self.state = old.wrapping_mul(MULTIPLIER).wrapping_add(self.increment);
        let xorshifted = ((old >> 18 ^ old) >> 27) as u32;
        xorshifted.rotate_right((old >> 59) as u32)
    }

    /// A number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        f64::from(self.bits()) / (1u64 << 32) as f64
    }

    /// An index below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// A point of the cube from -1 to 1.
    pub fn in_cube(&mut self) -> DVec3 {
        2.0 * DVec3::new(self.unit(), self.unit(), self.unit()) - 1.0
    }

    /// A point of the unit sphere's surface, by rejection.
    pub fn on_sphere(&mut self) -> DVec3 {
        loop {
            let point = self.in_cube();
            if (1e-6..=1.0).contains(&point.length_squared()) {
                return point.normalize();
            }
        }
    }
}
