//! Integrators: what a camera ray is worth.
//!
//! All rays of a tile advance together. The driver traces the camera rays; an integrator gets their hits, and traces
//! what it needs further in batches.

mod ao;
mod direct;
mod flat;
mod heat;
mod montecarlo;
mod path;
mod wavefront;

use glam::Vec3;
use halfdome_kernel::sampling::Sampler;
use halfdome_kernel::{Hit, Ray};

use crate::settings::Integrator;
use crate::world::World;

use wavefront::Wavefront;

/// Camera rays that are traced together, with unit directions, and their hits.
pub(crate) struct CameraRays<'a> {
    pub rays: &'a [Ray],
    pub hits: &'a [Hit],
    /// The numbers of each ray's sample; sets from [`FIRST_SET`] on are the integrator's.
    pub samplers: &'a [Sampler],
}

/// What an integrator keeps from one batch to the next: memory alone.
#[derive(Default)]
pub(crate) struct Memory {
    wave: Wavefront,
    generations: [montecarlo::Generation; 2],
    feelers: ao::Feelers,
}

/// The camera uses the sets of random numbers before this one.
pub(crate) const FIRST_SET: u32 = 1;

/// Writes the radiance that each camera ray sees; gives the number of further rays traced.
pub(crate) fn radiance(
    world: &World,
    integrator: &Integrator,
    camera: &CameraRays,
    memory: &mut Memory,
    radiance: &mut [Vec3],
) -> u64 {
    let Memory { wave, generations, feelers } = memory;
    match integrator {
        Integrator::Path(options) => path::radiance(world, options, camera, wave, radiance, |_| ()),
        Integrator::MonteCarlo(options) => montecarlo::radiance(world, options, camera, generations, radiance),
        Integrator::Direct(options) => direct::radiance(world, options, camera, wave, radiance),
        Integrator::Ao(options) => ao::openness(world, options, camera, feelers, radiance),
        Integrator::Flat => flat::colors(world, camera, radiance),
        Integrator::Heat(options) => heat::visits(world, options, camera, wave, radiance),
        Integrator::Normals => flat::normals(world, camera, radiance),
        Integrator::Albedo => flat::albedo(world, camera, radiance),
    }
}
