//! Triangulation of polygons: a fan around the first corner where that is valid, as for convex ones, else ear clipping
//! (Held, "FIST: Fast Industrial-Strength Triangulation of Polygons", 2001), through the crate `earcut`.
//!
//! A fan is valid if none of its triangles is flipped, seen along the polygon's normal (Newell's: the sum of the cross
//! products of its sides, which is defined for non-planar corners, too). Ears are clipped in the plane across that
//! normal. A self-intersecting polygon gets some triangulation, and one without area a fan.

use earcut::Earcut;
use glam::{DVec2, DVec3, Vec3};

/// How far a triangle may be turned over, as a part of the polygon's area: corners on a line are rounded.
const ROUNDING: f64 = 1e-6;

/// Cuts polygons, one after the other.
pub(crate) struct Cutter {
    earcut: Earcut<f64>,
    indices: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl Cutter {
    pub(crate) fn new() -> Self {
        Self { earcut: Earcut::new(), indices: Vec::new(), triangles: Vec::new() }
    }

    /// Triangles of a polygon of three corners or more, as numbers of its corners, in its winding.
    pub(crate) fn cut(&mut self, corners: &[Vec3]) -> &[[u32; 3]] {
        self.triangles.clear();
        let fan = (2..corners.len()).map(|last| [0, last - 1, last]);
        if let Some(normal) = normal(corners).filter(|&normal| {
            let least = -ROUNDING * normal.length_squared();
            corners.len() > 3 && fan.clone().any(|triangle| area(corners, triangle).dot(normal) < least)
        }) {
            let (right, up) = normal.normalize().any_orthonormal_pair();
            let flat = |&corner: &Vec3| {
                let corner = (corner - corners[0]).as_dvec3();
                DVec2::new(corner.dot(right), corner.dot(up)).to_array()
            };
            self.earcut.earcut(corners.iter().map(flat), &[], &mut self.indices);
            let ears = self.indices.as_chunks::<3>().0.iter();
            let turned = |it: &[u32; 3]| area(corners, it.map(|corner| corner as usize)).dot(normal);
            let sum: f64 = ears.clone().map(turned).sum();
            self.triangles.extend(ears.map(|&[a, b, c]| if sum < 0.0 { [a, c, b] } else { [a, b, c] }));
        }
        if self.triangles.is_empty() {
            self.triangles.extend(fan.map(|triangle| triangle.map(|corner| corner as u32)));
        }
        &self.triangles
    }
}

/// Twice the area of a triangle, along its normal.
fn area(corners: &[Vec3], [a, b, c]: [usize; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|corner| corners[corner].as_dvec3());
    (b - a).cross(c - a)
}

/// Twice the area of a polygon, along its normal; `None` if it has none.
fn normal(corners: &[Vec3]) -> Option<DVec3> {
    let sum: DVec3 = (2..corners.len()).map(|last| area(corners, [0, last - 1, last])).sum();
    (sum.is_finite() && sum.length_squared() > 0.0).then_some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An L with its inner corner at (1, 1), whose fan around (0, 2) would leave it.
    const L: [[f32; 2]; 6] = [[0.0, 2.0], [0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0]];

    fn corners(points: &[[f32; 2]]) -> Vec<Vec3> {
        points.iter().map(|&[x, y]| Vec3::new(x, y, 0.0)).collect()
    }

    /// Asserts that triangles cover the polygon once, in its winding.
    fn assert_covers(corners: &[Vec3], triangles: &[[u32; 3]]) {
        let normal = normal(corners).unwrap();
        let areas = triangles.iter().map(|it| area(corners, it.map(|it| it as usize)).dot(normal.normalize()));
        let areas: Vec<f64> = areas.collect();
        assert!(areas.iter().all(|&area| area > 0.0), "{triangles:?} {areas:?}");
        let sum: f64 = areas.iter().sum();
        assert!((sum / normal.length() - 1.0).abs() < 1e-6, "{triangles:?}");
    }

    #[test]
    fn convex_polygons_are_fans() {
        let mut cutter = Cutter::new();
        let square = corners(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(cutter.cut(&square[..3]), [[0, 1, 2]]);
        assert_eq!(cutter.cut(&square), [[0, 1, 2], [0, 2, 3]]);
        let mut bent = square.clone();
        bent[2].z = 0.9;
        assert_eq!(cutter.cut(&bent), [[0, 1, 2], [0, 2, 3]]);
        // Corners on a line, equal ones, and no area at all.
        assert_eq!(cutter.cut(&[square[0], square[1], square[1], square[2], square[3]]).len(), 3);
        let third = corners(&[[0.0, 0.0], [0.1, 0.3], [0.2, 0.6], [0.3, 0.9], [-1.0, 0.5]]);
        assert_eq!(cutter.cut(&third), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        assert_eq!(cutter.cut(&[Vec3::ONE; 4]), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(cutter.cut(&[square[0], square[1], square[0], square[1]]).len(), 2);
    }

    #[test]
    fn ears_cover_concave_polygons_once_whatever_their_first_corner_winding_and_plane() {
        let mut cutter = Cutter::new();
        let turn = glam::Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 2.0);
        let mut ears = 0;
        for first in 0..L.len() {
            for (reverse, bend) in [(false, 0.0), (true, 0.0), (false, 0.1)] {
                let mut polygon = corners(&L);
                polygon[3].z = bend;
                polygon.rotate_left(first);
                if reverse {
                    polygon.reverse();
                }
                let polygon: Vec<Vec3> = polygon.iter().map(|&corner| turn * corner + 100.0).collect();
                let triangles = cutter.cut(&polygon);
                assert_covers(&polygon, triangles);
                ears += usize::from(triangles.iter().any(|triangle| triangle[0] != 0));
            }
        }
        assert!(ears > 0);
    }

    #[test]
    fn a_comb_and_a_dart() {
        let mut cutter = Cutter::new();
        let mut comb = vec![[0.0, 0.0], [20.0, 0.0]];
        for tooth in (0..10_u8).rev() {
            let x = 2.0 * f32::from(tooth);
            comb.extend([[x + 1.5, 5.0], [x + 0.5, 1.0]]);
        }
        assert_covers(&corners(&comb), cutter.cut(&corners(&comb)));
        // From its first corner the fan of a dart is right: it stays.
        let dart = corners(&[[0.0, 1.0], [-2.0, -2.0], [0.0, 0.0], [2.0, -2.0]]);
        assert_eq!(cutter.cut(&dart), [[0, 1, 2], [0, 2, 3]]);
        let turned = [dart[1], dart[2], dart[3], dart[0]];
        assert_covers(&turned, cutter.cut(&turned));
        // One that crosses itself ends.
        let crossing = corners(&[[0.0, 0.0], [3.0, 3.0], [3.0, 0.0], [0.0, 2.0], [1.0, -1.0]]);
        assert!(!cutter.cut(&crossing).is_empty());
    }
}
