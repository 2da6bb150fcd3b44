//! Watchers of long work: they receive progress and early pictures, and may stop it.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::film::{Film, Picture};

/// The greatest side of the squares of a preview, in pixels.
pub const MAX_PREVIEW_SIDE: u32 = 256;

/// Watches a render and may stop it. Called from all threads.
pub trait Watch: Sync {
    /// Another `samples` camera samples and `rays` rays are done.
    fn advance(&self, samples: u64, rays: u64);
    /// Whether to stop; called often, from all threads. Once true, it should stay true. The samples so far still make a
    /// picture.
    fn stop(&self) -> bool;

    /// Whether the picture is no longer wanted at all: the first samples, which [`stop`](Self::stop) does not affect,
    /// are then not all taken. Called often; once true, it must stay true, and `stop` too.
    fn gives_up(&self) -> bool {
        false
    }

    /// Another `records` records were added to an irradiance cache.
    fn gathered(&self, _records: u64) {}

    /// The number of points covered by an irradiance cache that is being filled. It may fall where radii shrink, or
    /// where the cache is refilled with other records.
    fn covered(&self, _points: u64) {}

    /// The irradiance cache of which [`covered`](Self::covered) last reported is finished; another follows.
    fn filled(&self) {}

    /// The side in pixels of the squares with which the picture begins, a power of two up to [`MAX_PREVIEW_SIDE`]; 1
    /// for single pixels. The picture that [`render`](crate::driver::render()) gives does not depend on it.
    fn coarsest(&self) -> u32 {
        1
    }

    /// Receives the picture of each level from [`coarsest`](Self::coarsest) on down to 1, if it is more than 1: one
    /// sample for each square of `side` pixels. Called from the rendering thread, which waits.
    fn level(&self, _side: u32, _picture: &Picture) {}

    /// Whether [`level`](Self::level) needs the channel of this name.
    fn wants_channel(&self, _name: &str) -> bool {
        true
    }

    /// Receives the film after each wave of samples. Called from the rendering thread.
    fn wave(&self, _film: &Film) {}

    /// Whether the film is wanted now; called often. All threads then wait until it has been [delivered](Self::film).
    fn wants_film(&self) -> bool {
        false
    }

    /// Takes the film so far. Called from the rendering thread.
    fn film(&self, _film: &Film) {}
}

/// Stops work that traces more rays than it may, besides where another watcher stops it.
///
/// How far such work comes depends on threads, but not whether it is stopped.
pub(crate) struct RayLimit<'a> {
    watch: &'a dyn Watch,
    most: u64,
    traced: AtomicU64,
}

impl<'a> RayLimit<'a> {
    /// Stops after `most` rays.
    pub(crate) fn new(watch: &'a dyn Watch, most: u64) -> Self {
        Self { watch, most, traced: AtomicU64::new(0) }
    }

    /// The watcher without the limit.
    pub(crate) fn watch(&self) -> &'a dyn Watch {
        self.watch
    }

    /// Whether more rays have been traced. Once all work is done, this does not depend on threads.
    pub(crate) fn is_exceeded(&self) -> bool {
        self.traced.load(Ordering::Relaxed) > self.most
    }
}

impl Watch for RayLimit<'_> {
    fn advance(&self, samples: u64, rays: u64) {
        self.traced.fetch_add(rays, Ordering::Relaxed);
        self.watch.advance(samples, rays);
    }

    fn stop(&self) -> bool {
        self.is_exceeded() || self.watch.stop()
    }

    fn gathered(&self, records: u64) {
        self.watch.gathered(records);
    }

    fn covered(&self, points: u64) {
        self.watch.covered(points);
    }

    fn filled(&self) {
        self.watch.filled();
    }
}

/// Watches nothing.
#[cfg(test)]
pub(crate) struct NeverStops;

#[cfg(test)]
impl Watch for NeverStops {
    fn advance(&self, _: u64, _: u64) {}

    fn stop(&self) -> bool {
        false
    }
}
