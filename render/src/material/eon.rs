//! Rough diffuse reflection that loses no energy: EON.
//!
//! Portsmouth, Kutz and Hill, "EON: A practical energy-preserving rough diffuse BRDF" (2024): the Fujii-Oren-Nayar
//! model, and a reciprocal lobe for light that is scattered between facets. At roughness 0 it is Lambert's.
//!
//! Deviation: directions are sampled by the cosine, instead of by clipped linearly transformed cosines.

use std::f32::consts::{FRAC_1_PI, PI};

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// A rough diffuse reflection.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Eon {
    /// Albedo of the facets, and that of light which is scattered between them, divided by its mean loss.
    color: Vec3,
    multiple: Vec3,
    roughness: f32,
    /// The weight of the Lambertian part.
    flat: f32,
}

const LOSS: f32 = 0.5 - 2.0 / (3.0 * PI);
const MEAN: f32 = 2.0 / 3.0 - 28.0 / (15.0 * PI);

impl Eon {
    /// A closure with a roughness from 0 to 1.
    #[inline]
    pub(super) fn new(color: Vec3, roughness: f32) -> Self {
        let flat = 1.0 / (1.0 + LOSS * roughness);
        if roughness == 0.0 {
            return Self { color, multiple: Vec3::ZERO, roughness, flat };
        }
        let mean = flat * (1.0 + MEAN * roughness);
        let loss = 1.0 - mean;
        let multiple = color * color * (mean / loss) / (1.0 - color * loss);
        Self { color, multiple, roughness, flat }
    }

    /// `f(wo, wi)`; both above the horizon.
    #[inline(always)]
    pub(super) fn f(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        let s = wo.truncate().dot(wi.truncate());
        let ratio = if s > 0.0 { s / wo.z.max(wi.z) } else { s };
        let single = self.flat * (1.0 + self.roughness * ratio);
        let lost = (1.0 - self.single_albedo(wo.z)) * (1.0 - self.single_albedo(wi.z));
        (self.color * single + self.multiple * lost) * FRAC_1_PI
    }

    /// The part of uniform light that is reflected to `wo`.
    #[inline]
    pub(super) fn albedo(&self, wo: Vec3) -> Vec3 {
        if self.roughness == 0.0 {
            return self.color;
        }
        let single = self.single_albedo(wo.z);
        let loss = 1.0 - self.flat * (1.0 + MEAN * self.roughness);
        self.color * single + self.multiple * ((1.0 - single) * loss)
    }

    /// The albedo of one reflection from white facets: the paper's fit.
    #[inline(always)]
    fn single_albedo(&self, cos: f32) -> f32 {
        let s = 1.0 - cos;
        let g = s * (0.057_108_53 + s * (0.491_881_87 + s * (-0.332_181_44 + s * 0.071_442_99)));
        self.flat * (1.0 + self.roughness * g)
    }
}
