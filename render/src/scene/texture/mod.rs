//! Textures: texels as stored in their file, looked up as linear values.
//!
//! A picture has one to four channels (grey; grey and alpha; red, green and blue; all four) of 8 or 16 bits or of
//! 32-bit floats, and is stored unconverted: 8 bits stay 8 bits. Colours in sRGB are decoded at each lookup by a table.
//! A lookup is a function of the map and the texture coordinates alone.
//!
//! Filtering is bilinear or none; it mixes linear colours. Deviation: there are no mip levels: the samples of a pixel
//! average over distant texels.

mod brightness;
mod decode;
mod error;
#[cfg(feature = "ktx2")]
mod ktx2;
mod map;
mod store;

use std::sync::LazyLock;

use glam::{DVec4, IVec2, Vec2, Vec4};

pub(crate) use brightness::BrightnessTable;
pub(crate) use decode::decode;
pub use map::{ColorSpace, TextureFilter, TextureMap, Wrap};
pub(crate) use store::{Problem, TextureStore};

/// A picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    width: u32,
    height: u32,
    /// Numbers for each texel, 1 to 4.
    channels: usize,
    texels: Texels,
    /// The mean of all texels as sRGB and as linear numbers.
    means: [Vec4; 2],
}

/// The numbers of all texels, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Texels {
    /// 0 to 255 for 0 to 1.
    U8(Vec<u8>),
    /// 0 to 65,535 for 0 to 1.
    U16(Vec<u16>),
    /// Finite numbers.
    F32(Vec<f32>),
}

impl Texels {
    /// Floats, with 0 for what is not finite.
    fn finite(numbers: impl IntoIterator<Item = f32>) -> Self {
        Self::F32(numbers.into_iter().map(|number| if number.is_finite() { number } else { 0.0 }).collect())
    }
}

impl Texture {
    /// A picture of these texels, red, green, blue and alpha of 8 bits, row by row from the top.
    ///
    /// # Panics
    /// If there are none, or not as many as the size says.
    pub fn new(width: u32, height: u32, texels: Vec<[u8; 4]>) -> Self {
        Self::from_texels(width, height, 4, Texels::U8(texels.into_flattened()))
    }

    /// A picture of `channels` numbers a texel.
    ///
    /// # Panics
    /// If there are no texels, or not as many as the size says.
    pub(crate) fn from_texels(width: u32, height: u32, channels: usize, texels: Texels) -> Self {
        let count = width as usize * height as usize;
        assert!(count > 0 && (1..=4).contains(&channels) && texels.len() == count * channels, "texels of all");
        let mut texture = Self { width, height, channels, texels, means: [Vec4::ZERO; 2] };
        texture.means = [ColorSpace::Srgb, ColorSpace::Linear].map(|space| {
            let sum: DVec4 = (0..count).map(|index| texture.fetch(space, index).as_dvec4()).sum();
            (sum / count as f64).as_vec4()
        });
        texture
    }

    /// The mean of all texels as sRGB: linear colour and alpha.
    pub fn mean(&self) -> Vec4 {
        self.mean_in(ColorSpace::Srgb)
    }

    /// The mean of all texels, in linear numbers.
    pub(crate) fn mean_in(&self, space: ColorSpace) -> Vec4 {
        self.means[usize::from(space == ColorSpace::Linear)]
    }

    /// Pixels across and down.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Numbers for each texel.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Bits of each number: 8, 16 or 32.
    pub fn bits(&self) -> usize {
        match self.texels {
            Texels::U8(_) => 8,
            Texels::U16(_) => 16,
            Texels::F32(_) => 32,
        }
    }

    /// Bytes that the texels take.
    pub fn bytes(&self) -> usize {
        self.texel_bytes().len()
    }

    /// All texels as they lie in memory.
    pub(super) fn texel_bytes(&self) -> &[u8] {
        match &self.texels {
            Texels::U8(texels) => texels,
            Texels::U16(texels) => bytemuck::cast_slice(texels),
            Texels::F32(texels) => bytemuck::cast_slice(texels),
        }
    }

    /// Red, green, blue and alpha, in linear numbers, at texture coordinates.
    pub(crate) fn sample(&self, map: &TextureMap, texcoord: Vec2) -> Vec4 {
        let place = map.place(texcoord) * Vec2::new(self.width as f32, self.height as f32);
        if map.filter == TextureFilter::Nearest {
            return self.texel(map, place.floor());
        }
        let corner = (place - 0.5).floor();
        let part = place - 0.5 - corner;
        let IVec2 { x, y } = corner.as_ivec2();
        let column = |x: i32| map.wrap[0].within(x, self.width);
        let row = |y: i32| map.wrap[1].within(y, self.height) * self.width as usize;
        let (left, right, upper, lower) = (column(x), column(x.saturating_add(1)), row(y), row(y.saturating_add(1)));
        let [a, b, c, d] = self.fetch_all(map.space, [upper + left, upper + right, lower + left, lower + right]);
        let color = a.lerp(b, part.x).lerp(c.lerp(d, part.x), part.y);
        // What is far out has no part of a texel, nor has what is not a number.
        if color.is_finite() { color } else { self.texel(map, corner) }
    }

    #[inline]
    fn texel(&self, map: &TextureMap, place: Vec2) -> Vec4 {
        let IVec2 { x, y } = place.as_ivec2();
        let (x, y) = (map.wrap[0].within(x, self.width), map.wrap[1].within(y, self.height));
        self.fetch(map.space, y * self.width as usize + x)
    }

    #[inline]
    fn fetch(&self, space: ColorSpace, index: usize) -> Vec4 {
        let [texel] = self.fetch_all(space, [index]);
        texel
    }

    /// The texels with these numbers. Grey is red, green and blue alike; without alpha, it is 1.
    #[inline]
    fn fetch_all<const N: usize>(&self, space: ColorSpace, indices: [usize; N]) -> [Vec4; N] {
        match (&self.texels, space) {
            (Texels::U8(texels), ColorSpace::Srgb) => {
                let linear = &*SRGB8;
                self.widen(texels, indices, |code| linear[usize::from(code)], unit8)
            }
            (Texels::U8(texels), ColorSpace::Linear) => self.widen(texels, indices, unit8, unit8),
            (Texels::U16(texels), ColorSpace::Srgb) => {
                self.widen(texels, indices, |code| from_srgb(unit16(code)), unit16)
            }
            (Texels::U16(texels), ColorSpace::Linear) => self.widen(texels, indices, unit16, unit16),
            (Texels::F32(texels), _) => self.widen(texels, indices, |number| number, |number| number),
        }
    }

    #[inline(always)]
    fn widen<T: Copy, const N: usize>(
        &self,
        texels: &[T],
        indices: [usize; N],
        color: impl Fn(T) -> f32,
        alpha: impl Fn(T) -> f32,
    ) -> [Vec4; N] {
        // A loop, as `map` is not always inlined.
        let mut found = [Vec4::ONE; N];
        for (found, index) in found.iter_mut().zip(indices) {
            let first = index * self.channels;
            *found = match texels[first..first + self.channels] {
                [grey] => Vec4::new(color(grey), color(grey), color(grey), 1.0),
                [grey, a] => Vec4::new(color(grey), color(grey), color(grey), alpha(a)),
                [r, g, b] => Vec4::new(color(r), color(g), color(b), 1.0),
                [r, g, b, a] => Vec4::new(color(r), color(g), color(b), alpha(a)),
                _ => Vec4::ONE,
            };
        }
        found
    }
}

impl Texels {
    fn len(&self) -> usize {
        match self {
            Self::U8(texels) => texels.len(),
            Self::U16(texels) => texels.len(),
            Self::F32(texels) => texels.len(),
        }
    }
}

#[inline]
fn unit8(code: u8) -> f32 {
    f32::from(code) / 255.0
}

fn unit16(code: u16) -> f32 {
    f32::from(code) / 65535.0
}

/// [`from_srgb`] of all 8-bit codes.
static SRGB8: LazyLock<[f32; 256]> = LazyLock::new(|| core::array::from_fn(|code| srgb_to_linear(code as f64 / 255.0)));

fn from_srgb(signal: f32) -> f32 {
    srgb_to_linear(signal.into())
}

/// The transfer function of sRGB (IEC 61966-2-1), from signals to linear light.
fn srgb_to_linear(signal: f64) -> f32 {
    let light = if signal <= 0.04045 { signal / 12.92 } else { ((signal + 0.055) / 1.055).powf(2.4) };
    light as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(wrap: Wrap, filter: TextureFilter) -> TextureMap {
        TextureMap { wrap: [wrap; 2], filter, ..TextureMap::default() }
    }

    /// Three texels in a row, whose alphas are 0, 0.2 and 1, and whose colours are black, 188 and white.
    fn row() -> Texture {
        Texture::new(3, 1, vec![[0, 0, 0, 0], [188, 188, 188, 51], [255; 4]])
    }

    #[test]
    fn colours_are_linear() {
        // The inverse of the published codes for 0.5 and 0.18.
        let texel = Texture::new(1, 1, vec![[188, 118, 255, 0]]).mean();
        assert!((texel - Vec4::new(0.5, 0.18, 1.0, 0.0)).abs().max_element() < 0.003);
        let mean = row().mean();
        assert!((mean - Vec4::new(0.5, 0.5, 0.5, 0.4)).abs().max_element() < 0.002, "{mean}");
        let raw = row().mean_in(ColorSpace::Linear);
        assert!((raw - Vec4::new(0.5791, 0.5791, 0.5791, 0.4)).abs().max_element() < 1e-4, "{raw}");
    }

    #[test]
    fn sixteen_bits_and_floats_say_what_eight_bits_say() {
        let codes = [0u8, 51, 102, 255, 7, 200];
        let eight = Texture::from_texels(2, 1, 3, Texels::U8(codes.into()));
        let sixteen = Texture::from_texels(2, 1, 3, Texels::U16(codes.map(|code| 257 * u16::from(code)).into()));
        let float = Texture::from_texels(2, 1, 3, Texels::F32(codes.map(unit8).into()));
        assert_eq!([eight.bits(), sixteen.bits(), float.bits()], [8, 16, 32]);
        assert_eq!([eight.bytes(), sixteen.bytes(), float.bytes()], [6, 12, 24]);
        for space in [ColorSpace::Srgb, ColorSpace::Linear] {
            for index in 0..2 {
                let difference = eight.fetch(space, index) - sixteen.fetch(space, index);
                assert!(difference.abs().max_element() < 1e-6, "{space:?}");
            }
            // Floats are linear whatever the map says.
            assert_eq!(float.fetch(space, 1), eight.fetch(ColorSpace::Linear, 1));
        }
    }

    #[test]
    fn grey_is_every_colour_and_what_has_no_alpha_is_opaque() {
        let grey = Texture::from_texels(1, 1, 1, Texels::U8(vec![51]));
        assert_eq!(grey.mean_in(ColorSpace::Linear), Vec4::new(0.2, 0.2, 0.2, 1.0));
        let with_alpha = Texture::from_texels(1, 1, 2, Texels::U8(vec![51, 102]));
        assert_eq!(with_alpha.mean_in(ColorSpace::Linear), Vec4::new(0.2, 0.2, 0.2, 0.4));
    }

    #[test]
    fn texels_are_mixed_between_their_centres() {
        let alpha = |filter, u: f32| row().sample(&map(Wrap::Repeat, filter), Vec2::new(u / 3.0, 0.3)).w;
        let near = |found: f32, expected: f32| assert!((found - expected).abs() < 1e-5, "{found}, not {expected}");
        for (u, expected) in [(0.5, 0.0), (1.5, 0.2), (1.0, 0.1), (2.0, 0.6), (2.25, 0.8), (3.0, 0.5), (0.0, 0.5)] {
            near(alpha(TextureFilter::Bilinear, u), expected);
        }
        for (u, expected) in [(0.9, 0.0), (1.1, 0.2), (2.9, 1.0), (3.1, 0.0)] {
            near(alpha(TextureFilter::Nearest, u), expected);
        }
    }

    #[test]
    fn no_coordinate_is_too_far_out() {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for filter in [TextureFilter::Bilinear, TextureFilter::Nearest] {
                for u in [f32::MAX, f32::MIN, f32::NAN, f32::INFINITY, 1e9, -1e9] {
                    let color = row().sample(&map(wrap, filter), Vec2::new(u, u));
                    assert!(color.is_finite() && color.min_element() >= 0.0 && color.max_element() <= 1.0);
                }
            }
        }
    }
}
