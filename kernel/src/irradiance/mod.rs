//! Irradiance of a point from the radiance and the distances that rays over its hemisphere found, with its gradients
//! and its Hessian.
//!
//! A record is made at x_i with the unit normal n_i. A [`Layout`] cuts the hemisphere above it into cells and gives a
//! direction for each: [`Stratified`] in rings and sectors, [`Hemicube`] in the texels of half a cube. The caller
//! traces a ray along each and returns its radiance L and the distance r of its hit, +∞ for a miss. Then, per colour
//! channel,
//!
//! ```text
//! E    = Σ cells   L ∫ cos θ dω                                       irradiance
//! ∇_r  = Σ cells   L ∫ n × ω dω                                       rotational gradient
//! ∇_t  = Σ walls   (L_B - L_A) m (∫ cos θ ds) / r_AB                  translational gradient
//! 1/R  = 1/π Σ cells (1/r) ∫ cos θ dω                                 harmonic mean distance
//! ```
//!
//! (Ward and Heckbert, "Irradiance gradients", 1992; Castaño, "Irradiance caching, part 1", 2011, for the
//! hemicube.) A wall is
//! the arc between neighbouring cells A and B, and m the part in the tangent plane of the sphere's unit tangent across
//! it, from A to B. All of it depends on the layout alone save L and r, so a table has it, computed once.
//!
//! # Signs and frames
//! The one convention of signs, for world vectors:
//!
//! E(x, n) = E_i + (n_i × n)·∇_r + (x - x_i)·∇_t
//!
//! Accumulated gradients are local: z is n_i, and x and y are where the layout's azimuth says. Take them to the world
//! with [`Gather::to_world`] and the frame that took the directions there.
//!
//! # Deviations
//! - Where the depth is continuous, r_max/r_min < 1.5, 1/r_AB is the mean of the two reciprocals, elsewhere that of the
//!   nearer. The nearer alone, as published, makes a wall that meets another steeper than it is: ∇_t of a shining
//!   ceiling between black walls is off by 7% at 20 x 63 cells, else by 4%.
//! - The hemicube's walls are arcs of great circles, and its cells' integrals are exact for their spherical polygons.
//!   The published form, of cosines and azimuths of texel centres, is biased and gives a furnace a gradient.
//!
//! Distances less than [`MIN_DISTANCE`], zero and NaN count as it. Every sum has a fixed order, so that results are
//! equal bit for bit on every instruction set. Nothing here allocates.
//!
//! ```
//! use glam::{Vec2, Vec3};
//! use halfdome_kernel::irradiance::{Layout, Stratified};
//! use halfdome_kernel::sampling::{Frame, Strata};
//!
//! let strata = Strata::new(10, 32).unwrap();
//! let layout = Stratified::new(strata, vec![0.0; Stratified::table_len(&strata)]).unwrap();
//! let mut directions = vec![Vec3::ZERO; layout.cells()];
//! layout.directions(&mut |_cell| Vec2::splat(0.5), &mut directions).unwrap();
//!
//! // A floor beside an endless shining wall at x = -1, under a dark sky.
//! let radiance: Vec<Vec3> = directions.iter().map(|d| if d.x < 0.0 { Vec3::ONE } else { Vec3::ZERO }).collect();
//! let distance: Vec<f32> = directions.iter().map(|d| if d.x < 0.0 { -1.0 / d.x } else { f32::INFINITY }).collect();
//! let gather = layout.accumulate(&radiance, &distance).unwrap();
//! assert!((gather.irradiance.x - std::f32::consts::FRAC_PI_2).abs() < 1e-5);
//!
//! // A normal that turns towards the wall sees more of it.
//! let leaning = Vec3::new(-0.1, 0.0, 1.0).normalize();
//! let (brighter, clamped) = gather.extrapolate(Vec3::ZERO, Vec3::Z, leaning);
//! assert!(brighter.x > gather.irradiance.x && !clamped);
//! # let world = gather.to_world(&Frame::from_normal(Vec3::Y));
//! # assert_eq!(world.irradiance, gather.irradiance);
//! ```

mod accumulate;
mod edge;
mod gather;
mod hemicube;
mod hessian;
mod mesh;
pub mod reference;
mod source;
mod stratified;
mod strip;
#[cfg(test)]
mod tests;

pub use accumulate::MIN_DISTANCE;
pub use gather::Gather;
pub use hemicube::Hemicube;
pub use hessian::{Ellipse, Hessian};
pub use source::PointSource;
pub use stratified::Stratified;

use core::fmt;

use glam::{Vec2, Vec3};

/// Luminance of linear Rec. 709 radiance.
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// A hemisphere cut into cells.
pub trait Layout {
    /// The number of cells, and so of rays.
    fn cells(&self) -> usize;

    /// Writes a unit direction for each cell, z up, to `out`, in the order of the cells. `jitter(cell)`, in [0, 1)², is
    /// the position in the cell; a layout of fixed directions does not call it.
    ///
    /// # Errors
    ///
    /// [`LayoutError::Length`] if `out` has not [`cells`](Self::cells) elements; nothing is written then.
    fn directions(&self, jitter: &mut dyn FnMut(usize) -> Vec2, out: &mut [Vec3]) -> Result<(), LayoutError>;

    /// Irradiance, its gradients and the distances from what each cell's ray found: `radiance` in W/(m² sr), finite;
    /// `distance` in world units, +∞ for a miss, whose radiance (the sky's) counts all the same.
    ///
    /// # Errors
    ///
    /// [`LayoutError::Length`] if either slice has not [`cells`](Self::cells) elements.
    fn accumulate(&self, radiance: &[Vec3], distance: &[f32]) -> Result<Gather, LayoutError>;

    /// The second derivatives of irradiance along the tangent plane, of the mesh of neighbouring hit points. What the
    /// slices hold is as in [`accumulate`](Self::accumulate), and `directions` those that were traced, unit and local.
    ///
    /// # Errors
    ///
    /// [`LayoutError::Length`] if a slice has not [`cells`](Self::cells) elements.
    fn hessian(&self, directions: &[Vec3], radiance: &[Vec3], distance: &[f32]) -> Result<Hessian, LayoutError>;
}

/// Why a layout, or a slice for it, was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayoutError {
    /// A hemicube's size is odd or out of range.
    Size {
        /// The size asked for, in texels.
        size: u32,
    },
    /// The memory for the table is too short.
    Table {
        /// The number of floats that the table needs.
        needed: usize,
        /// The length of the memory given.
        given: usize,
    },
    /// A slice has not one element for each cell.
    Length {
        /// The number of cells.
        cells: usize,
        /// The slice's length.
        slice: usize,
    },
}

impl fmt::Display for LayoutError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size { size } => {
                write!(f, "hemicube of {size} texels a side: must be even, from 2 to {}", hemicube::MAX_SIZE)
            }
            Self::Table { needed, given } => {
                write!(f, "the layout's table needs memory for {needed} floats, there is some for {given}")
            }
            Self::Length { cells, slice } => {
                write!(f, "{cells} cells need as many elements, the slice has {slice}")
            }
        }
    }
}

impl core::error::Error for LayoutError {}

/// Checks that slices have an element for each cell.
fn check_lengths<const N: usize>(cells: usize, slices: [usize; N]) -> Result<(), LayoutError> {
    match slices.into_iter().find(|&slice| slice != cells) {
        Some(slice) => Err(LayoutError::Length { cells, slice }),
        None => Ok(()),
    }
}
