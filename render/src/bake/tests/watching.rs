//! Bakes that are watched, stopped and resumed.

use std::sync::atomic::{AtomicU64, Ordering};

use super::*;

/// Says stop after a number of texels and records.
struct StopsAfter(AtomicU64);

impl Watch for StopsAfter {
    fn advance(&self, texels: u64, _: u64) {
        let _ = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| Some(left.saturating_sub(texels)));
    }

    fn gathered(&self, records: u64) {
        self.advance(records, 0);
    }

    fn stop(&self) -> bool {
        self.0.load(Ordering::Relaxed) == 0
    }
}

/// Counts caches that another follows.
struct CountsCaches(AtomicU64);

impl Watch for CountsCaches {
    fn advance(&self, _: u64, _: u64) {}

    fn stop(&self) -> bool {
        false
    }

    fn filled(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

#[test]
fn a_watcher_hears_that_the_rough_cache_is_done() {
    let scene = cornell_box();
    let world = World::new(scene.clone()).unwrap();
    for (bounces, expected) in [(None, 1), (Some(1), 0)] {
        let mut options = BakeOptions { size: 16, spp: 1, ..quick() };
        (options.cache.rays, options.cache.bounces) = (64, bounces);
        let watch = CountsCaches(AtomicU64::new(0));
        let atlas = Atlas::new(&scene, &options).unwrap();
        bake(&scene, &world, atlas, &options, &Checkpoint::new(1), &watch).unwrap();
        assert_eq!(watch.0.into_inner(), expected, "{bounces:?}");
    }
}

#[test]
fn threads_and_interruptions_do_not_show() {
    let scene = cornell_box();
    let world = World::new(scene.clone()).unwrap();
    for directional in [Directional::None, Directional::Sh1] {
        let mut options = BakeOptions { size: 32, spp: 4, directional, ..quick() };
        options.cache.rays = 64;
        let atlas = Atlas::new(&scene, &options).unwrap();
        let bake_on = |threads: usize, checkpoint: &Checkpoint, watch: &dyn Watch| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| bake(&scene, &world, atlas.clone(), &options, checkpoint, watch)).map(|bake| bake.maps)
        };
        let expected = bake_on(1, &Checkpoint::new(1), &NeverStops).unwrap();
        assert!(bake_on(4, &Checkpoint::new(1), &NeverStops).unwrap() == expected);
        // From stop to stop, with the state on disk in between.
        let folder = tempfile::tempdir().unwrap();
        let path = Checkpoint::path(&folder.path().join("a.obj"));
        let keep = |checkpoint: Checkpoint| {
            checkpoint.keep(crate::output::OutputFile::check(&path).unwrap(), std::time::Duration::from_secs(3600))
        };
        let mut stops = 0;
        let resumed = loop {
            let checkpoint = keep(Checkpoint::read(&path, 1).unwrap().unwrap_or_else(|| Checkpoint::new(1)));
            match bake_on(2, &checkpoint, &StopsAfter(AtomicU64::new(100 + 50 * stops))) {
                Some(maps) => break maps,
                None => checkpoint.save().unwrap(),
            }
            stops += 1;
        };
        assert!(stops > 2, "{stops}");
        assert!(resumed == expected, "{directional:?}");
        assert!(Checkpoint::read(&path, 2).unwrap_err().problem.contains("another level"));
        std::fs::write(&path, &std::fs::read(&path).unwrap()[1..]).unwrap();
        assert!(Checkpoint::read(&path, 1).unwrap_err().problem.contains("damaged"));
    }
}
