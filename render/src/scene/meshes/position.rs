//! Positions as keys: corners are the same if their coordinates are equal bit for bit.

use glam::Vec3;

/// The bits of a position; both zeros are one.
pub(crate) type Key = [u32; 3];

/// The key of a position.
pub(crate) fn key(position: Vec3) -> Key {
    position.to_array().map(|coordinate| (coordinate + 0.0).to_bits())
}
