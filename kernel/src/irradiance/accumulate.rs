//! The sums of a gather in lanes: eight cells of a row at a time, down the rows, and then the next eight columns.
//!
//! A layout is made of [`Grid`]s: rows of cells, with a wall between cells above each other and between neighbours in a
//! row. Going down the rows, the cells above are those of the step before, so radiance and distance are read once.

use glam::Vec3;

use super::Gather;
use crate::simd::{Isa, Lanes, Simd, Work, dispatch};

/// Hits nearer than this, 2⁻⁶⁰, count as at this distance: it keeps reciprocals finite.
pub const LEAST_DISTANCE: f32 = 1.0 / (1u64 << 60) as f32;
/// Depth is continuous between neighbours whose distances have a ratio below this.
pub(super) const CONTINUOUS_RATIO: f32 = 1.5;

/// The numbers of a cell in the table: ∫ cos θ dω; ∫ n × ω dω, x and y; and m ∫ cos θ ds, x and y, of the walls to the
/// cell above and to the cell to the left. Walls that are not there have zeros.
pub(super) const CELL: usize = 7;

/// Eight cells' numbers.
type Octet = [[f32; 8]; CELL];

/// Cells in rows and columns, `first` and on, row by row. The left neighbour of column 0 is the last column.
#[derive(Clone, Copy)]
pub(super) struct Grid<'a> {
    pub(super) first: usize,
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Which cells are above row 0.
    pub(super) above: Above,
    /// An octet for each row in each eight columns: `table_len` numbers.
    pub(super) table: &'a [f32],
}

/// What is above the first row of a grid.
#[derive(Clone, Copy)]
pub(super) enum Above {
    /// Nothing.
    Zenith,
    /// The rim of the top of a hemicube of this size, which starts at cell 0.
    Rim(usize),
}

impl Above {
    /// The cell above `column` of the first row.
    #[inline(always)]
    pub(super) fn cell(self, column: usize) -> Option<usize> {
        match self {
            Self::Zenith => None,
            Self::Rim(size) => {
                let (along, last) = (column % size, size - 1);
                let (row, column) = match column / size {
                    0 => (along, last),
                    1 => (last, last - along),
                    2 => (last - along, 0),
                    _ => (0, along),
                };
                Some(row * size + column)
            }
        }
    }
}

/// The length of a grid's table; saturated if it overflows.
pub(super) fn table_len(rows: usize, columns: usize) -> usize {
    columns.div_ceil(8).saturating_mul(rows).saturating_mul(8 * CELL)
}

/// Writes a grid's table of [`table_len`] numbers; `cell(row, column)` gives those of a cell.
pub(super) fn fill_table(
    table: &mut [f32],
    rows: usize,
    columns: usize,
    mut cell: impl FnMut(usize, usize) -> [f64; CELL],
) {
    let octets = table.as_chunks_mut::<8>().0.as_chunks_mut::<CELL>().0;
    for (number, octet) in octets.iter_mut().enumerate() {
        let (first, row) = (number / rows * 8, number % rows);
        *octet = [[0.0; 8]; CELL];
        for lane in 0..8.min(columns - first) {
            for (lanes, value) in octet.iter_mut().zip(cell(row, first + lane)) {
                lanes[lane] = value as f32;
            }
        }
    }
}

/// What the rays found: slices of equal length.
#[derive(Clone, Copy)]
pub(super) struct Samples<'a> {
    pub(super) radiance: &'a [Vec3],
    pub(super) distance: &'a [f32],
}

/// Eight cells, red, green, blue and distance.
#[derive(Clone, Copy)]
struct Cells([[f32; 8]; 4]);

impl Cells {
    /// Black and infinitely far: adds nothing to any sum.
    const NONE: Self = Self([[0.0; 8], [0.0; 8], [0.0; 8], [f32::INFINITY; 8]]);

    #[inline(always)]
    fn set(&mut self, lane: usize, radiance: Vec3, distance: f32) {
        (self.0[0][lane], self.0[1][lane]) = (radiance.x, radiance.y);
        (self.0[2][lane], self.0[3][lane]) = (radiance.z, distance);
    }

    /// Up to eight cells from `first` on.
    #[inline(always)]
    fn read(samples: &Samples, first: usize, count: usize) -> Self {
        let mut cells = Self::NONE;
        if let Some(radiance) = samples.radiance[first..].first_chunk::<8>()
            && let Some(distance) = samples.distance[first..].first_chunk::<8>()
            && count >= 8
        {
            for lane in 0..8 {
                cells.set(lane, radiance[lane], distance[lane]);
            }
        } else {
            for lane in 0..count {
                cells.set(lane, samples.radiance[first + lane], samples.distance[first + lane]);
            }
        }
        cells
    }

    /// Each cell's left neighbour; that of the first is cell `left`.
    #[inline(always)]
    fn left(&self, samples: &Samples, left: usize) -> Self {
        let mut cells = Self::NONE;
        cells.set(0, samples.radiance[left], samples.distance[left]);
        for part in 0..4 {
            cells.0[part][1..].copy_from_slice(&self.0[part][..7]);
        }
        cells
    }
}

/// The distance, or [`LEAST_DISTANCE`] if it is not more.
pub(super) fn bound(distance: f32) -> f32 {
    if distance > LEAST_DISTANCE { distance } else { LEAST_DISTANCE }
}

/// [`bound`] in lanes.
#[inline(always)]
pub(super) fn bound_lanes<L: Lanes<8>>(distance: L) -> L {
    let least = L::splat(LEAST_DISTANCE);
    L::select(least.lt(distance), distance, least)
}

/// Eight cells in lanes.
#[derive(Clone, Copy)]
struct CellLanes<L> {
    radiance: [L; 3],
    distance: L,
    inverse: L,
}

impl<L: Lanes<8>> CellLanes<L> {
    #[inline(always)]
    fn new(cells: &Cells) -> Self {
        let [red, green, blue, distance] = &cells.0;
        let distance = bound_lanes(L::load(distance));
        Self { radiance: [L::load(red), L::load(green), L::load(blue)], distance, inverse: L::splat(1.0) / distance }
    }

    /// 1/r_AB of the walls to other cells: zero where both are infinitely far.
    #[inline(always)]
    fn wall(&self, other: &Self) -> L {
        let (near, far) = (self.inverse.max(other.inverse), self.inverse.min(other.inverse));
        let continuous = near.lt(far * L::splat(CONTINUOUS_RATIO));
        L::select(continuous, (near + far) * L::splat(0.5), near)
    }
}

/// Eight partial sums of each kind.
struct Sums<L> {
    irradiance: [L; 3],
    rotational: [[L; 2]; 3],
    translational: [[L; 2]; 3],
    inverse_distance: L,
    minimum_distance: L,
}

impl<L: Lanes<8>> Sums<L> {
    #[inline(always)]
    fn new() -> Self {
        let zero = L::splat(0.0);
        Self {
            irradiance: [zero; 3],
            rotational: [[zero; 2]; 3],
            translational: [[zero; 2]; 3],
            inverse_distance: zero,
            minimum_distance: L::splat(f32::INFINITY),
        }
    }

    /// Adds eight cells and their walls to those above and to the left.
    #[inline(always)]
    fn add(&mut self, octet: &Octet, here: &CellLanes<L>, above: &CellLanes<L>, left: &CellLanes<L>) {
        let [cosine, turn_x, turn_y, up_x, up_y, left_x, left_y] = octet;
        let cosine = L::load(cosine);
        let turn = [L::load(turn_x), L::load(turn_y)];
        let (up_wall, left_wall) = (here.wall(above), here.wall(left));
        let up = [L::load(up_x) * up_wall, L::load(up_y) * up_wall];
        let left_of = [L::load(left_x) * left_wall, L::load(left_y) * left_wall];
        for channel in 0..3 {
            let radiance = here.radiance[channel];
            let (rise_up, rise_left) = (radiance - above.radiance[channel], radiance - left.radiance[channel]);
            self.irradiance[channel] = self.irradiance[channel] + cosine * radiance;
            for axis in 0..2 {
                self.rotational[channel][axis] = self.rotational[channel][axis] + turn[axis] * radiance;
                let walls = up[axis] * rise_up + left_of[axis] * rise_left;
                self.translational[channel][axis] = self.translational[channel][axis] + walls;
            }
        }
        self.inverse_distance = self.inverse_distance + cosine * here.inverse;
        self.minimum_distance = self.minimum_distance.min(here.distance);
    }

    #[inline(always)]
    fn add_grid(&mut self, grid: &Grid, samples: &Samples) {
        let mut octets = grid.table.as_chunks::<8>().0.as_chunks::<CELL>().0.iter();
        for first in (0..grid.columns).step_by(8) {
            let count = 8.min(grid.columns - first);
            let mut above = Cells::NONE;
            for lane in 0..count {
                if let Some(cell) = grid.above.cell(first + lane) {
                    above.set(lane, samples.radiance[cell], samples.distance[cell]);
                }
            }
            let mut above = CellLanes::new(&above);
            for (row, octet) in (0..grid.rows).zip(octets.by_ref()) {
                let start = grid.first + row * grid.columns;
                let cells = Cells::read(samples, start + first, count);
                let previous = if first == 0 { grid.columns - 1 } else { first - 1 };
                let left = CellLanes::new(&cells.left(samples, start + previous));
                let here = CellLanes::new(&cells);
                self.add(octet, &here, &above, &left);
                above = here;
            }
        }
    }

    #[inline(always)]
    fn total(&self) -> Gather {
        let [red, green, blue] = &self.irradiance;
        let irradiance = [sum(*red), sum(*green), sum(*blue)];
        let gradients = [vectors(&self.rotational), vectors(&self.translational)];
        let minimum = self.minimum_distance.store().into_iter().fold(f32::INFINITY, f32::min);
        Gather::from_sums(irradiance, gradients, sum(self.inverse_distance), minimum)
    }
}

/// The sum of the lanes, in one order.
#[inline(always)]
pub(super) fn sum<L: Lanes<8>>(lanes: L) -> f32 {
    let [a, b, c, d, e, f, g, h] = lanes.store();
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

/// The sums of the lanes of a vector for each channel.
#[inline(always)]
fn vectors<L: Lanes<8>>(sums: &[[L; 2]; 3]) -> [[f32; 2]; 3] {
    let mut vectors = [[0.0; 2]; 3];
    for (vector, [x, y]) in vectors.iter_mut().zip(sums) {
        *vector = [sum(*x), sum(*y)];
    }
    vectors
}

/// The gather of grids that make up a layout.
pub(super) fn accumulate<const N: usize>(isa: Isa, grids: [Grid; N], samples: Samples) -> Gather {
    dispatch(isa, Accumulate { grids, samples })
}

struct Accumulate<'a, const N: usize> {
    grids: [Grid<'a>; N],
    samples: Samples<'a>,
}

impl<const N: usize> Work for Accumulate<'_, N> {
    type Output = Gather;
    #[inline(always)]
    fn run<S: Simd>(self) -> Gather {
        let mut sums = Sums::<S::F8>::new();
        for grid in &self.grids {
            sums.add_grid(grid, &self.samples);
        }
        sums.total()
    }
}
