//! Measures the treatment of seams: the difference of lookups on both sides of every edge and corner, and their error.
//!
//! The filter is bilinear within one face. *Seam* is the greatest difference between the faces that meet at a point of
//! an edge, *error* that between a lookup anywhere and the function that was stored, both relative to the mean. They
//! are measured on a smooth function of the direction, so that all treatments start from the same function.

use glam::{DVec3, Vec3};
use serde::Serialize;

use super::face::Face;
use super::grid::{Seams, TexelGrid};
use super::level::Level;

/// The seams that a treatment leaves in a level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SeamError {
    /// Greatest difference between faces that meet, relative to the mean.
    pub seam: f64,
    /// Greatest difference from the function, relative to the mean.
    pub error: f64,
}

/// Points of an edge for each of its texels, without the last.
const POINTS: u32 = 4;
/// Points across a face in which the error is measured, at most.
const MAX_POINTS: u32 = 128;

/// The greatest difference between faces at their edges and corners, relative to the mean.
pub fn seam(level: &Level) -> f64 {
    let mean = level.mean();
    if mean == 0.0 {
        return 0.0;
    }
    let points = level.grid.size * POINTS;
    let place = |i: u32| f64::from(2 * i) / f64::from(points) - 1.0;
    let edges = (0..3).flat_map(|axis| [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]].map(|ends| (axis, ends)));
    let directions = edges.flat_map(|(axis, [a, b])| {
        (0..=points).map(move |i| {
            let mut direction = [0.0; 3];
            (direction[axis], direction[(axis + 1) % 3], direction[(axis + 2) % 3]) = (place(i), a, b);
            DVec3::from(direction)
        })
    });
    let jump = |direction: DVec3| {
        // Faces on whose square the direction is.
        let meets = |face: &Face| face.coordinates(direction).is_some_and(|[u, v]| u.abs().max(v.abs()) <= 1.0);
        let seen = Face::ALL.into_iter().filter(meets).filter_map(|face| level.sample(face, direction));
        let (low, high) =
            seen.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        (high - low).max_element()
    };
    directions.map(jump).fold(0.0, f64::max) / mean
}

/// The seams that each treatment leaves in a level of this size, in the order of [`Seams::ALL`].
pub fn smooth(size: u32) -> [SeamError; 4] {
    Seams::ALL.map(|seams| {
        let grid = TexelGrid { size, seams };
        let value = |direction: DVec3| Vec3::splat(function(direction) as f32);
        let mut texels: Vec<Vec3> = grid.places().map(|(face, x, y)| value(grid.point(face, x, y))).collect();
        grid.weld(&mut texels);
        let level = Level { grid, lobe: None, texels };
        let points = (size * POINTS).min(MAX_POINTS);
        let place = |i: u32| f64::from(2 * i) / f64::from(points) - 1.0;
        let off = |face: Face, x: u32, y: u32| {
            let direction = face.point(place(x), place(y));
            let found = level.sample(face, direction).map_or(0.0, |value| value.x);
            (found - function(direction)).abs()
        };
        let places = Face::ALL.into_iter().flat_map(|face| (0..=points).map(move |x| (face, x)));
        let errors = places.flat_map(|(face, x)| (0..=points).map(move |y| off(face, x, y)));
        SeamError { seam: seam(&level), error: errors.fold(0.0, f64::max) }
    })
}

/// A smooth function with a mean of 1 and of no symmetry that a cube has, from harmonics up to the third degree.
fn function(direction: DVec3) -> f64 {
    let DVec3 { x, y, z } = direction.normalize();
    let first = 0.30 * x - 0.15 * y + 0.20 * z;
    let second = 0.25 * x * y - 0.30 * y * z + 0.20 * z * x + 0.10 * (x * x - y * y);
    let third = 0.40 * x * y * z + 0.15 * z * (x * x - y * y);
    1.0 + first + second + third
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn treatments_leave_no_seam_and_the_lookup_no_distortion() {
        for size in [4, 16, 64] {
            let [none, stretch, warp, lookup] = smooth(size);
            // A difference between neighbouring texels' centres that are about a texel apart.
            assert!(none.seam * f64::from(size) > 0.3, "{size}: {none:?}");
            for treated in [stretch, warp, lookup] {
                assert!(treated.seam < 1e-6 && treated.seam < 1e-4 * none.seam, "{size}: {treated:?}");
            }
            // The stretch moves what is near the edges by half a texel, the warp as much but in fewer places; the
            // lookup has the error of interpolation alone, of second order: less by a factor that grows with the size.
            let factor = f64::from(size) / 3.5;
            assert!(factor * lookup.error < none.error.min(stretch.error), "{size}: {lookup:?} {none:?} {stretch:?}");
            assert!(warp.error < stretch.error, "{size}: {warp:?} {stretch:?}");
        }
        let ratio = smooth(16)[3].error / smooth(64)[3].error;
        assert!((12.0..20.0).contains(&ratio), "a quarter of the step has a sixteenth of the error: {ratio}");
    }

    #[test]
    fn a_seam_is_what_faces_differ_by() {
        let grid = TexelGrid { size: 2, seams: Seams::None };
        let mut texels = vec![Vec3::ONE; 24];
        assert_eq!(seam(&Level { grid, lobe: None, texels: texels.clone() }), 0.0);
        // One face twice as bright as the rest.
        texels[8..12].fill(Vec3::splat(2.0));
        let level = Level { grid, lobe: None, texels };
        assert!((seam(&level) - 1.0 / (7.0 / 6.0)).abs() < 1e-12);
        assert_eq!(seam(&Level { texels: vec![Vec3::ZERO; 24], ..level }), 0.0);
    }

    #[test]
    fn a_face_of_one_texel_has_no_seam_when_treated() {
        let [none, stretch, warp, lookup] = smooth(1);
        assert!(none.seam > 0.1);
        assert_eq!([stretch.seam, warp.seam, lookup.seam], [0.0; 3]);
    }
}
