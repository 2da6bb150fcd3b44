//! Runs an integrator over the tiles of a picture on all threads, and keeps whoever watches informed.

use std::time::Duration;

use crate::film::Picture;

/// Watches a render and may stop it. Called from all threads.
pub trait Watch: Sync {
    /// `samples` camera samples and `rays` rays more are done.
    fn advance(&self, samples: u64, rays: u64);
    /// Whether to stop; asked often. The samples so far still make a picture.
    fn stop(&self) -> bool;
}

/// What a render gives.
#[derive(Clone, Debug)]
pub struct Render {
    /// The picture, complete or as far as it went.
    pub picture: Picture,
    /// Whether every sample was taken.
    pub finished: bool,
    /// Rays traced: camera, bounce and shadow rays.
    pub rays: u64,
    /// Wall-clock time.
    pub elapsed: Duration,
}
