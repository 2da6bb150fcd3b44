//! The hemisphere in M rings of elevation by N sectors of azimuth, all of equal cosine-weighted solid angle.
//!
//! Cell (j, k), j in 0..M and k in 0..N, lies between sin² θ = j/M and (j + 1)/M and between φ = 2πk/N and
//! 2π(k + 1)/N (Ward and Heckbert, 1992). A direction in it is that of the cosine hemisphere at
//! ((j + u_x)/M, (k + u_y)/N). Cells are ordered ring by ring: (j, k) has index jN + k.

use core::f32::consts::{PI, TAU};
use core::fmt;

use glam::{Vec2, Vec3};

use super::warp::{CosineHemisphere, Warp};
use super::{into_unit, sqrt};

/// A grid of M × N cells on the cosine-weighted hemisphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Strata {
    rings: u32,
    sectors: u32,
}

impl Strata {
    /// The most rings, and the most sectors: more could not be told apart in single precision.
    pub const MAX: u32 = 1 << 15;

    /// A grid of `rings` (M) by `sectors` (N), each from 1 to [`MAX`](Self::MAX).
    ///
    /// # Errors
    ///
    /// [`StrataError::Size`] if either is out of range.
    pub fn new(rings: u32, sectors: u32) -> Result<Self, StrataError> {
        let valid = 1..=Self::MAX;
        if valid.contains(&rings) && valid.contains(&sectors) {
            Ok(Self { rings, sectors })
        } else {
            Err(StrataError::Size { rings, sectors })
        }
    }

    /// The grid of about `count` cells that are as wide as they are high: M = √(count/π), N = πM, each rounded.
    pub fn near(count: u32) -> Self {
        let limit = |x: f32| (libm::roundf(x) as u32).clamp(1, Self::MAX);
        let rings = limit(sqrt(count as f32 / PI));
        Self { rings, sectors: limit(PI * rings as f32) }
    }

    /// M.
    pub fn rings(&self) -> u32 {
        self.rings
    }

    /// N.
    pub fn sectors(&self) -> u32 {
        self.sectors
    }

    /// MN, the number of cells.
    pub fn cells(&self) -> usize {
        self.rings as usize * self.sectors as usize
    }

    /// sin θ at the lower border of ring `ring`, √(j/M): 0 for ring 0, and 1 for ring M and beyond.
    pub fn border_sin(&self, ring: u32) -> f32 {
        sqrt(ring.min(self.rings) as f32 / self.rings as f32)
    }

    /// Δφ = 2π/N, in radians.
    pub fn sector_angle(&self) -> f32 {
        TAU / self.sectors as f32
    }

    /// The direction at `u` in [0, 1)² of cell (`ring`, `sector`), above the horizon whatever the rounding.
    #[inline(always)]
    pub fn direction(&self, ring: u32, sector: u32, u: Vec2) -> Vec3 {
        let elevation = into_unit((ring as f32 + u.x) / self.rings as f32);
        let azimuth = into_unit((sector as f32 + u.y) / self.sectors as f32);
        CosineHemisphere.map(Vec2::new(elevation, azimuth))
    }

    /// The density of the directions of all cells together, one in each or a cell at random: cos θ / π, per steradian.
    /// A single cell's is that of [`cell`](Self::cell).
    #[inline]
    pub fn pdf(&self, direction: Vec3) -> f32 {
        CosineHemisphere.pdf(direction)
    }

    /// The ring and the sector of the cell in which a direction above the horizon is, and the `u` in [0, 1)² at which:
    /// the inverse of [`direction`](Self::direction).
    pub fn inverse(&self, direction: Vec3) -> (u32, u32, Vec2) {
        let u = CosineHemisphere.inverse(direction);
        let (ring, x) = split(u.x * self.rings as f32, self.rings);
        let (sector, y) = split(u.y * self.sectors as f32, self.sectors);
        (ring, sector, Vec2::new(x, y))
    }

    /// Cell (`ring`, `sector`) as a warp of its own; `None` if there is no such cell.
    pub fn cell(&self, ring: u32, sector: u32) -> Option<Stratum> {
        (ring < self.rings && sector < self.sectors).then_some(Stratum { strata: *self, ring, sector })
    }

    /// Writes a direction of every cell to `out`, in the order of their indices; `jitter(ring, sector)` says where in
    /// the cell it is: (½, ½) is its middle.
    ///
    /// # Errors
    ///
    /// [`StrataError::Length`] if `out` has not [`cells`](Self::cells) elements; nothing is written then.
    pub fn directions(&self, mut jitter: impl FnMut(u32, u32) -> Vec2, out: &mut [Vec3]) -> Result<(), StrataError> {
        if out.len() != self.cells() {
            return Err(StrataError::Length { cells: self.cells(), slice: out.len() });
        }
        for (ring, row) in (0..).zip(out.chunks_exact_mut(self.sectors as usize)) {
            for (sector, direction) in (0..).zip(row) {
                *direction = self.direction(ring, sector, jitter(ring, sector));
            }
        }
        Ok(())
    }
}

/// The whole part and the fraction of a place in [0, `count`], kept below its end.
fn split(place: f32, count: u32) -> (u32, f32) {
    let whole = (place as u32).min(count - 1);
    (whole, into_unit(place - whole as f32))
}

/// One cell of the hemisphere, with density MN cos θ / π inside of it (measure: solid angle).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stratum {
    strata: Strata,
    ring: u32,
    sector: u32,
}

impl Stratum {
    /// Where a direction is in terms of the cell, which is the unit square.
    fn place(&self, direction: Vec3) -> Vec2 {
        let Strata { rings, sectors } = self.strata;
        let u = CosineHemisphere.inverse(direction);
        // By the shortest way around: the first sector's border may come back from a hair before a whole turn.
        let mut turn = u.y - (self.sector as f32 + 0.5) / sectors as f32;
        turn -= libm::roundf(turn);
        Vec2::new(u.x * rings as f32 - self.ring as f32, turn * sectors as f32 + 0.5)
    }
}

impl Warp for Stratum {
    type Point = Vec3;

    #[inline(always)]
    fn map(&self, u: Vec2) -> Vec3 {
        self.strata.direction(self.ring, self.sector, u)
    }

    /// The border has a tolerance for rounding.
    fn pdf(&self, direction: Vec3) -> f32 {
        let Strata { rings, sectors } = self.strata;
        let tolerance = 4.0 * f32::EPSILON * Vec2::new(rings as f32, sectors as f32);
        let beyond = (self.place(direction) - 0.5).abs() - 0.5;
        if beyond.cmple(tolerance).all() { self.strata.cells() as f32 * CosineHemisphere.pdf(direction) } else { 0.0 }
    }

    fn inverse(&self, direction: Vec3) -> Vec2 {
        let Vec2 { x, y } = self.place(direction);
        Vec2::new(into_unit(x), into_unit(y))
    }
}

/// Why a grid of strata, or a slice for its directions, was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrataError {
    /// A number of rings or sectors is out of range.
    Size {
        /// The rings asked for.
        rings: u32,
        /// The sectors asked for.
        sectors: u32,
    },
    /// The slice's length is not the number of cells.
    Length {
        /// The number of cells.
        cells: usize,
        /// The slice's length.
        slice: usize,
    },
}

impl fmt::Display for StrataError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size { rings, sectors } => {
                write!(f, "strata of {rings} rings by {sectors} sectors: each must be from 1 to {}", Strata::MAX)
            }
            Self::Length { cells, slice } => write!(f, "{cells} strata need {cells} directions, the slice has {slice}"),
        }
    }
}

impl core::error::Error for StrataError {}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::checksums::Checksum;
    use crate::sampling::{ONE_MINUS_EPSILON, Stream};

    fn jittered(strata: &Strata) -> Vec<Vec3> {
        let mut directions = vec![Vec3::ZERO; strata.cells()];
        strata.directions(|j, k| Stream::new(11, j, k).uniform2(0), &mut directions).unwrap();
        directions
    }

    #[test]
    fn every_cell_has_its_direction() {
        let strata = Strata::new(10, 31).unwrap();
        for (i, d) in jittered(&strata).into_iter().enumerate() {
            let d = d.as_dvec3();
            let (j, k) = ((i / 31) as f64, (i % 31) as f64);
            let sin_squared = d.x * d.x + d.y * d.y;
            let turn = (d.y.atan2(d.x) / core::f64::consts::TAU).rem_euclid(1.0);
            let u = Stream::new(11, j as u32, k as u32).uniform2(0).as_dvec2();
            assert!((sin_squared * 10.0 - (j + u.x)).abs() < 4e-6, "cell {i}: {d}");
            assert!((turn * 31.0 - (k + u.y)).abs() < 8e-6, "cell {i}: {d}");
            assert!((d.length() - 1.0).abs() < 2e-7);
            let (ring, sector, place) = strata.inverse(d.as_vec3());
            // A direction beside a border may come back from the next cell.
            let back = DVec2::new(f64::from(ring) + f64::from(place.x), f64::from(sector) + f64::from(place.y));
            assert!((back - DVec2::new(j, k) - u).abs().max_element() < 1e-5, "cell {i}: back at {back}");
            assert!((0.0..1.0).contains(&place.x) && (0.0..1.0).contains(&place.y));
        }
    }

    #[test]
    fn centres_integrate_the_cosine() {
        // 1/MN Σ f is the cosine-weighted mean: of cos θ it is 2/3, of sin² θ it is 1/2, of x it is 0.
        let strata = Strata::new(64, 200).unwrap();
        let mut directions = vec![Vec3::ZERO; strata.cells()];
        strata.directions(|_, _| Vec2::splat(0.5), &mut directions).unwrap();
        let mean =
            |f: fn(Vec3) -> f32| directions.iter().map(|&d| f64::from(f(d))).sum::<f64>() / directions.len() as f64;
        assert!((mean(|d| d.z) - 2.0 / 3.0).abs() < 2e-4);
        assert!((mean(|d| d.x * d.x + d.y * d.y) - 0.5).abs() < 1e-6);
        assert!(mean(|d| d.x).abs() < 1e-6);
    }

    #[test]
    fn corners_stay_above_the_horizon() {
        let corner = Vec2::splat(ONE_MINUS_EPSILON);
        for (rings, sectors) in [(1, 1), (10, 31), (Strata::MAX, Strata::MAX)] {
            let d = Strata::new(rings, sectors).unwrap().direction(rings - 1, sectors - 1, corner);
            assert!(d.z > 0.0 && (d.length() - 1.0).abs() < 2e-7, "{rings} x {sectors}: {d}");
        }
    }

    #[test]
    fn borders_and_shapes() {
        let strata = Strata::new(4, 12).unwrap();
        assert_eq!([0, 1, 4, 5].map(|j| strata.border_sin(j)), [0.0, 0.5, 1.0, 1.0]);
        assert_eq!(strata.sector_angle(), TAU / 12.0);
        assert_eq!(Strata::near(310), Strata::new(10, 31).unwrap());
        assert_eq!(Strata::near(0), Strata::new(1, 3).unwrap());
        assert_eq!(Strata::near(u32::MAX).rings(), Strata::MAX);
    }

    #[test]
    fn cells_share_the_hemisphere() {
        let strata = Strata::new(3, 5).unwrap();
        let cells: Vec<_> = (0..15).map(|i| strata.cell(i / 5, i % 5).unwrap()).collect();
        for i in 0..5000 {
            let direction = CosineHemisphere.map(Stream::new(4, i, 0).uniform2(0));
            let (ring, sector, _) = strata.inverse(direction);
            let density = 15.0 * strata.pdf(direction);
            let inside: Vec<_> = (0..15).filter(|&j| cells[j].pdf(direction) > 0.0).collect();
            // On a border it is in the tolerance of both cells.
            assert!(inside.contains(&((5 * ring + sector) as usize)) && inside.len() <= 4);
            assert!(inside.iter().all(|&j| cells[j].pdf(direction) == density));
            let shares: f64 = inside.iter().map(|&j| f64::from(cells[j].pdf(direction))).sum::<f64>() / 15.0;
            assert!(inside.len() > 1 || (shares - f64::from(strata.pdf(direction))).abs() < 1e-6);
        }
        assert_eq!([strata.cell(3, 0), strata.cell(0, 5)], [None; 2]);
    }

    #[test]
    fn bad_sizes_are_refused() {
        for (rings, sectors) in [(0, 5), (5, 0), (Strata::MAX + 1, 5), (5, u32::MAX)] {
            assert_eq!(Strata::new(rings, sectors), Err(StrataError::Size { rings, sectors }));
        }
        let mut slice = [Vec3::ZERO; 7];
        let error = Strata::new(2, 4).unwrap().directions(|_, _| Vec2::ONE, &mut slice).unwrap_err();
        assert_eq!(error, StrataError::Length { cells: 8, slice: 7 });
        assert_eq!(error.to_string(), "8 strata need 8 directions, the slice has 7");
        assert_eq!(slice, [Vec3::ZERO; 7]);
    }

    #[test]
    fn golden() {
        let mut sum = Checksum::new();
        sum.add(jittered(&Strata::new(56, 179).unwrap()).iter().flat_map(|d| d.to_array()));
        assert_eq!(sum.value(), 0xE73A_38EA_2209_E733, "{:#018X}", sum.value());
    }
}
