//! Tiles: the film's squares of pixels, and the sums of their samples.

use std::ops::Range;

use glam::{Vec2, Vec3};

use super::{Channel, FilterSample};

/// Pixels along a tile's side.
pub(crate) const TILE_SIDE: u32 = 32;

/// What the first surface along a camera ray is.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Features {
    pub albedo: Vec3,
    pub position: Vec3,
    pub normal: Vec3,
    pub shading_normal: Vec3,
    pub uv: Vec2,
}

/// A square of pixels, cut off at the film's border.
#[derive(Clone, Debug)]
pub(crate) struct Tile {
    x: Range<u32>,
    y: Range<u32>,
    pixels: Vec<Pixel>,
    /// Weighted sums of [`Features`] for each pixel; empty if they are not asked for.
    features: Vec<[f64; FEATURE_NAMES.len()]>,
    /// For each pixel the weights of samples that see nothing; empty if there are none.
    blind: Vec<f64>,
    /// Samples that every pixel has.
    pub samples: u32,
}

/// Weighted sums over a pixel's samples, in the order of the samples.
#[derive(Clone, Copy, Debug, Default)]
struct Pixel {
    weight: f64,
    radiance: [f64; 3],
    /// Zero on tiles that are not made for features.
    radiance_squared: [f64; 3],
}

const FEATURE_NAMES: [&str; 14] =
    ["Albedo.R", "Albedo.G", "Albedo.B", "P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z", "Ns.X", "Ns.Y", "Ns.Z", "u", "v"];

impl Features {
    fn values(&self) -> [f32; FEATURE_NAMES.len()] {
        let [a, p, n, s] = [self.albedo, self.position, self.normal, self.shading_normal].map(|v| v.to_array());
        [a[0], a[1], a[2], p[0], p[1], p[2], n[0], n[1], n[2], s[0], s[1], s[2], self.uv.x, self.uv.y]
    }
}

/// The tiles of a film, row by row; with `features` they hold those of the first surface too.
pub(crate) fn tiles(width: u32, height: u32, features: bool) -> Vec<Tile> {
    let starts = |end: u32| (0..end).step_by(TILE_SIDE as usize);
    let range = |start: u32, end: u32| start..start.saturating_add(TILE_SIDE).min(end);
    let tile = |x: u32, y: u32| {
        let (x, y) = (range(x, width), range(y, height));
        let pixels = vec![Pixel::default(); x.len() * y.len()];
        let features = if features { vec![[0.0; FEATURE_NAMES.len()]; pixels.len()] } else { Vec::new() };
        Tile { x, y, pixels, features, blind: Vec::new(), samples: 0 }
    };
    starts(height).flat_map(|y| starts(width).map(move |x| tile(x, y))).collect()
}

impl Tile {
    /// The pixels' coordinates, in the order in which [`add`](Self::add) numbers them.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let (columns, rows) = (self.x.clone(), self.y.clone());
        rows.flat_map(move |y| columns.clone().map(move |x| (x, y)))
    }

    /// Adds a sample to the pixel of this number. One that is not a number counts as black.
    pub(crate) fn add(&mut self, pixel: usize, filter: &FilterSample, radiance: Vec3) {
        let sums = &mut self.pixels[pixel];
        let weight = f64::from(filter.weight);
        sums.weight += weight;
        let radiance = if radiance.is_finite() { radiance } else { Vec3::ZERO };
        for (channel, value) in radiance.to_array().into_iter().enumerate() {
            sums.radiance[channel] += weight * f64::from(value);
        }
    }

    /// Adds a sample at which the film sees nothing to the pixel of this number.
    pub(crate) fn add_blind(&mut self, pixel: usize, filter: &FilterSample) {
        self.blind.resize(self.pixels.len(), 0.0);
        self.blind[pixel] += f64::from(filter.weight);
        self.pixels[pixel].weight += f64::from(filter.weight);
    }

    /// The part of a pixel that sees anything, 1 without samples.
    fn alpha(&self, pixel: usize) -> f64 {
        let blind = self.blind.get(pixel).map_or(0.0, |&weight| self.pixels[pixel].mean(weight));
        (1.0 - blind).clamp(0.0, 1.0)
    }

    /// The linear radiance of the pixel of this number; black without samples.
    pub(crate) fn radiance(&self, pixel: usize) -> [f32; 3] {
        let pixel = &self.pixels[pixel];
        pixel.radiance.map(|sum| pixel.mean(sum) as f32)
    }

    /// Its columns and rows.
    pub(crate) fn extent(&self) -> (Range<u32>, Range<u32>) {
        (self.x.clone(), self.y.clone())
    }

    /// Adds what the variance of a sample that is [added](Self::add) depends on, and what its first surface is; only on
    /// tiles made for it.
    pub(crate) fn add_features(&mut self, pixel: usize, filter: &FilterSample, radiance: Vec3, features: &Features) {
        let radiance = if radiance.is_finite() { radiance } else { Vec3::ZERO };
        for (sum, value) in self.pixels[pixel].radiance_squared.iter_mut().zip(radiance.to_array()) {
            *sum += f64::from(value).powi(2) * f64::from(filter.weight).powi(2);
        }
        for (sum, value) in self.features[pixel].iter_mut().zip(features.values()) {
            *sum += f64::from(filter.weight) * f64::from(value);
        }
    }
}

/// The channels of a film of `width` by `height` pixels, with alpha if it `has_border`.
pub(crate) fn channels(tiles: &[Tile], width: u32, height: u32, has_border: bool) -> Vec<Channel> {
    let plane = |name: &str, value: &dyn Fn(&Tile, usize) -> f64| {
        let mut values = vec![0.0; width as usize * height as usize];
        for tile in tiles {
            for (number, (x, y)) in tile.pixels().enumerate() {
                values[y as usize * width as usize + x as usize] = value(tile, number) as f32;
            }
        }
        Channel { name: name.to_owned(), values }
    };
    let colors = ["R", "G", "B"].into_iter().enumerate();
    let mut channels: Vec<Channel> =
        colors.clone().map(|(c, name)| plane(name, &|tile, pixel| f64::from(tile.radiance(pixel)[c]))).collect();
    if has_border {
        channels.push(plane("A", &Tile::alpha));
    }
    if tiles.iter().any(|tile| !tile.features.is_empty()) {
        for (f, name) in FEATURE_NAMES.into_iter().enumerate() {
            channels.push(plane(name, &|tile, pixel| tile.pixels[pixel].mean(tile.features[pixel][f])));
        }
        for (c, name) in colors {
            let variance = |tile: &Tile, pixel: usize| tile.pixels[pixel].variance(c, f64::from(tile.samples));
            channels.push(plane(&format!("Variance.{name}"), &variance));
        }
    }
    channels
}

impl Pixel {
    /// A weighted sum over the weights; zero without samples.
    fn mean(&self, sum: f64) -> f64 {
        if self.weight == 0.0 { 0.0 } else { sum / self.weight }
    }

    /// The estimated variance of the pixel's value: that of `n` samples' mean, had they been independent.
    fn variance(&self, channel: usize, n: f64) -> f64 {
        if n < 2.0 || self.weight == 0.0 {
            return 0.0;
        }
        let scale = n / self.weight;
        let mean = self.mean(self.radiance[channel]);
        let mean_square = self.radiance_squared[channel] * scale * scale / n;
        (mean_square - mean * mean).max(0.0) / (n - 1.0)
    }
}
