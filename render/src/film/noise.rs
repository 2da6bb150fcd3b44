//! The noise of a film, estimated from the two halves of its samples.
//!
//! The halves are independent estimates `a` and `b` of a pixel, of weights `p` and `q` that sum to 1, so that the
//! variance of the pixel, `p a + q b`, is estimated without bias by `p q (a - b)²`. One pixel's estimate is inaccurate;
//! a tile's mean over 1024 is accurate. Errors are relative to the luminance of the darker half, as a firefly would
//! otherwise hide its own error, and to no less than a tenth of the film's level: the squared mean of the roots of the
//! first samples' luminance, which bright lamps hardly affect.

use glam::DVec3;

use super::tile::Tile;
use super::{Film, LUMINANCE};

/// Below this part of the film's level errors are as visible as at it.
const FLOOR: f64 = 0.1;

fn luminance(color: [f64; 3]) -> f64 {
    DVec3::from_array(color).dot(LUMINANCE)
}

impl Film {
    /// The level of what the first samples see; `None` before every pixel has one.
    pub(crate) fn level(&self) -> Option<f64> {
        let mut roots = 0.0;
        for tile in &self.tiles {
            if tile.samples.is_empty() {
                return None;
            }
            roots += tile.pixels.iter().map(|pixel| luminance(pixel.mean()).max(0.0).sqrt()).sum::<f64>();
        }
        let mean = roots / (f64::from(self.header.width) * f64::from(self.header.height));
        Some(mean * mean)
    }

    /// The estimated relative error of the picture: the root of the pixels' mean squared error. `None` without halves,
    /// or before both have samples.
    pub fn relative_error(&self) -> Option<f64> {
        let level = self.header.level?;
        let mut sum = 0.0;
        for tile in self.tiles.iter().filter(|tile| !tile.samples.is_empty()) {
            sum += tile.relative_error(level)?.powi(2) * tile.pixels.len() as f64;
        }
        let pixels: usize =
            self.tiles.iter().filter(|tile| !tile.samples.is_empty()).map(|tile| tile.pixels.len()).sum();
        Some((sum / pixels.max(1) as f64).sqrt())
    }
}

impl Tile {
    /// The root of the mean squared relative error of its pixels, in a film of this level. `None` without halves, or
    /// before both have samples.
    pub(crate) fn relative_error(&self, level: f64) -> Option<f64> {
        if self.halves.is_empty() || self.samples.len() < 16 {
            return None;
        }
        let squared = |number: usize| {
            let [a, b] = self.halves(number)?;
            let (p, q) = (self.pixels[number].mean_of(a.weight), self.pixels[number].mean_of(b.weight));
            let (a, b) = (luminance(a.mean()), luminance(b.mean()));
            let variance = p * q * (a - b) * (a - b);
            let seen = a.min(b).max(FLOOR * level);
            Some(if variance > 0.0 { variance / (seen * seen) } else { 0.0 })
        };
        let count = self.pixels.len();
        let sum: f64 = (0..count).map(squared).sum::<Option<f64>>()?;
        Some((sum / count as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::film::{Extras, FilterSample, tiles};

    /// A tile of two pixels whose samples have these luminances.
    fn tile(samples: u32, value: impl Fn(usize, u32) -> f32) -> Tile {
        let mut tile = tiles(2, 1, Extras { halves: true, ..Extras::default() }).remove(0);
        let filter = FilterSample { offset: [0.0; 2], weight: 1.0 };
        for sample in 0..samples {
            (0..2).for_each(|pixel| tile.add(pixel, sample, &filter, Vec3::splat(value(pixel, sample))));
        }
        tile.samples = 0..samples;
        tile
    }

    /// One sample of 32 is a thousand times too bright: about 32 times too much, which must be reported.
    #[test]
    fn bright_dots_do_not_excuse_themselves() {
        let dot = tile(32, |pixel, sample| if (pixel, sample) == (0, 5) { 1000.0 } else { 1.0 });
        let error = dot.relative_error(1.0).unwrap();
        assert!(error > 10.0, "{error}");
        // A lamp of a pixel's size is no dot: its halves are 99 and 101.
        let is_first = crate::film::tile::is_in_first_half;
        let lamp = tile(32, |pixel, sample| match pixel {
            0 => {
                if is_first(sample) {
                    99.0
                } else {
                    101.0
                }
            }
            _ => 1.0,
        });
        let error = lamp.relative_error(1.0).unwrap();
        let expected = (0.5f64 * 0.25 * (2.0f64 / 99.0).powi(2)).sqrt();
        assert!((error - expected).abs() < 1e-6, "{error}, {expected}");
        assert_eq!(tile(32, |_, _| 0.0).relative_error(1.0), Some(0.0));
    }

    #[test]
    fn dark_pixels_are_held_against_the_level() {
        let is_first = crate::film::tile::is_in_first_half;
        let dark = tile(32, |_, sample| if is_first(sample) { 0.0 } else { 0.01 });
        let error = dark.relative_error(1.0).unwrap();
        assert!((error - 0.005 / FLOOR).abs() < 1e-6, "{error}");
        assert_eq!(tile(8, |_, _| 1.0).relative_error(1.0), None, "too few");
    }
}
