//! Splitting many primitives by bins: Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies", on
//! all three axes, with the cost of blocks of `b` primitives:
//!
//! ```text
//! cost(split) = A(left) ceil(left / b) + A(right) ceil(right / b)
//! ```

use glam::Vec3A;

use super::executor::Executor;
use super::primitive::{Bounds, Primitive, PrimitiveBounds};

/// The most bins along an axis.
pub(super) const MAX_BINS: usize = 32;
/// Primitives that are binned or partitioned as one piece of work.
const CHUNK: usize = 1 << 15;

/// Numbers bins along each axis.
#[derive(Clone, Copy)]
pub(super) struct Binning {
    origin: Vec3A,
    scale: Vec3A,
    count: usize,
}

impl Binning {
    /// `count` bins, up to [`MAX_BINS`], along each side of the box around the centres.
    pub(super) fn new(centers: &Bounds, count: usize) -> Self {
        let scale = Vec3A::splat(count as f32) / (centers.max - centers.min);
        // Along a side of no length, or hardly any, all fall into the first bin.
        let scale = Vec3A::select(scale.cmplt(Vec3A::splat(f32::MAX)), scale, Vec3A::ZERO);
        Self { origin: centers.min, scale, count }
    }

    /// The bin along one axis.
    #[inline(always)]
    fn bin(&self, prim: &Primitive, axis: usize) -> usize {
        let position = (prim.center()[axis] - self.origin[axis]) * self.scale[axis];
        position.min((self.count - 1) as f32) as usize
    }

    /// The bins along all axes.
    #[inline(always)]
    fn bins(&self, prim: &Primitive) -> [usize; 3] {
        let position = (prim.center() - self.origin) * self.scale;
        let position = position.min(Vec3A::splat((self.count - 1) as f32)).to_array();
        // The remainder changes nothing, and saves a check of bounds.
        [0, 1, 2].map(|axis| position[axis] as usize % MAX_BINS)
    }
}

/// The contents of the bins of each axis.
#[derive(Clone)]
pub(super) struct Bins {
    bounds: [[Bounds; 3]; MAX_BINS],
    prims: [[u32; 3]; MAX_BINS],
}

/// A way to split: primitives in bins up to `last` along `axis` go to the left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    axis: usize,
    last: usize,
    /// The boxes around both sides.
    bounds: [Bounds; 2],
}

impl Bins {
    const EMPTY: Self = Self { bounds: [[Bounds::EMPTY; 3]; MAX_BINS], prims: [[0; 3]; MAX_BINS] };

    /// Puts primitives into bins.
    pub(super) fn fill<E: Executor>(executor: &E, binning: &Binning, prims: &[Primitive]) -> Self {
        if prims.len() > CHUNK {
            let (a, b) = prims.split_at(prims.len() / 2);
            let fill = |prims| move || Self::fill(executor, binning, prims);
            let (mut bins, other) = executor.join(fill(a), fill(b));
            bins.add(&other);
            return bins;
        }
        let mut bins = Self::EMPTY;
        for prim in prims {
            let bounds = prim.bounds();
            for (axis, bin) in binning.bins(prim).into_iter().enumerate() {
                bins.bounds[bin][axis].grow(&bounds);
                bins.prims[bin][axis] += 1;
            }
        }
        bins
    }

    fn add(&mut self, other: &Self) {
        for bin in 0..MAX_BINS {
            for axis in 0..3 {
                self.bounds[bin][axis].grow(&other.bounds[bin][axis]);
                self.prims[bin][axis] += other.prims[bin][axis];
            }
        }
    }

    /// The cheapest split if `lanes` primitives fill a block; `None` if all are in one bin along each axis. Of equally
    /// cheap ones the most balanced.
    pub(super) fn best(&self, binning: &Binning, lanes: u32) -> Option<Split> {
        let blocks = |prims: u32| prims.div_ceil(lanes) as f32;
        let count = binning.count;
        // Cost and box of what is right of each bin.
        let mut right = [[(0.0, Bounds::EMPTY); 3]; MAX_BINS];
        let mut bounds = [Bounds::EMPTY; 3];
        let mut prims = [0; 3];
        for bin in (1..count).rev() {
            for axis in 0..3 {
                bounds[axis].grow(&self.bounds[bin][axis]);
                prims[axis] += self.prims[bin][axis];
                right[bin - 1][axis] = (bounds[axis].half_area() * blocks(prims[axis]), bounds[axis]);
            }
        }
        let total = core::array::from_fn::<u32, 3, _>(|axis| prims[axis] + self.prims[0][axis])[0];
        let mut best: Option<(f32, u32, Split)> = None;
        let mut bounds = [Bounds::EMPTY; 3];
        let mut prims = [0; 3];
        for bin in 0..count - 1 {
            for axis in 0..3 {
                bounds[axis].grow(&self.bounds[bin][axis]);
                prims[axis] += self.prims[bin][axis];
                if prims[axis] == 0 || prims[axis] == total {
                    continue;
                }
                let (cost, right) = right[bin][axis];
                let cost = cost + bounds[axis].half_area() * blocks(prims[axis]);
                let imbalance = prims[axis].abs_diff(total - prims[axis]);
                if best.is_none_or(|(least, least_imbalance, _)| {
                    cost < least || cost == least && imbalance < least_imbalance
                }) {
                    best = Some((cost, imbalance, Split { axis, last: bin, bounds: [bounds[axis], right] }));
                }
            }
        }
        best.map(|(_, _, split)| split)
    }
}

impl Split {
    /// Moves the left side's primitives to the front; returns their number and both sides' extents.
    pub(super) fn partition<E: Executor>(
        &self,
        executor: &E,
        binning: &Binning,
        prims: &mut [Primitive],
    ) -> (usize, [PrimitiveBounds; 2]) {
        let (middle, centers) = self.move_left(executor, binning, prims);
        let side = |i: usize| PrimitiveBounds { bounds: self.bounds[i], centers: centers[i] };
        (middle, [side(0), side(1)])
    }

    /// The number of primitives on the left, and the boxes around both sides' centres.
    fn move_left<E: Executor>(&self, executor: &E, binning: &Binning, prims: &mut [Primitive]) -> (usize, [Bounds; 2]) {
        if prims.len() > CHUNK {
            let half = prims.len() / 2;
            let (a, b) = prims.split_at_mut(half);
            let part = |prims| move || self.move_left(executor, binning, prims);
            let ((left, mut centers), (more, other)) = executor.join(part(a), part(b));
            centers[0].grow(&other[0]);
            centers[1].grow(&other[1]);
            // Right of the first half and left of the second change places.
            let swapped = (half - left).min(more);
            let (front, back) = prims[left..half + more].split_at_mut(swapped);
            let rest = back.len() - swapped;
            front.swap_with_slice(&mut back[rest..]);
            return (left + more, centers);
        }
        // Without a branch on the side, which would be unpredictable.
        let mut centers = [Bounds::EMPTY; 2];
        let mut middle = 0;
        for i in 0..prims.len() {
            let prim = prims[i];
            let on_left = binning.bin(&prim, self.axis) <= self.last;
            centers[usize::from(!on_left)].grow_to(prim.center());
            prims[i] = prims[middle];
            prims[middle] = prim;
            middle += usize::from(on_left);
        }
        (middle, centers)
    }
}
