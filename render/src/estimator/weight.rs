//! Multiple importance sampling weights: light that two techniques can find counts once, split by their densities.

use halfdome_kernel::sampling::power;

use crate::settings::LightSampling;

/// Multiple importance sampling weights of a bounce with the density `bounce` and a light sample with the density
/// `light`, both per solid angle. Each pair of them adds up to 1. An infinite density is that of a delta function,
/// which the other technique cannot find: a mirror or the camera's pinhole for bounces, a delta light for light
/// samples.
impl LightSampling {
    /// The weight of light that a bounce found.
    #[inline]
    pub(crate) fn bounce_weight(self, bounce: f32, light: f32) -> f32 {
        match self {
            Self::Naive => 1.0,
            Self::Direct if bounce == f32::INFINITY || light == 0.0 => 1.0,
            Self::Direct => 0.0,
            Self::Mis => power(bounce, light),
        }
    }

    /// The weight of a light sample, by the reciprocal of its density, which light sampling needs anyway.
    #[inline]
    pub(crate) fn light_weight(self, per_light: f32, bounce: f32) -> f32 {
        match self {
            Self::Naive if per_light == 0.0 => 1.0,
            Self::Naive => 0.0,
            Self::Direct => 1.0,
            // The power heuristic again, by the ratio of the densities.
            Self::Mis => 1.0 / (1.0 + (bounce * per_light) * (bounce * per_light)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_both_can_find_counts_once() {
        for lights in [LightSampling::Naive, LightSampling::Direct, LightSampling::Mis] {
            for (bounce, light) in [(0.3, 2.0), (5.0, 0.01), (1.0, 1.0)] {
                let sum = lights.bounce_weight(bounce, light) + lights.light_weight(1.0 / light, bounce);
                assert!((sum - 1.0).abs() < 1e-6, "{lights:?}, {bounce}, {light}: {sum}");
            }
        }
    }

    #[test]
    fn deltas_win() {
        for lights in [LightSampling::Naive, LightSampling::Direct, LightSampling::Mis] {
            assert_eq!(lights.bounce_weight(f32::INFINITY, 3.0), 1.0, "an area light in a mirror, {lights:?}");
            assert_eq!(lights.light_weight(0.0, 3.0), 1.0, "a point light, {lights:?}");
            assert_eq!(lights.bounce_weight(3.0, 0.0), 1.0, "what is never sampled, {lights:?}");
        }
    }
}
