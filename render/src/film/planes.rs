//! A film's channels, computed from its sums.

use super::tile::{FEATURE_NAMES, Tile};
use super::{Channel, Film};

/// The names of the colours.
pub(crate) const COLORS: [&str; 3] = ["R", "G", "B"];

/// The channels of first hits and samples.
const DEPTH: &str = "Depth.Z";
const IDS: [&str; 4] = ["Id.Object", "Id.Material", "Id.Triangle", "Id.Instance"];
/// As compositors call it (Foundry's Nuke).
const MOTION: [&str; 2] = ["forward.u", "forward.v"];
const SAMPLES: &str = "Samples.Y";

/// Whether a channel is there because denoising needs it.
pub(crate) fn is_for_denoising(name: &str) -> bool {
    let layer = name.split_once('.').map_or("", |(layer, _)| layer);
    FEATURE_NAMES.contains(&name)
        || ["Variance", "HalfA", "HalfB", "UV", "Depth", "Id", "forward", "Samples"].contains(&layer)
}

impl Film {
    /// The channels of names that are wanted, with alpha if the film has a border.
    pub(super) fn channels(&self, wants: &dyn Fn(&str) -> bool) -> Vec<Channel> {
        let mut channels = Vec::new();
        let mut push = |name: String, value: &dyn Fn(&Tile, usize) -> f64| {
            if wants(&name) {
                channels.push(self.plane(name, value));
            }
        };
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
            for (name, feature) in ["UV.U", "UV.V"].into_iter().zip(FEATURE_NAMES.len() - 2..) {
                push(name.to_owned(), &|tile, pixel| tile.pixels[pixel].mean_of(tile.features[pixel][feature]));
            }
            push(DEPTH.to_owned(), &|tile, pixel| tile.first_hits[pixel].depth.into());
            for (number, name) in IDS.into_iter().enumerate() {
                push(name.to_owned(), &|tile, pixel| tile.first_hits[pixel].ids[number].into());
            }
            for (axis, name) in MOTION.into_iter().enumerate() {
                push(name.to_owned(), &|tile, pixel| tile.first_hits[pixel].motion[axis].into());
            }
            push(SAMPLES.to_owned(), &|tile, _| tile.samples.len() as f64);
            for (c, color) in COLORS.into_iter().enumerate() {
                push(format!("Variance.{color}"), &|tile, pixel| tile.variance(pixel, c));
            }
        }
        for (number, name) in self.header.light.iter().enumerate() {
            for (c, color) in COLORS.into_iter().enumerate() {
                let mean = |tile: &Tile, pixel: usize| tile.pixels[pixel].mean_of(tile.light[pixel][number][c]);
                push(format!("{name}.{color}"), &mean);
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
        channels.extend(self.matte_channels().into_iter().filter(|channel| wants(&channel.name)));
        channels
    }

    /// How many samples each pixel has, row by row from the top.
    pub(crate) fn sample_counts(&self) -> Vec<f32> {
        self.plane(String::new(), &|tile, _| tile.samples.len() as f64).values
    }

    /// The estimated relative error of each pixel's tile, row by row from the top; `None` where
    /// [`relative_error`](Self::relative_error) is.
    pub(crate) fn relative_errors(&self) -> Option<Vec<f32>> {
        self.relative_error()?;
        let level = self.header.level?;
        let mut errors = vec![f32::NAN; self.header.width as usize * self.header.height as usize];
        for tile in &self.tiles {
            let error = tile.relative_error(level).map_or(f32::NAN, |error| error as f32);
            tile.pixels().for_each(|(x, y)| errors[y as usize * self.header.width as usize + x as usize] = error);
        }
        Some(errors)
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
