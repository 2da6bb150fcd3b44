//! Where trees are built: on rayon's threads.

use halfdome_kernel::Executor;

/// The threads of the current rayon pool, and the receiver of a build's progress: fractions that add up to about 1,
/// from all threads.
#[derive(Clone, Copy)]
pub struct RayonExecutor<'w>(pub &'w (dyn Fn(f32) + Sync));

impl RayonExecutor<'_> {
    /// An executor without a receiver of progress.
    pub const UNWATCHED: Self = Self(&|_| ());
}

impl Executor for RayonExecutor<'_> {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        rayon::join(a, b)
    }

    fn advance(&self, fraction: f32) {
        (self.0)(fraction);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use glam::Vec3;
    use halfdome_kernel::{Bvh, Quality, Serial};

    use super::*;

    #[test]
    fn trees_do_not_depend_on_threads() {
        let triangle = |i: u32| {
            let at = Vec3::new((i % 97) as f32, (i % 89) as f32, (i % 83) as f32);
            [at, at + Vec3::X * (i % 7) as f32 + Vec3::Y, at + Vec3::Z]
        };
        let triangles: Vec<_> = (0..50_000).map(triangle).collect();
        for quality in Quality::ALL {
            let (expected, _) = Bvh::build_on(&Serial, &triangles, &quality.into()).unwrap();
            for threads in [1, 2, 8] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let heard = Mutex::new(Vec::new());
                let watch = |fraction| heard.lock().unwrap().push(fraction);
                let built = pool.install(|| Bvh::build_on(&RayonExecutor(&watch), &triangles, &quality.into()));
                let (bvh, _) = built.unwrap();
                assert!(bvh.view().nodes() == expected.view().nodes(), "{quality}, {threads} threads");
                let ids = |bvh: &Bvh| bvh.view().blocks().iter().map(|block| block.prim_id).collect::<Vec<_>>();
                assert!(ids(&bvh) == ids(&expected), "{quality}, {threads} threads");
                let sum: f32 = heard.into_inner().unwrap().iter().sum();
                assert!((sum - 1.0).abs() < 1e-3, "{quality}, {threads} threads: {sum}");
            }
        }
    }
}
