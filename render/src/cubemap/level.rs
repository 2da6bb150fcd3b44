//! One level of a cube map: its texels and lookups.

use glam::{DVec3, Vec3};

use super::face::Face;
use super::grid::TexelGrid;
use super::lobe::Lobe;

/// A level.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// The positions of the texels.
    pub grid: TexelGrid,
    /// The lobe of their filter; `None` for unfiltered radiance.
    pub lobe: Option<Lobe>,
    /// Radiance, W/(m² sr), linear sRGB: face by face, row by row from the top.
    pub texels: Vec<Vec3>,
}

impl Level {
    /// The texels of one face.
    pub fn face(&self, face: Face) -> &[Vec3] {
        let count = self.texels.len() / 6;
        &self.texels[face as usize * count..][..count]
    }

    /// What hardware reads that filters bilinearly within one face; `None` if the direction, in the cube's space,
    /// points away from the face. Beyond the outermost texels' centres, their values go on.
    pub fn sample(&self, face: Face, direction: DVec3) -> Option<DVec3> {
        let [s, t] = face.coordinates(direction)?;
        let last = f64::from(self.grid.size - 1);
        let [x, y] = [s, t].map(|s| (self.grid.lookup(s) - 0.5).clamp(0.0, last));
        let texels = self.face(face);
        let texel = |x: f64, y: f64| texels[y as usize * self.grid.size as usize + x as usize].as_dvec3();
        let row = |y: f64| texel(x.floor(), y).lerp(texel(x.ceil(), y), x.fract());
        Some(row(y.floor()).lerp(row(y.ceil()), y.fract()))
    }

    /// Mean of all texels, each as much as any other.
    pub(super) fn mean(&self) -> f64 {
        let sum: DVec3 = self.texels.iter().map(|texel| texel.as_dvec3()).sum();
        sum.element_sum() / (3.0 * self.texels.len() as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::super::grid::Seams;
    use super::*;

    #[test]
    fn lookups_at_texels_find_them_and_in_between_mix_them() {
        for seams in [Seams::None, Seams::Lookup] {
            let grid = TexelGrid { size: 4, seams };
            let texels: Vec<Vec3> = (0..96).map(|i| Vec3::splat(i as f32)).collect();
            let level = Level { grid, lobe: None, texels };
            for (number, (face, x, y)) in grid.places().enumerate() {
                let found = level.sample(face, 2.0 * grid.point(face, x, y)).unwrap();
                assert!((found.x - number as f64).abs() < 1e-9, "{seams:?} {face:?} {x} {y}: {found}");
            }
            let between = Face::NegativeZ.point(grid.place(2.0), grid.place(1.25));
            // Between columns 1 and 2 of rows 0 and 1, three quarters down.
            let expected = 80.0 + 1.5 + 4.0 * 0.75;
            assert!((level.sample(Face::NegativeZ, between).unwrap().x - expected).abs() < 1e-9);
            assert_eq!(level.sample(Face::PositiveZ, between), None);
        }
    }
}
