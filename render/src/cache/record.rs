//! A record: the irradiance at a point of a surface, its derivatives, and the radii within which it is valid.

use glam::Vec3;

pub use crate::estimator::SECTORS;

/// A point of a surface that asks for records.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LookupPoint {
    pub(crate) position: Vec3,
    /// Unit normal on the side that is lit.
    pub(crate) normal: Vec3,
    /// As that of a [record](Record::clearance), if it is known.
    pub(crate) clearance: Option<f32>,
}

/// The indirect irradiance at a point. Lengths are in the scene's units, vectors in world space.
///
/// Lookups read many records to use few: what says where one is valid is in one cache line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Record {
    /// The position.
    pub position: Vec3,
    /// The unit normal, on the side that is lit.
    pub normal: Vec3,
    /// Unit tangent along which it reaches the least far.
    pub axis: Vec3,
    /// The radii of the ellipse along [`axis`](Self::axis) and across it; the former is the lesser.
    pub radii: [f32; 2],
    /// The least distance of what it sees, and of the occluders.
    pub min_distance: f32,
    /// Harmonic mean of the distances of what it sees; less where something hangs low nearby.
    pub mean_distance: f32,
    /// Irradiance in W/m², linear sRGB.
    pub irradiance: Vec3,
    /// For each channel the gradient by which irradiance changes with the position.
    pub translational: [Vec3; 3],
    /// The standard error of the irradiance by the noise of the gather, of the channel where it is greatest.
    pub standard_error: f32,
    /// The address of the record's random numbers, and its place in the order of a file.
    pub key: u64,
    /// For each channel the gradient by which irradiance changes with the normal.
    pub rotational: [Vec3; 3],
    /// For each sector of azimuth, from the first tangent of the frame about the normal, the distance along the surface
    /// of the nearest occluder; infinite if there is none.
    pub occluders: [f32; SECTORS],
    /// The greatest distance of the hits of rays halfway up on four sides; infinite if one misses.
    pub clearance: f32,
}

impl Record {
    /// The position as a lookup point.
    pub(crate) fn point(&self) -> LookupPoint {
        LookupPoint { position: self.position, normal: self.normal, clearance: Some(self.clearance) }
    }

    /// Irradiance at a point where the record is valid, with this normal, by the given gradients: Ward and Heckbert's
    /// (1992) `E + (n_i × n)·∇_r E + (x - x_i)·∇_t E`. May be negative.
    #[inline]
    pub fn extrapolate(&self, position: Vec3, normal: Vec3, rotation: bool, translation: bool) -> Vec3 {
        let mut irradiance = self.irradiance;
        if rotation {
            let axis = self.normal.cross(normal);
            irradiance += Vec3::from_array(self.rotational.map(|gradient| gradient.dot(axis)));
        }
        if translation {
            let step = position - self.position;
            irradiance += Vec3::from_array(self.translational.map(|gradient| gradient.dot(step)));
        }
        irradiance
    }

    /// The `irradiance` for a normal tilted by a map, on a surface with this unit normal. Light only comes from above
    /// the surface: of uniform light `(1 + cos) / 2` remains, and the gradient gives the difference for other light.
    #[inline]
    pub(crate) fn tilt(&self, irradiance: Vec3, normal: Vec3, tilted: Vec3, rotation: bool) -> Vec3 {
        let left = irradiance * (0.5 + 0.5 * normal.dot(tilted));
        if !rotation {
            return left;
        }
        let axis = normal.cross(tilted);
        left + Vec3::from_array(self.rotational.map(|gradient| gradient.dot(axis)))
    }

    /// The distance of `step` from the record, in units of its radius in that direction.
    #[inline]
    pub fn relative_distance(&self, step: Vec3) -> f32 {
        let [minor, major] = self.radii;
        let along = step.dot(self.axis);
        if minor == major {
            return step.length() / minor;
        }
        let height = step.dot(self.normal);
        let across_squared = (step.length_squared() - along * along - height * height).max(0.0);
        ((along * along + height * height) / (minor * minor) + across_squared / (major * major)).sqrt()
    }

    /// Everything as 32-bit words after the key, vectors before scalars; what a file holds.
    pub(crate) fn words(&self) -> [u32; Self::WORDS] {
        let mut words = [0; Self::WORDS];
        let vectors = [self.position, self.normal, self.irradiance].into_iter().chain(self.rotational);
        let vectors = vectors.chain(self.translational).chain([self.axis]).flat_map(|v| v.to_array());
        let scalars = [self.mean_distance, self.min_distance, self.radii[0], self.radii[1], self.standard_error];
        for (word, value) in words.iter_mut().zip(vectors.chain(scalars).chain(self.occluders).chain([self.clearance]))
        {
            *word = value.to_bits();
        }
        words
    }

    /// The record of these words.
    pub(crate) fn from_words(key: u64, words: &[u32; Self::WORDS]) -> Self {
        let value = |i: usize| f32::from_bits(words[i]);
        let vector = |i: usize| Vec3::new(value(3 * i), value(3 * i + 1), value(3 * i + 2));
        Self {
            key,
            position: vector(0),
            normal: vector(1),
            irradiance: vector(2),
            rotational: [vector(3), vector(4), vector(5)],
            translational: [vector(6), vector(7), vector(8)],
            axis: vector(9),
            mean_distance: value(30),
            min_distance: value(31),
            radii: [value(32), value(33)],
            standard_error: value(34),
            occluders: std::array::from_fn(|i| value(35 + i)),
            clearance: value(35 + SECTORS),
        }
    }

    /// Whether all numbers are what they may be; those of a file could be anything.
    pub(super) fn is_valid(&self) -> bool {
        let vectors = [self.position, self.normal, self.irradiance, self.axis].into_iter();
        let finite = vectors.chain(self.rotational).chain(self.translational).all(|v| v.is_finite());
        let lengths = self.radii[0] > 0.0 && self.radii[1] >= self.radii[0] && self.radii[1].is_finite();
        let distances = [self.mean_distance, self.min_distance, self.standard_error];
        let distances = distances.iter().all(|number| (0.0..f32::INFINITY).contains(number));
        let units = [self.normal, self.axis].iter().all(|v| (v.length_squared() - 1.0).abs() < 1e-3);
        let occluders = self.occluders.iter().chain([&self.clearance]).all(|distance| *distance >= 0.0);
        finite && lengths && distances && units && occluders && self.irradiance.min_element() >= 0.0
    }

    /// Ten vectors, four lengths, the standard error, the occluders and the clearance.
    pub(crate) const WORDS: usize = 36 + SECTORS;
}
