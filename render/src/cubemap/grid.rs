//! Positions of a face's texels and of lookups: the three treatments of seams of Castaño's "Seamless Cube Map
//! Filtering" (The Witness blog, 2012).
//!
//! Hardware that filters within one face alone never looks half a texel beyond its outermost texels' centres, and so
//! sees a seam. With `s = 2t/n - 1`, `t` being a coordinate in texels of a face of `n`:
//!
//! - `none`: texels are where lookups expect them, at `s`.
//! - `stretch`: the outermost texels lie on the edge, where the neighbour has the same ones: `s n/(n - 1)`, all of the
//!   face being a little too small. (His `map_2`.)
//! - `warp`: likewise, but the middle stays in place: `a s³ + s` with `a = n²/(n - 1)³`.
//! - `lookup`: texels are as for `stretch`, and the lookup shrinks its coordinates by `(n - 1)/n`, so that all texels
//!   are at their exact positions.
//!
//! Texels that faces share are made equal bit for bit. A face of one texel has no edge but its neighbours': there, all
//! six are the same with any treatment.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};

use super::face::Face;
use crate::settings::named;

/// The treatment of seams between faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seams {
    /// Nothing: for hardware that filters across edges.
    None,
    /// Faces are scaled until their outermost texels meet.
    Stretch,
    /// Faces are bent near their edges until they meet.
    Warp,
    /// Faces are scaled, and so is what a shader looks up.
    Lookup,
}

named!(Seams: None = "none", Stretch = "stretch", Warp = "warp", Lookup = "lookup");

/// The texels of one face, as many across as down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TexelGrid {
    /// Texels across, at least 1.
    pub size: u32,
    /// Their placement.
    pub seams: Seams,
}

impl TexelGrid {
    /// Where a coordinate in texels is on the face, -1 to 1; centres have halves.
    pub fn place(&self, t: f64) -> f64 {
        let n = f64::from(self.size);
        let s = (2.0 * t - n) / n;
        let place = match self.seams {
            _ if self.size == 1 => s,
            Seams::None => s,
            Seams::Stretch | Seams::Lookup => (2.0 * t - n) / (n - 1.0),
            // The formula's result, without its rounding.
            Seams::Warp if t <= 0.5 || t >= n - 0.5 => s.signum(),
            Seams::Warp => n * n / (n - 1.0).powi(3) * s * s * s + s,
        };
        place.clamp(-1.0, 1.0)
    }

    /// The point of a face at which the texel in this column and row has its value.
    pub(super) fn point(&self, face: Face, x: u32, y: u32) -> DVec3 {
        face.point(self.place(f64::from(x) + 0.5), self.place(f64::from(y) + 0.5))
    }

    /// The coordinate in texels that a lookup at `s` of a face, -1 to 1, reads.
    pub fn lookup(&self, s: f64) -> f64 {
        let n = f64::from(self.size);
        let scale = if self.seams == Seams::Lookup { (n - 1.0) / n } else { 1.0 };
        0.5 * (s * scale + 1.0) * n
    }

    /// The number of texels of all six faces.
    pub(super) fn texels(&self) -> usize {
        6 * (self.size as usize).pow(2)
    }

    /// Face, column and row of all texels, in the order of their indices: by faces, then by rows.
    pub(super) fn places(&self) -> impl Iterator<Item = (Face, u32, u32)> + use<> {
        let size = self.size;
        Face::ALL.into_iter().flat_map(move |face| (0..size).flat_map(move |y| (0..size).map(move |x| (face, x, y))))
    }

    /// Gives texels that are at one place on two or three faces their mean.
    pub(super) fn weld(&self, texels: &mut [Vec3]) {
        if self.seams == Seams::None {
            return;
        }
        let mut groups: BTreeMap<[u64; 3], Vec<usize>> = BTreeMap::new();
        let last = self.size - 1;
        for (number, (face, x, y)) in self.places().enumerate() {
            if [x, y].into_iter().any(|place| place == 0 || place == last) {
                let point = if last == 0 { DVec3::ZERO } else { self.point(face, x, y) };
                groups.entry(point.to_array().map(f64::to_bits)).or_default().push(number);
            }
        }
        for group in groups.values() {
            let sum: DVec3 = group.iter().map(|&number| texels[number].as_dvec3()).sum();
            let mean = (sum / group.len() as f64).as_vec3();
            group.iter().for_each(|&number| texels[number] = mean);
        }
    }
}

/// The solid angle of a rectangle on a face, as seen from the middle of the cube: from `u[0]` to `u[1]` and `v[0]` to
/// `v[1]`.
///
/// The corner of the quadrant that ends at `(u, v)` is the integral of `(1 + u² + v²)^(-3/2)`,
/// `atan(u v / √(1 + u² + v²))`.
pub(super) fn solid_angle(u: [f64; 2], v: [f64; 2]) -> f64 {
    let quadrant = |u: f64, v: f64| (u * v).atan2((1.0 + u * u + v * v).sqrt());
    quadrant(u[1], v[1]) - quadrant(u[0], v[1]) - quadrant(u[1], v[0]) + quadrant(u[0], v[0])
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn outermost_texels_are_on_the_edge_and_the_middle_stays() {
        for size in [2, 3, 4, 8, 64] {
            for seams in [Seams::Stretch, Seams::Warp, Seams::Lookup] {
                let grid = TexelGrid { size, seams };
                let n = f64::from(size);
                assert_eq!((grid.place(0.5), grid.place(n - 0.5), grid.place(0.5 * n)), (-1.0, 1.0, 0.0), "{grid:?}");
                let places: Vec<f64> = (0..size).map(|x| grid.place(f64::from(x) + 0.5)).collect();
                assert!(places.is_sorted_by(|a, b| a < b), "{grid:?}");
                assert!(places.iter().zip(places.iter().rev()).all(|(a, b)| *a == -b), "{grid:?}");
            }
            // Castaño's maps of the second texel.
            let n = f64::from(size);
            assert!((TexelGrid { size, seams: Seams::Stretch }.place(1.5) - (2.0 / (n - 1.0) - 1.0)).abs() < 1e-15);
            let s = 3.0 / n - 1.0;
            let warped = n * n / (n - 1.0).powi(3) * s.powi(3) + s;
            assert!((TexelGrid { size, seams: Seams::Warp }.place(1.5) - warped).abs() < 1e-14);
        }
    }

    /// A lookup that was shrunk reads each texel at the direction for which it was made.
    #[test]
    fn the_modified_lookup_undoes_the_stretch() {
        for seams in [Seams::None, Seams::Lookup] {
            let grid = TexelGrid { size: 8, seams };
            for x in 0..8 {
                let t = f64::from(x) + 0.5;
                assert!((grid.lookup(grid.place(t)) - t).abs() < 1e-12, "{seams:?}");
            }
        }
    }

    #[test]
    fn texels_cover_the_sphere() {
        for seams in Seams::ALL {
            let grid = TexelGrid { size: 5, seams };
            let side = |x: u32| [grid.place(f64::from(x)), grid.place(f64::from(x) + 1.0)];
            let sum: f64 = grid.places().map(|(_, x, y)| solid_angle(side(x), side(y))).sum();
            assert!((sum - 4.0 * PI).abs() < 1e-12, "{seams:?}: {sum}");
        }
        // A small square in the middle has its area.
        assert!((solid_angle([-1e-3, 1e-3], [-1e-3, 1e-3]) / 4e-6 - 1.0).abs() < 1e-5);
    }

    #[test]
    fn welding_joins_two_at_edges_and_three_at_corners() {
        for seams in [Seams::Stretch, Seams::Warp, Seams::Lookup] {
            let grid = TexelGrid { size: 4, seams };
            let mut texels: Vec<Vec3> = (0..grid.texels()).map(|i| Vec3::splat(i as f32)).collect();
            let before = texels.clone();
            grid.weld(&mut texels);
            let mut partners = [0; 4];
            for (i, (face, x, y)) in grid.places().enumerate() {
                let point = grid.point(face, x, y);
                let same: Vec<usize> = grid
                    .places()
                    .enumerate()
                    .filter(|(_, (f, x, y))| grid.point(*f, *x, *y) == point)
                    .map(|p| p.0)
                    .collect();
                let mean = same.iter().map(|&j| before[j].x).sum::<f32>() / same.len() as f32;
                assert!((texels[i].x - mean).abs() < 1e-5, "{face:?} {x} {y}");
                partners[same.len()] += 1;
            }
            // Eight corners of three, twelve edges with two texels of two each.
            assert_eq!(partners, [0, 24, 48, 24]);
            let mut single: Vec<Vec3> = (0..6).map(|i| Vec3::splat(i as f32)).collect();
            TexelGrid { size: 1, seams }.weld(&mut single);
            assert_eq!(single, [Vec3::splat(2.5); 6]);
        }
    }
}
