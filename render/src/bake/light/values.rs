//! The values of texels: irradiance, followed by the requested moments.

use glam::{DVec3, Vec3};

/// As many vectors for each texel, one after the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct Values {
    layers: usize,
    all: Vec<Vec3>,
}

impl Values {
    /// Of these irradiances and moments, `layers` vectors of each texel.
    pub(crate) fn of(layers: usize, texels: impl Iterator<Item = (Vec3, [DVec3; 4])>) -> Self {
        let vectors = |(irradiance, moments): (Vec3, [DVec3; 4])| {
            std::iter::once(irradiance).chain(moments.map(|moment| moment.as_vec3())).take(layers)
        };
        Self { layers, all: texels.flat_map(vectors).collect() }
    }

    /// The joined values of several chunks of texels, in order.
    pub(crate) fn joined(layers: usize, chunks: impl Iterator<Item = Self>) -> Self {
        Self { layers, all: chunks.flat_map(|values| values.all).collect() }
    }

    /// Vectors for each texel.
    pub(crate) fn layers(&self) -> usize {
        self.layers
    }

    /// The values of each texel.
    pub(crate) fn texels(&self) -> impl Iterator<Item = &[Vec3]> {
        self.all.chunks_exact(self.layers)
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.all.iter_mut().zip(&other.all).for_each(|(value, other)| *value += *other);
    }

    /// Puts the vectors of a texel in place of those that are there.
    pub(crate) fn set(&mut self, texel: usize, values: &[Vec3]) {
        self.all[texel * self.layers..(texel + 1) * self.layers].copy_from_slice(values);
    }

    pub(crate) fn to_words(&self) -> Vec<u32> {
        self.all.iter().flat_map(|value| value.to_array()).map(f32::to_bits).collect()
    }

    pub(crate) fn from_words(layers: usize, words: &[u32]) -> Self {
        let vector = |v: &[u32]| Vec3::from_array([0, 1, 2].map(|i| f32::from_bits(v[i])));
        Self { layers, all: words.chunks_exact(3).map(vector).collect() }
    }
}
