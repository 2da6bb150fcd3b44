//! Executors of builds: the kernel splits the work, the caller provides the threads.

/// Runs the parts of a build, on as many threads as it likes, and receives the build's progress.
///
/// The tree does not depend on the executor: the triangles alone decide what is split and in what order parts are
/// joined.
pub trait Executor: Sync {
    /// Runs both closures to their end, perhaps at the same time, and returns both results.
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B);

    /// Reports that another `fraction` of the build is done; called from all threads. All fractions add up to about 1.
    fn advance(&self, fraction: f32) {
        let _ = fraction;
    }
}

/// Runs everything on the caller's thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Serial;

impl Executor for Serial {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        (a(), b())
    }
}

/// Runs on the current pool of rayon.
#[cfg(feature = "rayon")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayonExecutor;

#[cfg(feature = "rayon")]
impl Executor for RayonExecutor {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        rayon::join(a, b)
    }
}

/// Shows `visit` each of `items` and its index, which for the first is `first`, in pieces of up to `task`.
pub(crate) fn for_each<E: Executor, T: Send>(
    executor: &E,
    task: usize,
    first: usize,
    items: &mut [T],
    visit: &(impl Fn(usize, &mut T) + Sync),
) {
    if items.len() > task {
        let middle = items.len() / 2;
        let (a, b) = items.split_at_mut(middle);
        executor
            .join(|| for_each(executor, task, first, a, visit), || for_each(executor, task, first + middle, b, visit));
    } else {
        (first..).zip(items).for_each(|(index, item)| visit(index, item));
    }
}

// Miri would take hours.
#[cfg(all(test, feature = "rayon", not(miri)))]
mod tests {
    use super::*;
    use crate::traverse::tests::{Random, soup};
    use crate::{Bvh, Quality};

    #[test]
    fn rayon_changes_nothing_in_the_tree() {
        let triangles = soup(&mut Random(83), 20_000, 0.05);
        let bits = |tree: &Bvh| bytemuck::cast_slice::<_, u32>(tree.view().nodes()).to_vec();
        for quality in Quality::ALL {
            let (mut one, report) = Bvh::build(&triangles, &quality.into()).unwrap();
            let (mut many, same) = Bvh::build_on(&RayonExecutor, &triangles, &quality.into()).unwrap();
            assert!(report == same && bits(&one) == bits(&many));
            let moved: alloc::vec::Vec<_> = triangles.iter().map(|corners| corners.map(|p| p * 2.0 - p.x)).collect();
            let refit = one.refit(&moved).unwrap();
            assert_eq!(many.refit_on(&RayonExecutor, &moved).unwrap(), refit);
            assert!(bits(&one) == bits(&many));
        }
    }
}
