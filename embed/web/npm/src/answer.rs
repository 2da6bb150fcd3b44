//! The results of batches, in the order in which JavaScript reads them.

use glam::Vec3;
use halfdome_kernel::Hit;

/// The answer to the last batch, in words of 32 bits.
#[derive(Default)]
pub(crate) struct Answer(Vec<u32>);

impl Answer {
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    pub(crate) fn address(&self) -> *const u32 {
        self.0.as_ptr()
    }

    pub(crate) fn push_words(&mut self, words: impl IntoIterator<Item = u32>) {
        self.0.extend(words);
    }

    /// All `t`, then all `u`, all `v`, and all numbers of triangles, -1 for none.
    pub(crate) fn push_hits<'a>(&mut self, hits: impl Iterator<Item = &'a Hit> + Clone) {
        self.0.extend(hits.clone().map(|hit| hit.t.to_bits()));
        self.0.extend(hits.clone().map(|hit| hit.u.to_bits()));
        self.0.extend(hits.clone().map(|hit| hit.v.to_bits()));
        self.0.extend(hits.map(|hit| hit.prim_id));
    }

    pub(crate) fn push_places(&mut self, places: impl Iterator<Item = Vec3>) {
        self.0.extend(places.flat_map(|place| place.to_array().map(f32::to_bits)));
    }

    /// A byte each, 1 or 0.
    pub(crate) fn push_bytes(&mut self, bytes: &[bool]) {
        let word = |four: &[bool]| {
            let byte = |place: usize| four.get(place).copied().unwrap_or_default().into();
            u32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)])
        };
        self.0.extend(bytes.chunks(4).map(word));
    }
}
