//! FNV-1a, 64 bits, of bytes and numbers.

use glam::Vec3;

/// FNV-1a of these bytes.
pub(crate) fn fnv(bytes: &[u8]) -> u64 {
    let mut hash = Fnv::new();
    hash.bytes(bytes);
    hash.0
}

/// A hash under way.
pub(super) struct Fnv(pub(super) u64);

impl Fnv {
    pub(super) fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    pub(super) fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    pub(super) fn word(&mut self, word: u32) {
        self.bytes(&word.to_le_bytes());
    }

    pub(super) fn count(&mut self, count: usize) {
        self.word(count as u32);
        self.word((count as u64 >> 32) as u32);
    }

    pub(super) fn floats(&mut self, values: &[f32]) {
        values.iter().for_each(|value| self.word(value.to_bits()));
    }

    pub(super) fn vector(&mut self, v: Vec3) {
        self.floats(&v.to_array());
    }
}
