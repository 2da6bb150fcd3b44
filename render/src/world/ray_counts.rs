//! Counts of the rays traced in a world, by kind.

use std::ops::Sub;
use std::sync::atomic::{AtomicU64, Ordering};

use super::World;

/// Counted by batches, from all threads.
#[derive(Debug, Default)]
pub(super) struct RayCounters {
    side_by_side: AtomicU64,
    occlusion: AtomicU64,
}

/// Rays so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct RayCounts {
    /// Coherent rays: the camera's.
    pub side_by_side: u64,
    /// Occlusion rays.
    pub occlusion: u64,
}

impl RayCounters {
    pub(super) fn add_side_by_side(&self, rays: usize) {
        self.side_by_side.fetch_add(rays as u64, Ordering::Relaxed);
    }

    pub(super) fn add_occlusion(&self, rays: usize) {
        self.occlusion.fetch_add(rays as u64, Ordering::Relaxed);
    }
}

impl Sub for RayCounts {
    type Output = Self;

    fn sub(self, before: Self) -> Self {
        Self { side_by_side: self.side_by_side - before.side_by_side, occlusion: self.occlusion - before.occlusion }
    }
}

impl World {
    /// The rays that were traced since the world was made.
    pub(crate) fn ray_counts(&self) -> RayCounts {
        let RayCounters { side_by_side, occlusion } = &self.ray_counters;
        let [side_by_side, occlusion] = [side_by_side, occlusion].map(|count| count.load(Ordering::Relaxed));
        RayCounts { side_by_side, occlusion }
    }
}
