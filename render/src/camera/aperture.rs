//! Points of a lens: a disc, or a regular polygon whose corners lie on its border.
//!
//! Both maps from the square keep areas, so that equally spread numbers become equally spread points. The polygon's is
//! one triangle from the centre for each blade, each for a part of the numbers.

use std::f64::consts::TAU;

use glam::Vec2;
use halfdome_kernel::sampling::warp::{ConcentricDisc, Warp};

use crate::scene::Lens;

/// The opening through which light comes.
#[derive(Clone, Debug)]
pub(super) struct Aperture {
    /// The polygon's corners, the first once more at the end; empty for a disc.
    corners: Vec<Vec2>,
    /// Half the width and half the height of the circle around it.
    radii: Vec2,
}

impl Aperture {
    pub(super) fn new(lens: &Lens) -> Self {
        let corner = |number: u32| {
            let turn = f64::from(number % lens.blades) / f64::from(lens.blades) * TAU;
            let (sin, cos) = (turn + f64::from(lens.rotation).to_radians()).sin_cos();
            Vec2::new(cos as f32, sin as f32)
        };
        let corners = if lens.blades < 3 { Vec::new() } else { (0..=lens.blades).map(corner).collect() };
        Self { corners, radii: lens.radius * Vec2::new(lens.ratio.recip(), 1.0) }
    }

    /// The point to the right and up of the lens's middle for `u` in [0, 1)².
    pub(super) fn point(&self, u: Vec2) -> Vec2 {
        self.radii * if self.corners.is_empty() { ConcentricDisc.map(u) } else { self.of_polygon(u) }
    }

    fn of_polygon(&self, u: Vec2) -> Vec2 {
        let blades = self.corners.len() - 1;
        let along = u.x * blades as f32;
        // The product may round up to the number of blades.
        let blade = (along as usize).min(blades - 1);
        u.y.sqrt() * self.corners[blade].lerp(self.corners[blade + 1], along - blade as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(lens: &Lens) -> Vec<Vec2> {
        let aperture = Aperture::new(lens);
        let side = 400;
        let middle = |i: usize| (i as f32 + 0.5) / side as f32;
        (0..side * side).map(|i| aperture.point(Vec2::new(middle(i % side), middle(i / side)))).collect()
    }

    const LENS: Lens = Lens { radius: 2.0, focus: 1.0, blades: 0, rotation: 0.0, ratio: 1.0 };

    /// A shape of even density has the second moments of the shape, `∫x² / area`; and the greatest reach is a corner's.
    #[test]
    fn polygons_have_their_area_and_orientation() {
        for blades in [3, 5, 6, 8] {
            for rotation in [0.0, 10.0, 90.0] {
                let points = points(&Lens { blades, rotation, ..LENS });
                let n = f64::from(blades);
                // Of a regular polygon about any axis through its centre: R²/24 (4 + 2 cos(2π/n)) · ... in closed form
                // R² (2 + cos(2π/n)) / 12.
                let expected = 4.0 * (2.0 + (TAU / n).cos()) / 12.0;
                let mean = |f: &dyn Fn(&Vec2) -> f32| {
                    points.iter().map(|p| f64::from(f(p))).sum::<f64>() / points.len() as f64
                };
                assert!((mean(&|p| p.x * p.x) / expected - 1.0).abs() < 1e-3, "{blades} {rotation}");
                assert!((mean(&|p| p.y * p.y) / expected - 1.0).abs() < 1e-3, "{blades} {rotation}");
                assert!(
                    mean(&|p| p.x).abs() < 1e-3 && mean(&|p| p.y).abs() < 1e-3 && mean(&|p| p.x * p.y).abs() < 1e-3
                );
                // Inside of all sides, whose distance from the centre is R cos(π/n), and up to the corners.
                let inner = 2.0 * (TAU / 2.0 / n).cos();
                for blade in 0..blades {
                    let at = |turn: f64| {
                        let (sin, cos) = (turn / n * TAU + f64::from(rotation).to_radians()).sin_cos();
                        Vec2::new(cos as f32, sin as f32)
                    };
                    let reach = |axis: Vec2| points.iter().map(|p| p.dot(axis)).fold(0.0, f32::max);
                    let side = f64::from(reach(at(f64::from(blade) + 0.5)));
                    assert!(side <= inner + 1e-5 && side > 0.995 * inner, "{side} {inner}");
                    assert!(reach(at(f64::from(blade))) > 1.98);
                }
            }
        }
    }

    #[test]
    fn an_anamorphic_lens_is_higher_than_wide() {
        let points = points(&Lens { ratio: 2.0, ..LENS });
        let mean = |f: &dyn Fn(&Vec2) -> f32| points.iter().map(f).sum::<f32>() / points.len() as f32;
        // Of an ellipse with the half axes a and b: a²/4 and b²/4.
        assert!((mean(&|p| p.x * p.x) - 0.25).abs() < 1e-3);
        assert!((mean(&|p| p.y * p.y) - 1.0).abs() < 2e-3);
        assert!(points.iter().all(|p| (2.0 * p.x).hypot(p.y) <= 2.0 + 1e-5));
    }
}
