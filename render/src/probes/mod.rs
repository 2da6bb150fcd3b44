//! Light probes: incident light from all directions at points in space, on a grid or in a list.

mod gather;
mod grid;
pub mod harmonics;
mod place;
mod quadrature;
#[cfg(test)]
mod tests;
mod volume;

use glam::Vec3;
use rayon::prelude::*;

pub use gather::ProbeLight;
pub use grid::ProbeGrid;
pub use volume::{Volume, volume};

use crate::settings::named;
use crate::watch::Watch;
use crate::world::World;
use gather::ProbeGatherer;
use quadrature::Quadrature;

/// The estimator of light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Directions of a probe in which paths look for what surfaces reflect, and the sky; about, and at least 18.
    pub rays: u32,
    /// Samples of direct light on each of a probe's two sides, at least 1.
    pub spp: u32,
    /// Selects the random numbers.
    pub seed: u64,
}

/// A probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// The position where the light was computed.
    pub position: Vec3,
    /// Whether the place is as good as any.
    pub state: State,
    /// The part of all directions in which the backs of surfaces are seen there, from 0 to 1.
    pub backs: f32,
    /// The incident light.
    pub light: ProbeLight,
}

/// Whether a probe is in the open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// It is.
    Free,
    /// The probe's place on the grid was inside a solid, and it has been moved outside.
    Moved,
    /// All of its cell is inside of something, and its light is that of its neighbours.
    Filled,
    /// The probe is inside a solid: on a grid without free points its light is zero; a listed point has the light found
    /// there.
    Covered,
}

named!(State: Free = "free", Moved = "moved", Filled = "filled", Covered = "covered");

/// Probes in the order of their points, and what they took.
#[derive(Clone, Debug, PartialEq)]
pub struct Probes {
    /// The probes.
    pub probes: Vec<Probe>,
    /// Rays traced for light.
    pub rays: u64,
}

/// Probes of a grid, in its order, on the threads of the current rayon pool; `None` if the watcher stops. They depend
/// on the world, the grid and the options alone.
pub fn on_grid(world: &World, grid: &ProbeGrid, options: &Options, watch: &dyn Watch) -> Option<Probes> {
    let mut probes = place::probes(world, grid, watch)?;
    let rays = gather(world, &mut probes, |probe| probe.state != State::Covered, options, watch)?;
    place::fill(grid, &mut probes);
    Some(Probes { probes, rays })
}

/// Probes at points, which are never moved. Else like [`on_grid`].
pub fn at_points(world: &World, points: &[Vec3], options: &Options, watch: &dyn Watch) -> Option<Probes> {
    let probe = |(&position, backs): (&Vec3, f32)| {
        let state = if place::is_covered(backs) { State::Covered } else { State::Free };
        Probe { position, state, backs, light: ProbeLight::default() }
    };
    let mut probes: Vec<Probe> = points.iter().zip(place::backs(world, points, watch)?).map(probe).collect();
    let rays = gather(world, &mut probes, |_| true, options, watch)?;
    Some(Probes { probes, rays })
}

/// Finds the light of the chosen probes; gives the number of rays.
fn gather(
    world: &World,
    probes: &mut [Probe],
    chosen: impl Fn(&Probe) -> bool + Sync,
    options: &Options,
    watch: &dyn Watch,
) -> Option<u64> {
    let sphere = Quadrature::with_directions(options.rays);
    let one = |gatherer: &mut ProbeGatherer, (number, probe): (usize, &mut Probe)| {
        if watch.stop() {
            return None;
        }
        let mut rays = 0;
        if chosen(probe) {
            (probe.light, rays) = gatherer.light(probe.position, number as u32);
        }
        watch.advance(1, rays);
        Some(rays)
    };
    let rays: Option<Vec<u64>> =
        probes.par_iter_mut().enumerate().map_init(|| ProbeGatherer::new(world, options, &sphere), one).collect();
    Some(rays?.iter().sum())
}
