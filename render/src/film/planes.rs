//! A film's channels: what its sums say of each pixel.

use super::tile::{FEATURE_NAMES, Tile};
use super::{Channel, Film};

/// The names of the colours.
const COLORS: [&str; 3] = ["R", "G", "B"];

impl Film {
    /// The channels, with alpha if the film has a border.
    pub(super) fn channels(&self) -> Vec<Channel> {
        let mut channels = Vec::new();
        let mut push = |name: String, value: &dyn Fn(&Tile, usize) -> f64| channels.push(self.plane(name, value));
        for (c, color) in COLORS.into_iter().enumerate() {
            push(color.to_owned(), &|tile, pixel| f64::from(tile.radiance(pixel)[c]));
        }
        if self.header.has_border {
            push("A".to_owned(), &Tile::alpha);
        }
        if self.header.aov {
            for (f, name) in FEATURE_NAMES.into_iter().enumerate() {
                push(name.to_owned(), &|tile, pixel| tile.pixels[pixel].mean_of(tile.features[pixel][f]));
            }
            for (c, color) in COLORS.into_iter().enumerate() {
                push(format!("Variance.{color}"), &|tile, pixel| tile.variance(pixel, c));
            }
        }
        if self.header.halves {
            for (half, name) in ["HalfA", "HalfB"].into_iter().enumerate() {
                for (c, color) in COLORS.into_iter().enumerate() {
                    let mean = |tile: &Tile, pixel| tile.halves(pixel).map_or(0.0, |halves| halves[half].mean()[c]);
                    push(format!("{name}.{color}"), &mean);
                }
            }
        }
        channels
    }

    /// A channel of these values.
    fn plane(&self, name: String, value: &dyn Fn(&Tile, usize) -> f64) -> Channel {
        let (width, height) = (self.header.width as usize, self.header.height as usize);
        let mut values = vec![0.0; width * height];
        for tile in &self.tiles {
            for (number, (x, y)) in tile.pixels().enumerate() {
                values[y as usize * width + x as usize] = value(tile, number) as f32;
            }
        }
        Channel { name, values }
    }
}
