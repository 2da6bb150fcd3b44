//! Integrators: what a camera ray is worth.
//!
//! All rays of a tile advance together. The driver traces the camera rays; an integrator gets their hits, and traces
//! what it needs further in batches.

mod normals;
mod path;

use glam::Vec3;
use halfdome_kernel::sampling::Sampler;
use halfdome_kernel::{Hit, Ray};

use crate::settings::{Integrator, Settings};
use crate::world::World;

pub(crate) use path::Wavefront;

/// Camera rays that are traced together, with unit directions, and their hits.
pub(crate) struct CameraRays<'a> {
    pub rays: &'a [Ray],
    pub hits: &'a [Hit],
    /// The numbers of each ray's sample; sets from [`FIRST_SET`] on are the integrator's.
    pub samplers: &'a [Sampler],
}

/// The camera uses the sets of random numbers before this one.
pub(crate) const FIRST_SET: u32 = 1;

/// Writes the radiance that each camera ray sees; gives the number of further rays traced.
pub(crate) fn radiance(
    world: &World,
    settings: &Settings,
    camera: &CameraRays,
    wavefront: &mut Wavefront,
    radiance: &mut [Vec3],
) -> u64 {
    match &settings.integrator {
        Integrator::Path(options) => path::radiance(world, options.max_depth, camera, wavefront, radiance),
        Integrator::Normals => normals::normals(world, camera, radiance),
        _ => normals::albedo(world, camera, radiance),
    }
}
