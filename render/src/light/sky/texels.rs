//! Bilinear interpolation of a sky picture, across the seam and the poles, as in other renderers.
//!
//! A place has a column `x` and a row `y`. Columns are even in azimuth; within a row, `y` is even in solid angle, so that a
//! density over places is one per solid angle but for a factor that each row has. What a texel counts for is a tent about its
//! middle, one texel to each side; at the poles what is beyond is folded back.

use std::f32::consts::{PI, TAU};

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
}

/// The texels around a place, and their weights, whose sum is 1.
pub(super) struct Around<'a> {
    texels: [&'a Vec3; 4],
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
        Self { picture, borders, tents }
    }

    pub(super) fn picture(&self) -> &SkyPicture {
        &self.picture
    }

    /// The texels around the direction of a unit vector.
    #[inline]
    pub(super) fn around(&self, direction: Vec3) -> Around<'_> {
        let (width, height) = (self.picture.width as usize, self.picture.height as usize);
        // Not the floor, which is a call.
        let place = self.place(direction) + 0.5;
        let (next_column, next_row) = (place.x as usize, place.y as usize);
        let part = place - Vec2::new(next_column as f32, next_row as f32);
        let [left, right] = [next_column + width - 1, next_column].map(|column| column % width);
        let [above, below] = [next_row.saturating_sub(1), next_row.min(height - 1)];
        let texel = |row: usize, column: usize| &self.picture.texels[row * width + column];
        Around {
            texels: [texel(above, left), texel(above, right), texel(below, left), texel(below, right)],
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
        let phi = direction.x.atan2(-direction.z) + self.picture.rotation;
        let across = (phi / TAU + 0.5).rem_euclid(1.0) * width;
        // More exact near the poles than the arc cosine.
        let squared_sine = Vec2::new(direction.x, direction.z).length_squared();
        let theta = squared_sine.sqrt().atan2(direction.y);
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
        let width = self.picture.width as f32;
        let row = (place.y as usize).min(self.tents.len() - 1);
        let [above, below] = [self.borders[row], self.borders[row + 1]];
        let half = above.lerp(below, (place.y - row as f32).clamp(0.0, 1.0));
        let sine = 2.0 * (half.x * half.y).sqrt();
        let phi = TAU * (place.x / width - 0.5) - self.picture.rotation;
        Vec3::new(sine * phi.sin(), half.y - half.x, -sine * phi.cos())
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

impl Around<'_> {
    /// The mean of what texels have.
    #[inline]
    pub(super) fn mean(&self, value: impl Fn(Vec3) -> Vec3) -> Vec3 {
        self.texels.iter().zip(self.weights).map(|(texel, weight)| value(**texel) * weight).sum()
    }

    /// The same of a number.
    #[inline]
    pub(super) fn mean_number(&self, value: impl Fn(Vec3) -> f64) -> f64 {
        self.texels.iter().zip(self.weights).map(|(texel, weight)| value(**texel) * f64::from(weight)).sum()
    }
}
