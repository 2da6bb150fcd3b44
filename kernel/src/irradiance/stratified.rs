//! Rings and sectors of equal cosine-weighted solid angle ([`Strata`]).
//!
//! With θ_{j-} and θ_{j+} a ring's borders, φ_k a sector's centre and φ_{k-} its first border, û = (cos φ, sin φ) and
//! φ̂ = (-sin φ, cos φ), the integrals over cell (j, k) and along its walls are
//!
//! ```text
//! ∫ cos θ dω  = π/(MN)
//! ∫ n × ω dω  = φ̂(φ_k) 2 sin(π/N) ½ [θ - sin θ cos θ], from θ_{j-} to θ_{j+}
//! m ∫ cos θ ds = û(φ_k) Δφ sin θ_{j-} cos² θ_{j-}            the wall to ring j - 1
//! m ∫ cos θ ds = φ̂(φ_{k-}) (sin θ_{j+} - sin θ_{j-})         the wall to sector k - 1; of sector 0 to the last
//! ```
//!
//! The walls are Ward and Heckbert's ("Irradiance gradients", 1992). Their rotational gradient has tan θ of the ray in
//! place of the integral: its variance grows with the logarithm of the number of rays, and tan θ of the cell's centre
//! is biased.

use core::f64::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::accumulate::{Above, Grid, Samples, accumulate, fill_table, table_len};
use super::mesh::{Patch, hessian};
use super::{Gather, Hessian, Layout, LayoutError, check_lengths};
use crate::sampling::Strata;
use crate::simd::Isa;

/// The layout of [`Strata`], with its table in memory of the caller's: a `&mut [f32]`, or a `Vec<f32>` to own it.
#[derive(Clone, Copy, Debug)]
pub struct Stratified<T> {
    strata: Strata,
    table: T,
    isa: Isa,
}

impl Stratified<()> {
    /// The number of floats in the table of `strata`.
    pub fn table_len(strata: &Strata) -> usize {
        table_len(strata.rings() as usize, strata.sectors() as usize)
    }
}

impl<T: AsRef<[f32]> + AsMut<[f32]>> Stratified<T> {
    /// Computes the table in `table`, which needs [`Stratified::table_len`] floats.
    ///
    /// # Errors
    ///
    /// [`LayoutError::Table`] if there is memory for less.
    pub fn new(strata: Strata, mut table: T) -> Result<Self, LayoutError> {
        let (needed, given) = (Stratified::table_len(&strata), table.as_ref().len());
        let (rings, sectors) = (strata.rings() as usize, strata.sectors() as usize);
        let memory = table.as_mut().get_mut(..needed).ok_or(LayoutError::Table { needed, given })?;
        let (cells, angle) = (rings as f64 * sectors as f64, TAU / sectors as f64);
        fill_table(memory, rings, sectors, |ring, sector| {
            let border = |ring: usize| {
                let sine_squared = ring as f64 / rings as f64;
                (libm::sqrt(sine_squared), libm::sqrt(1.0 - sine_squared))
            };
            let ((sin, cos), (sin_out, cos_out)) = (border(ring), border(ring + 1));
            // ∫ sin² θ dθ
            let zone = 0.5 * (libm::asin(sin_out) - sin_out * cos_out - (libm::asin(sin) - sin * cos));
            let turn = 2.0 * libm::sin(0.5 * angle) * zone;
            let (up, left) = (angle * sin * cos * cos, sin_out - sin);
            let (centre, first_border) = ((sector as f64 + 0.5) * angle, sector as f64 * angle);
            let ((y, x), (border_y, border_x)) = (libm::sincos(centre), libm::sincos(first_border));
            [PI / cells, -y * turn, x * turn, x * up, y * up, -border_y * left, border_x * left]
        });
        Ok(Self { strata, table, isa: Isa::detect() })
    }
}

impl<T> Stratified<T> {
    /// The layout, accumulating with the instructions of `isa` instead of those of [`Isa::detect`].
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// The rings and sectors.
    pub fn strata(&self) -> Strata {
        self.strata
    }
}

impl<T: AsRef<[f32]>> Layout for Stratified<T> {
    fn cells(&self) -> usize {
        self.strata.cells()
    }

    fn directions(&self, jitter: &mut dyn FnMut(usize) -> Vec2, out: &mut [Vec3]) -> Result<(), LayoutError> {
        check_lengths(self.cells(), [out.len()])?;
        for (cell, direction) in out.iter_mut().enumerate() {
            let (ring, sector) = (cell as u32 / self.strata.sectors(), cell as u32 % self.strata.sectors());
            *direction = self.strata.direction(ring, sector, jitter(cell));
        }
        Ok(())
    }

    fn accumulate(&self, radiance: &[Vec3], distance: &[f32]) -> Result<Gather, LayoutError> {
        check_lengths(self.cells(), [radiance.len(), distance.len()])?;
        let grid = Grid {
            first: 0,
            rows: self.strata.rings() as usize,
            columns: self.strata.sectors() as usize,
            above: Above::Zenith,
            table: self.table.as_ref(),
        };
        Ok(accumulate(self.isa, [grid], Samples { radiance, distance }))
    }

    fn hessian(&self, directions: &[Vec3], radiance: &[Vec3], distance: &[f32]) -> Result<Hessian, LayoutError> {
        check_lengths(self.cells(), [directions.len(), radiance.len(), distance.len()])?;
        let (rows, columns) = (self.strata.rings() as usize, self.strata.sectors() as usize);
        let patch = Patch { first: 0, rows, columns, band: true, above: Above::Zenith };
        Ok(hessian(self.isa, [patch], directions, Samples { radiance, distance }))
    }
}
