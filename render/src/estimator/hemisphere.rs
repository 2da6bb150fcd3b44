//! Directions over a surface for gathering: `∫ V cos θ / π dω` is the mean of `V` times each direction's weight,
//! `cos θ / (π density)`.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{CosineHemisphere, UniformHemisphere, Warp};
use halfdome_kernel::sampling::{ONE_MINUS_EPSILON, Strata};

use crate::settings::HemisphereSampling;

/// A number of directions, chosen in one of the ways of [`HemisphereSampling`].
pub(crate) struct Hemisphere {
    rays: u32,
    sampling: Sampling,
}

enum Sampling {
    Uniform,
    Cosine,
    Grid(Strata),
    UniformGrid(Strata),
}

impl Hemisphere {
    /// `rays` directions, at least 1; fewer if strata make no grid of so many cells.
    pub(crate) fn new(sampling: HemisphereSampling, rays: u32) -> Self {
        // Cells as wide as high: M = √(rays/π) rings of N = rays/M sectors.
        let rings = ((rays as f32 / PI).sqrt().round() as u32).clamp(1, Strata::MAX);
        let sectors = (rays / rings).clamp(1, Strata::MAX);
        let strata = Strata::new(rings, sectors).expect("both numbers are in range");
        let cells = rings * sectors;
        match sampling {
            HemisphereSampling::Uniform => Self { rays, sampling: Sampling::Uniform },
            HemisphereSampling::Cosine => Self { rays, sampling: Sampling::Cosine },
            HemisphereSampling::Stratified => Self { rays: cells, sampling: Sampling::Grid(strata) },
            HemisphereSampling::StratifiedUniform => Self { rays: cells, sampling: Sampling::UniformGrid(strata) },
        }
    }

    /// The number of directions.
    pub(crate) fn rays(&self) -> u32 {
        self.rays
    }

    /// Direction `ray` by two random numbers, about the z axis, and its weight.
    pub(crate) fn direction(&self, ray: u32, u: Vec2) -> (Vec3, f32) {
        let uniform = |u| {
            let direction = UniformHemisphere.map(u);
            // (cos θ / π) / (1 / 2π)
            (direction, 2.0 * direction.z)
        };
        match &self.sampling {
            Sampling::Uniform => uniform(u),
            Sampling::Cosine => (CosineHemisphere.map(u), 1.0),
            Sampling::Grid(strata) => (strata.direction(ray / strata.sectors(), ray % strata.sectors(), u), 1.0),
            Sampling::UniformGrid(strata) => {
                let cell = Vec2::new((ray / strata.sectors()) as f32, (ray % strata.sectors()) as f32) + u;
                let limit = Vec2::splat(ONE_MINUS_EPSILON);
                uniform((cell / Vec2::new(strata.rings() as f32, strata.sectors() as f32)).min(limit))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use halfdome_kernel::sampling::Stream;

    use super::*;

    const ALL: [HemisphereSampling; 4] = [
        HemisphereSampling::Uniform,
        HemisphereSampling::Cosine,
        HemisphereSampling::Stratified,
        HemisphereSampling::StratifiedUniform,
    ];

    #[test]
    fn a_hemisphere_has_as_many_directions_as_asked_for_or_a_few_less() {
        for rays in [1, 2, 3, 10, 16, 100, 256, 4096] {
            for sampling in ALL {
                let directions = Hemisphere::new(sampling, rays).rays();
                assert!(directions <= rays && directions * 10 >= rays * 9, "{directions} of {rays}");
            }
        }
    }

    /// Every choice estimates the same: of 1 the mean is 1, of cos θ it is 2/3, of x it is 0.
    #[test]
    fn all_choices_agree_on_integrals() {
        let mut variances = Vec::new();
        for sampling in ALL {
            let hemisphere = Hemisphere::new(sampling, 256);
            let (mut sums, mut squares) = (glam::DVec3::ZERO, 0.0);
            for trial in 0..400 {
                let mut mean = glam::DVec3::ZERO;
                for ray in 0..hemisphere.rays() {
                    let (d, weight) = hemisphere.direction(ray, Stream::new(1, trial, ray).uniform2(0));
                    mean += f64::from(weight) * glam::DVec3::new(1.0, d.z.into(), d.x.into());
                }
                mean /= f64::from(hemisphere.rays());
                sums += mean / 400.0;
                squares += (mean.y - 2.0 / 3.0).powi(2) / 400.0;
            }
            assert!((sums - glam::DVec3::new(1.0, 2.0 / 3.0, 0.0)).abs().max_element() < 0.004, "{sampling:?}: {sums}");
            variances.push(squares);
        }
        // Strata and the cosine both take noise away.
        let [uniform, cosine, stratified, stratified_uniform] = variances[..] else { unreachable!() };
        assert!(cosine < 0.5 * uniform && stratified < 0.05 * cosine && stratified_uniform < 0.05 * uniform);
    }
}
