//! Sources of radiance at the hits of gathers' rays: paths, or a coarser irradiance cache.

use crate::world::Hit;
use glam::Vec3;
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::Sampler;

/// Computes the radiance along rays with known hits; returns the number of further rays. Emission of the hit surfaces
/// must not count.
pub(crate) trait Follow {
    /// Writes radiance for each ray that hit something.
    fn follow(&mut self, rays: &[Ray], hits: &[Hit], samplers: &[Sampler], radiance: &mut [Vec3]) -> u64;
}
