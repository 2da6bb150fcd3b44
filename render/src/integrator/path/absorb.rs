//! Absorption of paths' light in solids (see [`media`](crate::integrator::media)); it costs nothing in scenes without
//! such solids.

use glam::Vec3;

use super::Advance;
use crate::integrator::media::Arrival;
use crate::integrator::path_block::{Bounces, PathBlock, ShadowRays};

impl Advance<'_, '_> {
    /// Whether any solid absorbs light.
    #[inline(always)]
    pub(super) fn is_absorbed(&self) -> bool {
        !self.wave.media.is_empty()
    }

    /// Dims paths by the way to where they have arrived.
    #[inline(never)]
    pub(super) fn absorb_on_the_way(&self, block: &mut PathBlock) {
        for i in 0..block.len {
            let distance = self.wave.hits[block.source[i] as usize].t;
            block.dim(i, self.arrival(block, i).transmittance(distance));
        }
    }

    /// Dims light samples by the way to the lights.
    #[inline(never)]
    pub(super) fn absorb_light_samples(&self, block: &PathBlock, shadows: &mut ShadowRays) {
        for i in 0..block.len {
            if shadows.is_lit(i) {
                shadows.dim(i, self.arrival(block, i).transmittance_of(&shadows.ray(i)));
            }
        }
    }

    /// Keeps the media of a block's continuing paths.
    #[inline(never)]
    pub(super) fn keep_media(&mut self, block: &PathBlock, bounces: &Bounces) {
        for i in (0..block.len).filter(|&i| bounces.goes_on[i] != 0) {
            let media = self.arrival(block, i).onwards(bounces.direction(i));
            self.wave.next_media.push(media);
        }
    }

    /// Keeps those of path `i` for one that was aimed from there.
    pub(super) fn keep_media_of_aimed(&mut self, block: &PathBlock, i: usize, direction: Vec3) {
        if self.is_absorbed() {
            let media = self.arrival(block, i).onwards(direction);
            self.wave.aimed_media.push(media);
        }
    }

    /// Path `i` where it has arrived.
    pub(super) fn arrival(&self, block: &PathBlock, i: usize) -> Arrival<'_> {
        let media = self.wave.media[block.source[i] as usize];
        Arrival { world: self.world, media, boundary: block.boundary(i) }
    }
}
