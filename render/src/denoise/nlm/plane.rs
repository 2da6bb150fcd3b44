//! Planes with a border, so that loops over neighbours and patches need no test at the picture's edges.

/// The radius of a window.
pub(super) const WINDOW: usize = 9;
/// The radius of a patch.
pub(super) const PATCH: usize = 3;
/// The border: a window's pixels, and the patches around these.
pub(super) const BORDER: usize = WINDOW + PATCH;

/// The size of a picture, and of its planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Extent {
    pub(super) width: usize,
    pub(super) height: usize,
}

/// Values of a picture's pixels, and of those of its border, which are like the nearest pixel's.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    extent: Extent,
    values: Vec<f32>,
}

impl Extent {
    pub(super) fn len(self) -> usize {
        self.width * self.height
    }

    /// Values from one row to the next in a plane.
    pub(super) fn stride(self) -> usize {
        self.width + 2 * BORDER
    }

    /// The index of a pixel in a plane; it may be in the border.
    #[inline(always)]
    pub(super) fn index(self, x: isize, y: isize) -> usize {
        let border = BORDER as isize;
        ((y + border) * self.stride() as isize + x + border) as usize
    }
}

impl Plane {
    /// The plane of a function of pixels' indices.
    pub(super) fn new(extent: Extent, value: impl Fn(usize) -> f32) -> Self {
        let inner = |i: usize, side: usize| i.saturating_sub(BORDER).min(side - 1);
        let rows = (0..extent.height + 2 * BORDER).map(|y| inner(y, extent.height));
        let columns = 0..extent.stride();
        let pixels = rows.flat_map(|y| columns.clone().map(move |x| y * extent.width + inner(x, extent.width)));
        Self { extent, values: pixels.map(value).collect() }
    }

    /// `count` values from this pixel on, to the right.
    #[inline(always)]
    pub(super) fn row(&self, x: isize, y: isize, count: usize) -> &[f32] {
        let start = self.extent.index(x, y);
        &self.values[start..start + count]
    }
}

/// The mean of `values` over the square that reaches `radius` from each pixel, cut off at the edges.
pub(super) fn blurred(extent: Extent, values: &[f32], radius: usize) -> Vec<f32> {
    let Extent { width, height } = extent;
    let blur = |source: &[f32], count: usize, step: usize, lines: usize, line: usize| {
        let mut target = vec![0.0; source.len()];
        let mut sums = vec![0.0_f64; count + 1];
        for start in (0..lines).map(|i| i * line) {
            for i in 0..count {
                sums[i + 1] = sums[i] + f64::from(source[start + i * step]);
            }
            for i in 0..count {
                let (from, to) = (i.saturating_sub(radius), (i + radius + 1).min(count));
                target[start + i * step] = ((sums[to] - sums[from]) / (to - from) as f64) as f32;
            }
        }
        target
    };
    let across = blur(values, width, 1, height, width);
    blur(&across, height, width, width, 1)
}
