//! The sums of a gather in lanes, [strip](super::strip) by strip.
//!
//! A layout is made of [`Grid`]s: rows of cells, with a wall between cells above each other and between neighbours in a
//! row. Going down the rows, the cells above are those of the step before.

use glam::Vec3;

use super::Gather;
use super::strip::{BEFORE, BLOCK, COLUMNS, Cells, Columns, HERE, Row, load, parts, sum};
use crate::simd::{Isa, Lanes, Simd, Work, dispatch};

/// Hits nearer than this, 2⁻⁶⁰, count as at this distance: it keeps reciprocals finite.
pub const MIN_DISTANCE: f32 = 1.0 / (1u64 << 60) as f32;
/// Depth is continuous between neighbours whose distances have a ratio below this.
pub(super) const CONTINUOUS_RATIO: f32 = 1.5;

/// The numbers of a cell in the table: ∫ cos θ dω; ∫ n × ω dω, x and y; and m ∫ cos θ ds, x and y, of the walls to the
/// cell above and to the cell to the left. Walls that are not there have zeros.
pub(super) const CELL: usize = 7;

/// The numbers of a row of a strip.
type Group = [[f32; COLUMNS]; CELL];

/// Cells in rows and columns, `first` and on, row by row. The left neighbour of column 0 is the last column.
#[derive(Clone, Copy)]
pub(super) struct Grid<'a> {
    pub(super) first: usize,
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Which cells are above row 0.
    pub(super) above: Above,
    /// A group for each row of each strip: `table_len` numbers.
    pub(super) table: &'a [f32],
}

/// The row above the first row of a grid.
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
    columns.div_ceil(COLUMNS).saturating_mul(rows).saturating_mul(COLUMNS * CELL)
}

/// Writes a grid's table of [`table_len`] numbers; `cell(row, column)` gives those of a cell.
pub(super) fn fill_table(
    table: &mut [f32],
    rows: usize,
    columns: usize,
    mut cell: impl FnMut(usize, usize) -> [f64; CELL],
) {
    let groups = table.as_chunks_mut::<COLUMNS>().0.as_chunks_mut::<CELL>().0;
    for (number, group) in groups.iter_mut().enumerate() {
        let (first, row) = (number / rows * COLUMNS, number % rows);
        *group = [[0.0; COLUMNS]; CELL];
        for lane in 0..COLUMNS.min(columns - first) {
            for (lanes, value) in group.iter_mut().zip(cell(row, first + lane)) {
                lanes[lane] = value as f32;
            }
        }
    }
}

/// The results of the rays: slices of equal length.
#[derive(Clone, Copy)]
pub(super) struct Samples<'a> {
    pub(super) radiance: &'a [Vec3],
    pub(super) distance: &'a [f32],
}

/// A row of cells: red, green, blue, distance and its reciprocal.
type Light = Row<5>;

/// Black and infinitely far: adds nothing to any sum.
const NONE: [f32; 5] = [0.0, 0.0, 0.0, f32::INFINITY, 0.0];

impl<S: Simd> Cells<S, 5> for Samples<'_> {
    #[inline(always)]
    fn one(&self, cell: usize) -> [f32; 5] {
        let Vec3 { x, y, z } = self.radiance[cell];
        let distance = bound(self.distance[cell]);
        [x, y, z, distance, 1.0 / distance]
    }

    #[inline(always)]
    fn many(&self, cell: usize) -> Option<[S::F16; 5]> {
        let [red, green, blue] = parts::<S>(self.radiance[cell..].first_chunk()?);
        let distance = bound_lanes(S::F16::load(self.distance[cell..].first_chunk()?));
        Some([red, green, blue, distance, S::F16::splat(1.0) / distance])
    }
}

/// The distance, or [`MIN_DISTANCE`] if it is not more.
pub(super) fn bound(distance: f32) -> f32 {
    if distance > MIN_DISTANCE { distance } else { MIN_DISTANCE }
}

/// [`bound`] in lanes.
#[inline(always)]
pub(super) fn bound_lanes<L: Lanes<COLUMNS>>(distance: L) -> L {
    let least = L::splat(MIN_DISTANCE);
    L::select(least.lt(distance), distance, least)
}

/// Cells in lanes.
#[derive(Clone, Copy)]
struct CellLanes<const N: usize, L> {
    radiance: [L; 3],
    inverse: L,
}

impl<const N: usize, L: Lanes<N>> CellLanes<N, L> {
    #[inline(always)]
    fn new<const FROM: usize>(row: &Light, first: usize) -> Self {
        let radiance =
            [row.lanes::<FROM, N, L>(0, first), row.lanes::<FROM, N, L>(1, first), row.lanes::<FROM, N, L>(2, first)];
        Self { radiance, inverse: row.lanes::<FROM, N, L>(4, first) }
    }

    /// 1/r_AB of the walls to other cells: zero where both are infinitely far.
    #[inline(always)]
    fn wall(&self, other: &Self) -> L {
        let (near, far) = (self.inverse.max(other.inverse), self.inverse.min(other.inverse));
        let continuous = near.lt(far * L::splat(CONTINUOUS_RATIO));
        L::select(continuous, (near + far) * L::splat(0.5), near)
    }
}

/// Partial sums of each kind.
#[derive(Clone, Copy)]
struct Sums<const N: usize, L> {
    irradiance: [L; 3],
    rotational: [[L; 2]; 3],
    translational: [[L; 2]; 3],
    inverse_distance: L,
    minimum_distance: L,
    squares: [L; 3],
}

impl<const N: usize, L: Lanes<N>> Sums<N, L> {
    #[inline(always)]
    fn new() -> Self {
        let zero = L::splat(0.0);
        Self {
            irradiance: [zero; 3],
            rotational: [[zero; 2]; 3],
            translational: [[zero; 2]; 3],
            inverse_distance: zero,
            minimum_distance: L::splat(f32::INFINITY),
            squares: [zero; 3],
        }
    }

    /// Adds the cells of a row from column `first` of the strip on, and their walls to those above and to the left.
    #[inline(always)]
    fn add(&mut self, group: &Group, row: &Light, first: usize, above: &CellLanes<N, L>) -> CellLanes<N, L> {
        let (here, left) = (CellLanes::new::<HERE>(row, first), CellLanes::new::<BEFORE>(row, first));
        let [cosine, turn_x, turn_y, up_x, up_y, left_x, left_y] = group;
        let cosine = load::<N, L>(cosine, first);
        let turn: [L; 2] = [load(turn_x, first), load(turn_y, first)];
        let (up_wall, left_wall) = (here.wall(above), here.wall(&left));
        let up = [load::<N, L>(up_x, first) * up_wall, load::<N, L>(up_y, first) * up_wall];
        let left_of = [load::<N, L>(left_x, first) * left_wall, load::<N, L>(left_y, first) * left_wall];
        for channel in 0..3 {
            let radiance = here.radiance[channel];
            let (rise_up, rise_left) = (radiance - above.radiance[channel], radiance - left.radiance[channel]);
            let step = cosine * rise_left;
            self.squares[channel] = self.squares[channel] + step * step;
            self.irradiance[channel] = self.irradiance[channel] + cosine * radiance;
            for axis in 0..2 {
                self.rotational[channel][axis] = self.rotational[channel][axis] + turn[axis] * radiance;
                let walls = up[axis] * rise_up + left_of[axis] * rise_left;
                self.translational[channel][axis] = self.translational[channel][axis] + walls;
            }
        }
        self.inverse_distance = self.inverse_distance + cosine * here.inverse;
        self.minimum_distance = self.minimum_distance.min(row.lanes::<HERE, N, L>(3, first));
        here
    }
}

impl Grid<'_> {
    /// Adds the cells to the sums of a strip's columns, `N` of them each.
    #[inline(always)]
    fn add<S: Simd, const N: usize, L: Lanes<N>>(&self, samples: &Samples, all: &mut [Sums<N, L>]) {
        let mut groups = self.table.as_chunks::<COLUMNS>().0.as_chunks::<CELL>().0;
        let mut block = [Row::splat(NONE); BLOCK];
        for first in (0..self.columns).step_by(COLUMNS) {
            let columns = Columns::new(first, self.columns);
            let mut rim = Row::splat(NONE);
            if let Above::Rim(_) = self.above {
                rim.read::<S, _>(samples, 0, &columns.replaced(|column| self.above.cell(column).unwrap_or(0)));
            }
            let mut above = [CellLanes::new::<HERE>(&rim, 0), CellLanes::new::<HERE>(&rim, COLUMNS - N)];
            let mut rows = (0..self.rows).map(|row| self.first + row * self.columns);
            while rows.len() > 0 {
                let count = rows.len().min(BLOCK);
                for (row, start) in block[..count].iter_mut().zip(rows.by_ref()) {
                    row.read::<S, _>(samples, start, &columns);
                }
                for ((sums, above), first) in all.iter_mut().zip(&mut above).zip((0..).step_by(N)) {
                    for (row, group) in block[..count].iter().zip(groups) {
                        *above = sums.add(group, row, first, above);
                    }
                }
                groups = groups.get(count..).unwrap_or_default();
            }
        }
    }
}

/// The combined sums.
#[inline(always)]
fn total<const N: usize, L: Lanes<N>>(all: &[Sums<N, L>]) -> Gather {
    // A loop, whose body the compiler inlines; it does not inline closures that it sees several times.
    let (mut irradiance, mut squares) = ([0.0; 3], [0.0; 3]);
    let [mut rotational, mut translational] = [[[0.0; 2]; 3]; 2];
    for channel in 0..3 {
        irradiance[channel] = sum(all.iter().map(|sums| sums.irradiance[channel]));
        squares[channel] = sum(all.iter().map(|sums| sums.squares[channel]));
        for axis in 0..2 {
            rotational[channel][axis] = sum(all.iter().map(|sums| sums.rotational[channel][axis]));
            translational[channel][axis] = sum(all.iter().map(|sums| sums.translational[channel][axis]));
        }
    }
    let inverse_distance = sum(all.iter().map(|sums| sums.inverse_distance));
    let distances = all.iter().flat_map(|sums| sums.minimum_distance.store());
    let gradients = [rotational, translational];
    Gather::from_sums(irradiance, gradients, inverse_distance, distances.fold(f32::INFINITY, f32::min), squares)
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
        if S::WIDE { self.sum::<S, 16, S::F16>() } else { self.sum::<S, 8, S::F8>() }
    }
}

impl<const GRIDS: usize> Accumulate<'_, GRIDS> {
    #[inline(always)]
    fn sum<S: Simd, const N: usize, L: Lanes<N>>(&self) -> Gather {
        let mut all = [Sums::<N, L>::new(); 2];
        let all = &mut all[..COLUMNS / N];
        for grid in &self.grids {
            grid.add::<S, N, L>(&self.samples, all);
        }
        total(all)
    }
}
