//! Strips of a layout's grid: sixteen columns of cells, down all rows.
//!
//! Each cell needs its neighbours to the left and to the right, so one more column is read on each side. Rows are read
//! a few at a time, and then used: lanes that are loaded before all of their parts have been stored for a while would
//! have to wait. Each column of a strip has sums of its own, so it does not matter whether a strip is gone down once in
//! sixteen lanes or twice in eight.

use glam::Vec3;

use crate::simd::{Lanes, Simd};

/// Columns of a strip.
pub(super) const COLUMNS: usize = 16;
/// Columns that are read: one before those of the strip, and one after them.
const WIDTH: usize = COLUMNS + 2;
/// Rows that are read before they are used.
pub(super) const BLOCK: usize = 8;

/// Where lanes start in what was read.
pub(super) const BEFORE: usize = 0;
pub(super) const HERE: usize = 1;
pub(super) const NEXT: usize = 2;

/// The input: `PARTS` numbers a cell.
pub(super) trait Cells<S: Simd, const PARTS: usize> {
    /// The numbers of one cell.
    fn one(&self, cell: usize) -> [f32; PARTS];
    /// The numbers of the cells of a strip's columns, from one on, as far as they exist.
    fn many(&self, cell: usize) -> Option<[S::F16; PARTS]>;
}

/// A row of a strip.
#[derive(Clone, Copy)]
pub(super) struct Row<const PARTS: usize>(pub(super) [[f32; WIDTH]; PARTS]);

impl<const PARTS: usize> Row<PARTS> {
    /// The same numbers in all columns.
    pub(super) fn splat(parts: [f32; PARTS]) -> Self {
        Self(parts.map(|part| [part; WIDTH]))
    }

    /// Reads the cells of these columns, in the row that begins with cell `start`.
    #[inline(always)]
    pub(super) fn read<S: Simd, C: Cells<S, PARTS>>(&mut self, cells: &C, start: usize, columns: &Columns) {
        if columns.contiguous {
            self.set(0, cells.one(start + columns.cells[0]));
            if let Some(many) = cells.many(start + columns.cells[HERE]) {
                for (part, lanes) in self.0.iter_mut().zip(many) {
                    part[HERE..HERE + COLUMNS].copy_from_slice(&lanes.store());
                }
            }
            self.set(WIDTH - 1, cells.one(start + columns.cells[WIDTH - 1]));
        } else {
            for place in 0..columns.count {
                self.set(place, cells.one(start + columns.cells[place]));
            }
        }
    }

    #[inline(always)]
    fn set(&mut self, place: usize, values: [f32; PARTS]) {
        for (part, value) in self.0.iter_mut().zip(values) {
            part[place] = value;
        }
    }

    /// A part in lanes that start from column `first`, from one [before](BEFORE) or [next](NEXT) to it.
    #[inline(always)]
    pub(super) fn lanes<const FROM: usize, const N: usize, L: Lanes<N>>(&self, part: usize, first: usize) -> L {
        load(&self.0[part], first + FROM)
    }
}

/// Lanes of some numbers, from one on.
#[inline(always)]
pub(super) fn load<const N: usize, L: Lanes<N>>(numbers: &[f32], first: usize) -> L {
    let mut lanes = [0.0; N];
    lanes.copy_from_slice(&numbers[first..first + N]);
    L::load(&lanes)
}

/// The columns that a row of a strip is read from.
#[derive(Clone, Copy)]
pub(super) struct Columns {
    cells: [usize; WIDTH],
    /// How many of them there are; behind them is what was read before.
    count: usize,
    /// Whether the strip is full, and its cells follow each other.
    contiguous: bool,
}

impl Columns {
    /// The columns from `first` on of a row of so many cells; the last one is beside the first.
    #[inline(always)]
    pub(super) fn new(first: usize, columns: usize) -> Self {
        let count = COLUMNS.min(columns - first) + 2;
        let mut cells = [0; WIDTH];
        for (place, cell) in cells.iter_mut().enumerate().take(count) {
            *cell = (first + columns - 1 + place) % columns;
        }
        Self { cells, count, contiguous: count == WIDTH }
    }

    /// Other cells instead.
    #[inline(always)]
    pub(super) fn replaced(&self, cell: impl Fn(usize) -> usize) -> Self {
        Self { cells: self.cells.map(cell), contiguous: false, ..*self }
    }
}

/// The x, y and z of vectors.
#[inline(always)]
pub(super) fn parts<S: Simd>(vectors: &[Vec3; COLUMNS]) -> [S::F16; 3] {
    S::deinterleave(bytemuck::cast_ref(vectors))
}

/// The sum of the columns' sums, in one order; the lanes are one or two for a strip.
#[inline(always)]
pub(super) fn sum<const N: usize, L: Lanes<N>>(lanes: impl Iterator<Item = L>) -> f32 {
    let mut values = [0.0; COLUMNS];
    for (values, lanes) in values.chunks_exact_mut(N).zip(lanes) {
        values.copy_from_slice(&lanes.store());
    }
    let mut count = COLUMNS;
    while count > 1 {
        count /= 2;
        for i in 0..count {
            values[i] += values[i + count];
        }
    }
    values[0]
}
