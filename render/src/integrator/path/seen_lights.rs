//! Lights with a size that rays of paths hit.

use glam::Vec3;

use super::{Advance, SKY};
use crate::estimator::SeenLight;
use crate::integrator::emission::{lights_beyond_panes, lights_on_the_way};
use crate::world::time_of;

impl Advance<'_, '_> {
    /// Lets all paths see those before what they have hit.
    #[inline(never)]
    pub(super) fn see_lights(&mut self) {
        let world = self.world;
        if world.lights.sized.is_empty() {
            return;
        }
        for source in 0..self.wave.paths.len() {
            let (path, ray, hit) = (self.wave.paths[source], self.wave.rays[source], self.wave.hits[source]);
            let until = (hit.t, time_of(self.batch.times, path.index as usize));
            let how = (self.options.lights, SKY);
            let mut see = |seen: &SeenLight, light: Vec3| {
                let transmittance = self.wave.transmittance(world, source, seen.distance);
                let found = self.clamped(path.throughput * light * transmittance);
                self.radiance[path.index as usize] += found;
                self.record_light(source, seen.number, found);
                self.learn_found(source, found);
            };
            lights_on_the_way(world, how, &path, &ray, until, &mut see);
            lights_beyond_panes(world, how, &path, &ray, &hit, &mut see);
        }
    }
}
