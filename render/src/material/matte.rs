//! Lambert's diffuse reflection: `f = ρ/π`.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};

use super::{Bsdf, Evaluation, Event, Inputs, Sample};

/// See [`Kind::Matte`](super::Kind::Matte).
#[derive(Clone, Copy, Debug)]
pub struct Matte {
    color: Vec3,
}

impl Bsdf for Matte {
    #[inline]
    fn new(inputs: &Inputs, _is_inside: bool) -> Self {
        Self { color: inputs.base_color }
    }

    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> Evaluation {
        let density = wi.z.max(0.0) * FRAC_1_PI;
        let reverse_density = if wi.z > 0.0 { wo.z * FRAC_1_PI } else { 0.0 };
        Evaluation { f_cos: self.color * density, density, reverse_density }
    }

    #[inline]
    fn sample(&self, _wo: Vec3, u: Vec2) -> Option<Sample> {
        let wi = CosineHemisphere.map(u);
        let event = Event::DIFFUSE | Event::REFLECTION;
        (wi.z > 0.0).then_some(Sample { wi, weight: self.color, density: wi.z * FRAC_1_PI, event })
    }

    fn mirror_reflectance(&self, _wo: Vec3) -> Vec3 {
        Vec3::ZERO
    }

    #[inline]
    fn albedo(&self, _wo: Vec3) -> Vec3 {
        self.color
    }

    #[inline]
    fn diffuse_albedo(&self, _wo: Vec3) -> Vec3 {
        self.color
    }

    #[inline]
    fn transmits(&self) -> bool {
        false
    }
}
