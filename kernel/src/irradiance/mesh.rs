//! The Hessian of a mesh of small lights, in lanes.
//!
//! Neighbouring hit points make triangles, and each triangle is a polygon light with the radiance of its farthest
//! vertex: what is nearer hides the light behind it, so that the edges of occluders are where the lights' edges are
//! (Schwarzhaupt, Wann Jensen and Jarosz 2012). The contribution of a triangle is a sum over its [edges](super::edge),
//! which change their sign with the direction; so each edge of the mesh is computed once, for the difference of the
//! radiances on its two sides.
//!
//! # Deviations
//! The mesh is closed: the first ring's triangles meet in a point at the zenith, and the last ring's points are dropped
//! onto the tangent plane. So light that is the same everywhere has the Hessian zero, without the mean being
//! subtracted. The hundredth of the mean radiance that is added to each triangle (1 where all is black) ends at the
//! last ring, as published: it would have no Hessian if it did not.

use core::f32::consts::PI;

use glam::Vec3;

use super::accumulate::{Above, MIN_DISTANCE, Samples, bound, bound_lanes};
use super::edge::{Ends, Sums};
use super::strip::{BEFORE, BLOCK, COLUMNS, Cells, Columns, HERE, NEXT, Row, parts};
use super::{Hessian, LUMINANCE};
use crate::simd::{Isa, Lanes, Simd, Work, dispatch};

/// The part of the mean radiance that is added to every light.
const BASE: f32 = 0.01;

/// Points in rows and columns. Rows follow each other away from the zenith and columns with the azimuth, or the other
/// way round both ways.
#[derive(Clone, Copy)]
pub(super) struct Patch {
    pub(super) first: usize,
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Whether the patch goes around the zenith down to the horizon, with the last column beside the first. Else it
    /// is a rectangle of its own, with columns against the azimuth.
    pub(super) band: bool,
    /// The start of a band.
    pub(super) above: Above,
}

/// The Hessian of the patches of a layout.
pub(super) fn hessian<const N: usize>(isa: Isa, patches: [Patch; N], directions: &[Vec3], samples: Samples) -> Hessian {
    dispatch(isa, Triangulate { patches, points: HitPoints { directions, samples } })
}

struct Triangulate<'a, const N: usize> {
    patches: [Patch; N],
    points: HitPoints<'a>,
}

impl<const N: usize> Work for Triangulate<'_, N> {
    type Output = Hessian;
    #[inline(always)]
    fn run<S: Simd>(self) -> Hessian {
        if S::WIDE { self.sum::<S, 16, S::F16>() } else { self.sum::<S, 8, S::F8>() }
    }
}

impl<const PATCHES: usize> Triangulate<'_, PATCHES> {
    #[inline(always)]
    fn sum<S: Simd, const N: usize, L: Lanes<N>>(&self) -> Hessian {
        let (mut light, mut base) = ([Sums::<N, L>::zero(); 2], [Sums::zero(); 2]);
        let (light, base) = (&mut light[..COLUMNS / N], &mut base[..COLUMNS / N]);
        for patch in &self.patches {
            patch.add::<S, N, L>(&self.points, light, base);
        }
        let ((irradiance, light), (_, base)) = (Sums::total(light), Sums::total(base));
        let (irradiance, ambient) = if irradiance > 0.0 { (irradiance, BASE / PI * irradiance) } else { (PI, 1.0) };
        Hessian {
            xx: light[0] + ambient * base[0],
            xy: light[1] + ambient * base[1],
            yy: light[2] + ambient * base[2],
            irradiance,
        }
    }
}

struct HitPoints<'a> {
    directions: &'a [Vec3],
    samples: Samples<'a>,
}

/// A row of points: x, y and z of their directions, reciprocal distances and luminances.
type Points = Row<5>;

impl<S: Simd> Cells<S, 5> for HitPoints<'_> {
    #[inline(always)]
    fn one(&self, cell: usize) -> [f32; 5] {
        let Vec3 { x, y, z } = self.directions[cell];
        let Samples { radiance, distance } = self.samples;
        [x, y, z, 1.0 / bound(distance[cell]), radiance[cell].dot(LUMINANCE)]
    }

    #[inline(always)]
    fn many(&self, cell: usize) -> Option<[S::F16; 5]> {
        let [x, y, z] = parts::<S>(self.directions[cell..].first_chunk()?);
        let [red, green, blue] = parts::<S>(self.samples.radiance[cell..].first_chunk()?);
        let distance = S::F16::load(self.samples.distance[cell..].first_chunk()?);
        let inverse = S::F16::splat(1.0) / bound_lanes(distance);
        let (red, green) = (red * S::F16::splat(LUMINANCE.x), green * S::F16::splat(LUMINANCE.y));
        Some([x, y, z, inverse, red + green + blue * S::F16::splat(LUMINANCE.z)])
    }
}

impl HitPoints<'_> {
    /// All at the zenith, in the mean of the points of a patch's first row.
    fn zenith(&self, patch: &Patch) -> Points {
        let row = patch.first..patch.first + patch.columns;
        let inverses = self.samples.distance[row.clone()].iter().map(|&distance| 1.0 / bound(distance));
        let luminances = self.samples.radiance[row].iter().map(|radiance| radiance.dot(LUMINANCE));
        let count = patch.columns as f32;
        Row::splat([0.0, 0.0, 1.0, inverses.sum::<f32>() / count, luminances.sum::<f32>() / count])
    }
}

/// The points moved along the normal onto the tangent plane.
#[inline(always)]
fn on_horizon(mut row: Points) -> Points {
    let [x, y, z, inverse, _] = &mut row.0;
    for k in 0..x.len() {
        let sine = libm::sqrtf(x[k] * x[k] + y[k] * y[k]).max(f32::MIN_POSITIVE);
        (x[k], y[k], z[k]) = (x[k] / sine, y[k] / sine, 0.0);
        inverse[k] = (inverse[k] / sine).min(1.0 / MIN_DISTANCE);
    }
    row
}

#[inline(always)]
fn ends<const FROM: usize, const N: usize, L: Lanes<N>>(row: &Points, first: usize) -> Ends<N, L> {
    let direction =
        [row.lanes::<FROM, N, L>(0, first), row.lanes::<FROM, N, L>(1, first), row.lanes::<FROM, N, L>(2, first)];
    Ends::new(direction, row.lanes::<FROM, N, L>(3, first))
}

#[inline(always)]
fn depth<const FROM: usize, const N: usize, L: Lanes<N>>(row: &Points, first: usize) -> Depth<N, L> {
    Depth { inverse: row.lanes::<FROM, N, L>(3, first), luminance: row.lanes::<FROM, N, L>(4, first) }
}

/// The distances and luminances of points.
#[derive(Clone, Copy)]
struct Depth<const N: usize, L> {
    inverse: L,
    luminance: L,
}

impl<const N: usize, L: Lanes<N>> Depth<N, L> {
    /// The farther of each pair, the first of equal ones.
    #[inline(always)]
    fn or_farther(self, other: Self) -> Self {
        let farther = other.inverse.lt(self.inverse);
        Self {
            inverse: L::select(farther, other.inverse, self.inverse),
            luminance: L::select(farther, other.luminance, self.luminance),
        }
    }
}

/// A row of a strip: what edges need that start from it or end there.
#[derive(Clone, Copy)]
struct Border<const N: usize, L> {
    here: Ends<N, L>,
    next: Ends<N, L>,
    depths: [Depth<N, L>; 3],
}

impl<const N: usize, L: Lanes<N>> Border<N, L> {
    #[inline(always)]
    fn new(row: &Points, first: usize) -> Self {
        Self {
            here: ends::<HERE, N, L>(row, first),
            next: ends::<NEXT, N, L>(row, first),
            depths: [
                depth::<BEFORE, N, L>(row, first),
                depth::<HERE, N, L>(row, first),
                depth::<NEXT, N, L>(row, first),
            ],
        }
    }
}

/// As many columns of a strip as there are lanes, and what has been added of them down to a row.
#[derive(Clone, Copy)]
struct Lines<const N: usize, L> {
    /// 1 or -1 in lanes that have a column of quads to their right, else 0; the same for those to their left.
    right: L,
    left: L,
    /// The row, and the radiance above its edges.
    row: Border<N, L>,
    above: L,
}

impl<const N: usize, L: Lanes<N>> Lines<N, L> {
    /// Adds the quads between the row and the next one: triangles a, d, c and a, c, b, where a and b are above d and c.
    /// Edges of the next row wait for what is below them.
    #[inline(always)]
    fn add_quads(&mut self, lower: Border<N, L>, sums: &mut Sums<N, L>) {
        let Border { here: a, next: b, depths: [before, a_depth, b_depth] } = self.row;
        let Border { here: d, next: c, depths: [_, d_depth, c_depth] } = lower;
        let adc = self.right * a_depth.or_farther(d_depth).or_farther(c_depth).luminance;
        let acb = self.right * a_depth.or_farther(c_depth).or_farther(b_depth).luminance;
        let left = self.left * before.or_farther(d_depth).or_farther(a_depth).luminance;
        *sums = sums.add(&a, &b, self.above - acb).add(&a, &d, adc - left).add(&a, &c, acb - adc);
        (self.row, self.above) = (lower, adc);
    }
}

impl Patch {
    /// Adds the lights to the sums of a strip's columns, `N` of them each.
    #[inline(always)]
    fn add<S: Simd, const N: usize, L: Lanes<N>>(
        &self,
        points: &HitPoints,
        light: &mut [Sums<N, L>],
        base: &mut [Sums<N, L>],
    ) {
        let zenith = points.zenith(self);
        let mut block = [zenith; BLOCK];
        for first in (0..self.columns).step_by(COLUMNS) {
            let columns = Columns::new(first, self.columns);
            let mut rows = (0..self.rows).map(|row| self.first + row * self.columns);
            let mut row = zenith;
            match self.above {
                Above::Zenith if self.band => (),
                Above::Zenith => row.read::<S, _>(points, rows.next().unwrap_or(0), &columns),
                Above::Rim(_) => {
                    row.read::<S, _>(points, 0, &columns.replaced(|column| self.above.cell(column).unwrap_or(0)));
                }
            }
            let mut lines = [self.lines(first, &row, 0), self.lines(first, &row, COLUMNS - N)];
            while rows.len() > 0 {
                let count = rows.len().min(BLOCK);
                for (row, start) in block[..count].iter_mut().zip(rows.by_ref()) {
                    row.read::<S, _>(points, start, &columns);
                }
                for ((lines, light), lane) in lines.iter_mut().zip(light.iter_mut()).zip((0..).step_by(N)) {
                    for row in &block[..count] {
                        lines.add_quads(Border::new(row, lane), light);
                    }
                }
                row = block[count - 1];
            }
            let horizon = on_horizon(row);
            for (part, lines) in lines.iter_mut().enumerate().take(light.len()) {
                let (light, base) = (&mut light[part], &mut base[part]);
                if self.band {
                    *base = base.add(&lines.row.here, &lines.row.next, lines.right);
                    lines.add_quads(Border::new(&horizon, part * N), light);
                }
                // The edges of the last row have nothing below.
                *light = light.add(&lines.row.here, &lines.row.next, lines.above);
            }
        }
    }

    /// The lines of a strip that begin at a lane of its row, with nothing above.
    #[inline(always)]
    fn lines<const N: usize, L: Lanes<N>>(&self, first: usize, row: &Points, lane: usize) -> Lines<N, L> {
        let (mut right, mut left) = ([0.0; N], [0.0; N]);
        for ((right, left), column) in right.iter_mut().zip(&mut left).zip(first + lane..self.columns) {
            (*right, *left) = match self.band {
                true => (1.0, 1.0),
                false => (-f32::from(column + 1 < self.columns), -f32::from(column > 0)),
            };
        }
        Lines { right: L::load(&right), left: L::load(&left), row: Border::new(row, lane), above: L::splat(0.0) }
    }
}
