//! Watchers of long work: they receive progress and early pictures, and may stop it.

use crate::film::{Film, Picture};

/// The greatest side of the squares of a preview, in pixels.
pub const MAX_PREVIEW_SIDE: u32 = 256;

/// Watches a render and may stop it. Called from all threads.
pub trait Watch: Sync {
    /// `samples` camera samples and `rays` rays more are done.
    fn advance(&self, samples: u64, rays: u64);
    /// Whether to stop; asked often. The samples so far still make a picture.
    fn stop(&self) -> bool;

    /// Whether the picture is no longer wanted at all: the first samples, which [`stop`](Self::stop) does not affect,
    /// are then not all taken. Called often; once true, it must stay true, and `stop` too.
    fn gives_up(&self) -> bool {
        false
    }

    /// `records` more were added to an irradiance cache.
    fn gathered(&self, _records: u64) {}

    /// An irradiance cache that is being filled serves so many of its points. That may be fewer than before, where records
    /// turn out to reach less far, or where the cache is filled anew with others.
    fn covered(&self, _points: u64) {}

    /// The irradiance cache of which [`covered`](Self::covered) last reported is finished; another follows.
    fn filled(&self) {}

    /// The side in pixels of the squares with which the picture begins, a power of two up to [`MAX_PREVIEW_SIDE`]; 1 for single
    /// pixels. The picture that [`render`](crate::driver::render()) gives does not depend on it.
    fn coarsest(&self) -> u32 {
        1
    }

    /// Sees the picture of each level from [`coarsest`](Self::coarsest) on down to 1, if it is more than 1: one sample for
    /// each square of `side` pixels. Called from the thread that renders, which waits.
    fn level(&self, _side: u32, _picture: &Picture) {}

    /// Whether [`level`](Self::level) is to see the channel of this name.
    fn wants_channel(&self, _name: &str) -> bool {
        true
    }

    /// Sees the film after each wave of samples. Called from the thread that renders.
    fn wave(&self, _film: &Film) {}

    /// Whether the film is wanted now; asked often. All threads then wait until it was [given](Self::film).
    fn wants_film(&self) -> bool {
        false
    }

    /// Takes the film so far. Called from the thread that renders.
    fn film(&self, _film: &Film) {}
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
