//! A picture between its texels: bilinear, around and over the poles' rows, as other renderers show it.
//!
//! A place has a column `x` and a row `y`. Columns are even in azimuth; within a row, `y` is even in solid angle, so that a
//! density over places is one per solid angle but for a factor that each row has. What a texel counts for is a tent about its
//! middle, one texel to each side; at the poles what is beyond is folded back.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use crate::scene::SkyPicture;

/// The texels around a place, and their weights, whose sum is 1.
pub(super) struct Around<'a> {
    texels: [&'a Vec3; 4],
    weights: [f32; 4],
}

impl<'a> Around<'a> {
    /// In the direction of a unit vector.
    #[inline]
    pub(super) fn new(picture: &'a SkyPicture, direction: Vec3) -> Self {
        let (width, height) = (picture.width as usize, picture.height as usize);
        let place = place(picture, direction) - 0.5;
        let floor = place.floor();
        let part = place - floor;
        let left = (floor.x as i64).rem_euclid(width as i64) as usize;
        let right = if left + 1 == width { 0 } else { left + 1 };
        // From -1 for what is above the middle of the first row.
        let [above, below] = [floor.y, floor.y + 1.0].map(|row| (row.max(0.0) as usize).min(height - 1));
        let texel = |row: usize, column: usize| &picture.texels[row * width + column];
        Self {
            texels: [texel(above, left), texel(above, right), texel(below, left), texel(below, right)],
            weights: [
                (1.0 - part.x) * (1.0 - part.y),
                part.x * (1.0 - part.y),
                (1.0 - part.x) * part.y,
                part.x * part.y,
            ],
        }
    }

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

/// The place in a direction: its column and row, with what is within them as fractions.
pub(super) fn place(picture: &SkyPicture, direction: Vec3) -> Vec2 {
    let (width, height) = (picture.width as f32, picture.height as f32);
    let phi = direction.x.atan2(-direction.z) + picture.rotation;
    let across = (phi / TAU + 0.5).rem_euclid(1.0) * width;
    // More exact near the poles than the arc cosine.
    let theta = Vec2::new(direction.x, direction.z).length().atan2(direction.y);
    let row = (theta * height / PI).floor().clamp(0.0, height - 1.0);
    let [above, below] = [row, row + 1.0].map(|row| PI * row / height);
    // cos a - cos b = 2 sin((a + b) / 2) sin((b - a) / 2).
    let down = (0.5 * (theta + above)).sin() * (0.5 * (theta - above)).sin();
    let all = (0.5 * (below + above)).sin() * (0.5 * (below - above)).sin();
    Vec2::new(across, row + (down / all).clamp(0.0, 1.0))
}

/// The direction to a place; columns go around.
pub(super) fn direction_to(picture: &SkyPicture, place: Vec2) -> Vec3 {
    let (width, height) = (picture.width as f32, picture.height as f32);
    let row = place.y.floor().clamp(0.0, height - 1.0);
    // Half of 1 - cos and of 1 + cos, as cosines near the poles are all 1.
    let halves = |row: f32| {
        let (sin, cos) = (0.5 * PI * row / height).sin_cos();
        Vec2::new(sin * sin, cos * cos)
    };
    let half = halves(row).lerp(halves(row + 1.0), (place.y - row).clamp(0.0, 1.0));
    let sine = 2.0 * (half.x * half.y).sqrt();
    let phi = TAU * (place.x / width - 0.5) - picture.rotation;
    Vec3::new(sine * phi.sin(), half.y - half.x, -sine * phi.cos())
}

/// A place by the tent of a texel, in proportion to solid angle, for numbers in [0, 1).
pub(super) fn place_in_tent(picture: &SkyPicture, (column, row): (u32, u32), u: Vec2) -> Vec2 {
    let across = match u.x < 0.5 {
        true => (2.0 * u.x).sqrt() - 1.0,
        false => 1.0 - (2.0 * (1.0 - u.x)).sqrt(),
    };
    let [above, own, below] = picture.row_solid_angles(row).map(|part| part as f32);
    let number = u.y * (above + own + below);
    let down = match () {
        () if number < above => -1.0 + 0.5 * (number / above).sqrt(),
        () if number < above + own => {
            let part = 2.0 * (number - above) / own - 1.0;
            (1.0 - (1.0 - 0.75 * part.abs()).max(0.25).sqrt()).copysign(part)
        }
        () => 1.0 - 0.5 * (1.0 - (number - above - own) / below).max(0.0).sqrt(),
    };
    let (y, height) = (row as f32 + 0.5 + down, picture.height as f32);
    let folded = if y < 0.0 {
        -y
    } else if y > height {
        2.0 * height - y
    } else {
        y
    };
    Vec2::new(column as f32 + 0.5 + across, folded)
}
