//! What solids absorb of paths' light (see [`media`](crate::integrator::media)); nothing of it happens where none does.

use glam::Vec3;
use halfdome_kernel::Ray;

use super::Advance;
use crate::integrator::media::Media;
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
            let source = block.source[i] as usize;
            let distance = self.wave.hits[source].t;
            let part = self.wave.media[source].transmittance_to(self.world, &block.boundary(i), distance);
            block.dim(i, part);
        }
    }

    /// Dims light samples by the way to the lights.
    #[inline(never)]
    pub(super) fn absorb_light_samples(&self, block: &PathBlock, shadows: &mut ShadowRays) {
        for i in 0..block.len {
            if shadows.is_lit(i) {
                let part = self.left_of_light(block, i, &shadows.ray(i));
                shadows.dim(i, part);
            }
        }
    }

    /// What is left of light along a shadow ray of path `i`.
    pub(super) fn left_of_light(&self, block: &PathBlock, i: usize, ray: &Ray) -> Vec3 {
        self.media_towards(block, i, ray.direction).transmittance_along(self.world, ray)
    }

    /// Keeps the media of the paths of a block that go on.
    #[inline(never)]
    pub(super) fn keep_media(&mut self, block: &PathBlock, bounces: &Bounces) {
        for i in (0..block.len).filter(|&i| bounces.goes_on[i] != 0) {
            let media = self.media_towards(block, i, bounces.direction(i));
            self.wave.next_media.push(media);
        }
    }

    /// Keeps those of path `i` for one that was aimed from there.
    pub(super) fn keep_media_of_aimed(&mut self, block: &PathBlock, i: usize, direction: Vec3) {
        if self.is_absorbed() {
            let media = self.media_towards(block, i, direction);
            self.wave.next_media.push(media);
        }
    }

    fn media_towards(&self, block: &PathBlock, i: usize, direction: Vec3) -> Media {
        self.wave.media[block.source[i] as usize].towards(self.world, &block.boundary(i), direction)
    }
}
