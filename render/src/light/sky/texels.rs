//! Bilinear interpolation of a sky picture, across the seam and the poles, as in other renderers.
//!
//! A place has a column `x` and a row `y`. Columns are even in azimuth; within a row, `y` is even in solid angle, so that a
//! density over places is one per solid angle but for a factor that each row has. What a texel counts for is a tent about its
//! middle, one texel to each side; at the poles what is beyond is folded back.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Vec2, Vec3};

use crate::scene::SkyPicture;

/// A picture, and what directions need to know of its rows.
#[derive(Debug)]
pub(super) struct SkyTexels {
    picture: SkyPicture,
    /// `(1 - cos θ) / 2` and `(1 + cos θ) / 2` of the rows' borders, as cosines near the poles are all 1; one more than there
    /// are rows.
    borders: Vec<Vec2>,
    /// How much of the tent of a row's texels is in the rows above, of the texel and below.
    tents: Vec<[f32; 3]>,
    /// How far the picture is turned, as a part of a whole turn, from 0 to 1.
    turned: f32,
}

/// Where the texels around a place are in the picture, and their weights, whose sum is 1.
#[derive(Clone, Copy, Default)]
pub(super) struct TexelPlaces {
    indices: [usize; 4],
    weights: [f32; 4],
}

/// The texels around a place, and their weights.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Around {
    texels: [Vec3; 4],
    weights: [f32; 4],
}

impl SkyTexels {
    pub(super) fn new(picture: SkyPicture) -> Self {
        let border = |row: u32| {
            let (sin, cos) = (0.5 * PI * row as f32 / picture.height as f32).sin_cos();
            Vec2::new(sin * sin, cos * cos)
        };
        let tent = |row: u32| picture.row_solid_angles(row).map(|part| part as f32);
        let borders = (0..=picture.height).map(border).collect();
        let tents = (0..picture.height).map(tent).collect();
        let turned = (picture.rotation / TAU).rem_euclid(1.0);
        Self { picture, borders, tents, turned }
    }

    pub(super) fn picture(&self) -> &SkyPicture {
        &self.picture
    }

    /// The texels around the direction of a unit vector.
    #[inline]
    pub(super) fn around(&self, direction: Vec3) -> Around {
        self.fetch(&self.places(direction))
    }

    /// The texels at these places.
    #[inline]
    pub(super) fn fetch(&self, places: &TexelPlaces) -> Around {
        let mut texels = [Vec3::ZERO; 4];
        for (texel, &index) in texels.iter_mut().zip(&places.indices) {
            *texel = self.picture.texels[index];
        }
        Around { texels, weights: places.weights }
    }

    /// Where the texels around the direction of a unit vector are.
    #[inline]
    pub(super) fn places(&self, direction: Vec3) -> TexelPlaces {
        let (width, height) = (self.picture.width as usize, self.picture.height as usize);
        // Not the floor, which is a call.
        let place = self.place(direction) + 0.5;
        let (next_column, next_row) = (place.x as usize, place.y as usize);
        let part = place - Vec2::new(next_column as f32, next_row as f32);
        // Divisions would take longer than all the rest.
        let left = if next_column == 0 { width - 1 } else { next_column - 1 };
        let right = if next_column >= width { 0 } else { next_column };
        let [above, below] = [next_row.saturating_sub(1), next_row.min(height - 1)];
        let index = |row: usize, column: usize| row * width + column;
        TexelPlaces {
            indices: [index(above, left), index(above, right), index(below, left), index(below, right)],
            weights: [
                (1.0 - part.x) * (1.0 - part.y),
                part.x * (1.0 - part.y),
                (1.0 - part.x) * part.y,
                part.x * part.y,
            ],
        }
    }

    /// The place in a direction: its column and row, with what is within them as fractions.
    #[inline]
    pub(super) fn place(&self, direction: Vec3) -> Vec2 {
        let (width, height) = (self.picture.width as f32, self.picture.height as f32);
        let turns = angle(direction.x, -direction.z) / TAU + 0.5 + self.turned;
        let across = (if turns >= 1.0 { turns - 1.0 } else { turns }) * width;
        // More exact near the poles than the arc cosine.
        let squared_sine = Vec2::new(direction.x, direction.z).length_squared();
        let theta = angle(squared_sine.sqrt(), direction.y);
        let row = ((theta * height / PI) as usize).min(self.tents.len() - 1);
        let [above, below] = [self.borders[row], self.borders[row + 1]];
        let half = 0.5 * squared_sine / (1.0 + direction.y.abs());
        let down = match direction.y >= 0.0 {
            true => (half - above.x) / (below.x - above.x),
            false => (above.y - half) / (above.y - below.y),
        };
        Vec2::new(across, row as f32 + down.clamp(0.0, 1.0))
    }

    /// The direction to a place; columns go around.
    pub(super) fn direction_to(&self, place: Vec2) -> Vec3 {
        direction(self.azimuth(place.x), self.polar(place.y))
    }

    /// Sine and cosine of the azimuth of a column.
    fn azimuth(&self, column: f32) -> Vec2 {
        let phi = TAU * (column / self.picture.width as f32 - 0.5) - self.picture.rotation;
        Vec2::new(phi.sin(), phi.cos())
    }

    /// Sine and cosine of the angle of a row from the zenith.
    fn polar(&self, row: f32) -> Vec2 {
        let whole = (row as usize).min(self.tents.len() - 1);
        let [above, below] = [self.borders[whole], self.borders[whole + 1]];
        let half = above.lerp(below, (row - whole as f32).clamp(0.0, 1.0));
        Vec2::new(2.0 * (half.x * half.y).sqrt(), half.y - half.x)
    }

    /// The direction to the middle of a texel.
    pub(super) fn middle(&self, column: u32, row: u32) -> Vec3 {
        self.direction_to(Vec2::new(column as f32 + 0.5, row as f32 + 0.5))
    }

    /// The directions to the middles of all texels.
    pub(super) fn middles(&self) -> Middles {
        let middle = |number: i64| number as f32 + 0.5;
        Middles {
            azimuths: (-1..=i64::from(self.picture.width)).map(|column| self.azimuth(middle(column))).collect(),
            polars: (-1..=i64::from(self.picture.height)).map(|row| self.polar(middle(row))).collect(),
        }
    }

    /// The diagonal of a texel at the horizon, in radians: nothing in a texel's tent is farther from its middle.
    pub(super) fn texel_angle(&self) -> f32 {
        Vec2::new(TAU / self.picture.width as f32, PI / self.picture.height as f32).length()
    }

    /// A place by the tent of a texel, in proportion to solid angle, for numbers in [0, 1).
    pub(super) fn place_in_tent(&self, (column, row): (u32, u32), u: Vec2) -> Vec2 {
        let across = match u.x < 0.5 {
            true => (2.0 * u.x).sqrt() - 1.0,
            false => 1.0 - (2.0 * (1.0 - u.x)).sqrt(),
        };
        let [above, own, below] = self.tents[row as usize];
        let number = u.y * (above + own + below);
        let down = match () {
            () if number < above => -1.0 + 0.5 * (number / above).sqrt(),
            () if number < above + own => {
                let part = 2.0 * (number - above) / own - 1.0;
                (1.0 - (1.0 - 0.75 * part.abs()).sqrt()).copysign(part)
            }
            () => 1.0 - 0.5 * (1.0 - (number - above - own) / below).max(0.0).sqrt(),
        };
        let (y, height) = (row as f32 + 0.5 + down, self.picture.height as f32);
        let folded = match () {
            () if y < 0.0 => -y,
            () if y > height => 2.0 * height - y,
            () => y,
        };
        Vec2::new(column as f32 + 0.5 + across, folded)
    }
}

/// The directions to the middles of texels, and of those beside the first and last: what it takes of columns and of rows.
pub(super) struct Middles {
    azimuths: Vec<Vec2>,
    polars: Vec<Vec2>,
}

impl Middles {
    /// The direction to the middle of a texel.
    pub(super) fn of(&self, column: u32, row: u32) -> Vec3 {
        direction(self.azimuths[column as usize + 1], self.polars[row as usize + 1])
    }

    /// Those of a texel and the eight around it; what is beyond a pole is at the pole.
    pub(super) fn around(&self, column: u32, row: u32) -> impl Iterator<Item = Vec3> {
        let polars = &self.polars[row as usize..][..3];
        let azimuths = &self.azimuths[column as usize..][..3];
        azimuths.iter().flat_map(move |&azimuth| polars.iter().map(move |&polar| direction(azimuth, polar)))
    }
}

/// The unit vector by sines and cosines of both angles.
fn direction(azimuth: Vec2, polar: Vec2) -> Vec3 {
    Vec3::new(polar.x * azimuth.x, polar.y, -polar.x * azimuth.y)
}

impl Around {
    /// The mean of what texels have.
    #[inline]
    pub(super) fn mean(&self, value: impl Fn(Vec3) -> Vec3) -> Vec3 {
        self.texels.iter().zip(self.weights).map(|(texel, weight)| value(*texel) * weight).sum()
    }

    /// The same of a number.
    #[inline]
    pub(super) fn mean_number(&self, value: impl Fn(Vec3) -> f32) -> f32 {
        self.texels.iter().zip(self.weights).map(|(texel, weight)| value(*texel) * weight).sum()
    }
}

/// The angle of a vector in -π..=π, as the C library gives it, whose function took a good part of a lookup's time.
#[inline(always)]
fn angle(y: f32, x: f32) -> f32 {
    let (along, up) = (x.abs(), y.abs());
    let tangent = along.min(up) / along.max(up).max(f32::MIN_POSITIVE);
    // Abramowitz and Stegun 4.4.49, to 2e-8.
    const TERMS: [f32; 8] = [
        0.002_866_225_7,
        -0.016_165_737,
        0.042_909_615,
        -0.075_289_64,
        0.106_562_64,
        -0.142_089,
        0.199_935_51,
        -0.333_331_47,
    ];
    let squared = tangent * tangent;
    let arc = tangent + tangent * squared * TERMS.iter().fold(0.0, |sum, term| sum * squared + term);
    let arc = if up > along { FRAC_PI_2 - arc } else { arc };
    let arc = if x < 0.0 { PI - arc } else { arc };
    arc.copysign(y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_the_library() {
        for i in 0..100_000 {
            let expected = (f64::from(i) / 50_000.0 - 1.0) * std::f64::consts::PI;
            let found = angle((3.0 * expected.sin()) as f32, (3.0 * expected.cos()) as f32);
            let off = (f64::from(found) - expected).abs();
            assert!(off.min((off - 2.0 * std::f64::consts::PI).abs()) < 4e-7, "{found}, not {expected}");
        }
        assert_eq!(angle(0.0, 0.0), 0.0);
    }
}
