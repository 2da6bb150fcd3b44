//! Half a cube around the point (Cohen and Greenberg, "The hemi-cube", 1985), seen through the texels of its faces.
//!
//! The top lies in z = 1 and has n × n texels; each of the four sides has n × n/2, from z = 1 down to the horizon.
//! Rays go through the texels' centres. Cells are ordered so: the top row by row, y and then x ascending; then the
//! sides as one band around the point, the rows from the top down, in each of them the faces +x, +y, -x, -y one after
//! the other with the azimuth ascending.
//!
//! A cell is a spherical polygon with corners d_i in the directions of the texel's corners, so (Lambert)
//!
//! ∫ ω dω = ½ Σ angle(d_i, d_{i+1}) normalize(d_i × d_{i+1}),
//!
//! of which the third component is ∫ cos θ dω, and which turned by a right angle about z is ∫ n × ω dω. A wall from
//! d_0 to d_1 has m = ± normalize(d_0 × d_1) and ∫ cos θ ds = |d_1 - d_0| cos θ at its middle, the seams between top
//! and sides like any other. Walls on the horizon add nothing.

use glam::{DVec3, Vec2, Vec3, dvec3};

use super::accumulate::{Above, CELL, Grid, Samples, accumulate, fill_table, table_len};
use super::mesh::{Patch, hessian};
use super::{Gather, Hessian, Layout, LayoutError, check_lengths};
use crate::simd::Isa;

/// The most texels a side.
pub(super) const MAX_SIZE: u32 = 1 << 12;

/// The layout of a hemicube, with its table in memory of the caller's: a `&mut [f32]`, or a `Vec<f32>` to own it.
#[derive(Clone, Copy, Debug)]
pub struct Hemicube<T> {
    size: u32,
    table: T,
    isa: Isa,
}

impl Hemicube<()> {
    /// The most texels a side.
    pub const MAX_SIZE: u32 = MAX_SIZE;

    /// The number of floats in the table of a hemicube with `size` texels a side.
    pub fn table_len(size: u32) -> usize {
        let size = size as usize;
        table_len(size, size).saturating_add(table_len(size / 2, size.saturating_mul(4)))
    }
}

impl<T: AsRef<[f32]> + AsMut<[f32]>> Hemicube<T> {
    /// Computes the table in `table`, which needs [`Hemicube::table_len`] floats. `size` is even, from 2 to
    /// [`Hemicube::MAX_SIZE`].
    ///
    /// # Errors
    ///
    /// [`LayoutError::Size`] if it is not, [`LayoutError::Table`] if there is memory for less.
    pub fn new(size: u32, mut table: T) -> Result<Self, LayoutError> {
        if size % 2 == 1 || !(2..=MAX_SIZE).contains(&size) {
            return Err(LayoutError::Size { size });
        }
        let (needed, given) = (Hemicube::table_len(size), table.as_ref().len());
        let memory = table.as_mut().get_mut(..needed).ok_or(LayoutError::Table { needed, given })?;
        let n = size as usize;
        let (top, sides) = memory.split_at_mut(table_len(n, n));
        fill_table(top, n, n, |row, column| {
            let corner = |i, j| top_point(n, j, i);
            texel(corner, row, column, row > 0, column > 0)
        });
        // The band's walls upwards from row 0 are the seams, and those to the left of column 0 go to the last column.
        fill_table(sides, n / 2, 4 * n, |row, column| {
            let (face, column) = (column / n, column % n);
            let corner = |i, j| side_point(n, face, i, j);
            texel(corner, row, column, true, true)
        });
        Ok(Self { size, table, isa: Isa::detect() })
    }
}

/// The unit direction through a point of the top's grid.
fn top_point(n: usize, x: f64, y: f64) -> DVec3 {
    unit(dvec3(2.0 * x / n as f64 - 1.0, 2.0 * y / n as f64 - 1.0, 1.0))
}

/// The unit direction through a point of a side's grid, `row` from the top down.
fn side_point(n: usize, face: usize, row: f64, column: f64) -> DVec3 {
    let (along, z) = (2.0 * column / n as f64 - 1.0, 1.0 - 2.0 * row / n as f64);
    unit(match face {
        0 => dvec3(1.0, along, z),
        1 => dvec3(-along, 1.0, z),
        2 => dvec3(-1.0, -along, z),
        _ => dvec3(along, -1.0, z),
    })
}

/// Of length one; by a routine that is the same on every target.
fn unit(v: DVec3) -> DVec3 {
    v / libm::sqrt(v.dot(v))
}

/// A texel's numbers in the table; `corner(row, column)` is a unit direction on the face's grid.
fn texel(corner: impl Fn(f64, f64) -> DVec3, row: usize, column: usize, up: bool, left: bool) -> [f64; CELL] {
    let (i, j) = (row as f64, column as f64);
    let corners = [corner(i, j), corner(i, j + 1.0), corner(i + 1.0, j + 1.0), corner(i + 1.0, j)];
    let centre = corner(i + 0.5, j + 0.5);
    let mut vector = DVec3::ZERO;
    for (k, &a) in corners.iter().enumerate() {
        let cross = a.cross(corners[(k + 1) % 4]);
        let sine = libm::sqrt(cross.dot(cross));
        vector += cross * (0.5 * libm::asin(sine) / sine);
    }
    if vector.dot(centre) < 0.0 {
        vector = -vector;
    }
    let wall = |there: bool, a: DVec3, b: DVec3| {
        if !there {
            return DVec3::ZERO;
        }
        let across = unit(a.cross(b));
        let integral = unit(a + b).z * libm::sqrt((b - a).dot(b - a));
        // Into this cell.
        across * if across.dot(centre) < 0.0 { -integral } else { integral }
    };
    let (up, left) = (wall(up, corners[0], corners[1]), wall(left, corners[0], corners[3]));
    [vector.z, -vector.y, vector.x, up.x, up.y, left.x, left.y]
}

impl<T> Hemicube<T> {
    /// The layout, accumulating with the instructions of `isa` instead of those of [`Isa::detect`].
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// The number of texels a side, n.
    pub fn size(&self) -> u32 {
        self.size
    }
}

impl<T: AsRef<[f32]>> Layout for Hemicube<T> {
    fn cells(&self) -> usize {
        3 * self.size as usize * self.size as usize
    }

    fn directions(&self, _: &mut dyn FnMut(usize) -> Vec2, out: &mut [Vec3]) -> Result<(), LayoutError> {
        check_lengths(self.cells(), [out.len()])?;
        let n = self.size as usize;
        let (top, sides) = out.split_at_mut(n * n);
        for (cell, direction) in top.iter_mut().enumerate() {
            *direction = top_point(n, (cell % n) as f64 + 0.5, (cell / n) as f64 + 0.5).as_vec3();
        }
        for (cell, direction) in sides.iter_mut().enumerate() {
            let (row, column) = (cell / (4 * n), cell % (4 * n));
            let (face, column) = (column / n, column % n);
            *direction = side_point(n, face, row as f64 + 0.5, column as f64 + 0.5).as_vec3();
        }
        Ok(())
    }

    fn accumulate(&self, radiance: &[Vec3], distance: &[f32]) -> Result<Gather, LayoutError> {
        check_lengths(self.cells(), [radiance.len(), distance.len()])?;
        let n = self.size as usize;
        let (top, sides) = self.table.as_ref().split_at(table_len(n, n));
        let top = Grid { first: 0, rows: n, columns: n, above: Above::Zenith, table: top };
        let sides = Grid { first: n * n, rows: n / 2, columns: 4 * n, above: Above::Rim(n), table: sides };
        Ok(accumulate(self.isa, [top, sides], Samples { radiance, distance }))
    }

    fn hessian(&self, directions: &[Vec3], radiance: &[Vec3], distance: &[f32]) -> Result<Hessian, LayoutError> {
        check_lengths(self.cells(), [directions.len(), radiance.len(), distance.len()])?;
        let n = self.size as usize;
        let top = Patch { first: 0, rows: n, columns: n, band: false, above: Above::Zenith };
        let sides = Patch { first: n * n, rows: n / 2, columns: 4 * n, band: true, above: Above::Rim(n) };
        Ok(hessian(self.isa, [top, sides], directions, Samples { radiance, distance }))
    }
}
