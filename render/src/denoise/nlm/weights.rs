//! Weights between pixels by how alike the patches around them are in a noisy picture.
//!
//! `d² = Σ ((u_p - u_q)² - 2 min(v_p, v_q)) / (ε + k² (v_p + v_q))` is the mean over colours and the patch, with the
//! picture `u` and its variance `v`: about 0 if only noise tells the patches apart. The weight is `exp(-max(d², 0))`.
//!
//! Source: Rousselle, Knaus and Zwicker, "Adaptive Rendering with Non-Local Means Filtering", 2012.
//!
//! Deviations: they subtract `v_p + min(v_p, v_q)`; here distances are symmetric, so that a pixel's weights are also
//! those that others give it. The exponential is `(1 - d²/8)⁸`, without a tail and of plain multiplications, which are
//! equal on all machines.

use super::plane::{Extent, PATCH, Plane, WINDOW};

/// Pixels across and down that are worked on together.
pub(super) const TILE: [usize; 2] = [64, 16];
const PIXELS: usize = TILE[0] * TILE[1];
/// Pixels across a tile with the patches around it.
const ACROSS: usize = TILE[0] + 2 * PATCH;
const DOWN: usize = TILE[1] + 2 * PATCH;

/// A noisy picture and its variance.
pub(super) struct Noisy<'a> {
    pub(super) color: &'a [Plane; 3],
    pub(super) variance: &'a [Plane; 3],
    /// The square of a negligible brightness.
    pub(super) epsilon: f32,
    pub(super) k: f32,
}

/// For each offset in a window the weights of a tile's pixels.
pub(super) struct Weights {
    values: Vec<[f32; PIXELS]>,
    /// Distances of pixels, and sums of these down the patches.
    distances: Vec<f32>,
    columns: Vec<f32>,
}

/// The offsets of a window.
pub(super) fn offsets() -> impl Iterator<Item = (isize, isize)> {
    let reach = || -(WINDOW as isize)..=WINDOW as isize;
    reach().flat_map(move |y| reach().map(move |x| (x, y)))
}

impl Weights {
    pub(super) fn new() -> Self {
        let count = offsets().count();
        Self {
            values: vec![[0.0; PIXELS]; count],
            distances: vec![0.0; ACROSS * DOWN],
            columns: vec![0.0; ACROSS * TILE[1]],
        }
    }

    /// The weights of the pixels in a row of the tile, in the order of [`offsets`].
    #[inline(always)]
    pub(super) fn row(&self, offset: usize, row: usize) -> &[f32; TILE[0]] {
        let start = row * TILE[0];
        self.values[offset][start..start + TILE[0]].try_into().expect("a row")
    }

    /// Finds the weights of the tile whose first pixel is `(left, top)`, by the picture `noisy`.
    #[inline(always)]
    pub(super) fn find(&mut self, noisy: &Noisy, extent: Extent, (left, top): (usize, usize)) {
        let across = TILE[0].min(extent.width - left);
        let down = TILE[1].min(extent.height - top);
        for (number, (dx, dy)) in offsets().enumerate() {
            self.distances(noisy, (left as isize, top as isize), (dx, dy), (across, down));
            let values = &mut self.values[number];
            sum_patches(&self.distances, &mut self.columns, values, (across, down));
            // Parts of the window outside of the picture are empty.
            let inside = |i: usize, start: usize, d: isize, end: usize| {
                let i = (start + i) as isize + d;
                i >= 0 && i < end as isize
            };
            for y in 0..down {
                let row = &mut values[y * TILE[0]..(y + 1) * TILE[0]];
                if !inside(y, top, dy, extent.height) {
                    row.fill(0.0);
                    continue;
                }
                let outside = |x: &usize| !inside(*x, left, dx, extent.width);
                (0..across).filter(outside).for_each(|x| row[x] = 0.0);
                row[across..].fill(0.0);
            }
        }
    }

    #[inline(always)]
    fn distances(
        &mut self,
        noisy: &Noisy,
        (left, top): (isize, isize),
        (dx, dy): (isize, isize),
        (across, down): (usize, usize),
    ) {
        let Noisy { color, variance, epsilon, k } = noisy;
        let (count, patch, k2) = (across + 2 * PATCH, PATCH as isize, k * k);
        for row in 0..down + 2 * PATCH {
            let (x, y) = (left - patch, top - patch + row as isize);
            let sums = &mut self.distances[row * ACROSS..row * ACROSS + count];
            sums.fill(0.0);
            for (color, variance) in color.iter().zip(variance.iter()) {
                let (here, there) = (color.row(x, y, count), color.row(x + dx, y + dy, count));
                let (v_here, v_there) = (variance.row(x, y, count), variance.row(x + dx, y + dy, count));
                for i in 0..count {
                    let (v, w) = (v_here[i], v_there[i]);
                    let difference = here[i] - there[i];
                    let least = if v < w { v } else { w };
                    sums[i] += (difference * difference - 2.0 * least) / (epsilon + k2 * (v + w));
                }
            }
        }
    }
}

/// Sums distances of pixels over patches, and turns them into weights.
#[inline(always)]
fn sum_patches(distances: &[f32], columns: &mut [f32], values: &mut [f32; PIXELS], (across, down): (usize, usize)) {
    const SIDE: usize = 2 * PATCH + 1;
    const SCALE: f32 = 1.0 / (8.0 * 3.0 * (SIDE * SIDE) as f32);
    let count = across + 2 * PATCH;
    for y in 0..down {
        let sums = &mut columns[y * ACROSS..y * ACROSS + count];
        sums.fill(0.0);
        for row in 0..SIDE {
            let start = (y + row) * ACROSS;
            sums.iter_mut().zip(&distances[start..start + count]).for_each(|(sum, value)| *sum += value);
        }
    }
    for y in 0..down {
        let sums = &columns[y * ACROSS..(y + 1) * ACROSS];
        let row = &mut values[y * TILE[0]..(y + 1) * TILE[0]];
        for x in 0..across {
            let mut sum = 0.0;
            for i in 0..SIDE {
                sum += sums[x + i];
            }
            let d = sum * SCALE;
            let d = if d > 0.0 { d } else { 0.0 };
            let base = if d < 1.0 { 1.0 - d } else { 0.0 };
            let squared = base * base;
            row[x] = (squared * squared) * (squared * squared);
        }
    }
}
