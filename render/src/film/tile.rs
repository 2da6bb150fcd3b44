//! Tiles: the film's squares of pixels, and the sums of their samples.

use std::ops::Range;

use glam::{Vec2, Vec3};

use super::FilterSample;
use super::cryptomatte::{Coverage, NO_NAME};
use super::sum::{PositiveSum, Sum};

/// Pixels along a tile's side.
pub(crate) const TILE_SIDE: u32 = 32;

/// Samples in a row that belong to the same half: as many as a stratified set of two dimensions has at least.
const HALF_BLOCK: u32 = 4;

/// The first surface along a camera ray.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Features {
    pub albedo: Vec3,
    pub position: Vec3,
    pub normal: Vec3,
    pub shading_normal: Vec3,
    pub uv: Vec2,
}

/// The first surface along a pixel's first camera ray: what no filter can average.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FirstHit {
    /// The sample; [`NO_SAMPLE`](Self::NO_SAMPLE) before there is one.
    pub sample: u32,
    /// Along the view of a flat camera, from the eye of others; [`NO_DEPTH`](Self::NO_DEPTH) where nothing is hit.
    pub depth: f32,
    /// Numbers of the object, the material, the triangle in the object, and the instance, from 1; 0 where nothing is
    /// hit, or what is in no instance.
    pub ids: [u32; 4],
    /// How many pixels what is hit moves to the right and up while the shutter is open.
    pub motion: [f32; 2],
}

impl FirstHit {
    pub(crate) const NO_SAMPLE: u32 = u32::MAX;
    /// As Blender has it.
    pub(crate) const NO_DEPTH: f32 = 1e10;
    pub(crate) const NONE: Self =
        Self { sample: Self::NO_SAMPLE, depth: Self::NO_DEPTH, ids: [0; 4], motion: [0.0; 2] };
}

/// The contents of a film besides radiance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Extras {
    /// [`Features`], and the variance of the samples.
    pub features: bool,
    /// Sums of half of the samples.
    pub halves: bool,
    /// How many Cryptomatte layers.
    pub mattes: usize,
    /// How many AOVs by light path expressions.
    pub light: usize,
}

/// A square of pixels, cut off at the film's border.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tile {
    x: Range<u32>,
    y: Range<u32>,
    pub(super) pixels: Vec<Pixel>,
    /// The sums of the first half alone; empty if they are not asked for.
    pub(super) halves: Vec<Pixel>,
    /// Sums of [`Features`]; empty if they are not asked for.
    pub(super) features: Vec<[Sum; FEATURE_NAMES.len()]>,
    /// The hits of the first samples; empty if they are not asked for.
    pub(super) first_hits: Vec<FirstHit>,
    /// Sums of squared radiance; empty if they are not asked for.
    pub(super) squares: Vec<[PositiveSum; 3]>,
    /// The AOVs by light path expressions of each pixel.
    pub(super) light: Vec<Vec<[Sum; 3]>>,
    /// The coverage of pixels in each Cryptomatte layer.
    pub(super) mattes: Vec<Vec<Coverage>>,
    /// The weights of each pixel's samples without a ray; empty if there are none.
    pub(super) uncovered: Vec<Sum>,
    /// Samples that every pixel has, by their indices.
    pub samples: Range<u32>,
    /// Samples that are not numbers.
    pub(super) bad: BadSamples,
}

/// Weighted sums over a pixel's samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Pixel {
    pub(super) weight: Sum,
    pub(super) radiance: [Sum; 3],
}

/// Samples whose radiance is no finite number: they count as black.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BadSamples {
    /// How many there are.
    pub count: u64,
    /// The first pixel that has one, row by row: its row and its column.
    pub first: Option<(u32, u32)>,
}

pub(super) const FEATURE_NAMES: [&str; 14] =
    ["Albedo.R", "Albedo.G", "Albedo.B", "P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z", "Ns.X", "Ns.Y", "Ns.Z", "u", "v"];

impl Features {
    fn values(&self) -> [f32; FEATURE_NAMES.len()] {
        let [a, p, n, s] = [self.albedo, self.position, self.normal, self.shading_normal].map(|v| v.to_array());
        [a[0], a[1], a[2], p[0], p[1], p[2], n[0], n[1], n[2], s[0], s[1], s[2], self.uv.x, self.uv.y]
    }
}

impl BadSamples {
    /// These and others.
    pub(super) fn and(self, other: Self) -> Self {
        Self { count: self.count + other.count, first: self.first.into_iter().chain(other.first).min() }
    }
}

/// Whether a sample belongs to the first half: blocks of samples are dealt out by the Thue-Morse sequence, so that the
/// halves have as many and are stratified alike, whatever the number of samples.
pub(crate) fn is_in_first_half(sample: u32) -> bool {
    (sample / HALF_BLOCK).count_ones().is_multiple_of(2)
}

/// The tiles of a film, row by row.
pub(crate) fn tiles(width: u32, height: u32, extras: Extras) -> Vec<Tile> {
    let starts = |end: u32| (0..end).step_by(TILE_SIDE as usize);
    let range = |start: u32, end: u32| start..start.saturating_add(TILE_SIDE).min(end);
    let tile = |x: u32, y: u32| {
        let (x, y) = (range(x, width), range(y, height));
        let count = x.len() * y.len();
        let of = |is_there: bool| if is_there { count } else { 0 };
        Tile {
            x,
            y,
            pixels: vec![Pixel::default(); count],
            halves: vec![Pixel::default(); of(extras.halves)],
            features: vec![[Sum::default(); FEATURE_NAMES.len()]; of(extras.features)],
            first_hits: vec![FirstHit::NONE; of(extras.features)],
            squares: vec![[PositiveSum::default(); 3]; of(extras.features)],
            light: vec![vec![[Sum::default(); 3]; extras.light]; of(extras.light > 0)],
            mattes: vec![vec![Coverage::default(); count]; extras.mattes],
            uncovered: Vec::new(),
            samples: 0..0,
            bad: BadSamples::default(),
        }
    };
    starts(height).flat_map(|y| starts(width).map(move |x| tile(x, y))).collect()
}

impl Tile {
    /// The pixels' coordinates, in the order in which [`add`](Self::add) numbers them.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let (columns, rows) = (self.x.clone(), self.y.clone());
        rows.flat_map(move |y| columns.clone().map(move |x| (x, y)))
    }

    /// Adds a sample to the pixel of this index. One that is not a number counts as black.
    #[inline]
    pub(crate) fn add(&mut self, pixel: usize, sample: u32, filter: &FilterSample, radiance: Vec3) {
        let radiance = if radiance.is_finite() { radiance } else { self.add_bad(pixel) };
        self.pixels[pixel].add(filter.weight, radiance);
        if !self.halves.is_empty() && is_in_first_half(sample) {
            self.halves[pixel].add(filter.weight, radiance);
        }
    }

    /// Notes a sample that is not a number; gives what it counts as.
    #[cold]
    fn add_bad(&mut self, pixel: usize) -> Vec3 {
        let (column, row) = (pixel % self.x.len(), pixel / self.x.len());
        let place = (self.y.start + row as u32, self.x.start + column as u32);
        self.bad = self.bad.and(BadSamples { count: 1, first: Some(place) });
        Vec3::ZERO
    }

    /// Adds a sample without a ray to the pixel of this index.
    pub(crate) fn add_uncovered(&mut self, pixel: usize, sample: u32, filter: &FilterSample) {
        self.uncovered.resize(self.pixels.len(), Sum::default());
        self.uncovered[pixel].add(filter.weight.into());
        for layer in 0..self.mattes.len() {
            self.add_name(layer, pixel, filter, NO_NAME);
        }
        self.add(pixel, sample, filter, Vec3::ZERO);
    }

    /// Adds what the variance of a sample that is [added](Self::add) depends on, and what its first surface is; only on
    /// tiles made for it.
    pub(crate) fn add_features(&mut self, pixel: usize, filter: &FilterSample, radiance: Vec3, features: &Features) {
        let radiance = if radiance.is_finite() { radiance } else { Vec3::ZERO };
        for (sum, value) in self.squares[pixel].iter_mut().zip(radiance.to_array()) {
            sum.add((f64::from(value) * f64::from(filter.weight)).powi(2));
        }
        for (sum, value) in self.features[pixel].iter_mut().zip(features.values()) {
            sum.add(f64::from(filter.weight) * f64::from(if value.is_finite() { value } else { 0.0 }));
        }
    }

    /// Adds what AOVs by light path expressions have of a sample that is [added](Self::add); nothing of one that is not
    /// a number.
    pub(crate) fn add_light(&mut self, pixel: usize, filter: &FilterSample, radiance: Vec3, light: &[Vec3]) {
        if !radiance.is_finite() {
            return;
        }
        for (sums, light) in self.light[pixel].iter_mut().zip(light) {
            for (sum, value) in sums.iter_mut().zip(light.to_array()) {
                sum.add(f64::from(filter.weight) * f64::from(value));
            }
        }
    }

    /// Adds the name that a sample shows to a Cryptomatte layer.
    pub(crate) fn add_name(&mut self, layer: usize, pixel: usize, filter: &FilterSample, id: u32) {
        self.mattes[layer][pixel].add(id, filter.weight);
    }

    /// Whether a sample comes before all whose hits were taken; only on tiles made for it.
    pub(crate) fn is_first(&self, pixel: usize, sample: u32) -> bool {
        sample < self.first_hits[pixel].sample
    }

    /// Takes the hit of a sample, if it is the pixel's first; only on tiles made for it.
    pub(crate) fn add_hit(&mut self, pixel: usize, hit: FirstHit) {
        if self.is_first(pixel, hit.sample) {
            self.first_hits[pixel] = hit;
        }
    }

    /// The linear radiance of the pixel of this index; black without samples.
    pub(crate) fn radiance(&self, pixel: usize) -> [f32; 3] {
        let [red, green, blue] = self.pixels[pixel].mean();
        [red as f32, green as f32, blue as f32]
    }

    /// The part of a pixel that sees anything, 1 without samples.
    pub(super) fn alpha(&self, pixel: usize) -> f64 {
        let uncovered = self.uncovered.get(pixel).map_or(0.0, |&weight| self.pixels[pixel].mean_of(weight));
        (1.0 - uncovered).clamp(0.0, 1.0)
    }

    /// The sums of a pixel's halves; nothing on tiles that are not made for it.
    pub(super) fn halves(&self, pixel: usize) -> Option<[Pixel; 2]> {
        let first = *self.halves.get(pixel)?;
        Some([first, self.pixels[pixel].without(&first)])
    }

    /// The estimated variance of the pixel's value: that of its samples' mean, had they been independent.
    pub(super) fn variance(&self, pixel: usize, channel: usize) -> f64 {
        let (sums, n) = (&self.pixels[pixel], self.samples.len() as f64);
        if n < 2.0 || sums.weight == Sum::default() {
            return 0.0;
        }
        let scale = n / sums.weight.value();
        let mean_square = self.squares[pixel][channel].value() * scale * scale / n;
        (mean_square - sums.mean()[channel].powi(2)).max(0.0) / (n - 1.0)
    }

    /// Its columns and rows.
    pub(crate) fn extent(&self) -> (Range<u32>, Range<u32>) {
        (self.x.clone(), self.y.clone())
    }
}

impl Pixel {
    #[inline]
    fn add(&mut self, weight: f32, radiance: Vec3) {
        let weight = f64::from(weight);
        self.weight.add(weight);
        for (sum, value) in self.radiance.iter_mut().zip(radiance.to_array()) {
            sum.add(weight * f64::from(value));
        }
    }

    /// All but the sums of a part.
    fn without(&self, part: &Self) -> Self {
        let radiance = std::array::from_fn(|c| self.radiance[c].without(part.radiance[c]));
        Self { weight: self.weight.without(part.weight), radiance }
    }

    /// Its radiance.
    pub(super) fn mean(&self) -> [f64; 3] {
        let [red, green, blue] = self.radiance;
        [self.mean_of(red), self.mean_of(green), self.mean_of(blue)]
    }

    /// A sum over the weights; zero without samples.
    pub(super) fn mean_of(&self, sum: Sum) -> f64 {
        if self.weight == Sum::default() { 0.0 } else { sum.value() / self.weight.value() }
    }
}
